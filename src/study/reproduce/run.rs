//! Simulated scans behind the points of one figure.

use super::many::Fits;
use super::phase::{Errors, phase_errors};
use super::printed::printed_distance_m;
use super::run_error::RunError;
use super::statistics::{Measured, rate, sample_mean, sample_mean_of, sample_std};
use super::{FigureId, ReproduceOptions};
use crate::door::Jobs as _;
use crate::estimate::fit::Fitter;
use crate::estimate::unwrap::unwrap;
use crate::estimate::{CountingTier, delay_error_ps, distance_m};
use crate::photons::DetectorModel;
use crate::response::{CountSampler, MeanResponse, SecondMoments};
use crate::scene::{DetectorIndex, EstimatorKind, Scene};
use crate::sensor::Sensor;
use crate::simulate::Tier;
use crate::simulate::scans::scans;

/// Scans behind a mean correlation, as in the article.
const CORRELATION_SCANS: u64 = 100;
/// Scans over whole code periods behind a rate.
const SEARCH_SCANS: u64 = 200;
/// The same if each is fitted.
const FITTED_SEARCH_SCANS: u64 = 100;
/// Integration time that the asked number of scans is for.
const USUAL_INTEGRATION_PS: f64 = 1.04e9;

/// Makes the scans of one figure; every call has random numbers of its own.
#[derive(Debug)]
pub struct Run {
    seed: u64,
    repetitions: u64,
}

impl Run {
    /// A run for one figure.
    pub fn new(id: FigureId, options: &ReproduceOptions) -> Run {
        Run {
            seed: options.seed ^ (id.ordinal() + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15),
            repetitions: options.repetitions.max(2),
        }
    }

    fn next_seed(&mut self) -> u64 {
        self.seed = self.seed.wrapping_add(1);
        self.seed
    }

    /// Share of scans over whole code periods that find the target.
    pub fn search(&mut self, scene: &Scene) -> Result<Measured, RunError> {
        let seed = self.next_seed();
        let scans = self.repetitions.min(match scene.estimator {
            EstimatorKind::Fft => SEARCH_SCANS,
            EstimatorKind::Model => FITTED_SEARCH_SCANS,
        });
        let options = Tier::Events.scans(scans).seeded(seed);
        let path = &Sensor::new(scene).simulate(options)?.estimates[0];
        Ok(rate(scans - path.missed_scans, scans))
    }

    /// Scans behind a standard deviation: the same light for each.
    fn scans_of(&self, scene: &Scene) -> u64 {
        let shorter = USUAL_INTEGRATION_PS / scene.scan.requested_integration_ps;
        self.repetitions * (shorter.round() as u64).max(1)
    }

    /// Scans that were asked for.
    pub fn repetitions(&self) -> u64 {
        self.repetitions
    }

    /// Errors of the phase estimates of the scene's first path.
    pub fn errors(&mut self, scene: &Scene) -> Result<Errors, RunError> {
        self.share_of_errors(scene, 1)
    }

    /// The same from one of so many shares of the scans.
    pub fn share_of_errors(&mut self, scene: &Scene, shares: u64) -> Result<Errors, RunError> {
        let scans = self.scans_of(scene).div_ceil(shares).max(2);
        phase_errors(scene, self.next_seed(), scans)
    }

    /// The same, and nothing where too few scans find the target.
    pub fn errors_if_any(
        &mut self,
        scene: &Scene,
        shares: u64,
    ) -> Result<Option<Errors>, RunError> {
        match self.share_of_errors(scene, shares) {
            Err(RunError::NoStatistics { .. }) => Ok(None),
            errors => errors.map(Some),
        }
    }

    /// Joint fits of scans of a tier, as many as were asked for and no more than `most`.
    pub fn fits(&mut self, scene: &Scene, tier: Tier, most: u64) -> Result<Fits, RunError> {
        let scans = self.repetitions.min(most);
        Fits::of(scene, tier, self.next_seed(), scans)
    }

