//! Dead time and afterpulses taken out of the expected histogram of a detector stepped
//! through time, which shares nothing with the correction: what is left is range walk.

use std::f64::consts::PI;

use goldtof_fft::num_complex::Complex64;

use goldtof::estimate::{delay_error_ps, distance_m};
use goldtof::histogram::correction::{BinnedAfterpulses, BinnedDetector, CorrectionError};
use goldtof::histogram::correlation::HistogramCorrelator;
use goldtof::scene::Scene;
use optics_support::stepped::Stepped;
use optics_support::{gold_11, ideal_scene, table_i_scene};

const STEP_PS: f64 = 25.0;
const SAMPLES: u32 = 8;
const DELAY_PS: f64 = 21_350.0;

fn scene(primary_cps: f64) -> Scene {
    let mut scene = table_i_scene(gold_11(), primary_cps, 2047 * 7);
    scene.paths[0].delay_ps = DELAY_PS;
    scene
}

/// Time that the phase gives for a histogram, by the article's formula.
fn phase_ps(bins: &[f64]) -> f64 {
    let counts = HistogramCorrelator::new(&gold_11(), SAMPLES).correlate(bins);
    let peak = (0..counts.len()).max_by(|&a, &b| counts[a].total_cmp(&counts[b]));
    let peak = peak.expect("steps") as i64;
    let samples = i64::from(SAMPLES);
    let sum: Complex64 = (-samples..samples)
        .map(|i| {
            let count = counts[(peak + i).rem_euclid(counts.len() as i64) as usize];
            Complex64::from_polar(count, -PI * i as f64 / samples as f64)
        })
        .sum();
    peak as f64 * 1000.0 - sum.arg() / PI * 8000.0
}

/// Distances of histograms beyond that of the same light on an ideal detector, in mm.
struct Walk {
    ideal_ps: f64,
}

impl Walk {
    /// Of light with the delay of a scene.
    fn of(scene: &Scene) -> Walk {
        let mut ideal = ideal_scene(gold_11(), 1e3, 2047);
        ideal.detectors[0].dead_time_ps = STEP_PS; // blinds for 10^-8 of the time
        ideal.detectors[0].afterpulsing_time_constant_ps = 5e3;
        ideal.paths[0].delay_ps = scene.paths[0].delay_ps + scene.detectors[0].delay_ps;
        Walk { ideal_ps: phase_ps(&Stepped::new(&ideal, STEP_PS).hits_per_sample()) }
    }

    fn mm(&self, bins: &[f64]) -> f64 {
        let period_ps = 2047.0 * 8000.0;
        1e3 * distance_m(delay_error_ps(phase_ps(bins), self.ideal_ps, period_ps))
    }
}

fn table_i(afterpulses: bool) -> BinnedDetector {
    BinnedDetector {
        bins: 14.0,
        afterpulses: afterpulses.then(|| BinnedAfterpulses {
            mean_per_avalanche: -(1.0 - 0.137_f64).ln(),
            time_constant_bins: 5.0,
        }),
    }
}

/// Walk of the histogram as it is, with dead time taken out, and with afterpulses too.
fn walks_mm(scene: &Scene, walk: &Walk) -> [f64; 3] {
    let bins = Stepped::new(scene, STEP_PS).hits_per_sample();
    let corrected = |afterpulses| {
        let light = table_i(afterpulses).correct_means(&bins, 1.0);
        walk.mm(&light.expect("it is ready").per_period)
    };
    [walk.mm(&bins), corrected(false), corrected(true)]
}

