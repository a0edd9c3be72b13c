//! Shares of misses from drawn scans, where counts are correlated: phase steps that
//! share their light, and the shape that the model estimator looks for.
//!
//! Counts are normal numbers with the exact means and variances. Of steps that share
//! their light, those of groups round the peak have their exact covariances, those of
//! all others the correlations of one group far from it. The same random numbers are
//! drawn every time, so that the answer depends on the scene alone.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::Target;
use crate::estimate::model::best_match;
use crate::estimate::phase::{Measurement, estimate_at, first_maximum};
use crate::estimate::theory::ExpectedCounts;
use crate::optics::{GroupMoments, cholesky, in_parallel};
use crate::scene::EstimatorKind;

/// Counts drawn, about, and the scans that they may make.
const COUNTS: u64 = 16_000_000;
const SCANS: std::ops::RangeInclusive<u64> = 1_000..=20_000;
const SEED: u64 = 0x6d69_7373_6564;
/// Groups whose steps come this near to the path, in chips, have exact covariances.
const NEAR_CHIPS: f64 = 3.0;

/// One group's counts: mean + L z.
struct Group {
    means: Vec<f64>,
    factor: Vec<Vec<f64>>,
}

/// Expected share of scans that miss the target, with a standard error of
/// sqrt(p (1 - p) / scans).
pub(super) fn missed(counts: &ExpectedCounts, target: &Target) -> f64 {
    let groups = groups(counts, target);
    let steps = counts.means.len() as u64;
    let scans = (COUNTS / steps).clamp(*SCANS.start(), *SCANS.end());
    let found = in_parallel(scans as usize, |scan| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(SEED + scan as u64);
        let mut values = Vec::with_capacity(steps as usize);
        for group in &groups {
            group.draw(&mut rng, &mut values);
        }
        target.found_in(&values)
    });
    let found = found.into_iter().filter(|&found| found).count();
    1.0 - found as f64 / scans as f64
}

impl Target<'_> {
    /// Whether the estimator finds the path in a scan's counts. The model estimator's
    /// fit goes to the peak that its coarse stage has found.
    fn found_in(&self, values: &[f64]) -> bool {
        let zeros = values.iter().filter(|&&value| value == 0.0).count();
        if values.iter().all(|&value| value <= 0.0) && 2 * zeros > values.len() {
            return false;
        }
        if self.scene.estimator == EstimatorKind::Model {
            let source = self.scene.detectors[self.detector].reference;
            let step = best_match(self.scene, &self.scene.sources[source].code, values);
            return self.accepts(self.measured_ps + self.step_error_ps(step), 1.0);
        }
        let measurement = Measurement::new(self.scene, &[]);
        let estimate = estimate_at(values, first_maximum(values), &measurement, 0.0);
        self.accepts(estimate.delay_ps, 1.0)
    }
}

impl Group {
    fn draw(&self, rng: &mut Xoshiro256PlusPlus, values: &mut Vec<f64>) {
        let normal: Vec<f64> = self.means.iter().map(|_| StandardNormal.sample(rng)).collect();
        for (mean, row) in self.means.iter().zip(&self.factor) {
            let error: f64 = row.iter().zip(&normal).map(|(f, z)| f * z).sum();
            values.push((mean + error).round());
        }
    }
}

fn groups(counts: &ExpectedCounts, target: &Target) -> Vec<Group> {
    let model = counts.model();
    let moments = counts.second.of_scan();
    let means = |steps: &[u64]| -> Vec<f64> {
        let of_step = |&step: &u64| counts.means[step as usize].signed;
        steps.iter().map(of_step).collect()
    };
    let std = |step: u64| moments[step as usize].signed_variance.max(0.0).sqrt();
    if model.parallel() == 1 {
        return (0..counts.means.len() as u64)
            .map(|step| Group {
                means: means(&[step]),
                factor: vec![vec![std(step)]],
            })
            .collect();
    }
    let reach_ps = NEAR_CHIPS * target.scene.chip_period_ps;
    let is_near = |group: u64| {
        let mut steps = model.steps_of_group(group);
        steps.any(|step| target.step_error_ps(step as usize).abs() < reach_ps)
    };
    // The last group may be smaller: no model for others.
    let far = (0..model.groups() - 1).find(|&group| !is_near(group));
    let far = far.map(|group| counts.second.of_group(group));
    in_parallel(model.groups() as usize, |group| {
        let steps: Vec<u64> = model.steps_of_group(group as u64).collect();
        let covariance = match &far {
            Some(far) if !is_near(group as u64) => (0..steps.len())
                .map(|a| {
                    let of_pair = |b: usize| correlation(far, a, b) * std(steps[a]) * std(steps[b]);
                    (0..steps.len()).map(of_pair).collect()
                })
                .collect(),
            _ => {
                let mut exact = counts.second.of_group(group as u64).covariance;
                exact.truncate(steps.len());
                exact
            }
        };
        Group {
            means: means(&steps),
            factor: cholesky(covariance),
        }
    })
}

fn correlation(group: &GroupMoments, a: usize, b: usize) -> f64 {
    let c = &group.covariance;
    c[a][b] / (c[a][a] * c[b][b]).sqrt()
}
