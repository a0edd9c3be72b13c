//! The score of stimuli whose worth is known.

use std::path::Path;

use super::*;
use crate::deliver;
use crate::scene;

fn sensor() -> Sensor {
    let path = format!("{}/../scenes/quick.toml", env!("CARGO_MANIFEST_DIR"));
    let mut scene = scene::load(Path::new(&path)).unwrap();
    scene.scan.integration_chips = 100;
    scene.scan.steps = 24;
    Sensor::new(&scene)
}

fn emitted(sensor: &Sensor) -> Verilog {
    Verilog::emitted(sensor, &deliver::emit(sensor, "goldtof test").unwrap().files).unwrap()
}

fn options(clocks: u64, mutants: u32) -> GradeOptions {
    let clocks = Some(clocks);
    GradeOptions { clocks, mutants, proof_time_s: 1, proof_budget_s: 4, ..Default::default() }
}

/// The grade by all faults and mutants.
fn whole_grade(sensor: &Sensor, verilog: &Verilog, options: &GradeOptions) -> Grade {
    let graded = grade(sensor, verilog, options, |count| (0..count).collect(), |_| ()).unwrap();
    graded.grade(options)
}

#[test]
fn a_longer_stimulus_catches_more_and_all_are_accounted_for() {
    let sensor = sensor();
    let verilog = emitted(&sensor);
    let mut shares = Vec::new();
    for clocks in [400, 40_000] {
        let grade = whole_grade(&sensor, &verilog, &options(clocks, 60));
        let mutants = grade.mutants.unwrap();
        assert_eq!(mutants.total, 60);
        for score in [&grade.faults, &mutants] {
            let parts = score.caught + score.proven_equivalent + score.survivors.len();
            assert_eq!(parts, score.total);
            assert!(score.last_caught_clock < Some(clocks));
        }
        shares.push((grade.faults.caught_fraction, mutants.caught_fraction));
    }
    assert!(shares[0].0 < 0.9 && shares[0].1 < 0.9, "{shares:?}");
    assert!(shares[1].0 > 0.99 && shares[1].1 > 0.95, "{shares:?}");
}

/// The adversary's host asks for every register; photons have none.
#[test]
fn a_sensor_with_registers_is_graded_with_a_host() {
    let path = format!("{}/../scenes/quick.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap() + "\n[hardware]\nregisters = \"axi4-lite\"\n";
    let sensor = Sensor::new(&scene::parse("quick.toml", &text).unwrap());
    let verilog = emitted(&sensor);
    // Of 2,200 faults every twentieth.
    let some = |count: usize| (0..count).step_by(20).collect();
    let [hostile, photons] = [GradeStimulus::Adversarial, GradeStimulus::Photons].map(|stimulus| {
        let options = GradeOptions { stimulus, clocks: None, ..options(0, 0) };
        let graded = grade(&sensor, &verilog, &options, some, |_| ()).unwrap();
        graded.grade(&options).faults
    });
    assert!(hostile.total > 100 && hostile.caught_fraction > 0.9, "{hostile:?}");
    assert!(photons.caught_fraction < hostile.caught_fraction - 0.1, "{photons:?}");
}

#[test]
fn a_redundant_register_is_proven_equivalent_and_a_port_that_is_stuck_is_not() {
    let sensor = sensor();
    // What the stimulus leaves is little, and is decided far within the bounds.
    let options = GradeOptions { proof_time_s: 20, proof_budget_s: 60, ..options(40_000, 0) };
    let with = |verilog: &Verilog| whole_grade(&sensor, verilog, &options).faults;
    let mut verilog = emitted(&sensor);
    let before = with(&verilog);
    let top = verilog.sources.iter_mut().find(|file| file.name == "sensor_top.v");
    let text = &mut top.unwrap().text;
    // Two registers that never have the same value, and a gate that waits for it.
    let end = text.rfind("endmodule").unwrap();
    text.insert_str(
        end,
        "reg one_a; reg one_b; wire never = one_a & one_b;\n\
         always @(posedge i_clk) begin one_a <= i_samples[0]; one_b <= ~i_samples[0]; end\n",
    );
    let reset = ".i_rst (i_rst)";
    let found = text.find(".i_rst").unwrap_or_else(|| panic!("{reset}"));
    let open = found + text[found..].find('(').unwrap();
    let close = open + text[open..].find(')').unwrap();
    text.replace_range(open..=close, "(i_rst | never)");
    let after = with(&verilog);
    // The gate stuck at 0 cannot be seen; stuck at 1 it is a reset that never ends.
    assert!(after.proven_equivalent > before.proven_equivalent, "{before:?} {after:?}");
    let stuck = |survivor: &&Judged| survivor.net.starts_with("never");
    assert_eq!(after.survivors.iter().filter(stuck).count(), 0, "{after:?}");
}
