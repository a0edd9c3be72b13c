//! The plan says of every part whether the scene needs it, and why.

use std::path::Path;
use std::sync::Arc;

use goldtof::code::{CodeSpec, Family};
use goldtof::plan::overview::{Overview, overview, with_cells};
use goldtof::plan::resources::{Basis, resources};
use goldtof::plan::{Part, plan};
use goldtof::report::plan::{parts, text};
use goldtof::scene::{
    CellOutputs, Combination, EstimatorKind, Fluctuation, FpgaTarget, Movement, Scene, load,
};
use goldtof::sensor::Sensor;

fn standard(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.toml"));
    load(&path).unwrap_or_else(|error| panic!("{error}"))
}

/// The part `name` of the hardware or of the simulation.
fn part(scene: &Scene, name: &str) -> Part {
    let plan = plan(&Sensor::new(scene));
    let mut parts = plan.hardware.into_iter().chain(plan.simulation);
    parts.find(|part| part.part == name).unwrap_or_else(|| panic!("no part {name}"))
}

#[test]
fn the_plan_of_paper_single() {
    let sensor = Sensor::new(&standard("paper-single"));
    insta::assert_snapshot!(
        parts(&with_cells(plan(&sensor), &sensor), None),
        @r#"
    Hardware, kept
      code_generator     an LFSR of degree 11 makes the first m-sequence
      second_lfsr        a Gold code is the XOR of two m-sequences
      phase_stepper      delays the reference by 8 phase steps per chip
      lane_choice        delays the reference by parts of a chip, one of 8 samples at a time
      edge_detector      finds rising edges in 8 samples per clock of 1 detector
      updown_correlator  17 bits hold any count of 13100 chips with at most 4 edges each
      scan_controller    walks 16376 phase steps of 13100 chips each
      result_stream      counts leave as an AXI4-Stream of 24 bits

    Hardware, left out
      interleaver           about 4 LUTs, 2 flip-flops    the code is not interleaved (nu = 0)
      parallel_correlators  about 76 LUTs, 81 flip-flops  parallel = 1: phase steps are correlated one after another
      count_segments        about 8 LUTs, 20 flip-flops   one carry chain holds 17 bits at full clock; saves pipeline stages
      saturation                                          no stimulus can overflow 17 bits; saves a pipeline stage and a port
      total_counts          about 36 LUTs, 59 flip-flops  the estimator "fft" uses the signed counts alone
      registers                                           the scan and the codes are those of the scene
      scan_realignment                                    a scan of all 16376 phase steps ends where it began
      peak_detector         about 32 LUTs, 74 flip-flops  the host receives all 16376 counts and finds their maximum

    Simulation, kept
      modulated_light   mean power 4 pW, keyed by a code of 992 on-chips in 2047
      off_state_light   extinction_ratio = 10: background of 1/10 of the on-rate
      photon_detection  photon_detection_probability = 0.31: scales the rates, no photon is drawn in vain
      dark_counts       dark_count_rate = 71 kcps, as background
      dead_time         blind for 14 ns after an avalanche
      afterpulsing      probability 0.137, decaying with 5 ns
      delay             detections are registered 1.75 ns late; the calibration offset removes it
      jitter            2 Gaussian parts of 53.6 ps together
      pulse_sampling    pulses of 7 ns are sampled every 1 ns; those that merge count once
      full_scan         the scan covers all 16376 phase steps
      coarse_estimate   the maximum over the scan
      fine_estimate     phase of the fundamental over 16 phase steps

    Simulation, left out
      moving_paths         every path keeps its delay
      interference         no light of any other source reaches the detector
      multipath            one path leads from the reference's source to the detector
      background           background_rate = 0
      counter_edge_delays  sampled hardware applies the sign to samples and has no such edges; only the tier in continuous time (events) uses them
      model_fit            estimator = "fft"
    "#
    );
}

