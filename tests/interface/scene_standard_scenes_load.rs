//! The scenes under `scenes/` are right, and mean what their comments say.

use std::path::Path;

use goldtof::code::Generator;
use goldtof::scene::{CounterTiming, EstimatorKind, FpgaTarget, Scene, SourceIndex, load};

fn standard(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.toml"));
    load(&path).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn every_scene_of_the_folder_loads_under_its_own_name() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| load(&entry.unwrap().path()).unwrap_or_else(|error| panic!("{error}")).name)
        .collect();
    names.sort();
    assert_eq!(
        names,
        [
            "dual-view",
            "histogram",
            "image",
            "image-glass",
            "image-two-sensors",
            "macropixel",
            "moving",
            "multipath",
            "paper-interleaved",
            "paper-single",
            "paper-square",
            "quick"
        ]
    );
}

#[test]
fn paper_single_has_the_parameters_of_table_i() {
    let scene = standard("paper-single");
    assert_eq!(scene.chip_period_ps, 8000.0);
    assert_eq!(scene.samples_per_chip, 8);

    let [source] = scene.sources.as_slice() else {
        panic!("one source");
    };
    assert_eq!(source.code.len(), 2047);
    assert!(matches!(source.code.generator, Generator::Gold { .. }));
    assert_eq!(source.wavelength_nm, 783.0);
    assert_eq!(source.mean_power_w, 4e-12);
    assert_eq!(source.extinction_ratio, 10.0);

    let [spad] = scene.detectors.as_slice() else {
        panic!("one detector");
    };
    assert_eq!(spad.reference, SourceIndex(0));
    assert_eq!(spad.photon_detection_probability, 0.31);
    assert_eq!(spad.dark_count_rate_cps, 71e3);
    assert_eq!(spad.background_rate_cps, 0.0);
    assert_eq!(spad.dead_time_ps, 14e3);
    assert_eq!(spad.afterpulsing_probability, 0.137);
    assert_eq!(spad.afterpulsing_time_constant_ps, 5e3);
    assert_eq!(spad.pulse_width_ps, 7e3);
    assert_eq!(spad.delay_ps, 1750.0);
    assert_eq!(spad.jitter_ps, [53.5, 4.0]);
    let counter =
        CounterTiming { rising_delay_ps: 340.0, falling_delay_ps: 390.0, transition_ps: 1.5 };
    assert_eq!(spad.counter, counter);

    let [path] = scene.paths.as_slice() else {
        panic!("one path");
    };
    assert!((path.distance_m() - 3.2).abs() < 1e-12);
    // 6.4 m at 299,792,458 m/s.
    assert!((path.delay_ps - 21_348.102_092_681_73).abs() < 1e-9, "{}", path.delay_ps);
    assert_eq!(path.transmission, 1.0);

    assert_eq!((scene.scan.first_step, scene.scan.steps), (0, 16_376));
    assert!(scene.scan.is_full());
    assert_eq!(scene.scan.integration_chips, 13_100);
    assert_eq!(scene.scan.requested_integration_ps, 104.8e6);
    assert_eq!(scene.estimator, EstimatorKind::Fft);
    assert_eq!(scene.hardware.target, FpgaTarget::Ecp525k6);
    assert_eq!(scene.hardware.parallel, 1);
    assert_eq!(scene.hardware.counter_width, None);
}

#[test]
fn the_other_scenes_differ_from_paper_single_in_what_their_names_say() {
    assert_eq!(standard("paper-square").sources[0].code.chips, [1, 0]);
    assert_eq!(standard("paper-square").scan.steps, 16);

    let interleaved = standard("paper-interleaved");
    assert_eq!(interleaved.sources[0].code.len(), 2 * 2047);
    assert!(interleaved.sources[0].code.is_balanced());

    let dual = standard("dual-view");
    assert_eq!(dual.sources.len(), 2);
    assert_eq!(dual.detectors.len(), 1);
    assert_ne!(dual.sources[0].code.chips, dual.sources[1].code.chips);
    assert_eq!(dual.sources[0].mean_power_w, dual.sources[1].mean_power_w);

    let multipath = standard("multipath");
    let apart = multipath.paths[1].delay_ps - multipath.paths[0].delay_ps;
    assert!((apart / multipath.chip_period_ps - 1.5).abs() < 0.01, "{apart} ps");

    let quick = standard("quick");
    assert_eq!(quick.scan.steps, 248);
    assert_eq!(quick.scan.integration_chips, 2500);
    assert_eq!(quick.detectors[0].pulse_width_ps, 7e3);
}
