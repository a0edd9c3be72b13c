//! Every malformed scene is refused with where, what, and what would be right.

use goldtof::scene::{SceneErrors, load, parse};

mod by_table;
mod codes;
mod large;
mod movement;
mod quantities;
mod structure;

/// A right scene, from which each test departs in one place.
const SCENE: &str = r#"[clock]
chip_period = "8 ns"
samples_per_chip = 8

[[source]]
name = "laser"
code = { family = "gold", degree = 5 }
wavelength = "783 nm"
mean_power = "20 pW"

[[detector]]
name = "spad"
reference = "laser"
dead_time = "14 ns"

[[path]]
source = "laser"
detector = "spad"
distance = "3.2 m"

[scan]
integration = "20 us"
"#;

/// What the scene is refused with once `right` is replaced by `wrong`.
fn refusal(right: &str, wrong: &str) -> String {
    assert!(SCENE.contains(right), "the scene has no {right}");
    let scene = SCENE.replacen(right, wrong, 1);
    match parse("scenes/x.toml", &scene) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("accepted:\n{scene}"),
    }
}

#[test]
fn the_scene_itself_is_right() {
    if let Err(error) = parse("scenes/x.toml", SCENE) {
        panic!("{error}");
    }
}

#[test]
fn all_errors_are_reported_together_in_the_order_of_the_file() {
    let scene = SCENE
        .replace("783 nm", "783")
        .replace("dead_time", "dead_tme")
        .replace("[clock]", "[clock]\nchip_perod = 3");
    let Err(SceneErrors::Invalid { errors, .. }) = parse("scenes/x.toml", &scene) else {
        panic!("accepted:\n{scene}");
    };
    let places: Vec<(usize, usize)> = errors.iter().map(|e| (e.line, e.column)).collect();
    assert_eq!(places, [(2, 1), (9, 14), (15, 1)]);
}

#[test]
fn a_wrong_source_causes_no_further_errors_elsewhere() {
    let scene = SCENE.replace("degree = 5", "degree = 8");
    let Err(SceneErrors::Invalid { errors, .. }) = parse("scenes/x.toml", &scene) else {
        panic!("accepted:\n{scene}");
    };
    assert_eq!(errors.len(), 1, "{errors:?}");
}

#[test]
fn columns_count_characters_and_tabs_keep_the_caret_in_place() {
    let scene = SCENE.replace("dead_time", "\tdead_time").replace("14 ns", "14 \u{b5}");
    let Err(SceneErrors::Invalid { errors, .. }) = parse("scenes/x.toml", &scene) else {
        panic!("accepted:\n{scene}");
    };
    assert_eq!((errors[0].column, errors[0].marked), (14, 6));
    assert!(errors[0].to_string().ends_with(&format!("| \t{}^^^^^^", " ".repeat(12))));
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let error = load(std::path::Path::new("scenes/absent.toml")).unwrap_err();
    let text = error.to_string();
    assert!(text.starts_with("scenes/absent.toml: cannot read the scene: "), "{text}");
}
