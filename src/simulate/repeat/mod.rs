//! Photons to distance, many times: the JSON of `goldtof simulate`.

mod answers;
mod moments;
mod statistics;
mod tally;
mod text;

use std::ops::Range;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::path_statistics::PathStatistics;
use super::scans::{PreparedTier, ScansError};
use super::{SimulateOptions, Tier, domain, expected};
use crate::cosim::StimulusKind;
use crate::cosim::exercised::{Exercised, missing};
use crate::estimate::estimator::EstimatorInput;
use crate::estimate::evidence::Comparisons;
use crate::estimate::{TheoryEffort, Work, theory};
use crate::histogram::Histogram;
use crate::photons::StepCount;
use crate::progress::Progress;
use crate::scene::{Architecture, DetectorIndex, EstimatorKind};
use crate::sensor::Sensor;

pub(crate) use answers::Ranging;
use statistics::statistics;
pub use tally::ScanTally;

/// Counts that wait for their estimates, about.
const COUNTS_AT_ONCE: usize = 1 << 21;

/// What a simulation gives.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
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

impl Simulation {
    /// Whether no scans contradict what is expected of them.
    pub fn is_as_expected(&self) -> bool {
        self.estimates.iter().all(|path| path.expectation_holds != Some(false))
    }
}

/// What the scans of a stretch say, detector by detector.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Gathered {
    /// For each detector what its scans say of its paths.
    pub tallies: Vec<ScanTally>,
    /// What the Verilog was made to show, where it is simulated.
    pub exercised: Option<Exercised>,
    /// Wall time.
    pub run_time_s: f64,
}

impl Gathered {
    /// Takes the stretch that follows.
    pub fn append(&mut self, later: Gathered) {
        self.run_time_s += later.run_time_s;
        match (&mut self.exercised, later.exercised) {
            (Some(exercised), Some(more)) => exercised.append(&more),
            (None, more) => self.exercised = more,
            (Some(_), None) => {}
        }
        for (tally, more) in self.tallies.iter_mut().zip(later.tallies) {
            tally.append(more);
        }
    }
}

/// A sensor that is simulated scan by scan, with its scene's estimator: what the scans say is
/// gathered, all at once or stretch by stretch, and concluded from in the end.
pub struct Simulated<'a> {
    sensor: &'a Sensor,
    options: SimulateOptions,
    /// For each detector.
    rangings: Vec<Ranging<'a>>,
    /// The comparisons of scans with expectations that it belongs to.
    family: Comparisons,
}

impl<'a> Simulated<'a> {
    /// A sensor, and how it is simulated.
    ///
    /// # Errors
    /// When what the tier that draws nothing has to work out takes too long.
    pub fn new(sensor: &'a Sensor, options: SimulateOptions) -> Result<Simulated<'a>, ScansError> {
        let tier = options.fidelity;
        let detectors = || DetectorIndex::of(&sensor.scene().detectors);
        if !tier.draws() {
            // Before anything that takes as long as there are steps or paths.
            for detector in detectors() {
                TheoryEffort::of(sensor, detector)?.check(Work::Predictions(1))?;
            }
        }
        let counting = tier.counting(sensor);
        let ranging = |detector| Ranging::new(sensor, detector, counting);
        let family = Comparisons::of_paths(sensor.scene().paths.len());
        Ok(Simulated { sensor, options, rangings: detectors().map(ranging).collect(), family })
    }

    /// The same as one of so many simulations whose scans are held against expectations
    /// together.
    pub fn one_of(self, simulations: usize) -> Simulated<'a> {
        Simulated { family: self.family.one_of(simulations), ..self }
    }

    /// All scans, and what they say. What prepared the tier is not in the run time.
    ///
    /// # Errors
    /// When the tier cannot do the scene.
    pub fn simulate(
        &self,
        prepared: &PreparedTier,
        on_progress: &mut dyn FnMut(Progress),
    ) -> Result<Simulation, ScansError> {
        self.conclude(self.gather(prepared, 0..self.options.repetitions, on_progress)?)
    }

    /// What is gathered of no scans.
    pub fn nothing(&self) -> Gathered {
        let of_detector = |ranging: &Ranging| ScanTally::of_paths(ranging.paths.len());
        Gathered {
            tallies: self.rangings.iter().map(of_detector).collect(),
            exercised: None,
            run_time_s: 0.0,
        }
    }

    /// Simulates some scans of every detector, by their numbers among all of the seed, with
    /// the tier prepared. `on_progress` hears of each scan, in order.
    ///
    /// # Errors
    /// When the tier cannot do the scene.
    pub fn gather(
        &self,
        prepared: &PreparedTier,
        scans: Range<u64>,
        on_progress: &mut dyn FnMut(Progress),
    ) -> Result<Gathered, ScansError> {
        let started = Instant::now();
        let of = (scans.end - scans.start).saturating_mul(self.rangings.len() as u64);
        let mut done = 0;
        let mut on_scan = || {
            done += 1;
            on_progress(Progress::Parts { done, of });
        };
        let mut gathered = Gathered { tallies: Vec::new(), exercised: None, run_time_s: 0.0 };
        for ranging in &self.rangings {
            let (tally, exercised) =
                of_scans(ranging, prepared, self.options.seed, scans.clone(), &mut on_scan)?;
            // Every detector's scans run the whole hardware.
            if ranging.detector == DetectorIndex(0) {
                gathered.exercised = exercised;
            }
            gathered.tallies.push(tally);
        }
        gathered.run_time_s = started.elapsed().as_secs_f64();
        Ok(gathered)
    }

