//! What DESIGN.md says of release builds is what Cargo is told.

use std::path::Path;

/// A number that wraps must not become an answer.
#[test]
fn release_builds_and_those_of_benchmarks_check_overflow() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let text = std::fs::read_to_string(path).expect("it is there");
    let manifest: toml::Table = text.parse().expect("it is TOML");
    let profiles = manifest["profile"].as_table().expect("they are set");
    for name in ["", "-estimation", "-hardware", "-physics", "-sensor", "-system", "-verification"]
    {
        let package = format!("goldtof{name}");
        let checks = &profiles["release"]["package"][&package]["overflow-checks"];
        assert_eq!(checks.as_bool(), Some(true), "{package}");
    }
    // Benchmarks inherit it.
    assert!(profiles["bench"].get("package").is_none());
}
