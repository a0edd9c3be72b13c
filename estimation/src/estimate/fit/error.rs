//! Errors of fits.

use crate::estimate::NoEstimate;
use crate::estimate::approximation::Approximation;
use crate::estimate::dead_time::Uncorrected;
use crate::histogram::correction::CorrectionError;
use crate::response::MeanResponseError;
use crate::scene::PathIndex;

/// Why a fit failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
    /// The mean response cannot be had.
    #[error(transparent)]
    MeanResponse(#[from] MeanResponseError),
    /// The counts do not have a peak to start from.
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
    /// The reference's code does not belong to a Gold set.
    #[error(
        "the reference's code does not belong to a Gold set in which an interferer could be searched for"
    )]
    NoGoldSet,
    /// A path moves in a way that the fit does not model.
    #[error(
        "path {path} moves; the model estimator follows a detector's only path, at a constant \
         speed, without a fluctuation (estimator = \"fft\" accepts any)"
    )]
    Moves {
        /// Index of the path.
        path: PathIndex,
    },
    /// A path moves faster than a fit follows, or its speed is unknown.
    #[error(
        "the counts are best explained by a path that moves by {limit_m_per_s:.1} m/s or more, a \
         quarter of a phase step within one: integrate for a shorter time if it is that fast, or for a \
         longer one if the light does not determine its speed"
    )]
    TooFast {
        /// The fastest that is followed.
        limit_m_per_s: f64,
    },
    /// It would take too long.
    #[error(
        "a fit to this light would take about {seconds:.0} s of one core, and no more than {limit_s:.0} s \
         is spent on a scan: attenuate the light, or use fewer paths, a shorter dead time or a \
         shorter code; estimator = \"fft\" accepts any"
    )]
    TooLong {
        /// How long.
        seconds: f64,
        /// The limit.
        limit_s: f64,
    },
    /// No modulated light.
    #[error("nothing modulated reaches the detector")]
    Dark,
    /// The detector's own light does not stand out.
    #[error(
        "the light of the detector's own code does not stand out: its strongest correlation is {sigmas:.1} \
         standard deviations above the expectation without it, and {needed:.1} are required, which noise \
         alone exceeds in 0.3 % of scans; integrate longer"
    )]
    OwnNotSeen {
        /// Significance of the likeliest place.
        sigmas: f64,
        /// What it needs.
        needed: f64,
    },
    /// The counts do not determine the unknowns.
    #[error("{steps} phase steps or bins do not determine {unknowns} unknowns")]
    Undetermined {
        /// Phase steps, or bins, that took part.
        steps: usize,
        /// Number of unknowns.
        unknowns: usize,
    },
    /// The counts are much more sensitive to the distance in some places than in others.
    #[error(
        "the counts change unevenly with the distance: their slope at the scene's corresponds to a standard deviation of \
         {std_mm:.1} mm, but within five of them, or a phase step, the counts have another slope, one {read:.2} of the \
         other, so that no estimate is unbiased, and none scatters as a slope says. Corners of the code's correlation \
         are a phase step apart (more samples_per_chip or more light make them matter less), and pulses shorter than \
         a sample are missed between two samples"
    )]
    Uneven {
        /// Standard deviation from the counts' slope at the scene's delay.
        std_mm: f64,
        /// What a slope reads another one as; 1 if they are alike.
        read: f64,
    },
    /// Close paths of few samples a chip.
    #[error(
        "two paths of one code are within {chips} chips of each other, and a chip has {samples_per_chip} samples: corners of \
         the code's correlation, a phase step apart, give the likelihood several peaks, and the slopes of the counts do not tell how the fit scatters \
         (8 samples_per_chip or more, or paths farther apart)"
    )]
    Close {
        /// Samples that a chip has.
        samples_per_chip: f64,
        /// How near is too near.
        chips: f64,
    },
    /// Light that a fit to a histogram does not model.
    #[error(
        "{paths} paths carry modulated light to the detector, {own} of them from its own source; the \
         model estimator fits histograms of one path, from the own source (estimator = \"fft\" accepts \
         any)"
    )]
    NotOnePath {
        /// Paths with modulated light.
        paths: usize,
        /// Those of the detector's own source.
        own: usize,
    },
    /// The correlation of a histogram's bins is not known.
    #[error("the model estimator cannot weight a histogram's bins: {0}")]
    Uncorrected(#[from] Uncorrected),
    /// The histogram cannot be of this detector.
    #[error(transparent)]
    Correction(#[from] CorrectionError),
    /// The fit does not converge.
    #[error("the fit does not settle within {steps} steps")]
    NotConverged {
        /// Gauss-Newton steps that were taken.
        steps: usize,
    },
}