#[test]
fn the_plan_in_json_has_part_kept_and_reason() {
    let json = serde_json::to_value(plan(&Sensor::new(&standard("paper-square")))).unwrap();
    let second_lfsr = &json["hardware"][1];
    assert_eq!(second_lfsr["part"], "second_lfsr");
    assert_eq!(second_lfsr["kept"], false);
    assert_eq!(second_lfsr["reason"], "a square wave needs no LFSR");
    assert!(json["simulation"].as_array().is_some_and(|parts| !parts.is_empty()));
}

#[test]
fn interleaving_interference_and_multipath_are_kept_where_the_scene_has_them() {
    for (scene, name) in [
        ("paper-interleaved", "interleaver"),
        ("dual-view", "interference"),
        ("multipath", "multipath"),
    ] {
        assert!(part(&standard(scene), name).kept, "{scene}");
        assert!(!part(&standard("paper-single"), name).kept, "{name}");
    }
}

#[test]
fn a_window_scan_realigns_and_names_what_it_saves() {
    let mut scene = standard("paper-single");
    scene.scan.first_step = 5;
    scene.scan.steps = 33;
    assert!(part(&scene, "scan_realignment").kept);
    let full_scan = part(&scene, "full_scan");
    assert!(!full_scan.kept);
    // 1 - 33/16376
    assert_eq!(full_scan.reason, "the scan asks for 33 of 16376 phase steps, from step 5 on");
    let saving = full_scan.saving.expect("it saves time");
    assert!((saving.time_fraction - (1.0 - 33.0 / 16_376.0)).abs() < 1e-12);
}

#[test]
fn a_narrow_counter_is_clamped() {
    let mut scene = standard("paper-single");
    scene.hardware.counter_width = Some(12);
    assert!(part(&scene, "saturation").kept);
    // 13,100 chips with 4 edges each are 52,400 counts: 16 bits and a sign.
    scene.hardware.counter_width = Some(17);
    assert!(!part(&scene, "saturation").kept);
}

#[test]
fn total_counts_follow_the_estimator_unless_the_scene_says_otherwise() {
    let mut scene = standard("paper-single");
    scene.estimator = EstimatorKind::Model;
    // Up to 52,400 hits are 16 bits without a sign, above 17 in three bytes.
    let totals = part(&scene, "total_counts");
    assert!(totals.kept);
    assert_eq!(
        totals.reason,
        "the estimator \"model\" fits them too: the hits of each phase step in 16 bits, above \
         its signed count"
    );
    let stream = part(&scene, "result_stream").reason;
    assert_eq!(stream, "counts leave as an AXI4-Stream of 40 bits");
    scene.estimator = EstimatorKind::Fft;
    scene.hardware.total_counts = Some(true);
    assert!(part(&scene, "total_counts").kept);
    scene.hardware.total_counts = Some(false);
    let totals = part(&scene, "total_counts");
    assert!(!totals.kept && totals.reason.contains("total_counts = false"));
}

#[test]
fn neutral_parameters_leave_their_parts_out() {
    let names = [
        "off_state_light",
        "photon_detection",
        "dark_counts",
        "dead_time",
        "afterpulsing",
        "delay",
        "jitter",
    ];
    let mut scene = standard("paper-single");
    for name in names {
        assert!(part(&scene, name).kept, "{name}");
    }
    scene.sources[0].extinction_ratio = f64::INFINITY;
    let detector = &mut scene.detectors[0];
    detector.photon_detection_probability = 1.0;
    detector.dark_count_rate_cps = 0.0;
    detector.dead_time_ps = 0.0;
    detector.afterpulsing_probability = 0.0;
    detector.delay_ps = 0.0;
    detector.jitter_ps.clear();
    for name in names {
        assert!(!part(&scene, name).kept, "{name}");
    }
}

#[test]
fn a_dark_path_leaves_out_the_light_of_its_source() {
    let mut scene = standard("dual-view");
    scene.paths[1].transmission = 0.0;
    assert!(!part(&scene, "interference").kept);
    assert!(!part(&scene, "modulated_light (other)").kept);
    assert!(part(&scene, "modulated_light (laser)").kept);
}

#[test]
fn sources_of_one_code_share_a_generator() {
    let mut scene = standard("dual-view");
    scene.sources[1].code = scene.sources[0].code.clone();
    assert!(!part(&scene, "code_generator (other)").kept);
}

