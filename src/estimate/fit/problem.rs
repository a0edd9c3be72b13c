//! The unknowns of a fit, and what they let one expect.

use std::convert::Infallible;
use std::sync::Arc;

use super::least_squares::Weights;
use super::shared_light;
use super::template::Axis;
use crate::code::Code;
use crate::photons::DetectorModel;
use crate::response::{
    CountMoments, CountingTier, Light, LightPath, MeanCount, MeanResponse, MeanResponseError,
    SecondMoments,
};
use crate::scan::{Clock, Step};
use crate::scene::Scan;

/// Steps for derivatives: delay in chips, logarithm of a strength, and constant
/// light as a share of all light.
pub const DELAY_STEP_CHIPS: f64 = 2e-3;
const STRENGTH_STEP: f64 = 5e-3;
const CONSTANT_STEP: f64 = 5e-3;

/// Derivatives are good for steps of a fit this near: delay in chips, and shares of
/// the light.
const LINEAR_CHIPS: f64 = 1.0 / 64.0;
const LINEAR_SHARE: f64 = 0.03;

/// Scans of more steps are weighed with the second moments of few that stand for all.
const STEPS_ONE_BY_ONE: usize = 512;

/// From this many steps on, second moments of all steps of the scan at once cost
/// less than step by step.
const STEPS_FOR_SCAN_MOMENTS: usize = 60;

/// The unknowns: delay and ln(strength) of each path, and the background.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    pub paths: Vec<PathParameters>,
    /// Background per chip.
    pub constant: f64,
}

/// The unknowns of one path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathParameters {
    pub delay_chips: f64,
    /// Logarithm of what an on-chip adds to the primary rate per chip.
    pub ln_rate: f64,
}

/// A detector, codes, and the steps that take part.
#[derive(Debug, Clone)]
pub struct Problem<'m> {
    pub model: &'m DetectorModel,
    pub tier: CountingTier,
    /// The code of each path.
    pub codes: Vec<Arc<Code>>,
    /// Numbers of the steps in the scan, ascending.
    pub steps: Vec<Step>,
}

/// Derivatives of every step's means by one unknown.
pub type Column = Vec<MeanCount>;

/// 3 S steps round a peak, or what the scan has of them.
pub fn window(scan: &Scan, samples_per_chip: u32, peak: Step) -> Vec<Step> {
    let half = (3 * i64::from(samples_per_chip)).div_euclid(2).max(3);
    let (peak, steps) = (peak.0 as i64, scan.steps as i64);
    let mut window: Vec<Step> = if scan.is_full() {
        let half = half.min(steps / 2);
        (peak - half..peak + half)
            .map(|s| Step(s.rem_euclid(steps) as u64))
            .collect()
    } else {
        ((peak - half).max(0)..(peak + half).min(steps))
            .map(|s| Step(s as u64))
            .collect()
    };
    window.sort_unstable();
    window
}

impl Parameters {
    /// Number of unknowns.
    pub fn len(&self) -> usize {
        2 * self.paths.len() + 1
    }

    /// All unknowns moved by `share` of a step. Background stays at or above
    /// zero, strengths within e^2 of what they were, delays within half a chip.
    pub fn moved(&self, step: &[f64], share: f64) -> Parameters {
        let mut moved = self.clone();
        for (path, step) in moved.paths.iter_mut().zip(step.chunks(2)) {
            path.delay_chips += (share * step[0]).clamp(-0.5, 0.5);
            path.ln_rate += (share * step[1]).clamp(-2.0, 2.0);
        }
        moved.constant = (self.constant + share * step[step.len() - 1]).max(0.0);
        moved
    }

    /// The differences of all unknowns.
    pub fn minus(&self, other: &Parameters) -> Vec<f64> {
        let pairs = self.paths.iter().zip(&other.paths);
        let mut differences: Vec<f64> = pairs
            .flat_map(|(a, b)| [a.delay_chips - b.delay_chips, a.ln_rate - b.ln_rate])
            .collect();
        differences.push(self.constant - other.constant);
        differences
    }

    /// Whether derivatives at `other` are too far off for a fit that is here.
    pub fn differ_from(&self, other: &Parameters) -> bool {
        let differences = self.minus(other);
        let (constant, paths) = differences.split_last().unwrap_or((&0.0, &[]));
        let far = |path: &[f64]| path[0].abs() > LINEAR_CHIPS || path[1].abs() > LINEAR_SHARE;
        paths.chunks(2).any(far) || constant.abs() > LINEAR_SHARE * self.brightest()
    }

