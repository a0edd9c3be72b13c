//! Scenes and statistics for the tests of optics and estimators, and detectors stepped through time.
//!
//! A package of its own, since it computes: it is optimised, which the tests are not.

pub mod compared;
pub mod naive;
pub mod recordings;
pub mod sequential;
pub mod stepped;

use std::collections::BTreeMap;
use std::sync::Arc;

use goldtof_physics::photons::{DetectorModel, Pulse, PulseStream};
use goldtof_sensor::code::{Code, Generator};
use goldtof_sensor::scan::{Sample, Step};
use goldtof_sensor::scene::{
    CounterTiming, Detector, DetectorIndex, EstimatorKind, Hardware, LaserResponse, OtherLight,
    Path, Scan, Scene, Source, SourceClock, SourceIndex,
};

/// How often a test repeats what it counts: as often as every change needs, or, where
/// `scripts/test --thorough` says so, as a release.
pub fn repeated(every_change: u64, release: u64) -> u64 {
    match std::env::var_os("GOLDTOF_THOROUGH") {
        None => every_change,
        Some(_) => release,
    }
}

/// Of each kind the first and every third behind it; all of them where `scripts/test --thorough` says so.
pub fn some_of_each<T>(all: &[T], kind: impl Fn(&T) -> &str) -> Vec<&T> {
    let apart = repeated(3, 1);
    let mut seen = BTreeMap::<String, u64>::new();
    let is_chosen = |one: &&T| {
        let before = seen.entry(kind(one).to_owned()).or_default();
        *before += 1;
        (*before - 1).is_multiple_of(apart)
    };
    all.iter().filter(is_chosen).collect()
}

pub fn code(chips: &[u8]) -> Arc<Code> {
    Arc::new(Code {
        generator: Generator::Chips(chips.to_vec()),
        interleave: 0,
        chips: chips.to_vec(),
    })
}

/// `c[t]` = XOR of `c[t - e]`, from all ones.
pub fn m_sequence(degree: usize, exponents: &[usize]) -> Vec<u8> {
    let length = (1 << degree) - 1;
    let mut chips = vec![1_u8; degree];
    for t in degree..length {
        chips.push(exponents.iter().fold(0, |sum, e| sum ^ chips[t - e]));
    }
    chips
}

/// Index 0 of a Gold set: u XOR v.
pub fn gold(degree: usize, u: &[usize], v: &[usize]) -> Arc<Code> {
    let (u, v) = (m_sequence(degree, u), m_sequence(degree, v));
    code(&u.iter().zip(&v).map(|(a, b)| a ^ b).collect::<Vec<_>>())
}

pub fn gold_5() -> Arc<Code> {
    gold(5, &[5, 2], &[5, 4, 3, 2])
}

/// As [`gold_11`], for what does not depend on a code's length: a sixteenth of the phase steps, and of
/// what they cost.
pub fn gold_7() -> Arc<Code> {
    gold(7, &[7, 3], &[7, 3, 2, 1])
}

/// The same, with a quarter of the phase steps.
pub fn gold_9() -> Arc<Code> {
    gold(9, &[9, 4], &[9, 6, 4, 3])
}

pub fn gold_11() -> Arc<Code> {
    gold(11, &[11, 2], &[11, 8, 5, 2])
}

/// Mean optical power for a mean primary detection rate at 783 nm and
/// detection probability 1.
pub fn power_w(mean_rate_cps: f64) -> f64 {
    mean_rate_cps * 6.626_070_15e-34 * 299_792_458.0 / 783e-9
}

pub fn full_scan(samples_per_chip: u32, code: &Code, integration_chips: u64) -> Scan {
    let steps = u64::from(samples_per_chip) * code.len();
    Scan {
        first_step: 0,
        steps,
        steps_per_period: steps,
        integration_chips,
        requested_integration_ps: integration_chips as f64 * 8000.0,
    }
}

/// One source, one path without delay, and a detector that adds nothing of its
/// own: no dead time, no afterpulses, no delay, no jitter, an ideal counter.
/// The chip period is 8 ns, a chip has 8 samples.
pub fn ideal_scene(code: Arc<Code>, mean_rate_cps: f64, integration_chips: u64) -> Scene {
    let scan = full_scan(8, &code, integration_chips);
    Scene {
        name: "ideal".to_owned(),
        origin: Default::default(),
        chip_period_ps: 8000.0,
        samples_per_chip: 8,
        sources: vec![Source {
            name: "laser".to_owned(),
            code,
            wavelength_nm: 783.0,
            mean_power_w: power_w(mean_rate_cps),
            extinction_ratio: f64::INFINITY,
            response: LaserResponse::Ideal,
            clock: SourceClock::default(),
        }],
        detectors: vec![Detector::ideal("spad", SourceIndex(0), 4000.0)],
        paths: vec![Path {
            source: SourceIndex(0),
            detector: DetectorIndex(0),
            delay_ps: 0.0,
            transmission: 1.0,
            movement: None,
        }],
        scan,
        estimator: EstimatorKind::Fft,
        other_light: OtherLight::Given,
        hardware: Hardware::default(),
        array: None,
    }
}

