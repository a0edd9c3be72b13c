//! `goldtof explain`: where light, time and bits go, and what another value of one key would bring.

use serde_json::Value;

use super::program::{QUICK, goldtof, json, said};

const PAPER: &str = "scenes/paper-single.toml";

fn explained(scene: &str, more: &[&str]) -> Value {
    json(&[&["explain", scene, "--json"][..], more].concat())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

#[test]
fn the_articles_sensor_is_explained_by_its_own_numbers() {
    let told = explained(PAPER, &[]);
    let light = &told["light"];
    // 4 pW of 783 nm are 15.7669 million photons a second, detected with 31 %.
    assert!((number(&light["own_primary_hz"]) / 4.887_73e6 - 1.0).abs() < 1e-4);
    assert_eq!((number(&light["background_hz"]), number(&light["dark_counts_hz"])), (0.0, 71e3));
    // One afterpulse in 0.863 avalanches' worth, and 14 ns for each detection: between what dead time
    // leaves without afterpulses and what it leaves with all that come.
    let detected_cps = number(&light["detected_rate_cps"]);
    let primary_hz = 4.958_73e6;
    let most_hz = primary_hz / (1.0 - 0.137) / (1.0 + primary_hz / (1.0 - 0.137) * 14e-9);
    assert!((primary_hz / (1.0 + primary_hz * 14e-9)..most_hz).contains(&detected_cps));
    let blind = number(&light["blind_fraction"]);
    assert!((blind - detected_cps * 14e-9).abs() < 1e-9);
    // 16,376 results of 24 bits in 16,376 steps of 13,100 chips of 8 ns, and the gap between scans.
    let bits_per_s = number(&told["result_bits_per_s"]);
    assert!((bits_per_s / (24.0 / (13_100.0 * 8e-9)) - 1.0).abs() < 1e-3, "{bits_per_s}");
}

/// The bound of photons alone: as one over the root of the integration time.
#[test]
fn four_times_the_integration_halves_scatter_and_bound_and_takes_four_times_as_long() {
    for scene in [QUICK, PAPER] {
        let told = explained(scene, &[]);
        let changes = told["changes"].as_array().expect("a list");
        let longer = changes.iter().find(|change| {
            change["setting"].as_str().expect("text").starts_with("scan.integration=")
        });
        let longer = longer.expect("it is tried");
        let [now, then] = [&told["expected"], &longer["expected"]];
        for key in ["expected_std_m", "bound_m"] {
            let ratio = number(&then[key]) / number(&now[key]);
            assert!((ratio - 0.5).abs() < 0.01, "{scene} {key}: {ratio}");
        }
        let frame = number(&then["frame_time_s"]) / number(&now["frame_time_s"]);
        assert!((frame - 4.0).abs() < 0.01, "{scene}: {frame}");
        assert!((number(&longer["bound_change_fraction"]) + 0.5).abs() < 0.01);
    }
}

/// What is told of a change is what `plan` tells of the scene with that setting.
#[test]
fn each_change_is_what_the_plan_says_of_that_setting() {
    let told = explained(QUICK, &[]);
    let changes = told["changes"].as_array().expect("a list");
    assert!(changes.len() >= 12, "{changes:#?}");
    for change in changes {
        let setting = change["setting"].as_str().expect("text");
        let plan = json(&["plan", QUICK, "--set", setting, "--json"]);
        let row = usize::from(setting.ends_with("=model"));
        let expected = &plan["expected"][row];
        for key in ["expected_bias_m", "expected_std_m", "bound_m"] {
            assert_eq!(expected[key], change["expected"][key], "{setting} {key}");
        }
        let frame = &plan["figures"]["frame_time_s"];
        assert_eq!(frame, &change["expected"]["frame_time_s"], "{setting}");
        let rms_m =
            |of: &Value| number(&of["expected_bias_m"]).hypot(number(&of["expected_std_m"]));
        let gain = rms_m(expected) / rms_m(&told["expected"]) - 1.0;
        assert!((number(&change["rms_change_fraction"]) - gain).abs() < 1e-9, "{setting}");
    }
    let gains = changes.iter().map(|change| number(&change["rms_change_fraction"]));
    assert!(gains.is_sorted(), "the largest gain first");
}

#[test]
fn of_several_the_one_that_is_named() {
    let told = explained("scenes/dual-view.toml", &["--detector", "spad"]);
    let setting = |change: &Value| change["setting"].as_str().expect("text").to_owned();
    let changes: Vec<String> =
        told["changes"].as_array().expect("a list").iter().map(setting).collect();
    assert!(changes.contains(&"source[0].mean_power=8 pW".to_owned()), "{changes:?}");
    assert!(number(&told["light"]["other_primary_hz"]) > 0.0);
    let nobody = goldtof(&["explain", QUICK, "--detector", "nobody"]);
    assert_eq!(nobody.status.code(), Some(2));
    let error = said(&nobody);
    assert!(error.contains("no detector \"nobody\"; it has \"spad\""), "{error}");
}

/// A scene of which nothing is expected says why; what limits it says the text first.
#[test]
fn the_text_says_what_limits_first() {
    let text = |more: &[&str]| {
        let arguments = [&["explain"][..], more].concat();
        let output = goldtof(&arguments);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(
        text(&[QUICK]).contains("The bias limits it: -72.27 mm against a scatter of 17.05 mm.")
    );
    let model = text(&[QUICK, "--set", "estimate.estimator=model"]);
    assert!(model.contains("Photons limit it first: scan.integration=80 us takes"), "{model}");
    let passive = text(&[QUICK, "--set", "detector.recharge=passive"]);
    assert!(passive.contains("Nothing is expected of this scene:"), "{passive}");
    let dark = text(&[QUICK, "--set", "source.mean_power=0 W"]);
    assert!(dark.contains("Nothing is expected of this scene:"), "{dark}");
}

/// Of four samples a chip on a phase step the bound is none for every estimator, and no text calls it Cramer and Rao's.
#[test]
fn a_bound_has_the_name_of_what_it_is() {
    let corner = [
        "--set=clock.samples_per_chip=4",
        "--set=path.distance=3.597509 m",
        "--set=source.mean_power=2 pW",
        "--set=detector.delay=0 s",
        "--set=detector.counter={}",
    ];
    for (settings, kind, name, other) in [
        (&corner[..], "maximum-likelihood", "maximum-likelihood scatter", "Cramer-Rao"),
        (&[], "cramer-rao", "Cramer-Rao bound", "maximum-likelihood"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().to_str().unwrap();
        for command in [
            &["plan", QUICK][..],
            &["explain", QUICK],
            &["simulate", QUICK, "--fidelity", "expected"],
            &["run", QUICK, "--out", out],
        ] {
            let output = goldtof(&[command, settings].concat());
            let text = String::from_utf8_lossy(&output.stdout);
            assert!(text.contains(name) && !text.contains(other), "{command:?}: {text}");
        }
        let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
        assert!(page.contains(&format!("model fit, {name}")) && !page.contains(other), "{kind}");
        let told =
            json(&[&["simulate", QUICK, "--fidelity", "expected", "--json"], settings].concat());
        assert_eq!(told["estimates"][0]["bound_kind"], kind);
    }
}
