//! The main job: plan, emit, simulate photons, co-simulate, estimate, write it all.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::thread;

use serde::Serialize;

use crate::cosim::build::cache_dir;
use crate::cosim::engine::Engine;
use crate::cosim::error::CosimError;
use crate::cosim::sent::SentCount;
use crate::cosim::source::sources_of;
use crate::cosim::window::Window;
use crate::cosim::{self, Cosimulation, Request, StimulusKind, Verdict, cosimulate};
use crate::deliver::{self, Emission, HdlError};
use crate::document::Body;
use crate::estimate::report::{EstimateReport, estimate_histogram, estimate_scan};
use crate::files::{FileError, OutputFolder};
use crate::grade::{self, Grade, GradeOptions, GradeRequest};
use crate::histogram::Histogram;
use crate::photons::StepCount;
use crate::plan::figures::Figures;
use crate::plan::overview::with_cells;
use crate::plan::resources::{Resources, resources};
use crate::plan::{self, Plan};
use crate::reference::predictor::ReferenceError;
use crate::report::curves::IntegrationCurves;
use crate::report::page::Page;
use crate::report::provenance::Provenance;
use crate::report::timing::{Wave, waves};
use crate::report::{DetectorCounts, bins_csv, counts_csv};
use crate::scene::{DetectorIndex, Scene};
use crate::sensor::Sensor;

/// The report page; written last.
pub const REPORT: &str = "report.html";
const COUNTS: &str = "counts.csv";
/// File of the bins that a sensor's histograms have, as the Verilog sent them.
const BINS: &str = "bins.csv";
/// Waveforms round the first mismatch, and those that were asked for, each with its views.
const MISMATCH: &str = "mismatch.vcd";
const WAVES: &str = "waves.vcd";
const RTL: &str = "rtl";

/// Said of an estimate after a mismatch.
const OF_THE_VERILOG: &str = "the counts are the Verilog's, which differs from the reference model";

/// What a run is to do beside what its scene says.
#[derive(Debug, Clone)]
pub struct RunOptions {
    /// Folder for the Verilog (in `rtl`), `counts.csv`, of histograms `bins.csv`, too,
    /// `report.html`, after a mismatch `mismatch.vcd`, and
    /// `waves.vcd` if asked for; made when missing.
    pub out: PathBuf,
    /// Seed of all random numbers.
    pub seed: u64,
    /// How Verilog and reference model are clocked.
    pub engine: Engine,
    /// Grades the adversarial stimulus on the emitted Verilog, too, if that matches: with every
    /// stuck-at fault, and so many mutants.
    pub graded_mutants: Option<u32>,
    /// What emitted files say that they were made by.
    pub made_by: String,
    /// The clocks of `waves.vcd`; the file is not written without it.
    pub window: Option<Range<u64>>,
    /// What the report says of where it comes from; may be left empty.
    pub provenance: Provenance,
}

