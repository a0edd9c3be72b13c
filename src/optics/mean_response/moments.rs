//! Means, variances and covariance of the counts, step by step.

use std::thread;

use super::chain::{Chain, states_needed};
use super::expected::MeanResponse;
use super::forward::{self, Detections, ReadyStates};
use super::grid::{Grid, frame_chips};
use super::{variance, with_states};

/// Moments of the signed count r and the total count N of one phase step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CountMoments {
    /// Mean of r.
    pub signed_mean: f64,
    /// Mean of N.
    pub total_mean: f64,
    /// Variance of r.
    pub signed_variance: f64,
    /// Variance of N.
    pub total_variance: f64,
    /// Covariance of r and N.
    pub covariance: f64,
}

/// Second moments of the counts around a mean response, for steps that last much
/// longer than the detector's memory. Signs are taken without jitter.
pub struct SecondMoments<'r, 'm> {
    response: &'r MeanResponse<'m>,
    pairs: Box<dyn Pairs>,
    /// Excess of all detections over each cell.
    excess: Vec<f64>,
    hits: Vec<f64>,
    /// Variance of N that the chips before each chip add.
    total_variance: Vec<f64>,
}

/// Second moments of one phase step, before each chip of a code period.
struct PhaseSums {
    variance: Vec<f64>,
    covariance: Vec<f64>,
}

/// The detector's states, whatever their number.
trait Pairs: Send + Sync {
    fn excess(&self, grid: &Grid, detections: &Detections, signs: &[f64]) -> Vec<f64>;
}

struct Solved<const M: usize> {
    chain: Chain<M>,
    states: ReadyStates<M>,
}

/// Detections without memory: no pair knows of each other.
struct Poisson;

/// Steps between those worked out in full are this far apart round a path's
/// delay, in chips, ...
const KNOT_SPACING_CHIPS: f64 = 0.5;
/// ... out to this distance; ...
const KNOT_REACH_CHIPS: f64 = 4.0;
/// ... and this many are spread over the rest of the scan.
const FAR_KNOTS: u64 = 4;

impl<'r, 'm> SecondMoments<'r, 'm> {
    /// Solves for the states of the detector, and for the total count.
    pub fn new(response: &'r MeanResponse<'m>) -> SecondMoments<'r, 'm> {
        let (model, grid) = (response.model, &*response.grid);
        let pairs: Box<dyn Pairs> = if model.dead_time_chips > 0.0 {
            let needed = states_needed(model.afterpulsing, model.dead_time_chips);
            with_states!(needed, M => {
                let chain = Chain::<M>::new(model.afterpulsing, model.dead_time_chips);
                let mut states = ReadyStates::<M>::new();
                forward::solve(grid, &chain, Some(&mut states));
                Box::new(Solved { chain, states })
            })
        } else {
            Box::new(Poisson)
        };
        let cumulative = &response.detections.cumulative;
        let hits: Vec<f64> = cumulative.windows(2).map(|c| c[1] - c[0]).collect();
        let excess = pairs.excess(grid, &response.detections, &vec![1.0; hits.len()]);
        let per_cell = hits.iter().zip(&excess).map(|(hits, q)| hits + 2.0 * q);
        let total_variance = before_chips(grid, per_cell);
        SecondMoments {
            response,
            pairs,
            excess,
            hits,
            total_variance,
        }
    }

    /// Moments of step number `step` of the first scan.
    pub fn of_step(&self, step: u64) -> CountMoments {
        let sums = self.phase_sums(self.response.model.scan.step(step));
        let mean = self.response.mean_count(step);
        CountMoments {
            signed_mean: mean.signed,
            total_mean: mean.total,
            signed_variance: self.over_step(step, &sums.variance),
            total_variance: self.over_step(step, &self.total_variance),
            covariance: self.over_step(step, &sums.covariance),
        }
    }

