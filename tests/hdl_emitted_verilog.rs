mod hdl_support;
use hdl_support::*;

#[test]
fn show() {
    let codes = [code(Family::Gold(5), 1, 3)];
    let scene = scene(&codes, 0, 8, 3, Some(20), 40, Some(5));
    let emission = goldtof::hdl::emit(&scene, "goldtof emit test.toml --out build").unwrap();
    let dir = std::path::Path::new("/tmp/hdlshow");
    goldtof::hdl::write(&emission, dir).unwrap();
}
