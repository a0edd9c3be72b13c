//! The header that is checked in is the one that cbindgen makes of the source.
//!
//!     UPDATE_HEADER=1 cargo test -p goldtof-capi --test header_is_current

use std::fs;
use std::path::Path;

#[test]
fn the_header_is_the_sources() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut made = Vec::new();
    let config = cbindgen::Config::from_root_or_default(folder);
    cbindgen::generate_with_config(folder, config).unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let path = folder.join("include/goldtof.h");
    if std::env::var_os("UPDATE_HEADER").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let kept = fs::read_to_string(&path).unwrap_or_default();
    assert!(kept == made, "include/goldtof.h is not current; UPDATE_HEADER=1 renews it");
}
