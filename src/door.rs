//! The library's doors: the jobs of a [`Sensor`] are methods ([`Jobs`]) whose options have
//! defaults. The function of a longer job's name does the same and tells its [`Progress`].

use crate::cosim::error::CosimError;
use crate::cosim::own::{self, OwnRtl};
use crate::cosim::source::Verilog;
use crate::cosim::{CosimOptions, Cosimulation, cosimulate};
use crate::deliver::{self, Emission, HdlError, Prefix};
use crate::estimate::report::{EstimateReport, Reporter};
use crate::estimate::{ImpossibleScan, possible_scan};
use crate::grade::{Grade, GradeOptions, Graded, not_graded};
use crate::photons::StepCount;
use crate::progress::Progress;
use crate::run::{Run, RunError, RunOptions, run};
use crate::scene::{Detector, DetectorIndex, EstimatorKind, Scene, TotalsMissing};
use crate::sensor::Sensor;
use crate::simulate::repeat::Simulation;
use crate::simulate::scans::ScansError;
use crate::simulate::{SimulateOptions, Tier, simulate};
use crate::version::MADE_BY;

/// What can be done with a sensor.
///
/// ```
/// use goldtof::{Jobs as _, Sensor};
///
/// let expected = Sensor::load("scenes/quick.toml")?.expected()?;
/// assert!(expected.estimates[0].expected_std_m.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Jobs {
    /// The sensor.
    fn sensor(&self) -> &Sensor;

    /// Verilog of the sensor, with testbench, constraints and file lists; [`deliver::write`] puts
    /// it into a folder.
    ///
    /// ```
    /// use goldtof::{Jobs as _, Sensor};
    ///
    /// let sensor = Sensor::load("scenes/paper-single.toml")?;
    /// let prefix = Some("left_".parse()?);
    /// let emission = sensor.emit(&goldtof::EmitOptions { prefix, ..Default::default() })?;
    /// assert_eq!(emission.clock_hz, 125e6); // one clock is one chip of 8 ns
    /// assert_eq!(emission.top, "left_sensor_top");
    /// assert!(emission.files.iter().any(|file| file.name == "left_gold_generator.v"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// When the scene asks for more than the hardware supports.
    fn emit(&self, options: &EmitOptions) -> Result<Emission, HdlError> {
        let prefix = options.prefix.clone().unwrap_or_default();
        deliver::emit_prefixed(self.sensor(), &prefix, &options.made_by)
    }

    /// Expected bias and standard deviation of each path's distance, from the exact mean response
    /// of the detectors, without random numbers.
    ///
    /// ```
    /// use goldtof::{Jobs as _, Sensor};
    ///
    /// let expected = Sensor::load("scenes/quick.toml")?.expected()?;
    /// let path = &expected.estimates[0];
    /// assert!((path.true_distance_m - 3.2).abs() < 1e-9);
    /// println!("{:?} m, {:?} m", path.expected_bias_m, path.expected_std_m);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// When the scene is beyond the exact response.
    fn expected(&self) -> Result<Simulation, ScansError> {
        self.simulate(Tier::Expected.scans(1))
    }

    /// Repeated scans, photons to distances.
    ///
    /// ```
    /// use goldtof::simulate::Tier;
    /// use goldtof::{Jobs as _, Sensor};
    ///
    /// let simulation = Sensor::load("scenes/quick.toml")?.simulate(Tier::Counts.scans(20))?;
    /// let path = &simulation.estimates[0];
    /// assert_eq!(path.estimates + path.missed_scans, 20);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// When the scene is outside the tier's domain, or a tool that it needs is missing or fails.
    fn simulate(&self, options: SimulateOptions) -> Result<Simulation, ScansError> {
        simulate(self.sensor(), options, |_| ())
    }

    /// Verilog, emitted or your own, against the bit-exact reference model: every output port at
    /// every clock. A mismatch is a result.
    ///
    /// ```no_run
    /// use std::path::Path;
    ///
    /// use goldtof::cosim::{StimulusKind, Verdict};
    /// use goldtof::{Jobs as _, Sensor};
    ///
    /// let sensor = Sensor::load("scenes/quick.toml")?;
    /// let mut found = sensor.cosim(&goldtof::CosimOptions {
    ///     own: goldtof::OwnRtl::folder("my_rtl"),
    ///     stimulus: StimulusKind::Adversarial,
    ///     ..Default::default()
    /// })?;
    /// if found.report.verdict == Verdict::Mismatch {
    ///     found.write_vcd(Path::new("mismatch.vcd"))?;
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// When the scene has no hardware, the Verilog does not fit it or ends its own simulation,
    /// or a tool is missing or fails.
    fn cosim(&self, options: &CosimOptions) -> Result<Cosimulation, CosimFailed> {
        cosim(self.sensor(), options, |_| ())
    }

    /// Fault coverage of a stimulus on the emitted Verilog or your own.
    ///
    /// # Errors
    /// When the scene has no hardware, the Verilog does not fit it, differs from the reference
    /// model or cannot be graded, or a tool is missing or fails.
    fn grade(&self, options: &GradeOptions) -> Result<Grade, CosimFailed> {
        grade(self.sensor(), options, |_| ())
    }

    /// Distance from the counts of a scan, one of each phase step in their order, beside the
    /// truth and the expectation. Where the counts give no distance, the report says why.
    ///
    /// ```
    /// use goldtof::photons::StepCount;
    /// use goldtof::{Jobs as _, Sensor};
    ///
    /// let sensor = Sensor::load("scenes/quick.toml")?;
    /// // All light is counted up in phase step 40 and its neighbours.
    /// let counts: Vec<StepCount> = (0..sensor.scene().scan.steps as i64)
    ///     .map(|step| (100 - 12 * (step - 40).abs()).max(0))
    ///     .map(|signed| StepCount { signed, total: 200 })
    ///     .collect();
    /// let estimate = sensor.estimate(&goldtof::EstimateOptions::default(), &counts)?;
    /// assert_eq!(estimate.coarse_phase_step, Some(40));
    /// assert!(estimate.distance_m.is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// When the scene has no such detector, its scan another number of steps, or its hardware
    /// cannot have counted that.
    fn estimate(
        &self,
        options: &EstimateOptions,
        counts: &[StepCount],
    ) -> Result<EstimateReport, EstimateError> {
        let sensor = self.sensor().with_estimator(options.estimator)?.summed();
        let scene = sensor.scene();
        let detector = detector_named(scene, options.detector.as_deref())?;
        // Hardware that sends no total counts leaves them all 0.
        let has_totals = counts.iter().any(|count| count.total != 0);
        let told = |count: &StepCount| (count.signed, has_totals.then_some(count.total));
        let counts = possible_scan(scene, &counts.iter().map(told).collect::<Vec<_>>())?;
        Ok(Reporter::new(&sensor, detector).scan(&counts))
    }

    /// The main job: plan, emission, photon simulation, co-simulation, estimates and report, into
    /// `options.out`, or `out` and the scene's name: the Verilog (in `rtl`), `counts.csv`, of histograms `bins.csv` too,
    /// `report.html`, after a mismatch `mismatch.vcd`, and `waves.vcd` if asked for. A mismatch of
    /// Verilog and reference model is a result.
    ///
    /// ```no_run
    /// use goldtof::{Jobs as _, Sensor};
    ///
    /// let sensor = Sensor::load("scenes/quick.toml")?;
    /// let run = sensor.run(&goldtof::RunOptions::default())?;
    /// println!("{}: {:?}", run.cosim.verdict, run.estimates[0].distance_m);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// When the scene has no hardware, a tool is missing or fails, or a file cannot be
    /// written.
    fn run(&self, options: &RunOptions) -> Result<Run, RunError> {
        run(self.sensor(), options, |_| ())
    }
}

