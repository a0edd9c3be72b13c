//! What theory says of a detector's scans, from one solution of its state.

use super::bound::{Bound, bound, bound_of};
use super::expected_counts::with_counts;
use super::fit::bins::BinFitter;
use super::fit::error::FitError;
use super::prediction::{Asked, Prediction, PredictionError, moves};
use super::{CountingTier, TheoryEffort, Work, coverage, histogram, moving, still};
use crate::response::MeanResponseError;
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
    let asked = Asked { sensor, detector, path, tier: counting };
    if sensor.scene().hardware.architecture == Architecture::Histogram {
        return covered(&asked, histogram::predict(&asked, false));
    }
    if moves(sensor, detector) {
        moving::check_speed(sensor, detector)?;
    }
    TheoryEffort::of(sensor, detector)?.check(Work::Predictions(1))?;
    let predicted = match moves(sensor, detector) {
        true => moving::predict(&asked),
        false => still::predict(&asked),
    };
    covered(&asked, predicted)
}

/// A prediction, where its approximations hold.
pub(super) fn covered(
    asked: &Asked,
    predicted: Result<Prediction, PredictionError>,
) -> Result<Prediction, PredictionError> {
    coverage::check_scene(asked)?;
    let predicted = predicted?;
    coverage::check_phase(asked, &predicted)?;
    // Drawn scans are those that find the path already.
    if predicted.is_drawn {
        return Ok(predicted);
    }
    let (counted, share) = predicted.counted(asked);
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
    let solved = match sensor.scene().hardware.architecture {
        Architecture::Histogram => of_histograms(sensor, detector, paths),
        Architecture::UpDown => of_steps(sensor, detector, paths, counting),
    };
    solved.unwrap_or_else(|reason| Theory {
        predictions: vec![Err(reason.into()); paths.len()],
        missed: vec![None; paths.len()],
        bound: Err(reason.into()),
    })
}

/// Predictions and bound of a detector's counts of phase steps, if they do not take too long.
fn of_steps(
    sensor: &Sensor,
    detector: DetectorIndex,
    paths: &[PathIndex],
    tier: CountingTier,
) -> Result<Theory, MeanResponseError> {
    let effort = TheoryEffort::of(sensor, detector)?;
    effort.check(Work::Predictions(paths.len()))?;
    if moves(sensor, detector) {
        // Each phase step has a response of its own.
        let predict = |&path: &PathIndex| predict(sensor, detector, path, tier);
        let predictions: Vec<_> = paths.iter().map(predict).collect();
        return Ok(Theory {
            missed: predictions.iter().map(|p| p.ok()?.missed_fraction).collect(),
            predictions,
            bound: bound(sensor, detector, tier),
        });
    }
    with_counts(sensor, detector, tier, |counts| {
        let predict = |&path: &PathIndex| {
            let asked = Asked { sensor, detector, path, tier };
            let predicted = still::predict_from(counts, &asked);
            let missed = missed(&predicted).or_else(|| match predicted {
                Err(PredictionError::CoarseOnly(_)) => still::missed_from(counts, &asked),
                _ => None,
            });
            (covered(&asked, predicted), missed)
        };
        let (predictions, missed) = told(paths.iter().map(predict));
        let bound = match effort.check(Work::Bound) {
            Ok(()) => bound_of(sensor, detector, tier, counts),
            Err(reason) => Err(reason.into()),
        };
        Ok(Theory { predictions, missed, bound })
    })
}

/// Predictions and bound of a detector's histograms.
fn of_histograms(
    sensor: &Sensor,
    detector: DetectorIndex,
    paths: &[PathIndex],
) -> Result<Theory, MeanResponseError> {
    let predictions = histogram::predictions(sensor, detector, paths, false)?;
    let predict = |(predicted, &path): (Result<Prediction, PredictionError>, &PathIndex)| {
        let missed = missed(&predicted);
        let asked = Asked { sensor, detector, path, tier: CountingTier::Sampled };
        (covered(&asked, predicted), missed)
    };
    let (predictions, missed) = told(predictions.into_iter().zip(paths).map(predict));
    let bound = BinFitter::new(sensor, detector).and_then(|fitter| fitter.bound());
    Ok(Theory { predictions, missed, bound })
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
