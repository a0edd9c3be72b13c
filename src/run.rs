//! The main job: plan, emit, simulate photons, co-simulate, estimate, write it all.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::thread;

use serde::Serialize;

use crate::cosim::build::cache_dir;
use crate::cosim::engine::Engine;
use crate::cosim::error::CosimError;
use crate::cosim::sent::SentCount;
use crate::cosim::source::Verilog;
use crate::cosim::window::Window;
use crate::cosim::{self, CosimOptions, Cosimulation, Verdict, cosimulate};
use crate::deliver::{self, Emission, HdlError};
use crate::estimate::CountingTier;
use crate::estimate::chance::Darkness;
use crate::estimate::report::EstimateReport;
use crate::files::{FileError, OutputFolder};
use crate::grade::{self, Grade, GradeOptions};
use crate::histogram::Histogram;
use crate::photons::StepCount;
use crate::plan::figures::Figures;
use crate::plan::overview::with_cells;
use crate::plan::resources::{Resources, resources};
use crate::plan::{self, Plan};
use crate::progress::Progress;
use crate::recorded::{AsItIs, RecordedHistogram, RecordedScan, fit_distance_alone};
use crate::reference::predictor::ReferenceError;
use crate::report::curves::IntegrationCurves;
use crate::report::kept::kept;
use crate::report::page::Page;
use crate::report::provenance::Provenance;
use crate::report::timing::{Wave, waves};
use crate::report::{DetectorCounts, bins_csv, counts_csv};
use crate::scene::{DetectorIndex, EstimatorKind, Scene, TotalsMissing};
use crate::sensor::Sensor;
use crate::version::MADE_BY;

/// The report page; written last.
pub const REPORT: &str = "report.html";
const COUNTS: &str = "counts.csv";
/// File of the bins that a sensor's histograms have, as the Verilog sent them.
const BINS: &str = "bins.csv";
/// Waveforms round the first mismatch, and those that were asked for, each with its views.
const MISMATCH: &str = "mismatch.vcd";
const WAVES: &str = "waves.vcd";
const RTL: &str = "rtl";

/// Remark on an estimate after a mismatch.
const OF_THE_VERILOG: &str = "the counts are the Verilog's, which differs from the reference model";

/// Options of the main job.
#[derive(Debug, Clone, clap::Args)]
pub struct RunOptions {
    /// Folder for the Verilog, counts.csv and report.html; created if missing, for example
    /// --out build/quick [default: out/ and the scene's name]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Estimator [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    /// Co-simulation engine
    #[arg(long, value_name = "E", value_enum, default_value_t)]
    pub engine: Engine,
    /// Also grade the adversarial stimulus on the Verilog, with every stuck-at fault and
    /// 0 to 10,000 mutants, so that the report states the strength of a match, for example
    /// --grade or --grade=100 [default: no grade; 0 mutants]
    #[arg(long = "grade", value_name = "MUTANTS", num_args = 0..=1, require_equals = true,
          default_missing_value = "0", hide_default_value = true,
          value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pub graded_mutants: Option<u32>,
    /// Seed of all random numbers
    #[arg(skip)]
    pub seed: u64,
    /// What emitted files say that they were made by
    #[arg(skip)]
    pub made_by: String,
    /// The clocks of `waves.vcd`; the file is not written without it
    #[arg(skip)]
    pub window: Option<Range<u64>>,
    /// What changes with the program that runs it, its version too: the cache keeps what theory tells
    /// the report for it. None is kept without
    #[arg(skip)]
    pub program: Option<String>,
    /// What the report says of where it comes from; may be left empty
    #[arg(skip)]
    pub provenance: Provenance,
}

impl Default for RunOptions {
    fn default() -> RunOptions {
        RunOptions {
            out: None,
            estimator: None,
            engine: Engine::Auto,
            graded_mutants: None,
            seed: 1,
            made_by: MADE_BY.to_owned(),
            window: None,
            program: None,
            provenance: Provenance::default(),
        }
    }
}

impl RunOptions {
    /// The folder of a scene's run.
    pub fn folder(&self, scene: &Scene) -> PathBuf {
        // A name of dots alone would lead out of it.
        let of_scene = || Path::new("out").join(scene.name.trim_matches('.'));
        self.out.clone().unwrap_or_else(of_scene)
    }
}

/// How far a run is.
#[derive(Debug)]
pub enum RunEvent<'a> {
    /// Another run writes into the folder; this one waits for its end.
    Waits(&'a Path),
    /// The Verilog is in its folder.
    Emitted(&'a Emission, &'a Path),
    /// Clocks that were co-simulated, then stages of the grade.
    Progress(Progress),
    /// The co-simulation is done.
    Compared(&'a cosim::Report),
}

/// Results of a run; the JSON of `goldtof run`.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Run {
    /// The scene's name.
    #[serde(skip)]
    pub scene: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Parts that are kept and left out.
    pub plan: Plan,
    /// The Verilog.
    pub emit: Emission,
    /// Verilog and reference model, side by side.
    pub cosim: cosim::Report,
    /// Distances from the Verilog's counts by the scene's estimator, one entry per detector.
    pub estimates: Vec<EstimateReport>,
    /// The same by the other estimator, on the same counts.
    pub other_estimates: Vec<EstimateReport>,
    /// Fault coverage of the adversarial stimulus on this Verilog, if asked for and if the Verilog
    /// matches.
    pub grade: Option<Grade>,
}

