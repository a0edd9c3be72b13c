//! Bias and scatter of the phase from drawn scans, where several phase steps may have the
//! largest count, or the phase scatters too much for its linearisation.
//!
//! Only steps near the path's peak are drawn: those that may lead to it, and the fine
//! stage's windows round them. Means and variances are exact, covariances of steps that share
//! their light too; the same random numbers are drawn every time.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::law::CountLaw;
use super::target::Target;
use crate::estimate::delay_error_ps;
use crate::estimate::expected_counts::ExpectedCounts;
use crate::estimate::phase::estimate_at;
use crate::math::correlating;
use crate::scan::{Scan, Step};

/// Scans drawn: standard errors of 1.1 % of a standard deviation for the bias, 0.8 % for the
/// standard deviation.
const SCANS: u64 = 8_000;
const SEED: u64 = 0x6e65_6172;
/// Fewer scans that find the path have no statistics.
const LEAST_FOUND: usize = 400;

/// Mean and standard deviation of the delay's errors, in ps, of scans whose largest count is
/// within a chip of step `peak`; none where few of those have a fine estimate.
pub(super) fn errors_ps(
    counts: &ExpectedCounts,
    target: &Target,
    peak: usize,
) -> Option<(f64, f64)> {
    let timing = target.sensor.timing();
    let chip = i64::from(timing.clock.samples_per_chip);
    let near = around(&timing.scan, peak, 2 * chip);
    let leading = around(&timing.scan, peak, chip);
    let drawn = Drawn::of(counts, target, &near, peak)?;
    let error_ps = |values: &mut Vec<f64>, scan: u64| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(SEED + scan);
        drawn.draw(&mut rng, &near, values);
        let largest = leading
            .iter()
            .copied()
            .reduce(|best, step| if values[step] > values[best] { step } else { best });
        let estimate = estimate_at(values, largest?, timing, 0.0);
        let error_ps = delay_error_ps(estimate.delay_ps, target.measured_ps, target.code_period_ps);
        let is_found = target.accepted.low_ps <= error_ps && error_ps <= target.accepted.high_ps;
        (estimate.is_fine() && is_found).then_some(error_ps)
    };
    let expected = counts.signed();
    let scans = (0..SCANS).into_par_iter();
    let errors_ps: Vec<Option<f64>> = scans.map_init(|| expected.clone(), error_ps).collect();
    let errors_ps: Vec<f64> = errors_ps.into_iter().flatten().collect();
    let count = errors_ps.len() as f64;
    let mean = errors_ps.iter().sum::<f64>() / count;
    let squares = errors_ps.iter().map(|error| (error - mean).powi(2)).sum::<f64>();
    (errors_ps.len() >= LEAST_FOUND).then(|| (mean, (squares / (count - 1.0)).sqrt()))
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

/// Counts of some steps.
struct Drawn {
    laws: Vec<(CountLaw, [f64; 4])>,
    /// Of standard normal numbers that go together as the counts do.
    factor: Vec<Vec<f64>>,
}

impl Drawn {
    /// Of steps that count light of their own those of the peak's window, whose variances are
    /// known already, stand for the ones beside it.
    fn of(counts: &ExpectedCounts, target: &Target, near: &[usize], peak: usize) -> Option<Drawn> {
        let timing = &counts.model().timing;
        let chip = i64::from(timing.clock.samples_per_chip);
        let n = near.len();
        let mut covariance = vec![vec![0.0; n]; n];
        if timing.parallel == 1 {
            let nearest: Vec<Step> =
                near.iter().map(|&step| nearest_within(&timing.scan, peak, step, chip)).collect();
            for (place, moments) in counts.second.of_steps(&nearest).iter().enumerate() {
                covariance[place][place] = moments.signed_variance;
            }
        }
        if timing.parallel > 1 {
            let group = |place: usize| timing.grouping().group_of(Step::at(near[place]));
            let mut left: Vec<usize> = (0..n).collect();
            while let Some(&first) = left.first() {
                let (own, others) = left.into_iter().partition(|&p| group(p) == group(first));
                left = others;
                let own: Vec<usize> = own;
                let steps: Vec<Step> = own.iter().map(|&place| Step::at(near[place])).collect();
                let moments = counts.second.of_steps_together(&steps);
                for (i, &a) in own.iter().enumerate() {
                    for (j, &b) in own.iter().enumerate() {
                        covariance[a][b] = moments.covariance[i][j];
                    }
                }
            }
        }
        let spad = &target.sensor.scene().detectors[target.detector];
        let law = |place: usize| {
            let mean = &counts.means[near[place]];
            let law = CountLaw {
                mean: mean.signed,
                variance: covariance[place][place].max(0.0),
                total: mean.total,
                afterpulses: -(-spad.afterpulsing_probability).ln_1p(),
            };
            (law, law.deviation_of_normal())
        };
        let laws: Vec<_> = (0..n).map(law).collect();
        let correlation = |a: usize, b: usize| {
            let variances = covariance[a][a] * covariance[b][b];
            if variances > 0.0 { covariance[a][b] / variances.sqrt() } else { 0.0 }
        };
        let correlations: Vec<Vec<f64>> =
            (0..n).map(|a| (0..n).map(|b| correlation(a, b)).collect()).collect();
        Some(Drawn { laws, factor: correlating(&correlations, 0.0)? })
    }

    fn draw(&self, rng: &mut Xoshiro256PlusPlus, near: &[usize], values: &mut [f64]) {
        let normal: Vec<f64> = near.iter().map(|_| StandardNormal.sample(rng)).collect();
        for (((law, bent), row), &step) in self.laws.iter().zip(&self.factor).zip(near) {
            let z: f64 = row.iter().zip(&normal).map(|(f, z)| f * z).sum();
            let [c0, c1, c2, c3] = bent;
            let deviation = c0 + z * (c1 + z * (c2 + z * c3));
            values[step] = (law.mean + law.std() * deviation).round();
        }
    }
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
