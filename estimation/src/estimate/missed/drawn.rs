//! Scans drawn from the counts' exact moments: where counts go together, where several phase steps
//! may have the largest count, or the phase scatters too much for its linearisation.
//!
//! Counts have the exact means and variances, and the skewness and kurtosis of their law; those
//! of steps that share their light go together. The same random numbers are drawn every time, so
//! that the answer depends on the scene alone.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::target::MissConditions;
use crate::estimate::count_law::{CountLaw, laws};
use crate::estimate::delay_error_ps;
use crate::estimate::expected_counts::ExpectedCounts;
use crate::estimate::fit::start::PeakShape;
use crate::estimate::phase::{estimate_at, first_maximum};
use crate::estimate::truth::Asked;
use crate::math::correlating;
use crate::scan::{self, Scan, Step};
use crate::scene::EstimatorKind;
use crate::sensor::Sensor;

/// Counts drawn for a share of misses, about, and the scans that they may make.
const COUNTS: u64 = 16_000_000;
const SCANS: std::ops::RangeInclusive<u64> = 100..=20_000;
const SEED: u64 = 0x6d69_7373_6564;
/// Groups whose steps come this near to the path, in chips, have exact covariances; all others
/// the correlations of one group far from it.
const NEAR_CHIPS: f64 = 3.0;

/// Scans drawn for errors: standard errors of 1.1 % of a standard deviation for the bias, 0.8 %
/// for the standard deviation.
pub(super) const SCANS_FOR_ERRORS: u64 = 8_000;
const SEED_FOR_ERRORS: u64 = 0x6e65_6172;
/// Fewer scans that find the path have no statistics.
const LEAST_FOUND: usize = 400;

/// Counts that are drawn one after the other: normal numbers, each bent to its step's law.
struct DrawnCounts {
    laws: Vec<Bent>,
    /// L, of counts that go together: their normal numbers are L z.
    factor: Option<Vec<Vec<f64>>>,
}

/// mean + std (c0 + c1 z + c2 z^2 + c3 z^3), of counts the nearest whole number.
struct Bent {
    mean: f64,
    std: f64,
    deviation: [f64; 4],
    is_count: bool,
}

impl DrawnCounts {
    /// Counts with some laws that go together as `covariance` says; none where that has no finite
    /// numbers.
    fn together(laws: &[CountLaw], covariance: &[Vec<f64>]) -> Option<DrawnCounts> {
        DrawnCounts::bent(laws.iter().map(Bent::of).collect(), covariance)
    }

    fn bent(laws: Vec<Bent>, covariance: &[Vec<f64>]) -> Option<DrawnCounts> {
        let correlation = |a: usize, b: usize| {
            let variances = covariance[a][a] * covariance[b][b];
            if variances > 0.0 { covariance[a][b] / variances.sqrt() } else { 0.0 }
        };
        let row = |a: usize| (0..laws.len()).map(|b| correlation(a, b)).collect();
        let correlations: Vec<Vec<f64>> = (0..laws.len()).map(row).collect();
        let factor = correlating(&correlations, 0.0)?;
        Some(DrawnCounts { laws, factor: Some(factor) })
    }

    /// Counts none of which goes with another.
    fn alone(laws: impl Iterator<Item = CountLaw>) -> DrawnCounts {
        DrawnCounts { laws: laws.map(|law| Bent::of(&law)).collect(), factor: None }
    }

    /// Gives `each` one count after the other. `normal` keeps the place of their normal numbers.
    fn draw(&self, rng: &mut Xoshiro256PlusPlus, normal: &mut Vec<f64>, mut each: impl FnMut(f64)) {
        let Some(factor) = &self.factor else {
            return self.laws.iter().for_each(|law| each(law.bend(StandardNormal.sample(rng))));
        };
        normal.clear();
        normal.extend(self.laws.iter().map(|_| -> f64 { StandardNormal.sample(rng) }));
        for (law, row) in self.laws.iter().zip(factor) {
            each(law.bend(row.iter().zip(&*normal).map(|(f, z)| f * z).sum()));
        }
    }
}

impl Bent {
    fn of(law: &CountLaw) -> Bent {
        let std = law.variance.max(0.0).sqrt();
        Bent { mean: law.mean, std, deviation: law.deviation_of_normal(), is_count: true }
    }

    fn normal(mean: f64, variance: f64) -> Bent {
        let std = variance.max(0.0).sqrt();
        Bent { mean, std, deviation: [0.0, 1.0, 0.0, 0.0], is_count: false }
    }

    /// The value that a standard normal number stands for.
    fn bend(&self, z: f64) -> f64 {
        let [c0, c1, c2, c3] = self.deviation;
        let deviation = c0 + z * (c1 + z * (c2 + z * c3));
        let value = self.mean + self.std * deviation;
        if self.is_count { value.round() } else { value }
    }
}

