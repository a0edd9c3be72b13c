//! What theory says of a detector's scans, from one solution of its state.

use super::bound::{Bound, bound, bound_of};
use super::expected_counts::ExpectedCounts;
use super::fit::bins::BinFitter;
use super::fit::error::FitError;
use super::prediction::{Prediction, PredictionError, moves};
use super::{CountingTier, TheoryEffort, histogram, moving, still};
use crate::photons::DetectorModel;
use crate::response::{MeanResponse, MeanResponseError, SecondMoments};
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

/// Predicts the phase estimator's bias against path `path`, and its standard
/// deviation, for counts of tier `counting`.
///
/// The standard deviation comes from the phase's linearisation: with Z the
/// fundamental, the phase's error is the sum over offsets i of the count's error
/// times sin(pi i / S + phi) / |Z|. Steps of one group (`parallel` in the sensor)
/// see the same detections, so their counts go together; groups are independent.
/// Paths may move, slowly beside the phase steps; the bias is against their
/// [`true_delay`](super::true_delay).
///
/// # Panics
/// If the scene has no such detector or path.
pub fn predict(
    sensor: &Sensor,
    detector: DetectorIndex,
    path: PathIndex,
    counting: CountingTier,
) -> Result<Prediction, PredictionError> {
    if sensor.scene().hardware.architecture == Architecture::Histogram {
        return histogram::predict(sensor, detector, path);
    }
    if moves(sensor, detector) {
        moving::check_speed(sensor, detector)?;
    }
    TheoryEffort::of(sensor, detector)?.check_predictions(1)?;
    if moves(sensor, detector) {
        moving::predict(sensor, detector, path, counting)
    } else {
        still::predict(sensor, detector, path, counting)
    }
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
        return of_histograms(sensor, detector, paths);
    }
    if moves(sensor, detector) {
        // Each phase step has a response of its own.
        if let Err(reason) = checked_effort(sensor, detector, paths.len()) {
            return Theory::refused(reason, paths.len());
        }
        let predict = |&path: &PathIndex| predict(sensor, detector, path, counting);
        let predictions: Vec<_> = paths.iter().map(predict).collect();
        return Theory {
            missed: predictions.iter().map(|p| p.ok()?.missed_fraction).collect(),
            predictions,
            bound: bound(sensor, detector, counting),
        };
    }
    let effort = match checked_effort(sensor, detector, paths.len()) {
        Ok(effort) => effort,
        Err(reason) => return Theory::refused(reason, paths.len()),
    };
    let of_counts = |counts: &ExpectedCounts| {
        let predict =
            |&path: &PathIndex| still::predict_from(counts, sensor, detector, path, counting);
        let predictions: Vec<_> = paths.iter().map(predict).collect();
        let missed = |(predicted, &path): (&Result<Prediction, _>, &PathIndex)| match predicted {
            Ok(predicted) => predicted.missed_fraction,
            Err(PredictionError::CoarseOnly(_)) => {
                still::missed_from(counts, sensor, detector, path, counting)
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

/// Predictions and bound of a detector's histograms.
fn of_histograms(sensor: &Sensor, detector: DetectorIndex, paths: &[PathIndex]) -> Theory {
    let predictions = match histogram::predictions(sensor, detector, paths) {
        Ok(predictions) => predictions,
        Err(reason) => return Theory::refused(reason, paths.len()),
    };
    let missed = |predicted: &Result<Prediction, PredictionError>| match predicted {
        Ok(predicted) => predicted.missed_fraction,
        // A peak that is not there is not found.
        Err(PredictionError::Flat) => Some(1.0),
        Err(_) => None,
    };
    Theory {
        missed: predictions.iter().map(missed).collect(),
        predictions,
        bound: BinFitter::new(sensor, detector).and_then(|fitter| fitter.bound()),
    }
}

impl Theory {
    fn refused(reason: MeanResponseError, paths: usize) -> Theory {
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
