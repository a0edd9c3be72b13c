//! Weights of fits, worked out once for neighbouring light.
//!
//! Second moments cost more than all else in a fit, and hardly change with the
//! light. So weights are those at the nearest node of a grid of the unknowns: the
//! same, whatever was fitted before.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use super::least_squares::Weights;
use super::problem::{Parameters, PathParameters, Problem};
use crate::optics::MeanResponseError;

/// Distance of nodes: delay in chips, logarithm of a strength, and constant light
/// as a share of all.
struct Spacing {
    delay_chips: f64,
    ln_rate: f64,
    constant: f64,
    /// Most nodes that are kept.
    kept: usize,
}

/// Half a spacing changes weights by less than a per cent: chi-square of some tens
/// of counts has a spread of 15.
const OF_WINDOWS: Spacing = Spacing {
    delay_chips: 1.0 / 64.0,
    ln_rate: 0.02,
    constant: 0.02,
    kept: 10_000,
};

/// Chi-square of ten thousands of counts has a spread of under a per cent.
const OF_SCANS: Spacing = Spacing {
    delay_chips: 1.0 / 64.0,
    ln_rate: 5e-3,
    constant: 5e-3,
    kept: 100,
};

/// Which node.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Key {
    /// Steps of a window; none for the whole scan.
    steps: Vec<u64>,
    /// Chips of the codes.
    codes: Vec<Vec<u8>>,
    /// Delay and strength of each path, and the constant light, in spacings.
    place: Vec<i64>,
}

/// Weights at nodes that were needed so far.
#[derive(Default)]
pub struct KnownWeights {
    nodes: Mutex<HashMap<Key, Arc<Weights>>>,
}

impl KnownWeights {
    /// The weights of a problem at the node nearest to `parameters`.
    pub fn of(
        &self,
        problem: &Problem,
        parameters: &Parameters,
    ) -> Result<Arc<Weights>, MeanResponseError> {
        let spacing = match problem.takes_all_steps() {
            true => &OF_SCANS,
            false => &OF_WINDOWS,
        };
        let (place, node) = nearest(parameters, spacing);
        let key = Key {
            steps: match problem.takes_all_steps() {
                true => Vec::new(),
                false => problem.steps.clone(),
            },
            codes: problem.codes.iter().map(|c| c.chips.clone()).collect(),
            place,
        };
        // Whoever panicked meanwhile left the map whole.
        let nodes = || self.nodes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = nodes().get(&key) {
            return Ok(Arc::clone(known));
        }
        let weights = Arc::new(problem.weights(&problem.response(&node)?)?);
        let mut nodes = nodes();
        if nodes.len() < spacing.kept {
            nodes.insert(key, Arc::clone(&weights));
        }
        Ok(weights)
    }
}

impl fmt::Debug for KnownWeights {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("KnownWeights").finish_non_exhaustive()
    }
}

/// The node nearest to some parameters, and its numbers.
fn nearest(parameters: &Parameters, spacing: &Spacing) -> (Vec<i64>, Parameters) {
    let mut place = Vec::with_capacity(parameters.len());
    let mut round = |value: f64, spacing: f64| {
        let number = (value / spacing).round();
        place.push(number as i64);
        number * spacing
    };
    let paths: Vec<PathParameters> = parameters
        .paths
        .iter()
        .map(|path| PathParameters {
            delay_chips: round(path.delay_chips, spacing.delay_chips),
            ln_rate: round(path.ln_rate, spacing.ln_rate),
        })
        .collect();
    let modulated: f64 = paths.iter().map(|path| path.ln_rate.exp()).sum();
    let constant = round(parameters.constant / modulated, spacing.constant) * modulated;
    (place, Parameters { paths, constant })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_within_half_a_spacing_and_its_own_nearest() {
        for number in 0..50 {
            let number = f64::from(number);
            let parameters = Parameters {
                paths: vec![PathParameters {
                    delay_chips: 2.0 + 0.0137 * number,
                    ln_rate: -4.0 + 0.0311 * number,
                }],
                constant: 1e-3 * number,
            };
            let (place, node) = nearest(&parameters, &OF_WINDOWS);
            let (path, known) = (parameters.paths[0], node.paths[0]);
            assert!((path.delay_chips - known.delay_chips).abs() <= 0.5001 / 64.0);
            assert!((path.ln_rate - known.ln_rate).abs() <= 0.01001);
            let off = (parameters.constant - node.constant).abs();
            assert!(off <= 0.01001 * known.ln_rate.exp());
            assert_eq!(nearest(&node, &OF_WINDOWS).0, place);
        }
    }
}
