//! Widths of the samples' bins from simulated dark counts: as often within their intervals as these
//! say, the same through the file, and refused where the counts are not of dark counts alone.

use std::fs;

use goldtof::photons::{DetectorModel, Level, PulseStream};
use goldtof::recorded::CountsFile;
use goldtof::recorded::code_density::{
    CodeDensity, DarkCounts, DarkParts, DensityError, code_density,
};
use goldtof::scan::{Sample, Sampler};
use goldtof::scene::{DetectorIndex, Scene, load, load_with};
use goldtof::sensor::Sensor;
use optics_support::{Moments, assert_within_standard_errors, gold_5, repeated, table_i_scene};

const SPAD: DetectorIndex = DetectorIndex(0);
const WIDTHS: [f64; 8] = [1.3, 0.7, 1.0, 0.55, 1.25, 0.9, 1.35, 0.95];

/// The sensor of Table I, dark but for a share of light, with quicker dark counts.
fn scene(widths: &[f64], light: f64) -> Scene {
    let mut scene = table_i_scene(gold_5(), 5e6 * light, 31 * 60);
    scene.detectors[0].dark_count_rate_cps = 5e6 * (1.0 - light);
    scene.detectors[0].sampler = Sampler::of_widths(widths);
    scene
}

/// Rising edges of a scan by their sample of the code period: some 15,000.
fn counts(scene: &Scene, seed: u64) -> DarkCounts {
    let model = DetectorModel::new(&Sensor::new(scene), SPAD);
    let samples = scene.scan.steps * scene.scan.integration_chips * 8;
    let mut pulses = Vec::new();
    PulseStream::new(&model, seed, 0).advance(Sample(samples), &mut pulses);
    let mut level = Level::default();
    let mut counts = vec![0; 31 * 8];
    for pulse in &pulses {
        if level.rises(pulse) {
            counts[(pulse.first.0 % (31 * 8)) as usize] += 1;
        }
    }
    DarkCounts { detector: SPAD, parts: DarkParts::Chips, counts }
}

fn density(scene: &Scene, dark: &DarkCounts) -> Result<CodeDensity, DensityError> {
    code_density(&Sensor::new(scene), dark)
}

#[test]
fn widths_are_within_their_intervals_as_often_as_these_say() {
    let scene = scene(&WIDTHS, 0.0);
    let runs = repeated(400, 4_000);
    let (mut within, mut disagreements, mut found) = (0, Vec::new(), vec![Vec::new(); 8]);
    for seed in 0..runs {
        let told = density(&scene, &counts(&scene, seed)).expect("dark counts alone");
        for (sample, (bin, width)) in told.samples.iter().zip(WIDTHS).enumerate() {
            let [low, high] = bin.width_ps_ci95;
            within += u64::from((low..=high).contains(&(1000.0 * width)));
            found[sample].push(bin.width_ps);
        }
        disagreements.push(told.disagreement_in_std.expect("chips"));
        assert!(told.p_value < 1e-6);
    }
    let all = 8 * runs;
    let share = within as f64 / all as f64;
    println!("{share:.4} of {all} widths within their intervals of 95 %");
    // Two and a half standard deviations of so many.
    assert!((share - 0.95).abs() < 2.5 * (0.95 * 0.05 / all as f64).sqrt(), "{share}");
    for (sample, (found, width)) in found.into_iter().zip(WIDTHS).enumerate() {
        let z = Moments::of(found).z(1000.0 * width);
        assert_within_standard_errors(z, 4.0, &format!("width of sample {sample}"));
    }
    let normal = Moments::of(disagreements);
    println!("disagreement {:.3}, variance {:.3}", normal.mean, normal.variance);
    assert!(normal.mean.abs() < 0.2 && (normal.variance - 1.0).abs() < 0.3);
}

#[test]
fn even_samples_are_taken_for_uneven_as_often_as_chance_has_it() {
    let scene = scene(&[1.0; 8], 0.0);
    let runs = 300;
    let seldom = (0..runs).filter(|&seed| {
        let told = density(&scene, &counts(&scene, seed)).expect("dark counts alone");
        assert!(told.distance_error_m.abs() < 0.01);
        told.p_value < 0.05
    });
    let seldom = seldom.count() as f64;
    println!("{seldom} of {runs} below a chance of 5 %");
    assert!((seldom - 15.0).abs() < 4.0 * 15_f64.sqrt(), "{seldom}");
}

/// What the sampler costs, from the counts alone.
#[test]
fn a_second_pin_is_measured_and_what_it_costs() {
    let skew = 0.1;
    let scene = scene(&[1.0 - skew, 1.0 + skew].repeat(4), 0.0);
    let told: Vec<_> = (0..16)
        .map(|seed| density(&scene, &counts(&scene, seed)).expect("dark counts alone"))
        .collect();
    let error_m = told.iter().map(|told| told.distance_error_m).sum::<f64>() / told.len() as f64;
    // 0.0749 mm a picosecond, of 100; and four standard deviations of 16 times 15,000 counts.
    assert!((error_m + 7.49e-3).abs() < 1.25e-3, "{error_m}");
    assert!(told[0].text(71e3).contains("for widths to 1 % count 80000, 1.1 s at 71.0 kcps"));
}

