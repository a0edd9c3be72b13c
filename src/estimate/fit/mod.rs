//! The model estimator: delay and strength of every path, and the constant
//! light, fitted to the counts.
//!
//! The mean response of this very detector to this very light can be worked out
//! ([`MeanResponse`]), so nothing need be read off a phase: weighted least
//! squares of (r\[k\], N\[k\]) with the full 2 x 2 covariance of each step, by
//! Gauss-Newton. Range walk, circular error and interference are in the model
//! and do not bias the fit. The background is always unknown, which makes
//! extinction ratio and background harmless at the price of under 2 % of
//! precision.
//!
//! One path is fitted to a window of 3 S steps round the peak. More light is looked
//! for in all of the scan, one source after another ([`joint`]). Light of other codes
//! needs a scan over the whole code period: it hardly shows in a window, but over a
//! scan its cross-correlation is as distinct as the peak.

mod bins;
mod candidates;
mod coarse;
mod descent;
mod fitter;
mod gauss_newton;
mod hadamard;
mod joint;
mod known_moments;
mod least_squares;
pub(super) mod moving;
mod outcome;
mod pairs;
mod problem;
mod shared_light;
mod start;
mod template;

use crate::scene::{Architecture, DetectorIndex, PathIndex};
use std::sync::Arc;

pub use bins::BinFitter;
pub(super) use coarse::best_match;
pub use fitter::Fitter;
pub(super) use least_squares::Weights;
pub(super) use problem::{Parameters, PathParameters, Problem, window};
pub(super) use template::Axis;

use super::bound::bound;
use super::{CountingTier, NoEstimate, TheoryEffort};
use crate::code::Code;
use crate::estimate::histogram::Uncorrected;
use crate::histogram::correction::CorrectionError;
use crate::photons::{DetectorModel, StepCount};
use crate::response::{MeanCount, MeanResponse, MeanResponseError};
pub use crate::scene::OtherLight;
use crate::sensor::Sensor;

/// Chi-square this many standard deviations above its expectation is an alarm;
/// by chance less than one fit in 10,000 has it.
pub const ALARM_SIGMAS: f64 = 5.0;

/// What a fit says of the light.
#[derive(Debug, Clone)]
pub struct ModelEstimate {
    /// Time of flight of the strongest path of the reference, folded into
    /// 0 .. code period.
    pub delay_ps: f64,
    /// Half its optical path.
    pub distance_m: f64,
    /// Standard deviation of the distance, from the counts' covariances.
    pub std_m: f64,
    /// Speed of the path, and the moment at which it is where it says; `None` of paths
    /// that stand still.
    pub velocity: Option<Velocity>,
    /// Every path of the fit, the strongest of the reference first.
    pub paths: Vec<FittedPath>,
    /// Primary rate of all light that is not modulated, dark counts included.
    pub constant_rate_hz: f64,
    /// Weighted sum of squared residuals: about `degrees_of_freedom`, with a
    /// standard deviation of sqrt(2 x that), unless the model lacks something.
    pub chi_square: f64,
    /// Two per step, less the number of unknowns.
    pub degrees_of_freedom: usize,
    /// Phase steps that took part.
    pub steps: usize,
    /// Own paths of the scene that the counts do not tell apart; none if all were
    /// found.
    pub untold: Option<Untold>,
    /// Gauss-Newton steps of the last fit.
    pub iterations: usize,
}

/// How a path moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Velocity {
    /// Speed of the distance, positive away from the sensor.
    pub m_per_s: f64,
    /// Its standard deviation.
    pub std_m_per_s: f64,
    /// The moment that the distance is of, from the start of the scan.
    pub at_s: f64,
}

/// One path of a fit.
#[derive(Debug, Clone)]
pub struct FittedPath {
    /// Its code.
    pub code: Arc<Code>,
    /// Time of flight, folded into 0 .. code period.
    pub delay_ps: f64,
    /// Its standard deviation.
    pub delay_std_ps: f64,
    /// Primary rate that on-chips add.
    pub rate_hz: f64,
    /// Standard deviation of that rate, as a share of it.
    pub rate_relative_std: f64,
}