    /// Adds a path, whose mean is taken from the background.
    pub fn add_path(&mut self, path: PathParameters, problem: &Problem) {
        if let Some(code) = problem.codes.get(self.paths.len()) {
            let mean = path.ln_rate.exp() * code.weight() as f64 / code.len() as f64;
            self.constant = (self.constant - mean).max(0.1 * self.constant);
        }
        self.paths.push(path);
    }

    /// Whether unknown number `index` is a delay.
    fn is_delay(&self, index: usize) -> bool {
        index < 2 * self.paths.len() && index.is_multiple_of(2)
    }

    /// Everything that shines, per chip.
    pub fn brightest(&self) -> f64 {
        self.constant + self.paths.iter().map(|p| p.ln_rate.exp()).sum::<f64>()
    }

    /// Unknown number `index` moved by `sign` times its step for derivatives,
    /// and that step.
    pub fn nudged(&self, index: usize, sign: f64) -> (Parameters, f64) {
        let mut nudged = self.clone();
        let step = match nudged.paths.get_mut(index / 2) {
            Some(path) if index.is_multiple_of(2) => {
                path.delay_chips += sign * DELAY_STEP_CHIPS;
                DELAY_STEP_CHIPS
            }
            Some(path) => {
                path.ln_rate += sign * STRENGTH_STEP;
                STRENGTH_STEP
            }
            None => {
                let step = CONSTANT_STEP * self.brightest();
                nudged.constant += sign * step;
                step
            }
        };
        (nudged, sign * step)
    }
}

impl<'m> Problem<'m> {
    pub fn clock(&self) -> Clock {
        self.model.timing.clock
    }

    /// Samples per chip, S.
    pub fn samples_per_chip(&self) -> f64 {
        f64::from(self.model.timing.clock.samples_per_chip)
    }

    /// The light that the unknowns stand for.
    pub fn light(&self, parameters: &Parameters) -> Light {
        let paths = parameters.paths.iter().zip(&self.codes);
        Light {
            paths: paths
                .map(|(path, code)| LightPath {
                    code: Arc::clone(code),
                    rate_per_chip: path.ln_rate.exp(),
                    delay_chips: path.delay_chips,
                    shape: self.model.shape_of(code),
                })
                .collect(),
            constant_per_chip: parameters.constant,
        }
    }

