//! Means, variances and covariance of the counts, step by step.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::MeanResponseError;
use super::expected::MeanResponse;
use super::grid::{Samples, frame_chips};
use super::pairs::{DetectorPairs, before_chips};
use crate::scan::{Group, Step};

/// Moments of the signed count r and the total count N of one phase step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CountMoments {
    /// Mean of r.
    pub signed_mean: f64,
    /// Mean of N.
    pub total_mean: f64,
    /// Variance of r.
    pub signed_variance: f64,
    /// Variance of N.
    pub total_variance: f64,
    /// Covariance of r and N.
    pub covariance: f64,
}

/// Moments of the counts of one group of phase steps, which share their light.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GroupMoments {
    /// Mean of r of each step that was asked for.
    pub signed_means: Vec<f64>,
    /// Mean of N, which is one and the same for all of them.
    pub total_mean: f64,
    /// Covariances of r of each step and, last, of N.
    pub covariance: Vec<Vec<f64>>,
}

impl GroupMoments {
    /// Those of the first `steps` steps only.
    pub fn of_first(&self, steps: usize) -> GroupMoments {
        let total = self.signed_means.len();
        let kept: Vec<usize> = (0..steps.min(total)).chain([total]).collect();
        let row = |&a: &usize| kept.iter().map(|&b| self.covariance[a][b]).collect();
        GroupMoments {
            signed_means: self.signed_means.iter().take(steps).copied().collect(),
            total_mean: self.total_mean,
            covariance: kept.iter().map(row).collect(),
        }
    }
}

/// Second moments of the counts around a mean response, for steps that last much
/// longer than the detector's memory. Signs are taken without jitter.
pub struct SecondMoments<'r, 'm> {
    pub(super) response: &'r MeanResponse<'m>,
    pub(super) pairs: DetectorPairs,
    /// Variance of N that the chips before each chip add.
    total_variance: Vec<f64>,
    /// Moments of the steps that were asked for so far.
    known: Mutex<BTreeMap<Step, CountMoments>>,
}

impl<'r, 'm> SecondMoments<'r, 'm> {
    /// Solves for the states of the detector, and for the total count.
    ///
    /// # Errors
    /// As for the mean response.
    pub fn new(response: &'r MeanResponse<'m>) -> Result<SecondMoments<'r, 'm>, MeanResponseError> {
        let samples = Samples { origin_chips: origin_chips(response), sampling: response.sampling };
        let pairs = DetectorPairs::new(response.model, &response.light, samples)?;
        let per_cell = pairs.hits.iter().zip(&pairs.excess_of_all);
        let per_cell = per_cell
            .zip(pairs.seen_of_period())
            .map(|((hits, excess), seen)| seen * (hits + 2.0 * excess));
        let total_variance = before_chips(&pairs.grid, per_cell);
        Ok(SecondMoments { response, pairs, total_variance, known: Mutex::default() })
    }

    /// Moments of a step of the first scan.
    pub fn of_step(&self, step: Step) -> CountMoments {
        let mean = self.response.mean_count(step);
        let signs = self.signs(self.response.model.timing.scan.phase_step(step));
        let excess = self.pairs.excess(&signs);
        let grid = &self.pairs.grid;
        let cells = || {
            let cells = self.pairs.hits.iter().zip(&signs).zip(&excess);
            cells.zip(self.pairs.seen_of_period())
        };
        let variance = cells().map(|(((hits, s), q), seen)| seen * hits + 2.0 * s * q);
        let covariance = cells()
            .zip(&self.pairs.excess_of_all)
            .map(|((((hits, s), q), seen), q_all)| s * (hits + q_all) + seen * q);
        CountMoments {
            signed_mean: mean.signed,
            total_mean: mean.total,
            signed_variance: self.over_step(step, &before_chips(grid, variance)),
            total_variance: self.total_variance(step),
            covariance: self.over_step(step, &before_chips(grid, covariance)),
        }
    }

