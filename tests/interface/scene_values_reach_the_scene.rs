//! Every key of a right scene arrives with its meaning and its default.

use goldtof::scene::{EstimatorKind, Fluctuation, FpgaTarget, Movement, Scan, Scene, parse};
use proptest::prelude::*;

/// Only what a scene cannot do without: L' = 31, S = 8, T_s = 1 ns, K = 248.
const LEAST: &str = r#"
[clock]
chip_period = "8 ns"

[[source]]
name = "laser"
code = { family = "gold", degree = 5 }
wavelength = "783 nm"
mean_power = "20 pW"

[[detector]]
name = "spad"
reference = "laser"

[[path]]
source = "laser"
detector = "spad"
distance = "3.2 m"

[scan]
integration = "20 us"
"#;

fn scene(text: &str) -> Scene {
    parse("folder/some-name.toml", text).unwrap_or_else(|error| panic!("{error}"))
}

/// The scan of the least scene with another line under `[scan]`.
fn scan(line: &str) -> Scan {
    scene(&format!("{LEAST}{line}\n")).scan
}

#[test]
fn what_is_left_out_has_the_documented_default() {
    let scene = scene(LEAST);
    assert_eq!(scene.name, "some-name");
    assert_eq!(scene.samples_per_chip, 8);
    assert_eq!(scene.sources[0].extinction_ratio, f64::INFINITY);
    assert_eq!(scene.sources[0].code.interleave, 0);
    let detector = &scene.detectors[0];
    assert_eq!(detector.photon_detection_probability, 1.0);
    assert_eq!(detector.dark_count_rate_cps, 0.0);
    assert_eq!(detector.background_rate_cps, 0.0);
    assert_eq!(detector.dead_time_ps, 0.0);
    assert_eq!(detector.afterpulsing_probability, 0.0);
    assert_eq!(detector.delay_ps, 0.0);
    assert!(detector.jitter_ps.is_empty());
    assert_eq!(detector.counter.rising_delay_ps, 0.0);
    assert_eq!(scene.paths[0].transmission, 1.0);
    assert_eq!(scene.paths[0].movement, None);
    assert!(scene.scan.is_full());
    assert_eq!(scene.scan.steps_per_period, 248);
    assert_eq!(scene.estimator, EstimatorKind::Fft);
    assert_eq!(scene.hardware.target, FpgaTarget::Ecp525k6);
    assert_eq!(scene.hardware.parallel, 1);
    assert_eq!(scene.hardware.counter_width, None);
    assert!(!scene.hardware.peak_detector);
    assert_eq!(scene.hardware.total_counts, None);
    assert!(!scene.sends_total_counts());
}

#[test]
fn the_pulse_is_half_the_dead_time_long_but_never_shorter_than_a_phase_step() {
    for (dead_time, pulse_width_ps) in [("14 ns", 7000.0), ("1.5 ns", 1000.0), ("0 ns", 1000.0)] {
        let text = LEAST.replace("reference", &format!("dead_time = \"{dead_time}\"\nreference"));
        let width = scene(&text).detectors[0].pulse_width_ps;
        assert_eq!(width, pulse_width_ps, "{dead_time}");
    }
}

/// An output that falls to a half in each ln(2) time constants is at a quarter after two of them.
#[test]
fn a_threshold_and_a_time_constant_are_a_dead_time() {
    const TIME_CONSTANT: &str = "recharge_time_constant = \"10 ns\"";
    const THRESHOLD: &str = "comparator_threshold = 0.25";
    const PASSIVE: &str = "recharge = \"passive\"";
    let with = |keys: &[&str]| LEAST.replace("reference", &(keys.join("\n") + "\nreference"));
    let of_comparator = scene(&with(&[PASSIVE, TIME_CONSTANT, THRESHOLD]));
    let spad = &of_comparator.detectors[0];
    let dead_time_ps = 2.0 * 10e3 * std::f64::consts::LN_2;
    assert!((spad.dead_time_ps / dead_time_ps - 1.0).abs() < 1e-14, "{}", spad.dead_time_ps);
    assert!((spad.pulse_width_ps / dead_time_ps - 0.5).abs() < 1e-14, "{}", spad.pulse_width_ps);
    assert!(spad.is_paralyzable());
    for (keys, told) in [
        (vec![PASSIVE, TIME_CONSTANT], "recharge_time_constant: alone it gives no dead time"),
        (vec![PASSIVE, THRESHOLD], "write recharge_time_constant, too, or dead_time"),
        (vec![PASSIVE, TIME_CONSTANT, THRESHOLD, "dead_time = \"14 ns\""], "leave out it or both"),
        (vec![TIME_CONSTANT, THRESHOLD], "write recharge = \"passive\""),
        (vec![PASSIVE, TIME_CONSTANT, "comparator_threshold = 1"], "outside 0.0001 to 0.9999"),
        (vec![PASSIVE, TIME_CONSTANT, "comparator_threshold = 0"], "outside 0.0001 to 0.9999"),
        (
            vec![PASSIVE, THRESHOLD, "recharge_time_constant = \"2 ms\""],
            "outside \"1 fs\" to \"1 ms\"",
        ),
    ] {
        let error = parse("x.toml", &with(&keys)).expect_err(told).to_string();
        assert!(error.contains(told), "{told}: {error}");
        assert_eq!(error.matches("x.toml:").count(), 1, "{error}");
    }
}