    /// What all scans say, beside what is expected. Its run time is that of the gathering,
    /// and its own.
    ///
    /// # Errors
    /// When the tier that draws nothing cannot do the scene.
    pub fn conclude(&self, gathered: Gathered) -> Result<Simulation, ScansError> {
        let started = Instant::now();
        let scene = self.sensor.scene();
        let tier = self.options.fidelity;
        let mut estimates = Vec::new();
        let mut warnings = self.not_shown(gathered.exercised.as_ref());
        for (ranging, tally) in self.rangings.iter().zip(&gathered.tallies) {
            let of_detector = self.statistics(ranging, tally)?;
            warnings.extend(of_detector.warnings);
            estimates.extend(of_detector.estimates);
        }
        Ok(Simulation {
            scene: scene.name.clone(),
            seed: self.options.seed,
            fidelity: tier,
            domain: domain::of(tier, scene.hardware.architecture),
            warnings,
            estimator: scene.estimator,
            repetitions: gathered.tallies.first().map_or(0, |tally| tally.scans),
            estimates,
            run_time_s: gathered.run_time_s + started.elapsed().as_secs_f64(),
        })
    }

    /// What the Verilog was not made to show, where it is simulated.
    fn not_shown(&self, exercised: Option<&Exercised>) -> Vec<String> {
        let interface = self.sensor.interface();
        let missing = exercised.map(|shown| missing(shown, interface, StimulusKind::Photons));
        let missing = missing.into_iter().flatten();
        missing
            .map(|missing| {
                format!("the Verilog is not shown to count as the model does: {missing}")
            })
            .collect()
    }

    /// The statistics of all scans of a detector.
    fn statistics(&self, ranging: &Ranging, tally: &ScanTally) -> Result<OfDetector, ScansError> {
        let (sensor, detector) = (self.sensor, ranging.detector);
        let architecture = sensor.scene().hardware.architecture;
        let integrations = match architecture {
            Architecture::UpDown => sensor.timing().scan.steps as f64,
            Architecture::Histogram => 1.0,
        };
        let integration_s = sensor.timing().integration_ps() * 1e-12;
        // What draws nothing has no scans.
        let measured_s = tally.scans.max(1) as f64 * integrations * integration_s;
        let rate_cps = tally.detections as f64 / measured_s;
        let theory = theory(sensor, detector, &ranging.paths, ranging.counting);
        let mut estimates = statistics(ranging, tally, &theory, rate_cps, self.family);
        if !self.options.fidelity.draws() {
            expected::answer(sensor, detector, &theory, &mut estimates)?;
        }
        let predicted = ranging.paths.iter().copied().zip(theory.predictions);
        let predicted: Vec<_> = predicted.collect();
        let mut warnings = domain::warnings(sensor, detector, self.options.fidelity, &predicted);
        let name = &sensor.scene().detectors[detector].name;
        let walks = ranging.estimator.walks(false);
        warnings.extend(walks.map(|walks| format!("{name}: range walk is left in: {walks}")));
        Ok(OfDetector { estimates, warnings })
    }
}

/// What the scans of one detector say.
struct OfDetector {
    estimates: Vec<PathStatistics>,
    warnings: Vec<String>,
}

/// What some scans of a detector say, and what the Verilog was made to show.
fn of_scans(
    ranging: &Ranging,
    prepared: &PreparedTier,
    seed: u64,
    scans: Range<u64>,
    on_scan: &mut dyn FnMut(),
) -> Result<(ScanTally, Option<Exercised>), ScansError> {
    let mut batches = Batches::new(ranging);
    let (sensor, detector) = (ranging.sensor, ranging.detector);
    let exercised = prepared.scans(sensor, detector, seed, scans, &mut |counted| {
        on_scan();
        batches.add(counted);
    })?;
    Ok((batches.tally(), exercised))
}

/// Scans that wait until there are enough of them to be estimated from on all cores.
struct Batches<'r, 's> {
    ranging: &'r Ranging<'s>,
    tally: ScanTally,
    steps: Vec<StepCount>,
    histograms: Vec<Histogram>,
    /// Counts, or bins, of the scans that wait.
    counts: usize,
}

impl<'r, 's> Batches<'r, 's> {
    fn new(ranging: &'r Ranging<'s>) -> Self {
        Batches {
            ranging,
            tally: ScanTally::of_paths(ranging.paths.len()),
            steps: Vec::new(),
            histograms: Vec::new(),
            counts: 0,
        }
    }

    fn add(&mut self, scan: EstimatorInput) {
        let counts = match scan {
            EstimatorInput::Steps(counts) => {
                self.tally.detections += counts.iter().map(|count| count.total).sum::<u64>();
                self.steps.extend_from_slice(counts);
                counts.len()
            }
            EstimatorInput::Bins(histogram) => {
                let bins = histogram.bins().len();
                self.tally.detections += histogram.total();
                self.histograms.push(histogram.clone());
                bins
            }
        };
        self.counts += counts;
        if self.counts + counts > COUNTS_AT_ONCE {
            self.estimate();
        }
    }

    fn estimate(&mut self) {
        let mut answers = self.ranging.answers(&self.steps);
        answers.extend(self.ranging.answers_of_histograms(&self.histograms));
        self.tally.add(answers, self.ranging.tolerance_m());
        self.steps.clear();
        self.histograms.clear();
        self.counts = 0;
    }

    /// What all scans say.
    fn tally(mut self) -> ScanTally {
        self.estimate();
        self.tally
    }
}