/// Expected share of scans that miss the target, with a standard error of
/// sqrt(p (1 - p) / scans); none where the moments are no finite numbers.
pub(super) fn missed(counts: &ExpectedCounts, target: &MissConditions) -> Option<f64> {
    let groups = groups_of_scan(counts, target)?;
    let Asked { sensor, detector, .. } = target.asked;
    let scans = scans(sensor);
    let is_model = sensor.scene().estimator == EstimatorKind::Model;
    let shape = is_model.then(|| PeakShape::of(sensor, detector, None));
    let draws = (0..scans).into_par_iter().filter(|scan| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(SEED + scan);
        let (mut values, mut normal) = (Vec::with_capacity(counts.means.len()), Vec::new());
        for group in &groups {
            group.draw(&mut rng, &mut normal, |value| values.push(value));
        }
        target.found_in(&values, shape.as_ref())
    });
    Some(1.0 - draws.count() as f64 / scans as f64)
}

/// Scans that are drawn.
pub(super) fn scans(sensor: &Sensor) -> u64 {
    let counts = sensor.timing().scan.steps * work_per_count(sensor);
    (COUNTS / counts).clamp(*SCANS.start(), *SCANS.end())
}

/// What a count costs beside drawing it: the model estimator's coarse stage transforms it there and back.
fn work_per_count(sensor: &Sensor) -> u64 {
    if sensor.scene().estimator == EstimatorKind::Model { 3 } else { 1 }
}

impl MissConditions<'_> {
    /// Whether the estimator finds the path in a scan's counts. The model estimator's
    /// fit goes to the peak that its start is at.
    fn found_in(&self, values: &[f64], shape: Option<&PeakShape>) -> bool {
        let zeros = values.iter().filter(|&&value| value == 0.0).count();
        if values.iter().all(|&value| value <= 0.0) && 2 * zeros > values.len() {
            return false;
        }
        if let Some(shape) = shape {
            let start_ps = self.step_error_ps(shape.best_match(values).0);
            return self.accepts(self.measured_ps + start_ps, 1.0);
        }
        let timing = self.asked.sensor.timing();
        let estimate = estimate_at(values, first_maximum(values), timing, 0.0);
        self.accepts(estimate.delay_ps, 1.0)
    }
}

fn groups_of_scan(counts: &ExpectedCounts, target: &MissConditions) -> Option<Vec<DrawnCounts>> {
    let model = counts.model();
    let laws = laws(counts, target.spad());
    if model.timing.parallel == 1 {
        return Some(vec![DrawnCounts::alone(laws.into_iter())]);
    }
    let reach_ps = target.asked.sensor.clock().ps(NEAR_CHIPS);
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
        let laws: Vec<CountLaw> = steps.iter().map(|&step| laws[step.index()]).collect();
        DrawnCounts::together(&laws, &moments.covariance)
    };
    (0..model.timing.groups()).into_par_iter().map(group).collect()
}

/// What scans say of a path whose largest count is [near](MissConditions::leading) a step.
pub struct DrawnErrors {
    /// Share of those that find the path with a fine estimate.
    pub found_fraction: f64,
    /// Mean and standard deviation of these estimates' errors, in ps; none where they are few.
    pub errors_ps: Option<(f64, f64)>,
}

/// Of counts whose largest is near step `peak`.
pub(super) fn errors(
    counts: &ExpectedCounts,
    target: &MissConditions,
    peak: usize,
) -> Option<DrawnErrors> {
    let near = target.near(peak);
    let groups = groups_of_steps(counts, target, &near, peak)?;
    Some(errors_of_groups(&counts.signed(), &groups, target, peak))
}

/// The same of normal values of all phase steps, of which those near the peak have the covariance
/// that `covariance` gives for them.
pub(super) fn errors_of_values<E>(
    values: &[f64],
    covariance: impl FnOnce(&[Step]) -> Result<Vec<Vec<f64>>, E>,
    target: &MissConditions,
    peak: usize,
) -> Result<Option<DrawnErrors>, E> {
    let near = target.near(peak);
    let steps: Vec<Step> = near.iter().map(|&step| Step::at(step)).collect();
    let covariance = covariance(&steps)?;
    let laws =
        near.iter().enumerate().map(|(i, &step)| Bent::normal(values[step], covariance[i][i]));
    let group = DrawnCounts::bent(laws.collect(), &covariance);
    Ok(group.map(|group| errors_of_groups(values, &[group], target, peak)))
}

impl MissConditions<'_> {
    /// As far from the expected peak as the largest count of scans that find the path is looked for, in phase steps: a chip, and
    /// as much farther as jitter blurs the peak.
    fn leading(&self) -> i64 {
        let chips = 1 + self.blurred_chips() as i64;
        i64::from(self.asked.sensor.clock().samples_per_chip) * chips
    }

    /// By how many chips jitter widens the peak.
    pub(super) fn blurred_chips(&self) -> u32 {
        (2.0 * self.asked.sensor.clock().chips(self.spad().jitter_std_ps())) as u32
    }

    /// Steps whose values decide the estimate of these scans, in the scan's order.
    fn near(&self, peak: usize) -> Vec<usize> {
        let timing = self.asked.sensor.timing();
        let window = i64::from(timing.clock.samples_per_chip);
        around(&timing.scan, peak, self.leading() + window)
    }
}

