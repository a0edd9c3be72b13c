//! Detectors that are read out by rows: the counts of the reference model at every clock, whatever
//! the windows of a step, and what such hardware has not.

use std::path::Path;

use goldtof::cosim::engine::Engine;
use goldtof::cosim::source::{Verilog, sources_of};
use goldtof::cosim::{CosimOptions, StimulusKind, TOP, Verdict, cosimulate};
use goldtof::scene::{Scene, load_with};
use goldtof::sensor::Sensor;

use crate::hdl_support::models;

fn scene(settings: &[&str]) -> Result<Scene, String> {
    let settings: Vec<_> = settings.iter().map(|text| text.parse().expect("a setting")).collect();
    load_with(Path::new("tests/scenes/rows.toml"), &settings).map_err(|errors| errors.to_string())
}

/// One window a step, two, and many; one sample a chip, and so many hits that counters wrap.
#[test]
fn every_window_is_counted() {
    for settings in [
        &["clock.samples_per_chip=1", "scan.steps=all", "scan.integration=72 ns"][..],
        &["clock.samples_per_chip=16", "scan.integration=128 ns", "hardware.polarity=low"],
        &["clock.samples_per_chip=8", "scan.integration=20 us", "hardware.target=ice40-hx8k"],
    ] {
        let sensor = Sensor::new(&scene(settings).expect("it is sound"));
        let emission = goldtof::deliver::emit(&sensor, "goldtof emit rows.toml").expect("it is");
        let options = CosimOptions {
            stimulus: StimulusKind::Adversarial,
            engine: Engine::Lockstep,
            ..Default::default()
        };
        let verilog = Verilog {
            top: TOP.to_owned(),
            sources: sources_of(&emission.files),
            registers: None,
            cache: models(),
        };
        let report = cosimulate(&sensor, &verilog, &options, |_, _| ()).expect("it runs").report;
        assert_eq!(report.verdict, Verdict::Match, "{settings:?}");
        let coverage = report.coverage;
        assert_eq!(coverage.covered, coverage.points, "{settings:?}");
    }
}

#[test]
fn what_rows_cannot_have_is_refused() {
    for (setting, said) in [
        ("hardware.parallel=2", "one phase step at a time; leave out parallel"),
        ("hardware.total_counts=true", "signed counts alone, without totals"),
        ("estimate.estimator=model", "signed counts alone, without totals"),
        ("hardware.peak_detector=true", "leave out peak_detector"),
        ("hardware.counter_width=6", "exact counts; leave out counter_width"),
        ("hardware.registers=axi4-lite", "steps of a length that is built in"),
        ("hardware.accumulate=2", "scans that are sent as they are; leave out accumulate"),
        ("scan.integration=56 ns", "phase steps of at least 8 chips, and these have 7"),
    ] {
        let error = scene(&[setting]).expect_err(setting);
        assert!(error.contains(said), "{setting}: {error}");
        assert!(error.contains("hardware.readout"), "{setting}: {error}");
    }
}