/// How far a run is.
#[derive(Debug)]
pub enum RunEvent<'a> {
    /// Another run writes into the folder; this one waits for its end.
    Waits(&'a Path),
    /// The Verilog is in its folder.
    Emitted(&'a Emission, &'a Path),
    /// Clocks that were co-simulated, of how many.
    Clocks(u64, u64),
    /// The co-simulation is done.
    Compared(&'a cosim::Report),
    /// What is being done for the grade.
    Grades(&'static str),
}

/// What a run found; as JSON the document of `goldtof run`.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Run {
    /// The scene's name.
    #[serde(skip)]
    pub scene: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// What was kept and left out.
    pub plan: Plan,
    /// The Verilog.
    pub emit: Emission,
    /// Verilog and reference model, side by side.
    pub cosim: cosim::Report,
    /// What the Verilog's counts say of the distance, by the scene's estimator; one
    /// entry per detector.
    pub estimates: Vec<EstimateReport>,
    /// The same by the other estimator, on the same counts.
    pub other_estimates: Vec<EstimateReport>,
    /// What the adversarial stimulus is worth on this Verilog, if that was asked for and the
    /// Verilog matches.
    pub grade: Option<Grade>,
}

impl Body for Run {
    const NAME: &'static str = "run";
}

/// Why a run has no result.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The hardware cannot be emitted or written.
    #[error(transparent)]
    Hdl(#[from] HdlError),
    /// The Verilog cannot be co-simulated.
    #[error(transparent)]
    Cosim(#[from] CosimError),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The hardware's ports cannot be predicted.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
}

/// Does a scene's main job. A mismatch of Verilog and reference model is a result.
///
/// ```no_run
/// use std::path::Path;
///
/// let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
/// let options = goldtof::RunOptions {
///     out: "out/quick".into(),
///     seed: 1,
///     engine: goldtof::cosim::engine::Engine::Auto,
///     graded_mutants: None,
///     made_by: "goldtof emit quick.toml".to_owned(),
///     window: None,
///     provenance: goldtof::Provenance::default(),
/// };
/// let run = goldtof::run(&scene, &options, |_| ())?;
/// println!("{}: {:?}", run.cosim.verdict, run.estimates[0].distance_m);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the scene has no hardware, a tool is missing or fails, or a file cannot be
/// written.
pub fn run(
    scene: &Scene,
    options: &RunOptions,
    mut on_event: impl FnMut(RunEvent),
) -> Result<Run, RunError> {
    let sensor = Sensor::new(scene);
    if options.graded_mutants.is_some() {
        grade::refuse(&sensor)?;
    }
    let plan = with_cells(plan::plan(&sensor), &sensor);
    let emission = deliver::emit(&sensor, &options.made_by)?;
    let folder = OutputFolder::open(&options.out, |path| on_event(RunEvent::Waits(path)))?;
    remove_other_runs(&folder)?;
    let rtl = folder.subfolder(RTL, |path| on_event(RunEvent::Waits(path)))?;
    deliver::write_into(&emission, &rtl)?;
    on_event(RunEvent::Emitted(&emission, &folder.join(RTL)));

    let request = request(&emission, options)?;
    let clocks = |done, of| on_event(RunEvent::Clocks(done, of));
    let (cosimulation, shown) =
        beside(|| Shown::of(&sensor, options.seed), || cosimulate(&sensor, &request, clocks));
    let mut cosimulation = cosimulation?;
    if cosimulation.report.verdict == Verdict::Mismatch {
        cosimulation.write_mismatch(&folder.join(MISMATCH))?;
    }
    if options.window.is_some() {
        cosimulation.write_vcd(&folder.join(WAVES))?;
    }
    on_event(RunEvent::Compared(&cosimulation.report));
    let other = Sensor::new(&scene.estimated_by(scene.estimator.other()));
    let (own_estimates, other_estimates) =
        beside(|| estimates(&other, &cosimulation), || estimates(&sensor, &cosimulation));
    let mutants =
        options.graded_mutants.filter(|_| cosimulation.report.verdict != Verdict::Mismatch);
    let stage = |stage| on_event(RunEvent::Grades(stage));
    let grade = mutants.map(|mutants| graded(&sensor, &request, mutants, stage));
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
    write(&run, &sensor, &cosimulation.counts, &shown?, options, &folder)?;
    Ok(run)
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

/// What the report shows that the co-simulation has no say in.
struct Shown {
    resources: Option<Resources>,
    waves: Vec<Wave>,
    curves: Vec<IntegrationCurves>,
}

impl Shown {
    fn of(sensor: &Sensor, seed: u64) -> Result<Shown, ReferenceError> {
        Ok(Shown {
            resources: resources(sensor),
            waves: waves(sensor, seed)?,
            curves: IntegrationCurves::of_first_paths(sensor),
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

fn request(emission: &Emission, options: &RunOptions) -> Result<Request, CosimError> {
    Ok(Request {
        top: emission.top.clone(),
        sources: sources_of(&emission.files),
        registers: Some(emission.scan_registers.clone()),
        cache: cache_dir()?,
        stimulus: StimulusKind::Photons,
        clocks: None,
        seed: options.seed,
        window: options.window.clone().map_or(Window::Found, Window::Clocks),
        engine: options.engine,
    })
}

/// What the adversarial stimulus is worth on the design of a co-simulation.
fn graded(
    sensor: &Sensor,
    cosimulated: &Request,
    mutants: u32,
    on_stage: impl FnMut(&'static str),
) -> Result<Grade, CosimError> {
    let request = GradeRequest {
        top: cosimulated.top.clone(),
        sources: cosimulated.sources.clone(),
        registers: cosimulated.registers.clone(),
        cache: cosimulated.cache.clone(),
        options: GradeOptions { mutants, seed: cosimulated.seed, ..Default::default() },
    };
    let graded = grade::grade(sensor, &request, |count| (0..count).collect(), on_stage);
    let graded = graded.map_err(grade::not_graded)?;
    Ok(graded.grade(&request.options))
}

/// What the counts that the Verilog sent say of the distance, detector by detector.
fn estimates(sensor: &Sensor, cosimulation: &Cosimulation) -> Vec<EstimateReport> {
    let of_detector = |(detector, sent): (DetectorIndex, &Vec<SentCount>)| {
        let mut estimate = match histogram_of(sensor, sent) {
            Some(histogram) => estimate_histogram(sensor, detector, &histogram),
            None => {
                let counts: Vec<StepCount> = sent.iter().map(SentCount::step_count).collect();
                estimate_scan(sensor, detector, &counts)
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
    let plan = sensor.interface().histogram?;
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
    let histograms: Vec<(DetectorIndex, Histogram)> = DetectorIndex::all()
        .zip(sent)
        .filter_map(|(detector, sent)| Some((detector, histogram_of(sensor, sent)?)))
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
            emission: &run.emit,
            cosim: &run.cosim,
            counts: &counts,
            estimates: &run.estimates,
            other_estimates: &run.other_estimates,
            grade: run.grade.as_ref(),
        };
        folder.write(REPORT, &page.html())?;
    }
    Ok(())
}