    /// Mean error, in metres, of the fits of so many scans of a tier.
    pub fn fitted_bias_m(
        &mut self,
        scene: &Scene,
        tier: Tier,
        scans: u64,
    ) -> Result<Measured, RunError> {
        let options = tier.scans(scans).seeded(self.next_seed());
        let path = &Sensor::new(scene).simulate(options)?.estimates[0];
        let (Some(bias_m), Some(error_m)) = (path.bias_m, path.bias_std_error_m) else {
            return Err(RunError::NoStatistics { scans });
        };
        Ok(Measured::normal(bias_m, error_m))
    }

    /// The same of counts that a counter in continuous time is expected to have, with
    /// their scatter: no samples, in which pulses merge or are lost.
    pub fn fitted_bias_in_continuous_time_m(
        &mut self,
        scene: &Scene,
        scans: u64,
    ) -> Result<Measured, RunError> {
        let tier = CountingTier::Events;
        let sensor = Sensor::new(scene);
        let model = DetectorModel::new(&sensor, DetectorIndex(0));
        let response = MeanResponse::of_tier(&model, tier)?;
        let sampler = CountSampler::of(&model, &SecondMoments::new(&response)?)?;
        let fitter = Fitter::new(&sensor, DetectorIndex(0), tier, scene.other_light);
        let period_ps = sensor.timing().code_period_ps();
        let seed = self.next_seed();
        let errors_m: Vec<f64> = (0..scans)
            .filter_map(|scan| fitter.fit(&sampler.scan(seed, scan)).ok())
            .map(|found| delay_error_ps(found.delay_ps, scene.paths[0].delay_ps, period_ps))
            .map(distance_m)
            .collect();
        if errors_m.len() < 2 {
            return Err(RunError::NoStatistics { scans });
        }
        Ok(sample_mean_of(&errors_m))
    }

    /// Standard deviation, in metres, of the estimator as the article prints it.
    pub fn printed_std_m(&mut self, scene: &Scene) -> Result<Measured, RunError> {
        let scans = self.scans_of(scene);
        let mut distances = Vec::new();
        self.each_scan(scene, scans, |counts| {
            distances.extend(printed_distance_m(scene, counts));
        })?;
        if distances.len() < 2 {
            return Err(RunError::NoStatistics { scans });
        }
        let range_m = distance_m(scene.timing().code_period_ps());
        // Those on either side of the range's border belong together.
        let unwrapped =
            unwrap(&distances, range_m).map_err(|_| RunError::NoStatistics { scans })?;
        Ok(sample_std(&unwrapped))
    }

    /// Mean count of each phase step.
    pub fn mean_counts(&mut self, scene: &Scene) -> Result<Vec<Measured>, RunError> {
        let n = self.repetitions.min(CORRELATION_SCANS);
        let steps = scene.scan.steps as usize;
        let (mut sums, mut squares) = (vec![0.0; steps], vec![0.0; steps]);
        self.each_scan(scene, n, |counts| {
            for ((sum, square), &count) in sums.iter_mut().zip(&mut squares).zip(counts) {
                *sum += count as f64;
                *square += (count as f64).powi(2);
            }
        })?;
        let moments = sums.iter().zip(&squares);
        Ok(moments.map(|(&sum, &squares)| sample_mean(sum, squares, n)).collect())
    }

    /// Share of scans, one for each that was asked for, whose counts have a property.
    pub fn share(
        &mut self,
        scene: &Scene,
        mut property: impl FnMut(&[i64]) -> bool,
    ) -> Result<Measured, RunError> {
        let n = self.repetitions;
        let mut successes = 0;
        self.each_scan(scene, n, |counts| successes += u64::from(property(counts)))?;
        Ok(rate(successes, n))
    }

    fn each_scan(
        &mut self,
        scene: &Scene,
        n: u64,
        mut on_scan: impl FnMut(&[i64]),
    ) -> Result<(), RunError> {
        let seed = self.next_seed();
        let mut signed = Vec::new();
        scans(&Sensor::new(scene), DetectorIndex(0), Tier::Events, seed, n, |counts| {
            signed.clear();
            signed.extend(counts.iter().map(|count| count.signed));
            on_scan(&signed);
        })?;
        Ok(())
    }
}
