//! The plan says of every part whether the scene needs it, and why.

use std::path::Path;

use goldtof::cli::plan::to_text;
use goldtof::plan::plan;
use goldtof::scene::{Scene, load, parse};

fn standard(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(format!("{name}.toml"));
    load(&path).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn show() {
    println!("{}", to_text(&plan(&standard("paper-single"))));
    println!("{}", to_text(&plan(&standard("dual-view"))));
    let _ = parse("x", "");
}
