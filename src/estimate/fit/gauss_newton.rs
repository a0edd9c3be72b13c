//! Weighted least squares, step by step to the minimum.

use std::sync::Arc;

use super::error::FitError;
use super::known_moments::{KnownMoments, Linear};
use super::model_estimate::{FittedPath, ModelEstimate};
use super::normal::Normal;
use super::parameters::{Column, Parameters};
use super::problem::Problem;
use super::template::Axis;
use super::weights::Weights;
use crate::estimate::distance_m;
use crate::response::{MeanCount, MeanResponse, MeanResponseError};

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

/// Least share of a step that is tried.
const LEAST_SHARE: f64 = 0.01;

/// Most exact expectations of a fit that starts from known derivatives, and most nodes
/// on the way to the nearest.
const MOST_NEAR: usize = 4;
const MOST_NODES: usize = 4;

/// From node to node, to that which is nearest to its own fit; `None` if there is none.
fn approach(
    problem: &Problem,
    axis: &Axis,
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
        let weights = known.scan_weights(problem, &linear.parameters, &linear.means, axis)?;
        let columns = linear.columns_at(&linear.parameters);
        let Some(normal) = weights.normal(&columns, measured, &linear.means) else {
            return Ok(None);
        };
        let next = linear.parameters.moved(&bounded(&normal, &linear.parameters), 1.0);
        if linear.holds_for(&next, problem.model.dead_time_chips) {
            return Ok(Some((linear, next)));
        }
        here = next;
    }
    Ok(None)
}

/// Where a fit stands.
struct Here<'m> {
    parameters: Parameters,
    response: MeanResponse<'m>,
    expected: Vec<MeanCount>,
    chi_square: f64,
}

/// Where weights were made: of a Poisson process, before any were for this detector.
struct Weighing {
    weights: Weights,
    at: Option<Parameters>,
    times: usize,
}

impl Weighing {
    /// Whether those of this detector were made too far from here, if they were at all.
    fn is_of_elsewhere(&self, here: &Parameters, normal: &Normal) -> bool {
        self.at
            .as_ref()
            .is_none_or(|there| normal.largest_step_sigmas(&here.minus(there)) > WEIGHED_SIGMAS)
    }
}

impl<'m> Here<'m> {
    /// The start of a fit, with weights of a Poisson process.
    fn at(
        problem: &Problem<'m>,
        start: &Parameters,
        measured: &[MeanCount],
    ) -> Result<(Here<'m>, Weighing), FitError> {
        let response = problem.response(start)?;
        let expected = problem.means_of(&response);
        let weights = Weights::of_poisson(&expected);
        let here = Here {
            chi_square: weights.chi_square(measured, &expected),
            parameters: start.clone(),
            response,
            expected,
        };
        let weighing = Weighing { weights, at: None, times: 0 };
        Ok((here, weighing))
    }

    fn jacobian(&self, problem: &Problem<'m>) -> Result<Vec<Column>, MeanResponseError> {
        problem.jacobian(&self.parameters, &self.response, &self.expected)
    }

