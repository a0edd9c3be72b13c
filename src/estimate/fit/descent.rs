//! From a start to the unknowns that the counts of a whole scan fit best.
//!
//! Rough derivatives, of the light's first order, cost nothing beside an expected
//! response, and a fit with the exact response and rough derivatives goes to nearly
//! the same place: they serve while hypotheses are compared. The end is found, and
//! its covariance told, with exact ones.

use std::sync::Arc;

use super::error::FitError;
use super::normal::Normal;
use super::parameters::{Column, Parameters};
use super::problem::Problem;
use super::template::{Axis, Template};
use super::weights::Weights;
use crate::code::Code;
use crate::response::{MeanCount, MeanResponse};

/// Most steps with rough derivatives, and with exact ones.
const MOST_ROUGH: usize = 12;
const MOST_EXACT: usize = 12;

/// A fit has settled when no unknown moves by more than this share of its standard
/// deviation, or chi-square falls by less than that squared, about: corners of the
/// correlation let no gradient vanish.
const ROUGHLY_SIGMAS: f64 = 0.15;
const SETTLED_SIGMAS: f64 = 0.01;

/// Shares of a step that are tried where the whole makes matters worse.
const SHARES: [f64; 5] = [1.0, 0.4, 0.16, 0.06, 0.02];

/// Light that counts may come from, and how well it fits.
#[derive(Debug, Clone)]
pub struct Hypothesis {
    pub codes: Vec<Arc<Code>>,
    pub parameters: Parameters,
    pub expected: Vec<MeanCount>,
    /// What is expected beyond that on average over where steps begin in the code
    /// period; kept while light changes little, for it costs the most.
    beyond_average: Arc<Vec<MeanCount>>,
    pub chi_square: f64,
    /// Steps taken so far.
    pub iterations: usize,
}

/// The counts of a scan, and what hypotheses about them share.
pub struct Descent<'a, 'm> {
    /// Detector and steps; its codes are not used.
    pub problem: &'a Problem<'m>,
    pub measured: &'a [MeanCount],
    pub axis: &'a Axis,
    pub weights: Weights,
}

