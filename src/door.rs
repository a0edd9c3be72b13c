//! The library's doors beside [`run`](crate::run): one function for each job, with its
//! options and its errors.

use crate::cosim::build::cache_dir;
use crate::cosim::engine::Engine;
use crate::cosim::error::CosimError;
use crate::cosim::latency::{Latency, held_to};
use crate::cosim::own::{self, OwnDesign, OwnRtl};
use crate::cosim::source::sources_of;
use crate::cosim::window::Window;
use crate::cosim::{Cosimulation, Request, StimulusKind, cosimulate};
use crate::deliver::{self, Emission, HdlError, Prefix};
use crate::estimate::report::{EstimateReport, estimate_scan};
use crate::estimate::{ImpossibleScan, possible_scan};
use crate::grade::{Grade, GradeOptions, GradeRequest, Graded, not_graded};
use crate::photons::StepCount;
use crate::rtl::blocks::ScanRegisters;
use crate::scene::{DetectorIndex, Scene};
use crate::sensor::Sensor;
use crate::simulate::SimulateOptions;
use crate::simulate::repeat::{self, Simulation};
use crate::simulate::scans::ScansError;

/// How to emit.
#[derive(Debug, Clone)]
pub struct EmitOptions {
    /// What the files say that they were made by: the command, as a rule.
    pub made_by: String,
    /// What the names of modules, files and macros begin with, so that several sensors
    /// can be in one design; none by default.
    pub prefix: Prefix,
}

/// Makes the Verilog of a scene's sensor, and what goes with it;
/// [`deliver::write`] puts it into a folder.
///
/// ```
/// use std::path::Path;
///
/// let scene = goldtof::scene::load(Path::new("scenes/paper-single.toml"))?;
/// let options = goldtof::EmitOptions {
///     made_by: "goldtof emit paper-single.toml".to_owned(),
///     prefix: "left_".parse()?,
/// };
/// let emission = goldtof::emit(&scene, &options)?;
/// assert_eq!(emission.clock_hz, 125e6); // one clock is one chip of 8 ns
/// assert_eq!(emission.top, "left_sensor_top");
/// assert!(emission.files.iter().any(|file| file.name == "left_gold_generator.v"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the scene asks for more than the hardware takes.
pub fn emit(scene: &Scene, options: &EmitOptions) -> Result<Emission, HdlError> {
    deliver::emit_prefixed(&Sensor::new(scene), &options.prefix, &options.made_by)
}

/// Simulates a scene from photons to distances, many times.
///
/// ```
/// use std::path::Path;
///
/// let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
/// let options = goldtof::SimulateOptions { repetitions: 20, ..Default::default() };
/// let simulation = goldtof::simulate(&scene, &options)?;
/// let path = &simulation.estimates[0];
/// assert_eq!(path.estimates + path.missed_scans, 20);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the tier cannot do the scene, or a tool that it needs is missing or fails.
pub fn simulate(scene: &Scene, options: &SimulateOptions) -> Result<Simulation, ScansError> {
    simulate_watched(scene, options, |_, _| ())
}

/// [`simulate`]; `on_progress` hears of each scan how many are done and how many there
/// are, of all detectors. If it unwinds, the simulation ends there, and leaves nothing
/// behind.
///
/// # Errors
/// As there.
pub fn simulate_watched(
    scene: &Scene,
    options: &SimulateOptions,
    on_progress: impl FnMut(u64, u64),
) -> Result<Simulation, ScansError> {
    let scene = scene.clone().with_estimator(options.estimator)?;
    repeat::simulate_watched(&Sensor::new(&scene), options, on_progress)
}

/// Which Verilog is compared with the reference model.
#[derive(Debug, Clone)]
pub enum Rtl {
    /// What is emitted for the scene.
    Emitted {
        /// What the files say that they were made by. A build is found again by its
        /// files, so that the same words spare another one.
        made_by: String,
    },
    /// Verilog of one's own with the same ports.
    Own(OwnRtl),
}

