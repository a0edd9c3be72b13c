//! The fast engine under background, against exact results.

use std::num::NonZero;
use std::thread::available_parallelism;

use goldtof::photons::fast::StepCounter;
use goldtof::photons::{DetectorModel, StepCount};
use goldtof::response::MeanResponse;
use goldtof::scene::{DetectorIndex, Scan, Scene};
use goldtof::sensor::Sensor;
use optics_support::{Moments, assert_within_standard_errors, code, ideal_scene, table_i_scene};

const STEP_CHIPS: u64 = 13_100;
const STEP_S: f64 = STEP_CHIPS as f64 * 8e-9;

/// Total counts of so many steps.
fn totals(scene: &Scene, steps: u64) -> Moments {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    let counter = StepCounter::new(&model);
    assert_eq!(counter.outside_domain(), None, "the lanes must be used");
    let mut counts = vec![StepCount::ZERO; steps as usize];
    let threads = available_parallelism().unwrap_or(NonZero::<usize>::MIN);
    counter.count_on_threads(threads, 5, 0..steps, 0..1, &mut counts);
    Moments::of(counts.iter().map(|count| count.total as f64))
}

/// Mean and variance of the counts, within three standard errors each; with
/// `--nocapture` as a row of a table.
#[track_caller]
fn assert_moments(what: &str, counts: &Moments, mean: f64, variance: f64) {
    let (mean_z, variance_z) = (counts.z(mean), counts.variance_z(variance));
    println!(
        "{what:28} {:11.0} detections  rate {:.6} Mcps, exact {:.6} ({mean_z:+.2} standard \
         errors)  Fano {:.5}, exact {:.5} ({variance_z:+.2})",
        counts.mean * counts.count,
        counts.mean / STEP_S / 1e6,
        mean / STEP_S / 1e6,
        counts.variance / counts.mean,
        variance / mean,
    );
    assert_within_standard_errors(mean_z, 3.0, &format!("{what}: mean count"));
    assert_within_standard_errors(variance_z, 3.0, &format!("{what}: variance"));
}

/// Background on a detector that adds nothing.
fn constant_light(rate_cps: f64) -> Scene {
    let mut scene = ideal_scene(code(&[1, 0, 1]), 0.0, STEP_CHIPS);
    scene.detectors[0].background_rate_cps = rate_cps;
    scene.scan = Scan { steps: 1, ..scene.scan };
    scene
}

/// The same light from a source whose code is always on.
fn always_on(rate_cps: f64) -> Scene {
    let mut scene = ideal_scene(code(&[1]), rate_cps, STEP_CHIPS);
    scene.scan.steps = 1;
    scene
}

/// Mean lambda T / (1 + lambda D), and Fano factor 1 / (1 + lambda D)^2 up to
/// terms of D / T, which are added: a stationary renewal process has the
/// variance V T / M^3 + 1/6 + V^2 / (2 M^4) - S / (3 M^3), for waits of mean M,
/// variance V and third central moment S (Cox, Renewal Theory, 1962, section
/// 4.5, with the equilibrium start).
fn assert_renewal(scene: &Scene, rate: f64, dead_time: f64, steps: u64) {
    let counts = totals(scene, steps);
    let mean_wait = 1.0 / rate + dead_time;
    let (v, s) = (rate.powi(-2), 2.0 * rate.powi(-3));
    let variance = v * STEP_S / mean_wait.powi(3) + 1.0 / 6.0 + v * v / (2.0 * mean_wait.powi(4))
        - s / (3.0 * mean_wait.powi(3));
    let what = format!("dead time, {rate:.0e} cps");
    assert_moments(&what, &counts, STEP_S / mean_wait, variance);
}

fn assert_dead_time_alone(scale: u64) {
    for (rate, steps) in [(1e6, 4_000), (10e6, 1_500), (50e6, 700)] {
        for mut scene in [constant_light(rate), always_on(rate)] {
            scene.detectors[0].dead_time_ps = 14e3;
            assert_renewal(&scene, rate, 14e-9, steps * scale);
        }
    }
}

