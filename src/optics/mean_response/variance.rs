//! Variance of signed counts, from the value of being in a state.
//!
//! U_m(t) is the expected signed count still to come for a detector that is
//! ready with m afterpulses pending; W_j(t) = sum over m of K\[j\]\[m\] U_m(t + D)
//! the same right after an avalanche. Counts so far plus value so far is a
//! martingale, so the variance is the sum of its squared jumps: at avalanches,
//! and where the dead time's end shows how many afterpulses are pending.

use super::cells::{History, SolvedCell};
use super::chain::{Chain, STATES, State};
use super::forward::ForwardSolution;
use super::grid::{Grid, Place};
use super::integrator::Propagators;

/// Variance that each chip of the common code period adds to the count.
/// `sign` is the reference's sign at a sample of that period.
pub fn per_chip(
    grid: &Grid,
    chain: &Chain,
    forward: &ForwardSolution,
    sign: impl Fn(i64) -> f64,
) -> Vec<f64> {
    let per_chip = grid.cells.len();
    let period = grid.period_chips as usize;
    let chips = period + grid.memory_chips as usize;
    let samples_per_chip = grid.cells[per_chip - 1].sample as i64;
    let mut variance = vec![0.0; period];
    // From the last cell to the first: chip 0 of the history is the last chip.
    let mut history = History::new(per_chip, grid.reach_chips);
    let mut known = Propagators::new(per_chip);
    let mut value: State = [0.0; STATES];
    for chip in (0..chips).rev() {
        history.forget();
        for (index, cell) in grid.cells.iter().enumerate().rev() {
            let lambda = grid.lambda(chip as i64, index);
            let sign = sign(chip as i64 * samples_per_chip + cell.sample as i64);
            let later = cell
                .after
                .map(|place| After::new(chain, value_at(grid, &history, chips, chip, place)));
            let gain = |node: usize, m: usize| {
                let released = m as f64 * chain.release_per_chip;
                let after_release = if m > 0 { later[node].mean[m - 1] } else { 0.0 };
                lambda * (sign + later[node].mean[m]) + released * (sign + after_release)
            };
            let mut start = [0.0; STATES];
            let propagators = known.get(chain, index, cell.width, lambda);
            let mut start_slope = [0.0; STATES];
            let mut end_slope = [0.0; STATES];
            for m in 0..STATES {
                let rate = chain.exit_rate(lambda, m);
                // Time runs backwards here: the cell's end comes first.
                let g = [gain(2, m), gain(1, m), gain(0, m)];
                start[m] = propagators[m].advance(value[m], g);
                end_slope[m] = rate * value[m] - g[0];
                start_slope[m] = rate * start[m] - g[2];
            }
            let solved = SolvedCell {
                start,
                end: value,
                start_slope,
                end_slope,
                width: cell.width,
            };
            if chip < period {
                let probabilities = &forward.cells[chip * per_chip + index];
                let density = [(0.0, 1.0), (0.5, 4.0), (1.0, 1.0)].map(|(x, weight)| {
                    let node = (2.0 * x) as usize;
                    weight
                        * jumps_squared(
                            chain,
                            lambda,
                            sign,
                            &probabilities.at(x),
                            &solved.at(x),
                            &later[node],
                        )
                });
                variance[chip] += cell.width / 6.0 * density.iter().sum::<f64>();
            }
            history.push(solved);
            value = start;
        }
    }
    variance
}

/// Mean and variance of the value one dead time later, by afterpulses pending
/// right after the avalanche.
struct After {
    mean: State,
    variance: State,
}

impl After {
    fn new(chain: &Chain, value: State) -> After {
        let mean: State =
            std::array::from_fn(|j| (0..STATES).map(|m| chain.transition[j][m] * value[m]).sum());
        let variance = std::array::from_fn(|j| {
            (0..STATES)
                .map(|m| chain.transition[j][m] * (value[m] - mean[j]).powi(2))
                .sum()
        });
        After { mean, variance }
    }
}

/// Rate of the martingale's squared jumps.
fn jumps_squared(
    chain: &Chain,
    lambda: f64,
    sign: f64,
    probabilities: &State,
    value: &State,
    later: &After,
) -> f64 {
    let at_avalanches: f64 = (0..STATES)
        .map(|m| {
            let photon = (sign + later.mean[m] - value[m]).powi(2);
            let released = m as f64 * chain.release_per_chip;
            let afterpulse = if m > 0 {
                (sign + later.mean[m - 1] - value[m]).powi(2)
            } else {
                0.0
            };
            probabilities[m] * (lambda * photon + released * afterpulse)
        })
        .sum();
    let avalanches = chain.avalanche_rates(lambda, probabilities);
    let at_ends: f64 = (0..STATES).map(|j| avalanches[j] * later.variance[j]).sum();
    at_avalanches + at_ends
}

/// U at a place later than the cell; zero after the last chip.
fn value_at(grid: &Grid, history: &History, chips: usize, chip: usize, place: Place) -> State {
    let later_chip = chip + place.chips as usize;
    if later_chip >= chips {
        return [0.0; STATES];
    }
    let reversed_cell = grid.cells.len() - 1 - place.cell;
    history
        .get(chips - 1 - later_chip, reversed_cell)
        .at(place.position)
}