/// What to compare, and how.
#[derive(Debug, Clone)]
pub struct CosimOptions {
    /// The Verilog.
    pub rtl: Rtl,
    /// What drives both sides.
    pub stimulus: StimulusKind,
    /// Clocks to run, reset included; `None` for a whole scan of photons, or as long as
    /// the adversary needs.
    pub clocks: Option<u64>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The clocks to keep for waveforms.
    pub window: Window,
    /// How late results may come.
    pub latency: Latency,
    /// How both sides are clocked.
    pub engine: Engine,
}

/// Why nothing was compared.
#[derive(Debug, thiserror::Error)]
pub enum CosimFailed {
    /// The hardware cannot be emitted.
    #[error(transparent)]
    Hdl(#[from] HdlError),
    /// The Verilog cannot be read, built or run.
    #[error(transparent)]
    Cosim(#[from] CosimError),
}

/// Runs Verilog beside the bit-exact reference model and compares every output port at
/// every clock. `on_progress` hears clocks done and clocks in all. A mismatch is a
/// result.
///
/// ```no_run
/// use std::path::Path;
///
/// use goldtof::cosim::window::Window;
/// use goldtof::cosim::{StimulusKind, Verdict};
///
/// let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
/// let options = goldtof::CosimOptions {
///     rtl: goldtof::Rtl::Own(goldtof::OwnRtl::folder("my_rtl")),
///     stimulus: StimulusKind::Adversarial,
///     clocks: None,
///     seed: 1,
///     window: goldtof::cosim::window::Window::Found,
///     latency: goldtof::cosim::latency::Latency::Auto,
///     engine: goldtof::cosim::engine::Engine::Auto,
/// };
/// let mut found = goldtof::cosim(&scene, &options, |_, _| ())?;
/// if found.report.verdict == Verdict::Mismatch {
///     found.write_vcd(Path::new("mismatch.vcd"))?;
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the scene has no hardware, the Verilog does not fit it or ends its own
/// simulation, or a tool is missing or fails.
pub fn cosim(
    scene: &Scene,
    options: &CosimOptions,
    on_progress: impl FnMut(u64, u64),
) -> Result<Cosimulation, CosimFailed> {
    let sensor = Sensor::new(scene);
    let design = options.rtl.read(&sensor)?;
    let request = Request {
        top: design.top,
        sources: design.sources,
        registers: design.registers,
        cache: cache_dir()?,
        stimulus: options.stimulus,
        clocks: options.clocks,
        seed: options.seed,
        window: options.window.clone(),
        engine: options.engine,
    };
    let sensor = held_to(&sensor, options.latency, &request)?;
    let mut done = cosimulate(&sensor, &request, on_progress)?;
    done.report.remarks = design.remarks;
    Ok(done)
}

impl Rtl {
    /// SHA-256 of the design that is meant, in hexadecimal digits: of its top module's name
    /// and of name and text of every file.
    ///
    /// # Errors
    /// When it cannot be emitted or read.
    pub(crate) fn sha256(&self, scene: &Scene) -> Result<String, CosimFailed> {
        let design = self.read(&Sensor::new(scene))?;
        let files = design.sources.iter().flat_map(|file| [&file.name, &file.text]);
        Ok(crate::digest::sha256_of_all(std::iter::once(&design.top).chain(files)))
    }

    /// The design that is meant.
    fn read(&self, sensor: &Sensor) -> Result<OwnDesign, CosimFailed> {
        Ok(match self {
            Rtl::Own(own) => own::read(own, sensor.interface())?,
            Rtl::Emitted { made_by } => {
                let files = deliver::verilog(sensor, &Prefix::default(), made_by)?;
                OwnDesign {
                    sources: sources_of(&files),
                    top: deliver::TOP.to_owned(),
                    registers: Some(ScanRegisters::of(sensor.interface())),
                    remarks: Vec::new(),
                }
            }
        })
    }
}

/// How many faults and mutants of a design a stimulus finds. `on_stage` is told what is
/// being done.
///
/// # Errors
/// When the scene has no hardware, the Verilog does not fit it, differs from the
/// reference model or is none of which faults can be told, or a tool is missing or fails.
pub fn grade(
    scene: &Scene,
    rtl: &Rtl,
    options: &GradeOptions,
    on_stage: impl FnMut(&'static str),
) -> Result<Grade, CosimFailed> {
    let graded = grade_some(scene, rtl, options, |count| (0..count).collect(), on_stage)?;
    Ok(graded.grade(options))
}

/// What becomes of some faults and mutants of a design: of those that `choose` says, by
/// their numbers in order, given how many there are of a kind.
///
/// # Errors
/// As [`grade`].
pub(crate) fn grade_some(
    scene: &Scene,
    rtl: &Rtl,
    options: &GradeOptions,
    choose: impl Fn(usize) -> Vec<usize> + Sync,
    on_stage: impl FnMut(&'static str),
) -> Result<Graded, CosimFailed> {
    let sensor = Sensor::new(scene);
    let design = rtl.read(&sensor)?;
    let request = GradeRequest {
        top: design.top,
        sources: design.sources,
        registers: design.registers,
        cache: cache_dir()?,
        options: *options,
    };
    let graded = crate::grade::grade(&sensor, &request, choose, on_stage);
    Ok(graded.map_err(not_graded)?)
}

/// Whose counts they are.
#[derive(Debug, Clone)]
pub struct EstimateOptions {
    /// Name of the detector.
    pub detector: String,
}

/// Why counts cannot be estimated from.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EstimateError {
    /// The scene has no such detector.
    #[error("the scene has no detector \"{name}\"; it has {known}")]
    NoDetector {
        /// The name that was given.
        name: String,
        /// Those that it has.
        known: String,
    },
    /// The counts are not those of a scan.
    #[error(transparent)]
    Impossible(#[from] ImpossibleScan),
}

/// Turns the counts of a scan, one of each phase step in their order, into a distance,
/// by the scene's estimator, beside the truth and what theory expects. Where the counts
/// give no distance, the report says why.
///
/// ```
/// use std::path::Path;
///
/// use goldtof::photons::StepCount;
///
/// let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
/// // All light is counted up in phase step 40 and its neighbours.
/// let counts: Vec<StepCount> = (0..scene.scan.steps as i64)
///     .map(|step| (100 - 12 * (step - 40).abs()).max(0))
///     .map(|signed| StepCount { signed, total: 200 })
///     .collect();
/// let options = goldtof::EstimateOptions {
///     detector: scene.detectors[0].name.clone(),
/// };
/// let estimate = goldtof::estimate(&scene, &options, &counts)?;
/// assert_eq!(estimate.coarse_phase_step, Some(40));
/// assert!(estimate.distance_m.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the scene has no such detector, its scan another number of steps, or its hardware
/// cannot have counted that.
pub fn estimate(
    scene: &Scene,
    options: &EstimateOptions,
    counts: &[StepCount],
) -> Result<EstimateReport, EstimateError> {
    let name = &options.detector;
    let mut detectors = scene.detectors.iter();
    let Some(detector) = detectors.position(|detector| detector.name == *name).map(DetectorIndex)
    else {
        let known: Vec<String> =
            scene.detectors.iter().map(|detector| format!("\"{}\"", detector.name)).collect();
        return Err(EstimateError::NoDetector { name: name.clone(), known: known.join(", ") });
    };
    // Hardware that sends no total counts leaves them all 0.
    let has_totals = counts.iter().any(|count| count.total != 0);
    let told = |count: &StepCount| (count.signed, has_totals.then_some(count.total));
    let counts = possible_scan(scene, &counts.iter().map(told).collect::<Vec<_>>())?;
    Ok(estimate_scan(&Sensor::new(scene), detector, &counts))
}
