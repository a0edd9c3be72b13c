//! Photons to distance, many times: the JSON of `goldtof simulate`.

mod answers;
mod moments;
mod statistics;
mod text;

use std::time::Instant;

use serde::Serialize;

use super::scans::{Prepared, ScansError};
use super::{Tier, domain, expected};
use crate::cosim::engine::Engine;
use crate::document::Body;
use crate::estimate::{TheoryEffort, theory};
use crate::photons::StepCount;
use crate::scene::{DetectorIndex, EstimatorKind, PathIndex};
use crate::sensor::Sensor;

use answers::{Answers, Ranging};
use statistics::statistics;

/// Counts that wait for their estimates, about.
const COUNTS_AT_ONCE: usize = 1 << 21;

/// What a simulation gives.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Simulation {
    /// The scene's name.
    #[serde(skip)]
    pub scene: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// How much of the sensor was simulated.
    pub fidelity: Tier,
    /// How distances were got from counts.
    pub estimator: EstimatorKind,
    /// For which scenes and questions its answers hold.
    pub domain: &'static str,
    /// Where this scene is outside of that, and what it does to the answer.
    pub warnings: Vec<String>,
    /// Scans simulated; none by the tier that draws nothing.
    pub repetitions: u64,
    /// One entry per detector and path: those of the detector's own source, and
    /// with `estimator` model all whose light the fit takes in.
    pub estimates: Vec<PathStatistics>,
    /// Wall time.
    pub run_time_s: f64,
}

impl Body for Simulation {
    const NAME: &'static str = "simulate";
}

/// Statistics of the estimates that a detector's scans give of one path.
///
/// A repetition counts for the path nearest to its estimate, if that is within a
/// chip of it; mean and scatter are over the repetitions that count for the path.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PathStatistics {
    /// Name of the detector.
    pub detector: String,
    /// Name of the source whose light the path carries.
    pub source: String,
    /// Index of the path in the scene.
    pub path: PathIndex,
    /// True distance, folded into the unambiguous range; without a fluctuation,
    /// whose effect belongs to the scatter.
    pub true_distance_m: f64,
    /// When a path that moves has it, from the start of the scan: as the scan comes
    /// by the path. None for a path that stands still.
    pub true_distance_at_s: Option<f64>,
    /// Repetitions that count for the path.
    pub estimates: u64,
    /// Repetitions that miss the path: no estimate within a chip of it (of a code of
    /// fewer than four chips, within a quarter of its period;
    /// [`crate::estimate::tolerance_ps`]), or another path is nearer.
    pub missed_scans: u64,
    /// Their share of all repetitions; of the tier that draws nothing the expected
    /// share. None where that cannot be told.
    pub missed_fraction: Option<f64>,
    /// Its 95 % confidence interval (Wilson); none without repetitions.
    pub missed_fraction_ci95: Option<[f64; 2]>,
    /// The share that the exact moments of the counts give, by the same definition.
    /// None where it cannot be told (the model estimator with several paths).
    pub expected_missed_fraction: Option<f64>,
    /// One less `missed_fraction`: how often the coarse stage is right.
    pub correct_coarse_fraction: Option<f64>,
    /// Mean estimate, folded into the unambiguous range; none without estimates, or
    /// where they are spread all over the range ([`crate::estimate::unwrap`]).
    pub mean_distance_m: Option<f64>,
    /// Mean error, the shorter way round the unambiguous range. Errors are taken
    /// round their circular mean, and so is `std_m`.
    pub bias_m: Option<f64>,
    /// Standard deviation of one scan's estimate; none below two estimates.
    pub std_m: Option<f64>,
    /// Standard error of `mean_distance_m` and `bias_m`.
    pub bias_std_error_m: Option<f64>,
    /// Standard error of `std_m`, for normal errors, or larger where their fourth
    /// moment says so.
    pub std_std_error_m: Option<f64>,
    /// The bias that the exact mean response gives: the estimator's answer to
    /// the expected counts.
    pub expected_bias_m: Option<f64>,
    /// The standard deviation that it gives.
    pub expected_std_m: Option<f64>,
    /// Cramer-Rao bound: the least standard deviation of any unbiased estimate
    /// from these counts ([`crate::estimate::bound`]).
    pub bound_m: Option<f64>,
    /// `std_m` in bounds.
    pub std_over_bound: Option<f64>,
    /// Why there is no bound, where that is so.
    pub bound_remark: Option<String>,
    /// Share of this detector's fits whose chi-square says that the light or the
    /// detector is not as modelled; none for the phase estimator.
    pub chi_square_alarm_fraction: Option<f64>,
    /// Rate of counted detections.
    pub detected_rate_cps: f64,
    /// Why there is no fine estimate, where that is so.
    pub remark: Option<String>,
}

