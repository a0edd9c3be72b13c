//! Shares of misses from drawn scans, where counts are correlated: phase steps that
//! share their light, and the shape that the model estimator looks for.
//!
//! Counts have the exact means and variances, and the skewness and kurtosis of their
//! law. Of steps that share
//! their light, those of groups round the peak have their exact covariances, those of
//! all others the correlations of one group far from it. The same random numbers are
//! drawn every time, so that the answer depends on the scene alone.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::law::CountLaw;
use super::scan::laws;
use super::target::Target;
use crate::estimate::expected_counts::ExpectedCounts;
use crate::estimate::fit::coarse::best_match;
use crate::estimate::phase::{estimate_at, first_maximum};
use crate::math::correlating;
use crate::response::GroupMoments;
use crate::scan;
use crate::scan::Step;
use crate::scene::{DetectorIndex, EstimatorKind};
use crate::sensor::Sensor;

/// Counts drawn, about, and the scans that they may make.
const COUNTS: u64 = 16_000_000;
const SCANS: std::ops::RangeInclusive<u64> = 100..=20_000;
const SEED: u64 = 0x6d69_7373_6564;
/// Groups whose steps come this near to the path, in chips, have exact covariances.
const NEAR_CHIPS: f64 = 3.0;

/// One group's counts: normal numbers L z, each bent to its step's law.
struct Group {
    laws: Vec<Drawn>,
    factor: Vec<Vec<f64>>,
}

/// mean + std (c0 + c1 z + c2 z^2 + c3 z^3).
struct Drawn {
    mean: f64,
    std: f64,
    deviation: [f64; 4],
}

/// Expected share of scans that miss the target, with a standard error of
/// sqrt(p (1 - p) / scans); none where the moments are no finite numbers.
pub(super) fn missed(counts: &ExpectedCounts, target: &Target) -> Option<f64> {
    let groups = groups(counts, target)?;
    let steps = counts.means.len() as u64;
    let scans = scans(target.sensor, target.detector);
    let draws = (0..scans).into_par_iter().filter(|scan| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(SEED + scan);
        let mut values = Vec::with_capacity(steps as usize);
        for group in &groups {
            group.draw(&mut rng, &mut values);
        }
        target.found_in(&values)
    });
    Some(1.0 - draws.count() as f64 / scans as f64)
}

/// Scans that are drawn.
pub(super) fn scans(sensor: &Sensor, detector: DetectorIndex) -> u64 {
    let counts = sensor.timing().scan.steps * work_per_count(sensor, detector);
    (COUNTS / counts).clamp(*SCANS.start(), *SCANS.end())
}

/// What a count costs beside drawing it: the model estimator's coarse stage holds a
/// template against every step, some chips wide.
fn work_per_count(sensor: &Sensor, detector: DetectorIndex) -> u64 {
    if sensor.scene().estimator != EstimatorKind::Model {
        return 1;
    }
    let source = sensor.scene().detectors[detector].reference;
    let chips = (1_u64 << sensor.scene().sources[source].code.interleave) + 1;
    1 + chips * u64::from(sensor.clock().samples_per_chip) / 8
}

impl Target<'_> {
    /// Whether the estimator finds the path in a scan's counts. The model estimator's
    /// fit goes to the peak that its coarse stage has found.
    fn found_in(&self, values: &[f64]) -> bool {
        let zeros = values.iter().filter(|&&value| value == 0.0).count();
        if values.iter().all(|&value| value <= 0.0) && 2 * zeros > values.len() {
            return false;
        }
        if self.sensor.scene().estimator == EstimatorKind::Model {
            let source = self.sensor.scene().detectors[self.detector].reference;
            let step = best_match(self.sensor, &self.sensor.scene().sources[source].code, values);
            return self.accepts(self.measured_ps + self.step_error_ps(step), 1.0);
        }
        let timing = self.sensor.timing();
        let estimate = estimate_at(values, first_maximum(values), timing, 0.0);
        self.accepts(estimate.delay_ps, 1.0)
    }
}

impl Group {
    fn draw(&self, rng: &mut Xoshiro256PlusPlus, values: &mut Vec<f64>) {
        let normal: Vec<f64> = self.laws.iter().map(|_| StandardNormal.sample(rng)).collect();
        for (law, row) in self.laws.iter().zip(&self.factor) {
            let z: f64 = row.iter().zip(&normal).map(|(f, z)| f * z).sum();
            let [c0, c1, c2, c3] = law.deviation;
            let deviation = c0 + z * (c1 + z * (c2 + z * c3));
            values.push((law.mean + law.std * deviation).round());
        }
    }
}

impl Drawn {
    fn of(law: &CountLaw) -> Drawn {
        Drawn {
            mean: law.mean,
            std: law.variance.max(0.0).sqrt(),
            deviation: law.deviation_of_normal(),
        }
    }
}

fn groups(counts: &ExpectedCounts, target: &Target) -> Option<Vec<Group>> {
    let model = counts.model();
    let laws = laws(counts, target);
    if model.timing.parallel == 1 {
        let alone = |law: &CountLaw| Group { laws: vec![Drawn::of(law)], factor: vec![vec![1.0]] };
        return Some(laws.iter().map(alone).collect());
    }
    let reach_ps = target.sensor.clock().ps(NEAR_CHIPS);
    let is_near = |group: scan::Group| {
        let mut steps = model.timing.grouping().steps_of(group);
        steps.any(|step| target.step_error_ps(step.index()).abs() < reach_ps)
    };
    // The last group may be smaller: no model for others.
    let far = (0..model.timing.groups() - 1).map(scan::Group).find(|&group| !is_near(group));
    let far = far.map(|group| counts.second.of_group(group));
    let group = |group| {
        let group = scan::Group(group);
        let steps: Vec<Step> = model.timing.grouping().steps_of(group).collect();
        let exact;
        let moments = match &far {
            Some(far) if !is_near(group) => far,
            _ => {
                exact = counts.second.of_group(group);
                &exact
            }
        };
        let of_step = |a: usize| -> Vec<f64> {
            (0..steps.len()).map(|b| correlation(moments, a, b)).collect()
        };
        let correlations: Vec<Vec<f64>> = (0..steps.len()).map(of_step).collect();
        let laws = steps.iter().map(|&step| Drawn::of(&laws[step.index()])).collect();
        Some(Group { laws, factor: correlating(&correlations, 0.0)? })
    };
    (0..model.timing.groups()).into_par_iter().map(group).collect()
}

/// None where nothing varies.
fn correlation(group: &GroupMoments, a: usize, b: usize) -> f64 {
    let c = &group.covariance;
    let variances = c[a][a] * c[b][b];
    if variances > 0.0 { c[a][b] / variances.sqrt() } else { 0.0 }
}
