//! Which of many independent counts is the largest, and what the phase makes of it.
//!
//! P(step k counts most) = sum over x of P(r\[k\] = x) P(r\[j\] < x for every j before k)
//! P(r\[j\] <= x for every j after k): the first of equal counts wins. Only steps near
//! the path can lead to it, so only their chances are summed; the others, which may be
//! tens of thousands, are in the products alone. There steps of nearly the same law go
//! together.

use std::collections::HashMap;

use super::law::{CountLaw, laws};
use super::target::Target;
use crate::estimate::expected_counts::ExpectedCounts;

/// From this standard deviation on counts are taken in strides: ties hardly matter.
const WHOLE_NUMBERS_TO: f64 = 16.0;
/// Nodes per standard deviation then.
const NODES_PER_STD: f64 = 10.0;
/// The sums reach so many standard deviations beyond the means.
const REACH_STD: f64 = 8.0;
/// Steps go together whose means are within this share of a standard deviation, and
/// whose standard deviations within this share.
const SAME_MEAN: f64 = 0.04;
const SAME_STD: f64 = 0.01;

/// Products below e to this are nothing.
const LEAST_LOG: f64 = -40.0;

/// Steps that have nearly the same law, their mean one.
struct Alike {
    law: CountLaw,
    number: f64,
}

/// A run of steps of the scan without any that is near the path.
struct Run {
    /// First step after it.
    end: usize,
    steps: Vec<Alike>,
}

/// Expected share of scans that miss the target, for independent steps.
pub(super) fn missed(counts: &ExpectedCounts, target: &Target) -> f64 {
    let laws = laws(counts, target.spad());
    // The phase moves an estimate by up to a chip.
    let reach_ps = target.asked.sensor.clock().ps(2.0);
    let near: Vec<usize> =
        (0..laws.len()).filter(|&step| target.step_error_ps(step).abs() < reach_ps).collect();
    let winners = winners(&laws, &near);
    let found = winners.iter().map(|winner| {
        // The chance to be found hardly changes over the counts that win.
        let found = target.found_from(&laws, winner.step, winner.mean_count);
        winner.chance * found
    });
    1.0 - found.sum::<f64>()
}

/// A step that may count most.
struct Winner {
    step: usize,
    /// Chance that it does.
    chance: f64,
    /// What it counts then, on average.
    mean_count: f64,
}

/// The chances of the steps `near`, which are in order.
fn winners(laws: &[CountLaw], near: &[usize]) -> Vec<Winner> {
    let runs = runs(laws, near);
    let stds = || near.iter().map(|&step| laws[step].std());
    let narrowest = stds().fold(f64::INFINITY, f64::min).max(1e-3);
    let stride = match narrowest > WHOLE_NUMBERS_TO {
        true => narrowest / NODES_PER_STD,
        false => 1.0,
    };
    let ends = near.iter().map(|&step| {
        let reach = REACH_STD * laws[step].std() + 1.0;
        (laws[step].mean - reach, laws[step].mean + reach)
    });
    let (low, high) =
        ends.fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    // Sums of chances, and of chances times counts.
    let mut sums = vec![[0.0; 2]; near.len()];
    let mostly_zero = mostly_zero(laws);
    let mut x = low.floor();
    while x <= high {
        // Without a count above zero there is no estimate.
        if !(mostly_zero && x <= 0.0) {
            let chances = chances_at(laws, near, &runs, x, stride);
            for (sums, chance) in sums.iter_mut().zip(chances) {
                sums[0] += chance;
                sums[1] += chance * x;
            }
        }
        x += stride;
    }
    let with_sums = near.iter().zip(sums).filter(|(_, sums)| sums[0] > 1e-12);
    with_sums
        .map(|(&step, [chance, counts])| Winner { step, chance, mean_count: counts / chance })
        .collect()
}

/// P(each step of `near` counts x, within a stride, and no other more).
fn chances_at(laws: &[CountLaw], near: &[usize], runs: &[Run], x: f64, stride: f64) -> Vec<f64> {
    // Whole numbers: at most x, and less than x. Strides: ties are shared.
    let [at_most, less] = match stride > 1.0 {
        true => [x, x],
        false => [x + 0.5, x - 0.5],
    };
    let log_of = |law: &CountLaw, y: f64| law.below(y).max(1e-300).ln();
    let log_run = |run: &Run, y: f64| -> f64 {
        let of = |alike: &Alike| alike.number * log_of(&alike.law, y);
        run.steps.iter().map(of).sum()
    };
    let log_runs: Vec<[f64; 2]> =
        runs.iter().map(|run| [log_run(run, less), log_run(run, at_most)]).collect();
    let log_of_runs: f64 = log_runs.iter().map(|logs| logs[1]).sum();
    if log_of_runs < LEAST_LOG {
        return vec![0.0; near.len()];
    }
    let log_near: Vec<[f64; 2]> = near
        .iter()
        .map(|&step| [log_of(&laws[step], less), log_of(&laws[step], at_most)])
        .collect();
    // All after; each step, as it is passed, goes to those before.
    let mut log_product = log_of_runs + log_near.iter().map(|logs| logs[1]).sum::<f64>();
    let mut passed = 0;
    let mut chances = Vec::with_capacity(near.len());
    for (&step, logs) in near.iter().zip(&log_near) {
        while passed < runs.len() && runs[passed].end <= step {
            log_product += log_runs[passed][0] - log_runs[passed][1];
            passed += 1;
        }
        let own = laws[step].below(x + 0.5 * stride) - laws[step].below(x - 0.5 * stride);
        chances.push(own.max(0.0) * (log_product - logs[1]).exp());
        log_product += logs[0] - logs[1];
    }
    chances
}

