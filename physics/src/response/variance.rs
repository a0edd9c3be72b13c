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

use std::ops::Range;

use rayon::prelude::*;

use super::chain::Chain;
use super::forward::{Detections, ReadyStates};
use super::grid::{Grid, GridInterpolation, Rearming};
use super::history::History;
use super::integrator::{CellStep, CellSteps};
use super::several::{Number, Several};
use super::span::Span;
use super::steady::{self, Round, Rounds};

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
        [alone] => vec![problem.solve(alone, span)],
        _ => {
            let solved = problem.solve(&Several::interleaved(signs), span);
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
    /// How what comes long after is solved for; waited for if none.
    pub round: Option<Round>,
}

impl<const M: usize> Backwards<'_, M> {
    fn solve<V: Number>(&self, signs: &[V], span: &Span) -> Vec<V> {
        let (first, period) = (span.first_chip, self.grid.period_chips);
        let [counted, begun] = [span.counted.start, span.begun].map(|chip| first + chip);
        let mut to_come = ToCome::new(self, signs);
        match self.round {
            Some(round) => {
                to_come.round_chips = round.chips;
                steady::settle(&mut to_come, round.most);
                to_come.go_back(begun..begun.next_multiple_of(period), true, None);
            }
            None => to_come.go_back(begun..first + span.counted.end, true, None),
        }
        let mut excess = vec![V::default(); span.begun * self.grid.cells.len()];
        let (before, within) = excess.split_at_mut(span.counted.start * self.grid.cells.len());
        to_come.go_back(counted..begun, true, Some(within));
        to_come.go_back(first..counted, false, Some(before));
        excess
    }
}

/// The counts to come after some chip, of a detector in any state: from the last one back.
struct ToCome<'a, const M: usize, V> {
    problem: &'a Backwards<'a, M>,
    signs: &'a [V],
    steps: CellSteps<'a, M>,
    /// Chip 0 is the last chip.
    history: History<M, V>,
    losses: Option<Losses<'a, M, V>>,
    /// U where the cell that is to come next ends.
    end: [V; M],
    /// u there.
    expected_end: V,
    /// What the cell solved last has at its start, and its light: none yet.
    later_at_start: [V; M],
    lambda_there: f64,
    /// Chips solved.
    chips: usize,
    /// Chips of a round.
    round_chips: usize,
    lambdas: Vec<f64>,
}