impl<'m> Descent<'_, 'm> {
    /// A problem with the codes of a hypothesis.
    pub fn problem_of(&self, codes: &[Arc<Code>]) -> Problem<'m> {
        Problem { codes: codes.to_vec(), ..self.problem.clone() }
    }

    /// What is expected of some light, and how well it fits.
    pub fn hypothesis(
        &self,
        codes: Vec<Arc<Code>>,
        parameters: Parameters,
    ) -> Result<Hypothesis, FitError> {
        let problem = self.problem_of(&codes);
        let response = problem.response(&parameters)?;
        let expected = problem.means_of(&response);
        let average = problem.means_on_average(&response);
        let beyond = expected.iter().zip(&average).map(|(exact, mean)| MeanCount {
            signed: exact.signed - mean.signed,
            total: exact.total - mean.total,
        });
        Ok(Hypothesis {
            chi_square: self.weights.chi_square(self.measured, &expected),
            beyond_average: Arc::new(beyond.collect()),
            codes,
            parameters,
            expected,
            iterations: 0,
        })
    }

    /// The same for light that is little different from that of `near`.
    pub fn near_hypothesis(
        &self,
        near: &Hypothesis,
        codes: Vec<Arc<Code>>,
        parameters: Parameters,
    ) -> Result<Hypothesis, FitError> {
        let problem = self.problem_of(&codes);
        let mut expected = problem.means_on_average(&problem.response(&parameters)?);
        for (mean, beyond) in expected.iter_mut().zip(near.beyond_average.iter()) {
            mean.signed += beyond.signed;
            mean.total += beyond.total;
        }
        Ok(Hypothesis {
            chi_square: self.weights.chi_square(self.measured, &expected),
            beyond_average: Arc::clone(&near.beyond_average),
            codes,
            parameters,
            expected,
            iterations: near.iterations,
        })
    }

    /// A hypothesis of other weights, with these.
    pub fn weighed(&self, here: Hypothesis) -> Hypothesis {
        Hypothesis { chi_square: self.weights.chi_square(self.measured, &here.expected), ..here }
    }

    /// The same light, with all that is expected of it worked out.
    fn refreshed(&self, here: Hypothesis) -> Result<Hypothesis, FitError> {
        Ok(Hypothesis {
            iterations: here.iterations,
            ..self.hypothesis(here.codes, here.parameters)?
        })
    }

    /// Goes down with rough derivatives. `templates` are those of the codes.
    pub fn roughly(
        &self,
        start: Hypothesis,
        templates: &[Arc<Template>],
    ) -> Result<Hypothesis, FitError> {
        let near = self.downwards(start, templates, None)?;
        let here = self.refreshed(near)?;
        self.downwards(here, templates, None)
    }

    /// The same for light that changes little on the way. A combination of the unknowns may
    /// be `held` as it is.
    pub fn downwards(
        &self,
        start: Hypothesis,
        templates: &[Arc<Template>],
        held: Option<&[f64]>,
    ) -> Result<Hypothesis, FitError> {
        let mut here = start;
        for _ in 0..MOST_ROUGH {
            let columns = self.rough_columns(&here, templates);
            // Between two steps counts follow a delay in a straight line: rough derivatives of
            // two paths that are less than two steps apart are not independent.
            let damped = self.weights.damped_normal(&columns, self.measured, &here.expected);
            let mut normal = damped.ok_or_else(|| self.undetermined(&here))?;
            if let Some(held) = held {
                normal = normal.holding(held);
            }
            let Some(next) = self.step(&here, &normal) else {
                break;
            };
            let moved = normal.largest_step_sigmas(&next.parameters.minus(&here.parameters));
            let fell = here.chi_square - next.chi_square;
            here = next;
            if moved < ROUGHLY_SIGMAS || fell < ROUGHLY_SIGMAS * ROUGHLY_SIGMAS {
                break;
            }
        }
        Ok(here)
    }

    /// Goes down with exact derivatives, to where it settles.
    pub fn exactly(&self, start: Hypothesis) -> Result<(Hypothesis, Normal), FitError> {
        let problem = self.problem_of(&start.codes);
        let mut here = start;
        let (mut columns, mut linearised) = self.exact_columns(&problem, &here)?;
        for _ in 0..MOST_EXACT {
            let normal = self.normal(&columns, &here).ok_or_else(|| self.undetermined(&here))?;
            let Some(next) = self.step(&here, &normal) else {
                if here.parameters == linearised {
                    return Ok((here, normal));
                }
                (columns, linearised) = self.exact_columns(&problem, &here)?;
                continue;
            };
            let moved = normal.largest_step_sigmas(&next.parameters.minus(&here.parameters));
            let fell = here.chi_square - next.chi_square;
            here = self.refreshed(next)?;
            let is_far = here.parameters.differ_from(&linearised);
            if moved < SETTLED_SIGMAS || fell < SETTLED_SIGMAS * SETTLED_SIGMAS {
                return Ok((here, normal));
            }
            if is_far {
                (columns, linearised) = self.exact_columns(&problem, &here)?;
            }
        }
        let normal = self.normal(&columns, &here).ok_or_else(|| self.undetermined(&here))?;
        Ok((here, normal))
    }

    fn exact_columns(
        &self,
        problem: &Problem<'m>,
        here: &Hypothesis,
    ) -> Result<(Vec<Column>, Parameters), FitError> {
        let response: MeanResponse = problem.response(&here.parameters)?;
        let columns = problem.jacobian_on_average(&here.parameters, &response)?;
        Ok((columns, here.parameters.clone()))
    }

    fn normal(&self, columns: &[Column], here: &Hypothesis) -> Option<Normal> {
        self.weights.normal(columns, self.measured, &here.expected)
    }

    fn undetermined(&self, here: &Hypothesis) -> FitError {
        FitError::Undetermined { steps: self.measured.len(), unknowns: here.parameters.len() }
    }

    /// A step that lowers chi-square, `None` if there is none.
    fn step(&self, here: &Hypothesis, normal: &Normal) -> Option<Hypothesis> {
        let mut full = normal.solution();
        let constant = here.parameters.constant;
        if full.last().is_some_and(|step| constant + step < 0.0) {
            // There is no less than no background.
            full = normal.solution_with_last(-constant);
        }
        SHARES.iter().find_map(|&share| {
            let parameters = here.parameters.moved(&full, share);
            // A step of few counts may lead to light that has no response.
            let codes = here.codes.clone();
            let tried = self.near_hypothesis(here, codes, parameters).ok()?;
            (tried.chi_square < here.chi_square)
                .then_some(Hypothesis { iterations: here.iterations + 1, ..tried })
        })
    }

    /// What a detection more or less of the light's rate makes of the signed counts'
    /// pattern, and of the totals.
    pub fn gains(
        &self,
        codes: &[Arc<Code>],
        parameters: &Parameters,
        expected: &[MeanCount],
    ) -> [f64; 2] {
        let detected = expected.iter().map(|mean| mean.total).sum::<f64>()
            / (expected.len() as f64 * self.axis.chips);
        let lit = parameters.paths.iter().zip(codes);
        let lit = lit.map(|(path, code)| path.ln_rate.exp() * share_of_ones(code));
        let primary = parameters.constant + lit.sum::<f64>();
        let per_primary = detected / primary.max(f64::MIN_POSITIVE);
        let dead = self.problem.model.dead_time_chips;
        // A pattern of chips lowers what follows it within itself by half.
        let pattern = per_primary / (1.0 + 0.5 * primary * dead.min(1.0));
        [pattern, per_primary * (1.0 - (detected * dead).min(0.95))]
    }

    fn rough_columns(&self, here: &Hypothesis, templates: &[Arc<Template>]) -> Vec<Column> {
        let axis = self.axis;
        let [pattern, total] = self.gains(&here.codes, &here.parameters, &here.expected);
        let mut columns = Vec::with_capacity(here.parameters.len());
        let lit = here.parameters.paths.iter().zip(&here.codes).zip(templates);
        for ((path, code), template) in lit {
            let rate = path.ln_rate.exp();
            let signed = pattern * rate * axis.periods;
            let totals = total * rate * axis.chips * share_of_ones(code);
            let (delay, strength) = axis
                .values(template, path.delay_chips)
                .map(|[value, slope]| {
                    let delay = MeanCount { signed: -signed * slope, total: 0.0 };
                    let strength = MeanCount { signed: signed * value, total: totals };
                    (delay, strength)
                })
                .unzip();
            columns.push(delay);
            columns.push(strength);
        }
        let reference = &self.problem.model.reference;
        let surplus = 2.0 * share_of_ones(reference) - 1.0;
        let constant =
            MeanCount { signed: pattern * surplus * axis.chips, total: total * axis.chips };
        columns.push(vec![constant; axis.len()]);
        columns
    }
}

/// Ones among a code's chips.
pub fn share_of_ones(code: &Code) -> f64 {
    code.weight() as f64 / code.len() as f64
}