    /// The response to the light that the unknowns stand for.
    pub fn response(&self, parameters: &Parameters) -> Result<MeanResponse<'m>, MeanResponseError> {
        MeanResponse::to_light(self.model, self.light(parameters), self.tier)
    }

    /// Expected counts of the steps that take part.
    pub fn means(&self, parameters: &Parameters) -> Result<Vec<MeanCount>, MeanResponseError> {
        Ok(self.means_of(&self.response(parameters)?))
    }

    /// Expected counts of the steps that take part.
    pub fn means_of(&self, response: &MeanResponse) -> Vec<MeanCount> {
        if self.takes_all_steps() {
            return response.mean_counts();
        }
        self.steps.iter().map(|&s| response.mean_count(s)).collect()
    }

    /// The same with what is left of whole code periods on average.
    pub fn means_on_average(&self, response: &MeanResponse) -> Vec<MeanCount> {
        match self.takes_all_steps() {
            true => response.mean_counts_on_average(),
            false => self.means_of(response),
        }
    }

    /// Derivatives by every unknown of what is expected [on
    /// average](Self::means_on_average); `response` is that at `parameters`.
    pub fn jacobian_on_average(
        &self,
        parameters: &Parameters,
        response: &MeanResponse,
    ) -> Result<Vec<Column>, MeanResponseError> {
        let here = self.means_on_average(response);
        let at = |parameters: &Parameters| -> Result<Vec<MeanCount>, MeanResponseError> {
            Ok(self.means_on_average(&self.response(parameters)?))
        };
        (0..parameters.len())
            .map(|index| {
                let (above, up) = parameters.nudged(index, 1.0);
                if !parameters.is_delay(index) {
                    return Ok(slope(&here, &at(&above)?, up));
                }
                // From both sides, or a fit that stands on the tip of a peak would not
                // see the other side of it.
                let (below, down) = parameters.nudged(index, -1.0);
                Ok(slope(&at(&below)?, &at(&above)?, up - down))
            })
            .collect()
    }

    /// How often a fit makes its weights. Those of steps that count the same light depend
    /// on where between two steps the light's edges are.
    pub fn most_weighings(&self) -> usize {
        if self.shares_light() { 4 } else { 1 }
    }

    /// Whether second moments of few steps stand for those of all.
    pub fn is_long(&self) -> bool {
        self.steps.len() > STEPS_ONE_BY_ONE
    }

    /// Whether no step of the scan is left out.
    pub fn takes_all_steps(&self) -> bool {
        self.steps.len() as u64 == self.model.timing.scan.steps
    }

    /// Derivatives by every unknown; `response` and `means` are those at
    /// `parameters`. Good for steps of a fit: by strengths and background they are
    /// one-sided, of one more solution each. By delays they are from both sides, or a
    /// fit that stands on the tip of a peak would not see the other side of it.
    pub fn jacobian(
        &self,
        parameters: &Parameters,
        response: &MeanResponse,
        means: &[MeanCount],
    ) -> Result<Vec<Column>, MeanResponseError> {
        (0..parameters.len())
            .map(|index| {
                if parameters.is_delay(index) {
                    return self.central_slope(parameters, response, index);
                }
                let (nudged, step) = parameters.nudged(index, 1.0);
                Ok(slope(means, &self.means(&nudged)?, step))
            })
            .collect()
    }

    /// Derivatives by every unknown, from both sides; `response` is that at
    /// `parameters`.
    pub fn central_jacobian(
        &self,
        parameters: &Parameters,
        response: &MeanResponse,
    ) -> Result<Vec<Column>, MeanResponseError> {
        (0..parameters.len())
            .map(|index| self.central_slope(parameters, response, index))
            .collect()
    }

    fn central_slope(
        &self,
        parameters: &Parameters,
        response: &MeanResponse,
        index: usize,
    ) -> Result<Column, MeanResponseError> {
        if parameters.paths.len() == 1 && parameters.is_delay(index) {
            // All light earlier or later at once: the same solution, read off there.
            let at = |by: f64| -> Result<Vec<MeanCount>, MeanResponseError> {
                Ok(self.means_of(&response.delayed(self.clock().ps(by))?))
            };
            let (below, above) = (at(-DELAY_STEP_CHIPS)?, at(DELAY_STEP_CHIPS)?);
            return Ok(slope(&below, &above, 2.0 * DELAY_STEP_CHIPS));
        }
        let (above, up) = parameters.nudged(index, 1.0);
        let (below, down) = parameters.nudged(index, -1.0);
        Ok(slope(&self.means(&below)?, &self.means(&above)?, up - down))
    }

    /// Places on the axis at which the detector's own code peaks.
    pub fn own_peaks(&self, parameters: &Parameters, axis: &Axis) -> Vec<f64> {
        let reference = &self.model.reference.chips;
        let paths = self.codes.iter().zip(&parameters.paths);
        paths
            .filter(|(code, _)| &code.chips == reference)
            .map(|(_, path)| axis.place_of(path.delay_chips))
            .collect()
    }

    /// Inverse covariances of the steps' counts, from their second moments; `parameters`
    /// and `means` are those of their light.
    pub fn weights_of(
        &self,
        second: &SecondMoments,
        parameters: &Parameters,
        means: &[MeanCount],
        axis: &Axis,
    ) -> Weights {
        if self.shares_light() && self.is_long() {
            let peaks = self.own_peaks(parameters, axis);
            let of_few = |few: &Problem| Ok::<_, Infallible>(few.shared_steps(second).into());
            return match shared_light::weights_of_scan(self, axis, &peaks, means, of_few) {
                Ok(weights) => weights,
                Err(never) => match never {},
            };
        }
        match self.shares_light() {
            true => Weights::of_groups(&self.shared_steps(second)),
            false => Weights::of(&self.moments_of(second)),
        }
    }

    /// Moments of the steps' counts.
    pub fn moments(&self, response: &MeanResponse) -> Result<Vec<CountMoments>, MeanResponseError> {
        Ok(self.moments_of(&SecondMoments::new(response)?))
    }

    fn moments_of(&self, second: &SecondMoments) -> Vec<CountMoments> {
        if self.takes_all_steps() && self.steps.len() > STEPS_FOR_SCAN_MOMENTS {
            second.of_scan()
        } else {
            second.of_steps(&self.steps)
        }
    }
}

/// Differences of counts over a step of an unknown.
pub fn slope(from: &[MeanCount], to: &[MeanCount], step: f64) -> Column {
    from.iter()
        .zip(to)
        .map(|(a, b)| MeanCount {
            signed: (b.signed - a.signed) / step,
            total: (b.total - a.total) / step,
        })
        .collect()
}