impl<'a, const M: usize, V: Number> ToCome<'a, M, V> {
    fn new(problem: &'a Backwards<'a, M>, signs: &'a [V]) -> ToCome<'a, M, V> {
        let grid = problem.grid;
        ToCome {
            problem,
            signs,
            steps: CellSteps::new(problem.chain, grid.cells.len()),
            history: History::new(grid.cells.len(), grid.reach_chips),
            losses: grid.rearming.as_ref().map(Losses::new),
            end: [V::default(); M],
            expected_end: V::default(),
            later_at_start: [V::default(); M],
            lambda_there: f64::NAN,
            chips: 0,
            round_chips: 0,
            lambdas: Vec::new(),
        }
    }

    /// Goes back through chips of the light, of which `excess` receives Q.
    fn go_back(&mut self, chips: Range<usize>, is_counted: bool, excess: Option<&mut [V]>) {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f") {
                // SAFETY: the processor has the instructions, as just made sure.
                return unsafe { self.go_back_avx512(chips, is_counted, excess) };
            }
            if is_x86_feature_detected!("avx2") {
                // SAFETY: the processor has the instructions, as just made sure.
                return unsafe { self.go_back_avx2(chips, is_counted, excess) };
            }
        }
        self.go_back_plainly(chips, is_counted, excess);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f")]
    fn go_back_avx512(&mut self, chips: Range<usize>, is_counted: bool, excess: Option<&mut [V]>) {
        self.go_back_plainly(chips, is_counted, excess);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn go_back_avx2(&mut self, chips: Range<usize>, is_counted: bool, excess: Option<&mut [V]>) {
        self.go_back_plainly(chips, is_counted, excess);
    }

    #[inline(always)]
    fn go_back_plainly(
        &mut self,
        chips: Range<usize>,
        is_counted: bool,
        mut excess: Option<&mut [V]>,
    ) {
        let Backwards { grid, states, detections, .. } = *self.problem;
        let nothing = V::default();
        let per_chip = grid.cells.len();
        let first = chips.start;
        for chip in chips.rev() {
            grid.fill_rates(chip as i64, &mut self.lambdas);
            let first_cell = chip % grid.period_chips * per_chip;
            for (index, cell) in grid.cells.iter().enumerate().rev() {
                let in_period = first_cell + index;
                let sign = if is_counted { self.signs[in_period] } else { nothing };
                let lambda = self.lambdas[index];
                let step = self.steps.get(index, cell.width, lambda);
                // Plain loops, here and in what is called: closures are not always
                // inlined, and would be compiled for narrow vectors.
                let mut later = [[nothing; M]; 3];
                let mut gains = [[nothing; M]; 3];
                // U is continuous, but for what waits for samples.
                let joins =
                    cell.after_joins && lambda == self.lambda_there && self.losses.is_none();
                for node in 0..3 {
                    later[node] = if node == 2 && joins {
                        self.later_at_start
                    } else {
                        let value = value_at(&self.history, self.chips, &cell.after[node]);
                        step.pass_backwards(&value)
                    };
                    // Time runs backwards here: the cell's end comes first.
                    for m in 0..M {
                        gains[2 - node][m] = sign * step.exit[m] + later[node][m];
                    }
                }
                let (start, end) = (step.advance(&self.end, &gains), self.end);
                let mut end_slope = step.slope(&end, &gains[0]);
                let mut start_slope = step.slope(&start, &gains[2]);
                for m in 0..M {
                    end_slope[m] = -end_slope[m];
                    start_slope[m] = -start_slope[m];
                }

                let mean = Mean::of(detections, in_period, cell.width, sign, self.expected_end);
                if let Some(excess) = excess.as_deref_mut() {
                    excess[(chip - first) * per_chip + index] =
                        excess_of_cell(&states[in_period], &later, &mean, cell.width);
                }
                let mut on_return = [start, end, start_slope, end_slope];
                if let Some(losses) = &mut self.losses {
                    losses.take_off(index, step, sign, &mut on_return);
                }
                self.history.put(self.chips, index, on_return);
                (self.later_at_start, self.lambda_there) = (later[0], lambda);
                self.end = start;
                self.expected_end = mean.to_come[0];
            }
            self.chips += 1;
        }
    }

    /// The last chips solved, of which a dead time reads.
    fn reached(&self) -> Range<usize> {
        self.chips - self.problem.grid.reach_chips - 1..self.chips
    }
}

/// Its state is what the next dead time reads of the last one, and what waits; counts to come are
/// told by how many more there are than on average.
impl<const M: usize, V: Number> Rounds for ToCome<'_, M, V> {
    fn go_round(&mut self) {
        self.go_back(0..self.round_chips, true, None);
    }

    fn states(&self) -> Vec<Vec<f64>> {
        let cells = || self.reached().flat_map(|chip| self.history.of_chip(chip));
        let border = |border: usize| cells().flat_map(move |borders| borders[border]);
        let values = border(0).chain(border(1)).chain(self.end);
        let values = values.map(|value| value - self.expected_end);
        let lost = self.losses.iter().flat_map(|losses| &losses.levels).flatten().copied();
        V::columns(values.chain(border(2)).chain(border(3)).chain(lost))
    }

    /// Cells' starts.
    fn telling(&self) -> usize {
        self.reached().len() * self.problem.grid.cells.len() * M
    }

    /// All but slopes and losses: a count more that is to come is so whatever the detector does.
    fn drifting(&self) -> usize {
        2 * self.telling() + M
    }

    fn set(&mut self, states: &[Vec<f64>]) {
        let mut state = V::rows(states);
        let mut next = || state.next().unwrap_or_default();
        for border in 0..4 {
            for chip in self.reached() {
                for borders in self.history.of_chip_mut(chip) {
                    borders[border].fill_with(&mut next);
                }
            }
            if border == 1 {
                self.end.fill_with(&mut next);
            }
        }
        for level in self.losses.iter_mut().flat_map(|losses| &mut losses.levels) {
            level.fill_with(&mut next);
        }
        self.expected_end = V::default();
        self.lambda_there = f64::NAN;
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

/// U at a place later than a cell of the chip before which `chips` have been solved; zero after the last chip.
#[inline(always)]
fn value_at<const M: usize, V: Number>(
    history: &History<M, V>,
    chips: usize,
    place: &GridInterpolation,
) -> [V; M] {
    match chips.checked_sub(place.chips as usize) {
        Some(chip) => history.read(chip, place),
        None => [V::default(); M],
    }
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
