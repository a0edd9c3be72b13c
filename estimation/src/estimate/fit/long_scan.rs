//! What the counts of many steps at once weigh: second moments of few of them stand for all.
//!
//! Within a chip and a half of the own code's peaks they are taken step by step. Elsewhere the
//! reference's signs are as good as random beside the light, and moments per detection depend
//! on where in a chip the reference's edges are, and hardly on the chip.

use std::sync::Arc;

use super::problem::Problem;
use super::template::Axis;
use super::weights::Weights;
use crate::response::{CountMoments, MeanCount};
use crate::scan::Step;

/// Chips to either side of a peak in which moments are taken step by step.
pub const REACH_CHIPS: f64 = 1.5;
/// Steps elsewhere whose moments are taken, at least, and of each phase of a chip.
const STEPS_AWAY: usize = 12;
const STEPS_OF_PHASE: usize = 2;
/// Phases of a chip that are told apart.
const MOST_PHASES: usize = 8;

/// Second moments of one step's counts, per expected detection.
#[derive(Debug, Clone, Copy)]
pub struct PerDetection {
    signed_mean: f64,
    signed_variance: f64,
    total_variance: f64,
    covariance: f64,
}

impl PerDetection {
    /// Those of a step with some moments.
    pub fn from_moments(moments: &CountMoments) -> PerDetection {
        let detections = moments.total_mean.max(f64::MIN_POSITIVE);
        PerDetection {
            signed_mean: moments.signed_mean / detections,
            signed_variance: moments.signed_variance / detections,
            total_variance: moments.total_variance / detections,
            covariance: moments.covariance / detections,
        }
    }

    /// Moments of a step that expects `mean`: what r shares with N goes with r as N's
    /// variance goes with N.
    pub fn of(&self, mean: &MeanCount) -> CountMoments {
        let more = mean.signed - self.signed_mean * mean.total;
        CountMoments {
            signed_mean: mean.signed,
            total_mean: mean.total,
            signed_variance: self.signed_variance * mean.total,
            total_variance: self.total_variance * mean.total,
            covariance: self.covariance * mean.total + self.total_variance * more,
        }
    }

    fn mean(all: &[PerDetection]) -> PerDetection {
        let mean =
            |of: &dyn Fn(&PerDetection) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
        PerDetection {
            signed_mean: mean(&|m| m.signed_mean),
            signed_variance: mean(&|m| m.signed_variance),
            total_variance: mean(&|m| m.total_variance),
            covariance: mean(&|m| m.covariance),
        }
    }
}

/// Steps whose moments stand for those of all.
struct Few {
    steps: Vec<Step>,
    /// Of each step of the problem: which of the steps, or which phase of a chip.
    sources: Vec<Source>,
    /// Of each phase, its steps.
    of_phases: Vec<Vec<usize>>,
}

enum Source {
    Itself(usize),
    Phase(usize),
}

impl Few {
    /// `peaks` are the places of the own code's on the axis.
    fn of(problem: &Problem, axis: &Axis, peaks: &[f64]) -> Few {
        let scan = &problem.model.timing.scan;
        let samples = axis.samples_per_chip as usize;
        let phases = samples.min(MOST_PHASES);
        let phase_of = |step: Step| scan.phase_step(step) as usize % samples * phases / samples;
        let is_near = |step: Step| {
            let place = problem.place_of(step, axis);
            let reach = REACH_CHIPS * axis.samples_per_chip;
            peaks.iter().any(|peak| axis.steps_apart(place - peak) <= reach)
        };
        let mut few = Few { steps: Vec::new(), sources: Vec::new(), of_phases: Vec::new() };
        let mut away = vec![Vec::new(); phases];
        for &step in &problem.steps {
            let phase = phase_of(step);
            few.sources.push(if is_near(step) {
                few.steps.push(step);
                Source::Itself(few.steps.len() - 1)
            } else {
                away[phase].push(step);
                Source::Phase(phase)
            });
        }
        let wanted = STEPS_AWAY.div_ceil(phases).max(STEPS_OF_PHASE);
        for of_phase in away {
            let count = wanted.min(of_phase.len());
            let spread =
                (0..count).map(|part| of_phase[(2 * part + 1) * of_phase.len() / (2 * count)]);
            few.of_phases.push((few.steps.len()..few.steps.len() + count).collect());
            few.steps.extend(spread);
        }
        few
    }
}

/// Weights of a long scan, whose steps count light of their own. `peaks` are the places of
/// the own code's on the axis, `added` is a variance that every signed count has beside that
/// of its light, and `moments` gives those of a problem of few steps.
pub fn weights_of_scan<E>(
    problem: &Problem,
    axis: &Axis,
    peaks: &[f64],
    means: &[MeanCount],
    added: f64,
    moments: impl FnOnce(&Problem) -> Result<Arc<[PerDetection]>, E>,
) -> Result<Weights, E> {
    let Few { steps, sources, of_phases } = Few::of(problem, axis, peaks);
    let known = moments(&Problem { steps, ..problem.clone() })?;
    let mean_of = |steps: &Vec<usize>| {
        PerDetection::mean(&steps.iter().map(|&step| known[step]).collect::<Vec<_>>())
    };
    let of_phases: Vec<PerDetection> = of_phases.iter().map(mean_of).collect();
    let all = sources.iter().zip(means).map(|(source, mean)| {
        let moments = match *source {
            Source::Itself(step) => known[step].of(mean),
            Source::Phase(phase) => of_phases[phase].of(mean),
        };
        CountMoments { signed_variance: moments.signed_variance + added, ..moments }
    });
    Ok(Weights::of(&all.collect::<Vec<_>>()))
}

/// How many steps' moments stand for a long scan's, with so many own peaks.
pub fn few_steps(samples_per_chip: f64, peaks: f64) -> f64 {
    let phases = samples_per_chip.min(MOST_PHASES as f64);
    let away = (STEPS_AWAY as f64).max(phases * STEPS_OF_PHASE as f64);
    peaks * (2.0 * REACH_CHIPS * samples_per_chip + 1.0) + away
}
