//! Expected detections registered before one instant of every chip.
//!
//! M(t), the expected avalanches before t, is piecewise a quartic: known by the
//! cumulative at the cell's start and the cell's [`rates`](Detections::rates).
//! Jitter smooths it with a Gaussian, and with its tail where it has one. Since cells are the same in every chip,
//! the smoothed value at one place in the chip is the same few weights for every
//! chip; they are worked out once.

use std::ops::Range;

use super::forward::{Detections, integrated_basis};
use super::grid::Grid;
use crate::math::exponential_normal_density;
use crate::photons::tail::{MOST_TIME_CONSTANTS, Tail};

/// The Gaussian is cut here (probability 2e-9), and scaled to make up for it.
const CUT_SIGMAS: f64 = 6.0;

/// Nodes and weights of Gauss-Legendre quadrature on -1..1, positive half.
const LEGENDRE: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// The delay of registered times that is not constant.
#[derive(Debug, Clone, Copy)]
pub struct Jitter<'a> {
    /// Standard deviation of the Gaussian part.
    pub sigma_chips: f64,
    /// What comes on top.
    pub tail: Option<&'a Tail>,
}

impl Jitter<'_> {
    /// No such delay.
    pub const NONE: Jitter<'static> = Jitter { sigma_chips: 0.0, tail: None };
}

/// One instant of every chip.
#[derive(Debug, Clone)]
pub struct ChipColumn {
    terms: Vec<Term>,
}

/// What one cell contributes.
#[derive(Debug, Clone)]
struct Term {
    chips: i64,
    cell: usize,
    /// Weight of the cumulative at the cell's start.
    cumulative: f64,
    /// Weights of the cell's rates.
    rates: [f64; 4],
}

impl ChipColumn {
    /// The instant `time_chips` (in the grid's frame) after a chip's start, seen
    /// through jitter, on average over the transition time.
    pub fn new(grid: &Grid, time_chips: f64, jitter: Jitter, transition_chips: f64) -> ChipColumn {
        let mut column = ChipColumn { terms: Vec::new() };
        if transition_chips > 0.0 {
            for side in [-transition_chips, transition_chips] {
                column.add_jittered(grid, time_chips + side, jitter, 0.5);
            }
        } else {
            column.add_jittered(grid, time_chips, jitter, 1.0);
        }
        column
    }

    /// Adds M before `centre`, as jitter lets one see it. What a delay leaves behind the
    /// instant was an avalanche that much earlier.
    fn add_jittered(&mut self, grid: &Grid, centre: f64, jitter: Jitter, weight: f64) {
        let sigma = jitter.sigma_chips;
        match jitter.tail {
            None => self.add_smoothed(grid, centre, sigma, weight),
            Some(Tail::Exponential { share, time_constant_chips }) => {
                self.add_smoothed(grid, centre, sigma, weight * (1.0 - share));
                self.add_tail(grid, centre, sigma, *time_constant_chips, weight * share);
            }
            Some(Tail::Delays(delays)) => {
                for [delay, share] in delays {
                    self.add_smoothed(grid, centre - delay, sigma, weight * share);
                }
            }
        }
    }

    /// The same where the delay is a Gaussian and an exponential number together.
    fn add_tail(&mut self, grid: &Grid, centre: f64, sigma: f64, constant: f64, weight: f64) {
        let begin = centre - MOST_TIME_CONSTANTS * constant - CUT_SIGMAS * sigma;
        // Near the instant the density changes as the Gaussian does.
        let near = centre - (CUT_SIGMAS + 2.0) * sigma;
        let longest = |from: f64| match from < near {
            true => constant.min(near - from),
            false => constant.max(sigma).min(if sigma > 0.0 { 2.0 * sigma } else { constant }),
        };
        let density = |time: f64| exponential_normal_density(centre - time, constant, sigma);
        self.add_averaged(grid, begin..centre + CUT_SIGMAS * sigma, longest, density, weight);
    }

    fn add_smoothed(&mut self, grid: &Grid, centre: f64, sigma: f64, weight: f64) {
        if sigma <= 0.0 {
            let (chips, cell, position) = grid.locate(centre);
            self.add(grid, chips, cell, position, weight);
            return;
        }
        let reach = CUT_SIGMAS * sigma;
        let density = |time: f64| (-0.5 * ((time - centre) / sigma).powi(2)).exp();
        self.add_averaged(grid, centre - reach..centre + reach, |_| 2.0 * sigma, density, weight);
    }

