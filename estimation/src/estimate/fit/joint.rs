//! Finding all light of a scan: one path after another, each where the residual of those found so
//! far stands out most, with a new fit of all of them each time.
//!
//! Residuals are relative to the exact expected counts. Relative to a linear model, dead time would
//! make ghosts: it multiplies the light with itself, and a product of shifted Gold codes is a Gold
//! code of the same set.

use super::air::{Air, KnownCode, MOST_OTHERS, MOST_OWN};
use super::descent::Hypothesis;
use super::error::FitError;
use super::known_moments::KnownMoments;
use super::model_estimate::{Goodness, ModelEstimate, Untold};
use super::normal::Normal;
use super::pairs::{self, TOLD_APART};
use super::problem::Problem;
use super::rivals::{self, Beyond};
use super::search::FitSearch;
use crate::estimate::distance_m;
use crate::math::bisected;
use crate::response::MeanCount;

/// Most paths of one fit, which bounds its time.
const MOST_PATHS: usize = MOST_OWN + MOST_OTHERS;

/// A path whose significance is this many thresholds is not questioned again.
const SURE: f64 = 2.0;

/// All light that a scan shows.
#[derive(Debug)]
pub struct AllLight<'m> {
    pub hypothesis: Hypothesis<'m>,
    pub normal: Normal,
    /// What other hypotheses make of it.
    pub beyond_normal: Beyond,
    /// Standard deviation of a signed count, and signed counts of a step for a unit
    /// of a template's value and of light.
    pub sigma: f64,
    pub unit: f64,
    /// Numbers that the counts are.
    pub values: usize,
    /// As [`Weights`](super::weights::Weights) have it.
    pub most_correlated: f64,
}

/// All light that stands out, and the detector's own if it does.
pub fn all_light<'m>(
    air: &Air,
    problem: &Problem<'m>,
    known: &KnownMoments,
    measured: &[MeanCount],
) -> Result<AllLight<'m>, FitError> {
    let [light, own] = air.thresholds();
    let (mut search, mut here) = FitSearch::new(air, problem, known, measured)?;
    while here.parameters.paths.len() < MOST_PATHS {
        let place = search.strongest(&here, light);
        // Where other light is still missing, that makes one path look like two.
        let least_gain = place.as_ref().map_or(0.0, |place| place.sigmas.powi(2));
        here = match (told_pair(&search, &here, least_gain), place) {
            (Some(pair), _) => pair,
            (None, Some(place)) => search.with(&here, place.path(search.unit(&here)))?,
            (None, None) => break,
        };
    }
    if !here.parameters.paths.iter().any(|path| path.has(&air.known[0].code)) {
        let place = search.strongest_own(&here);
        if place.sigmas < own {
            return Err(FitError::OwnNotSeen { sigmas: place.sigmas, needed: own });
        }
        here = search.with(&here, place.path(search.unit(&here)))?;
    }
    loop {
        let (hypothesis, normal) = search.finished(here, known)?;
        if let Some(rest) = without_least_needed(&search, &hypothesis, &normal, light)? {
            here = rest;
            continue;
        }
        return Ok(AllLight {
            beyond_normal: rivals::beyond_normal(&search, &hypothesis, &normal),
            sigma: search.sigma(),
            unit: search.unit(&hypothesis),
            values: search.descent.weights.values(),
            most_correlated: search.descent.weights.most_correlated,
            hypothesis,
            normal,
        });
    }
}

/// The best pair in place of any path, if the counts tell it from one. It must gain more than
/// `least_gain`.
fn told_pair<'m>(
    search: &FitSearch<'_, 'm>,
    here: &Hypothesis<'m>,
    least_gain: f64,
) -> Option<Hypothesis<'m>> {
    let paths = 0..here.parameters.paths.len();
    let best = paths.filter_map(|path| {
        let best = pairs::pairs(search, here, path, least_gain).into_iter().next()?;
        Some((path, best))
    });
    let best = best.min_by(|(_, a), (_, b)| a.chi_square.total_cmp(&b.chi_square));
    best.filter(|(path, pair)| pairs::is_told_apart(here, pair, *path)).map(|(_, pair)| pair)
}

