//! The Cramer-Rao bound: how precise any unbiased estimator can be.

use std::sync::Arc;

use super::model::{FitError, Parameters, PathParameters, Problem, window};
use super::phase::first_maximum;
use super::{CountingTier, distance_m};
use crate::optics::{DetectorModel, Light, MeanResponse};
use crate::scene::Scene;

/// What the counts of one scan can tell of a distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Least standard deviation of the distance, with delay and strength of
    /// every path and the constant light unknown.
    pub bound_m: f64,
    /// Phase steps that take part: 3 S round the peak for one path, the whole
    /// scan for more.
    pub steps: usize,
}

/// The bound for the first path of the scene that carries modulated light to the
/// detector, from derivatives of the means and the exact covariance of r and N at
/// each step. What the variances alone would tell of the delay is left out.
///
/// # Panics
/// If the scene has no such detector.
pub fn bound(scene: &Scene, detector: usize, tier: CountingTier) -> Result<Bound, FitError> {
    let model = DetectorModel::new(scene, detector);
    let light = Light::of(&model);
    let parameters = Parameters {
        paths: light
            .paths
            .iter()
            .map(|path| PathParameters {
                delay_chips: path.delay_chips,
                ln_rate: path.rate_per_chip.ln(),
            })
            .collect(),
        constant: light.constant_per_chip,
    };
    let steps = if parameters.paths.len() == 1 {
        let means = MeanResponse::to_light(&model, light.clone(), tier)?.mean_counts();
        let signed: Vec<f64> = means.iter().map(|mean| mean.signed).collect();
        let peak = first_maximum(&signed) as u64;
        window(&scene.scan, scene.samples_per_chip, peak)
    } else {
        (0..scene.scan.steps).collect()
    };
    let problem = Problem {
        model: &model,
        tier,
        codes: light.paths.iter().map(|p| Arc::clone(&p.code)).collect(),
        steps,
    };
    let jacobian = problem.central_jacobian(&parameters)?;
    let information = problem.weights(&parameters)?.information(&jacobian);
    let steps = problem.steps.len();
    match information {
        Some(information) if !parameters.paths.is_empty() => Ok(Bound {
            bound_m: distance_m(information.standard_deviations()[0] * scene.chip_period_ps),
            steps,
        }),
        _ => Err(FitError::Undetermined {
            steps,
            unknowns: parameters.len(),
        }),
    }
}
