//! Expected counts as functions of the unknowns of a fit.

use std::sync::Arc;

use super::error::FitError;
use super::parameters::{DELAY_STEP_CHIPS, DerivativeColumn, FitParameters, PathParameters, slope};
use super::template::DelayAxis;
use crate::estimate::unwrap::tolerance_ps;
use crate::photons::DetectorModel;
use crate::response::{CountingTier, Light, LightPath, MeanCount, MeanResponse, MeanResponseError};
use crate::scan::{Clock, Step};
use crate::scene::Scan;

/// Scans of more steps are weighed with the second moments of few that stand for all.
pub const STEPS_ONE_BY_ONE: usize = 512;

/// Most often that a fit makes its weights.
pub const MOST_WEIGHINGS: usize = 4;

/// A detector, and the steps that take part.
#[derive(Debug, Clone)]
pub struct Problem<'m> {
    pub model: &'m DetectorModel,
    pub tier: CountingTier,
    /// Numbers of the steps in the scan, ascending.
    pub steps: Vec<Step>,
    /// The moment that the delay of a moving path refers to, from the start of the scan.
    pub moment_ps: f64,
}

/// How expected counts are read off a response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResponseReading {
    /// As they are.
    Exact,
    /// With what is left of whole code periods on average.
    OnAverage,
}

/// Responses to light of which one unknown is a little less, and a little more.
pub struct NeighbouringResponses<'m> {
    below: MeanResponse<'m>,
    above: MeanResponse<'m>,
    /// How far apart the two are.
    apart: f64,
    /// The response that counts their difference, by how far apart they are.
    slope: MeanResponse<'m>,
}

impl<'m> NeighbouringResponses<'m> {
    fn new(
        below: MeanResponse<'m>,
        above: MeanResponse<'m>,
        apart: f64,
    ) -> NeighbouringResponses<'m> {
        NeighbouringResponses { slope: above.less(&below, 1.0 / apart), below, above, apart }
    }

    /// The same for another integration time.
    pub fn counted_by<'n>(&self, model: &'n DetectorModel) -> NeighbouringResponses<'n> {
        let [below, above, slope] =
            [&self.below, &self.above, &self.slope].map(|side| side.counted_by(model));
        NeighbouringResponses { below, above, apart: self.apart, slope }
    }
}

