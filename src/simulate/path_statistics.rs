//! What the scans of a detector say of one path.

use serde::Serialize;

use crate::estimate::bound::BoundKind;
use crate::scene::PathIndex;

/// Statistics of the estimates that a detector's scans give of one path.
///
/// A repetition counts for the path nearest to its estimate, if that is within a
/// chip of it; mean and scatter are over the repetitions that count for the path.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct PathStatistics {
    /// Name of the detector.
    pub detector: String,
    /// Name of the source whose light the path carries.
    pub source: String,
    /// Index of the path in the scene.
    pub path: PathIndex,
    /// True distance, folded into the unambiguous range; without a fluctuation,
    /// whose effect belongs to the scatter.
    pub true_distance_m: f64,
    /// When a path that moves has it, from the start of the scan: as the scan comes
    /// by the path. None for a path that stands still.
    pub true_distance_at_s: Option<f64>,
    /// Repetitions that count for the path.
    pub estimates: u64,
    /// Repetitions that miss the path: no estimate within a chip of it (of a code of
    /// fewer than four chips, within a quarter of its period;
    /// [`crate::estimate::tolerance_ps`]), or another path is nearer.
    pub missed_scans: u64,
    /// Their share of all repetitions; of the tier that draws nothing the expected
    /// share. None where that cannot be told.
    pub missed_fraction: Option<f64>,
    /// Its 95 % confidence interval (Wilson); none without repetitions.
    pub missed_fraction_ci95: Option<[f64; 2]>,
    /// The share that the exact moments of the counts give, by the same definition.
    /// None where it cannot be told (the model estimator with several paths).
    pub expected_missed_fraction: Option<f64>,
    /// One less `missed_fraction`: how often the coarse stage is right.
    pub correct_coarse_fraction: Option<f64>,
    /// Share of the detector's scans that `goldtof estimate` would refuse, since scans without any
    /// light of its source have as large counts ([`crate::estimate::chance`]). They take part in all
    /// else that stands here, as in what is expected. None without scans.
    pub refused_fraction: Option<f64>,
    /// Mean estimate, folded into the unambiguous range; none without estimates, or
    /// where they are spread all over the range ([`crate::estimate::unwrap`]).
    pub mean_distance_m: Option<f64>,
    /// Mean error, the shorter way round the unambiguous range. Errors are taken
    /// round their circular mean, and so is `std_m`.
    pub bias_m: Option<f64>,
    /// Standard deviation of one scan's estimate; none below two estimates.
    pub std_m: Option<f64>,
    /// Standard error of `mean_distance_m` and `bias_m`.
    pub bias_std_error_m: Option<f64>,
    /// Standard error of `std_m`, for normal errors, or larger where their fourth
    /// moment says so.
    pub std_std_error_m: Option<f64>,
    /// The bias that the exact mean response gives: the estimator's answer to
    /// the expected counts.
    pub expected_bias_m: Option<f64>,
    /// The standard deviation that it gives.
    pub expected_std_m: Option<f64>,
    /// Whether the scans bear out the three expectations, within what they claim and with a
    /// chance of 1 in 10,000 to be accused wrongly ([`crate::estimate::evidence`]); none
    /// without scans, or without an expectation.
    pub expectation_holds: Option<bool>,
    /// How the scans contradict them, where they do.
    pub expectation_remark: Option<String>,
    /// Least standard deviation of an estimate from these counts ([`crate::estimate::bound`]).
    pub bound_m: Option<f64>,
    /// What `bound_m` is; none without one.
    pub bound_kind: Option<BoundKind>,
    /// `std_m` in bounds.
    pub std_over_bound: Option<f64>,
    /// Why there is no bound, or of which steps it is where not of all.
    pub bound_remark: Option<String>,
    /// Share of this detector's fits whose chi-square says that the light or the
    /// detector is not as modelled; none for the phase estimator.
    pub chi_square_alarm_fraction: Option<f64>,
    /// Rate of counted detections.
    pub detected_rate_cps: f64,
    /// Why there is no fine estimate, where that is so.
    pub remark: Option<String>,
}