/// The rates, walks as they are and with dead time alone are about those of a prototype of
/// another hand: -2.7, -18.9, -76.5, -157.8, -323.6 mm and 2.0, 3.6, 7.1, 9.0, 6.2 mm.
#[test]
fn hardly_any_walk_is_left_of_any_light() {
    let beyond_ideal = Walk::of(&scene(1.0));
    for (primary_mcps, as_it_is, dead_time) in [
        (1.2, -4.0, 0.8),
        (6.0, -20.4, 2.2),
        (25.0, -76.6, 5.8),
        (60.0, -154.7, 8.1),
        (200.0, -316.6, 9.2),
    ] {
        let mut scene = scene(primary_mcps * 1e6);
        let [walk, without_dead_time, without_both] = walks_mm(&scene, &beyond_ideal);
        assert!((walk - as_it_is).abs() < 0.1, "{primary_mcps}: {walk} mm");
        let left = without_dead_time - dead_time;
        assert!(left.abs() < 0.1, "{primary_mcps}: {without_dead_time} mm");
        assert!(without_both.abs() < 0.6, "{primary_mcps}: {without_both} mm");
        // The jitter of Table I, which the correction leaves out, moves nothing.
        scene.detectors[0].jitter_ps.clear();
        let [.., without_jitter] = walks_mm(&scene, &beyond_ideal);
        let jitter_mm = without_both - without_jitter;
        assert!(jitter_mm.abs() < 0.05, "{primary_mcps}: {jitter_mm} mm");
    }
}

/// Dead times that are no whole bins, and light that changes within them.
#[test]
fn the_dead_time_need_not_be_whole_bins() {
    for (dead_time_ps, samples_mcps) in [(10_400.0, 25.0), (22_725.0, 25.0), (39_950.0, 60.0)] {
        let mut scene = scene(samples_mcps * 1e6);
        scene.detectors[0].dead_time_ps = dead_time_ps;
        scene.paths[0].delay_ps = 20_125.0;
        let bins = Stepped::new(&scene, STEP_PS).hits_per_sample();
        let dead_time = BinnedDetector { bins: dead_time_ps / 1000.0, ..table_i(true) };
        let light = dead_time.correct_means(&bins, 1.0).expect("it is ready");
        let walk = Walk::of(&scene);
        let left = walk.mm(&light.per_period);
        assert!(left.abs() < 1.0, "{dead_time_ps} ps: {left} mm");
        assert!(walk.mm(&bins).abs() > 20.0);
    }
}

/// Under constant light a detector without afterpulses detects r / (1 + r D), in every bin,
/// also where the dead time is shorter than a bin or longer than the code period.
#[test]
fn constant_light_comes_back_whatever_the_dead_time() {
    for dead_time_bins in [0.0, 0.3, 1.0, 1.75, 7.0, 15.5, 16.0, 39.2] {
        let light = 0.02;
        let detected = light / (1.0 + light * dead_time_bins);
        let dead_time = BinnedDetector { bins: dead_time_bins, afterpulses: None };
        let corrected = dead_time.correct_means(&[detected; 16], 1.0).expect("it is ready");
        for bin in 0..16 {
            assert!((corrected.per_period[bin] - light).abs() < 1e-14);
            let ready = 1.0 - detected * dead_time_bins;
            assert!((corrected.ready[bin] - ready).abs() < 1e-14);
        }
    }
}

#[test]
fn what_no_such_detector_counts_is_refused() {
    // One detection in each bin of every period cannot be with a dead time.
    let refused = table_i(true).correct_means(&[0.5; 16], 1.0);
    let Err(CorrectionError::NeverReady { bin: 0, ready, .. }) = refused else {
        panic!("{refused:?}");
    };
    assert!((ready - (1.0 - 7.0)).abs() < 1e-12);
    let with = |bins, mean_per_avalanche, time_constant_bins| BinnedDetector {
        bins,
        afterpulses: Some(BinnedAfterpulses { mean_per_avalanche, time_constant_bins }),
    };
    let refuses = |dead_time: BinnedDetector| dead_time.correct_means(&[0.01; 16], 1.0).is_err();
    for bins in [f64::NAN, -1.0, f64::INFINITY] {
        assert!(refuses(BinnedDetector { bins, afterpulses: None }));
    }
    assert!(refuses(with(0.9, 0.1, 5.0)));
    assert!(refuses(with(14.0, -0.1, 5.0)) && refuses(with(14.0, 0.1, 0.0)));
    assert!(refuses(with(14.0, f64::NAN, 5.0)) && refuses(with(14.0, 0.1, f64::NAN)));
    // Each avalanche traps more than one, which are never lost.
    assert!(matches!(
        with(1.0, 40.0, 1e9).correct_means(&[0.9; 16], 1.0),
        Err(CorrectionError::NotSettled { .. })
    ));
}