    /// Moments of every step of the first scan.
    ///
    /// Means are exact. Second moments per detection vary slowly with the phase
    /// step, save near a path's delay: there they are worked out every half chip,
    /// elsewhere at a few steps, and interpolated. Of the covariance, what is not
    /// proportional to r itself is interpolated. Between far steps what is left
    /// out is the chance correlation of the shifted code with the light, some
    /// per mille of the variance for codes of a thousand chips.
    pub fn of_scan(&self) -> Vec<CountMoments> {
        let scan = &self.response.model.scan;
        let knots = self.knots();
        let solved = self.solve_knots(&knots);
        let per_period = self.response.correlator.hits_per_period();
        let fano = self.total_variance[self.total_variance.len() - 1] / per_period;
        let means = self.response.mean_counts();
        let mut next = 0;
        (0..scan.steps)
            .zip(means)
            .map(|(step, mean)| {
                while next < knots.len() && knots[next] <= step {
                    next += 1;
                }
                let (early, late) = (next.saturating_sub(1), next.min(knots.len() - 1));
                let gap = knots[late] - knots[early];
                let share = match gap {
                    0 => 0.0,
                    _ => (step - knots[early]) as f64 / gap as f64,
                };
                let between = |values: [f64; 2]| values[0] + share * (values[1] - values[0]);
                let (a, b) = (&solved[early], &solved[late]);
                let variance = between([a.variance, b.variance]);
                let covariance = between([a.covariance, b.covariance]);
                CountMoments {
                    signed_mean: mean.signed,
                    total_mean: mean.total,
                    signed_variance: variance * mean.total,
                    total_variance: self.over_step(step, &self.total_variance),
                    covariance: fano * mean.signed + covariance * mean.total,
                }
            })
            .collect()
    }

    /// Steps of the scan that are worked out in full, ascending; the first and
    /// the last step are among them.
    fn knots(&self) -> Vec<u64> {
        let response = self.response;
        let scan = &response.model.scan;
        let samples_per_chip = f64::from(response.model.samples_per_chip);
        let mut knots = vec![0, scan.steps - 1];
        knots.extend((1..=FAR_KNOTS).map(|n| n * (scan.steps - 1) / (FAR_KNOTS + 1)));
        let count = (KNOT_REACH_CHIPS / KNOT_SPACING_CHIPS) as i64;
        for path in &response.light.paths {
            let delay = path.delay_chips + response.delay_chips + response.model.delay_chips
                - 0.5 * (response.timing.rising + response.timing.falling);
            for n in -count..=count {
                let chips = delay + n as f64 * KNOT_SPACING_CHIPS;
                let phase_step = (chips * samples_per_chip).round() as i64;
                let step = (phase_step - scan.first_step as i64)
                    .rem_euclid(scan.steps_per_period as i64) as u64;
                if step < scan.steps {
                    knots.push(step);
                }
            }
        }
        knots.sort_unstable();
        knots.dedup();
        knots
    }

    /// Second moments per expected detection, without what is proportional to r.
    fn solve_knots(&self, knots: &[u64]) -> Vec<PerDetection> {
        let per_period = self.response.correlator.hits_per_period();
        let last = self.response.grid.period_chips;
        let fano = self.total_variance[last] / per_period;
        let solve = |step: &u64| {
            let phase_step = self.response.model.scan.step(*step);
            let sums = self.phase_sums(phase_step);
            let signed = self.response.correlator.signed_per_period(phase_step);
            PerDetection {
                variance: sums.variance[last] / per_period,
                covariance: (sums.covariance[last] - fano * signed) / per_period,
            }
        };
        let threads = thread::available_parallelism().map_or(1, |n| n.get());
        let share = knots.len().div_ceil(threads);
        thread::scope(|scope| {
            let workers: Vec<_> = knots
                .chunks(share)
                .map(|knots| scope.spawn(move || knots.iter().map(solve).collect::<Vec<_>>()))
                .collect();
            workers
                .into_iter()
                .flat_map(|worker| match worker.join() {
                    Ok(solved) => solved,
                    Err(panic) => std::panic::resume_unwind(panic),
                })
                .collect()
        })
    }

