//! Predictions and bound for a detector's scans, from one solution of its state.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::bound::{PrecisionBound, beside, bound, bound_of};
use super::expected_counts::ExpectedCounts;
use super::fit::error::FitError;
use super::prediction::{Prediction, PredictionError, moves};
use super::truth::Asked;
use super::{CountingTier, TheoryEffort, Work, coverage, histogram, moving, still};
use crate::photons::DetectorModel;
use crate::response::{MeanResponse, MeanResponseError, SecondMoments};
use crate::scene::{Architecture, DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// Predictions and bound of one detector. A refusal cannot be written as data.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Theory {
    /// Prediction of the phase estimator for each path that was asked for.
    #[serde(with = "as_data")]
    pub predictions: Vec<Result<Prediction, PredictionError>>,
    /// Share of scans that miss each of them: those of the predictions, and of paths with only a coarse
    /// estimate.
    pub missed: Vec<Option<f64>>,
    /// How precise any estimator can be.
    #[serde(with = "as_data")]
    pub bound: Result<PrecisionBound, FitError>,
}

/// What theory tells as data, where it does not refuse to: what is asked again of a refusal costs little.
mod as_data {
    use super::{Deserialize, Serialize};
    use serde::{Deserializer, Serializer, ser::Error as _};

    /// A result, or several.
    pub trait ResultShape: Sized {
        type Data: for<'de> Deserialize<'de>;
        fn data(&self) -> Option<impl Serialize>;
        fn of(data: Self::Data) -> Self;
    }

    impl<T: Serialize + for<'de> Deserialize<'de>, E> ResultShape for Result<T, E> {
        type Data = T;

        fn data(&self) -> Option<impl Serialize> {
            self.as_ref().ok()
        }

        fn of(data: T) -> Self {
            Ok(data)
        }
    }

    impl<T: ResultShape> ResultShape for Vec<T> {
        type Data = Vec<T::Data>;

        fn data(&self) -> Option<impl Serialize> {
            self.iter().map(T::data).collect::<Option<Vec<_>>>()
        }

        fn of(data: Vec<T::Data>) -> Self {
            data.into_iter().map(T::of).collect()
        }
    }

    pub fn serialize<T: ResultShape, S: Serializer>(told: &T, to: S) -> Result<S::Ok, S::Error> {
        told.data().ok_or_else(|| S::Error::custom("a refusal is not data"))?.serialize(to)
    }

    pub fn deserialize<'de, T: ResultShape, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
        T::Data::deserialize(from).map(T::of)
    }
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
pub fn theory(
    sensor: &Sensor,
    detector: DetectorIndex,
    paths: &[PathIndex],
    counting: CountingTier,
) -> Theory {
    match follows_steps(sensor, detector) {
        true => of_each_step(sensor, detector, paths, counting),
        false => of_still(&[sensor], detector, paths, counting).swap_remove(0),
    }
}

/// [`theory`] at other integration times, in chips, from one solution of the detector's state;
/// with the sensor that has each of them.
pub fn theory_of_integrations(
    sensor: &Sensor,
    detector: DetectorIndex,
    paths: &[PathIndex],
    counting: CountingTier,
    chips: &[u64],
) -> Vec<(Sensor, Theory)> {
    let of = |&chips: &u64| sensor.with(|scene| scene.scan.integration_chips = chips);
    let sensors: Vec<Sensor> = chips.iter().map(of).collect();
    let theories = match follows_steps(sensor, detector) {
        true => {
            let of_sensor = |sensor| of_each_step(sensor, detector, paths, counting);
            sensors.par_iter().map(of_sensor).collect()
        }
        false => of_still(&sensors.iter().collect::<Vec<_>>(), detector, paths, counting),
    };
    sensors.into_iter().zip(theories).collect()
}

/// Whether one solution of a detector's state is not enough: for histograms, and for paths that
/// move.
fn follows_steps(sensor: &Sensor, detector: DetectorIndex) -> bool {
    sensor.scene().hardware.architecture == Architecture::Histogram || moves(sensor, detector)
}

/// Theory of histograms, and of paths that move.
fn of_each_step(
    sensor: &Sensor,
    detector: DetectorIndex,
    paths: &[PathIndex],
    counting: CountingTier,
) -> Theory {
    if sensor.scene().hardware.architecture == Architecture::Histogram {
        return of_histograms(sensor, detector, paths, counting)
            .unwrap_or_else(|reason| Theory::refused(reason, paths.len()));
    }
    // Each phase step has a response of its own.
    if let Err(reason) = checked_effort(sensor, detector, paths.len()) {
        return Theory::refused(reason, paths.len());
    }
    let predict = |&path: &PathIndex| predict(sensor, detector, path, counting);
    let predictions: Vec<_> = paths.iter().map(predict).collect();
    Theory {
        missed: predictions.iter().map(|p| p.ok()?.missed_fraction).collect(),
        predictions,
        bound: bound(sensor, detector, counting),
    }
}

