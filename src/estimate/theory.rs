//! What theory says of a detector's scans, from one solution of its state.

use super::bound::{Bound, bound_of};
use super::histogram;
use super::prediction::{missed_from, moves, predict_from};
use super::{CountingTier, Prediction, PredictionError, TheoryEffort, bound::bound, predict};
use crate::estimate::fit::FitError;
use crate::photons::DetectorModel;
use crate::response::{MeanCount, MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::Step;
use crate::scene::{Architecture, DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// Predictions and bound of one detector.
#[derive(Debug, Clone)]
pub struct Theory {
    /// What the phase estimator will say of each path that was asked for.
    pub predictions: Vec<Result<Prediction, PredictionError>>,
    /// Share of scans that miss each of them: those of the predictions, and of paths
    /// that there is only a coarse estimate of.
    pub missed: Vec<Option<f64>>,
    /// How precise any estimator can be.
    pub bound: Result<Bound, FitError>,
}

/// [`predict`] for some paths and [`bound`](super::bound::bound) together, which
/// share nearly all of their work.
///
/// # Panics
/// If the scene has no such detector or paths.
pub fn theory(
    sensor: &Sensor,
    detector: DetectorIndex,
    paths: &[PathIndex],
    counting: CountingTier,
) -> Theory {
    if sensor.scene().hardware.architecture == Architecture::Histogram {
        return histogram::theory(sensor, detector, paths);
    }
    if moves(sensor, detector) {
        // Each phase step has a response of its own.
        if let Err(reason) = checked_effort(sensor, detector, paths.len()) {
            return Theory::refused(reason, paths.len());
        }
        let predict = |&path: &PathIndex| predict(sensor, detector, path, counting);
        let predictions: Vec<_> = paths.iter().map(predict).collect();
        return Theory {
            missed: predictions
                .iter()
                .map(|p| p.ok()?.missed_fraction)
                .collect(),
            predictions,
            bound: bound(sensor, detector, counting),
        };
    }
    let effort = match checked_effort(sensor, detector, paths.len()) {
        Ok(effort) => effort,
        Err(reason) => return Theory::refused(reason, paths.len()),
    };
    let of_counts = |counts: &ExpectedCounts| {
        let predict = |&path: &PathIndex| predict_from(counts, sensor, detector, path, counting);
        let predictions: Vec<_> = paths.iter().map(predict).collect();
        let missed = |(predicted, &path): (&Result<Prediction, _>, &PathIndex)| match predicted {
            Ok(predicted) => predicted.missed_fraction,
            Err(PredictionError::CoarseOnly(_)) => {
                missed_from(counts, sensor, detector, path, counting)
            }
            // A peak that is not there is not found.
            Err(PredictionError::Flat) => Some(1.0),
            Err(_) => None,
        };
        Theory {
            missed: predictions.iter().zip(paths).map(missed).collect(),
            predictions,
            bound: match effort.check_bound() {
                Ok(()) => bound_of(sensor, detector, counting, counts),
                Err(reason) => Err(reason.into()),
            },
        }
    };
    let model = DetectorModel::new(sensor, detector);
    let solved = MeanResponse::of_tier(&model, counting).and_then(|response| {
        let second = SecondMoments::new(&response)?;
        Ok(of_counts(&ExpectedCounts::new(&response, &second)))
    });
    solved.unwrap_or_else(|reason: MeanResponseError| Theory::refused(reason, paths.len()))
}

impl Theory {
    pub(super) fn refused(reason: MeanResponseError, paths: usize) -> Theory {
        Theory {
            predictions: vec![Err(reason.into()); paths],
            missed: vec![None; paths],
            bound: Err(reason.into()),
        }
    }
}

/// What theory takes, if predictions of so many paths do not take too long.
fn checked_effort(
    sensor: &Sensor,
    detector: DetectorIndex,
    paths: usize,
) -> Result<TheoryEffort, MeanResponseError> {
    let effort = TheoryEffort::of(sensor, detector)?;
    effort.check_predictions(paths)?;
    Ok(effort)
}

/// The expected counts of a scan, and what their second moments follow from.
pub(super) struct ExpectedCounts<'r, 'm> {
    pub response: &'r MeanResponse<'m>,
    pub second: &'r SecondMoments<'r, 'm>,
    /// Of every step.
    pub means: Vec<MeanCount>,
}

impl<'r, 'm> ExpectedCounts<'r, 'm> {
    pub fn new(
        response: &'r MeanResponse<'m>,
        second: &'r SecondMoments<'r, 'm>,
    ) -> ExpectedCounts<'r, 'm> {
        ExpectedCounts {
            response,
            second,
            means: response.mean_counts(),
        }
    }

    pub fn model(&self) -> &'m DetectorModel {
        self.response.model()
    }

    /// Of some steps.
    pub fn of_steps(&self, steps: &[Step]) -> Vec<MeanCount> {
        steps.iter().map(|step| self.means[step.index()]).collect()
    }

    /// Expected signed counts.
    pub fn signed(&self) -> Vec<f64> {
        self.means.iter().map(|mean| mean.signed).collect()
    }
}
