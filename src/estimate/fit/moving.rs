//! One path that moves at a constant speed, fitted with that speed unknown.
//!
//! A step expects what it would of a path that stands still, averaged over where the path
//! is during the step: at two places, which is exact for a cubic. Delay and speed are told
//! of one moment, that at which the scan comes by the path ([`true_delay`]); there they
//! hardly know of each other.

use std::sync::Arc;

use rayon::prelude::*;

use super::candidates;
use super::error::FitError;
use super::gauss_newton::{CONVERGED_SIGMAS, MOST_ITERATIONS};
use super::known_moments::KnownMoments;
use super::model_estimate::{FittedPath, ModelEstimate, Velocity};
use super::normal::Normal;
use super::parameters::{Column, DELAY_STEP_CHIPS, Parameters, PathParameters, slope};
use super::problem::{Problem, window};
use super::weights::Weights;
use crate::estimate::phase::first_maximum;
use crate::estimate::{CountingTier, distance_m, true_delay};
use crate::photons::DetectorModel;
use crate::response::{Light, MeanCount, MeanResponse, MeanResponseError};
use crate::scan::Step;
use crate::scene::{DetectorIndex, OtherLight, PathIndex};
use crate::sensor::Sensor;

/// Most phase steps by which a path may move within one: beyond, a step's average
/// over its places is not that of two.
const MOST_STEPS_MOVED: f64 = 0.25;

/// Shares of a step that are tried where the whole makes matters worse.
const SHARES: [f64; 5] = [1.0, 0.4, 0.16, 0.06, 0.02];

/// The moment that a moving path's distance is told of, from the start of a scan, if a
/// detector's only path moves enough to matter.
///
/// # Errors
/// Where paths move otherwise than at a constant speed, or several do.
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
    let is_one_path = candidates::is_one_path(sensor, detector, other);
    let fluctuates = scene.paths[path].delay_std_ps() > 0.0;
    let is_own = scene.paths[path].source == scene.detectors[detector].reference;
    if !is_only || !is_one_path || !is_own || fluctuates {
        return Err(FitError::Moves { path });
    }
    Ok(true_delay(sensor, path, tier).at_ps)
}

/// The unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course {
    /// Time of flight at the moment.
    pub delay_chips: f64,
    /// Its change per time, 2 v / c.
    pub walk: f64,
    /// Logarithm of what an on-chip adds to the primary rate per chip.
    pub ln_rate: f64,
    /// Background per chip.
    pub constant: f64,
}

impl Course {
    /// Number of unknowns.
    const UNKNOWNS: usize = 4;

    /// Of a path that stands still.
    pub fn still(parameters: &Parameters) -> Option<Course> {
        let path = parameters.paths.first()?;
        Some(Course {
            delay_chips: path.delay_chips,
            walk: 0.0,
            ln_rate: path.ln_rate,
            constant: parameters.constant,
        })
    }

    /// The light at the moment.
    pub fn parameters(&self) -> Parameters {
        Parameters {
            paths: vec![PathParameters { delay_chips: self.delay_chips, ln_rate: self.ln_rate }],
            constant: self.constant,
        }
    }

    fn minus(&self, other: &Course) -> [f64; Course::UNKNOWNS] {
        [
            self.delay_chips - other.delay_chips,
            self.walk - other.walk,
            self.ln_rate - other.ln_rate,
            self.constant - other.constant,
        ]
    }
}

/// The steps round the peak of a path that moves.
pub struct MovingPath<'p, 'm> {
    /// Detector, code and steps, as if the path stood still.
    still: &'p Problem<'m>,
    /// Chips from the moment to the middle of each step.
    times_chips: Vec<f64>,
    /// Chips of a step.
    step_chips: f64,
    moment_ps: f64,
}

/// A finished fit.
struct Fitted {
    course: Course,
    normal: Normal,
    chi_square: f64,
    values: usize,
    iterations: usize,
}

impl<'p, 'm> MovingPath<'p, 'm> {
    pub fn new(still: &'p Problem<'m>, moment_ps: f64) -> MovingPath<'p, 'm> {
        let timing = &still.model.timing;
        let time = |&step: &Step| timing.clock.chips(timing.middle_of_step_ps(step) - moment_ps);
        MovingPath {
            times_chips: still.steps.iter().map(time).collect(),
            step_chips: timing.scan.integration_chips as f64,
            still,
            moment_ps,
        }
    }