/// Paths that a scene has and the counts do not show.
#[derive(Debug, Clone, PartialEq)]
pub struct Untold {
    /// How many of the detector's own source were not told apart.
    pub missing: usize,
    /// Two equal paths nearer to each other than this are told apart in less than
    /// 95 % of scans, with the light that was found. As a difference of distances.
    pub resolution_m: f64,
}

impl FittedPath {
    /// How many standard deviations its light is above none.
    pub fn significance(&self) -> f64 {
        1.0 / self.rate_relative_std.max(f64::MIN_POSITIVE)
    }
}

impl std::fmt::Display for Untold {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} more of the own source's paths cannot be told apart from what was found: they are too \
             weak, or within {:.3} m of one (where two equal ones are told apart in 95 % of scans); \
             standard deviations take that in",
            self.missing, self.resolution_m
        )
    }
}

impl ModelEstimate {
    /// How many standard deviations chi-square is above its expectation: the
    /// alarm that the light or the detector is not as modelled.
    pub fn alarm_sigmas(&self) -> f64 {
        let degrees = self.degrees_of_freedom as f64;
        (self.chi_square - degrees) / (2.0 * degrees).sqrt()
    }
}

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
    /// The mean response cannot be had.
    #[error(transparent)]
    MeanResponse(#[from] MeanResponseError),
    /// The counts have no peak to start from.
    #[error(transparent)]
    NoPeak(#[from] NoEstimate),
    /// Not one count per step of the scan.
    #[error("{found} steps were counted, the scan has {steps}")]
    WrongNumberOfCounts {
        /// Counts given.
        found: usize,
        /// Steps of the scan.
        steps: u64,
    },
    /// More light than one path needs more steps.
    #[error(
        "light of more than one path is told apart over a whole scan; this one has {steps} of \
         {steps_per_period} phase steps (write steps = \"all\", or other_light = \"none\" in \
         [estimate] to take all but the strongest path for constant)"
    )]
    NeedsWholeScan {
        /// Steps of the scan.
        steps: u64,
        /// Steps of the code period.
        steps_per_period: u64,
    },
    /// The reference is no code of a Gold set.
    #[error("the reference's code is of no Gold set in which an interferer could be looked for")]
    NoGoldSet,
    /// A path moves in a way that a fit does not follow.
    #[error(
        "path {path} moves; the model estimator follows the only path of a detector, at a constant \
         speed, without a fluctuation (estimator = \"fft\" takes any)"
    )]
    Moves {
        /// Index of the path.
        path: PathIndex,
    },
    /// A path moves faster than a fit follows, or nobody can say how fast.
    #[error(
        "the counts are best explained by a path that moves by {limit_m_per_s:.1} m/s or more, a \
         quarter of a phase step within one: integrate for a shorter time if it is so fast, or for a \
         longer one if the light does not tell its speed"
    )]
    TooFast {
        /// The fastest that is followed.
        limit_m_per_s: f64,
    },
    /// There is nothing to range.
    #[error("nothing modulated reaches the detector")]
    Dark,
    /// The detector's own light does not stand out.
    #[error(
        "no light of the detector's own code stands out: its likeliest place is {sigmas:.1} standard \
         deviations above what is expected without it, and {needed:.1} are asked for, which noise \
         alone exceeds in 0.3 % of scans; integrate longer"
    )]
    OwnNotSeen {
        /// Significance of the likeliest place.
        sigmas: f64,
        /// What it needs.
        needed: f64,
    },
    /// The counts do not determine the unknowns.
    #[error("the counts of {steps} phase steps do not determine {unknowns} unknowns")]
    Undetermined {
        /// Steps that took part.
        steps: usize,
        /// Number of unknowns.
        unknowns: usize,
    },
    /// The counts tell much more of the distance at some places than at others.
    #[error(
        "pulses are shorter than a sample, so that the counts hardly tell where between two samples \
         light comes: their slope here stands for a standard deviation of {std_mm:.1} mm, but it \
         changes by more than half within that or half a sample, so that no estimate is unbiased"
    )]
    Uneven {
        /// Standard deviation by the counts' slope at the scene's own delay.
        std_mm: f64,
    },
    /// Light that a fit to a histogram does not take.
    #[error(
        "{paths} paths carry modulated light to the detector, {own} of them of its own source; the \
         model estimator takes histograms of one path, of the own source (estimator = \"fft\" takes \
         any)"
    )]
    NotOnePath {
        /// Paths with modulated light.
        paths: usize,
        /// Those of the detector's own source.
        own: usize,
    },
    /// How a histogram's bins go together is not known.
    #[error("the model estimator cannot weigh a histogram's bins: {0}")]
    Uncorrected(#[from] Uncorrected),
    /// A histogram is of no such detector.
    #[error(transparent)]
    Correction(#[from] CorrectionError),
    /// Gauss-Newton does not settle.
    #[error(
        "the fit does not settle within {} steps",
        gauss_newton::MOST_ITERATIONS
    )]
    NotConverged,
}