    /// Moments of some steps of the first scan, on all processors. They are kept:
    /// a step that is asked for again costs nothing.
    pub fn of_steps(&self, steps: &[Step]) -> Vec<CountMoments> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let mut unknown: Vec<Step> = steps.to_vec();
        unknown.retain(|step| !known.contains_key(step));
        let found: Vec<CountMoments> = unknown.par_iter().map(|&step| self.of_step(step)).collect();
        known.extend(unknown.into_iter().zip(found));
        steps.iter().map(|step| known[step]).collect()
    }

    /// Variance of the sum of weight x r over steps of one group, which count the
    /// same detections: that of one count with the weighted sum of their signs.
    ///
    /// # Panics
    /// If there are no steps.
    pub fn variance_of_sum(&self, steps: &[(Step, f64)]) -> f64 {
        let mut sign = vec![0.0; self.pairs.hits.len()];
        // Mean of the squared sign of what is seen: that of one step is 1 also in a
        // cell that an edge divides, where its mean is not. Cells are no wider than an
        // eighth of a chip, so edges of two steps seldom lie in one.
        let mut spread = sign.clone();
        for &(step, weight) in steps {
            let signs = self.signs(self.response.model.timing.scan.phase_step(step));
            let sums = sign.iter_mut().zip(&mut spread);
            for ((sum, spread), (s, seen)) in
                sums.zip(signs.iter().zip(self.pairs.seen_of_period()))
            {
                *sum += weight * s;
                *spread += weight * weight * (seen - of_seen(s * s, seen));
            }
        }
        let excess = self.pairs.excess(&sign);
        let cells = self.pairs.hits.iter().zip(&sign).zip(&spread).zip(&excess);
        let variance =
            cells.zip(self.pairs.seen_of_period()).map(|((((hits, s), spread), q), seen)| {
                hits * (of_seen(s * s, seen) + spread) + 2.0 * s * q
            });
        self.over_step(steps[0].0, &before_chips(&self.pairs.grid, variance))
    }

    /// Moments of the counts of a whole group.
    pub fn of_group(&self, group: Group) -> GroupMoments {
        let steps = self.response.model.timing.grouping().steps_of(group);
        self.of_steps_together(&steps.collect::<Vec<_>>())
    }

    /// Moments of the counts of some steps of one group.
    ///
    /// # Panics
    /// If there are no steps.
    pub fn of_steps_together(&self, steps: &[Step]) -> GroupMoments {
        let model = self.response.model;
        let first = steps[0];
        let signs: Vec<Vec<f64>> =
            steps.iter().map(|&step| self.signs(model.timing.scan.phase_step(step))).collect();
        let excess: Vec<Vec<f64>> = signs.par_iter().map(|s| self.pairs.excess(s)).collect();
        let grid = &self.pairs.grid;
        let hits = &self.pairs.hits;
        let seen: Vec<f64> = self.pairs.seen_of_period().collect();
        let over_step = |of_cell: &dyn Fn(usize) -> f64| {
            self.over_step(first, &before_chips(grid, (0..hits.len()).map(of_cell)))
        };
        let count = steps.len();
        let mut covariance = vec![vec![0.0; count + 1]; count + 1];
        for a in 0..count {
            for b in 0..=a {
                let (sa, sb, qa, qb) = (&signs[a], &signs[b], &excess[a], &excess[b]);
                let product = |cell: usize| match a == b {
                    true => seen[cell],
                    false => of_seen(sa[cell] * sb[cell], seen[cell]),
                };
                covariance[a][b] =
                    over_step(&|c| hits[c] * product(c) + sa[c] * qb[c] + sb[c] * qa[c]);
                covariance[b][a] = covariance[a][b];
            }
            let all = &self.pairs.excess_of_all;
            covariance[a][count] =
                over_step(&|c| signs[a][c] * (hits[c] + all[c]) + seen[c] * excess[a][c]);
            covariance[count][a] = covariance[a][count];
        }
        covariance[count][count] = self.total_variance(first);
        let means = steps.iter().map(|&step| self.response.mean_count(step));
        GroupMoments {
            signed_means: means.map(|mean| mean.signed).collect(),
            total_mean: self.response.mean_count(first).total,
            covariance,
        }
    }

    /// Variance of N of a step.
    pub(super) fn total_variance(&self, step: Step) -> f64 {
        self.over_step(step, &self.total_variance)
    }

    /// Mean sign in every cell of the code period, 0 where no sample sees a pulse.
    fn signs(&self, phase_step: u64) -> Vec<f64> {
        let response = self.response;
        let chips = &response.model.reference.chips;
        let chip_at = |chip: i64| chips[chip.rem_euclid(chips.len() as i64) as usize];
        // Code chip 0 begins here, in the grid's frame.
        let phase = phase_step as f64 / f64::from(response.model.timing.clock.samples_per_chip);
        let timing = &response.timing;
        let [rising, falling] =
            [timing.rising, timing.falling].map(|edge| phase + edge - self.frame_chips());
        let whole = rising.min(falling).floor();
        let [rise, fall] = [rising, falling].map(|edge| self.pairs.shares_after(edge - whole));
        let grid = &self.pairs.grid;
        let mut signs = Vec::with_capacity(self.pairs.hits.len());
        for chip in 0..grid.period_chips as i64 {
            let [two_before, before, after] =
                [2, 1, 0].map(|back| chip_at(chip - whole as i64 - back));
            for cell in 0..grid.cells.len() {
                // An edge a little over a chip late still belongs to the chip before.
                let seen = self.pairs.seen[cell];
                let level = level_after(two_before, before, rise[1][cell], fall[1][cell], seen)
                    + level_after(before, after, rise[0][cell], fall[0][cell], seen)
                    - f64::from(before) * seen;
                signs.push(2.0 * level - seen);
            }
        }
        signs
    }

    /// Registered time of the grid's origin, in chips.
    pub(super) fn frame_chips(&self) -> f64 {
        origin_chips(self.response)
    }

    /// What the chips of a step add up to; `before` has the sums before each chip
    /// of the grid. The window's edges are rounded to whole chips of the grid.
    fn over_step(&self, step: Step, before: &[f64]) -> f64 {
        let period = self.pairs.grid.period_chips;
        let (periods, first, rest) = self.response.chips_of(step);
        let shift = (self.frame_chips() - self.response.timing.window).round() as i64;
        let first = (first as i64 - shift).rem_euclid(period as i64) as usize;
        let end = first + rest;
        let partial = match end.checked_sub(period) {
            None => before[end] - before[first],
            Some(past) => before[period] - before[first] + before[past],
        };
        periods * before[period] + partial
    }
}

/// Registered time of the origin of a response's grid, in chips.
fn origin_chips(response: &MeanResponse) -> f64 {
    frame_chips(&response.light) + response.delay_chips + response.model.delay_chips
}

/// A mean over what is seen of a cell, taken as its mean's square would be: of the
/// square of a sum over the cell, and the seen share.
fn of_seen(square: f64, seen: f64) -> f64 {
    if seen > 0.0 { square / seen } else { 0.0 }
}

/// Mean level over what is seen of a cell that an edge from `before` to `after` may
/// divide.
fn level_after(before: u8, after: u8, after_rise: f64, after_fall: f64, seen: f64) -> f64 {
    match (before, after) {
        (0, 1) => after_rise,
        (1, 0) => seen - after_fall,
        _ => f64::from(after) * seen,
    }
}
