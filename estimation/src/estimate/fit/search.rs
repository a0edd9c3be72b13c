//! A scan in which light is looked for, and what it would be with more light.

use std::sync::Arc;

use super::air::Air;
use super::descent::{Descent, Hypothesis};
use super::error::FitError;
use super::known_moments::KnownMoments;
use super::parameters::{Parameters, PathParameters};
use super::problem::{Problem, Reading};
use super::template::{Axis, Template};
use crate::code::Code;
use crate::response::MeanCount;

/// A scan, and what may be in it.
pub struct Search<'a, 'm> {
    pub air: &'a Air,
    pub descent: Descent<'a, 'm>,
}

impl<'a, 'm> Search<'a, 'm> {
    /// A search with weights for light that is all constant.
    pub fn new(
        air: &'a Air,
        problem: &'a Problem<'m>,
        known: &KnownMoments,
        measured: &'a [MeanCount],
    ) -> Result<(Search<'a, 'm>, Hypothesis<'m>), FitError> {
        let model = problem.model;
        let detected = measured.iter().map(|count| count.total).sum::<f64>()
            / (measured.len() as f64 * air.axis.chips);
        let constant = model.dead_time().primary(detected);
        let background = Parameters { paths: Vec::new(), walk: None, constant };
        let nothing = Problem { codes: Vec::new(), ..problem.clone() };
        let start = Hypothesis::of(&nothing, background, Reading::OnAverage)?;
        let weights = start.weights(&nothing, known, &air.axis)?;
        let reading = Reading::OnAverage;
        let descent = Descent { problem, measured, axis: &air.axis, weights, reading };
        let search = Search { air, descent };
        let start = search.descent.roughly(start, &[])?;
        Ok((search, start))
    }

    fn templates(&self, codes: &[Arc<Code>]) -> Vec<Arc<Template>> {
        codes.iter().map(|code| self.air.template_of(code)).collect()
    }

    /// What some light leaves over of the signed counts.
    pub fn residual(&self, here: &Hypothesis) -> Vec<f64> {
        let pairs = self.descent.measured.iter().zip(&here.expected);
        pairs.map(|(count, mean)| count.signed - mean.signed).collect()
    }

    /// Signed counts of a step for a unit of a template's value and of light.
    pub fn unit(&self, here: &Hypothesis) -> f64 {
        let [pattern, _] = self.descent.gains(&here.codes, &here.parameters, &here.expected);
        pattern * self.air.axis.periods
    }

    /// The same light and a path with a code, fitted.
    pub fn with(
        &self,
        here: &Hypothesis<'m>,
        code: &Arc<Code>,
        path: PathParameters,
    ) -> Result<Hypothesis<'m>, FitError> {
        let mut codes = here.codes.clone();
        codes.push(Arc::clone(code));
        let mut parameters = here.parameters.clone();
        parameters.add_path(path, code);
        let templates = self.templates(&codes);
        let start = self.descent.near_hypothesis(here, codes, parameters)?;
        self.descent.roughly(start, &templates)
    }

    /// The same light without a path, fitted.
    pub fn without(&self, here: &Hypothesis<'m>, path: usize) -> Result<Hypothesis<'m>, FitError> {
        let (mut codes, mut parameters) = (here.codes.clone(), here.parameters.clone());
        parameters.remove_path(path, &codes.remove(path));
        let templates = self.templates(&codes);
        let start = self.descent.near_hypothesis(here, codes, parameters)?;
        let (rest, _) = self.descent.exactly(self.descent.roughly(start, &templates)?)?;
        Ok(rest)
    }

    /// Two paths in place of one, fitted.
    pub fn with_pair(
        &self,
        here: &Hypothesis<'m>,
        path: usize,
        pair: [PathParameters; 2],
    ) -> Result<Hypothesis<'m>, FitError> {
        let mut codes = here.codes.clone();
        codes.push(Arc::clone(&here.codes[path]));
        let mut parameters = here.parameters.clone();
        parameters.paths[path] = pair[0];
        parameters.paths.push(pair[1]);
        let templates = self.templates(&codes);
        let start = self.descent.near_hypothesis(here, codes, parameters)?;
        self.descent.roughly(start, &templates)
    }

    /// One path in place of two, fitted. The second number is the larger one.
    pub fn with_one(
        &self,
        here: &Hypothesis<'m>,
        [first, second]: [usize; 2],
    ) -> Result<Hypothesis<'m>, FitError> {
        let mut codes = here.codes.clone();
        codes.remove(second);
        let mut parameters = here.parameters.clone();
        let gone = parameters.paths.remove(second);
        let kept = &mut parameters.paths[first];
        let [kept_rate, gone_rate] = [&*kept, &gone].map(|path| path.ln_rate.exp());
        let share = gone_rate / (kept_rate + gone_rate);
        kept.delay_chips += share * (gone.delay_chips - kept.delay_chips);
        kept.ln_rate = (kept_rate + gone_rate).ln();
        let templates = self.templates(&codes);
        let start = self.descent.near_hypothesis(here, codes, parameters)?;
        self.descent.roughly(start, &templates)
    }

    /// The same light with the logarithm of two paths' ratio moved by `by` and held there, all
    /// else fitted.
    pub fn with_ratio(
        &self,
        here: &Hypothesis<'m>,
        [first, second]: [usize; 2],
        by: f64,
    ) -> Result<Hypothesis<'m>, FitError> {
        let mut parameters = here.parameters.clone();
        let [a, b] = [first, second].map(|path| parameters.paths[path]);
        let [rate_a, rate_b] = [a, b].map(|path| path.ln_rate.exp());
        let share = rate_b / (rate_a + rate_b);
        let next = 1.0 / (1.0 + rate_a / rate_b * (-by).exp());
        // Their middle stays, and how wide they spread.
        let middle = a.delay_chips + share * (b.delay_chips - a.delay_chips);
        let wider = (share * (1.0 - share) / (next * (1.0 - next))).sqrt();
        let apart = wider * (b.delay_chips - a.delay_chips);
        parameters.paths[first] = PathParameters {
            delay_chips: middle - next * apart,
            ln_rate: ((1.0 - next) * (rate_a + rate_b)).ln(),
        };
        parameters.paths[second] = PathParameters {
            delay_chips: middle + (1.0 - next) * apart,
            ln_rate: (next * (rate_a + rate_b)).ln(),
        };
        let held = parameters.ln_ratio(first, second);
        let templates = self.templates(&here.codes);
        let codes = here.codes.clone();
        let start = self.descent.near_hypothesis(here, codes, parameters)?;
        self.descent.downwards(start, &templates, Some(&held))
    }

    /// Standard deviation of a signed count.
    pub fn sigma(&self) -> f64 {
        self.descent.weights.signed_sigma(self.air.axis.samples_per_chip)
    }

    /// Where the scan's steps are.
    pub fn axis(&self) -> &Axis {
        &self.air.axis
    }
}
