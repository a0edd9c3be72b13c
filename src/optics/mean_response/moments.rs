//! Means, variances and covariance of the counts, step by step.

use super::MeanResponseError;
use super::expected::MeanResponse;
use super::grid::frame_chips;
use super::pairs::{DetectorPairs, before_chips};
use super::scan_moments;

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

/// Second moments of the counts around a mean response, for steps that last much
/// longer than the detector's memory. Signs are taken without jitter.
pub struct SecondMoments<'r, 'm> {
    pub(super) response: &'r MeanResponse<'m>,
    pub(super) pairs: DetectorPairs,
    /// Variance of N that the chips before each chip add.
    total_variance: Vec<f64>,
}

impl<'r, 'm> SecondMoments<'r, 'm> {
    /// Solves for the states of the detector, and for the total count.
    ///
    /// # Errors
    /// As for the mean response.
    pub fn new(response: &'r MeanResponse<'m>) -> Result<SecondMoments<'r, 'm>, MeanResponseError> {
        let pairs = DetectorPairs::new(response.model, &response.light)?;
        let per_cell = pairs.hits.iter().zip(&pairs.excess_of_all);
        let per_cell = per_cell.map(|(hits, excess)| hits + 2.0 * excess);
        let total_variance = before_chips(&pairs.grid, per_cell);
        Ok(SecondMoments {
            response,
            pairs,
            total_variance,
        })
    }

    /// Moments of step number `step` of the first scan.
    pub fn of_step(&self, step: u64) -> CountMoments {
        let mean = self.response.mean_count(step);
        let signs = self.signs(self.response.model.scan.step(step));
        let excess = self.pairs.excess(&signs);
        let grid = &self.pairs.grid;
        let cells = || self.pairs.hits.iter().zip(&signs).zip(&excess);
        let variance = cells().map(|((hits, s), q)| hits + 2.0 * s * q);
        let covariance = cells()
            .zip(&self.pairs.excess_of_all)
            .map(|(((hits, s), q), q_all)| s * (hits + q_all) + q);
        CountMoments {
            signed_mean: mean.signed,
            total_mean: mean.total,
            signed_variance: self.over_step(step, &before_chips(grid, variance)),
            total_variance: self.total_variance(step),
            covariance: self.over_step(step, &before_chips(grid, covariance)),
        }
    }

    /// Moments of every step of the first scan: of few steps one by one, of many
    /// as [`scan_moments`] has it.
    pub fn of_scan(&self) -> Vec<CountMoments> {
        scan_moments::of_scan(self)
    }

    /// Variance of N of a step.
    pub(super) fn total_variance(&self, step: u64) -> f64 {
        self.over_step(step, &self.total_variance)
    }

    /// Mean sign in every cell of the code period.
    fn signs(&self, phase_step: u64) -> Vec<f64> {
        let response = self.response;
        let chips = &response.model.reference.chips;
        let chip_at = |chip: i64| chips[chip.rem_euclid(chips.len() as i64) as usize];
        // Code chip 0 begins here, in the grid's frame.
        let phase = phase_step as f64 / f64::from(response.model.samples_per_chip);
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
                let level = level_after(two_before, before, rise[1][cell], fall[1][cell])
                    + level_after(before, after, rise[0][cell], fall[0][cell])
                    - f64::from(before);
                signs.push(2.0 * level - 1.0);
            }
        }
        signs
    }

    /// Registered time of the grid's origin, in chips.
    pub(super) fn frame_chips(&self) -> f64 {
        let response = self.response;
        frame_chips(&response.light) + response.delay_chips + response.model.delay_chips
    }

    /// What the chips of a step add up to; `before` has the sums before each chip
    /// of the grid. The window's edges are rounded to whole chips of the grid.
    fn over_step(&self, step: u64, before: &[f64]) -> f64 {
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

/// Mean level over a cell that an edge from `before` to `after` may divide.
fn level_after(before: u8, after: u8, after_rise: f64, after_fall: f64) -> f64 {
    match (before, after) {
        (0, 1) => after_rise,
        (1, 0) => 1.0 - after_fall,
        _ => f64::from(after),
    }
}
