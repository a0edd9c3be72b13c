//! Counts of whole scans, one tier or another.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::num::NonZero;
use std::ops::Range;

use super::effort::TooMuch;
use super::histograms::{self, HistogramsError};
use super::run_up::{Wanted, begun_by};
use super::{Tier, effort};
use crate::cosim::build::{Built, build};
use crate::cosim::engine::Engine;
use crate::cosim::error::CosimError;
use crate::cosim::exercised::Exercised;
use crate::cosim::lanes::refuse_memories;
use crate::cosim::lockstep::Lockstep;
use crate::cosim::sent::SentCount;
use crate::cosim::source::Verilog;
use crate::cosim::verilated::Verilated;
use crate::cosim::window::Window;
use crate::cosim::{CosimOptions, Cosimulation, Verdict, cosimulate};
use crate::deliver::{self, HdlError, Prefix};
use crate::estimate::PredictionError;
use crate::estimate::estimator::EstimatorInput;
use crate::histogram::Histogram;
use crate::photons::StepCount;
use crate::photons::fast::StepCounter;
use crate::reference::blocks;
use crate::reference::photons::Photons;
use crate::reference::predictor::{ReferenceError, ReferenceModel, StepResult};
use crate::reference::stimulus::{Stimulus, clocks_for_scans};
use crate::response::{CountSampler, MeanResponse, MeanResponseError, SecondMoments};
use crate::scene::{Architecture, DetectorIndex, TotalsMissing};
use crate::sensor::Sensor;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;

/// Phase steps whose counts are held at once, about.
const STEPS_AT_ONCE: u64 = 1 << 20;

/// Why there are no lanes for more.
const ONE_SCAN: &str = "several scans follow one another, and lanes share out one";

