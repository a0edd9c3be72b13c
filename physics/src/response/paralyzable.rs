//! A detector whose dead time each arrival begins anew, without afterpulses.
//!
//! It fires at t if light arrives then and none did within the dead time D before, so that its
//! detection rate is known at once, from the primary rate lambda:
//!
//! m(t) = lambda(t) exp(-integral of lambda over t - D..t).
//!
//! Whether it fires at t' >= t + D has nothing to do with what arrived until t, and within D of a
//! detection there is no other one. So a detection goes with fewer later ones than there would be
//! on average: with those of the dead time after it. Of constant light that is Var N = r T -
//! r^2 D (2 T - D) with r = lambda exp(-lambda D).

use super::forward::{AllAndMerged, Detections};
use super::grid::{Grid, GridInterpolation};
use super::span::Span;

/// Every detection; pulses do not merge.
pub fn solve(grid: &Grid) -> AllAndMerged {
    let arrivals = Detections::poisson(grid);
    let per_chip = grid.cells.len();
    // Arrivals from the period's start to a place that is at most one dead time before it.
    let until = |chip: usize, place: &GridInterpolation| {
        let period = grid.period_chips as i64;
        let at = chip as i64 + place.chips;
        let turns = at.div_euclid(period) as f64;
        let index = at.rem_euclid(period) as usize * per_chip + place.cell;
        let within = at_place(place, &arrivals.cumulative, &arrivals.rates, index);
        (within + turns * arrivals.per_period(), arrivals.rates[index][0])
    };
    let rates = arrivals.rates.iter().enumerate().map(|(index, arriving)| {
        let (chip, cell) = (index / per_chip, &grid.cells[index % per_chip]);
        let lambda = arriving[0];
        let [start, end] = [(0, index), (2, index + 1)].map(|(node, border)| {
            let (before, _) = until(chip, &cell.before[node]);
            lambda * (before - arrivals.cumulative[border]).exp()
        });
        // Neither rate changes within a cell: its edges, and those a dead time later, are borders.
        let (_, leaving) = until(chip, &cell.before[1]);
        let slope = (leaving - lambda) * cell.width;
        [start, end, slope * start, slope * end]
    });
    AllAndMerged { all: Detections::of(grid, rates.collect()), merged: None }
}

/// For every cell in which pairs begin: expected detections there, times what each goes with of
/// later ones, weighted with `signs`, beyond their plain expectation.
pub fn excess(grid: &Grid, detections: &Detections, signs: &[f64], span: &Span) -> Vec<f64> {
    let per_chip = grid.cells.len();
    let chips = span.counted.end;
    let in_period =
        |index: usize| (index + span.first_chip * per_chip) % (grid.period_chips * per_chip);
    // Counts, and their rates, from the first cell in which pairs begin.
    let mut counts = Vec::with_capacity(chips * per_chip + 1);
    let mut rates = Vec::with_capacity(chips * per_chip);
    let mut sum = 0.0;
    counts.push(sum);
    for index in 0..chips * per_chip {
        let of_period = in_period(index);
        let is_counted = index >= span.counted.start * per_chip;
        let sign = if is_counted { signs[of_period] } else { 0.0 };
        sum += sign * (detections.cumulative[of_period + 1] - detections.cumulative[of_period]);
        counts.push(sum);
        rates.push(detections.rates[of_period].map(|rate| sign * rate));
    }
    let until = |chip: usize, place: &GridInterpolation| match chip + place.chips as usize {
        later if later < chips => at_place(place, &counts, &rates, later * per_chip + place.cell),
        _ => sum,
    };
    let cells = (0..span.begun * per_chip).map(|index| {
        let (chip, cell) = (index / per_chip, &grid.cells[index % per_chip]);
        let [start, end] = [counts[index], counts[index + 1]];
        let slopes = [0, 1].map(|of| rates[index][of] * cell.width);
        let until_now = [start, middle([start, end], slopes), end];
        let [first, last, first_slope, last_slope] = detections.rates[in_period(index)];
        let fires = [first, middle([first, last], [first_slope, last_slope]), last];
        let [a, b, c] =
            [0, 1, 2].map(|node| fires[node] * (until_now[node] - until(chip, &cell.after[node])));
        // Simpson's rule.
        cell.width / 6.0 * (a + 4.0 * b + c)
    });
    cells.collect()
}

/// What has come until a place, of what comes before each cell and at which rates; `index` is its
/// cell's.
fn at_place(place: &GridInterpolation, before: &[f64], rates: &[[f64; 4]], index: usize) -> f64 {
    let [start, end, start_slope, end_slope] = place.weights;
    let [first, last, ..] = rates[index];
    before[index] * start + before[index + 1] * end + first * start_slope + last * end_slope
}

/// The cubic of these values and slopes, times the cell's width, in the middle of its cell.
fn middle([start, end]: [f64; 2], [start_slope, end_slope]: [f64; 2]) -> f64 {
    0.5 * (start + end) + (start_slope - end_slope) / 8.0
}
