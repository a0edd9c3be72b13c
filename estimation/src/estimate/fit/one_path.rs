//! The fit of a single path.
//!
//! Near a node of known light the means are nearly linear in the unknowns, and their derivatives
//! are kept from scan to scan: steps from node to node cost nothing beside an expected response.
//! Only the last steps, from the node nearest to the fit, take exact means.

use std::sync::Arc;

use super::descent::{Derivatives, Descent, Hypothesis};
use super::error::FitError;
use super::known_moments::{KnownMoments, Linear};
use super::likeliest::{Likeliest, PathSlopes, Scatter, likeliest};
use super::model_estimate::{Goodness, ModelEstimate, Velocity};
use super::normal::Normal;
use super::parameters::FitParameters;
use super::problem::{Problem, ResponseReading, Sides};
use super::template::DelayAxis;
use super::weights::Weights;
use crate::response::MeanCount;

/// A finished fit.
pub struct OnePathFit<'m> {
    pub end: Hypothesis<'m>,
    normal: Normal,
    weights: Weights,
}

impl<'m> OnePathFit<'m> {
    /// With derivatives of nodes near the start, if that fit settles; else from the start itself.
    pub fn new(
        problem: &Problem<'m>,
        axis: &DelayAxis,
        known: &KnownMoments,
        start: FitParameters,
        counts: &[MeanCount],
    ) -> Result<OnePathFit<'m>, FitError> {
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
            let source = Derivatives::Nodes(known, Some(linear));
            OnePathFit::from(problem, axis, known, (near, source), &measured).ok()
        });
        near.map_or_else(
            || OnePathFit::from(problem, axis, known, (start, Derivatives::Differences), &measured),
            Ok,
        )
    }

    /// From a start, with the weights of Poisson counts until the fit is near its end.
    fn from(
        problem: &Problem<'m>,
        axis: &DelayAxis,
        known: &KnownMoments,
        (start, source): (FitParameters, Derivatives),
        measured: &[MeanCount],
    ) -> Result<OnePathFit<'m>, FitError> {
        let start = Hypothesis::of(problem, start, ResponseReading::Exact, None)?;
        let (weights, weighed_at) = match source {
            Derivatives::Nodes(..) => {
                (start.weights(problem, known, axis)?, Some(start.parameters.clone()))
            }
            _ => (Weights::of_poisson(&start.expected), None),
        };
        let mut descent =
            Descent { problem, measured, axis, weights, reading: ResponseReading::Exact };
        let settled = descent.weighed(start, source, known, weighed_at)?;
        if !settled.has_settled {
            return Err(FitError::NotConverged { steps: settled.steps });
        }
        let (end, normal) = settled.at_end();
        Ok(OnePathFit { end, normal, weights: descent.weights })
    }

    /// -2 ln(likelihood), less a constant: chi-square alone would favour points at which the counts
    /// are expected to scatter more.
    pub fn unlikelihood(&self) -> f64 {
        self.end.chi_square + self.weights.ln_determinant()
    }

    /// How the likeliest delays scatter round the fit's, were that the true one.
    pub fn scatter(&self, problem: &Problem<'m>) -> Result<Likeliest, FitError> {
        let Hypothesis { parameters, expected, .. } = &self.end;
        let response = problem.response(parameters)?;
        let jacobian =
            problem.jacobian(parameters, &response, ResponseReading::Exact, Sides::Both)?;
        let apart = |chips| {
            let apart = problem.apart(parameters, &response, expected, (0, chips))?;
            Ok(self.weights.whitened(&apart))
        };
        let (steps, unknowns) = (problem.steps.len(), parameters.len());
        let slopes = PathSlopes::of_path(self.weights.whitened_columns(&jacobian), 0);
        likeliest(&Scatter::Normal, slopes, problem.found_within_chips(), apart)?
            .ok_or(FitError::Undetermined { steps, unknowns })
    }

    pub fn estimate(&self, problem: &Problem) -> ModelEstimate {
        let end = &self.end;
        let found = Goodness {
            chi_square: end.chi_square,
            degrees_of_freedom: self.weights.values().saturating_sub(end.parameters.len()),
            steps: problem.steps.len(),
            iterations: end.iterations,
            most_correlated: self.weights.most_correlated,
        };
        let std = self.normal.standard_deviations();
        let estimate = ModelEstimate::new(problem.clock(), &end.parameters, &std, found);
        let at_s = problem.moment_ps * 1e-12;
        let velocity = estimate.velocity.map(|velocity| Velocity { at_s, ..velocity });
        ModelEstimate { velocity, ..estimate }
    }
}

/// Most nodes on the way.
const MOST_NODES: usize = 4;

/// The end of a fit to first order, and the node nearby; `None` if it fails: a start from few counts
/// may be light that has no response.
pub fn nearby(
    problem: &Problem,
    axis: &DelayAxis,
    known: &KnownMoments,
    start: &FitParameters,
    measured: &[MeanCount],
) -> Option<(Arc<Linear>, FitParameters)> {
    let mut here = start.clone();
    for _ in 0..MOST_NODES {
        let linear = known.linear(problem, &here).ok()?;
        let Linear { parameters, means, columns } = &*linear;
        let weights = known.weights(problem, parameters, means, axis).ok()?;
        let residuals = weights.residuals(measured, means);
        let normal = Normal::of_whitened(&weights.whitened_columns(columns), &residuals)?;
        here = parameters.moved(&parameters.step(&normal, problem.most_walk()));
        if linear.holds_for(&here, problem) {
            return Some((linear, here));
        }
    }
    None
}