#[test]
fn a_path_that_moves_is_followed_and_one_of_no_speed_is_not() {
    let mut scene = standard("paper-single");
    let moving = |velocity_m_per_s, std_m| {
        Some(Movement {
            velocity_m_per_s,
            fluctuation: Some(Fluctuation { std_m, correlation_time_ps: 1e9 }),
        })
    };
    scene.paths[0].movement = moving(1.5, 2e-3);
    let kept = part(&scene, "moving_paths");
    assert!(kept.kept);
    assert_eq!(
        kept.reason,
        "path 0 moves at 1.5 m/s and by 2 mm at random with a correlation time of 1000 us"
    );
    // It turns every chip of 8 ns; of 4 pW a photon is detected every 200 ns.
    scene.paths[0].movement = Some(Movement {
        velocity_m_per_s: 0.0,
        fluctuation: Some(Fluctuation { std_m: 2e-3, correlation_time_ps: 1e6 }),
    });
    let kept = part(&scene, "moving_paths");
    assert!(kept.reason.contains("; photon by photon: path 0 of the scene moves anew"), "{kept:?}");
    scene.paths[0].movement = moving(0.0, 0.0);
    assert!(!part(&scene, "moving_paths").kept);
}

#[test]
fn a_sensor_that_was_synthesized_has_its_measured_cells() {
    let mut scene = standard("paper-single");
    // First row of docs/resources.md.
    let base = resources(&Sensor::new(&scene)).expect("it was measured");
    assert_eq!((base.cells.luts, base.cells.flip_flops), (101, 212));
    assert_eq!(base.basis, Basis::Measured);
    // Its row "total_counts".
    scene.hardware.total_counts = Some(true);
    let totals = resources(&Sensor::new(&scene)).expect("it was measured");
    assert_eq!((totals.cells.luts, totals.cells.flip_flops), (133, 278));
    // No row has both; the fit says so, and is near what the two rows add up to.
    scene.hardware.peak_detector = true;
    let both = resources(&Sensor::new(&scene)).expect("it can be fitted");
    assert!(matches!(both.basis, Basis::Fitted { .. }));
    let sum = 278.0 + 299.0 - 212.0;
    assert!((both.cells.flip_flops as f64 / sum - 1.0).abs() < 0.1, "{both:?}");
    // Its row "K = 16 cells, adder", whose counts are wider; of 8 cells there is none, and the fit is between those of 4 and 16.
    let mut scene = standard("paper-single");
    let detector = &mut scene.detectors[0];
    (detector.cells, detector.cell_outputs) = (16, CellOutputs::Separate);
    detector.combination = Combination::Adder;
    let adder = resources(&Sensor::new(&scene)).expect("it was measured");
    assert_eq!((adder.cells.luts, adder.basis), (475, Basis::Measured));
    scene.detectors[0].cells = 8;
    let fewer = resources(&Sensor::new(&scene)).expect("it can be fitted");
    assert!((220..360).contains(&fewer.cells.luts), "{fewer:?}");
}

#[test]
fn a_histogram_has_its_memories_and_cells() {
    // First row of the second table of docs/resources.md.
    let mut scene = standard("histogram");
    let two = resources(&Sensor::new(&scene)).expect("it was measured");
    assert_eq!((two.cells.luts, two.cells.flip_flops), (195, 304));
    assert_eq!((two.block_rams, two.basis), (16, Basis::Measured));
    // Seven code periods are not two, and no row has bins of two bits.
    scene.hardware.buffers = 1;
    scene.scan.integration_chips = 3 * 2047;
    let narrow = resources(&Sensor::new(&scene)).expect("it can be fitted");
    assert!(matches!(narrow.basis, Basis::Fitted { .. }));
    assert_eq!(narrow.block_rams, 8);
    assert!(narrow.cells.luts < 120, "{narrow:?}");
    // So it is for another family; but not of so long a code, and the plan says so.
    scene.hardware.target = FpgaTarget::Ice40Hx8k;
    let narrow = resources(&Sensor::new(&scene)).expect("it can be fitted");
    assert!(matches!(narrow.basis, Basis::Fitted { .. }));
    let mut code = CodeSpec::new(Family::Gold);
    code.degree = Some(13);
    scene.sources[0].code = Arc::new(code.build().expect("a preferred pair"));
    scene.scan.integration_chips = 3 * 8191;
    scene.samples_per_chip = 4;
    (scene.scan.steps, scene.scan.steps_per_period) = (4 * 8191, 4 * 8191);
    let overview = overview(&Sensor::new(&scene));
    assert!(overview.resources.is_none());
    assert!(text(&overview, None).contains("31 to 2,047 for an iCE40"));
}