    /// Expected counts of the steps.
    pub fn means(&self, course: &Course) -> Result<Vec<MeanCount>, MeanResponseError> {
        let response = self.still.response(&course.parameters())?;
        self.means_of(&response, course.walk, 0.0)
    }

    /// Derivatives by every unknown; `means` are those at `course`.
    pub fn jacobian(
        &self,
        course: &Course,
        means: &[MeanCount],
    ) -> Result<Vec<Column>, MeanResponseError> {
        let response = self.still.response(&course.parameters())?;
        let nudged = |by: f64| self.means_of(&response, course.walk, by);
        let (below, above) = (nudged(-DELAY_STEP_CHIPS)?, nudged(DELAY_STEP_CHIPS)?);
        let by_delay = slope(&below, &above, 2.0 * DELAY_STEP_CHIPS);
        let by_walk = by_delay.iter().zip(&self.times_chips);
        let by_walk = by_walk.map(|(slope, time)| MeanCount {
            signed: slope.signed * time,
            total: slope.total * time,
        });
        let mut columns = vec![by_delay.clone(), by_walk.collect()];
        let here = course.parameters();
        // Strength and background.
        for unknown in 1..here.len() {
            let (there, step) = here.nudged(unknown, 1.0);
            let there = self.means_of(&self.still.response(&there)?, course.walk, 0.0)?;
            columns.push(slope(means, &there, step));
        }
        Ok(columns)
    }

    /// What steps expect of a response to the light at the moment, `later` by some chips.
    fn means_of(
        &self,
        response: &MeanResponse,
        walk: f64,
        later: f64,
    ) -> Result<Vec<MeanCount>, MeanResponseError> {
        // Nodes of Gauss and Legendre's rule.
        let side = 0.5 * walk * self.step_chips / 3_f64.sqrt();
        let steps = self.still.steps.par_iter().zip(&self.times_chips);
        steps
            .map(|(&step, time)| {
                let middle = later + walk * time;
                let at = |chips: f64| -> Result<MeanCount, MeanResponseError> {
                    let delayed = response.delayed(self.still.clock().ps(chips))?;
                    Ok(delayed.mean_count(step))
                };
                let (early, late) = (at(middle - side)?, at(middle + side)?);
                Ok(MeanCount {
                    signed: 0.5 * (early.signed + late.signed),
                    total: 0.5 * (early.total + late.total),
                })
            })
            .collect()
    }

    /// The fit to one count per step of the problem, and what it says.
    pub fn fit(
        &self,
        known: &KnownMoments,
        start: Course,
        measured: &[MeanCount],
    ) -> Result<ModelEstimate, FitError> {
        let fitted = self.descend(known, start, measured)?;
        let limit = self.most_walk();
        if fitted.course.walk.abs() >= 0.999 * limit {
            return Err(FitError::TooFast { limit_m_per_s: distance_m(1e12 * limit) });
        }
        Ok(self.estimate(&fitted))
    }

    /// Gauss-Newton, with shorter steps where a full one makes matters worse: first with
    /// the weights of a Poisson process, then with those of this detector.
    fn descend(
        &self,
        known: &KnownMoments,
        start: Course,
        measured: &[MeanCount],
    ) -> Result<Fitted, FitError> {
        let undetermined =
            || FitError::Undetermined { steps: measured.len(), unknowns: Course::UNKNOWNS };
        if 2 * measured.len() <= Course::UNKNOWNS {
            return Err(undetermined());
        }
        let mut course = start;
        let mut expected = self.means(&course)?;
        let mut weights = Weights::of_poisson(&expected);
        let mut is_reweighted = false;
        for iteration in 1..=MOST_ITERATIONS {
            let jacobian = self.jacobian(&course, &expected)?;
            let normal = weights.normal(&jacobian, measured, &expected).ok_or_else(undetermined)?;
            let chi_square = weights.chi_square(measured, &expected);
            let next = self.downwards(&normal, &course, chi_square, &weights, measured);
            let (moved, fell) = match next {
                None => (0.0, 0.0),
                Some((next, means)) => {
                    let moved = normal.largest_step_sigmas(&next.minus(&course));
                    (course, expected) = (next, means);
                    (moved, chi_square - weights.chi_square(measured, &expected))
                }
            };
            if !is_reweighted && moved < 1.0 {
                is_reweighted = true;
                weights = known.weights(self.still, &course.parameters(), &expected)?;
            } else if moved < CONVERGED_SIGMAS || fell < CONVERGED_SIGMAS * CONVERGED_SIGMAS {
                return Ok(Fitted {
                    chi_square: weights.chi_square(measured, &expected),
                    values: weights.values(),
                    course,
                    normal,
                    iterations: iteration,
                });
            }
        }
        Err(FitError::NotConverged { steps: MOST_ITERATIONS })
    }