/// Sides from which derivatives are taken. Those by delays are from both in any case, or a fit
/// that stands on the tip of a peak would not see the other side of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sides {
    /// Of one more solution for each unknown.
    One,
    Both,
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
    /// All steps of a scan.
    pub fn of_scan(model: &'m DetectorModel, tier: CountingTier) -> Problem<'m> {
        let steps = Step::all(model.timing.scan.steps).collect();
        Problem { model, tier, steps, moment_ps: 0.0 }
    }

    pub fn clock(&self) -> Clock {
        self.model.timing.clock
    }

    /// Samples per chip, S.
    pub fn samples_per_chip(&self) -> f64 {
        f64::from(self.model.timing.clock.samples_per_chip)
    }

    /// How far off an estimate may be that has [found](crate::estimate::missed) the detector's own path. Of a code so short that
    /// errors wrap all count for it.
    pub fn found_within_chips(&self) -> f64 {
        let clock = self.clock();
        let period_ps = clock.ps(self.model.reference.len() as f64);
        let found_ps = tolerance_ps(clock.chip_period_ps, period_ps);
        if found_ps < clock.chip_period_ps { f64::INFINITY } else { clock.chips(found_ps) }
    }

    /// The light that the unknowns stand for.
    pub fn light(&self, parameters: &FitParameters) -> Light {
        let path = |path: &PathParameters| LightPath {
            code: Arc::clone(&path.code),
            rate_per_chip: path.rate(),
            delay_chips: path.delay_chips,
            shape: self.model.shape_of(&path.code),
        };
        Light {
            paths: parameters.paths.iter().map(path).collect(),
            constant_per_chip: parameters.constant,
        }
    }

    /// The response to the light that the unknowns stand for.
    pub fn response(
        &self,
        parameters: &FitParameters,
    ) -> Result<MeanResponse<'m>, MeanResponseError> {
        MeanResponse::to_light(self.model, self.light(parameters), self.tier)
    }

    /// Expected counts of the steps that take part, from the response to the light.
    pub fn means_of(
        &self,
        parameters: &FitParameters,
        response: &MeanResponse,
    ) -> Result<Vec<MeanCount>, MeanResponseError> {
        if let Some(walk) = parameters.walk {
            return self.means_on_the_way(response, walk);
        }
        if self.takes_all_steps() {
            return Ok(response.mean_counts());
        }
        Ok(self.steps.iter().map(|&s| response.mean_count(s)).collect())
    }

    /// The same, read as `reading` says.
    pub fn means_read(
        &self,
        parameters: &FitParameters,
        response: &MeanResponse,
        reading: ResponseReading,
    ) -> Result<Vec<MeanCount>, MeanResponseError> {
        match reading == ResponseReading::OnAverage && self.takes_all_steps() {
            true => Ok(response.mean_counts_on_average()),
            false => self.means_of(parameters, response),
        }
    }

    /// How often a fit makes its weights of nearly the same light. Those of steps that count the
    /// same light depend on where between two steps its edges are.
    pub fn most_weighings(&self) -> usize {
        if self.shares_light() { MOST_WEIGHINGS } else { 1 }
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

    /// Derivatives of the expected counts by every unknown; `response` is that at `parameters`.
    pub fn jacobian(
        &self,
        parameters: &FitParameters,
        response: &MeanResponse<'m>,
        reading: ResponseReading,
        sides: Sides,
    ) -> Result<Vec<DerivativeColumn>, MeanResponseError> {
        let of = |response: &MeanResponse| self.means_read(parameters, response, reading);
        let here = (sides == Sides::One).then(|| of(response)).transpose()?;
        let mut columns: Vec<DerivativeColumn> = Vec::with_capacity(parameters.len());
        for index in 0..parameters.len() {
            let column = if parameters.walk_index() == Some(index) {
                self.slope_by_walk(&columns[0])
            } else {
                match &here {
                    Some(here) if !parameters.is_delay(index) => {
                        let (above, up) = parameters.nudged(index, 1.0);
                        slope(here, &of(&self.response(&above)?)?, up)
                    }
                    _ => {
                        let beside = self.beside(parameters, response, index)?;
                        self.slope_between(parameters, &beside, reading)?
                    }
                }
            };
            columns.push(column);
        }
        Ok(columns)
    }

    /// Responses on both sides of an unknown other than the walk; `response` is that at `parameters`.
    pub fn beside(
        &self,
        parameters: &FitParameters,
        response: &MeanResponse<'m>,
        index: usize,
    ) -> Result<NeighbouringResponses<'m>, MeanResponseError> {
        if parameters.paths.len() == 1 && parameters.is_delay(index) {
            // All light earlier or later at once: the same solution, read off there.
            let delayed = |by: f64| response.delayed(self.clock().ps(by));
            let step = DELAY_STEP_CHIPS;
            let (below, above) = rayon::join(|| delayed(-step), || delayed(step));
            return Ok(NeighbouringResponses::new(below?, above?, 2.0 * step));
        }
        let [(below, down), (above, up)] = [-1.0, 1.0].map(|by| parameters.nudged(index, by));
        let (below, above) = rayon::join(|| self.response(&below), || self.response(&above));
        Ok(NeighbouringResponses::new(below?, above?, up - down))
    }

    /// Derivatives of the expected counts by an unknown, from the responses on both its sides.
    pub fn slope_between(
        &self,
        parameters: &FitParameters,
        beside: &NeighbouringResponses,
        reading: ResponseReading,
    ) -> Result<DerivativeColumn, MeanResponseError> {
        let of = |response: &MeanResponse| self.means_read(parameters, response, reading);
        match parameters.walk {
            None => of(&beside.slope),
            Some(_) => Ok(slope(&of(&beside.below)?, &of(&beside.above)?, beside.apart)),
        }
    }

    /// How far the counts expected of light with one path some chips later are from those expected of it; `response` is that at
    /// `parameters`, and `means` are its counts.
    pub fn apart(
        &self,
        parameters: &FitParameters,
        response: &MeanResponse<'m>,
        means: &[MeanCount],
        (path, later_chips): (usize, f64),
    ) -> Result<DerivativeColumn, FitError> {
        let mut moved = parameters.clone();
        moved.paths[path].delay_chips += later_chips;
        let response = match parameters.paths.len() {
            1 => response.delayed(self.clock().ps(later_chips))?,
            _ => self.response(&moved)?,
        };
        Ok(slope(means, &self.means_of(&moved, &response)?, 1.0))
    }

    /// The place of a step of the scan on the axis.
    pub fn place_of(&self, step: Step, axis: &DelayAxis) -> f64 {
        axis.place_of_phase_step(self.model.timing.scan.phase_step(step))
    }

    /// Places on the axis at which the detector's own code peaks.
    pub fn own_peaks(&self, parameters: &FitParameters, axis: &DelayAxis) -> Vec<f64> {
        let own = parameters.paths.iter().filter(|path| path.has(&self.model.reference));
        own.map(|path| axis.place_of(path.delay_chips)).collect()
    }

    /// Places of the steps of each group, which count the same light.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let grouping = self.model.timing.grouping();
        let places: Vec<usize> = (0..self.steps.len()).collect();
        let group = |&place: &usize| grouping.group_of(self.steps[place]);
        places.chunk_by(|a, b| group(a) == group(b)).map(<[usize]>::to_vec).collect()
    }
}
