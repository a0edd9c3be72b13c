//! From a histogram of arrival times to a distance, and its prediction.
//!
//! The article's coarse and fine stage take the counts of all phase steps, which follow
//! from the histogram; with dead time and afterpulses taken out of it first, wherever that
//! is possible, no range walk is left in them.

use super::dead_time::periods;
pub use super::dead_time::{Uncorrected, dead_time};
use super::phase::{Estimate, NoEstimate, estimate, estimate_values, is_one_window};
use super::prediction::{PhaseAnswer, is_never_largest};
use super::truth::Asked;
use super::{
    CountingTier, Prediction, PredictionError, TheoryEffort, Work, calibration_offset_ps, coverage,
    missed,
};
use crate::histogram::Histogram;
use crate::histogram::correction::{BinnedDetector, CorrectionError, PrimaryLight};
use crate::histogram::correlation::HistogramCorrelator;
use crate::math::normal_cdf;
use crate::photons::{DetectorModel, StepCount};
use crate::response::{MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::Step;
use crate::scene::{DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// A share of misses that is the sum of all steps' chances, which count the same photons.
const SURELY_FOUND: f64 = 1e-7;

/// Why a histogram does not give a distance.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoHistogramEstimate {
    /// Its counts do not have a peak.
    #[error(transparent)]
    NoEstimate(#[from] NoEstimate),
    /// It cannot be of this detector.
    #[error(transparent)]
    Correction(#[from] CorrectionError),
}

/// The article's estimator on histograms of one detector.
#[derive(Debug)]
pub struct PhaseOfHistogram<'s> {
    sensor: &'s Sensor,
    correlator: HistogramCorrelator,
    dead_time: Result<BinnedDetector, Uncorrected>,
    offset_ps: f64,
}

impl<'s> PhaseOfHistogram<'s> {
    /// The estimator of detector `detector`, for bins of tier `tier`.
    ///
    /// # Panics
    /// If the scene has no such detector.
    pub fn new(
        sensor: &'s Sensor,
        detector: DetectorIndex,
        tier: CountingTier,
    ) -> PhaseOfHistogram<'s> {
        let code = sensor.reference(detector);
        PhaseOfHistogram {
            sensor,
            correlator: HistogramCorrelator::new(code, sensor.clock().samples_per_chip),
            dead_time: dead_time(sensor, detector),
            offset_ps: calibration_offset_ps(sensor, detector, tier),
        }
    }

    /// Counts of all phase steps, which follow from a histogram.
    pub fn step_counts(&self, histogram: &Histogram) -> Vec<StepCount> {
        let total = histogram.total();
        let signed = self.correlator.signed_counts(histogram).into_iter();
        signed.map(|signed| StepCount { signed, total }).collect()
    }

    /// Why range walk is not removed, if it is not.
    pub fn walks(&self) -> Option<Uncorrected> {
        self.dead_time.err()
    }

    /// Time of flight and distance (eqs. 15 to 17) from the counts of all phase steps that
    /// follow from a histogram: of the light behind it, without dead time and afterpulses,
    /// or as they are where these cannot be taken out.
    ///
    /// # Errors
    /// When the counts have no peak, or the histogram cannot be of this detector.
    ///
    /// # Panics
    /// If the histogram has not one bin per sample of the code period.
    pub fn estimate(&self, histogram: &Histogram) -> Result<Estimate, NoHistogramEstimate> {
        let timing = self.sensor.timing();
        match self.dead_time {
            Err(_) => {
                let counts = self.correlator.signed_counts(histogram);
                Ok(estimate(timing, &counts, self.offset_ps)?)
            }
            Ok(dead_time) => {
                let light = dead_time.correct(histogram)?.per_period;
                let counts = self.correlator.correlate(&light);
                Ok(estimate_values(timing, &counts, self.offset_ps)?)
            }
        }
    }
}

/// The expected histogram of the scene's own light.
struct ExpectedHistogram<'e, 'm> {
    phase: PhaseOfHistogram<'e>,
    response: &'e MeanResponse<'m>,
    /// Values that the estimator takes, of all phase steps.
    values: Vec<f64>,
    /// The light that they are sums of, where dead time is taken out.
    light: Option<PrimaryLight>,
}

impl<'e, 'm> ExpectedHistogram<'e, 'm> {
    fn new(
        phase: PhaseOfHistogram<'e>,
        response: &'e MeanResponse<'m>,
    ) -> Result<ExpectedHistogram<'e, 'm>, CorrectionError> {
        let sensor = phase.sensor;
        let bins = response.mean_bins();
        let (values, light) = match phase.dead_time {
            Err(_) => (phase.correlator.correlate(&bins), None),
            Ok(dead_time) => {
                let periods = periods(sensor);
                let means: Vec<f64> = bins.iter().map(|bin| bin / periods).collect();
                let light = dead_time.correct_means(&means, periods)?;
                let values = phase.correlator.correlate(&light.per_period);
                (values, Some(light))
            }
        };
        Ok(ExpectedHistogram { phase, response, values, light })
    }

    fn predict(&self, asked: &Asked) -> Result<Prediction, PredictionError> {
        let (sensor, values) = (self.phase.sensor, &self.values);
        let model = self.response.model();
        let is_modulated = model.modulated_paths().any(|modulated| modulated == asked.path);
        if let Some(light) = self.light.as_ref().filter(|_| is_modulated) {
            coverage::check_ready(&light.ready, periods(sensor))?;
        }
        let answer = PhaseAnswer::to_path(values, asked, model)?;
        let variance_ps2 = self.variance_of_sum(&answer.slopes_ps)?;
        let peak_variance = self.variance_of_sum(&[(Step::at(answer.peak), 1.0)])?;
        let per_count = self.value_per_count();
        coverage::check_slipping(model, asked.tier, peak_variance / (per_count * per_count))?;
        let rate_hz = self.response.detection_rate_hz();
        let predicted = answer.prediction(asked, [variance_ps2, peak_variance], rate_hz);
        // Where the peak's window is the whole period, no other step is the largest in its stead: the phase
        // leads elsewhere where noise turns the fundamental round.
        let turned = match is_one_window(sensor.timing()) {
            true => normal_cdf(-1.0 / predicted.phase_std_rad),
            false => 0.0,
        };
        let failures = predicted.coarse_failure_bound_fraction + turned;
        let (_, counted) = predicted.counted(asked);
        let predicted = Prediction {
            missed_fraction: match is_never_largest(values, answer.peak, peak_variance, sensor) {
                true => Some(1.0),
                false => (failures < SURELY_FOUND).then_some(1.0 - counted + failures),
            },
            ..predicted
        };
        if predicted.is_linear() || missed::errors_wrap(sensor, asked.path) {
            return Ok(predicted);
        }
        let covariance = |steps: &[Step]| self.covariance(steps);
        let drawn = missed::drawn_errors_of_values(values, covariance, asked, answer.peak)?;
        let found = drawn.as_ref().filter(|_| failures < SURELY_FOUND);
        let predicted = match found {
            // Where the steps that may lead do not all lead to the path, no one phase tells how many do.
            Some(drawn) => Prediction {
                missed_fraction: Some(1.0 - drawn.found_fraction + failures),
                ..predicted
            },
            None => predicted,
        };
        Ok(predicted.with_drawn_errors(drawn))
    }

    /// What a count adds to the values, on average over all bins.
    fn value_per_count(&self) -> f64 {
        let Some(light) = &self.light else { return 1.0 };
        light.per_period.iter().sum::<f64>() / self.response.mean_bins().iter().sum::<f64>()
    }

    /// Variance of the sum of weight x value over phase steps.
    fn variance_of_sum(&self, weighted: &[(Step, f64)]) -> Result<f64, PredictionError> {
        let Some(light) = &self.light else {
            return Ok(SecondMoments::new(self.response)?.variance_of_sum(weighted));
        };
        let mut weights = vec![0.0; light.variance.len()];
        for &(step, weight) in weighted {
            weights.iter_mut().zip(self.signs(step)).for_each(|(sum, sign)| *sum += weight * sign);
        }
        Ok(covariance(&light.variance, &weights, &weights))
    }

    /// Covariances of the values of some phase steps.
    fn covariance(&self, steps: &[Step]) -> Result<Vec<Vec<f64>>, PredictionError> {
        let Some(light) = &self.light else {
            return Ok(SecondMoments::new(self.response)?.of_steps_together(steps).covariance);
        };
        let signs: Vec<Vec<f64>> = steps.iter().map(|&step| self.signs(step).collect()).collect();
        let of_step =
            |a: &Vec<f64>| signs.iter().map(|b| covariance(&light.variance, a, b)).collect();
        Ok(signs.iter().map(of_step).collect())
    }

    /// How a phase step counts the hits of each bin: +1 or -1.
    fn signs(&self, step: Step) -> impl Iterator<Item = f64> {
        let model = self.response.model();
        let samples = model.timing.clock.samples_per_chip as usize;
        let chips = &model.reference.chips;
        let bins = chips.len() * samples;
        let first = bins - model.timing.scan.phase_step(step) as usize % bins;
        (first..first + bins)
            .map(move |shifted| 2.0 * f64::from(chips[shifted / samples % chips.len()]) - 1.0)
    }
}

/// Covariance of two weighted sums of independent numbers with some variances.
fn covariance(variance: &[f64], a: &[f64], b: &[f64]) -> f64 {
    variance.iter().zip(a.iter().zip(b)).map(|(variance, (a, b))| a * b * variance).sum()
}

/// What the phase of a histogram is expected to say of some paths, from one solution of the
/// detector's state; from the counts of its phase steps as they are, if these are `steps_alone`.
///
/// # Errors
/// When there is none, or it would take too long; for each path as for counts of phase steps, and
/// where the light is too bright to take the dead time out.
///
/// # Panics
/// If the scene has no such detector or path.
pub(super) fn predictions(
    sensor: &Sensor,
    detector: DetectorIndex,
    paths: &[PathIndex],
    counting: CountingTier,
    steps_alone: bool,
) -> Result<Vec<Result<Prediction, PredictionError>>, MeanResponseError> {
    TheoryEffort::of(sensor, detector)?.check(Work::Histogram)?;
    let mut phase = PhaseOfHistogram::new(sensor, detector, counting);
    if steps_alone {
        phase.dead_time = Err(Uncorrected::CountsOfSteps);
    }
    let model = DetectorModel::new(sensor, detector);
    let response = MeanResponse::of_tier(&model, counting)?;
    Ok(match ExpectedHistogram::new(phase, &response) {
        Ok(expected) => {
            let asked = |&path| Asked { sensor, detector, path, tier: counting };
            paths.iter().map(asked).map(|asked| expected.predict(&asked)).collect()
        }
        Err(reason) => vec![Err(reason.into()); paths.len()],
    })
}

/// The same of one path.
pub(super) fn predict(asked: &Asked, steps_alone: bool) -> Result<Prediction, PredictionError> {
    predictions(asked.sensor, asked.detector, &[asked.path], asked.tier, steps_alone)?.remove(0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::path::Path;

    use goldtof_fft::num_complex::Complex64;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Poisson};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::scene::load_with;

    /// Share of drawn histograms whose fundamental points away from that of the means.
    fn turned_round(means: &[f64], draws: u32) -> f64 {
        let fundamental = |bins: &[f64]| -> Complex64 {
            let turn = TAU / bins.len() as f64;
            let bins = bins.iter().enumerate();
            bins.map(|(k, &count)| Complex64::from_polar(count, turn * k as f64)).sum()
        };
        let of_means = fundamental(means).conj();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        let is_turned = |_: &u32| {
            let drawn =
                means.iter().map(|&mean| Poisson::new(mean).expect("hits").sample(&mut rng));
            (fundamental(&drawn.collect::<Vec<f64>>()) * of_means).re < 0.0
        };
        (0..draws).filter(is_turned).count() as f64 / f64::from(draws)
    }

    /// A square wave's peak has no rivals, but noise turns its fundamental round: in none of the drawn
    /// histograms of bright light, and in a tenth and more of dim light.
    #[test]
    fn the_share_that_misses_a_square_wave_is_told_only_where_it_is_next_to_nothing() {
        for (power_pw, is_known) in [(20.0, true), (0.1, false)] {
            let settings = [
                "source.code={ family = \"square\" }".to_owned(),
                "path.distance=0.5 m".to_owned(),
                "hardware.architecture=histogram".to_owned(),
                format!("source.mean_power={power_pw} pW"),
            ];
            let settings = settings.map(|setting| setting.parse().expect("a setting"));
            let scene = load_with(Path::new("../scenes/quick.toml"), &settings).expect("sound");
            let first = (DetectorIndex(0), [PathIndex(0)]);
            let sensor = Sensor::new(&scene);
            let said = predictions(&sensor, first.0, &first.1, CountingTier::Sampled, false);
            let said = said.expect("it can be").remove(0).expect("of the path");
            let model = DetectorModel::new(&sensor, first.0);
            let means = MeanResponse::new(&model).expect("there is one").mean_bins();
            let turned = turned_round(&means, 2_000);
            match is_known {
                true => assert!(turned == 0.0 && said.missed_fraction.is_some_and(|m| m < 1e-6)),
                false => assert!(turned > 0.1 && said.missed_fraction.is_none(), "{turned}"),
            }
        }
    }
}
