//! The state of the detector through one code period.

use super::cells::{History, SolvedCell};
use super::chain::{Chain, STATES, State};
use super::grid::{Grid, Place};
use super::integrator::Propagators;

/// Probabilities of the ready states, and what they fire.
#[derive(Debug, Clone)]
pub struct ForwardSolution {
    /// Cells of the code period, chip by chip.
    pub cells: Vec<SolvedCell>,
    /// Expected detections in each cell.
    pub hits: Vec<f64>,
}

/// Solves from a ready detector through the memory time and one code period;
/// the code period is kept.
pub fn solve(grid: &Grid, chain: &Chain) -> ForwardSolution {
    let per_chip = grid.cells.len();
    let warm_up = grid.memory_chips as usize;
    let chips = warm_up + grid.period_chips as usize;
    let mut history = History::new(per_chip, grid.reach_chips);
    let mut hits = Vec::with_capacity(grid.period_chips as usize * per_chip);
    let mut known = Propagators::new(per_chip);
    let mut state: State = [0.0; STATES];
    state[0] = 1.0;
    for chip in 0..chips {
        let code_chip = chip as i64 - warm_up as i64;
        if code_chip < 0 {
            history.forget();
        }
        for (index, cell) in grid.cells.iter().enumerate() {
            let lambda = grid.lambda(code_chip, index);
            let inflow = cell
                .before
                .map(|place| ready_again(grid, chain, &history, chip, code_chip, place));
            let mut end = [0.0; STATES];
            let propagators = known.get(chain, index, cell.width, lambda);
            let mut start_slope = [0.0; STATES];
            let mut end_slope = [0.0; STATES];
            for m in 0..STATES {
                let rate = chain.exit_rate(lambda, m);
                let g = [inflow[0][m], inflow[1][m], inflow[2][m]];
                end[m] = propagators[m].advance(state[m], g);
                start_slope[m] = g[0] - rate * state[m];
                end_slope[m] = g[2] - rate * end[m];
            }
            if code_chip >= 0 {
                // Detections are what has left the ready states.
                let came: [f64; 3] = inflow.map(|g| g.iter().sum());
                let came = cell.width / 6.0 * (came[0] + 4.0 * came[1] + came[2]);
                let left = state.iter().sum::<f64>() - end.iter().sum::<f64>();
                hits.push(came + left);
            }
            history.push(SolvedCell {
                start: state,
                end,
                start_slope,
                end_slope,
                width: cell.width,
            });
            state = end;
        }
    }
    ForwardSolution {
        cells: history.into_cells_from(warm_up),
        hits,
    }
}

/// Rate at which detectors come back from their dead times into each state.
fn ready_again(
    grid: &Grid,
    chain: &Chain,
    history: &History,
    chip: usize,
    code_chip: i64,
    place: Place,
) -> State {
    let Ok(past_chip) = usize::try_from(chip as i64 + place.chips) else {
        // The detector starts ready: nothing is dead yet.
        return [0.0; STATES];
    };
    let past = history.get(past_chip, place.cell).at(place.position);
    let lambda = grid.lambda(code_chip + place.chips, place.cell);
    let avalanches = chain.avalanche_rates(lambda, &past);
    std::array::from_fn(|m| {
        (0..STATES)
            .map(|j| avalanches[j] * chain.transition[j][m])
            .sum()
    })
}