/// The sensor of Table I at 3.2 m, with another primary detection rate.
pub fn table_i_scene(code: Arc<Code>, mean_rate_cps: f64, integration_chips: u64) -> Scene {
    let mut scene = ideal_scene(code, mean_rate_cps / 0.31, integration_chips);
    scene.sources[0].extinction_ratio = 10.0;
    scene.paths[0].delay_ps = 2.0 * 3.2 / 299_792_458.0 * 1e12;
    let spad = &mut scene.detectors[0];
    spad.photon_detection_probability = 0.31;
    spad.dark_count_rate_cps = 71e3;
    spad.dead_time_ps = 14e3;
    spad.afterpulsing_probability = 0.137;
    spad.afterpulsing_time_constant_ps = 5e3;
    spad.pulse_width_ps = 7e3;
    spad.delay_ps = 1750.0;
    spad.jitter_ps = vec![53.5, 4.0];
    spad.counter =
        CounterTiming { rising_delay_ps: 340.0, falling_delay_ps: 390.0, transition_ps: 1.5 };
    scene
}

/// Signed counts of all steps of a scan, by the definition: hits at the first
/// sample of each pulse, the reference looked up at that sample. Hits are added
/// up by their sample in `hits`, modulo its length.
pub fn sampled_counts(
    scene: &Scene,
    model: &DetectorModel,
    seed: u64,
    repetition: u64,
    hits: &mut [f64],
) -> Vec<f64> {
    let Scan { steps, integration_chips, .. } = scene.scan;
    let chips = &scene.sources[0].code.chips;
    let step_samples = integration_chips * 8;
    let mut pulses = Vec::new();
    PulseStream::new(model, seed, repetition).advance(Sample(steps * step_samples), &mut pulses);
    let mut counts = vec![0.0; steps as usize];
    for Pulse { first: Sample(first), .. } in pulses {
        let step = first / step_samples;
        let k = scene.scan.phase_step(Step(step)) as i64;
        let chip = (first as i64 - k).div_euclid(8).rem_euclid(chips.len() as i64);
        counts[step as usize] += 2.0 * f64::from(chips[chip as usize]) - 1.0;
        let samples = hits.len() as u64;
        hits[(first % samples) as usize] += 1.0;
    }
    counts
}

/// Signed and total counts of the steps of one scan: the level is painted sample by
/// sample, and a high sample after a low one counts with the reference's sign there.
/// Hits are added up by their sample in `hits`, modulo its length.
pub fn painted_counts(
    scene: &Scene,
    model: &DetectorModel,
    seed: u64,
    hits: &mut [f64],
) -> Vec<[f64; 2]> {
    let per_chip = u64::from(scene.samples_per_chip);
    let steps = scene.scan.steps;
    let step_samples = scene.scan.integration_chips * per_chip;
    let mut pulses = Vec::new();
    PulseStream::new(model, seed, 0).advance(Sample(steps * step_samples), &mut pulses);
    let mut level = vec![false; (steps * step_samples) as usize];
    for Pulse { first, end } in pulses {
        let end = level.len().min(end.0 as usize);
        level[first.0 as usize..end].fill(true);
    }
    let chips = &scene.sources[0].code.chips;
    let mut counts = vec![[0.0; 2]; steps as usize];
    let mut before = false;
    for (sample, &high) in (0_u64..).zip(&level) {
        if high && !before {
            let step = sample / step_samples;
            let late = sample as i64 - scene.scan.phase_step(Step(step)) as i64;
            let chip = late.div_euclid(per_chip as i64);
            let chip = chip.rem_euclid(chips.len() as i64) as usize;
            counts[step as usize][0] += 2.0 * f64::from(chips[chip]) - 1.0;
            counts[step as usize][1] += 1.0;
            let place = sample % hits.len() as u64;
            hits[place as usize] += 1.0;
        }
        before = high;
    }
    counts
}

/// Mean and its standard error, and the variance, of a sample.
pub struct Moments {
    pub count: f64,
    pub mean: f64,
    pub variance: f64,
}

impl Moments {
    pub fn of(values: impl IntoIterator<Item = f64>) -> Moments {
        let values: Vec<f64> = values.into_iter().collect();
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        Moments { count, mean, variance: squares / (count - 1.0) }
    }

    pub fn standard_error(&self) -> f64 {
        (self.variance / self.count).sqrt()
    }

    /// How many standard errors the mean is away from a value.
    pub fn z(&self, expected: f64) -> f64 {
        (self.mean - expected) / self.standard_error()
    }

    /// How many standard errors the variance is away from a value, for a nearly
    /// Gaussian sample.
    pub fn variance_z(&self, expected: f64) -> f64 {
        (self.variance / expected - 1.0) / (2.0 / (self.count - 1.0)).sqrt()
    }
}

#[track_caller]
pub fn assert_within_standard_errors(z: f64, limit: f64, what: &str) {
    assert!(z.abs() < limit, "{what}: {z:.2} standard errors away");
}
