//! Second moments of the counts, from the value of being in a state.
//!
//! U_m(t) is the expected count still to come, after t, for a detector that is
//! ready with m afterpulses pending, and W the same right after an avalanche;
//! u(t) is its plain expectation. A detection at t thus goes with W - u(t) more
//! counts later than there would be on average, and since every pair of
//! detections has one that comes first,
//!
//! Var r = integral of m + 2 s Q_r, Var N = integral of m + 2 Q_N,
//! Cov(r, N) = integral of s m + s Q_N + Q_r,
//!
//! with m the detection rate, s the sign, and Q the rate of detections times
//! that excess, for counts with the sign (Q_r) and without (Q_N).
//!
//! Where pulses of the sampled level may merge, W is less by what a detector loses
//! that is ready again but must wait for some sample instants until its next pulse
//! counts; and only detections that count begin a pair.

// States are looped over by number: iterators are not always inlined.
#![allow(clippy::needless_range_loop)]

use super::chain::Chain;
use super::forward::{Detections, ReadyStates};
use super::grid::{Grid, Place, Rearming};
use super::history::History;
use super::integrator::{CellStep, CellSteps};
use super::span::Span;

/// Q integrated over each cell in which pairs begin. `signs` has the mean sign of
/// every cell of the code period; `states` are the ready states whose next pulse counts,
/// and `detections` those that count.
///
/// With the widest vectors that the processor has: no operation differs, so
/// results do not.
pub fn excess<const M: usize>(
    grid: &Grid,
    chain: &Chain<M>,
    states: &ReadyStates<M>,
    detections: &Detections,
    signs: &[f64],
    span: &Span,
) -> Vec<f64> {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has the instructions, as just made sure.
        return unsafe { excess_avx2(grid, chain, states, detections, signs, span) };
    }
    solve_backwards(grid, chain, states, detections, signs, span)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn excess_avx2<const M: usize>(
    grid: &Grid,
    chain: &Chain<M>,
    states: &ReadyStates<M>,
    detections: &Detections,
    signs: &[f64],
    span: &Span,
) -> Vec<f64> {
    solve_backwards(grid, chain, states, detections, signs, span)
}

#[inline(always)]
fn solve_backwards<const M: usize>(
    grid: &Grid,
    chain: &Chain<M>,
    states: &ReadyStates<M>,
    detections: &Detections,
    signs: &[f64],
    span: &Span,
) -> Vec<f64> {
    let per_chip = grid.cells.len();
    let period = grid.period_chips;
    let chips = span.counted.end;
    let mut excess = vec![0.0; span.begun * per_chip];
    // From the last cell to the first: chip 0 of the history is the last chip.
    let mut history = History::<M>::new(per_chip, grid.reach_chips);
    let mut steps = CellSteps::new(chain, per_chip);
    let mut lambdas = Vec::new();
    let mut losses = grid.rearming.as_ref().map(Losses::new);
    let mut end = [0.0; M];
    let mut expected_end = 0.0;
    for chip in (0..chips).rev() {
        grid.fill_rates((span.first_chip + chip) as i64, &mut lambdas);
        let first_cell = (span.first_chip + chip) % period * per_chip;
        let is_counted = chip >= span.counted.start;
        for (index, cell) in grid.cells.iter().enumerate().rev() {
            let in_period = first_cell + index;
            let sign = if is_counted { signs[in_period] } else { 0.0 };
            let step = steps.get(index, cell.width, lambdas[index]);
            // Plain loops, here and in what is called: closures are not always
            // inlined, and would be compiled for narrow vectors.
            let mut later = [[0.0; M]; 3];
            let mut gains = [[0.0; M]; 3];
            for node in 0..3 {
                let value = value_at(&history, chips, chip, &cell.after[node]);
                later[node] = step.pass_backwards(&value);
                // Time runs backwards here: the cell's end comes first.
                for m in 0..M {
                    gains[2 - node][m] = sign * step.exit[m] + later[node][m];
                }
            }
            let start = step.advance(&end, &gains);
            let mut end_slope = step.slope(&end, &gains[0]);
            let mut start_slope = step.slope(&start, &gains[2]);
            for m in 0..M {
                end_slope[m] = -end_slope[m];
                start_slope[m] = -start_slope[m];
            }

            let mean = Mean::of(detections, in_period, cell.width, sign, expected_end);
            if chip < span.begun {
                excess[chip * per_chip + index] =
                    excess_of_cell(&states[in_period], &later, &mean, cell.width);
            }
            let mut on_return = [start, end, start_slope, end_slope];
            if let Some(losses) = &mut losses {
                losses.take_off(index, step, sign, &mut on_return);
            }
            history.put(chips - 1 - chip, index, on_return);
            end = start;
            expected_end = mean.to_come[0];
        }
    }
    excess
}