#[test]
fn light_that_follows_the_clock_is_refused() {
    // A tenth of the counts.
    let lit = scene(&WIDTHS, 0.1);
    let refused = (0..20).filter_map(|seed| density(&lit, &counts(&lit, seed)).err());
    let refused: Vec<DensityError> = refused.collect();
    assert_eq!(refused.len(), 20);
    let by_code = |error: &&DensityError| matches!(error, DensityError::CodeShows { .. });
    assert!(refused.iter().all(|error| by_code(&error)), "{refused:?}");
    // Of recordings by sample only that one of them differs can be seen.
    let dark = scene(&WIDTHS, 0.0);
    let by_sample = |dark: DarkCounts| -> Vec<u64> {
        (0..8).map(|sample| dark.counts.iter().skip(sample).step_by(8).sum()).collect()
    };
    let first = by_sample(counts(&dark, 1));
    let other = scene(&[1.0, 1.0, 1.0, 0.55, 1.25, 0.9, 1.35, 0.95], 0.0);
    let runs = |others: Vec<u64>| {
        let counts = [first.clone(), others].concat();
        density(&dark, &DarkCounts { detector: SPAD, parts: DarkParts::Runs, counts })
    };
    assert!(runs(by_sample(counts(&dark, 2))).is_ok());
    let differ = runs(by_sample(counts(&other, 2))).expect_err("it changed");
    assert!(differ.to_string().starts_with("the recordings do not agree"), "{differ}");
}

#[test]
fn what_does_not_tell_widths_is_refused() {
    let dark = scene(&WIDTHS, 0.0);
    let of = |counts: [u64; 8]| {
        density(
            &dark,
            &DarkCounts { detector: SPAD, parts: DarkParts::Runs, counts: counts.into() },
        )
    };
    assert!(of([390, 411, 395, 405, 400, 402, 398, 399]).is_ok());
    // By chance two of two counts are the same in one recording of 900, and eight never.
    for stopped in [
        [400; 8],
        [65_535, 61_023, 65_535, 65_535, 60_110, 65_535, 65_535, 60_908],
        [61_023, 60_110, 65_535, 60_908, 61_544, 60_020, 60_700, 61_100],
    ] {
        let stopped = of(stopped).expect_err("counters are full").to_string();
        assert!(stopped.contains("counters that stop there"), "{stopped}");
    }
    let few = of([399; 8]).expect_err("too few").to_string();
    assert!(few.contains("3192 dark counts at 8 samples are too few"), "{few}");
    assert!(few.contains("count at least 3200"), "{few}");
    let none = of([400, 4000, 0, 400, 400, 400, 400, 400]).expect_err("no pin").to_string();
    assert!(none.contains("sample 2 has 0 of 6400 dark counts"), "{none}");
    for (pulse_ps, words) in [(1_300.0, "fall between two samples"), (13_500.0, "follow so soon")] {
        let mut other = dark.clone();
        other.detectors[0].pulse_width_ps = pulse_ps;
        let error = density(&other, &counts(&dark, 3)).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    }
}

/// From dark counts to the scene that reads what they say.
#[test]
fn widths_go_through_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let quick = folder.path().join("quick.toml");
    fs::copy("scenes/quick.toml", &quick).expect("copied");
    let sensor = Sensor::new(&load(&quick).expect("it is sound"));
    let dark = counts(&scene(&WIDTHS, 0.0), 9);
    let read = |text: String| {
        let path = folder.path().join("dark.csv");
        fs::write(&path, text).expect("written");
        CountsFile::read(&path).expect("text").dark_counts(&sensor)
    };
    let rows = dark.counts.iter().enumerate().map(|(bin, count)| format!("{bin},{count},spad\n"));
    let bins = read(format!("bin,count,detector\n{}", rows.collect::<String>())).expect("bins");
    assert_eq!(bins, std::slice::from_ref(&dark));
    let told = code_density(&sensor, &dark).expect("dark counts alone");
    fs::write(folder.path().join("sampler.csv"), told.csv()).expect("written");
    let set = "detector.sampler={ file = \"sampler.csv\" }".parse().expect("a setting");
    let scene = load_with(&quick, &[set]).expect("it is sound");
    for (sample, bin) in (0_i64..).zip(&told.samples) {
        let width_ps = 1000.0 * scene.detectors[0].sampler.width(sample);
        assert!((width_ps - bin.width_ps).abs() < 0.01, "{sample}: {width_ps} {bin:?}");
    }
    let samples = read("run;sample;count\n1;0;7\n0;0;1\n".to_owned() + &missing(0) + &missing(1));
    assert_eq!(samples.expect("samples")[0].counts[..10], [1, 10, 10, 10, 10, 10, 10, 10, 7, 11]);
    for (text, complaint) in [
        ("sample,count\n8,1\n", "dark.csv:2: a chip of the scene has no sample 8: it has 8"),
        ("sample,count\n0,1\n0,1\n", "dark.csv:3: sample 0 of detector \"spad\" stands on line 2"),
        ("sample,count\n0,-1\n", "dark.csv:2: count is -1"),
        ("sample,count\n0,1\n", "7 of the 8 samples of detector \"spad\" missing, the first is 1"),
        ("sample,count,run\n0,1,-1\n", "dark.csv:2: run is -1"),
        ("bin,count\n248,1\n", "dark.csv:2: the scene's histogram has no bin 248"),
        ("phase_step,count\n0,1\n", "dark.csv:1: dark counts are told by sample of the chip"),
        ("sample,counts\n0,1\n", "no column of samples is called \"counts\""),
    ] {
        let error = read(text.to_owned()).expect_err(text).to_string();
        assert!(error.contains(complaint), "{text:?}: {error}");
    }
}

/// Rows of samples 1 to 7 of a run.
fn missing(run: u32) -> String {
    (1..8).map(|sample| format!("{run};{sample};{}\n", 10 + run)).collect()
}
