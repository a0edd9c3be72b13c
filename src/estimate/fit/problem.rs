//! What the unknowns of a fit let one expect.

use std::sync::Arc;

use super::parameters::{Column, DELAY_STEP_CHIPS, Parameters, slope};
use super::template::Axis;
use crate::code::Code;
use crate::photons::DetectorModel;
use crate::response::{CountingTier, Light, LightPath, MeanCount, MeanResponse, MeanResponseError};
use crate::scan::{Clock, Step};
use crate::scene::Scan;

/// Scans of more steps are weighed with the second moments of few that stand for all.
pub const STEPS_ONE_BY_ONE: usize = 512;

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

/// 3 S steps round a peak, or what the scan has of them.
pub fn window(scan: &Scan, samples_per_chip: u32, peak: Step) -> Vec<Step> {
    let half = (3 * i64::from(samples_per_chip)).div_euclid(2).max(3);
    let (peak, steps) = (peak.0 as i64, scan.steps as i64);
    let mut window: Vec<Step> = if scan.is_full() {
        let half = half.min(steps / 2);
        (peak - half..peak + half).map(|s| Step(s.rem_euclid(steps) as u64)).collect()
    } else {
        ((peak - half).max(0)..(peak + half).min(steps)).map(|s| Step(s as u64)).collect()
    };
    window.sort_unstable();
    window
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

    /// Whether several steps count the same light.
    pub fn shares_light(&self) -> bool {
        self.model.timing.parallel > 1
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
        (0..parameters.len()).map(|index| self.central_slope(parameters, response, index)).collect()
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

    /// The place of a step of the scan on the axis.
    pub fn place_of(&self, step: Step, axis: &Axis) -> f64 {
        axis.place_of_phase_step(self.model.timing.scan.phase_step(step))
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
}
