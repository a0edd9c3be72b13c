//! Why there is no fit.

use crate::estimate::NoEstimate;
use crate::estimate::approximation::Approximation;
use crate::estimate::dead_time::Uncorrected;
use crate::histogram::correction::CorrectionError;
use crate::response::MeanResponseError;
use crate::scene::PathIndex;

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
    /// The mean response cannot be had.
    #[error(transparent)]
    MeanResponse(#[from] MeanResponseError),
    /// The counts have no peak to start from.
    #[error(transparent)]
    NoPeak(#[from] NoEstimate),
    /// An approximation behind what is expected of fits does not hold.
    #[error(transparent)]
    NotCovered(#[from] Approximation),
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
    /// It would take too long.
    #[error(
        "to fit this light would take about {seconds:.0} s of one core, and no more than {limit_s:.0} s \
         is spent on a scan: attenuate the light, or take fewer paths, a shorter dead time or a \
         shorter code; estimator = \"fft\" takes any"
    )]
    TooLong {
        /// How long.
        seconds: f64,
        /// The longest that is done.
        limit_s: f64,
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
    #[error("the fit does not settle within {steps} steps")]
    NotConverged {
        /// Gauss-Newton steps that were taken.
        steps: usize,
    },
}
