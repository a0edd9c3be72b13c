//! From a start to the node that is nearest to its own fit.
//!
//! Near a node means are as good as linear in the unknowns, and their derivatives are kept from
//! scan to scan: steps from node to node cost nothing beside an expected response.

use std::sync::Arc;

use super::error::FitError;
use super::known_moments::{KnownMoments, Linear};
use super::normal::Normal;
use super::parameters::Parameters;
use super::problem::Problem;
use super::scoring::{Counts, Settling, Slopes, settle};
use super::template::Axis;
use super::weights::Weights;
use crate::response::MeanCount;

/// Most nodes on the way.
const MOST_NODES: usize = 4;

/// The counts of a scan, which expect what a node says.
struct NearNode<'a, 'm> {
    problem: &'a Problem<'m>,
    measured: &'a [MeanCount],
    linear: &'a Linear,
    weights: Weights,
}

impl Counts for NearNode<'_, '_> {
    /// Parameters, and what they let one expect.
    type Place = (Parameters, Vec<MeanCount>);
    type Error = FitError;

    fn residuals(&self, (_, expected): &Self::Place) -> Result<Vec<f64>, FitError> {
        Ok(self.weights.residuals(self.measured, expected))
    }

    fn slopes(&mut self, _here: &Self::Place, _anew: bool) -> Result<Slopes, FitError> {
        let columns = self.weights.whitened_columns(&self.linear.columns);
        Ok(Slopes { columns, are_best: true })
    }

    fn step(&self, (parameters, _): &Self::Place, normal: &Normal) -> Vec<f64> {
        parameters.step(normal, self.problem.most_walk())
    }

    fn moved(&self, (here, _): &Self::Place, step: &[f64]) -> Result<Self::Place, FitError> {
        let there = here.moved(step);
        let expected = self.linear.means_at(&there);
        Ok((there, expected))
    }

    fn is_linear(&self, _from: &Self::Place, _to: &Self::Place) -> bool {
        true
    }

    fn weigh(&mut self, _here: &Self::Place, _fall: f64) -> Result<bool, FitError> {
        Ok(false)
    }

    fn undetermined(&self, (here, _): &Self::Place) -> FitError {
        FitError::Undetermined { steps: self.measured.len(), unknowns: here.len() }
    }
}

/// Where a fit to first order ends, and the node nearby; `None` where it leads nowhere: a start
/// from few counts may be light that has no response.
pub fn nearby(
    problem: &Problem,
    axis: &Axis,
    known: &KnownMoments,
    start: &Parameters,
    measured: &[MeanCount],
) -> Option<(Arc<Linear>, Parameters)> {
    let mut here = start.clone();
    for _ in 0..MOST_NODES {
        let linear = known.linear(problem, &here).ok()?;
        let Linear { parameters, means, .. } = &*linear;
        let weights = known.scan_weights(problem, parameters, means, axis).ok()?;
        let mut counts = NearNode { problem, measured, linear: &linear, weights };
        let node = (parameters.clone(), means.clone());
        let settled = settle(&mut counts, node, Settling::FINE).ok()?;
        here = settled.place.0.moved(&settled.step);
        if linear.holds_for(&here, problem) {
            return Some((linear, here));
        }
    }
    None
}