/// Theory of paths that stand still, for sensors that differ in their integration times alone.
fn of_still(
    sensors: &[&Sensor],
    detector: DetectorIndex,
    paths: &[PathIndex],
    counting: CountingTier,
) -> Vec<Theory> {
    let refused = |reason: MeanResponseError| Theory::refused(reason, paths.len());
    let of_counts = |sensor: &Sensor, effort: TheoryEffort, counts: &ExpectedCounts| {
        let predict = |&path: &PathIndex| {
            let asked = Asked { sensor, detector, path, tier: counting };
            let predicted = still::predict_from(counts, &asked);
            let missed = missed(&predicted).or_else(|| match predicted {
                Err(PredictionError::CoarseOnly(_)) => still::missed_from(counts, &asked),
                _ => None,
            });
            (covered(&asked, predicted), missed)
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
    let effort = |sensor: &&Sensor| checked_effort(sensor, detector, paths.len());
    let efforts: Vec<_> = sensors.iter().map(effort).collect();
    let Some(first) = efforts.iter().position(Result::is_ok) else {
        return efforts.into_iter().filter_map(Result::err).map(refused).collect();
    };
    let model = DetectorModel::new(sensors[first], detector);
    let solved = MeanResponse::of_tier(&model, counting).and_then(|response| {
        let second = SecondMoments::new(&response)?;
        let has_bound = |effort: &TheoryEffort| effort.check(Work::Bound).is_ok();
        let sides = match sensors.len() > 1 && efforts.iter().flatten().any(has_bound) {
            true => beside(&response, counting),
            false => None,
        };
        let second = if sensors.len() > 1 { second.shared() } else { second };
        let of_sensor = |(sensor, effort): (&&Sensor, &Result<TheoryEffort, _>)| {
            let effort = effort.map_err(refused)?;
            let model = DetectorModel::new(sensor, detector);
            let response = response.counted_by(&model);
            let second = second.counted_by(&response);
            let counts = ExpectedCounts {
                beside: sides
                    .as_ref()
                    .map(|sides| sides.iter().map(|unknown| unknown.counted_by(&model)).collect()),
                ..ExpectedCounts::new(&response, &second)
            };
            Ok(of_counts(sensor, effort, &counts))
        };
        let theories = sensors.iter().zip(&efforts).map(of_sensor);
        Ok(theories.map(|theory| theory.unwrap_or_else(|refused| refused)).collect())
    });
    solved.unwrap_or_else(|reason| sensors.iter().map(|_| refused(reason)).collect())
}

/// Predictions and bound of a detector's histograms.
fn of_histograms(
    sensor: &Sensor,
    detector: DetectorIndex,
    paths: &[PathIndex],
    counting: CountingTier,
) -> Result<Theory, MeanResponseError> {
    let predictions = histogram::predictions(sensor, detector, paths, counting, false)?;
    let predict = |(predicted, &path): (Result<Prediction, PredictionError>, &PathIndex)| {
        let missed = missed(&predicted);
        let asked = Asked { sensor, detector, path, tier: counting };
        (covered(&asked, predicted), missed)
    };
    let (predictions, missed) = told(predictions.into_iter().zip(paths).map(predict));
    let bound = bound(sensor, detector, counting);
    Ok(Theory { predictions, missed, bound })
}

/// The share of scans that miss a path, where its prediction has it.
fn missed(predicted: &Result<Prediction, PredictionError>) -> Option<f64> {
    match predicted {
        Ok(predicted) => predicted.missed_fraction,
        // A missing peak is not found.
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::load_with;

    /// One solution for all integration times, against one for each: bit for bit. Ends of the
    /// shortest steps divide pairs of detections; steps of 31 chips are whole code periods.
    #[test]
    fn integration_times_share_their_solution() {
        for settings in [&[][..], &["path.distance=1.3 m", "detector.pulse_width=0.7 ns"]] {
            let settings: Vec<_> = settings.iter().map(|s| s.parse().expect("sound")).collect();
            let scene = load_with(Path::new("../scenes/quick.toml"), &settings).expect("sound");
            let (sensor, first, paths) = (Sensor::new(&scene), DetectorIndex(0), [PathIndex(0)]);
            for tier in [CountingTier::Sampled, CountingTier::Events] {
                let chips = [20, 31, 1000, 12_500, 200_000];
                let told = theory_of_integrations(&sensor, first, &paths, tier, &chips);
                assert!(told.iter().any(|(_, theory)| theory.bound.is_ok()));
                assert!(told.iter().any(|(_, theory)| theory.predictions[0].is_ok()));
                for ((at, theory_of_all), chips) in told.into_iter().zip(chips) {
                    assert_eq!(at.timing().scan.integration_chips, chips);
                    let alone = theory(&at, first, &paths, tier);
                    assert_eq!(format!("{theory_of_all:?}"), format!("{alone:?}"), "{chips} chips");
                }
            }
        }
    }
}