impl Jobs for Sensor {
    fn sensor(&self) -> &Sensor {
        self
    }
}

/// How to emit.
#[derive(Debug, Clone, clap::Args)]
pub struct EmitOptions {
    /// Prefix of the names of all modules, files and macros, so that one design can hold
    /// several sensors: a letter, then letters, digits and single underscores, at most
    /// 64 characters, for example --prefix left_ [default: none]
    #[arg(long, value_name = "NAME")]
    pub prefix: Option<Prefix>,
    /// What the files say that they were made by: the command, as a rule
    #[arg(skip)]
    pub made_by: String,
}

impl Default for EmitOptions {
    fn default() -> EmitOptions {
        EmitOptions { prefix: None, made_by: MADE_BY.to_owned() }
    }
}

/// Why nothing was compared.
#[derive(Debug, thiserror::Error)]
pub enum CosimFailed {
    /// The hardware cannot be emitted.
    #[error(transparent)]
    Hdl(#[from] HdlError),
    /// The Verilog cannot be read, built or run.
    #[error("{0}")]
    Cosim(#[from] CosimError),
}

/// Whose counts they are, and what turns them into a distance.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct EstimateOptions {
    /// Estimator [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    /// Name of the detector; the scene's first if none is given
    #[arg(skip)]
    pub detector: Option<String>,
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
    /// The estimator needs counts that the hardware does not send.
    #[error(transparent)]
    Totals(#[from] TotalsMissing),
}

/// The detector of this name, or the scene's first.
///
/// # Errors
/// When there is none.
pub(crate) fn detector_named(
    scene: &Scene,
    name: Option<&str>,
) -> Result<DetectorIndex, EstimateError> {
    let is_meant = |detector: &Detector| name.is_none_or(|name| detector.name == name);
    scene.detectors.iter().position(is_meant).map(DetectorIndex).ok_or_else(|| {
        let known = scene.detectors.iter().map(|detector| format!("\"{}\"", detector.name));
        EstimateError::NoDetector {
            name: name.unwrap_or_default().to_owned(),
            known: known.collect::<Vec<_>>().join(", "),
        }
    })
}

/// [`Jobs::cosim`] with its progress in clocks.
///
/// # Errors
/// As there.
pub fn cosim(
    sensor: &Sensor,
    options: &CosimOptions,
    mut on_progress: impl FnMut(Progress),
) -> Result<Cosimulation, CosimFailed> {
    let (verilog, remarks) = verilog(sensor, &options.own, &options.made_by)?;
    let parts = |done, of| on_progress(Progress::Parts { done, of });
    let mut done = cosimulate(sensor, &verilog, options, parts)?;
    done.report.remarks.splice(0..0, remarks);
    Ok(done)
}

/// [`Jobs::grade`] with its progress in stages.
///
/// # Errors
/// As there.
pub fn grade(
    sensor: &Sensor,
    options: &GradeOptions,
    on_progress: impl FnMut(Progress),
) -> Result<Grade, CosimFailed> {
    let graded = grade_some(sensor, options, |count| (0..count).collect(), on_progress)?;
    Ok(graded.grade(options))
}

/// What becomes of some faults and mutants of a design: of those that `choose` says, by
/// their numbers in order, given how many there are of a kind.
///
/// # Errors
/// As [`grade`].
pub(crate) fn grade_some(
    sensor: &Sensor,
    options: &GradeOptions,
    choose: impl Fn(usize) -> Vec<usize> + Sync,
    mut on_progress: impl FnMut(Progress),
) -> Result<Graded, CosimFailed> {
    let (verilog, _) = verilog(sensor, &options.own, &options.made_by)?;
    let stage = |what| on_progress(Progress::Stage(what));
    Ok(crate::grade::grade(sensor, &verilog, options, choose, stage).map_err(not_graded)?)
}

/// SHA-256 of the design that is graded, in hexadecimal digits: of its top module's name and of
/// name and text of every file.
///
/// # Errors
/// When it cannot be emitted or read.
pub(crate) fn sha256_of(sensor: &Sensor, options: &GradeOptions) -> Result<String, CosimFailed> {
    let (verilog, _) = verilog(sensor, &options.own, &options.made_by)?;
    let files = verilog.sources.iter().flat_map(|file| [&file.name, &file.text]);
    Ok(crate::digest::sha256_of_all(std::iter::once(&verilog.top).chain(files)))
}

/// The user's own Verilog, or else the emitted one; and what was ignored of it, or assumed.
fn verilog(
    sensor: &Sensor,
    own: &OwnRtl,
    made_by: &str,
) -> Result<(Verilog, Vec<String>), CosimFailed> {
    if own.is_given() {
        return Ok(own::read(own, sensor.interface())?);
    }
    let files = deliver::verilog(sensor, &Prefix::default(), made_by)?;
    Ok((Verilog::emitted(sensor, &files)?, Vec::new()))
}
