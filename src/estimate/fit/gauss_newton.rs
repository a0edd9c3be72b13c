//! Weighted least squares, step by step to the minimum.

use std::sync::Arc;

use super::error::FitError;
use super::known_moments::{KnownMoments, Linear};
use super::least_squares::{Normal, Weights};
use super::model_estimate::{FittedPath, ModelEstimate};
use super::parameters::Parameters;
use super::problem::Problem;
use crate::estimate::distance_m;
use crate::response::MeanCount;

/// Most Gauss-Newton steps: half a dozen are enough, save where noise is so large
/// that the peak's curvature shows within it.
pub const MOST_ITERATIONS: usize = 50;

/// A fit has converged when no unknown moves by more than this share of its
/// standard deviation, or chi-square falls by no more than its square: corners of the
/// correlation let no gradient vanish.
pub const CONVERGED_SIGMAS: f64 = 0.02;

/// Weights are made anew where a fit has settled farther than this from where they were
/// made, if they are worth it.
pub const WEIGHED_SIGMAS: f64 = 0.1;

/// Most exact expectations of a fit that starts from known derivatives, and most nodes
/// on the way to the nearest.
const MOST_NEAR: usize = 4;
const MOST_NODES: usize = 4;

/// From node to node, to that which is nearest to its own fit; `None` if there is none.
fn approach(
    problem: &Problem,
    known: &KnownMoments,
    start: &Parameters,
    measured: &[MeanCount],
) -> Result<Option<(Arc<Linear>, Parameters)>, FitError> {
    let mut here = start.clone();
    for _ in 0..MOST_NODES {
        // A start from few counts may be light that has no response.
        let Ok(linear) = known.linear(problem, &here) else {
            return Ok(None);
        };
        let weights = known.weights(problem, &linear.parameters, &linear.means)?;
        let columns = linear.columns_at(&linear.parameters);
        let Some(normal) = weights.normal(&columns, measured, &linear.means) else {
            return Ok(None);
        };
        let next = linear
            .parameters
            .moved(&bounded(&normal, &linear.parameters), 1.0);
        if linear.holds_for(&next, problem.model.dead_time_chips) {
            return Ok(Some((linear, next)));
        }
        here = next;
    }
    Ok(None)
}

/// The Gauss-Newton step that leaves no less than no background.
pub fn bounded(normal: &Normal, parameters: &Parameters) -> Vec<f64> {
    let full = normal.solution();
    match full.last() {
        Some(last) if parameters.constant + last < 0.0 => {
            normal.solution_with_last(-parameters.constant)
        }
        _ => full,
    }
}

/// A finished fit.
pub struct Fitted {
    pub parameters: Parameters,
    normal: Normal,
    chi_square: f64,
    /// Numbers that the counts are.
    values: usize,
    iterations: usize,
}

