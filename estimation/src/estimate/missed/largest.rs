//! Which of many independent counts is the largest, and what the phase makes of it.
//!
//! P(step k counts most) = sum over x of P(r\[k\] = x) P(r\[j\] < x for every j before k)
//! P(r\[j\] <= x for every j after k): the first of equal counts wins. Only steps near
//! the path can lead to it, so only their chances are summed; the others, which may be
//! tens of thousands, are in the products alone. There steps of nearly the same law go
//! together.

use std::collections::HashMap;

use super::target::MissConditions;
use crate::estimate::count_law::{CountLaw, laws};
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
pub(super) fn missed(counts: &ExpectedCounts, target: &MissConditions) -> f64 {
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
    let near_laws: Vec<CountLaw> = near.iter().map(|&step| laws[step]).collect();
    let narrowest = near_laws.iter().map(CountLaw::std).fold(f64::INFINITY, f64::min).max(1e-3);
    let stride = match narrowest > WHOLE_NUMBERS_TO {
        true => narrowest / NODES_PER_STD,
        false => 1.0,
    };
    let ends = near_laws.iter().map(|law| {
        let reach = REACH_STD * law.std() + 1.0;
        (law.mean - reach, law.mean + reach)
    });
    let (low, high) =
        ends.fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    // Sums of chances, and of chances times counts.
    let mut sums = vec![[0.0; 2]; near.len()];
    let below = |y: f64| Below::of(&near_laws, &runs, y);
    let mut x = low.floor();
    // Without a count above zero there is no estimate.
    if mostly_zero(&near_laws, &runs) {
        x = x.max(1.0);
    }
    let mut less = below(x - 0.5 * stride);
    while x <= high {
        let at_most = below(x + 0.5 * stride);
        // In strides ties are shared.
        let middle = (stride > 1.0).then(|| below(x));
        let others = match &middle {
            Some(middle) => [middle; 2],
            None => [&less, &at_most],
        };
        let own = at_most.near.iter().zip(&less.near).map(|(most, less)| (most - less).max(0.0));
        for (sums, chance) in sums.iter_mut().zip(chances(near, &runs, own, others)) {
            sums[0] += chance;
            sums[1] += chance * x;
        }
        less = at_most;
        x += stride;
    }
    let with_sums = near.iter().zip(sums).filter(|(_, sums)| sums[0] > 1e-12);
    with_sums
        .map(|(&step, [chance, counts])| Winner { step, chance, mean_count: counts / chance })
        .collect()
}

/// The chances that steps count less than some count.
struct Below {
    /// Of each step near the path.
    near: Vec<f64>,
    /// Logarithm of the chance that all of a run do.
    runs: Vec<f64>,
}

impl Below {
    fn of(near: &[CountLaw], runs: &[Run], y: f64) -> Below {
        let log_of = |alike: &Alike| alike.number * log(alike.law.below(y));
        Below {
            near: near.iter().map(|law| law.below(y)).collect(),
            runs: runs.iter().map(|run| run.steps.iter().map(log_of).sum()).collect(),
        }
    }
}

fn log(chance: f64) -> f64 {
    chance.max(1e-300).ln()
}

/// P(each step of `near` counts what it does with chance `own`, and no other more): those before
/// it count `less`, those after it `at_most` as much.
fn chances(
    near: &[usize],
    runs: &[Run],
    own: impl Iterator<Item = f64>,
    [less, at_most]: [&Below; 2],
) -> Vec<f64> {
    let log_of_runs: f64 = at_most.runs.iter().sum();
    if log_of_runs < LEAST_LOG {
        return vec![0.0; near.len()];
    }
    let log_near = |below: &Below| -> Vec<f64> { below.near.iter().map(|&p| log(p)).collect() };
    let (log_less, log_most) = (log_near(less), log_near(at_most));
    // All after; each step, as it is passed, goes to those before.
    let mut log_product = log_of_runs + log_most.iter().sum::<f64>();
    let mut passed = 0;
    let mut chances = Vec::with_capacity(near.len());
    for ((&step, own), (log_less, log_most)) in
        near.iter().zip(own).zip(log_less.iter().zip(&log_most))
    {
        while passed < runs.len() && runs[passed].end <= step {
            log_product += less.runs[passed] - at_most.runs[passed];
            passed += 1;
        }
        chances.push(own * (log_product - log_most).exp());
        log_product += log_less - log_most;
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
fn mostly_zero(near: &[CountLaw], runs: &[Run]) -> bool {
    let others = runs.iter().flat_map(|run| &run.steps).map(|alike| (&alike.law, alike.number));
    let (mut steps, mut zeros) = (0.0, 0.0);
    for (law, number) in near.iter().map(|law| (law, 1.0)).chain(others) {
        let (at_most, less) = (law.below(0.5), law.below(-0.5));
        steps += number;
        zeros += if at_most > 0.0 { number * (1.0 - less / at_most) } else { 0.0 };
    }
    zeros > 0.5 * steps
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
