//! Fits of paths to the steps of a scan.
//!
//! Rough derivatives, of first order in the light, cost nothing beside an expected
//! response, and a fit with the exact response and rough derivatives ends nearly at
//! the same point: they are used while hypotheses are compared. The last steps and the covariance
//! take exact derivatives, or those of a node nearby.

use std::borrow::Cow;
use std::sync::Arc;

use super::error::FitError;
use super::known_moments::{KnownMoments, Linear};
use super::normal::Normal;
use super::parameters::{DerivativeColumn, FitParameters, PathParameters, share_of_ones};
use super::problem::{MOST_WEIGHINGS, Problem, ResponseReading, Sides};
use super::scoring::{Counts, Settled, Settling, Slopes, settle};
use super::template::{DelayAxis, Template};
use super::weights::Weights;
use crate::response::{MeanCount, MeanResponse};

/// Light that may have caused the counts, and how well it fits.
#[derive(Debug, Clone)]
pub struct Hypothesis<'m> {
    pub parameters: FitParameters,
    pub expected: Vec<MeanCount>,
    response: Arc<MeanResponse<'m>>,
    /// Expected counts less their average over where steps begin in the code period; kept while the
    /// light changes little, since it costs the most.
    beyond_average: Arc<Vec<MeanCount>>,
    /// Of a fit that has settled.
    pub chi_square: f64,
    /// Steps taken so far.
    pub iterations: usize,
}

impl<'m> Hypothesis<'m> {
    /// Some light of a problem. Expected counts less their average may be those of light nearby.
    pub fn of(
        problem: &Problem<'m>,
        parameters: FitParameters,
        reading: ResponseReading,
        near: Option<&Hypothesis>,
    ) -> Result<Hypothesis<'m>, FitError> {
        let response = Arc::new(problem.response(&parameters)?);
        Hypothesis::with_response(problem, parameters, response, reading, near)
    }

    /// The same where the response to the light is known.
    fn with_response(
        problem: &Problem<'m>,
        parameters: FitParameters,
        response: Arc<MeanResponse<'m>>,
        reading: ResponseReading,
        near: Option<&Hypothesis>,
    ) -> Result<Hypothesis<'m>, FitError> {
        let mut expected = problem.means_read(&parameters, &response, reading)?;
        let beyond_average = match (near, reading) {
            (Some(near), _) => Arc::clone(&near.beyond_average),
            (None, ResponseReading::Exact) => Arc::default(),
            (None, ResponseReading::OnAverage) => {
                let exact = problem.means_of(&parameters, &response)?;
                Arc::new(
                    exact
                        .iter()
                        .zip(&expected)
                        .map(|(exact, mean)| MeanCount {
                            signed: exact.signed - mean.signed,
                            total: exact.total - mean.total,
                        })
                        .collect(),
                )
            }
        };
        for (mean, beyond) in expected.iter_mut().zip(beyond_average.iter()) {
            mean.signed += beyond.signed;
            mean.total += beyond.total;
        }
        Ok(Hypothesis {
            chi_square: f64::INFINITY,
            beyond_average,
            parameters,
            expected,
            response,
            iterations: near.map_or(0, |near| near.iterations),
        })
    }

    /// Weights of this detector at this light.
    pub fn weights(
        &self,
        problem: &Problem,
        known: &KnownMoments,
        axis: &DelayAxis,
    ) -> Result<Weights, FitError> {
        Ok(known.weights(problem, &self.parameters, &self.expected, axis)?)
    }
}

impl<'m> Settled<Hypothesis<'m>> {
    /// The end of the last step, and the normal equations there.
    pub fn at_end(self) -> (Hypothesis<'m>, Normal) {
        let parameters = self.place.parameters.moved(&self.step);
        (Hypothesis { parameters, chi_square: self.misfit, ..self.place }, self.normal)
    }
}

/// The counts of a scan, and what hypotheses about them share.
pub struct Descent<'a, 'm> {
    pub problem: &'a Problem<'m>,
    pub measured: &'a [MeanCount],
    pub axis: &'a DelayAxis,
    pub weights: Weights,
    /// How expected counts are read off the response.
    pub reading: ResponseReading,
}

/// Where the derivatives of a fit come from.
pub enum Derivatives<'a> {
    /// The light's first order.
    Templates(&'a [Arc<Template>]),
    /// Nodes nearby, which are kept from scan to scan, and the last of them.
    Nodes(&'a KnownMoments, Option<Arc<Linear>>),
    /// Differences at the current light.
    Differences,
}

/// A fit in progress.
struct Descending<'a, 'd, 'm> {
    descent: &'d Descent<'a, 'm>,
    source: Derivatives<'d>,
    /// Where weights of this detector come from within a standard deviation of the end, as often as
    /// such a problem needs; `None` if they stay as they are.
    known: Option<&'d KnownMoments>,
    /// A combination of the unknowns that is held constant.
    held: Option<&'d [f64]>,
    pub weights: Cow<'d, Weights>,
    /// The light that they belong to, if they are this detector's.
    weighed_at: Option<FitParameters>,
    weighings: usize,
    /// Exact derivatives, and the light that they belong to.
    linearised: Option<(Vec<DerivativeColumn>, FitParameters)>,
}

