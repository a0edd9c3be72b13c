//! The emitted text itself, for a reader's eye.

use crate::hdl_support::{Family, code, scene};
use goldtof::deliver::{Emission, emit, write};
use goldtof::sensor::Sensor;

const COMMAND: &str = "goldtof emit scenes/test.toml --out build";

fn window_scan(family: Family, interleave: u32, counter_width: Option<u32>) -> Emission {
    let codes = [code(family, interleave, 3)];
    let scene = scene(&codes, 0, 4, 5, Some(6), 40, counter_width);
    emit(&Sensor::new(&scene), COMMAND).expect("the scene is fine")
}

fn text<'a>(emission: &'a Emission, name: &str) -> &'a str {
    let file = emission.files.iter().find(|f| f.name == name);
    &file.unwrap_or_else(|| panic!("{name} is emitted")).text
}

#[test]
fn a_full_scan_reads_as_expected() {
    let codes = [code(Family::Gold(11), 0, 3)];
    let scene = scene(&codes, 0, 8, 0, None, 13_100, None);
    let emission = emit(&Sensor::new(&scene), COMMAND).expect("the scene is fine");
    for name in [
        "gold_generator",
        "phase_stepper",
        "edge_detector",
        "scan_controller",
        "updown_correlator",
        "result_stream",
        "sensor_top",
    ] {
        insta::assert_snapshot!(format!("full_{name}"), text(&emission, &format!("{name}.v")));
    }
}

#[test]
fn a_window_scan_of_an_interleaved_code_hands_its_parameters_down() {
    let emission = window_scan(Family::Gold(5), 2, Some(4));
    for name in [
        "gold_generator",
        "interleaver",
        "phase_stepper",
        "scan_controller",
        "result_stream",
        "sensor_top",
    ] {
        insta::assert_snapshot!(format!("window_{name}"), text(&emission, &format!("{name}.v")));
    }
}

#[test]
fn the_other_generators_read_as_expected() {
    for (family, name) in [
        (Family::MSequence(4), "m_sequence_generator"),
        (Family::Square, "square_generator"),
        (Family::Chips(70), "chip_table_generator"),
    ] {
        let emission = window_scan(family, 0, None);
        insta::assert_snapshot!(name, text(&emission, &format!("{name}.v")));
    }
}

#[test]
fn sources_with_one_code_share_a_generator_and_other_polynomials_get_a_module() {
    let shared = code(Family::Gold(5), 0, 3);
    let codes = [shared.clone(), code(Family::Gold(6), 0, 3), shared, code(Family::Gold(5), 0, 4)];
    let scene = scene(&codes, 1, 2, 0, None, 40, None);
    let emission = emit(&Sensor::new(&scene), COMMAND).expect("the scene is fine");
    insta::assert_snapshot!("four_sources_sensor_top", text(&emission, "sensor_top.v"));
}

#[test]
fn the_manifest_names_what_was_emitted_and_what_was_left_out() {
    let emission = window_scan(Family::Gold(5), 0, None);
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(&emission, folder.path()).expect("the files can be written");
    let manifest = std::fs::read_to_string(folder.path().join("manifest.json")).expect("written");
    insta::assert_snapshot!("manifest", manifest);
}
