//! What theory says of a detector's scans, from one solution of its state.

use super::bound::{Bound, bound, bound_of};
use super::expected_counts::ExpectedCounts;
use super::fit::bins::BinFitter;
use super::fit::error::FitError;
use super::prediction::{Prediction, PredictionError, moves};
use super::{CountingTier, TheoryEffort, Work, coverage, histogram, moving, still};
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
        let predicted = histogram::predict(sensor, detector, path, false);
        return covered(sensor, detector, path, counting, predicted);
    }
    if moves(sensor, detector) {
        moving::check_speed(sensor, detector)?;
    }
    TheoryEffort::of(sensor, detector)?.check(Work::Predictions(1))?;
    let predicted = match moves(sensor, detector) {
        true => moving::predict(sensor, detector, path, counting),
        false => still::predict(sensor, detector, path, counting),
    };
    covered(sensor, detector, path, counting, predicted)
}

/// A prediction, where its approximations hold.
pub(super) fn covered(
    sensor: &Sensor,
    detector: DetectorIndex,
    path: PathIndex,
    counting: CountingTier,
    predicted: Result<Prediction, PredictionError>,
) -> Result<Prediction, PredictionError> {
    coverage::check_scene(sensor, detector, path, counting)?;
    let predicted = predicted?;
    coverage::check_phase(sensor, path, &predicted)?;
    // Drawn scans are those that find the path already.
    if predicted.is_drawn {
        return Ok(predicted);
    }
    let (counted, share) = predicted.counted(sensor, path, counting);
    coverage::check_counted(share)?;
    Ok(counted)
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
        let predict = |&path: &PathIndex| {
            let predicted = still::predict_from(counts, sensor, detector, path, counting);
            let missed = missed(&predicted).or_else(|| match predicted {
                Err(PredictionError::CoarseOnly(_)) => {
                    still::missed_from(counts, sensor, detector, path, counting)
                }
                _ => None,
            });
            (covered(sensor, detector, path, counting, predicted), missed)
        };
        let (predictions, missed) = told(paths.iter().map(predict));
        Theory {
            missed,
            predictions,
            bound: match effort.check(Work::Bound) {
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
    let predictions = match histogram::predictions(sensor, detector, paths, false) {
        Ok(predictions) => predictions,
        Err(reason) => return Theory::refused(reason, paths.len()),
    };
    let counting = CountingTier::Sampled;
    let (predictions, missed) =
        told(predictions.into_iter().zip(paths).map(|(predicted, &path)| {
            let missed = missed(&predicted);
            (covered(sensor, detector, path, counting, predicted), missed)
        }));
    Theory {
        missed,
        predictions,
        bound: BinFitter::new(sensor, detector).and_then(|fitter| fitter.bound()),
    }
}

/// The share of scans that miss a path, where its prediction has it.
fn missed(predicted: &Result<Prediction, PredictionError>) -> Option<f64> {
    match predicted {
        Ok(predicted) => predicted.missed_fraction,
        // A peak that is not there is not found.
        Err(PredictionError::Flat) => Some(1.0),
        Err(_) => None,
    }
}

/// What is predicted of each path; its share of misses only where the scene's approximations
/// hold, or it is what keeps the rest from being told.
fn told(
    paths: impl Iterator<Item = (Result<Prediction, PredictionError>, Option<f64>)>,
) -> (Vec<Result<Prediction, PredictionError>>, Vec<Option<f64>>) {
    paths
        .map(|(predicted, missed)| {
            let is_told = match &predicted {
                Err(PredictionError::NotCovered(why)) => why.keeps_the_share_of_misses(),
                _ => true,
            };
            (predicted, missed.filter(|_| is_told))
        })
        .unzip()
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
    effort.check(Work::Predictions(paths))?;
    Ok(effort)
}
