//! `goldtof calibrate`, and what plan, explain and simulate say of a sampler, a duty cycle and crosstalk.

use std::fs;

use super::program::{QUICK, goldtof, json, said};

fn text(arguments: &[&str]) -> String {
    let output = goldtof(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", said(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &said(&output);
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

const SKEW: &str = "detector.sampler={ second_pin_skew = \"100 ps\" }";

#[test]
fn plan_says_what_a_second_pin_costs() {
    let plan = text(&["plan", QUICK, "--set", SKEW]);
    // Half of 100 ps, and c / 2 of that: 7.49 mm.
    let told =
        "samples are 0.900 to 1.100 ns apart, which moves the mean arrival by -50.0 ps, -7.49 mm";
    assert!(plan.contains(told), "{plan}");
    let even = text(&["plan", QUICK]);
    assert!(!even.contains("apart, which moves"), "{even}");
    let longer = text(&["plan", QUICK, "--set", "source.duty_cycle_distortion=-200 ps"]);
    assert!(longer.contains("on for -200 ps longer than its chips"), "{longer}");
}

#[test]
fn explain_tries_an_even_sampler_and_duty_cycle() {
    let explained = text(&["explain", QUICK, "--set", SKEW]);
    assert!(explained.contains("detector.sampler.second_pin_skew=0 s"), "{explained}");
    let widths = "detector.sampler={ widths = [1.2, 0.8, 1, 1, 1, 1, 1, 1] }";
    let explained = text(&["explain", QUICK, "--set", widths]);
    assert!(explained.contains("detector.sampler.widths=[1, 1, 1, 1, 1, 1, 1, 1]"), "{explained}");
    let longer = ["explain", QUICK, "--set", "source.duty_cycle_distortion=1 ns"];
    assert!(text(&longer).contains("source.duty_cycle_distortion=0 s"));
}

/// The tier without samples says what it leaves out, and is the only one that does.
#[test]
fn the_tier_without_samples_says_so() {
    for (fidelity, leaves_out) in [("events", true), ("sampled", false), ("expected", false)] {
        let simulated =
            text(&["simulate", QUICK, "--repeat", "2", "--fidelity", fidelity, "--set", SKEW]);
        let told = simulated.contains("samples are not equally far apart");
        assert_eq!(told, leaves_out, "{fidelity}: {simulated}");
    }
}

#[test]
fn dark_counts_become_a_file_that_the_scene_reads() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("text").to_owned();
    fs::copy(QUICK, at("quick.toml")).expect("copied");
    let counts = [900, 1100, 900, 1100, 900, 1100, 900, 1100];
    let rows = counts.iter().enumerate().map(|(sample, count)| format!("{sample},{count}\n"));
    fs::write(at("dark.csv"), "sample,count\n".to_owned() + &rows.collect::<String>())
        .expect("made");
    let arguments = ["calibrate", &at("quick.toml"), &at("dark.csv"), "--out", &at("pins.csv")];
    let told = text(&arguments);
    for words in [
        "spad: 8000 dark counts at 8 samples of a chip, 1000 ps apart",
        "mean arrival moved by -50.0 ps: distances of a scene without the sampler are off by -7.49 mm",
        "not known whether light follows the clock",
        "for widths to 1 % count 80000, 1.1 s at 71.0 kcps",
    ] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let read = ["plan", &at("quick.toml"), "--set", "detector.sampler.file=pins.csv"];
    assert!(text(&read).contains("moves the mean arrival by -50.0 ps"));
    // Shards and sweeps have what was in it.
    let document = json(&[&read[..], &["--json"]].concat());
    let settings = document["scene"]["settings"].as_array().expect("a list");
    let last = settings.last().and_then(|setting| setting.as_str()).unwrap_or_default();
    assert!(last.starts_with("detector[0].sampler={ widths = [0.9, 1.1,"), "{document}");
    // The chi-square of eight counts of 1,000, each 100 off: 80 for 7 degrees of freedom.
    let document = json(&[&arguments[..], &["--json"]].concat());
    let sampler = &document["samplers"][0];
    assert_eq!(sampler["chi_square"].as_f64(), Some(80.0));
    assert_eq!(sampler["degrees_of_freedom"].as_f64(), Some(7.0));
    assert_eq!(sampler["samples"][1]["width_ps"].as_f64(), Some(1100.0));
    fs::write(at("few.csv"), "sample,count\n0,1\n").expect("made");
    let output = goldtof(&["calibrate", QUICK, &at("few.csv")]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        said(&output).contains("few.csv:2: the file ends with 7 of the 8 samples"),
        "{}",
        said(&output)
    );
    let other = goldtof(&["calibrate", QUICK, &at("dark.csv"), "--detector", "other"]);
    assert!(said(&other).contains("the scene has \"spad\""), "{}", said(&other));
}
