//! The Cramer-Rao bound of the counts of one window.

use crate::photons::DetectorModel;
use crate::response::{
    CountMoments, CountingTier, Light, MeanCount, MeanResponse, MeanResponseError, SecondMoments,
};
use crate::scan::Step;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Steps of derivatives: of delays in chips, of rates as a share.
const DELAY_STEP_CHIPS: f64 = 2e-3;
const RATE_STEP: f64 = 5e-3;

/// What a window's counts tell of the light's delay, in inverse squares of a phase step: the inverse of the least
/// variance of an unbiased estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Information {
    /// Of the signed counts alone, which are what a window is weighed by.
    pub signed: f64,
    /// Of the total counts, too.
    pub with_totals: f64,
}

impl Information {
    /// Of a window that begins at a phase step, with the delay of the detector's own light and all strengths unknown. Steps
    /// count photons of their own, and their covariance is exact; what the counts' variances tell of the delay is left
    /// out, as in [`crate::estimate::bound`].
    ///
    /// The background is unknown where total counts tell it. In signed counts it is seen only by the walk of the
    /// delay that it causes by dead time. Without totals it is taken as known: that walk is a bias of the position, and
    /// no scatter.
    ///
    /// # Errors
    /// When the mean response cannot be had.
    pub fn of_window(
        sensor: &Sensor,
        detector: DetectorIndex,
        tier: CountingTier,
        first_step: u64,
        steps: u64,
    ) -> Result<Information, MeanResponseError> {
        let window = sensor.with(|scene| {
            scene.scan.first_step = first_step;
            scene.scan.steps = steps;
        });
        let model = DetectorModel::new(&window, detector);
        let light = Light::of(&model);
        let slopes =
            |change: &dyn Fn(&mut Light, f64)| -> Result<Vec<[f64; 2]>, MeanResponseError> {
                let counts = |by: f64| -> Result<Vec<MeanCount>, MeanResponseError> {
                    let mut changed = light.clone();
                    change(&mut changed, by);
                    Ok(MeanResponse::to_light(&model, changed, tier)?.mean_counts())
                };
                let differences = counts(1.0)?.into_iter().zip(counts(-1.0)?);
                Ok(differences.map(|(a, b)| [a.signed - b.signed, a.total - b.total]).collect())
            };
        let own = |path: &crate::response::LightPath| path.code.chips == model.reference.chips;
        let mut delay = slopes(&|light, by| {
            let paths = light.paths.iter_mut().filter(|path| own(path));
            paths.for_each(|path| path.delay_chips += by * DELAY_STEP_CHIPS);
        })?;
        let step_samples = 2.0 * DELAY_STEP_CHIPS * f64::from(sensor.clock().samples_per_chip);
        delay.iter_mut().flatten().for_each(|slope| *slope /= step_samples);
        let mut others = Vec::new();
        for path in 0..light.paths.len() {
            others.push(slopes(&|light, by| {
                light.paths[path].rate_per_chip *= 1.0 + by * RATE_STEP;
            })?);
        }
        let constant_step = RATE_STEP * light.brightest_per_chip();
        let background = slopes(&|light, by| light.constant_per_chip += by * constant_step)?;
        let all: Vec<Step> = Step::all(steps).collect();
        let response = MeanResponse::to_light(&model, light.clone(), tier)?;
        let moments = SecondMoments::new(&response)?.of_steps(&all);
        let signed = left(&moments, &delay, &others, |moment, [signed, _]| {
            [signed / moment.signed_variance.sqrt(), 0.0]
        });
        others.push(background);
        Ok(Information {
            signed,
            with_totals: left(&moments, &delay, &others, |moment, [signed, total]| {
                let [a, b, c] = moment.whitening();
                [a * signed, b * signed + c * total]
            }),
        })
    }
}

/// The square of what is left of one column of derivatives in directions in which no other changes the counts; `whitened`
/// gives numbers with unit covariance.
fn left(
    moments: &[CountMoments],
    column: &[[f64; 2]],
    others: &[Vec<[f64; 2]>],
    whitened: impl Fn(&CountMoments, [f64; 2]) -> [f64; 2],
) -> f64 {
    let of = |column: &[[f64; 2]]| -> Vec<f64> {
        moments.iter().zip(column).flat_map(|(moment, slopes)| whitened(moment, *slopes)).collect()
    };
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    // Gram and Schmidt's: each direction less its part in those before it.
    let mut directions: Vec<Vec<f64>> = Vec::new();
    for column in others.iter().map(|other| of(other)).chain([of(column)]) {
        let rest = directions.iter().fold(column, |rest, direction| {
            let share = dot(&rest, direction) / dot(direction, direction);
            rest.iter().zip(direction).map(|(a, b)| a - share * b).collect()
        });
        directions.push(rest);
    }
    directions.last().map_or(0.0, |rest| dot(rest, rest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::bound::bound;

    /// With totals it is the bound of a scan that consists of the window.
    #[test]
    fn with_totals_it_is_the_bound_of_a_scan() {
        let sensor = Sensor::load("tests/scenes/tracking.toml").expect("the scene is valid");
        let still = sensor.still_at(0.0);
        let detector = DetectorIndex(0);
        let window = still.with(|scene| {
            (scene.scan.first_step, scene.scan.steps) = (36, 16);
        });
        let expected = bound(&window, detector, CountingTier::Sampled).expect("there is one");
        // That of the slope: a window is placed anywhere between two phase steps.
        let expected = expected.paths[0].slope_m;
        let found = Information::of_window(&still, detector, CountingTier::Sampled, 36, 16)
            .expect("the response can be had");
        let sample_m = crate::estimate::distance_m(still.clock().sample_period_ps());
        let found_m = sample_m / found.with_totals.sqrt();
        assert!((found_m / expected - 1.0).abs() < 0.01, "{found_m} {expected}");
        assert!(found.signed < found.with_totals, "{found:?}");
    }

    /// Of columns that are not at right angles the part beside the others counts.
    #[test]
    fn what_others_tell_is_left_out() {
        let moment = CountMoments {
            signed_mean: 0.0,
            total_mean: 0.0,
            signed_variance: 4.0,
            total_variance: 1.0,
            covariance: 0.0,
        };
        let column = |values: [f64; 3]| values.map(|value| [value, 0.0]).to_vec();
        let whitened = |moment: &CountMoments, [signed, total]: [f64; 2]| {
            [signed / moment.signed_variance.sqrt(), total]
        };
        let others = [column([1.0, 0.0, 0.0]), column([1.0, 1.0, 0.0])];
        let found = left(&[moment; 3], &column([7.0, 5.0, 6.0]), &others, whitened);
        assert!((found - 9.0).abs() < 1e-12, "{found}");
    }
}