impl Fitted {
    /// From derivatives at a node near the start, which are kept from scan to scan: a
    /// step that costs nothing, then exact expectations, one or two, until a step is
    /// too small to matter. `None` where that does not lead to an end.
    pub fn near_node(
        problem: &Problem,
        known: &KnownMoments,
        start: &Parameters,
        counts: &[MeanCount],
    ) -> Result<Option<Fitted>, FitError> {
        if 2 * problem.steps.len() <= start.len() {
            return Ok(None);
        }
        let measured: Vec<MeanCount> = problem.steps.iter().map(|&s| counts[s.index()]).collect();
        let Some((linear, mut parameters)) = approach(problem, known, start, &measured)? else {
            return Ok(None);
        };
        for iteration in 1..=MOST_NEAR {
            let Ok(expected) = problem.means(&parameters) else {
                return Ok(None);
            };
            let weights = known.weights(problem, &parameters, &expected)?;
            let columns = linear.columns_at(&parameters);
            let Some(normal) = weights.normal(&columns, &measured, &expected) else {
                return Ok(None);
            };
            let next = parameters.moved(&bounded(&normal, &parameters), 1.0);
            let step = next.minus(&parameters);
            if normal.largest_step_sigmas(&step) < CONVERGED_SIGMAS {
                return Ok(Some(Fitted {
                    chi_square: weights.chi_square(&measured, &expected),
                    values: weights.values(),
                    parameters: next,
                    normal,
                    iterations: iteration,
                }));
            }
            parameters = next;
            if !linear.holds_for(&parameters, problem.model.dead_time_chips) {
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// Gauss-Newton, with shorter steps where a full one makes matters worse:
    /// first with the weights of a Poisson process, then, within a standard
    /// deviation of the end, with those of this detector.
    pub fn new(
        problem: &Problem,
        known: &KnownMoments,
        start: Parameters,
        counts: &[MeanCount],
    ) -> Result<Fitted, FitError> {
        let undetermined = || FitError::Undetermined {
            steps: problem.steps.len(),
            unknowns: start.len(),
        };
        if 2 * problem.steps.len() <= start.len() {
            return Err(undetermined());
        }
        let measured: Vec<MeanCount> = problem.steps.iter().map(|&s| counts[s.index()]).collect();
        let mut parameters = start.clone();
        let mut response = problem.response(&parameters)?;
        let mut expected = problem.means_of(&response);
        let mut weights = Weights::of_poisson(&expected);
        let mut chi_square = weights.chi_square(&measured, &expected);
        let mut weighed_at: Option<Parameters> = None;
        let mut times_weighed = 0;
        let mut jacobian = problem.jacobian(&parameters, &response, &expected)?;
        let mut linearised = parameters.clone();
        for iteration in 1..=MOST_ITERATIONS {
            let normal = weights
                .normal(&jacobian, &measured, &expected)
                .ok_or_else(undetermined)?;
            let full = bounded(&normal, &parameters);
            let (before, chi_square_before) = (parameters.clone(), chi_square);
            let mut share = 1.0;
            loop {
                let tried = parameters.moved(&full, share);
                // A step of few counts may lead to light that has no response.
                if let Ok(tried_response) = problem.response(&tried) {
                    let means = problem.means_of(&tried_response);
                    let found = weights.chi_square(&measured, &means);
                    if found <= chi_square * (1.0 + 1e-9) + 1e-6 {
                        (parameters, response, expected) = (tried, tried_response, means);
                        chi_square = found;
                        break;
                    }
                }
                share *= 0.4;
                if share < 0.01 {
                    break;
                }
            }
            if parameters == before && parameters != linearised {
                // No way leads down, perhaps for derivatives from elsewhere.
                jacobian = problem.jacobian(&parameters, &response, &expected)?;
                linearised = parameters.clone();
                continue;
            }
            // Where no way leads down even so is the minimum, as far as derivatives
            // from finite steps can tell.
            let moved = normal.largest_step_sigmas(&parameters.minus(&before));
            let fell = chi_square_before - chi_square;
            let has_settled = moved < CONVERGED_SIGMAS
                || weighed_at.is_some() && fell < CONVERGED_SIGMAS * CONVERGED_SIGMAS;
            let is_weighed_elsewhere = match &weighed_at {
                None => moved < 1.0,
                Some(_) if !has_settled || times_weighed == problem.most_weighings() => false,
                Some(there) => {
                    normal.largest_step_sigmas(&parameters.minus(there)) > WEIGHED_SIGMAS
                }
            };
            if is_weighed_elsewhere {
                weighed_at = Some(parameters.clone());
                times_weighed += 1;
                weights = known.weights(problem, &parameters, &expected)?;
                chi_square = weights.chi_square(&measured, &expected);
            } else if has_settled {
                return Ok(Fitted {
                    parameters,
                    normal,
                    chi_square,
                    values: weights.values(),
                    iterations: iteration,
                });
            }
            if parameters.differ_from(&linearised) {
                jacobian = problem.jacobian(&parameters, &response, &expected)?;
                linearised = parameters.clone();
            }
        }
        Err(FitError::NotConverged {
            steps: MOST_ITERATIONS,
        })
    }

    /// By how many standard deviations chi-square is above what it should be.
    pub fn excess_sigmas(&self) -> f64 {
        let degrees = self.degrees_of_freedom().max(1) as f64;
        (self.chi_square - degrees) / (2.0 * degrees).sqrt()
    }

    fn degrees_of_freedom(&self) -> usize {
        self.values.saturating_sub(self.parameters.len())
    }

    pub fn estimate(&self, problem: &Problem) -> ModelEstimate {
        let chip_ps = problem.clock().chip_period_ps;
        let std = self.normal.standard_deviations();
        let paths: Vec<FittedPath> = self
            .parameters
            .paths
            .iter()
            .zip(&problem.codes)
            .enumerate()
            .map(|(index, (path, code))| FittedPath {
                code: Arc::clone(code),
                delay_ps: path.delay_chips.rem_euclid(code.len() as f64) * chip_ps,
                delay_std_ps: std[2 * index] * chip_ps,
                rate_hz: path.ln_rate.exp() / (chip_ps * 1e-12),
                rate_relative_std: std[2 * index + 1],
            })
            .collect();
        ModelEstimate {
            delay_ps: paths[0].delay_ps,
            distance_m: distance_m(paths[0].delay_ps),
            std_m: distance_m(paths[0].delay_std_ps),
            velocity: None,
            constant_rate_hz: self.parameters.constant / (chip_ps * 1e-12),
            chi_square: self.chi_square,
            degrees_of_freedom: self.degrees_of_freedom(),
            steps: problem.steps.len(),
            untold: None,
            iterations: self.iterations,
            paths,
        }
    }
}