fn errors_of_groups(
    expected: &[f64],
    groups: &[DrawnCounts],
    target: &MissConditions,
    peak: usize,
) -> DrawnErrors {
    let timing = target.asked.sensor.timing();
    let leading = around(&timing.scan, peak, target.leading());
    let near = target.near(peak);
    let error_ps = |(values, normal): &mut (Vec<f64>, Vec<f64>), scan: u64| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(SEED_FOR_ERRORS + scan);
        let mut steps = near.iter();
        for group in groups {
            group.draw(&mut rng, normal, |value| {
                if let Some(&step) = steps.next() {
                    values[step] = value;
                }
            });
        }
        let largest = leading
            .iter()
            .copied()
            .reduce(|best, step| if values[step] > values[best] { step } else { best });
        let estimate = estimate_at(values, largest?, timing, 0.0);
        let error_ps = delay_error_ps(estimate.delay_ps, target.measured_ps, target.code_period_ps);
        let is_found = target.accepted.low_ps <= error_ps && error_ps <= target.accepted.high_ps;
        (estimate.is_fine() && is_found).then_some(error_ps)
    };
    let scans = (0..SCANS_FOR_ERRORS).into_par_iter();
    let places = || (expected.to_vec(), Vec::new());
    let errors_ps: Vec<Option<f64>> = scans.map_init(places, error_ps).collect();
    let errors_ps: Vec<f64> = errors_ps.into_iter().flatten().collect();
    let count = errors_ps.len() as f64;
    let mean = errors_ps.iter().sum::<f64>() / count;
    let squares = errors_ps.iter().map(|error| (error - mean).powi(2)).sum::<f64>();
    let are_enough = errors_ps.len() >= LEAST_FOUND;
    DrawnErrors {
        found_fraction: count / SCANS_FOR_ERRORS as f64,
        errors_ps: are_enough.then(|| (mean, (squares / (count - 1.0)).sqrt())),
    }
}

/// Counts of some steps near a peak, in the scan's order: those of a group go together.
///
/// Of steps that count light of their own those of the peak's window, whose variances are
/// known already, stand for the ones beside it.
fn groups_of_steps(
    counts: &ExpectedCounts,
    target: &MissConditions,
    near: &[usize],
    peak: usize,
) -> Option<Vec<DrawnCounts>> {
    let timing = &counts.model().timing;
    let law = |step: usize, variance: f64| {
        CountLaw::of(target.spad(), &counts.means[step], variance.max(0.0))
    };
    if timing.parallel == 1 {
        let chip = i64::from(timing.clock.samples_per_chip);
        let nearest = near.iter().map(|&step| nearest_within(&timing.scan, peak, step, chip));
        let moments = counts.second.of_steps(&nearest.collect::<Vec<_>>());
        let laws = near.iter().zip(moments).map(|(&step, of)| law(step, of.signed_variance));
        return Some(vec![DrawnCounts::alone(laws)]);
    }
    let group = |step: usize| timing.grouping().group_of(Step::at(step));
    let groups = near.chunk_by(|&a, &b| group(a) == group(b));
    let drawn = groups.map(|own| {
        let steps: Vec<Step> = own.iter().map(|&step| Step::at(step)).collect();
        let covariance = counts.second.of_steps_together(&steps).covariance;
        let laws = own.iter().enumerate().map(|(lane, &step)| law(step, covariance[lane][lane]));
        DrawnCounts::together(&laws.collect::<Vec<_>>(), &covariance)
    });
    drawn.collect()
}

/// Steps of a scan at most so far from one of them, each once, in the scan's order.
fn around(scan: &Scan, peak: usize, reach: i64) -> Vec<usize> {
    let steps = scan.steps as i64;
    let mut near: Vec<usize> = (-reach..=reach)
        .map(|offset| peak as i64 + offset)
        .filter(|step| scan.is_full() || (0..steps).contains(step))
        .map(|step| step.rem_euclid(steps) as usize)
        .collect();
    near.sort_unstable();
    near.dedup();
    near
}

/// The step nearest to `step` among those of the fine stage's window round a peak.
fn nearest_within(scan: &Scan, peak: usize, step: usize, chip: i64) -> Step {
    let steps = scan.steps as i64;
    let apart = step as i64 - peak as i64;
    let offset = match scan.is_full() {
        true => (apart + steps / 2).rem_euclid(steps) - steps / 2,
        false => apart,
    };
    let place = peak as i64 + offset.clamp(-chip, chip - 1);
    Step::at(match scan.is_full() {
        true => place.rem_euclid(steps),
        false => place.clamp(0, steps - 1),
    } as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_round_a_peak_wrap_in_full_scans_alone() {
        let scan = |steps| Scan {
            first_step: 0,
            steps,
            steps_per_period: 14,
            integration_chips: 1,
            requested_integration_ps: 1.0,
        };
        assert_eq!(around(&scan(14), 1, 2), [0, 1, 2, 3, 13]);
        assert_eq!(around(&scan(13), 1, 2), [0, 1, 2, 3]);
        assert_eq!(around(&scan(14), 1, 20), (0..14).collect::<Vec<_>>());
    }
}