/// The steps that are not near, by runs.
fn runs(laws: &[CountLaw], near: &[usize]) -> Vec<Run> {
    let mut runs = Vec::new();
    let mut start = 0;
    for end in near.iter().copied().chain([laws.len()]) {
        if end > start {
            runs.push(Run { end, steps: alike(&laws[start..end]) });
        }
        start = end + 1;
    }
    runs
}

fn alike(laws: &[CountLaw]) -> Vec<Alike> {
    let mut sums: HashMap<[i64; 2], [f64; 4]> = HashMap::new();
    let typical = laws.iter().map(CountLaw::std).sum::<f64>() / laws.len() as f64;
    for law in laws {
        let mean = (law.mean / (SAME_MEAN * typical.max(1e-9))).round() as i64;
        let std = (law.std().max(1e-9).ln() / SAME_STD).round() as i64;
        let sums = sums.entry([mean, std]).or_default();
        sums[0] += 1.0;
        sums[1] += law.mean;
        sums[2] += law.variance;
        sums[3] += law.total;
    }
    let mut sums: Vec<_> = sums.into_iter().collect();
    // In an order of its own the sum would differ in its last digits from run to run.
    sums.sort_unstable_by_key(|(key, _)| *key);
    sums.into_iter()
        .map(|(_, [number, means, variances, totals])| Alike {
            law: CountLaw {
                mean: means / number,
                variance: variances / number,
                total: totals / number,
                afterpulses: laws[0].afterpulses,
            },
            number,
        })
        .collect()
}

/// Whether most counts are zero in a scan that counts nothing above.
fn mostly_zero(laws: &[CountLaw]) -> bool {
    let zeros = laws.iter().map(|law| {
        let (at_most, less) = (law.below(0.5), law.below(-0.5));
        if at_most > 0.0 { 1.0 - less / at_most } else { 0.0 }
    });
    zeros.sum::<f64>() > 0.5 * laws.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normal(mean: f64, variance: f64) -> CountLaw {
        CountLaw { mean, variance, total: variance, afterpulses: 0.0 }
    }

    #[test]
    fn equal_laws_share_the_chances_and_the_first_of_equals_wins() {
        let law = normal(0.0, 400.0);
        let laws = vec![law; 5];
        let all: Vec<usize> = (0..5).collect();
        for winner in winners(&laws, &all) {
            assert!((winner.chance - 0.2).abs() < 1e-3, "{}", winner.chance);
        }
        // Two steps that count -1, 0, 1: the first wins P(a >= b) = (1 + P(a = b)) / 2.
        let law = normal(0.0, 4.0);
        let equal: f64 = (-20..=20)
            .map(|x| (law.below(f64::from(x) + 0.5) - law.below(f64::from(x) - 0.5)).powi(2))
            .sum();
        let found = winners(&[law; 2], &[0, 1]);
        assert!((found[0].chance - 0.5 * (1.0 + equal)).abs() < 1e-9);
        assert!((found[1].chance - 0.5 * (1.0 - equal)).abs() < 1e-9);
    }

    #[test]
    fn one_peak_among_many_equal_steps_wins_as_in_orthogonal_signalling() {
        // Probability of a right decision among M orthogonal signals at d' = 3, M = 1000:
        // integral of phi(x - 3) Phi(x)^999, here by a plain sum of another step.
        let std = 50.0;
        let mut laws = vec![normal(0.0, std * std); 1000];
        laws[400].mean = 3.0 * std;
        let exact: f64 = (-600..1200)
            .map(|i| {
                let x = f64::from(i) / 100.0;
                let density = (-0.5 * (x - 3.0) * (x - 3.0)).exp() / 2.506_628_274_631_000_5;
                let normal = crate::math::normal_cdf(x);
                0.01 * density * normal.powi(999)
            })
            .sum();
        let found = winners(&laws, &[400]);
        // The lattice's law has a small excess kurtosis of 1 / variance.
        assert!((found[0].chance - exact).abs() < 2e-3, "{} {exact}", found[0].chance);
    }
}