impl<'a, 'd, 'm> Descending<'a, 'd, 'm> {
    /// One with constant weights.
    pub fn new(descent: &'d Descent<'a, 'm>, source: Derivatives<'d>) -> Descending<'a, 'd, 'm> {
        Descending {
            weights: Cow::Borrowed(&descent.weights),
            descent,
            source,
            known: None,
            held: None,
            weighed_at: None,
            weighings: 0,
            linearised: None,
        }
    }

    /// Derivatives of a node near a hypothesis, where they come from nodes.
    fn of_node(&mut self, here: &Hypothesis<'m>) -> Option<Vec<DerivativeColumn>> {
        let Derivatives::Nodes(known, last) = &mut self.source else {
            return None;
        };
        let problem = self.descent.problem;
        if !last.as_ref().is_some_and(|linear| linear.holds_for(&here.parameters, problem)) {
            *last = known.linear(problem, &here.parameters).ok();
        }
        Some(last.as_ref()?.columns_at(&here.parameters))
    }

    /// Whitened derivatives at the current light, or so near that they are good enough.
    fn differences(&mut self, here: &Hypothesis<'m>, anew: bool) -> Result<Slopes, FitError> {
        let is_good = |(_, of): &(Vec<DerivativeColumn>, FitParameters)| match anew {
            true => &here.parameters == of,
            false => !here.parameters.differ_from(of),
        };
        let (columns, of) = match self.linearised.take().filter(is_good) {
            Some(known) => known,
            None => {
                let problem = self.descent.problem;
                let (parameters, reading) = (&here.parameters, self.descent.reading);
                let columns = problem.jacobian(parameters, &here.response, reading, Sides::One)?;
                (columns, here.parameters.clone())
            }
        };
        let slopes = Slopes {
            columns: self.weights.whitened_columns(&columns),
            are_best: of == here.parameters,
        };
        self.linearised = Some((columns, of));
        Ok(slopes)
    }

    fn is_rough(&self) -> bool {
        matches!(self.source, Derivatives::Templates(_))
    }
}

impl<'m> Counts for Descending<'_, '_, 'm> {
    type Point = Hypothesis<'m>;
    type Error = FitError;

    fn residuals(&self, here: &Hypothesis<'m>) -> Result<Vec<f64>, FitError> {
        Ok(self.weights.residuals(self.descent.measured, &here.expected))
    }

    fn slopes(&mut self, here: &Hypothesis<'m>, anew: bool) -> Result<Slopes, FitError> {
        let near = match self.source {
            Derivatives::Templates(templates) => Some(self.descent.rough_columns(here, templates)),
            Derivatives::Nodes(..) if !anew => self.of_node(here),
            Derivatives::Nodes(..) | Derivatives::Differences => None,
        };
        match near {
            Some(columns) => Ok(Slopes {
                columns: self.weights.whitened_columns(&columns),
                are_best: self.is_rough(),
            }),
            None => self.differences(here, anew),
        }
    }

    fn normal(&self, columns: &[Vec<f64>], residuals: &[f64]) -> Option<Normal> {
        let normal = Normal::of_whitened(columns, residuals);
        // Between two steps counts follow a delay in a straight line: rough derivatives of
        // two paths that are less than two steps apart are not independent.
        let damped = || self.is_rough().then(|| Normal::damped(columns, residuals)).flatten();
        let normal = normal.or_else(damped)?;
        Some(match self.held {
            Some(held) => normal.holding(held),
            None => normal,
        })
    }

    fn step(&self, here: &Hypothesis<'m>, normal: &Normal) -> Vec<f64> {
        here.parameters.step(normal, self.descent.problem.most_walk())
    }

