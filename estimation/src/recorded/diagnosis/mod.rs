//! Diagnosis of a sensor whose counts differ from the expectation of its scene.
//!
//! Every statement rests on a test, and all tests are one [`Comparisons`]: by design they reject a
//! correct scene in about one scan of a hundred (docs/recorded-counts.md has what was measured). At
//! first only the distance is unknown. Of light level, background, dead time, afterpulsing, chip period, integration
//! time and the other recharge, the one that raises the likelihood most is freed, and the next, as long as the gain is significant. Where
//! several do about as well, all of them are named: the counts do not tell which it is. A cause that
//! is named fits the counts; another one, or several together, may fit them as well.
//!
//! The chip period is a special case: code and counter run off one clock, so that another period leaves the counts what
//! they are but for what the detector does in its own time. It stands for any mistake of the detector's times at once, while
//! a crystal is exact to ppm. So another cause that does about as well comes first, and dead time and afterpulsing take its
//! place, unless the peak stands at the scene's path by that clock alone; and where the chip period does not explain the
//! counts by itself, they are explained without it, if they can be.

mod causes;
mod conclusion;
mod darkness;
mod other_codes;
mod start;

use serde::Serialize;

use super::Cause;
use super::hypothesis::{SceneFit, Unknown};
use super::observed::Observed;
use crate::estimate::evidence::Comparisons;
use crate::estimate::fit::FitError;
use crate::math::normal_cdf;
use crate::scene::{Detector, Scene, SourceIndex};
use crate::sensor::Sensor;
pub(super) use start::{delay_of_scene, fit_of_scene};

/// Probability that any of the tests rejects a correct scene, and their largest number.
const WRONG: f64 = 0.014;
const TESTS: usize = 9;

/// Hits of a step, on average over a scan, or of a histogram, from which on causes are
/// looked for: of scans with 370 the tests accuse a right scene as seldom as their level
/// says, of scans with 7 one time in five.
pub const FEWEST_HITS: f64 = 300.0;

/// A test and its outcome.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct TestOutcome {
    /// What is tested.
    pub cause: Cause,
    /// Gain of twice the log-likelihood, by chance a chi-square of one degree of freedom; for
    /// the residuals, their chi-square.
    pub statistic: f64,
    /// Probability of a statistic at least as large if the scene is right.
    pub p_value: Option<f64>,
    /// Whether it is below the test's level.
    pub rejects: bool,
    /// The scene's value, in `unit`.
    pub scene_value: Option<f64>,
    /// The fitted value.
    pub fitted_value: Option<f64>,
    /// Its standard deviation.
    pub fitted_value_std: Option<f64>,
    /// Unit of the values.
    pub unit: &'static str,
}

/// What the counts show about the scene.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Diagnosis {
    /// Causes that fit the counts better than the scene, the strongest first; empty if there are
    /// none. Causes that the counts do not distinguish are all listed.
    pub causes: Vec<Cause>,
    /// The same in a sentence.
    pub sentence: String,
    /// Every test that was done.
    pub tests: Vec<TestOutcome>,
    /// What could not be tested, and why.
    pub not_tested: Vec<String>,
}

/// Tests a scan against its scene: the diagnosis, and the fit behind it. `delays_ps` are candidates for
/// the delay of its peak, relative to the scene's: the tests begin with the one that agrees best. The scan
/// `may_be_dark` if its peak may be chance.
pub(super) fn diagnose(
    sensor: &Sensor,
    observed: Observed,
    delays_ps: &[f64],
    may_be_dark: bool,
) -> Result<(Diagnosis, SceneFit), FitError> {
    let mut examination = Examination {
        sensor,
        scene: sensor.scene(),
        observed,
        unknowns: vec![Unknown::Delay],
        fitted: fit_of_scene(sensor, observed, delays_ps)?,
        tests: Vec::new(),
        alike: Vec::new(),
        has_right_clock: false,
        not_tested: Vec::new(),
    };
    if examination.fitted.errors.is_empty() {
        examination.unknowns.clear();
    }
    if let Some(nothing) = examination.without_hits()? {
        return Ok(nothing);
    }
    let hits = examination.fitted.expected.hits();
    if hits < FEWEST_HITS {
        return Ok(examination.too_few_hits(hits));
    }
    if let Some(dark) = may_be_dark.then(|| examination.without_light()).flatten() {
        return Ok(dark);
    }
    let mut examination = examination.with_causes();
    let codes = match examination.is_explained() {
        true => Vec::new(),
        false => examination.other_codes(),
    };
    Ok(examination.conclude(codes))
}

#[derive(Clone)]
struct Examination<'s> {
    sensor: &'s Sensor,
    scene: &'s Scene,
    observed: Observed<'s>,
    unknowns: Vec<Unknown>,
    fitted: SceneFit,
    tests: Vec<TestOutcome>,
    /// Freed parameters, each with those that do about as well.
    alike: Vec<Vec<Unknown>>,
    /// Whether the chip period is taken for the scene's.
    has_right_clock: bool,
    not_tested: Vec<String>,
}

/// Chance of a chi-square of one degree of freedom above `statistic`.
fn chance(statistic: f64) -> f64 {
    2.0 * normal_cdf(-statistic.max(0.0).sqrt())
}

fn family() -> Comparisons {
    Comparisons::of(WRONG, TESTS)
}

/// The chi-square of one degree of freedom that has the chance of a test to be wrong.
fn critical() -> f64 {
    family().sigmas().powi(2)
}
impl TestOutcome {
    /// Of a test that has no value of the scene.
    fn new(cause: Cause, statistic: f64, p_value: Option<f64>, rejects: bool) -> TestOutcome {
        TestOutcome {
            cause,
            statistic,
            p_value,
            rejects,
            scene_value: None,
            fitted_value: None,
            fitted_value_std: None,
            unit: "",
        }
    }
}

impl Diagnosis {
    /// Where nothing is said but this.
    fn new(causes: &[Cause], sentence: impl Into<String>) -> Diagnosis {
        Diagnosis {
            causes: causes.to_vec(),
            sentence: sentence.into(),
            tests: Vec::new(),
            not_tested: Vec::new(),
        }
    }
}

impl Examination<'_> {
    /// The scene's detector.
    fn spad(&self) -> &Detector {
        &self.scene.detectors[self.observed.detector()]
    }

    /// The source whose code its reference is.
    fn own(&self) -> SourceIndex {
        self.spad().reference
    }

    fn is_explained(&self) -> bool {
        self.fitted.p_value.is_none_or(|p| p >= family().level())
    }
}