/// Why scans could not be simulated.
#[derive(Debug, thiserror::Error)]
pub enum ScansError {
    /// The exact mean response cannot be had.
    #[error(transparent)]
    MeanResponse(#[from] MeanResponseError),
    /// The expected estimate cannot be had.
    #[error(transparent)]
    Prediction(#[from] PredictionError),
    /// It would take too long, or too much memory.
    #[error(transparent)]
    TooMuch(#[from] TooMuch),
    /// The tier does no histograms.
    #[error(transparent)]
    Histograms(#[from] HistogramsError),
    /// The scene's hardware is not modelled.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// The scene's hardware cannot be emitted.
    #[error(transparent)]
    Hdl(#[from] HdlError),
    /// The co-simulation could not be done.
    #[error("{0}")]
    Cosim(#[from] CosimError),
    /// The estimator that is asked for needs total counts.
    #[error(transparent)]
    Totals(#[from] TotalsMissing),
    /// Verilog and reference model differ.
    #[error(
        "the Verilog and the reference model differ; `goldtof cosim` with the same scene and seed \
         shows where"
    )]
    Mismatch,
}

/// What a tier needs before its first scan, once for all scans of a scene to come:
/// the Verilog's model, built. The other tiers need nothing.
#[derive(Debug, Clone)]
pub struct PreparedTier {
    tier: Tier,
    rtl: Option<Rtl>,
}

/// The Verilog, and how it is clocked.
#[derive(Debug, Clone)]
struct Rtl {
    verilog: Verilog,
    library: Built,
    engine: Engine,
}

/// [`PreparedTier::scans`] of a tier that is prepared for them alone, of hardware that counts up and
/// down.
///
/// # Errors
/// When the tier cannot do the scene.
///
/// # Panics
/// If the hardware keeps histograms.
pub fn scans(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: Tier,
    seed: u64,
    repetitions: u64,
    mut on_scan: impl FnMut(&[StepCount]),
) -> Result<Option<Exercised>, ScansError> {
    let prepared = PreparedTier::new(sensor, tier, Engine::Auto)?;
    prepared.scans(sensor, detector, seed, 0..repetitions, &mut |counted| {
        let EstimatorInput::Steps(counts) = counted else { unreachable!("it keeps a histogram") };
        on_scan(counts);
    })
}

/// The same of hardware that keeps histograms.
///
/// # Errors
/// When the tier cannot do the scene.
///
/// # Panics
/// If the hardware counts up and down.
pub fn histograms(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: Tier,
    seed: u64,
    repetitions: u64,
    mut on_histogram: impl FnMut(Histogram),
) -> Result<Option<Exercised>, ScansError> {
    let prepared = PreparedTier::new(sensor, tier, Engine::Auto)?;
    prepared.scans(sensor, detector, seed, 0..repetitions, &mut |counted| {
        let EstimatorInput::Bins(histogram) = counted else {
            unreachable!("it counts up and down")
        };
        on_histogram(histogram.clone());
    })
}

impl PreparedTier {
    /// Prepares a tier for a scene; the engine is that of the Verilog, where the tier clocks it.
    ///
    /// # Errors
    /// When the Verilog cannot be emitted or built.
    pub fn new(sensor: &Sensor, tier: Tier, engine: Engine) -> Result<PreparedTier, ScansError> {
        if tier != Tier::Rtl {
            return Ok(PreparedTier { tier, rtl: None });
        }
        let files = deliver::verilog(sensor, &Prefix::default(), "goldtof simulate")?;
        let verilog = Verilog::emitted(sensor, &files)?;
        let Verilog { top, sources, cache, .. } = &verilog;
        let library = build(top, sources, sensor.interface(), cache)?;
        Ok(PreparedTier { tier, rtl: Some(Rtl { library, verilog, engine }) })
    }

    /// The tier.
    pub fn tier(&self) -> Tier {
        self.tier
    }

    /// Simulates some scans of one detector of the scene, by their numbers among all
    /// scans of the seed. `on_scan` gets what each counts, in order; that does not depend on
    /// which other scans are asked for. The tier that draws nothing has no scans. Gives what the
    /// Verilog was made to show, if it was run.
    ///
    /// # Errors
    /// When the tier cannot do the scene.
    ///
    /// # Panics
    /// If the scene has no such detector.
    pub fn scans(
        &self,
        sensor: &Sensor,
        detector: DetectorIndex,
        seed: u64,
        scans: Range<u64>,
        on_scan: &mut dyn FnMut(EstimatorInput),
    ) -> Result<Option<Exercised>, ScansError> {
        effort::check(sensor, detector, self.tier, scans.end - scans.start)?;
        if scans.is_empty() || !self.tier.draws() {
            return Ok(None);
        }
        let wanted = Wanted { sensor, detector, seed, scans };
        match sensor.scene().hardware.architecture {
            Architecture::UpDown => {
                self.steps(&wanted, &mut |counts| on_scan(EstimatorInput::Steps(counts)))
            }
            Architecture::Histogram => {
                self.bins(&wanted, &mut |histogram| on_scan(EstimatorInput::Bins(&histogram)))
            }
        }
    }

    /// Clocks the Verilog, of a tier that does, beside the reference model for so many clocks. Gives what it was
    /// made to show.
    ///
    /// # Errors
    /// When the two differ.
    pub fn beside_reference(
        &self,
        sensor: &Sensor,
        stimulus: &mut dyn Stimulus,
        clocks: u64,
    ) -> Result<Option<Exercised>, ScansError> {
        let Some(rtl) = &self.rtl else {
            return Ok(None);
        };
        if rtl.engine == Engine::Lanes {
            return Err(CosimError::NoLanes(ONE_SCAN.to_owned()).into());
        }
        rtl.beside_reference(sensor, stimulus, clocks, &mut |_| (), &mut |_| ()).map(Some)
    }

    fn steps(
        &self,
        wanted: &Wanted,
        on_scan: &mut dyn FnMut(&[StepCount]),
    ) -> Result<Option<Exercised>, ScansError> {
        match (self.tier, &self.rtl) {
            (Tier::Counts, _) => counts(wanted, on_scan)?,
            (Tier::Events, _) => events(wanted, on_scan),
            (_, None) => sampled(wanted, on_scan)?,
            (_, Some(rtl)) if wanted.scans == (0..1) && rtl.engine != Engine::Lockstep => {
                return rtl.one_scan(wanted, on_scan);
            }
            (_, Some(rtl)) if rtl.engine == Engine::Lanes => {
                return Err(CosimError::NoLanes(ONE_SCAN.to_owned()).into());
            }
            (_, Some(rtl)) => return rtl.lockstep(wanted, on_scan),
        }
        Ok(None)
    }

    fn bins(
        &self,
        wanted: &Wanted,
        on_histogram: &mut dyn FnMut(Histogram),
    ) -> Result<Option<Exercised>, ScansError> {
        match (self.tier, &self.rtl) {
            (Tier::Counts, _) => histograms::counts(wanted, on_histogram)?,
            (Tier::Events, _) => histograms::events(wanted, on_histogram)?,
            (_, None) => histograms::sampled(wanted, on_histogram)?,
            (_, Some(rtl)) => {
                let (model, mut made) = (wanted.model(), Ok(()));
                let mut on_bins = |bins| match histograms::histogram(&model, bins) {
                    Ok(histogram) => on_histogram(histogram),
                    Err(error) => made = Err(error),
                };
                let exercised = rtl.histograms(wanted, &mut on_bins)?;
                made.map_err(HistogramsError::from)?;
                return Ok(exercised);
            }
        }
        Ok(None)
    }
}

impl Rtl {
    /// Histograms of one detector as the Verilog sends them, each bin after the other.
    fn histograms(
        &self,
        wanted: &Wanted,
        on_bins: &mut dyn FnMut(Vec<u64>),
    ) -> Result<Option<Exercised>, ScansError> {
        let sensor = wanted.sensor;
        if self.engine == Engine::Lanes {
            refuse_memories(sensor.interface())
                .map_err(|reason| CosimError::NoLanes(reason.to_string()))?;
        }
        let bins = sensor.timing().scan.steps as usize;
        let from = begun_by(&wanted.models(), wanted.scans.start);
        let mut frame = Vec::with_capacity(bins);
        let mut on_sent = |sent: SentCount| {
            let bin = sent.bin.filter(|_| sent.detector == wanted.detector);
            frame.extend(bin.filter(|_| wanted.scans.contains(&(from + sent.scan))));
            if frame.len() == bins {
                on_bins(std::mem::replace(&mut frame, Vec::with_capacity(bins)));
            }
        };
        self.compared(wanted, from, &mut |_| (), &mut on_sent)
    }

    /// One scan, in lanes where it has a place there.
    fn one_scan(
        &self,
        wanted: &Wanted,
        on_scan: &mut dyn FnMut(&[StepCount]),
    ) -> Result<Option<Exercised>, ScansError> {
        let &Wanted { sensor, detector, seed, .. } = wanted;
        let options = CosimOptions { seed, engine: self.engine, ..Default::default() };
        let Cosimulation { report, counts, hits, .. } =
            cosimulate(sensor, &self.verilog, &options, |_, _| ())?;
        if report.verdict == Verdict::Mismatch {
            return Err(ScansError::Mismatch);
        }
        let mut collector = Collector::new(sensor.interface(), 0, 0..1, on_scan);
        for (sent, hits) in counts[detector].iter().zip(&hits[detector]) {
            let count = StepCount { signed: sent.signed, total: sent.total.unwrap_or(*hits) };
            collector.take(sent.scan, count);
        }
        Ok(Some(report.exercised))
    }

    /// Any number of scans.
    fn lockstep(
        &self,
        wanted: &Wanted,
        on_scan: &mut dyn FnMut(&[StepCount]),
    ) -> Result<Option<Exercised>, ScansError> {
        let from = begun_by(&wanted.models(), wanted.scans.start);
        let scans = wanted.scans.clone();
        let mut collector = Collector::new(wanted.sensor.interface(), from, scans, on_scan);
        // Hits of the steps that the Verilog has yet to send. They stand in where it
        // sends no totals: the rate of detections needs them, the estimator does not.
        let hits = RefCell::new(VecDeque::new());
        let mut on_result = |result: StepResult| {
            if result.detector == wanted.detector {
                hits.borrow_mut().push_back(result.total);
            }
        };
        let mut on_sent = |sent: SentCount| {
            if sent.detector == wanted.detector {
                let hits = hits.borrow_mut().pop_front();
                let total = sent.total.or(hits).unwrap_or(0);
                collector.take(sent.scan, StepCount { signed: sent.signed, total });
            }
        };
        self.compared(wanted, from, &mut on_result, &mut on_sent)
    }

    /// Clocks the Verilog beside the reference model with photons from one scan on to the last that is wanted.
    /// `on_result` gets what the model counts, `on_sent` what the Verilog sends, with scans numbered
    /// from the run's first. Gives what it was made to show.
    fn compared(
        &self,
        wanted: &Wanted,
        from: u64,
        on_result: &mut dyn FnMut(StepResult),
        on_sent: &mut dyn FnMut(SentCount),
    ) -> Result<Option<Exercised>, ScansError> {
        let interface = wanted.sensor.interface();
        let clocks = clocks_for_scans(interface, wanted.scans.end - from);
        let models = wanted.models();
        let mut photons = Photons::from_scan(&models, interface, wanted.seed, from);
        self.beside_reference(wanted.sensor, &mut photons, clocks, on_result, on_sent).map(Some)
    }

    /// Clocks the Verilog beside the reference model, with `stimulus` for so many clocks.
    fn beside_reference(
        &self,
        sensor: &Sensor,
        stimulus: &mut dyn Stimulus,
        clocks: u64,
        on_result: &mut dyn FnMut(StepResult),
        on_sent: &mut dyn FnMut(SentCount),
    ) -> Result<Exercised, ScansError> {
        let layout = Layout::of(sensor.interface());
        let outcome = Lockstep {
            model: &mut Verilated::load(&self.library, &layout)?,
            reference: &mut ReferenceModel::new(sensor.interface().clone())?,
            stimulus,
            layout: &layout,
            window: Window::Found,
        }
        .run_and_read(clocks, on_result, on_sent, &mut |_| ())?;
        if outcome.first.is_some() {
            return Err(ScansError::Mismatch);
        }
        let detectors = sensor.scene().detectors.iter();
        let names = detectors.map(|detector| detector.name.as_str());
        Ok(outcome.exercise.named(names))
    }
}

fn counts(wanted: &Wanted, on_scan: &mut dyn FnMut(&[StepCount])) -> Result<(), ScansError> {
    effort::check_draws(wanted.sensor, wanted.detector)?;
    let model = wanted.model();
    let response = MeanResponse::of_tier(&model, Tier::Counts.counting(wanted.sensor))?;
    let sampler = CountSampler::of(&model, &SecondMoments::new(&response)?)?;
    for scan in wanted.scans.clone() {
        on_scan(&sampler.scan(wanted.seed, scan));
    }
    Ok(())
}

fn events(wanted: &Wanted, on_scan: &mut dyn FnMut(&[StepCount])) {
    let model = wanted.model();
    let counter = StepCounter::new(&model);
    let threads = NonZero::new(rayon::current_num_threads()).unwrap_or(NonZero::<usize>::MIN);
    let (seed, scans, steps) = (wanted.seed, &wanted.scans, wanted.sensor.timing().scan.steps);
    let at_once = (STEPS_AT_ONCE / steps).max(1);
    let mut counted = Vec::new();
    let mut first = scans.start;
    while first < scans.end {
        let batch = first..first.saturating_add(at_once).min(scans.end);
        first = batch.end;
        counted.resize(((batch.end - batch.start) * steps) as usize, StepCount::default());
        counter.count_on_threads(threads, seed, batch, 0..steps, &mut counted);
        counted.chunks_exact(steps as usize).for_each(&mut *on_scan);
    }
}

fn sampled(wanted: &Wanted, on_scan: &mut dyn FnMut(&[StepCount])) -> Result<(), ScansError> {
    let interface = wanted.sensor.interface();
    let detectors = wanted.models();
    let from = begun_by(&detectors, wanted.scans.start);
    let clocks = clocks_for_scans(interface, wanted.scans.end - from);
    let mut reference = ReferenceModel::new(interface.clone())?;
    let mut photons = Photons::from_scan(&detectors, interface, wanted.seed, from);
    let mut collector = Collector::new(interface, from, wanted.scans.clone(), on_scan);
    blocks::results(&mut reference, &mut photons, clocks, &mut |result| {
        if result.detector == wanted.detector {
            let count = StepCount { signed: result.count, total: result.total };
            collector.take(result.scan, count);
        }
    });
    Ok(())
}

/// Gathers a detector's counts, which come in order, into scans.
struct Collector<'f> {
    steps: u64,
    /// The scan that the run began with.
    from: u64,
    /// Those that were asked for.
    scans: Range<u64>,
    scan: Vec<StepCount>,
    on_scan: &'f mut dyn FnMut(&[StepCount]),
}

impl<'f> Collector<'f> {
    fn new(
        interface: &Interface,
        from: u64,
        scans: Range<u64>,
        on_scan: &'f mut dyn FnMut(&[StepCount]),
    ) -> Collector<'f> {
        Collector { steps: interface.timing.scan.steps, from, scans, scan: Vec::new(), on_scan }
    }

    /// Takes the next step's counts, of the `scan`-th scan of the run. Those before the
    /// first that was asked for lead up to it, and those beyond the last are the start of
    /// one more, which the run's last clocks reach into.
    fn take(&mut self, scan: u64, count: StepCount) {
        if !self.scans.contains(&(self.from + scan)) {
            return;
        }
        self.scan.push(count);
        if self.scan.len() as u64 == self.steps {
            (self.on_scan)(&self.scan);
            self.scan.clear();
        }
    }
}