/// What is so on average at the beginning, in the middle and at the end of a cell.
struct Mean {
    /// Rate of detections.
    rate: [f64; 3],
    /// Expected count still to come.
    to_come: [f64; 3],
}

impl Mean {
    /// Of a cell, at whose end `to_come` is expected.
    #[inline(always)]
    fn of(detections: &Detections, cell: usize, width: f64, sign: f64, to_come: f64) -> Mean {
        let rates = &detections.rates[cell];
        let hits = detections.cumulative[cell + 1] - detections.cumulative[cell];
        let first_half = width
            * (13.0 / 32.0 * rates[0] + 3.0 / 32.0 * rates[1] + 11.0 / 192.0 * rates[2]
                - 5.0 / 192.0 * rates[3]);
        Mean {
            rate: [rates[0], 0.5 * (rates[0] + rates[1]) + (rates[2] - rates[3]) / 8.0, rates[1]],
            to_come: [to_come + sign * hits, to_come + sign * (hits - first_half), to_come],
        }
    }
}

/// Q integrated over a cell, by Simpson's rule. `ready` are the states at its nodes, and
/// `later` the counts to come after a detection there.
#[inline(always)]
fn excess_of_cell<const M: usize>(
    ready: &[[f64; M]; 3],
    later: &[[f64; M]; 3],
    mean: &Mean,
    width: f64,
) -> f64 {
    let mut density = [0.0; 3];
    for node in 0..3 {
        for m in 0..M {
            density[node] += ready[node][m] * later[node][m];
        }
        density[node] -= mean.rate[node] * mean.to_come[node];
    }
    width / 6.0 * (density[0] + 4.0 * density[1] + density[2])
}

/// What a ready detector loses of the counts to come by having to wait for sample
/// instants, by their number less one.
struct Losses<'g, const M: usize> {
    rearming: &'g Rearming,
    levels: Vec<[f64; M]>,
}

impl<'g, const M: usize> Losses<'g, M> {
    fn new(rearming: &'g Rearming) -> Losses<'g, M> {
        Losses { levels: vec![[0.0; M]; rearming.most_waits()], rearming }
    }

    /// Goes backwards through cell `index`, and takes the loss of those that become
    /// ready there off the value and its slopes.
    ///
    /// The first detection is lost, with what it would have counted: the loss is
    /// z' = exit (z - sign), from nothing at the instant that ends the wait.
    #[inline(always)]
    fn take_off(&mut self, index: usize, step: &CellStep<M>, sign: f64, value: &mut [[f64; M]; 4]) {
        let mut gain = [0.0; M];
        for m in 0..M {
            gain[m] = sign * step.exit[m];
        }
        let waits = self.rearming.waits[index];
        for (level, end) in self.levels.iter_mut().enumerate() {
            let start = step.advance(end, &[gain; 3]);
            if level + 1 == waits {
                let slopes = [step.slope(&start, &gain), step.slope(end, &gain)];
                for m in 0..M {
                    value[0][m] -= start[m];
                    value[1][m] -= end[m];
                    value[2][m] += slopes[0][m];
                    value[3][m] += slopes[1][m];
                }
            }
            *end = start;
        }
        if self.rearming.at_instant[index] && !self.levels.is_empty() {
            self.levels.rotate_right(1);
            if let Some(first) = self.levels.first_mut() {
                *first = [0.0; M];
            }
        }
    }
}

/// U at a place later than the cell; zero after the last chip.
#[inline(always)]
fn value_at<const M: usize>(
    history: &History<M>,
    chips: usize,
    chip: usize,
    place: &Place,
) -> [f64; M] {
    let later_chip = chip + place.chips as usize;
    if later_chip >= chips {
        return [0.0; M];
    }
    history.read(chips - 1 - later_chip, place)
}

#[cfg(test)]
mod tests {
    /// The first half of the cubic y0 (1 - 3x^2 + 2x^3) + y1 (3x^2 - 2x^3)
    /// + s0 (x - 2x^2 + x^3) + s1 (x^3 - x^2), term by term.
    #[test]
    fn half_a_cubic_has_these_weights() {
        let integral = |c: [f64; 4]| -> f64 {
            (0..4).map(|n| c[n] * 0.5_f64.powi(n as i32 + 1) / (n + 1) as f64).sum()
        };
        assert!((integral([1.0, 0.0, -3.0, 2.0]) - 13.0 / 32.0).abs() < 1e-15);
        assert!((integral([0.0, 0.0, 3.0, -2.0]) - 3.0 / 32.0).abs() < 1e-15);
        assert!((integral([0.0, 1.0, -2.0, 1.0]) - 11.0 / 192.0).abs() < 1e-15);
        assert!((integral([0.0, 0.0, -1.0, 1.0]) + 5.0 / 192.0).abs() < 1e-15);
    }
}
