//! Second moments for fits, worked out once for neighbouring light.
//!
//! They cost more than all else in a fit, and hardly change with the light beside
//! what Poisson counts would have: variances N, and the mean of r as covariance. So
//! what is different from that, per detection, is taken from the nearest node of a
//! grid of the unknowns: the same, whatever was fitted before.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use super::least_squares::Weights;
use super::problem::{Parameters, PathParameters, Problem};
use crate::response::{CountMoments, MeanCount, MeanResponseError};
use crate::scan::Step;

/// Distance of nodes: delays in chips, and rates times dead time, which is what
/// moments per detection depend on.
struct Spacing {
    delay_chips: f64,
    saturation: f64,
    /// Most nodes that are kept.
    kept: usize,
}

/// Half a spacing changes moments by less than a per cent: chi-square of some tens
/// of counts has a spread of 15 %.
const OF_WINDOWS: Spacing = Spacing {
    delay_chips: 1.0 / 32.0,
    saturation: 0.008,
    kept: 10_000,
};

/// Chi-square of ten thousands of counts has a spread of under a per cent.
const OF_SCANS: Spacing = Spacing {
    delay_chips: 1.0 / 64.0,
    saturation: 0.002,
    kept: 100,
};

/// Which node.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Key {
    /// Steps of a window; none for the whole scan.
    steps: Vec<Step>,
    /// Chips of the codes.
    codes: Vec<Vec<u8>>,
    /// Delay and strength of each path, and the constant light, in spacings.
    place: Vec<i64>,
}

/// Second moments of one step's counts, per expected detection.
#[derive(Debug, Clone, Copy)]
struct PerDetection {
    signed_variance: f64,
    total_variance: f64,
    /// Covariance of r and N, less the mean of r.
    excess_covariance: f64,
}

/// Second moments at nodes that were needed so far.
#[derive(Default)]
pub struct KnownMoments {
    nodes: Mutex<HashMap<Key, Arc<[PerDetection]>>>,
}

impl KnownMoments {
    /// The weights of a problem's counts at `parameters`, which expect `means`.
    pub fn weights(
        &self,
        problem: &Problem,
        parameters: &Parameters,
        means: &[MeanCount],
    ) -> Result<Weights, MeanResponseError> {
        let known = self.nearest(problem, parameters)?;
        let moments = means.iter().zip(known.iter());
        let moments: Vec<CountMoments> = moments
            .map(|(mean, known)| CountMoments {
                signed_mean: mean.signed,
                total_mean: mean.total,
                signed_variance: known.signed_variance * mean.total,
                total_variance: known.total_variance * mean.total,
                covariance: mean.signed + known.excess_covariance * mean.total,
            })
            .collect();
        Ok(Weights::of(&moments))
    }

    fn nearest(
        &self,
        problem: &Problem,
        parameters: &Parameters,
    ) -> Result<Arc<[PerDetection]>, MeanResponseError> {
        let spacing = match problem.takes_all_steps() {
            true => &OF_SCANS,
            false => &OF_WINDOWS,
        };
        let (place, node) = nearest(parameters, spacing, problem.model.dead_time_chips());
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
        let moments = problem.moments(&problem.response(&node)?)?;
        let found: Arc<[PerDetection]> = moments
            .iter()
            .map(|m| (m, m.total_mean.max(f64::MIN_POSITIVE)))
            .map(|(m, detections)| PerDetection {
                signed_variance: m.signed_variance / detections,
                total_variance: m.total_variance / detections,
                excess_covariance: (m.covariance - m.signed_mean) / detections,
            })
            .collect();
        let mut nodes = nodes();
        if nodes.len() < spacing.kept {
            nodes.insert(key, Arc::clone(&found));
        }
        Ok(found)
    }
}

impl fmt::Debug for KnownMoments {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("KnownMoments").finish_non_exhaustive()
    }
}

/// The node nearest to some parameters, and its numbers. Rates of nodes are odd
/// multiples of half a spacing: there is some light at every node.
fn nearest(
    parameters: &Parameters,
    spacing: &Spacing,
    dead_time_chips: f64,
) -> (Vec<i64>, Parameters) {
    let mut place = Vec::with_capacity(parameters.len());
    // Without dead time moments per detection do not depend on the rate.
    let rate_spacing = spacing.saturation / dead_time_chips.max(0.1);
    let mut numbered = |number: f64| {
        place.push(number as i64);
        number
    };
    let mut rate = |rate: f64| {
        let number = numbered((rate / rate_spacing).floor());
        (number + 0.5) * rate_spacing
    };
    let rates: Vec<f64> = parameters
        .paths
        .iter()
        .map(|p| rate(p.ln_rate.exp()))
        .collect();
    let constant = rate(parameters.constant);
    let paths = parameters.paths.iter().zip(rates);
    let paths = paths.map(|(path, rate)| PathParameters {
        delay_chips: numbered((path.delay_chips / spacing.delay_chips).round())
            * spacing.delay_chips,
        ln_rate: rate.ln(),
    });
    let node = Parameters {
        paths: paths.collect(),
        constant,
    };
    (place, node)
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
            let (place, node) = nearest(&parameters, &OF_WINDOWS, 2.0);
            let (path, known) = (parameters.paths[0], node.paths[0]);
            assert!((path.delay_chips - known.delay_chips).abs() <= 0.5001 / 32.0);
            assert!((path.ln_rate.exp() - known.ln_rate.exp()).abs() <= 0.002_001);
            assert!((parameters.constant - node.constant).abs() <= 0.002_001);
            assert_eq!(nearest(&node, &OF_WINDOWS, 2.0).0, place);
        }
    }
}