#[test]
fn optional_tables_are_read() {
    let scene = scene(&format!(
        "{LEAST}\n[estimate]\nestimator = \"model\"\n\n\
         [hardware]\ntarget = \"ice40-hx8k\"\nparallel = 4\ncounter_width = 12\n\
         peak_detector = true\ntotal_counts = true\n"
    ));
    assert_eq!(scene.estimator, EstimatorKind::Model);
    assert_eq!(scene.hardware.target, FpgaTarget::Ice40Hx8k);
    assert_eq!(scene.hardware.parallel, 4);
    assert_eq!(scene.hardware.counter_width, Some(12));
    assert!(scene.hardware.peak_detector);
    assert_eq!(scene.hardware.total_counts, Some(true));
}

#[test]
fn the_model_estimator_brings_total_counts_and_will_not_do_without() {
    let model = scene(&format!("{LEAST}\n[estimate]\nestimator = \"model\"\n"));
    assert!(model.sends_total_counts());
    // By the command line too, unless the scene's hardware has none.
    let phase = scene(LEAST).with_estimator(None).expect("nothing is asked for");
    assert!(!phase.sends_total_counts());
    let asked = phase.with_estimator(Some(EstimatorKind::Model));
    assert!(asked.expect("the scene leaves it open").sends_total_counts());
    let without = scene(&format!("{LEAST}\n[hardware]\ntotal_counts = false\n"));
    let refused = without.with_estimator(Some(EstimatorKind::Model));
    let error = refused.expect_err("there are no totals").to_string();
    assert!(error.contains("total_counts = false"), "{error}");
}

#[test]
fn a_path_takes_a_delay_in_place_of_a_distance() {
    let scene = scene(&LEAST.replace("distance = \"3.2 m\"", "delay = \"21.35 ns\""));
    assert_eq!(scene.paths[0].delay_ps, 21_350.0);
    // 21.35 ns of light, there and back.
    assert!((scene.paths[0].distance_m() - 3.200_284_489).abs() < 1e-8);
}

#[test]
fn both_spellings_of_an_infinite_extinction_ratio_are_taken() {
    for text in ["\"inf\"", "inf", "10", "10.0"] {
        let line = format!("extinction_ratio = {text}\nmean_power");
        let ratio = scene(&LEAST.replace("mean_power", &line)).sources[0].extinction_ratio;
        let expected = if text.contains("inf") { f64::INFINITY } else { 10.0 };
        assert_eq!(ratio, expected, "{text}");
    }
}

#[test]
fn a_window_is_given_by_its_first_step_and_count_or_by_its_centre() {
    let window = |line: &str| {
        let scan = scan(line);
        (scan.first_step, scan.steps)
    };
    assert_eq!(window("steps = \"all\""), (0, 248));
    assert_eq!(window("steps = { first = 240, count = 20 }"), (240, 20));
    // 3.2 m are 21.348 ns, so the nearest step of 1 ns is 21.
    assert_eq!(window("steps = { around = \"3.2 m\", halfwidth = 16 }"), (5, 33));
    assert_eq!(window("steps = { around = \"21.6 ns\", halfwidth = 16 }"), (6, 33));
    // Windows and distances wrap round the 248 ns of the code period.
    assert_eq!(window("steps = { around = \"3 ns\", halfwidth = 4 }"), (247, 9));
    assert_eq!(window("steps = { around = \"251 ns\", halfwidth = 0 }"), (3, 1));
}

#[test]
fn the_integration_time_is_rounded_to_whole_chips_and_kept_as_asked() {
    for (asked, chips) in [("20 us", 2500), ("4 ns", 1), ("20.003 us", 2500), ("20.005 us", 2501)] {
        let text = LEAST.replace("20 us", asked);
        assert_eq!(scene(&text).scan.integration_chips, chips, "{asked}");
    }
    let requested = scene(&LEAST.replace("20 us", "20.005 us")).scan.requested_integration_ps;
    assert_eq!(requested, 20_005_000.0);
}

