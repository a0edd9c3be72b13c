//! The Cramer-Rao bound: how precise any unbiased estimator can be.

use std::sync::Arc;

use super::model::{FitError, Parameters, PathParameters, Problem, check_independent, window};
use super::phase::first_maximum;
use super::theory::ExpectedCounts;
use super::{CountingTier, TheoryEffort, distance_m};
use crate::optics::{DetectorModel, Light, MeanResponse, SecondMoments};
use crate::scene::Scene;
use crate::sensor::Step;

/// What the counts of one scan can tell of distances.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// One entry per path that carries modulated light, in the scene's order.
    pub paths: Vec<PathBound>,
    /// Phase steps that take part: 3 S round the peak for one path of the
    /// detector's own source, the whole scan for other light.
    pub steps: usize,
}

/// What the counts can tell of one path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathBound {
    /// Index of the path in the scene.
    pub path: usize,
    /// Least standard deviation of its distance, with delay and strength of
    /// every path and the constant light unknown.
    pub bound_m: f64,
}

impl Bound {
    /// The bound of path `path` of the scene, if it carries modulated light.
    pub fn of_path(&self, path: usize) -> Option<f64> {
        let entry = self.paths.iter().find(|entry| entry.path == path)?;
        Some(entry.bound_m)
    }
}

/// The bound for all light of a detector, from derivatives of the means and the
/// exact covariance of r and N at each step. What the variances alone would tell
/// of the delay is left out.
///
/// # Errors
/// When the mean response cannot be had, or the scan does not determine all
/// unknowns.
///
/// # Panics
/// If the scene has no such detector.
pub fn bound(scene: &Scene, detector: usize, tier: CountingTier) -> Result<Bound, FitError> {
    check_independent(scene, detector)?;
    TheoryEffort::of(scene, detector)?.check_bound()?;
    let model = DetectorModel::new(scene, detector);
    let response = MeanResponse::of_tier(&model, tier)?;
    let second = SecondMoments::new(&response)?;
    bound_of(
        scene,
        detector,
        tier,
        &ExpectedCounts::new(&response, &second),
    )
}

/// The bound of the scene's own counts.
pub(super) fn bound_of(
    scene: &Scene,
    detector: usize,
    tier: CountingTier,
    counts: &ExpectedCounts,
) -> Result<Bound, FitError> {
    check_independent(scene, detector)?;
    let model = counts.model();
    let light = Light::of(model);
    if light.paths.is_empty() {
        return Err(FitError::Dark);
    }
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
    let problem = Problem {
        model,
        tier,
        codes: light.paths.iter().map(|p| Arc::clone(&p.code)).collect(),
        steps: steps(scene, detector, counts),
    };
    let jacobian = problem.central_jacobian(&parameters, counts.response)?;
    let information = problem.weights_of(counts.second).information(&jacobian);
    let steps = problem.steps.len();
    let undetermined = FitError::Undetermined {
        steps,
        unknowns: parameters.len(),
    };
    let deviations = information.ok_or(undetermined)?.standard_deviations();
    let paths = model.modulated_paths().zip(deviations.chunks(2));
    Ok(Bound {
        paths: paths
            .map(|(path, deviations)| PathBound {
                path,
                bound_m: distance_m(deviations[0] * scene.chip_period_ps),
            })
            .collect(),
        steps,
    })
}

/// The steps that the model estimator would use for the scene's light.
fn steps(scene: &Scene, detector: usize, counts: &ExpectedCounts) -> Vec<Step> {
    let own = scene.detectors[detector].reference;
    let mut sources = counts
        .model()
        .modulated_paths()
        .map(|path| scene.paths[path].source);
    if sources.next() != Some(own) || sources.next().is_some() {
        return Step::all(scene.scan.steps).collect();
    }
    let peak = Step::at(first_maximum(&counts.signed()));
    window(&scene.scan, scene.samples_per_chip, peak)
}