    /// A step that does not make chi-square worse, with what is expected there; `None`
    /// where no way leads down.
    fn downwards(
        &self,
        normal: &Normal,
        course: &Course,
        chi_square: f64,
        weights: &Weights,
        measured: &[MeanCount],
    ) -> Option<(Course, Vec<MeanCount>)> {
        let mut full = normal.solution();
        if course.constant + full[3] < 0.0 {
            // There is no less than no background.
            full = normal.solution_with_last(-course.constant);
        }
        SHARES.iter().find_map(|&share| {
            let tried = self.moved(course, &full, share);
            // A step of few counts may lead to light that has no response.
            let means = self.means(&tried).ok()?;
            let found = weights.chi_square(measured, &means);
            (found < chi_square).then_some((tried, means))
        })
    }

    /// All unknowns moved by `share` of a step, each within reason.
    fn moved(&self, course: &Course, step: &[f64], share: f64) -> Course {
        let limit = self.most_walk();
        Course {
            delay_chips: course.delay_chips + (share * step[0]).clamp(-0.5, 0.5),
            walk: (course.walk + share * step[1]).clamp(-limit, limit),
            ln_rate: course.ln_rate + (share * step[2]).clamp(-2.0, 2.0),
            constant: (course.constant + share * step[3]).max(0.0),
        }
    }

    /// The fastest change of the delay that a fit follows.
    fn most_walk(&self) -> f64 {
        MOST_STEPS_MOVED * self.still.model.timing.clock.sample_period_chips() / self.step_chips
    }

    fn estimate(&self, fitted: &Fitted) -> ModelEstimate {
        let clock = self.still.clock();
        let std = fitted.normal.standard_deviations();
        let code = &self.still.codes[0];
        let course = &fitted.course;
        let path = FittedPath {
            code: Arc::clone(code),
            delay_ps: clock.ps(course.delay_chips.rem_euclid(code.len() as f64)),
            delay_std_ps: clock.ps(std[0]),
            rate_hz: clock.hz(course.ln_rate.exp()),
            rate_relative_std: std[2],
        };
        ModelEstimate {
            delay_ps: path.delay_ps,
            distance_m: distance_m(path.delay_ps),
            std_m: distance_m(path.delay_std_ps),
            velocity: Some(Velocity {
                m_per_s: distance_m(1e12 * course.walk),
                std_m_per_s: distance_m(1e12 * std[1]),
                at_s: self.moment_ps * 1e-12,
            }),
            paths: vec![path],
            constant_rate_hz: clock.hz(course.constant),
            chi_square: fitted.chi_square,
            degrees_of_freedom: fitted.values.saturating_sub(Course::UNKNOWNS),
            steps: self.still.steps.len(),
            untold: None,
            iterations: fitted.iterations,
        }
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
) -> Result<(Problem<'m>, Course), FitError> {
    let light = Light::of(model);
    let lit = light.paths.first().zip(model.modulated_paths().next());
    let (path, index) = lit.ok_or(FitError::Dark)?;
    let course = Course {
        delay_chips: path.delay_chips,
        walk: sensor.scene().paths[index].delay_rate(),
        ln_rate: path.rate_per_chip.ln(),
        constant: light.constant_per_chip,
    };
    let problem = Problem { model, tier, codes: vec![Arc::clone(&path.code)], steps };
    Ok((problem, course))
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
    let (problem, course) = of_scene(sensor, response.model(), tier, steps)?;
    let moving = MovingPath::new(&problem, moment_ps).means(&course)?;
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