    fn phase_sums(&self, phase_step: u64) -> PhaseSums {
        let grid = &*self.response.grid;
        let signs = self.signs(phase_step);
        let excess = self
            .pairs
            .excess(grid, &self.response.detections, &signs);
        let cells = || self.hits.iter().zip(&signs).zip(&excess);
        let variance = cells().map(|((hits, s), q)| hits + 2.0 * s * q);
        let covariance = cells()
            .zip(&self.excess)
            .map(|(((hits, s), q), q_total)| s * (hits + q_total) + q);
        PhaseSums {
            variance: before_chips(grid, variance),
            covariance: before_chips(grid, covariance),
        }
    }

    /// Mean sign in every cell of the code period.
    fn signs(&self, phase_step: u64) -> Vec<f64> {
        let response = self.response;
        let chips = &response.model.reference.chips;
        let chi = |chip: i64| {
            f64::from(chips[chip.rem_euclid(chips.len() as i64) as usize]) * 2.0 - 1.0
        };
        // Code chip 0 begins here, in the grid's frame.
        let start = phase_step as f64 / f64::from(response.model.samples_per_chip)
            + 0.5 * (response.timing.rising + response.timing.falling)
            - self.frame_after_window()
            - response.timing.window;
        let (whole, cut) = (start.floor(), start - start.floor());
        let late: Vec<f64> = response
            .grid
            .edges
            .windows(2)
            .map(|edge| ((edge[1] - cut) / (edge[1] - edge[0])).clamp(0.0, 1.0))
            .collect();
        let mut signs = Vec::with_capacity(self.hits.len());
        for chip in 0..response.grid.period_chips as i64 {
            let (before, after) = (chi(chip - whole as i64 - 1), chi(chip - whole as i64));
            signs.extend(late.iter().map(|late| before + late * (after - before)));
        }
        signs
    }

    /// From a step's window to the grid's frame, in chips.
    fn frame_after_window(&self) -> f64 {
        let response = self.response;
        frame_chips(&response.light) + response.delay_chips + response.model.delay_chips
            - response.timing.window
    }

    /// What the chips of a step add up to; `before` has the sums before each chip
    /// of the grid. The window's edges are rounded to whole chips of the grid.
    fn over_step(&self, step: u64, before: &[f64]) -> f64 {
        let period = self.response.grid.period_chips;
        let (periods, first, rest) = self.response.chips_of(step);
        let shift = self.frame_after_window().round() as i64;
        let first = (first as i64 - shift).rem_euclid(period as i64) as usize;
        let end = first + rest;
        let partial = match end.checked_sub(period) {
            None => before[end] - before[first],
            Some(past) => before[period] - before[first] + before[past],
        };
        periods * before[period] + partial
    }
}

/// Second moments of one phase step, per expected detection.
struct PerDetection {
    variance: f64,
    covariance: f64,
}

impl<const M: usize> Pairs for Solved<M> {
    fn excess(&self, grid: &Grid, detections: &Detections, signs: &[f64]) -> Vec<f64> {
        variance::excess(grid, &self.chain, &self.states, detections, signs)
    }
}

impl Pairs for Poisson {
    fn excess(&self, _: &Grid, _: &Detections, signs: &[f64]) -> Vec<f64> {
        vec![0.0; signs.len()]
    }
}

/// Sums over the cells before each chip, and over all.
fn before_chips(grid: &Grid, per_cell: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sums = Vec::with_capacity(grid.period_chips + 1);
    let mut sum = 0.0;
    for (index, value) in per_cell.enumerate() {
        if index % grid.cells.len() == 0 {
            sums.push(sum);
        }
        sum += value;
    }
    sums.push(sum);
    sums
}