#[test]
fn what_people_read_of_a_plan_has_the_numbers_of_its_json() {
    let overview = overview(&Sensor::new(&standard("quick")));
    let json = serde_json::to_value(&overview).unwrap();
    let text = text(&overview, None);
    // 31 chips of 8 ns, 8 steps each, 2500 chips a step.
    assert_eq!(json["figures"]["phase_steps"], 248);
    assert!((json["figures"]["frame_time_s"].as_f64().unwrap() - 248.0 * 20e-6).abs() < 1e-12);
    for words in ["4.96 ms: 248 phase steps of 20 \u{b5}s", "125 MHz", "37.17 m"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    for expected in json["expected"].as_array().unwrap() {
        let bias_mm = expected["expected_bias_m"].as_f64().unwrap() * 1e3;
        let std_mm = expected["expected_std_m"].as_f64().unwrap() * 1e3;
        // -0.00 is nothing.
        let bias_mm = if bias_mm.abs() < 0.005 { 0.0 } else { bias_mm };
        let words = format!("bias {bias_mm:+.2} mm, scatter {std_mm:.2} mm");
        assert!(text.contains(&words), "{words}: {text}");
    }
    let luts = &json["resources"]["luts"];
    assert!(text.contains(&format!("about {luts} (LUT4")), "{luts}: {text}");
}

/// Four scans added up are expected to err as one whose steps are four times as long.
#[test]
fn a_plan_expects_what_a_host_gets() {
    let overview_of = |accumulate: u32, steps_are_longer: u64| {
        let mut scene = standard("quick");
        scene.hardware.accumulate = accumulate;
        scene.scan.integration_chips = 81 * 31 * steps_are_longer;
        overview(&Sensor::new(&scene))
    };
    let [one, four, long] = [(1, 1), (4, 1), (1, 4)].map(|(m, n)| overview_of(m, n));
    assert_eq!(four.expected, long.expected);
    let std_m = |of: &Overview| of.expected[0].expected_std_m.expect("quick is within theory");
    assert!((1.9..2.1).contains(&(std_m(&one) / std_m(&four))), "{:?}", four.expected);
    assert!(text(&four, None).contains(", sum of 4 scans"));
    assert_eq!(four.figures.frame_time_s, one.figures.frame_time_s);
}

#[test]
fn a_saving_that_was_measured_over_nothing_is_not_told() {
    let mut scene = standard("quick");
    for source in &mut scene.sources {
        source.mean_power_w = 0.0;
    }
    for detector in &mut scene.detectors {
        detector.dark_count_rate_cps = 0.0;
    }
    let overview = overview(&Sensor::new(&scene));
    assert!(overview.plan.not_measured > 0);
    let measured = overview.plan.simulation.iter().filter_map(|part| part.saving.as_ref());
    for saving in measured {
        assert!(!saving.basis.contains(" 0 detections"), "{saving:?}");
    }
    assert!(text(&overview, None).contains("was not measured"));
}

#[test]
fn a_plan_fits_the_terminal() {
    let overview = overview(&Sensor::new(&standard("quick")));
    let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let wide = text(&overview, None);
    let narrow = text(&overview, Some(70));
    assert!(narrow.lines().all(|line| line.chars().count() <= 80), "{narrow}");
    assert!(narrow.lines().count() > wide.lines().count());
    assert_eq!(words(&wide).len(), words(&narrow).len());
}
