//! The emitted testbench and FuseSoC core, as a team without goldtof runs them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::hdl_support::{Family, PLAIN_MAKE, code, run, scene};
use goldtof::deliver::{emit, write};
use goldtof::sensor::Sensor;

/// A window scan of two sources that saturates: every port and every part.
fn emitted(folder: &Path) {
    let codes = [code(Family::Gold(5), 1, 3), code(Family::MSequence(7), 0, 5)];
    let mut scene = scene(&codes, 0, 8, 5, Some(6), 40, Some(4));
    scene.name = "with a window".into();
    let emission =
        emit(&Sensor::new(&scene), "goldtof emit window.toml").expect("the scene is fine");
    write(&emission, folder).expect("the files can be written");
}

fn fusesoc(folder: &Path, target: &str) -> Output {
    // Beside the target's temporary folder, where scripts/python-tools puts it.
    let program = concat!(env!("CARGO_TARGET_TMPDIR"), "/../python/bin/fusesoc");
    Command::new(program)
        .args(["--cores-root", ".", "run", "--build-root", "build", "--target", target])
        .arg("goldtof:sensor:with_a_window")
        .current_dir(folder)
        // Its own settings and caches stay in the folder as well.
        .env("HOME", folder)
        .env("XDG_CONFIG_HOME", folder)
        .env("XDG_CACHE_HOME", folder)
        .env("XDG_DATA_HOME", folder)
        .env("MAKEFLAGS", PLAIN_MAKE)
        .output()
        .unwrap_or_else(|error| panic!("scripts/python-tools installs fusesoc: {error}"))
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn the_core_lints_and_simulates_and_fails_on_a_fault() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    emitted(folder.path());
    let lint = fusesoc(folder.path(), "lint");
    assert!(lint.status.success(), "{}", said(&lint));
    for target in ["sim", "sim_verilator"] {
        let sound = fusesoc(folder.path(), target);
        assert!(sound.status.success(), "{target}: {}", said(&sound));
        assert!(said(&sound).contains("PASS"), "{target}");
    }
    let path = folder.path().join("sensor_top.v");
    let top = fs::read_to_string(&path).expect("the top is there");
    let faulty = top.replace("o_laser <= chips", "o_laser <= ~chips");
    assert_ne!(faulty, top);
    fs::write(&path, faulty).expect("the top can be written");
    for target in ["sim", "sim_verilator"] {
        let faulty = fusesoc(folder.path(), target);
        assert!(!faulty.status.success(), "{target}: {}", said(&faulty));
        assert!(said(&faulty).contains("FAIL clock "), "{target}");
        assert!(said(&faulty).contains("o_laser expected "), "{target}");
    }
}

#[test]
fn a_missing_vector_file_fails_in_both_simulators() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    emitted(folder);
    let top = "sensor_top_tb";
    let arguments = ["-g2005", "-s", top, "-o", "tb.vvp", "-f", "sensor_top_tb.f"];
    run(folder, "iverilog", &arguments);
    let arguments = ["--binary", "-Wall", "--top-module", top, "-f", "sensor_top_tb.f"];
    run(folder, "verilator", &arguments);
    for missing in ["inputs", "chips", "results", "skips"] {
        let (name, away) = (format!("{top}_{missing}.hex"), folder.join("away.hex"));
        fs::rename(folder.join(&name), &away).expect("it was there");
        for (program, arguments) in [("vvp", &["tb.vvp"][..]), ("./obj_dir/Vsensor_top_tb", &[])] {
            let output = Command::new(program)
                .args(arguments)
                .current_dir(folder)
                .output()
                .expect("the simulation starts");
            assert!(!output.status.success(), "{program} without {name}");
            assert!(!said(&output).contains("PASS"), "{program} without {name}");
        }
        fs::rename(&away, folder.join(&name)).expect("it goes back");
    }
    assert!(run(folder, "vvp", &["tb.vvp"]).contains("PASS"));
    assert!(run(folder, "./obj_dir/Vsensor_top_tb", &[]).contains("PASS"));
}