    /// Adds `weight` times the mean of M with a density over a range of times, which need
    /// not be scaled: by Gauss and Legendre's rule on parts that end where cells do, and
    /// are no longer than `longest` of their start.
    fn add_averaged(
        &mut self,
        grid: &Grid,
        range: Range<f64>,
        longest: impl Fn(f64) -> f64,
        density: impl Fn(f64) -> f64,
        weight: f64,
    ) {
        let mut nodes = Vec::new();
        let mut total = 0.0;
        let mut from = range.start;
        // Cells are counted, not looked up: far from the origin a cell's end is no nearer to
        // its place than the last digit of a time.
        let (mut chip, mut cell, _) = grid.locate(from);
        while from < range.end {
            let cell_end = chip as f64 + grid.edges[cell + 1];
            let part_end = from + longest(from);
            let ends_inside = part_end > from && part_end < cell_end;
            let to = if ends_inside { part_end } else { cell_end }.min(range.end);
            let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
            for (node, node_weight) in LEGENDRE {
                for side in [-node, node] {
                    let time = middle + half * side;
                    let share = half * node_weight * density(time);
                    nodes.push((chip, cell, time, share));
                    total += share;
                }
            }
            if !ends_inside {
                cell += 1;
                if cell == grid.cells.len() {
                    (chip, cell) = (chip + 1, 0);
                }
            }
            from = to;
        }
        for (chip, cell, time, share) in nodes {
            let inside = time - chip as f64 - grid.edges[cell];
            let position = inside / grid.cells[cell].width;
            self.add(grid, chip, cell, position, weight * share / total);
        }
    }

    /// Adds `weight` times M at a position 0..1 inside a cell.
    fn add(&mut self, grid: &Grid, chips: i64, cell: usize, position: f64, weight: f64) {
        let known = self.terms.iter().position(|term| (term.chips, term.cell) == (chips, cell));
        let index = known.unwrap_or_else(|| {
            self.terms.push(Term { chips, cell, cumulative: 0.0, rates: [0.0; 4] });
            self.terms.len() - 1
        });
        let term = &mut self.terms[index];
        term.cumulative += weight;
        let basis = integrated_basis(position);
        let width = grid.cells[cell].width;
        for (sum, basis) in term.rates.iter_mut().zip(basis) {
            *sum += weight * width * basis;
        }
    }

    /// The expected detections registered before this instant of chips
    /// 0..=period, from some common origin on.
    pub fn cumulative(&self, grid: &Grid, detections: &Detections) -> Vec<f64> {
        let period = grid.period_chips as i64;
        let per_chip = grid.cells.len();
        let mut sums = vec![0.0; grid.period_chips + 1];
        for term in &self.terms {
            let [a, b, c, d] = term.rates;
            let turns = term.chips.div_euclid(period);
            let mut turned = turns as f64 * detections.per_period() * term.cumulative;
            let mut chip = term.chips.rem_euclid(period) as usize;
            for sum in &mut sums {
                let index = chip * per_chip + term.cell;
                let rate = &detections.rates[index];
                *sum += turned
                    + term.cumulative * detections.cumulative[index]
                    + (a * rate[0] + b * rate[1])
                    + (c * rate[2] + d * rate[3]);
                chip += 1;
                if chip == grid.period_chips {
                    chip = 0;
                    turned += detections.per_period() * term.cumulative;
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::grid::{Kinks, SampleInstants};
    use super::super::light::Light;
    use super::*;
    use crate::photons::DetectorModel;
    use crate::scene::{DetectorIndex, load};
    use crate::sensor::Sensor;

    /// An instant many kilometres of light away is one near by, so many chips later: a
    /// double's last digit there is more than any tolerance of a cell's ends.
    #[test]
    fn far_instants_have_the_terms_of_near_ones() {
        let scene = load(Path::new("../scenes/quick.toml")).expect("it is sound");
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let samples = SampleInstants { origin_chips: 0.0, sampling: None };
        let grid = Grid::new(&model, &Light::of(&model), Kinks::Later, &samples).expect("a grid");
        let exponential = Tail::Exponential { share: 0.3, time_constant_chips: 0.7 };
        for (sigma_chips, tail) in [(0.3, None), (1e-3, None), (0.05, Some(&exponential))] {
            let of = |time: f64| ChipColumn::new(&grid, time, Jitter { sigma_chips, tail }, 0.0);
            let near = of(0.4375);
            for far in [-300_000, 1 << 33, -(1 << 42)] {
                let column = of(far as f64 + 0.4375);
                let all = column.terms.iter();
                assert!((all.map(|t| t.cumulative).sum::<f64>() - 1.0).abs() < 1e-9);
                let tolerance = 1e-9 + 10.0 * (far as f64).abs() * f64::EPSILON / sigma_chips;
                for term in &near.terms {
                    let place = |t: &&Term| (t.chips - far, t.cell) == (term.chips, term.cell);
                    let found = column.terms.iter().find(place).map_or(0.0, |t| t.cumulative);
                    assert!((found - term.cumulative).abs() < tolerance, "{far}: {term:?} {found}");
                }
            }
        }
    }
}
