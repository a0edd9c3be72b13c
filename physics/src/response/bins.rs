//! Expected histograms of arrival times, and how their bins go together.
//!
//! Bin a counts what the sampled hardware counts at sample a of the reference's code
//! period. A bin is a correlator whose weight is 1 in one sample, so means and second
//! moments are those of counts, with other weights than signs.

use super::expected::MeanResponse;
use super::moments::{SecondMoments, rows};

impl MeanResponse<'_> {
    /// Bins of a histogram: samples of the reference's code period.
    fn bins(&self) -> usize {
        let samples = self.model.timing.clock.samples_per_chip as usize;
        self.model.reference.chips.len() * samples
    }

    /// Expected counts of every bin over the integration time's whole code periods, of the
    /// first histogram: S L' of them. Light whose code is longer than the reference's is as
    /// it was in those periods.
    pub fn mean_bins(&self) -> Vec<f64> {
        let periods = self.model.timing.scan.integration_chips / self.model.reference.len();
        let hits = self.hits_per_sample();
        let turns = hits.len() / self.bins();
        let mut means = vec![0.0; self.bins()];
        for (turn, hits) in hits.chunks_exact(self.bins()).enumerate() {
            // Period p of the histogram is turn p of the common period, modulo turns.
            let times = periods.saturating_sub(turn as u64).div_ceil(turns as u64) as f64;
            let add = |(mean, hits): (&mut f64, &f64)| *mean += times * hits;
            means.iter_mut().zip(hits).for_each(add);
        }
        means
    }
}

/// What of a cell lies in one bin.
struct Part {
    /// Bins from the first bin of the chip that the cell is in.
    bin: i64,
    /// Share of the cell, of what samples see.
    share: f64,
}

impl SecondMoments<'_, '_> {
    /// Covariances of weighted sums of a histogram's bins over the integration time, one
    /// weight per bin for each sum. The covariance of two bins is that of two sums of one
    /// bin each; every sum takes a solution of its own.
    ///
    /// # Panics
    /// If a sum has not one weight per bin.
    pub fn covariance_of_bin_sums(&self, sums: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let bins = self.response.bins();
        assert!(sums.iter().all(|sum| sum.len() == bins), "one weight per bin");
        let parts = self.parts();
        let samples = self.response.model.timing.clock.samples_per_chip as i64;
        let weight = |sum: &[f64], chip: usize, part: &Part| {
            sum[(chip as i64 * samples + part.bin).rem_euclid(bins as i64) as usize]
        };
        let cells = parts.len();
        let of_cells = |of_cell: &dyn Fn(usize, &Part) -> f64| -> Vec<f64> {
            (0..self.solved.pairs.hits.len())
                .map(|cell| {
                    let parts = &parts[cell % cells];
                    parts.iter().map(|part| of_cell(cell / cells, part)).sum()
                })
                .collect()
        };
        let means: Vec<Vec<f64>> = sums
            .iter()
            .map(|sum| of_cells(&|chip, part| part.share * weight(sum, chip, part)))
            .collect();
        let excess = self.solved.pairs.excess(&rows(&means));
        let integration = self.response.model.timing.scan.integration_chips as f64;
        let periods = integration / self.solved.pairs.grid.period_chips as f64;
        let covariance = |i: usize, j: usize| -> f64 {
            let own = of_cells(&|chip, part| {
                part.share * weight(&sums[i], chip, part) * weight(&sums[j], chip, part)
            });
            let cells = own.iter().zip(&self.solved.pairs.hits).enumerate();
            let of_period: f64 = cells
                .map(|(cell, (own, hits))| {
                    hits * own + means[i][cell] * excess[j][cell] + means[j][cell] * excess[i][cell]
                })
                .sum();
            periods * of_period
        };
        (0..sums.len()).map(|i| (0..sums.len()).map(|j| covariance(i, j)).collect()).collect()
    }

    /// How the cells of a chip are divided among bins.
    fn parts(&self) -> Vec<Vec<Part>> {
        let samples = f64::from(self.response.model.timing.clock.samples_per_chip);
        let sampling = self.response.sampling.as_ref();
        let place = |time: f64| sampling.map_or(time * samples, |sampling| sampling.place(time));
        let instant = |sample: i64| match sampling {
            None => sample as f64 / samples,
            Some(sampling) => sampling.instant_chips(sample),
        };
        let origin = self.frame_chips();
        let of_cell = |cell: &[f64]| {
            let [from, to] = [cell[0] + origin, cell[1] + origin];
            // Sample s takes what is registered after sample s - 1, up to its own instant.
            let first = place(from).floor() as i64 + 1;
            let last = place(to).ceil() as i64;
            (first..=last)
                .map(|bin| {
                    let start = instant(bin - 1).max(from);
                    let end = instant(bin).min(to);
                    let seen = match sampling {
                        None => end - start,
                        Some(sampling) => sampling.seen_between(start, end),
                    };
                    Part { bin, share: seen / (to - from) }
                })
                .collect()
        };
        self.solved.pairs.grid.edges.windows(2).map(of_cell).collect()
    }
}