#[test]
fn codes_are_made_with_every_key_they_take() {
    let code = |table: &str| {
        let text = LEAST.replace("{ family = \"gold\", degree = 5 }", table);
        scene(&text).sources[0].code.chips.clone()
    };
    // 3,1,0 from 1, 0, 0: c[t] = c[t-3] XOR c[t-1].
    let m = "{ family = \"m-sequence\", degree = 3, polynomials = [[3, 1, 0]], seeds = [\"100\"] }";
    assert_eq!(code(m), [1, 0, 0, 1, 1, 1, 0]);
    assert_eq!(code("{ family = \"chips\", chips = \"0110\" }"), [0, 1, 1, 0]);
    assert_eq!(code("{ family = \"square\", interleave = 1 }"), [1, 0, 0, 1]);
    let pair = "degree = 8, polynomials = [[8, 4, 3, 2, 0], [8, 6, 5, 3, 0]]";
    let allowed = format!("{{ family = \"gold\", {pair}, allow_non_preferred = true }}");
    assert_eq!(code(&allowed).len(), 255);
}

#[test]
fn light_beyond_the_unambiguous_range_is_no_error() {
    let scene = scene(&LEAST.replace("3.2 m", "100 km"));
    assert!((scene.paths[0].distance_m() - 1e5).abs() < 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Whatever is cut out, repeated or put in: a scene or located errors.
    #[test]
    fn no_text_makes_the_reader_panic(
        start in 0usize..400,
        length in 0usize..30,
        insert in "[\\[\\]{}\"=,.0-9a-zA-Zµ\n -]{0,12}",
    ) {
        let start = start.min(LEAST.len());
        let end = (start + length).min(LEAST.len());
        let text = format!("{}{insert}{}", &LEAST[..start], &LEAST[end..]);
        if let Err(error) = parse("x.toml", &text) {
            prop_assert!(error.to_string().starts_with("x.toml:"));
        }
    }
}

/// The movement of the least scene's path with more keys.
fn movement(keys: &str) -> Option<Movement> {
    let distance = "distance = \"3.2 m\"";
    let scene = scene(&LEAST.replace(distance, &format!("{distance}\n{keys}")));
    scene.paths[0].movement
}

#[test]
fn a_path_moves_at_its_speed_and_fluctuates() {
    let speed = |velocity_m_per_s| Movement { velocity_m_per_s, fluctuation: None };
    assert_eq!(movement("velocity = \"-3 mm/s\""), Some(speed(-3e-3)));
    assert_eq!(movement("velocity = \"36 km/h\""), Some(speed(10.0)));
    let fluctuation = Some(Fluctuation { std_m: 2e-3, correlation_time_ps: 1e9 });
    let keys = "velocity = \"1.5 m/s\"\n\
                fluctuation = { std = \"2 mm\", correlation_time = \"1 ms\" }";
    assert_eq!(movement(keys), Some(Movement { fluctuation, ..speed(1.5) }));
}

#[test]
fn a_path_that_does_neither_stands_still() {
    assert_eq!(movement("velocity = \"0 m/s\""), None);
    let keys = "fluctuation = { std = \"0 mm\", correlation_time = \"1 ms\" }";
    assert_eq!(movement(keys), None);
}

/// The least scene with a histogram and these keys more.
fn histogram(keys: &str) -> String {
    format!("{LEAST}[hardware]\narchitecture = \"histogram\"\n{keys}\n")
}

#[test]
fn a_histogram_integrates_over_whole_code_periods_for_all_steps_at_once() {
    // 31 chips of 8 ns: 20 us are 80.6 periods, 380 ns are 1.5, 100 ns are 0.4.
    for (integration, periods) in [("20 us", 81), ("380 ns", 2), ("100 ns", 1)] {
        let text = histogram("parallel = 1").replace("20 us", integration);
        let timing = scene(&text).timing();
        assert_eq!(timing.scan.integration_chips, 31 * periods);
        assert_eq!((timing.groups(), timing.grouping().steps_of_last()), (1, 248));
        assert!(timing.is_gapless());
    }
    assert!(scene(&histogram("")).sends_total_counts());
}

#[test]
fn what_a_histogram_has_no_use_for_is_refused_by_its_key() {
    for key in ["parallel = 2", "total_counts = true", "peak_detector = false"] {
        let error = parse("x.toml", &histogram(key)).expect_err(key).to_string();
        let name = key.split(' ').next().expect("a key");
        assert!(error.contains(&format!("hardware.{name}: ")), "{error}");
    }
    let window = histogram("").replace("[scan]", "[scan]\nsteps = { first = 0, count = 9 }");
    let error = parse("x.toml", &window).expect_err("a window").to_string();
    assert!(error.contains("hardware.architecture: a histogram has all phase steps"), "{error}");
}
