//! Expected counts of the sampled correlator.

use super::chain::Chain;
use super::forward::{self, ForwardSolution};
use super::grid::Grid;
use super::{MeanResponseError, variance};
use crate::optics::DetectorModel;

/// Expected hits of one detector, and what follows for signed counts.
#[derive(Debug, Clone)]
pub struct MeanResponse<'m> {
    model: &'m DetectorModel,
    grid: Grid,
    chain: Chain,
    /// `None` without dead time, where detections are a Poisson process.
    forward: Option<ForwardSolution>,
    /// Expected hits before each sample of the common code period, and in all.
    cumulative_hits: Vec<f64>,
}

impl<'m> MeanResponse<'m> {
    /// Solves the detector's state equation over one code period.
    pub fn new(model: &'m DetectorModel) -> Result<MeanResponse<'m>, MeanResponseError> {
        let grid = Grid::new(model)?;
        let chain = Chain::new(model.afterpulsing, model.dead_time_chips);
        let forward = (model.dead_time_chips > 0.0).then(|| forward::solve(&grid, &chain));
        let hits = match &forward {
            Some(solution) => solution.hits.clone(),
            None => poisson_hits(&grid),
        };
        let cumulative_hits = cumulative(&grid, &hits, u64::from(model.samples_per_chip));
        Ok(MeanResponse {
            model,
            grid,
            chain,
            forward,
            cumulative_hits,
        })
    }

    /// Expected hits at each sample of the common code period of all codes,
    /// S times as many as chips. A detection is a hit at the first sample at or
    /// after its registered time.
    pub fn hits_per_sample(&self) -> Vec<f64> {
        self.cumulative_hits
            .windows(2)
            .map(|edge| edge[1] - edge[0])
            .collect()
    }

    /// Mean detection rate.
    pub fn detection_rate_hz(&self) -> f64 {
        let seconds = self.grid.period_chips as f64 * self.model.chip_period_ps * 1e-12;
        self.hits_until(self.period_samples()) / seconds
    }

    /// Expected signed count of step number `step` of the first scan.
    pub fn expected_count(&self, step: u64) -> f64 {
        let phase_step = self.model.scan.step(step);
        let (periods, first, rest) = self.chips_of(step);
        let whole = if periods > 0 {
            periods as f64 * self.signed_hits(phase_step, 0, self.grid.period_chips)
        } else {
            0.0
        };
        whole + self.signed_hits(phase_step, first, rest)
    }

    /// Variance of the signed count of step number `step`, for steps that last
    /// much longer than the detector's memory.
    pub fn count_variance(&self, step: u64) -> f64 {
        let (periods, first, rest) = self.chips_of(step);
        let Some(forward) = &self.forward else {
            // Poisson: the variance is the mean number of detections.
            let samples_per_chip = u64::from(self.model.samples_per_chip);
            return periods as f64 * self.hits_until(self.period_samples())
                + self.hits_until((first + rest) * samples_per_chip)
                - self.hits_until(first * samples_per_chip);
        };
        let per_chip = variance::per_chip(&self.grid, &self.chain, forward, |sample| {
            self.sign(self.model.scan.step(step), sample)
        });
        let period = self.grid.period_chips;
        let partial = (first..first + rest).map(|chip| per_chip[(chip % period) as usize]);
        periods as f64 * per_chip.iter().sum::<f64>() + partial.sum::<f64>()
    }

    /// Whole periods in a step, its first chip, and the chips left over.
    fn chips_of(&self, step: u64) -> (u64, u64, u64) {
        let period = self.grid.period_chips;
        let chips = self.model.scan.integration_chips;
        let first = self.model.first_chip(0, step) % u128::from(period);
        (chips / period, first as u64, chips % period)
    }

    /// Sign of the reference, delayed by `phase_step` samples, at a sample.
    fn sign(&self, phase_step: u64, sample: i64) -> f64 {
        let chips = &self.model.reference.chips;
        let chip = (sample - phase_step as i64).div_euclid(i64::from(self.model.samples_per_chip));
        f64::from(chips[chip.rem_euclid(chips.len() as i64) as usize]) * 2.0 - 1.0
    }

    /// Expected signed hits in `chips` chips from chip `first` on.
    fn signed_hits(&self, phase_step: u64, first: u64, chips: u64) -> f64 {
        let samples_per_chip = u64::from(self.model.samples_per_chip);
        let mut sample = first * samples_per_chip;
        let end = (first + chips) * samples_per_chip;
        let mut before = self.hits_until(sample);
        let mut sum = 0.0;
        while sample < end {
            // The reference changes where (sample - k) is a multiple of S.
            let into_chip = (sample as i64 - phase_step as i64).rem_euclid(samples_per_chip as i64);
            let next = (sample + samples_per_chip - into_chip as u64).min(end);
            let hits = self.hits_until(next);
            sum += self.sign(phase_step, sample as i64) * (hits - before);
            before = hits;
            sample = next;
        }
        sum
    }

    /// Expected hits at samples 0..sample.
    fn hits_until(&self, sample: u64) -> f64 {
        let period = self.period_samples();
        let all = self.cumulative_hits[period as usize];
        (sample / period) as f64 * all + self.cumulative_hits[(sample % period) as usize]
    }

    fn period_samples(&self) -> u64 {
        self.grid.period_chips * u64::from(self.model.samples_per_chip)
    }
}

/// Hits per cell of a detector without dead time and afterpulses.
fn poisson_hits(grid: &Grid) -> Vec<f64> {
    (0..grid.period_chips as i64)
        .flat_map(|chip| {
            let cells = grid.cells.iter().enumerate();
            cells.map(move |(index, cell)| grid.lambda(chip, index) * cell.width)
        })
        .collect()
}

/// Running sum of hits at samples 0, 1, ..., from the hits of cells.
fn cumulative(grid: &Grid, hits: &[f64], samples_per_chip: u64) -> Vec<f64> {
    let samples = grid.period_chips * samples_per_chip;
    let mut per_sample = vec![0.0; samples as usize];
    for (chip, cells) in hits.chunks(grid.cells.len()).enumerate() {
        for (cell, hits) in grid.cells.iter().zip(cells) {
            let sample = (chip as u64 * samples_per_chip + cell.sample) % samples;
            per_sample[sample as usize] += hits;
        }
    }
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    for hits in per_sample {
        sum += hits;
        sums.push(sum);
    }
    sums
}