/// All light without the least significant path of another source, if that fits nearly as well: it may
/// have stood out only because other light was not fitted yet. Each path must lower chi-square by
/// the square of the threshold that it had to exceed.
fn without_least_needed<'m>(
    search: &FitSearch<'_, 'm>,
    here: &Hypothesis<'m>,
    normal: &Normal,
    threshold: f64,
) -> Result<Option<Hypothesis<'m>>, FitError> {
    let own = &search.air.known[0].code;
    let std = normal.standard_deviations();
    let is_sure = |path: usize| std[2 * path + 1] * SURE * threshold < 1.0;
    let mut best: Option<Hypothesis<'m>> = None;
    for (path, lit) in here.parameters.paths.iter().enumerate() {
        if !lit.has(own) && !is_sure(path) {
            let rest = search.without(here, path)?;
            let least = best.as_ref().map_or(f64::INFINITY, |best| best.chi_square);
            best = if rest.chi_square < least { Some(rest) } else { best };
        }
    }
    Ok(best.filter(|rest| rest.chi_square - here.chi_square < threshold * threshold))
}

/// Deviations that a pair must have on average to be told apart in 95 % of scans.
const IN_95_PERCENT: f64 = 1.645;

impl AllLight<'_> {
    /// The estimate: own paths first, the strongest of them first of all.
    pub fn estimate(&self, air: &Air, problem: &Problem) -> ModelEstimate {
        let fitted = &self.hypothesis;
        let mut parameters = fitted.parameters.clone();
        let own = &air.known[0];
        // A search does not know how many there are.
        let is_given = air.sets.is_empty();
        let room = |candidate: &KnownCode| if is_given { air.room(candidate, fitted) } else { 0 };
        let missing = room(own);
        let missing_of_others: usize = air.known[1..].iter().map(room).sum();
        let is_own = |path: usize| parameters.paths[path].has(&own.code);
        let rate = |path: usize| parameters.paths[path].ln_rate;
        let mut order: Vec<usize> = (0..parameters.paths.len()).collect();
        order.sort_by(|&a, &b| is_own(b).cmp(&is_own(a)).then(rate(b).total_cmp(&rate(a))));
        let resolution_chips = order.first().filter(|_| missing > 0).map_or(0.0, |&strongest| {
            self.resolution_chips(air, rate(strongest).exp() * self.unit)
        });
        let std = self.normal.standard_deviations();
        let std_of = |&path: &usize| {
            // Light in the middle of two paths is half their distance off.
            let hidden = if is_own(path) { 0.5 * resolution_chips } else { 0.0 };
            let [delay, ln_rate] = self.beyond_normal.variances[path];
            [
                (std[2 * path].powi(2) + delay + hidden * hidden).sqrt(),
                (std[2 * path + 1].powi(2) + ln_rate).sqrt(),
            ]
        };
        let std: Vec<f64> = order.iter().flat_map(std_of).collect();
        parameters.paths = order.iter().map(|&path| parameters.paths[path].clone()).collect();
        let found = Goodness {
            chi_square: fitted.chi_square,
            degrees_of_freedom: self.values.saturating_sub(parameters.len()),
            steps: air.axis.len(),
            iterations: fitted.iterations,
            most_correlated: self.most_correlated,
        };
        ModelEstimate {
            untold: (missing + missing_of_others > 0).then(|| Untold {
                missing,
                missing_of_others,
                resolution_m: distance_m(problem.clock().ps(resolution_chips)),
            }),
            told_apart_by: self.beyond_normal.least_fall.max(0.0).sqrt(),
            ..ModelEstimate::new(problem.clock(), &parameters, &std, found)
        }
    }

    /// How far apart two equal paths of light `height` in all must be, to be told apart
    /// in 95 % of scans.
    fn resolution_chips(&self, air: &Air, height: f64) -> f64 {
        let template = &air.known[0].matched.template;
        let needed = (TOLD_APART.sqrt() + IN_95_PERCENT).powi(2);
        let values = |delay: f64| -> Vec<f64> {
            let values = air.axis.values(template, delay).map(|[value, _]| value);
            air.axis.centred(&values.collect::<Vec<_>>())
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        // Squared residual of one path in the middle of two.
        let residual = |apart: f64| {
            let middle = 0.37 / air.axis.samples_per_chip;
            let [early, between, late] = [-0.5, 0.0, 0.5].map(|side| values(middle + side * apart));
            let both: Vec<f64> = early.iter().zip(&late).map(|(a, b)| 0.5 * (a + b)).collect();
            let shared = dot(&both, &between).powi(2) / dot(&between, &between);
            (dot(&both, &both) - shared).max(0.0) * (height / self.sigma).powi(2)
        };
        bisected([0.0, 2.0], 8, |apart| residual(apart) < needed)
    }
}