    /// The place a step further, or a shorter one where the full one makes matters worse;
    /// `None` where all of them do.
    fn downhill(
        &self,
        problem: &Problem<'m>,
        full: &[f64],
        weights: &Weights,
        measured: &[MeanCount],
    ) -> Option<Here<'m>> {
        let mut share = 1.0;
        while share >= LEAST_SHARE {
            let parameters = self.parameters.moved(full, share);
            // A step of few counts may lead to light that has no response.
            if let Ok(response) = problem.response(&parameters) {
                let expected = problem.means_of(&response);
                let chi_square = weights.chi_square(measured, &expected);
                if chi_square <= self.chi_square * (1.0 + 1e-9) + 1e-6 {
                    return Some(Here { parameters, response, expected, chi_square });
                }
            }
            share *= 0.4;
        }
        None
    }
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
    /// Of the counts' covariance.
    ln_determinant: f64,
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
        axis: &Axis,
        known: &KnownMoments,
        start: &Parameters,
        counts: &[MeanCount],
    ) -> Result<Option<Fitted>, FitError> {
        if 2 * problem.steps.len() <= start.len() {
            return Ok(None);
        }
        let measured: Vec<MeanCount> = problem.steps.iter().map(|&s| counts[s.index()]).collect();
        let Some((linear, mut parameters)) = approach(problem, axis, known, start, &measured)?
        else {
            return Ok(None);
        };
        for iteration in 1..=MOST_NEAR {
            let Ok(expected) = problem.means(&parameters) else {
                return Ok(None);
            };
            let weights = known.scan_weights(problem, &parameters, &expected, axis)?;
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
                    ln_determinant: weights.ln_determinant(),
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
        axis: &Axis,
        known: &KnownMoments,
        start: Parameters,
        counts: &[MeanCount],
    ) -> Result<Fitted, FitError> {
        let undetermined =
            || FitError::Undetermined { steps: problem.steps.len(), unknowns: start.len() };
        if 2 * problem.steps.len() <= start.len() {
            return Err(undetermined());
        }
        let measured: Vec<MeanCount> = problem.steps.iter().map(|&s| counts[s.index()]).collect();
        let (mut here, mut weighing) = Here::at(problem, &start, &measured)?;
        let mut jacobian = here.jacobian(problem)?;
        let mut linearised = start.clone();
        for iteration in 1..=MOST_ITERATIONS {
            let normal = weighing
                .weights
                .normal(&jacobian, &measured, &here.expected)
                .ok_or_else(undetermined)?;
            let (before, chi_square_before) = (here.parameters.clone(), here.chi_square);
            let full = bounded(&normal, &before);
            if let Some(next) = here.downhill(problem, &full, &weighing.weights, &measured) {
                here = next;
            }
            if here.parameters == before && here.parameters != linearised {
                // No way leads down, perhaps for derivatives from elsewhere.
                jacobian = here.jacobian(problem)?;
                linearised = here.parameters.clone();
                continue;
            }
            // Where no way leads down even so is the minimum, as far as derivatives
            // from finite steps can tell.
            let moved = normal.largest_step_sigmas(&here.parameters.minus(&before));
            let fell = chi_square_before - here.chi_square;
            let has_settled = moved < CONVERGED_SIGMAS
                || weighing.at.is_some() && fell < CONVERGED_SIGMAS * CONVERGED_SIGMAS;
            let is_near_the_end = match weighing.at {
                None => moved < 1.0,
                Some(_) => has_settled && weighing.times < problem.most_weighings(),
            };
            if is_near_the_end && weighing.is_of_elsewhere(&here.parameters, &normal) {
                weighing = Weighing {
                    weights: known.scan_weights(problem, &here.parameters, &here.expected, axis)?,
                    at: Some(here.parameters.clone()),
                    times: weighing.times + 1,
                };
                here.chi_square = weighing.weights.chi_square(&measured, &here.expected);
            } else if has_settled {
                return Ok(Fitted {
                    parameters: here.parameters,
                    normal,
                    chi_square: here.chi_square,
                    values: weighing.weights.values(),
                    ln_determinant: weighing.weights.ln_determinant(),
                    iterations: iteration,
                });
            }
            if here.parameters.differ_from(&linearised) {
                jacobian = here.jacobian(problem)?;
                linearised = here.parameters.clone();
            }
        }
        Err(FitError::NotConverged { steps: MOST_ITERATIONS })
    }

    /// How unlikely the counts are, in -2 ln(likelihood): chi-square alone would favour
    /// places at which counts are taken to scatter more.
    pub fn unlikelihood(&self) -> f64 {
        self.chi_square + self.ln_determinant
    }

    fn degrees_of_freedom(&self) -> usize {
        self.values.saturating_sub(self.parameters.len())
    }

    pub fn estimate(&self, problem: &Problem) -> ModelEstimate {
        let clock = problem.clock();
        let std = self.normal.standard_deviations();
        let paths: Vec<FittedPath> = self
            .parameters
            .paths
            .iter()
            .zip(&problem.codes)
            .enumerate()
            .map(|(index, (path, code))| FittedPath {
                code: Arc::clone(code),
                delay_ps: clock.ps(path.delay_chips.rem_euclid(code.len() as f64)),
                delay_std_ps: clock.ps(std[2 * index]),
                rate_hz: clock.hz(path.ln_rate.exp()),
                rate_relative_std: std[2 * index + 1],
            })
            .collect();
        ModelEstimate {
            delay_ps: paths[0].delay_ps,
            distance_m: distance_m(paths[0].delay_ps),
            std_m: distance_m(paths[0].delay_std_ps),
            velocity: None,
            constant_rate_hz: clock.hz(self.parameters.constant),
            chi_square: self.chi_square,
            degrees_of_freedom: self.degrees_of_freedom(),
            steps: problem.steps.len(),
            untold: None,
            iterations: self.iterations,
            paths,
        }
    }
}