#[test]
fn dead_time_alone_gives_the_renewal_rate_and_fano_factor() {
    assert_dead_time_alone(10);
}

#[test]
#[ignore = "hundreds of millions of detections; run with --release"]
fn dead_time_alone_does_so_over_hundreds_of_millions_of_detections() {
    assert_dead_time_alone(240);
}

/// Total progeny of a Poisson branching process (Borel): each primary avalanche
/// makes 1 / (1 - m) detections, and the Fano factor is 1 / (1 - m)^2.
fn assert_afterpulses_alone(scale: u64) {
    for (rate, probability, steps) in [(1e6, 0.137, 16_000), (10e6, 0.3, 1_000), (50e6, 0.137, 280)]
    {
        let mut scene = constant_light(rate);
        let spad = &mut scene.detectors[0];
        spad.afterpulsing_probability = probability;
        spad.afterpulsing_time_constant_ps = 5e3;
        let counts = totals(&scene, steps * scale);
        let m = -(1.0 - probability).ln();
        let mean = rate * STEP_S / (1.0 - m);
        // Clusters cut by the ends of the step cost some 10^-4 of the variance.
        let variance = mean * (1.0 - m).powi(-2);
        let what = format!("afterpulses, {rate:.0e} cps");
        assert_moments(&what, &counts, mean, variance);
    }
}

#[test]
fn afterpulses_alone_give_the_rate_and_fano_factor_of_a_branching_process() {
    assert_afterpulses_alone(3);
}

#[test]
#[ignore = "a hundred million detections; run with --release"]
fn afterpulses_alone_do_so_over_a_hundred_million_detections() {
    assert_afterpulses_alone(60);
}

/// Mean and variance of the counts of a step under background, for a detector
/// with dead time and afterpulses: a Markov renewal process, looked at whenever
/// the dead time ends.
///
/// With m afterpulses pending the wait is exponential, of rate r = lambda + m / tau,
/// whichever of them ends it; an afterpulse does with the chance (m / tau) / r. Then
/// each one pending outlives the dead time with exp(-D / tau), and a Poisson number of
/// new ones is pending at its end. The counts' variance is that of a cycle, with
/// all its covariances with later cycles, over the mean cycle cubed.
fn markov_renewal(rate: f64, dead_time: f64, probability: f64, constant: f64) -> (f64, f64) {
    const M: usize = 12;
    let survival = (-dead_time / constant).exp();
    let new = -(1.0 - probability).ln();
    let poisson = |n: usize| (1..=n).fold((-new).exp(), |p, i| p * new / i as f64);
    let binomial = |n: usize, k: usize| {
        let ways = (0..k).fold(1.0, |w, i| w * (n - i) as f64 / (i + 1) as f64);
        ways * survival.powi(k as i32) * (1.0 - survival).powi((n - k) as i32)
    };
    let after_dead_time = |pending: usize, next: usize| -> f64 {
        let kept = 0..=pending.min(next);
        kept.map(|k| binomial(pending, k) * poisson(next - k)).sum()
    };
    let exit = |m: usize| rate + m as f64 / constant;
    let step = |row: &[f64; M]| -> [f64; M] {
        std::array::from_fn(|next| {
            (0..M)
                .map(|m| {
                    let photon = rate / exit(m) * after_dead_time(m, next);
                    let released = match m {
                        0 => 0.0,
                        _ => m as f64 / constant / exit(m) * after_dead_time(m - 1, next),
                    };
                    row[m] * (photon + released)
                })
                .sum()
        })
    };
    let mut stationary = [0.0; M];
    stationary[0] = 1.0;
    for _ in 0..200 {
        stationary = step(&stationary);
    }
    let wait = |m: usize| dead_time + 1.0 / exit(m);
    let mean: f64 = (0..M).map(|m| stationary[m] * wait(m)).sum();
    let square: f64 = (0..M).map(|m| stationary[m] * (wait(m).powi(2) + exit(m).powi(-2))).sum();
    let mut variance = square - mean * mean;
    // What a cycle's wait says of those after it.
    let mut excess: [f64; M] = std::array::from_fn(|m| stationary[m] * (wait(m) - mean));
    for _ in 0..200 {
        excess = step(&excess);
        variance += 2.0 * (0..M).map(|m| excess[m] * wait(m)).sum::<f64>();
    }
    (STEP_S / mean, STEP_S * variance / mean.powi(3))
}

