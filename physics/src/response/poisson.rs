//! A detector without dead time and afterpulses: every primary event is a detection,
//! but pulses of the sampled level may merge.
//!
//! What it remembers is only how many sample instants it has to wait for until a pulse
//! counts: B_n(t) is the probability of n. A pulse that a sample sees makes n what the
//! place between two instants says, whatever it was. With z_n what having to wait loses
//! of the counts to come, a counted detection goes with sum over n of B_n z_n, less z
//! of its own n, more later ones than there would be on average.

use super::forward::{AllAndMerged, Detections};
use super::grid::{Grid, Rearming};
use super::span::Span;

/// B_n at the start of every cell of the code period.
#[derive(Debug, Clone, Default)]
pub struct Waiting {
    levels: Vec<Vec<f64>>,
}

/// Every detection, and those that merge.
pub fn solve(grid: &Grid) -> (AllAndMerged, Waiting) {
    let all = Detections::poisson(grid);
    let Some(rearming) = &grid.rearming else {
        return (AllAndMerged { all, merged: None }, Waiting::default());
    };
    let mut levels = vec![0.0; rearming.most_waits()];
    let warm_up = forgets_within_chips(rearming) as i64;
    let mut waiting = Waiting::default();
    let mut merged = Vec::with_capacity(all.rates.len());
    let mut lambdas = Vec::new();
    for chip in -warm_up..grid.period_chips as i64 {
        grid.fill_rates(chip, &mut lambdas);
        for (index, cell) in grid.cells.iter().enumerate() {
            // A detector may merge pulses and be ready again at once: then nothing waits.
            if rearming.at_instant[index] && !levels.is_empty() {
                levels.rotate_left(1);
                if let Some(last) = levels.last_mut() {
                    *last = 0.0;
                }
            }
            let lambda = lambdas[index];
            let rate = rate_of_seen(rearming, index, lambda);
            let start: f64 = levels.iter().sum();
            if chip >= 0 {
                waiting.levels.push(levels.clone());
            }
            pass(&mut levels, rearming.waits[index], (-rate * cell.width).exp());
            if chip >= 0 {
                let end: f64 = levels.iter().sum();
                let slope = |waiting: f64| lambda * rate * (1.0 - waiting) * cell.width;
                merged.push([lambda * start, lambda * end, slope(start), slope(end)]);
            }
        }
    }
    let merged = Some(Detections::of(grid, merged));
    (AllAndMerged { all, merged }, waiting)
}

impl Waiting {
    /// For every cell: expected counted detections there, times what each goes with of
    /// later ones, weighted with `signs`, beyond their plain expectation.
    pub fn excess(&self, grid: &Grid, signs: &[f64], span: &Span) -> Vec<f64> {
        let per_chip = grid.cells.len();
        let mut excess = vec![0.0; span.begun * per_chip];
        let Some(rearming) = &grid.rearming else {
            return excess;
        };
        let mut losses = vec![0.0; rearming.most_waits()];
        let mut lambdas = Vec::new();
        for chip in (0..span.begun + forgets_within_chips(rearming)).rev() {
            let place = (span.first_chip + chip) % grid.period_chips;
            grid.fill_rates(place as i64, &mut lambdas);
            for (index, cell) in grid.cells.iter().enumerate().rev() {
                let in_period = place * per_chip + index;
                let rate = rate_of_seen(rearming, index, lambdas[index]);
                let is_counted = chip >= span.counted.start;
                let cell = Cell {
                    sign: if is_counted { signs[in_period] } else { 0.0 },
                    rate,
                    width: cell.width,
                    waits: rearming.waits[index],
                };
                if chip < span.begun && rate > 0.0 {
                    let start = &self.levels[in_period];
                    let [a, b, c] = [0.0, 0.5, 1.0].map(|x| cell.density(start, &losses, x));
                    excess[chip * per_chip + index] = cell.width / 6.0 * (a + 4.0 * b + c);
                }
                for loss in &mut losses {
                    *loss = cell.loss(*loss, 0.0);
                }
                if rearming.at_instant[index] && !losses.is_empty() {
                    losses.rotate_right(1);
                    if let Some(first) = losses.first_mut() {
                        *first = 0.0;
                    }
                }
            }
        }
        excess
    }
}

/// One cell on the way back.
struct Cell {
    sign: f64,
    rate: f64,
    width: f64,
    waits: usize,
}

impl Cell {
    /// z at a position 0..1, from that at the cell's end.
    fn loss(&self, end: f64, position: f64) -> f64 {
        let stays = (-self.rate * self.width * (1.0 - position)).exp();
        self.sign + (end - self.sign) * stays
    }

    /// Rate of counted detections at a position, times the excess that each goes with.
    fn density(&self, start: &[f64], losses_at_end: &[f64], position: f64) -> f64 {
        let mut levels = start.to_vec();
        let stays = (-self.rate * self.width * position).exp();
        pass(&mut levels, self.waits, stays);
        let armed = 1.0 - levels.iter().sum::<f64>();
        let loss = |level: usize| self.loss(losses_at_end[level], position);
        let plain: f64 = levels.iter().enumerate().map(|(n, b)| b * loss(n)).sum();
        self.rate * armed * (plain - loss(self.waits - 1))
    }
}

/// Moves to the level of `waits` all but the share that sees no detection.
fn pass(levels: &mut [f64], waits: usize, stays: f64) {
    for level in &mut *levels {
        *level *= stays;
    }
    if let Some(level) = waits.checked_sub(1).and_then(|n| levels.get_mut(n)) {
        *level += 1.0 - stays;
    }
}

/// Rate of pulses that a sample sees. Without dead time the level after such a one is
/// high at the next instant, so that a wait of one instant is that of a pulse between
/// two samples, which changes nothing.
fn rate_of_seen(rearming: &Rearming, cell: usize, lambda: f64) -> f64 {
    if rearming.waits[cell] > 1 { lambda } else { 0.0 }
}

/// No wait is longer: a sample is at most a chip.
fn forgets_within_chips(rearming: &Rearming) -> usize {
    rearming.most_waits() + 2
}
