//! What cases read off the program: counts, expectations, estimates, verdicts. A test puts
//! readings of nothing in their place, which no case may take for right.

use std::ops::Range;

use super::case::CaseError;
use crate::code::correlate;
use crate::door::Jobs as _;
use crate::estimate::{
    CountingTier, Estimate, NoEstimate, Prediction, PredictionError, estimate, predict,
};
use crate::image::{ImageOptions, image};
use crate::light::{photon_rate_hz, round_trip_ps};
use crate::math::SampleStatistics;
use crate::photons::fast::StepCounter;
use crate::photons::{Detection, DetectorModel, StepCount, count_step};
use crate::response::{CountSampler, MeanCount, MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::{Group, Step};
use crate::scene::{Detector, DetectorIndex, PathIndex, Scene, SceneErrors, Setting, parse_with};
use crate::sensor::Sensor;
use crate::simulate::Tier;
use crate::simulate::repeat::Simulation;
use crate::simulate::scans::scans;

/// Readings in which there is nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(not(test), expect(dead_code, reason = "tests alone read nothing"))]
pub(super) enum Nothing {
    /// Every number is 0, every verdict "no".
    Zeros,
    /// Every number that can be is undefined, every verdict "yes".
    Undefined,
    /// There are no numbers.
    Empty,
}

#[cfg(test)]
thread_local! {
    /// What every reading of this thread is, in place of what it should be.
    pub(super) static NOTHING: std::cell::Cell<Option<Nothing>> = const { std::cell::Cell::new(None) };
}

/// What is read in place of anything.
pub(super) fn nothing() -> Option<Nothing> {
    #[cfg(test)]
    return NOTHING.get();
    #[cfg(not(test))]
    None
}

/// Some numbers, `length` of them where they are nothing.
fn some<T: Clone>(
    length: usize,
    [zero, undefined]: [T; 2],
    read: impl FnOnce() -> Vec<T>,
) -> Vec<T> {
    match nothing() {
        None => read(),
        Some(Nothing::Zeros) => vec![zero; length],
        Some(Nothing::Undefined) => vec![undefined; length],
        Some(Nothing::Empty) => Vec::new(),
    }
}

fn some_counts(length: usize, read: impl FnOnce() -> Vec<StepCount>) -> Vec<StepCount> {
    some(length, [StepCount::ZERO; 2], read)
}

/// What the pixels of a scene's array are off from what is expected of them, in standard
/// deviations; and how many times the light of the darkest the brightest has.
pub(super) fn deviations_of_pixels(scene: &Scene, seed: u64) -> Result<(Vec<f64>, f64), CaseError> {
    // What is not read need not be simulated.
    let fidelity = if nothing().is_some() { Tier::Expected } else { Tier::Events };
    let options = ImageOptions { fidelity, seed, ..ImageOptions::default() };
    let image = image(&Sensor::new(scene), &options, None, |_| ())?;
    let theory = image.theory.ok_or("there is no theory")?;
    let errors_m = image.measured.bias_m.values.iter();
    let known = theory.pixels.iter().zip(errors_m).filter_map(|(expected, error_m)| {
        let expected = expected.as_ref().filter(|_| error_m.is_finite())?;
        Some((error_m - expected.bias_m) / expected.std_m)
    });
    let known: Vec<f64> = known.collect();
    let lit = || image.seen.lit().map(|pixel| image.seen.own_primary_hz[pixel]);
    let span = lit().fold(0.0, f64::max) / lit().fold(f64::INFINITY, f64::min);
    Ok((some(known.len(), [0.0, f64::NAN], || known), span))
}

/// The detector of a scene.
pub(super) fn model(scene: &Scene) -> DetectorModel {
    DetectorModel::new(&Sensor::new(scene), DetectorIndex(0))
}

/// Counts of the first `steps` steps of the first scan, each photon simulated.
pub(super) fn counts(scene: &Scene, steps: u64, seed: u64) -> Vec<StepCount> {
    counts_of_scans(scene, 0..1, steps, seed)
}

/// Counts of the first `steps` steps of some scans.
pub(super) fn counts_of_scans(
    scene: &Scene,
    repetitions: Range<u64>,
    steps: u64,
    seed: u64,
) -> Vec<StepCount> {
    let length = ((repetitions.end - repetitions.start) * steps) as usize;
    some_counts(length, || {
        let mut counts = vec![StepCount::ZERO; length];
        StepCounter::new(&model(scene)).count(seed, repetitions, 0..steps, &mut counts);
        counts
    })
}

/// Total counts of the first `steps` steps of the first scan.
pub(super) fn totals(scene: &Scene, steps: u64, seed: u64) -> SampleStatistics {
    of_totals(&counts(scene, steps, seed))
}

/// Total counts.
pub(super) fn of_totals(counts: &[StepCount]) -> SampleStatistics {
    SampleStatistics::of(counts.iter().map(|count| count.total as f64))
}

/// Standard errors of their mean from that of a rate of detections.
pub(super) fn rate_z(scene: &Scene, steps: u64, seed: u64, rate_cps: f64) -> f64 {
    totals(scene, steps, seed).z(rate_cps * step_s(scene))
}

/// Standard errors of the mean signed count of so many scans of one phase step from an expected
/// one.
pub(super) fn signed_z(scene: &Scene, scans: u64, seed: u64, expected: f64) -> f64 {
    let found = counts_of_scans(scene, 0..scans, 1, seed);
    SampleStatistics::of(found.iter().map(|count| count.signed as f64)).z(expected)
}

/// Counts of the first `steps` steps of a scan by the plain loop.
pub(super) fn plain_counts(
    scene: &Scene,
    repetition: u64,
    steps: u64,
    seed: u64,
) -> Vec<StepCount> {
    some_counts(steps as usize, || {
        let model = model(scene);
        Step::all(steps).map(|step| count_step(&model, seed, repetition, step)).collect()
    })
}

/// The first detections of the second step of the first scan, `number` at most.
pub(super) fn detections(scene: &Scene, number: usize, seed: u64) -> Vec<Detection> {
    let none = Detection { chip: 0, fraction: 0.0 };
    let undefined = Detection { chip: 0, fraction: f64::NAN };
    some(number, [none, undefined], || model(scene).step(seed, 0, Group(1)).take(number).collect())
}

/// Expected counts of every step.
pub(super) fn mean_counts(scene: &Scene) -> Result<Vec<MeanCount>, MeanResponseError> {
    let steps = scene.scan.steps as usize;
    let [zero, undefined] = [0.0, f64::NAN].map(|value| MeanCount { signed: value, total: value });
    let model = model(scene);
    let means = || Ok(MeanResponse::of_tier(&model, CountingTier::Events)?.mean_counts());
    match nothing() {
        None => means(),
        Some(_) => Ok(some(steps, [zero, undefined], Vec::new)),
    }
}

/// Expected counts of one step, which are not taken from those of all.
pub(super) fn mean_count(scene: &Scene, step: Step) -> Result<MeanCount, CaseError> {
    let [zero, undefined] = [0.0, f64::NAN].map(|value| MeanCount { signed: value, total: value });
    let model = model(scene);
    let response = MeanResponse::of_tier(&model, CountingTier::Events)?;
    let means = some(1, [zero, undefined], || vec![response.mean_count(step)]);
    means.first().copied().ok_or_else(|| "nothing is expected".into())
}

/// Mean and variance that are expected of the total count of one step.
pub(super) fn moments_of_total(scene: &Scene, step: Step) -> Result<[f64; 2], CaseError> {
    let model = model(scene);
    let response = MeanResponse::of_tier(&model, CountingTier::Events)?;
    let moments = SecondMoments::new(&response)?.of_step(step);
    let read = || vec![[moments.total_mean, moments.total_variance]];
    let moments = some(1, [[0.0; 2], [f64::NAN; 2]], read);
    moments.first().copied().ok_or_else(|| "nothing is expected".into())
}

/// What is expected of a scene's first path, by a tier.
pub(super) fn predicted(scene: &Scene, tier: CountingTier) -> Result<Prediction, PredictionError> {
    let prediction = || predict(&Sensor::new(scene), DetectorIndex(0), PathIndex(0), tier);
    match nothing() {
        None => prediction(),
        Some(Nothing::Empty) => Err(PredictionError::Flat),
        Some(empty) => {
            let value = if empty == Nothing::Zeros { 0.0 } else { f64::NAN };
            Ok(Prediction { bias_m: value, std_m: value, ..prediction()? })
        }
    }
}

/// The estimate from some counts, in phase order.
pub(super) fn estimated(scene: &Scene, counts: &[i64]) -> Result<Estimate, NoEstimate> {
    let zeros = vec![0; counts.len()];
    let counts = if nothing().is_some() { &zeros } else { counts };
    estimate(&scene.timing(), counts, 0.0)
}

/// Scans of a tier, one after another.
pub(super) fn scanned(
    sensor: &Sensor,
    tier: Tier,
    seed: u64,
    number: u64,
) -> Result<Vec<Vec<StepCount>>, CaseError> {
    let steps = sensor.timing().scan.steps as usize;
    if nothing().is_some() {
        let scan = some_counts(steps, Vec::new);
        return Ok(some(number as usize, [scan.clone(), scan], Vec::new));
    }
    let mut found = Vec::new();
    scans(sensor, DetectorIndex(0), tier, seed, number, |counts| found.push(counts.to_vec()))?;
    Ok(found)
}

/// A scan that is drawn.
pub(super) fn drawn(sampler: &CountSampler, steps: usize, seed: u64, scan: u64) -> Vec<StepCount> {
    some_counts(steps, || sampler.scan(seed, scan))
}

/// Statistics of simulated scans.
pub(super) fn simulated(
    scene: &Scene,
    tier: Tier,
    seed: u64,
    scans: u64,
) -> Result<Simulation, CaseError> {
    let simulation = |scans| Sensor::new(scene).simulate(tier.scans(scans).seeded(seed));
    match nothing() {
        None => Ok(simulation(scans)?),
        Some(nothing) => {
            let mut simulation = simulation(1)?;
            let value = (nothing == Nothing::Zeros).then_some(0.0);
            let value = if nothing == Nothing::Undefined { Some(f64::NAN) } else { value };
            for path in &mut simulation.estimates {
                path.estimates = 0;
                for number in [
                    &mut path.mean_distance_m,
                    &mut path.bias_m,
                    &mut path.bias_std_error_m,
                    &mut path.std_m,
                ] {
                    *number = value;
                }
            }
            Ok(simulation)
        }
    }
}

/// The periodic correlation of two codes.
pub(super) fn correlation(a: &[u8], b: &[u8]) -> Vec<i64> {
    some(a.len(), [0; 2], || correlate(a, b))
}

/// Numbers that were worked out.
pub(super) fn numbers(values: Vec<f64>) -> Vec<f64> {
    some(values.len(), [0.0, f64::NAN], || values)
}

/// Why something is refused, if it is.
pub(super) fn refusal(read: impl FnOnce() -> Option<String>) -> Option<String> {
    match nothing() {
        None => read(),
        Some(nothing) => (nothing == Nothing::Undefined).then(String::new),
    }
}

/// Whether something was refused, or said.
pub(super) fn verdict(is_so: bool) -> bool {
    match nothing() {
        None => is_so,
        Some(nothing) => nothing == Nothing::Undefined,
    }
}

/// A sensor that adds nothing of its own: no dead time, no afterpulses, no
/// delay, no jitter, no edges; one path without delay, every photon detected.
/// `code` is the right-hand side of the key, `rate_cps` the mean rate of photons.
pub(super) fn ideal(
    code: &str,
    samples_per_chip: u32,
    rate_cps: f64,
    integration_chips: u64,
) -> Result<Scene, SceneErrors> {
    ideal_with(code, samples_per_chip, rate_cps, integration_chips, &[])
}

/// [`ideal`] with some keys set.
pub(super) fn ideal_with(
    code: &str,
    samples_per_chip: u32,
    rate_cps: f64,
    integration_chips: u64,
    settings: &[Setting],
) -> Result<Scene, SceneErrors> {
    let integration_ns = 8 * integration_chips;
    let text = format!(
        r#"
[clock]
chip_period = "8 ns"
samples_per_chip = {samples_per_chip}

[[source]]
name = "laser"
code = {code}
wavelength = "783 nm"
mean_power = "{power_w:e} W"
extinction_ratio = "inf"

[[detector]]
name = "spad"
reference = "laser"

[[path]]
source = "laser"
detector = "spad"
delay = "0 ns"

[scan]
integration = "{integration_ns} ns"
"#,
        power_w = rate_cps / photon_rate_hz(1.0, 783.0),
    );
    parse_with("ideal.toml", &text, settings)
}

/// The detector of Table I at 3.2 m, at a mean primary rate of `rate_cps`.
pub(super) fn table_i(
    code: &str,
    rate_cps: f64,
    integration_chips: u64,
) -> Result<Scene, SceneErrors> {
    let detector = crate::study::table_i_detector();
    let photons_cps = rate_cps / detector.photon_detection_probability;
    let mut scene = ideal(code, 8, photons_cps, integration_chips)?;
    scene.sources[0].extinction_ratio = 10.0;
    scene.paths[0].delay_ps = round_trip_ps(3.2);
    scene.detectors[0] = detector;
    Ok(scene)
}

/// A Gold code of 31 chips.
pub(super) const GOLD_5: &str = r#"{ family = "gold", degree = 5 }"#;
/// A Gold code of 2,047 chips.
pub(super) const GOLD_11: &str = r#"{ family = "gold", degree = 11 }"#;

/// Ideal scene under background only: `rate_cps` of background on a detector that `set` changes.
pub(super) fn constant_light(
    rate_cps: f64,
    integration_chips: u64,
    set: impl FnOnce(&mut Detector),
) -> Result<Scene, SceneErrors> {
    let mut scene = ideal(GOLD_5, 8, 0.0, integration_chips)?;
    scene.detectors[0].background_rate_cps = rate_cps;
    set(&mut scene.detectors[0]);
    Ok(scene)
}

/// The ideal sensor in light of 10 Mcps, with a scan of one phase step.
pub(super) fn lit_step(
    code: &str,
    samples_per_chip: u32,
    integration_chips: u64,
    step: u64,
) -> Result<Scene, SceneErrors> {
    let mut scene = ideal(code, samples_per_chip, 10e6, integration_chips)?;
    window(&mut scene, step, 1);
    Ok(scene)
}

/// A scan of the `steps` phase steps from `first` on.
pub(super) fn window(scene: &mut Scene, first: u64, steps: u64) {
    scene.scan.first_step = first;
    scene.scan.steps = steps;
}

/// How many of some counts have counted anything.
pub(super) fn seen(counts: &[StepCount]) -> usize {
    counts.iter().filter(|count| count.total > 0).count()
}

/// How many counts of two runs differ.
pub(super) fn differing(a: &[StepCount], b: &[StepCount]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count() + a.len().abs_diff(b.len())
}

/// Integration time per phase step.
pub(super) fn step_s(scene: &Scene) -> f64 {
    scene.timing().integration_ps() * 1e-12
}