/// Fits the counts of one scan of detector `detector`: [`Fitter::fit`], for one
/// scan only.
///
/// # Errors
/// As there.
///
/// # Panics
/// If the scene has no such detector.
pub fn fit(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    counts: &[StepCount],
    other: OtherLight,
) -> Result<ModelEstimate, FitError> {
    Fitter::new(sensor, detector, tier, other).fit(counts)
}

/// The same for counts that need not be whole, one per step of the scan.
///
/// # Errors
/// As [`fit`].
///
/// # Panics
/// If the scene has no such detector.
pub fn fit_means(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    counts: &[MeanCount],
    other: OtherLight,
) -> Result<ModelEstimate, FitError> {
    Fitter::new(sensor, detector, tier, other).fit_means(counts)
}

/// What to say of joint fits to steps that share their light.
pub fn shared_light(sensor: &Sensor, detector: DetectorIndex) -> Option<String> {
    let parallel = sensor.timing().parallel;
    let other = sensor.scene().other_light;
    (parallel > 1 && !candidates::is_one_path(sensor, detector, other)).then(|| {
        format!(
            "with parallel = {parallel} the phase steps of a group see the same light; of several \
             paths distances then scatter up to 1.7 times as much as the fit says"
        )
    })
}

/// What the fit says of a scene's expected counts, told of other light what the
/// scene says: its average answer, to first order in the noise.
///
/// # Errors
/// As [`fit`].
///
/// # Panics
/// If the scene has no such detector.
pub fn expected_fit(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
) -> Result<ModelEstimate, FitError> {
    if sensor.scene().hardware.architecture == Architecture::Histogram {
        TheoryEffort::of(sensor, detector)?.check_histogram()?;
        return BinFitter::new(sensor, detector)?.expected();
    }
    let other = sensor.scene().other_light;
    let fitter = Fitter::new(sensor, detector, tier, other);
    let moment_ps = fitter.moment_ps()?;
    TheoryEffort::of(sensor, detector)?.check_fit()?;
    let still;
    let standing = match moment_ps {
        Some(moment_ps) => {
            still = sensor.still_at(moment_ps);
            &still
        }
        None => sensor,
    };
    let model = DetectorModel::new(standing, detector);
    let response = MeanResponse::of_tier(&model, tier)?;
    if response.misses_pulses() {
        // A fit settles everywhere, but there its average is not that of the average.
        bound(sensor, detector, tier)?;
    }
    let mut means = response.mean_counts();
    if let Some(moment_ps) = moment_ps {
        moving::take_movement(sensor, &response, tier, moment_ps, &mut means)?;
    }
    fitter.fit_means(&means)
}