/// Simulates a scene's detectors, `repetitions` scans each, and estimates with
/// the scene's estimator.
///
/// # Errors
/// When the tier cannot do the scene.
pub fn simulate(
    sensor: &Sensor,
    tier: Tier,
    seed: u64,
    repetitions: u64,
) -> Result<Simulation, ScansError> {
    simulate_with(sensor, tier, Engine::Auto, seed, repetitions)
}

/// [`simulate`], with a way to clock the Verilog where the tier does.
///
/// # Errors
/// When the tier cannot do the scene.
pub fn simulate_with(
    sensor: &Sensor,
    tier: Tier,
    engine: Engine,
    seed: u64,
    repetitions: u64,
) -> Result<Simulation, ScansError> {
    simulate_watched(sensor, tier, engine, seed, repetitions, |_, _| ())
}

/// [`simulate_with`]; `on_progress` hears of each scan, in order, how many are done and
/// how many there are, of all detectors. If it unwinds, the simulation ends there, and
/// leaves nothing behind.
///
/// # Errors
/// When the tier cannot do the scene.
pub fn simulate_watched(
    sensor: &Sensor,
    tier: Tier,
    engine: Engine,
    seed: u64,
    repetitions: u64,
    on_progress: impl FnMut(u64, u64),
) -> Result<Simulation, ScansError> {
    let started = Instant::now();
    let prepared = Prepared::with_engine(sensor, tier, engine)?;
    let simulation = simulate_counting(sensor, &prepared, seed, repetitions, on_progress)?;
    Ok(Simulation {
        run_time_s: started.elapsed().as_secs_f64(),
        ..simulation
    })
}

/// [`simulate`] with a tier that was prepared for the scene before, which is not in
/// the run time.
///
/// # Errors
/// When the tier cannot do the scene.
pub(crate) fn simulate_prepared(
    sensor: &Sensor,
    prepared: &Prepared,
    seed: u64,
    repetitions: u64,
) -> Result<Simulation, ScansError> {
    simulate_counting(sensor, prepared, seed, repetitions, |_, _| ())
}

fn simulate_counting(
    sensor: &Sensor,
    prepared: &Prepared,
    seed: u64,
    repetitions: u64,
    mut on_progress: impl FnMut(u64, u64),
) -> Result<Simulation, ScansError> {
    let started = Instant::now();
    let tier = prepared.tier();
    let all = repetitions.saturating_mul(sensor.scene().detectors.len() as u64);
    let mut done = 0;
    let mut estimates = Vec::new();
    let mut warnings = Vec::new();
    for detector in DetectorIndex::of(&sensor.scene().detectors) {
        if !tier.draws() {
            // Before anything that takes as long as there are steps or paths.
            TheoryEffort::of(sensor, detector)?.check_predictions(1)?;
        }
        let ranging = Ranging::new(sensor, detector, tier.counting());
        let mut answers = Answers::new(&ranging);
        let mut detections = 0;
        let mut waiting: Vec<StepCount> = Vec::new();
        let remarks = prepared.scans(sensor, detector, seed, repetitions, |counts| {
            done += 1;
            on_progress(done, all);
            detections += counts.iter().map(|count| count.total).sum::<u64>();
            waiting.extend_from_slice(counts);
            if waiting.len() + counts.len() > COUNTS_AT_ONCE {
                answers.take(&waiting);
                waiting.clear();
            }
        })?;
        // Every detector's scans run the whole hardware.
        if detector == DetectorIndex(0) {
            warnings.extend(remarks);
        }
        answers.take(&waiting);
        let integration_s = sensor.timing().integration_ps() * 1e-12;
        let measured_s = repetitions as f64 * sensor.timing().scan.steps as f64 * integration_s;
        let rate_cps = detections as f64 / measured_s;
        let theory = theory(sensor, detector, &ranging.paths, tier.counting());
        let mut of_detector = statistics(&ranging, &answers, &theory, rate_cps);
        if !tier.draws() {
            expected::answer(sensor, detector, &theory, &mut of_detector)?;
        }
        estimates.extend(of_detector);
        let predicted = ranging.paths.iter().copied().zip(theory.predictions);
        let predicted: Vec<_> = predicted.collect();
        warnings.extend(domain::warnings(sensor, detector, tier, &predicted));
    }
    Ok(Simulation {
        scene: sensor.scene().name.clone(),
        seed,
        fidelity: tier,
        domain: domain::of(tier),
        warnings,
        estimator: sensor.scene().estimator,
        repetitions: if tier.draws() { repetitions } else { 0 },
        estimates,
        run_time_s: started.elapsed().as_secs_f64(),
    })
}
