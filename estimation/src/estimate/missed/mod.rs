//! Missed peaks: their definition, and their expected share.
//!
//! A scan *finds* a path if its estimate lies within [`tolerance_ps`](super::tolerance_ps) of the path's
//! true delay, the shorter way round the code period, and no other path of the same
//! source is nearer to it. Else it *misses the peak*. Simulation, prediction and
//! documents use this one definition, for either estimator.

mod drawn;
mod largest;
mod target;
mod wedge;

pub(super) use self::drawn::DrawnErrors;
use self::target::MissConditions;
pub(super) use self::target::{counted_errors_ps, errors_wrap};
use super::expected_counts::ExpectedCounts;
use super::phase::is_one_window;
use super::truth::Asked;
use crate::scan::Step;
use crate::scene::{Architecture, EstimatorKind};
use crate::sensor::Sensor;

/// Shares of misses below this are not worked out any further than the sum of the
/// chances of all wrong steps.
const NEGLIGIBLE: f64 = 1e-7;

/// Expected share of scans that miss the peak of a path; `None` if it is not
/// known (the model estimator with several paths, or with jitter of half a chip and more). `bound` is the sum of the chances
/// that a wrong step counts more than `peak`, the expected one.
///
/// One phase step at a time counts light of its own: the chances that each step has
/// the largest count, and that the phase round it leads to the path, are integrals
/// over that count ([`largest`]). Steps that share their light, and the shape that the
/// model estimator looks for, are correlated: scans are drawn from the counts' exact
/// means and covariances, always the same ones ([`drawn`]).
pub(super) fn missed_fraction(
    counts: &ExpectedCounts,
    asked: &Asked,
    (peak, bound): (usize, f64),
) -> Option<f64> {
    let (target, sensor) = (MissConditions::new(asked), asked.sensor);
    let is_model = sensor.scene().estimator == EstimatorKind::Model;
    let is_alone = || {
        let model = counts.model();
        model.modulated_paths().count() <= 1 && model.slipping().next().is_none()
    };
    // A fit of several paths may not tell them apart, and one under light of other clocks may not find
    // its own.
    if is_model && !is_alone() {
        return None;
    }
    // The bound accounts for steps that are not the path's own, and not for the phase round these, which another path
    // may turn.
    let one_window = is_one_window(sensor.timing());
    let is_led = !one_window && target.is_alone() && target.finds_from(&counts.signed(), peak);
    if bound < NEGLIGIBLE && is_led {
        return Some(bound);
    }
    // A peak as wide leads a fit to the path from much farther than the path's own chip: of starts that were farther, 4 % in
    // jitter of a chip, one in twenty missed.
    if is_model && target.blurred_chips() > 0 {
        return None;
    }
    let missed = if is_drawn(sensor) {
        drawn::missed(counts, &target)?
    } else if one_window {
        1.0 - target::of_whole_period(counts, &target)
    } else {
        largest::missed(counts, &target)
    };
    Some(missed.clamp(0.0, 1.0))
}

/// Mean and standard deviation of a path's errors, in ps, as scans have them whose largest
/// count is near step `peak`: drawn from the exact moments, with
/// what the coarse stage's choice among several steps and large errors of the phase do. None
/// where hardly any scan finds the path.
pub(super) fn drawn_errors(
    counts: &ExpectedCounts,
    asked: &Asked,
    peak: usize,
) -> Option<DrawnErrors> {
    drawn::errors(counts, &MissConditions::new(asked), peak)
}

/// The same of the values of a histogram's phase steps, taken as normal numbers: `covariance` gives
/// those of some steps.
///
/// # Errors
/// As `covariance`.
pub(super) fn drawn_errors_of_values<E>(
    values: &[f64],
    covariance: impl FnOnce(&[Step]) -> Result<Vec<Vec<f64>>, E>,
    asked: &Asked,
    peak: usize,
) -> Result<Option<DrawnErrors>, E> {
    drawn::errors_of_values(values, covariance, &MissConditions::new(asked), peak)
}

/// Whether the share is counted in drawn scans.
fn is_drawn(sensor: &Sensor) -> bool {
    sensor.scene().estimator == EstimatorKind::Model || sensor.timing().parallel > 1
}

/// Error of an expected share of misses, where it is counted in drawn scans, those of a histogram's phase with its errors: four
/// of its standard errors, and what none of them shows.
pub fn share_error(sensor: &Sensor, share: f64, are_errors_drawn: bool) -> f64 {
    let is_histogram = sensor.scene().hardware.architecture == Architecture::Histogram;
    let scans = match is_drawn(sensor) {
        true => drawn::scans(sensor) as f64,
        false if is_histogram && are_errors_drawn => drawn::SCANS_FOR_ERRORS as f64,
        false => return 0.0,
    };
    4.0 * (share * (1.0 - share) / scans).sqrt() + 10.0 / scans
}