    fn moved(&self, here: &Hypothesis<'m>, step: &[f64]) -> Result<Hypothesis<'m>, FitError> {
        let parameters = here.parameters.moved(step);
        let near = self.is_rough().then_some(here);
        let there = self.descent.hypothesis(parameters, near)?;
        Ok(Hypothesis { iterations: here.iterations + 1, ..there })
    }

    fn weigh(&mut self, here: &Hypothesis<'m>, fall: f64) -> Result<bool, FitError> {
        let problem = self.descent.problem;
        let Some(known) = self.known else {
            return Ok(false);
        };
        let is_of_here = self.weighed_at.as_ref() == Some(&here.parameters);
        // A start from a node may be of other light than the end, and its weights with it.
        let weighed_at = self.weighed_at.as_ref();
        let hold = weighed_at.is_some_and(|of| !here.parameters.differ_in_light_from(of));
        let most = if hold { problem.most_weighings() } else { MOST_WEIGHINGS };
        if is_of_here || fall >= 1.0 || self.weighings >= most {
            return Ok(false);
        }
        self.weighings += 1;
        self.weighed_at = Some(here.parameters.clone());
        self.weights = Cow::Owned(here.weights(problem, known, self.descent.axis)?);
        Ok(true)
    }

    fn undetermined(&self, here: &Hypothesis<'m>) -> FitError {
        let steps = self.descent.measured.len();
        FitError::Undetermined { steps, unknowns: here.parameters.len() }
    }
}

impl<'m> Descent<'_, 'm> {
    /// Expected counts of some light, which may be close to `near`.
    pub fn hypothesis(
        &self,
        parameters: FitParameters,
        near: Option<&Hypothesis>,
    ) -> Result<Hypothesis<'m>, FitError> {
        Hypothesis::of(self.problem, parameters, self.reading, near)
    }

    /// The same light, with nothing taken from light nearby.
    fn refreshed(&self, here: Hypothesis<'m>) -> Result<Hypothesis<'m>, FitError> {
        let Hypothesis { parameters, response, iterations, .. } = here;
        let (problem, reading) = (self.problem, self.reading);
        let here = Hypothesis::with_response(problem, parameters, response, reading, None)?;
        Ok(Hypothesis { iterations, ..here })
    }

    /// Descends with rough derivatives. `templates` are those of the codes.
    pub fn roughly(
        &self,
        start: Hypothesis<'m>,
        templates: &[Arc<Template>],
    ) -> Result<Hypothesis<'m>, FitError> {
        let near = self.downwards(start, templates, None)?;
        let here = self.refreshed(near)?;
        self.downwards(here, templates, None)
    }

    /// The same for light that changes little on the way. A combination of the unknowns may
    /// be `held` constant.
    pub fn downwards(
        &self,
        start: Hypothesis<'m>,
        templates: &[Arc<Template>],
        held: Option<&[f64]>,
    ) -> Result<Hypothesis<'m>, FitError> {
        let descending = Descending::new(self, Derivatives::Templates(templates));
        let mut descending = Descending { held, ..descending };
        let settled = settle(&mut descending, start, Settling::ROUGH)?;
        Ok(Hypothesis { chi_square: settled.misfit, ..settled.place })
    }

    /// Descends with exact derivatives until it settles.
    pub fn exactly(&self, start: Hypothesis<'m>) -> Result<(Hypothesis<'m>, Normal), FitError> {
        let mut descending = Descending::new(self, Derivatives::Differences);
        Ok(settle(&mut descending, start, Settling::FINE)?.at_end())
    }

    /// Descends with derivatives from `source`, and weights of this detector as soon as it is near
    /// the end, which are kept; those of the start may be `weighed_at` some light.
    pub fn weighed(
        &mut self,
        start: Hypothesis<'m>,
        source: Derivatives,
        known: &KnownMoments,
        weighed_at: Option<FitParameters>,
    ) -> Result<Settled<Hypothesis<'m>>, FitError> {
        let mut descending = Descending {
            known: Some(known),
            weighings: weighed_at.iter().len(),
            weighed_at,
            ..Descending::new(self, source)
        };
        let settled = settle(&mut descending, start, Settling::FINE)?;
        if let Cow::Owned(weights) = descending.weights {
            self.weights = weights;
        }
        Ok(settled)
    }

    /// Gains from the light's rate to the signed counts' pattern, and to the total counts.
    pub fn gains(&self, Hypothesis { parameters, expected, .. }: &Hypothesis) -> [f64; 2] {
        let detected = expected.iter().map(|mean| mean.total).sum::<f64>()
            / (expected.len() as f64 * self.axis.chips);
        let lit = parameters.paths.iter().map(PathParameters::mean_rate);
        let primary = parameters.constant + lit.sum::<f64>();
        let per_primary = detected / primary.max(f64::MIN_POSITIVE);
        let dead_time = self.problem.model.dead_time();
        // A pattern of chips lowers what follows it within itself by half.
        let pattern = per_primary / (1.0 + 0.5 * primary * dead_time.length.min(1.0));
        [pattern, per_primary * dead_time.ready_share(detected)]
    }

    fn rough_columns(
        &self,
        here: &Hypothesis,
        templates: &[Arc<Template>],
    ) -> Vec<DerivativeColumn> {
        let axis = self.axis;
        let [pattern, total] = self.gains(here);
        let mut columns = Vec::with_capacity(here.parameters.len());
        for (path, template) in here.parameters.paths.iter().zip(templates) {
            let signed = pattern * path.rate() * axis.periods;
            let totals = total * axis.chips * path.mean_rate();
            let values: Vec<[f64; 2]> = axis.values(template, path.delay_chips).collect();
            let delay = |[_, slope]: &[f64; 2]| MeanCount { signed: -signed * slope, total: 0.0 };
            let strength =
                |[value, _]: &[f64; 2]| MeanCount { signed: signed * value, total: totals };
            columns.push(values.iter().map(delay).collect());
            columns.push(values.iter().map(strength).collect());
        }
        let reference = &self.problem.model.reference;
        let surplus = 2.0 * share_of_ones(reference) - 1.0;
        let constant =
            MeanCount { signed: pattern * surplus * axis.chips, total: total * axis.chips };
        columns.push(vec![constant; axis.len()]);
        columns
    }
}