/// Why a run has no result.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The hardware cannot be emitted or written.
    #[error(transparent)]
    Hdl(#[from] HdlError),
    /// The Verilog cannot be co-simulated.
    #[error("{0}")]
    Cosim(#[from] CosimError),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The hardware's ports cannot be predicted.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// The estimator needs counts that the hardware does not send.
    #[error(transparent)]
    Totals(#[from] TotalsMissing),
}

/// [`Jobs::run`](crate::Jobs::run) with its progress.
///
/// # Errors
/// As there.
pub fn run(
    sensor: &Sensor,
    options: &RunOptions,
    mut on_event: impl FnMut(RunEvent),
) -> Result<Run, RunError> {
    let sensor = sensor.with_estimator(options.estimator)?;
    let scene = sensor.scene();
    if options.graded_mutants.is_some() {
        grade::refuse(&sensor)?;
    }
    let (compared, shown) =
        beside(|| Shown::of(&sensor, options), || Compared::of(&sensor, options, &mut on_event));
    let Compared { plan, emission, folder, _rtl, verilog, cosimulation } = compared?;
    let shown = shown?;
    let other = Sensor::new(&scene.estimated_by(scene.estimator.other()));
    let (own_estimates, mut other_estimates) = beside(
        || estimates(&other, &cosimulation, &shown),
        || estimates(&sensor, &cosimulation, &shown),
    );
    if scene.estimator == EstimatorKind::Fft && !scene.sends_total_counts() {
        let sent = DetectorIndex::all().zip(&cosimulation.counts);
        let both = own_estimates.iter().zip(&mut other_estimates);
        for ((detector, sent), (phase, model)) in sent.zip(both) {
            let counts = sent.iter().map(SentCount::step_count).collect();
            let scan = RecordedScan { detector, counts, has_totals: false };
            let as_it_is = &shown.as_it_is[detector];
            fit_distance_alone(&sensor, (&scan, as_it_is), phase, model);
        }
    }
    let mutants =
        options.graded_mutants.filter(|_| cosimulation.report.verdict != Verdict::Mismatch);
    let stage = |stage| on_event(RunEvent::Progress(Progress::Stage(stage)));
    let grade = mutants.map(|mutants| {
        let how = GradeOptions { mutants, seed: options.seed, ..Default::default() };
        let graded = grade::grade(&sensor, &verilog, &how, |count| (0..count).collect(), stage);
        Ok::<_, CosimError>(graded.map_err(grade::not_graded)?.grade(&how))
    });
    let run = Run {
        scene: scene.name.clone(),
        seed: options.seed,
        plan,
        emit: emission,
        grade: grade.transpose()?,
        estimates: own_estimates,
        other_estimates,
        cosim: cosimulation.report,
    };
    write(&run, &sensor, &cosimulation.counts, &shown, options, &folder)?;
    Ok(run)
}

/// The Verilog in its folder, beside its reference model.
struct Compared {
    plan: Plan,
    emission: Emission,
    folder: OutputFolder,
    /// Nobody else writes into it meanwhile.
    _rtl: OutputFolder,
    verilog: Verilog,
    cosimulation: Cosimulation,
}

impl Compared {
    fn of(
        sensor: &Sensor,
        options: &RunOptions,
        on_event: &mut impl FnMut(RunEvent),
    ) -> Result<Compared, RunError> {
        let plan = with_cells(plan::plan(sensor), sensor);
        let emission = deliver::emit(sensor, &options.made_by)?;
        let folder = options.folder(sensor.scene());
        let folder = OutputFolder::open(&folder, |path| on_event(RunEvent::Waits(path)))?;
        remove_other_runs(&folder)?;
        let rtl = folder.subfolder(RTL, |path| on_event(RunEvent::Waits(path)))?;
        deliver::write_into(&emission, &rtl)?;
        on_event(RunEvent::Emitted(&emission, &folder.join(RTL)));

        let verilog = Verilog::emitted(sensor, &emission.files)?;
        let how = CosimOptions {
            seed: options.seed,
            engine: options.engine,
            window: options.window.clone().map_or(Window::Found, Window::Clocks),
            ..Default::default()
        };
        let clocks = |done, of| on_event(RunEvent::Progress(Progress::Parts { done, of }));
        let mut cosimulation = cosimulate(sensor, &verilog, &how, clocks)?;
        if cosimulation.report.verdict == Verdict::Mismatch {
            cosimulation.write_mismatch(&folder.join(MISMATCH))?;
        }
        if options.window.is_some() {
            cosimulation.write_vcd(&folder.join(WAVES))?;
        }
        on_event(RunEvent::Compared(&cosimulation.report));
        Ok(Compared { plan, emission, folder, _rtl: rtl, verilog, cosimulation })
    }
}

/// A folder with a report has all that belongs to it, and of one scene.
fn remove_other_runs(folder: &OutputFolder) -> Result<(), RunError> {
    for name in [REPORT, COUNTS, BINS, MISMATCH, WAVES] {
        folder.remove(name)?;
    }
    for name in [MISMATCH, WAVES] {
        for view in cosim::views_beside(Path::new(name), folder.path()) {
            folder.remove(&view)?;
        }
    }
    Ok(folder.sync()?)
}

/// Parts of the report, and of estimates, that do not depend on the co-simulation.
struct Shown<'s> {
    resources: Option<Resources>,
    waves: Vec<Wave>,
    curves: Vec<IntegrationCurves>,
    as_it_is: Vec<AsItIs>,
    darkness: Vec<Darkness<'s>>,
}

impl<'s> Shown<'s> {
    fn of(sensor: &'s Sensor, options: &RunOptions) -> Result<Shown<'s>, ReferenceError> {
        let curves = || IntegrationCurves::of_first_paths(sensor);
        Ok(Shown {
            resources: resources(sensor),
            waves: waves(sensor, options.seed)?,
            curves: match (&options.program, cache_dir()) {
                (Some(program), Ok(cache)) => kept(&cache, program, sensor.scene(), curves),
                _ => curves(),
            },
            as_it_is: DetectorIndex::of(&sensor.scene().detectors)
                .map(|detector| AsItIs::new(sensor, detector))
                .collect(),
            darkness: DetectorIndex::of(&sensor.scene().detectors)
                .map(|detector| Darkness::of_scene(sensor, detector, CountingTier::Sampled))
                .collect(),
        })
    }
}

/// Does two things at once: `other` in a thread of its own. Gives both, `this` first.
fn beside<This, Other: Send>(
    other: impl FnOnce() -> Other + Send,
    this: impl FnOnce() -> This,
) -> (This, Other) {
    thread::scope(|scope| {
        let other = scope.spawn(other);
        let this = this();
        let other = other.join();
        (this, other.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}

/// Distances from the counts that the Verilog sent, detector by detector.
fn estimates(sensor: &Sensor, cosimulation: &Cosimulation, shown: &Shown) -> Vec<EstimateReport> {
    let of_detector = |(detector, sent): (DetectorIndex, &Vec<SentCount>)| {
        let reporter = IntegrationCurves::reporter(&shown.curves, sensor, detector)
            .knowing_darkness(&shown.darkness[detector]);
        let mut estimate = match histogram_of(sensor, sent) {
            Some(histogram) => reporter.histogram(&histogram),
            None => {
                let counts: Vec<StepCount> = sent.iter().map(SentCount::step_count).collect();
                reporter.scan(&counts)
            }
        };
        if cosimulation.report.verdict == Verdict::Mismatch {
            estimate.add_remark(OF_THE_VERILOG);
        }
        estimate
    };
    let counts = DetectorIndex::all().zip(&cosimulation.counts);
    counts.map(of_detector).collect()
}

/// The histogram that a detector's hardware sent, if it keeps one and sent all of it.
fn histogram_of(sensor: &Sensor, sent: &[SentCount]) -> Option<Histogram> {
    let plan = sensor.interface().histogram()?;
    let bins: Option<Vec<u64>> = sent.iter().map(|count| count.bin).collect();
    Histogram::new(bins?, plan.row_bins, plan.periods)
        .ok()
        .filter(|histogram| histogram.bins().len() as u64 == plan.bins())
}

/// Writes the counts, and last the report.
fn write(
    run: &Run,
    sensor: &Sensor,
    sent: &[Vec<SentCount>],
    shown: &Shown,
    options: &RunOptions,
    folder: &OutputFolder,
) -> Result<(), RunError> {
    let counts: Vec<DetectorCounts> = DetectorIndex::all()
        .zip(sent.iter().zip(&run.estimates))
        .map(|(detector, (counts, estimate))| {
            DetectorCounts::new(sensor, detector, estimate.calibration_offset_ps, counts)
        })
        .collect();
    folder.write(COUNTS, &counts_csv(sensor, &counts))?;
    let histograms: Vec<RecordedHistogram> = DetectorIndex::all()
        .zip(sent)
        .filter_map(|(detector, sent)| {
            Some(RecordedHistogram { detector, histogram: histogram_of(sensor, sent)? })
        })
        .collect();
    if !histograms.is_empty() {
        folder.write(BINS, &bins_csv(sensor, &histograms))?;
    }
    {
        let page = Page {
            sensor,
            seed: run.seed,
            provenance: &options.provenance,
            plan: &run.plan,
            figures: &Figures::of(sensor),
            resources: shown.resources.as_ref(),
            waves: &shown.waves,
            curves: &shown.curves,
            as_it_is: &shown.as_it_is,
            emission: &run.emit,
            cosim: &run.cosim,
            counts: &counts,
            histograms: &histograms,
            estimates: &run.estimates,
            other_estimates: &run.other_estimates,
            grade: run.grade.as_ref(),
        };
        folder.write(REPORT, &page.html())?;
    }
    Ok(())
}
