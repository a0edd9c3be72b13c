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

use rayon::prelude::*;

use super::chain::Chain;
use super::forward::{Detections, ReadyStates};
use super::grid::{Grid, GridInterpolation, Rearming};
use super::history::History;
use super::integrator::{CellStep, CellSteps};
use super::several::{Number, Several};
use super::span::Span;

/// Q integrated over each cell in which pairs begin, for each of several counts whose mean signs
/// `signs` has: one for every cell of the code period. `states` are the ready states whose next
/// pulse counts, and `detections` those that count.
///
/// Counts are solved for side by side, with the widest vectors that the processor has: no
/// operation differs, so results do not.
pub fn excess<const M: usize>(
    problem: &Backwards<M>,
    signs: &[&[f64]],
    span: &Span,
) -> Vec<Vec<f64>> {
    let solve = |signs: &[&[f64]]| match signs {
        [alone] => vec![solve(problem, alone, span)],
        _ => {
            let solved = solve(problem, &Several::interleaved(signs), span);
            (0..signs.len()).map(|place| Several::row(&solved, place)).collect()
        }
    };
    let solved: Vec<_> = signs.par_chunks(Several::COUNT).map(solve).collect();
    solved.into_iter().flatten().collect()
}

/// The equation of the counts to come.
#[derive(Clone, Copy)]
pub struct Backwards<'a, const M: usize> {
    pub grid: &'a Grid,
    pub chain: &'a Chain<M>,
    pub states: &'a ReadyStates<M>,
    pub detections: &'a Detections,
}

fn solve<const M: usize, V: Number>(problem: &Backwards<M>, signs: &[V], span: &Span) -> Vec<V> {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            // SAFETY: the processor has the instructions, as just made sure.
            return unsafe { solve_avx512(problem, signs, span) };
        }
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has the instructions, as just made sure.
            return unsafe { solve_avx2(problem, signs, span) };
        }
    }
    problem.solve(signs, span)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn solve_avx512<const M: usize, V: Number>(
    problem: &Backwards<M>,
    signs: &[V],
    span: &Span,
) -> Vec<V> {
    problem.solve(signs, span)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn solve_avx2<const M: usize, V: Number>(
    problem: &Backwards<M>,
    signs: &[V],
    span: &Span,
) -> Vec<V> {
    problem.solve(signs, span)
}

impl<const M: usize> Backwards<'_, M> {
    #[inline(always)]
    fn solve<V: Number>(&self, signs: &[V], span: &Span) -> Vec<V> {
        let Backwards { grid, chain, states, detections } = *self;
        let nothing = V::default();
        let per_chip = grid.cells.len();
        let period = grid.period_chips;
        let chips = span.counted.end;
        let mut excess = vec![nothing; span.begun * per_chip];
        // From the last cell to the first: chip 0 of the history is the last chip.
        let mut history = History::<M, V>::new(per_chip, grid.reach_chips);
        let mut steps = CellSteps::new(chain, per_chip);
        let mut lambdas = Vec::new();
        let mut losses = grid.rearming.as_ref().map(Losses::new);
        let mut end = [nothing; M];
        let mut expected_end = nothing;
        // What the cell solved last has at its start, and its light: none yet.
        let (mut later_at_start, mut lambda_there) = ([nothing; M], f64::NAN);
        for chip in (0..chips).rev() {
            grid.fill_rates((span.first_chip + chip) as i64, &mut lambdas);
            let first_cell = (span.first_chip + chip) % period * per_chip;
            let is_counted = chip >= span.counted.start;
            for (index, cell) in grid.cells.iter().enumerate().rev() {
                let in_period = first_cell + index;
                let sign = if is_counted { signs[in_period] } else { nothing };
                let step = steps.get(index, cell.width, lambdas[index]);
                // Plain loops, here and in what is called: closures are not always
                // inlined, and would be compiled for narrow vectors.
                let mut later = [[nothing; M]; 3];
                let mut gains = [[nothing; M]; 3];
                // U is continuous, but for what waits for samples.
                let joins = cell.after_joins && lambdas[index] == lambda_there && losses.is_none();
                for node in 0..3 {
                    later[node] = if node == 2 && joins {
                        later_at_start
                    } else {
                        let value = value_at(&history, chips, chip, &cell.after[node]);
                        step.pass_backwards(&value)
                    };
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
                (later_at_start, lambda_there) = (later[0], lambdas[index]);
                end = start;
                expected_end = mean.to_come[0];
            }
        }
        excess
    }
}

/// What is so on average at the beginning, in the middle and at the end of a cell.
struct Mean<V> {
    /// Rate of detections.
    rate: [f64; 3],
    /// Expected count still to come.
    to_come: [V; 3],
}

impl<V: Number> Mean<V> {
    /// Of a cell, at whose end `to_come` is expected.
    #[inline(always)]
    fn of(detections: &Detections, cell: usize, width: f64, sign: V, to_come: V) -> Mean<V> {
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
fn excess_of_cell<const M: usize, V: Number>(
    ready: &[[f64; M]; 3],
    later: &[[V; M]; 3],
    mean: &Mean<V>,
    width: f64,
) -> V {
    let mut density = [V::default(); 3];
    for node in 0..3 {
        for m in 0..M {
            density[node] += later[node][m] * ready[node][m];
        }
        density[node] -= mean.to_come[node] * mean.rate[node];
    }
    (density[0] + density[1] * 4.0 + density[2]) * (width / 6.0)
}

/// What a ready detector loses of the counts to come by having to wait for sample
/// instants, by their number less one.
struct Losses<'g, const M: usize, V> {
    rearming: &'g Rearming,
    levels: Vec<[V; M]>,
}

impl<'g, const M: usize, V: Number> Losses<'g, M, V> {
    fn new(rearming: &'g Rearming) -> Losses<'g, M, V> {
        Losses { levels: vec![[V::default(); M]; rearming.most_waits()], rearming }
    }

    /// Goes backwards through cell `index`, and takes the loss of those that become
    /// ready there off the value and its slopes.
    ///
    /// The first detection is lost, with what it would have counted: the loss is
    /// z' = exit (z - sign), from nothing at the instant that ends the wait.
    #[inline(always)]
    fn take_off(&mut self, index: usize, step: &CellStep<M>, sign: V, value: &mut [[V; M]; 4]) {
        let mut gain = [V::default(); M];
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
                *first = [V::default(); M];
            }
        }
    }
}

/// U at a place later than the cell; zero after the last chip.
#[inline(always)]
fn value_at<const M: usize, V: Number>(
    history: &History<M, V>,
    chips: usize,
    chip: usize,
    place: &GridInterpolation,
) -> [V; M] {
    let later_chip = chip + place.chips as usize;
    if later_chip >= chips {
        return [V::default(); M];
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