/// Background on the detector of Table I: against the Markov renewal process,
/// and that against the mean response's chain.
fn assert_table_i(scale: u64) {
    for (rate, steps) in [(1e6, 4_000), (10e6, 1_500), (50e6, 700)] {
        let mut scene = table_i_scene(code(&[1, 1, 1, 0, 1, 0, 0]), 0.0, STEP_CHIPS);
        scene.detectors[0].background_rate_cps = (rate - 71e3) / 0.31;
        let (mean, variance) = markov_renewal(rate, 14e-9, 0.137, 5e-9);
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let response = MeanResponse::new(&model).expect("it can be solved");
        let of_chain = response.detection_rate_hz() * STEP_S;
        assert!((of_chain / mean - 1.0).abs() < 2e-6, "{of_chain} {mean}");
        let counts = totals(&scene, steps * scale);
        assert_moments(&format!("Table I, {rate:.0e} cps"), &counts, mean, variance);
    }
}

#[test]
fn dead_time_and_afterpulses_together_give_the_rate_of_the_markov_chain() {
    assert_table_i(10);
}

#[test]
#[ignore = "a hundred million detections per rate; run with --release"]
fn dead_time_and_afterpulses_do_so_over_a_hundred_million_detections() {
    assert_table_i(300);
}

/// Light whose edges meet the sign's, so that every detection counts up, less
/// what jitter and transition take to the wrong side. Mean signed count of so
/// many steps, over that without either.
fn share_that_counts_up(change: impl Fn(&mut Scene)) -> (f64, f64) {
    let mut scene = ideal_scene(code(&[1, 1, 0, 0]), 50e6, STEP_CHIPS);
    scene.scan.steps = 1;
    // Both edges of the reference come as late as the light.
    scene.detectors[0].delay_ps = 1_750.0;
    scene.detectors[0].counter.rising_delay_ps = 1_750.0;
    scene.detectors[0].counter.falling_delay_ps = 1_750.0;
    change(&mut scene);
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let counter = StepCounter::new(&model);
    assert_eq!(counter.outside_domain(), None, "the lanes must be used");
    let mut counts = vec![StepCount::ZERO; 2500];
    counter.count(6, 0..2500, 0..1, &mut counts);
    let signed = Moments::of(counts.iter().map(|count| count.signed as f64));
    let all = 50e6 * STEP_S;
    (signed.mean / all, signed.standard_error() / all)
}

#[test]
fn jitter_and_transition_cost_what_they_take_to_the_wrong_side() {
    // Two chips of light, 16 ns, have two edges; a wrong sign costs twice.
    let cost = |wrong_ps: f64| 1.0 - 2.0 * 2.0 * wrong_ps / 16_000.0;
    let (found, error) = share_that_counts_up(|_| ());
    assert_within_standard_errors((found - 1.0) / error, 3.0, "sharp");
    // The integral of Phi(-x / sigma) over x > 0 is sigma / sqrt(2 pi).
    let (found, error) = share_that_counts_up(|scene| {
        scene.detectors[0].jitter_ps = vec![120.0, 160.0];
    });
    let wrong_ps = 200.0 / (2.0 * std::f64::consts::PI).sqrt();
    assert_within_standard_errors((found - cost(wrong_ps)) / error, 3.0, "jitter");
    // Half of the detections within the transition.
    let (found, error) = share_that_counts_up(|scene| {
        scene.detectors[0].counter.transition_ps = 300.0;
    });
    assert_within_standard_errors((found - cost(150.0)) / error, 3.0, "transition");
}
