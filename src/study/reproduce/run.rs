//! Simulated scans behind the points of one figure.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use goldtof_fft::num_complex::Complex64;

use super::prelude::*;
use super::{FigureId, ReproduceOptions};
use crate::code::CodeError;
use crate::door::Jobs as _;
use crate::estimate::fit::Fitter;
use crate::estimate::unwrap::unwrap;
use crate::estimate::{PredictionError, calibration_offset_ps, delay_error_ps, estimate};
use crate::photons::DetectorModel;
use crate::response::{CountSampler, MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::Step;
use crate::simulate::scans::{ScansError, scans};

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
pub struct FigureScans {
    seed: u64,
    repetitions: u64,
}

impl FigureScans {
    /// A run for one figure.
    pub fn new(id: FigureId, options: &ReproduceOptions) -> FigureScans {
        FigureScans {
            seed: options.seed ^ (id.ordinal() + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15),
            repetitions: options.repetitions.max(2),
        }
    }

    /// Seed of the scans that are made next.
    pub fn next_seed(&mut self) -> u64 {
        self.seed = self.seed.wrapping_add(1);
        self.seed
    }

    /// Share of scans over whole code periods that find the target.
    pub fn search(&mut self, scene: &Scene) -> Result<Measured, FigureError> {
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
    pub fn errors(&mut self, scene: &Scene) -> Result<Errors, FigureError> {
        self.share_of_errors(scene, 1)
    }

    /// The same from one of so many shares of the scans.
    pub fn share_of_errors(&mut self, scene: &Scene, shares: u64) -> Result<Errors, FigureError> {
        let scans = self.scans_of(scene).div_ceil(shares).max(2);
        phase_errors(scene, self.next_seed(), scans)
    }

    /// The same, and nothing where too few scans find the target.
    pub fn errors_if_any(
        &mut self,
        scene: &Scene,
        shares: u64,
    ) -> Result<Option<Errors>, FigureError> {
        match self.share_of_errors(scene, shares) {
            Err(FigureError::NoStatistics { .. }) => Ok(None),
            errors => errors.map(Some),
        }
    }

    /// Mean error, in metres, of the fits of so many scans of a tier.
    pub fn fitted_bias_m(
        &mut self,
        scene: &Scene,
        tier: Tier,
        scans: u64,
    ) -> Result<Measured, FigureError> {
        let options = tier.scans(scans).seeded(self.next_seed());
        let path = &Sensor::new(scene).simulate(options)?.estimates[0];
        let (Some(bias_m), Some(error_m)) = (path.bias_m, path.bias_std_error_m) else {
            return Err(FigureError::NoStatistics { scans });
        };
        Ok(Measured::normal(bias_m, error_m))
    }

    /// The same of counts that a counter in continuous time is expected to have, with
    /// their scatter: no samples, in which pulses merge or are lost.
    pub fn fitted_bias_in_continuous_time_m(
        &mut self,
        scene: &Scene,
        scans: u64,
    ) -> Result<Measured, FigureError> {
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
            return Err(FigureError::NoStatistics { scans });
        }
        Ok(sample_mean_of(&errors_m))
    }

    /// Standard deviation, in metres, of the estimator as the article prints it.
    pub fn printed_std_m(&mut self, scene: &Scene) -> Result<Measured, FigureError> {
        let scans = self.scans_of(scene);
        let mut distances = Vec::new();
        self.each_scan(scene, scans, |counts| {
            distances.extend(printed_distance_m(scene, counts));
        })?;
        if distances.len() < 2 {
            return Err(FigureError::NoStatistics { scans });
        }
        let range_m = distance_m(scene.timing().code_period_ps());
        // Those on either side of the range's border belong together.
        let unwrapped =
            unwrap(&distances, range_m).map_err(|_| FigureError::NoStatistics { scans })?;
        Ok(sample_std(&unwrapped))
    }

    /// Mean count of each phase step.
    pub fn mean_counts(&mut self, scene: &Scene) -> Result<Vec<Measured>, FigureError> {
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
    ) -> Result<Measured, FigureError> {
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
    ) -> Result<(), FigureError> {
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

/// Why a figure could not be made.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// A code could not be made.
    #[error(transparent)]
    Code(#[from] CodeError),
    /// Scans could not be simulated.
    #[error(transparent)]
    Scans(#[from] ScansError),
    /// The mean response could not be had.
    #[error(transparent)]
    MeanResponse(#[from] MeanResponseError),
    /// The estimator's mean answer could not be had.
    #[error(transparent)]
    Prediction(#[from] PredictionError),
    /// No statistics came of the scans.
    #[error("fewer than two of {scans} scans found the target; use more --repeat")]
    NoStatistics {
        /// Scans simulated.
        scans: u64,
    },
}

/// Errors of the estimates of a scene's first path.
#[derive(Debug, Clone, Copy)]
pub struct Errors {
    /// Standard deviation, in metres.
    pub std_m: Measured,
    /// Mean error, in metres.
    pub bias_m: Measured,
    /// Scans within a chip of the target; the others take no part.
    pub found: u64,
    /// All scans.
    pub scans: u64,
    /// Share of the found in which another step than the most frequent one counts
    /// most.
    pub elsewhere: Measured,
    /// Detections per second.
    pub detected_rate_cps: f64,
}

impl Errors {
    /// Share of scans within a chip of the target.
    pub fn correct_coarse(&self) -> Measured {
        rate(self.found, self.scans)
    }
}

/// Simulates scans, single detection by single detection, and takes the phase
/// estimator's errors against the first path.
pub fn phase_errors(scene: &Scene, seed: u64, repetitions: u64) -> Result<Errors, FigureError> {
    let sensor = Sensor::new(scene);
    let timing = sensor.timing();
    let offset_ps = calibration_offset_ps(&sensor, DetectorIndex(0), CountingTier::Events);
    let period_ps = timing.code_period_ps();
    let mut errors_m = Vec::new();
    let mut coarse_steps: BTreeMap<u64, u64> = BTreeMap::new();
    let mut detections = 0;
    let mut signed = Vec::new();
    scans(&sensor, DetectorIndex(0), Tier::Events, seed, repetitions, |counts| {
        signed.clear();
        signed.extend(counts.iter().map(|count| count.signed));
        detections += counts.iter().map(|count| count.total).sum::<u64>();
        let Ok(found) = estimate(timing, &signed, offset_ps) else {
            return;
        };
        let error_ps = delay_error_ps(found.delay_ps, scene.paths[0].delay_ps, period_ps);
        if error_ps.abs() <= timing.clock.chip_period_ps {
            errors_m.push(distance_m(error_ps));
            *coarse_steps.entry(found.coarse_step).or_default() += 1;
        }
    })?;
    if errors_m.len() < 2 {
        return Err(FigureError::NoStatistics { scans: repetitions });
    }
    let found = errors_m.len() as u64;
    let most_frequent = coarse_steps.values().copied().max().unwrap_or(found);
    let step_s = timing.integration_ps() * 1e-12;
    Ok(Errors {
        std_m: sample_std(&errors_m),
        bias_m: sample_mean_of(&errors_m),
        found,
        scans: repetitions,
        elsewhere: rate(found - most_frequent, found),
        detected_rate_cps: detections as f64 / (step_s * (repetitions * scene.scan.steps) as f64),
    })
}

/// Distance, in metres and not calibrated, by eqs. 16 and 17 as printed: 2 S + 1
/// samples, half the fundamental, the absolute phase step in the exponent (T_s
/// there in units of itself), and a fine part of phi T_s / (2 pi).
///
/// The fine part is at most half a phase step whatever the counts are, so that
/// what is returned is the coarse grid. `None` for a peak at the scan's rim.
pub fn printed_distance_m(scene: &Scene, counts: &[i64]) -> Option<f64> {
    let samples = scene.samples_per_chip as usize;
    let step_ps = scene.clock().sample_period_ps();
    // The first of equals, as `estimate` has it.
    let peak = (0..counts.len()).rev().max_by_key(|&i| counts[i])?;
    let window = peak.checked_sub(samples)?..peak + samples + 1;
    let fundamental: Complex64 = counts
        .get(window.clone())?
        .iter()
        .zip(window)
        .map(|(&count, index)| {
            let k = scene.scan.phase_step(Step::at(index)) as f64;
            Complex64::from_polar(count as f64, -PI * k / (2 * samples) as f64)
        })
        .sum();
    let fine_ps = fundamental.arg() / (2.0 * PI) * step_ps;
    Some(distance_m(scene.scan.phase_step(Step::at(peak)) as f64 * step_ps + fine_ps))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::reproduce::sensor::{PathLight, gold, sensor};

    #[test]
    fn a_triangle_at_a_step_returns_that_step_and_its_own_number_as_phase() {
        let code = gold(0, 0).expect("a Gold code");
        let scene = sensor(&[PathLight::new(&code, 1.0)], 1e-4);
        for k0 in [10_i64, 20, 37] {
            let counts: Vec<i64> =
                (0..scene.scan.steps as i64).map(|k| 100 * (8 - (k - k0).abs()).max(0)).collect();
            // A real, even window turned by -pi k0 / 16: nothing but k0 in it.
            let turns = -(k0 as f64) / 32.0;
            let expected_ps = 1000.0 * (k0 as f64 + turns - turns.round());
            let found = printed_distance_m(&scene, &counts).expect("a peak inside");
            assert!((found - distance_m(expected_ps)).abs() < 1e-9, "{k0}");
        }
    }
}
