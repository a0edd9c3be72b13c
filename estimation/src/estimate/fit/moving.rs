//! One path that moves at a constant speed, with that speed unknown.
//!
//! The expected count of a step is that of a path at rest, averaged over the positions of the path
//! during the step: over two of them, which is exact for a cubic. Delay and speed refer to the moment
//! at which the scan passes the path ([`true_delay`]); there they are nearly uncorrelated.

use rayon::prelude::*;

use super::air;
use super::error::FitError;
use super::parameters::{DerivativeColumn, FitParameters};
use super::problem::{Problem, window};
use crate::estimate::phase::first_maximum;
use crate::estimate::{CountingTier, true_delay};
use crate::photons::DetectorModel;
use crate::response::{Light, MeanCount, MeanResponse, MeanResponseError};
use crate::scan::Step;
use crate::scene::{DetectorIndex, OtherLight, PathIndex};
use crate::sensor::Sensor;

/// Most phase steps by which a path may move within one: beyond, two positions do not stand for a
/// step's average.
pub const MOST_STEPS_MOVED: f64 = 0.25;

/// The moment that a moving path's distance refers to, from the start of a scan, if a
/// detector's only path moves enough to matter.
///
/// # Errors
/// If a path fluctuates, or several paths move.
pub fn moment_ps(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    other: OtherLight,
) -> Result<Option<f64>, FitError> {
    let model = DetectorModel::new(sensor, detector);
    let (moved_chips, limit_chips) = model.movement_in_scan();
    let scene = sensor.scene();
    let moves = |&path: &PathIndex| {
        scene.paths[path].detector == detector && scene.paths[path].movement.is_some()
    };
    let mover = PathIndex::of(&scene.paths).find(moves);
    let Some(path) = mover.filter(|_| moved_chips > limit_chips) else {
        return Ok(None);
    };
    let mut modulated = model.modulated_paths();
    let is_only = modulated.next() == Some(path) && modulated.next().is_none();
    let is_one_path = air::is_one_path(sensor, &model, other);
    let fluctuates = scene.paths[path].delay_std_ps() > 0.0;
    let is_own = scene.paths[path].source == scene.detectors[detector].reference;
    if !is_only || !is_one_path || !is_own || fluctuates {
        return Err(FitError::Moves { path });
    }
    Ok(true_delay(sensor, path, tier).at_ps)
}

impl Problem<'_> {
    /// The fastest change of the delay that a fit follows.
    pub fn most_walk(&self) -> f64 {
        MOST_STEPS_MOVED * self.clock().sample_period_chips() / self.step_chips()
    }

    fn step_chips(&self) -> f64 {
        self.model.timing.scan.integration_chips as f64
    }

    /// Chips from the moment to the middle of a step.
    fn time_chips(&self, step: Step) -> f64 {
        self.clock().chips(self.model.timing.middle_of_step_ps(step) - self.moment_ps)
    }

    /// What steps expect of a response to the light at the moment, whose delay changes.
    pub fn means_on_the_way(
        &self,
        response: &MeanResponse,
        walk: f64,
    ) -> Result<Vec<MeanCount>, MeanResponseError> {
        // Nodes of Gauss and Legendre's rule.
        let side = 0.5 * walk * self.step_chips() / 3_f64.sqrt();
        let of_step = |&step: &Step| {
            let middle = walk * self.time_chips(step);
            let at = |chips: f64| -> Result<MeanCount, MeanResponseError> {
                Ok(response.delayed(self.clock().ps(chips))?.mean_count(step))
            };
            let (early, late) = (at(middle - side)?, at(middle + side)?);
            Ok(MeanCount {
                signed: 0.5 * (early.signed + late.signed),
                total: 0.5 * (early.total + late.total),
            })
        };
        self.steps.par_iter().map(of_step).collect()
    }

    /// Derivatives by the walk, from those by the delay.
    pub fn slope_by_walk(&self, by_delay: &DerivativeColumn) -> DerivativeColumn {
        let steps = by_delay.iter().zip(&self.steps);
        let by_walk = steps.map(|(slope, &step)| {
            let time = self.time_chips(step);
            MeanCount { signed: slope.signed * time, total: slope.total * time }
        });
        by_walk.collect()
    }
}

/// The only path of a scene's detector that is taken to stand still, at some steps, and
/// how it moves.
///
/// # Errors
/// If nothing modulated reaches the detector.
pub fn of_scene<'m>(
    sensor: &Sensor,
    model: &'m DetectorModel,
    tier: CountingTier,
    steps: Vec<Step>,
    moment_ps: f64,
) -> Result<(Problem<'m>, FitParameters), FitError> {
    let light = Light::of(model);
    let lit = light.paths.first().zip(model.modulated_paths().next());
    let (_, index) = lit.ok_or(FitError::Dark)?;
    let walk = Some(sensor.scene().paths[index].delay_rate());
    let parameters = FitParameters { walk, ..FitParameters::of(&light) };
    Ok((Problem { model, tier, steps, moment_ps }, parameters))
}

/// What the steps round the peak count of a scene's path as it moves, in place of what
/// they count of one that stands still as it does at the moment.
///
/// # Errors
/// As for the mean response.
pub fn take_movement(
    sensor: &Sensor,
    response: &MeanResponse,
    tier: CountingTier,
    moment_ps: f64,
    means: &mut [MeanCount],
) -> Result<(), FitError> {
    let signed: Vec<f64> = means.iter().map(|mean| mean.signed).collect();
    let peak = Step::at(first_maximum(&signed));
    // Twice as many as a fit takes, wherever it sees the peak.
    let samples = 2 * sensor.clock().samples_per_chip;
    let steps = in_one_go(&window(&sensor.timing().scan, samples, peak), peak);
    let (problem, parameters) = of_scene(sensor, response.model(), tier, steps, moment_ps)?;
    let moving = problem.means_of(&parameters, &problem.response(&parameters)?)?;
    for (step, mean) in problem.steps.iter().zip(moving) {
        means[step.index()] = mean;
    }
    Ok(())
}

/// The steps of a window that follow each other in time: those of a peak at the end of the
/// scan, without those of the next one's beginning.
pub fn in_one_go(window: &[Step], peak: Step) -> Vec<Step> {
    let near = |step: &&Step| step.0.abs_diff(peak.0) <= window.len() as u64;
    window.iter().filter(near).copied().collect()
}
