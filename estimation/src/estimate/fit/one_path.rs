//! The fit of the only path.

use std::borrow::Cow;
use std::sync::Arc;

use super::descent::{Descending, Descent, Hypothesis, Source};
use super::error::FitError;
use super::known_moments::KnownMoments;
use super::model_estimate::{FittedPath, ModelEstimate, Velocity};
use super::nearby::nearby;
use super::normal::Normal;
use super::parameters::Parameters;
use super::problem::{Problem, Reading};
use super::scoring::{Settling, settle};
use super::template::Axis;
use super::weights::Weights;
use crate::estimate::distance_m;
use crate::response::MeanCount;

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
    /// From derivatives of nodes near the start, if these lead to an end; else from the start
    /// itself.
    pub fn new(
        problem: &Problem,
        axis: &Axis,
        known: &KnownMoments,
        start: Parameters,
        counts: &[MeanCount],
    ) -> Result<Fitted, FitError> {
        if 2 * problem.steps.len() <= start.len() {
            let steps = problem.steps.len();
            return Err(FitError::Undetermined { steps, unknowns: start.len() });
        }
        let measured: Vec<MeanCount> = problem.steps.iter().map(|&s| counts[s.index()]).collect();
        let near = match start.walk {
            None => nearby(problem, axis, known, &start, &measured),
            Some(_) => None,
        };
        let near = near.and_then(|(linear, near)| {
            let source = Source::Nodes(known, Some(linear));
            Fitted::from(problem, axis, known, (near, source), &measured).ok()
        });
        near.map_or_else(
            || Fitted::from(problem, axis, known, (start, Source::Differences), &measured),
            Ok,
        )
    }

    /// From a start, with weights of a Poisson process until the fit is near its end, unless
    /// it is so already.
    fn from(
        problem: &Problem,
        axis: &Axis,
        known: &KnownMoments,
        (start, source): (Parameters, Source),
        measured: &[MeanCount],
    ) -> Result<Fitted, FitError> {
        let start = Hypothesis::of(problem, start, Reading::Exact)?;
        let (weights, weighed_at) = match source {
            Source::Nodes(..) => {
                (start.weights(problem, known, axis)?, Some(start.parameters.clone()))
            }
            _ => (Weights::of_poisson(&start.expected), None),
        };
        let descent = Descent { problem, measured, axis, weights, reading: Reading::Exact };
        let mut descending = Descending::new(&descent, source).weighing(known, weighed_at);
        let settled = settle(&mut descending, start, Settling::FINE)?;
        if !settled.has_settled {
            return Err(FitError::NotConverged { steps: settled.steps });
        }
        let weights: Cow<Weights> = descending.weights;
        let iterations = settled.steps;
        let (end, normal) = settled.at_end();
        Ok(Fitted {
            parameters: end.parameters,
            normal,
            chi_square: end.chi_square,
            values: weights.values(),
            ln_determinant: weights.ln_determinant(),
            iterations,
        })
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
            velocity: self.parameters.walk_index().zip(self.parameters.walk).map(
                |(index, walk)| Velocity {
                    m_per_s: distance_m(1e12 * walk),
                    std_m_per_s: distance_m(1e12 * std[index]),
                    at_s: problem.moment_ps * 1e-12,
                },
            ),
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
