//! A scan in which light is searched for, and fits of more or less light to it.

use std::sync::Arc;

use super::air::Air;
use super::descent::{Derivatives, Descent, Hypothesis};
use super::error::FitError;
use super::known_moments::KnownMoments;
use super::normal::Normal;
use super::parameters::{FitParameters, PathParameters};
use super::problem::{Problem, ResponseReading};
use super::template::Template;
use crate::response::MeanCount;

/// A scan, and the light that may be in it.
pub struct FitSearch<'a, 'm> {
    pub air: &'a Air,
    pub descent: Descent<'a, 'm>,
}

impl<'a, 'm> FitSearch<'a, 'm> {
    /// A search with weights for light that is all constant.
    pub fn new(
        air: &'a Air,
        problem: &'a Problem<'m>,
        known: &KnownMoments,
        measured: &'a [MeanCount],
    ) -> Result<(FitSearch<'a, 'm>, Hypothesis<'m>), FitError> {
        let model = problem.model;
        let detected = measured.iter().map(|count| count.total).sum::<f64>()
            / (measured.len() as f64 * air.axis.chips);
        let constant = model.dead_time().primary(detected);
        let background = FitParameters { paths: Vec::new(), walk: None, constant };
        let reading = ResponseReading::OnAverage;
        let start = Hypothesis::of(problem, background, reading, None)?;
        let weights = start.weights(problem, known, &air.axis)?;
        let descent = Descent { problem, measured, axis: &air.axis, weights, reading };
        let search = FitSearch { air, descent };
        let start = search.descent.roughly(start, &[])?;
        Ok((search, start))
    }

    /// Residuals of the signed counts.
    pub fn residual(&self, here: &Hypothesis) -> Vec<f64> {
        let pairs = self.descent.measured.iter().zip(&here.expected);
        pairs.map(|(count, mean)| count.signed - mean.signed).collect()
    }

    /// Signed counts of a step per unit of a template's value and of light.
    pub fn unit(&self, here: &Hypothesis) -> f64 {
        let [pattern, _] = self.descent.gains(here);
        pattern * self.air.axis.periods
    }

    /// Other light near `here`, fitted with rough derivatives.
    pub fn fitted(
        &self,
        here: &Hypothesis<'m>,
        change: impl FnOnce(&mut FitParameters),
    ) -> Result<Hypothesis<'m>, FitError> {
        let (start, templates) = self.changed(here, change)?;
        self.descent.roughly(start, &templates)
    }

    fn changed(
        &self,
        here: &Hypothesis<'m>,
        change: impl FnOnce(&mut FitParameters),
    ) -> Result<(Hypothesis<'m>, Vec<Arc<Template>>), FitError> {
        let mut parameters = here.parameters.clone();
        change(&mut parameters);
        let templates = parameters.paths.iter().map(|path| self.air.template_of(&path.code));
        let templates = templates.collect();
        Ok((self.descent.hypothesis(parameters, Some(here))?, templates))
    }

    /// The same light and a path, fitted.
    pub fn with(
        &self,
        here: &Hypothesis<'m>,
        path: PathParameters,
    ) -> Result<Hypothesis<'m>, FitError> {
        self.fitted(here, |light| light.add_path(path))
    }

    /// The same light without a path, fitted.
    pub fn without(&self, here: &Hypothesis<'m>, path: usize) -> Result<Hypothesis<'m>, FitError> {
        let rest = self.fitted(here, |light| light.remove_path(path))?;
        Ok(self.descent.exactly(rest)?.0)
    }

    /// The light that fits best near `here`, with exact derivatives and weights of that light, which
    /// are kept.
    pub fn finished(
        &mut self,
        here: Hypothesis<'m>,
        known: &KnownMoments,
    ) -> Result<(Hypothesis<'m>, Normal), FitError> {
        let descent = &mut self.descent;
        descent.weights = here.weights(descent.problem, known, descent.axis)?;
        let at = Some(here.parameters.clone());
        Ok(descent.weighed(here, Derivatives::Differences, known, at)?.at_end())
    }

    /// The same light with the logarithm of two paths' ratio moved by `by` and held there, all
    /// else fitted.
    pub fn with_ratio(
        &self,
        here: &Hypothesis<'m>,
        pair @ [first, second]: [usize; 2],
        by: f64,
    ) -> Result<Hypothesis<'m>, FitError> {
        let (start, templates) = self.changed(here, |light| light.share_anew(pair, by))?;
        let held = start.parameters.ln_ratio(first, second);
        self.descent.downwards(start, &templates, Some(&held))
    }

    /// Standard deviation of a signed count.
    pub fn sigma(&self) -> f64 {
        self.descent.weights.signed_sigma(self.air.axis.samples_per_chip)
    }
}
