//! Photons to distance, many times: the JSON of `goldtof simulate`.

mod answers;
mod moments;
mod statistics;
mod text;

use std::time::Instant;

use serde::Serialize;

use super::path_statistics::PathStatistics;
use super::scans::{Prepared, ScansError};
use super::{Tier, domain, expected};
use crate::cosim::engine::Engine;
use crate::document::Body;
use crate::estimate::{CountingTier, TheoryEffort, theory};
use crate::histogram::Histogram;
use crate::photons::StepCount;
use crate::scene::{Architecture, DetectorIndex, EstimatorKind};
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
    let run = Run {
        sensor,
        prepared,
        seed,
        repetitions,
    };
    let all = repetitions.saturating_mul(sensor.scene().detectors.len() as u64);
    let mut done = 0;
    let mut on_scan = || {
        done += 1;
        on_progress(done, all);
    };
    let mut estimates = Vec::new();
    let mut warnings = Vec::new();
    for detector in DetectorIndex::of(&sensor.scene().detectors) {
        if !tier.draws() {
            // Before anything that takes as long as there are steps or paths.
            TheoryEffort::of(sensor, detector)?.check_predictions(1)?;
        }
        let of_detector = match sensor.scene().hardware.architecture {
            Architecture::UpDown => run.of_counts(detector, &mut on_scan)?,
            Architecture::Histogram => run.of_histograms(detector, &mut on_scan)?,
        };
        // Every detector's scans run the whole hardware.
        if detector == DetectorIndex(0) {
            warnings.extend(of_detector.remarks);
        }
        warnings.extend(of_detector.warnings);
        estimates.extend(of_detector.estimates);
    }
    Ok(Simulation {
        scene: sensor.scene().name.clone(),
        seed,
        fidelity: tier,
        domain: domain::of(tier, sensor.scene().hardware.architecture),
        warnings,
        estimator: sensor.scene().estimator,
        repetitions: if tier.draws() { repetitions } else { 0 },
        estimates,
        run_time_s: started.elapsed().as_secs_f64(),
    })
}

/// Scans to simulate.
struct Run<'a> {
    sensor: &'a Sensor,
    prepared: &'a Prepared,
    seed: u64,
    repetitions: u64,
}

/// What the scans of one detector say.
struct OfDetector {
    estimates: Vec<PathStatistics>,
    warnings: Vec<String>,
    /// What the Verilog was not made to show.
    remarks: Vec<String>,
}

impl Run<'_> {
    /// Scans of counts, phase step by phase step.
    fn of_counts(
        &self,
        detector: DetectorIndex,
        on_scan: &mut impl FnMut(),
    ) -> Result<OfDetector, ScansError> {
        let sensor = self.sensor;
        let ranging = Ranging::new(sensor, detector, self.prepared.tier().counting());
        let mut answers = Answers::new(&ranging);
        let mut detections = 0;
        let mut waiting: Vec<StepCount> = Vec::new();
        let (seed, repetitions) = (self.seed, self.repetitions);
        let remarks = self
            .prepared
            .scans(sensor, detector, seed, repetitions, |counts| {
                on_scan();
                detections += counts.iter().map(|count| count.total).sum::<u64>();
                waiting.extend_from_slice(counts);
                if waiting.len() + counts.len() > COUNTS_AT_ONCE {
                    answers.take(&waiting);
                    waiting.clear();
                }
            })?;
        answers.take(&waiting);
        let steps = sensor.timing().scan.steps as f64;
        self.statistics(&ranging, &answers, detections, steps, remarks)
    }

    /// Scans that are histograms. Each tier counts as the hardware does.
    fn of_histograms(
        &self,
        detector: DetectorIndex,
        on_scan: &mut impl FnMut(),
    ) -> Result<OfDetector, ScansError> {
        let sensor = self.sensor;
        let ranging = Ranging::new(sensor, detector, CountingTier::Sampled);
        let mut answers = Answers::new(&ranging);
        let mut detections = 0;
        let mut waiting: Vec<Histogram> = Vec::new();
        let (seed, repetitions) = (self.seed, self.repetitions);
        let keep = |histogram: Histogram| {
            on_scan();
            detections += histogram.total();
            let bins = histogram.bins().len();
            waiting.push(histogram);
            if waiting.len() * bins > COUNTS_AT_ONCE {
                answers.take_histograms(&waiting);
                waiting.clear();
            }
        };
        let remarks = self
            .prepared
            .histograms(sensor, detector, seed, repetitions, keep)?;
        answers.take_histograms(&waiting);
        let mut of_detector = self.statistics(&ranging, &answers, detections, 1.0, remarks)?;
        if sensor.scene().estimator == EstimatorKind::Fft {
            let name = &sensor.scene().detectors[detector].name;
            let walks = ranging.walks().map(|walks| format!("{name}: {walks}"));
            of_detector.warnings.extend(walks);
        }
        Ok(of_detector)
    }

    /// The statistics of all scans, each of which has integrated so many times.
    fn statistics(
        &self,
        ranging: &Ranging,
        answers: &Answers,
        detections: u64,
        integrations: f64,
        remarks: Vec<String>,
    ) -> Result<OfDetector, ScansError> {
        let (sensor, detector, tier) = (self.sensor, ranging.detector, self.prepared.tier());
        let integration_s = sensor.timing().integration_ps() * 1e-12;
        let measured_s = self.repetitions as f64 * integrations * integration_s;
        let rate_cps = detections as f64 / measured_s;
        let theory = theory(sensor, detector, &ranging.paths, ranging.counting);
        let mut estimates = statistics(ranging, answers, &theory, rate_cps);
        if !tier.draws() {
            expected::answer(sensor, detector, &theory, &mut estimates)?;
        }
        let predicted = ranging.paths.iter().copied().zip(theory.predictions);
        let predicted: Vec<_> = predicted.collect();
        Ok(OfDetector {
            estimates,
            warnings: domain::warnings(sensor, detector, tier, &predicted),
            remarks,
        })
    }
}
