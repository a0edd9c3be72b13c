//! Finding all light of a scan: one source of light after another, where what the
//! light so far leaves over stands out, and all of it fitted anew each time.
//!
//! What is left over is taken from the exact expected counts. Against a linear model
//! dead time would make ghosts: it multiplies the light with itself, and a product of
//! shifted Gold codes is a Gold code of the same set.

use super::air::Air;
use super::descent::Hypothesis;
use super::error::FitError;
use super::known_moments::KnownMoments;
use super::normal::Normal;
use super::pairs::{self, Split};
use super::problem::Problem;
use super::ridge;
use super::search::Search;
use crate::response::MeanCount;

/// Most paths of one fit: bounds its time.
const MOST_PATHS: usize = 12;

/// Light that is above none by so many thresholds is there.
const SURE: f64 = 2.0;

/// All light that a scan shows.
#[derive(Debug)]
pub struct Found<'m> {
    pub hypothesis: Hypothesis<'m>,
    pub normal: Normal,
    /// To be added to the variances of each path's delay (chips^2) and ln(strength): for other
    /// hypotheses that fit nearly as well, and for what no covariance shows.
    pub beyond_normal: Vec<[f64; 2]>,
    /// Standard deviation of a signed count, and signed counts of a step for a unit
    /// of a template's value and of light.
    pub sigma: f64,
    pub unit: f64,
    /// Numbers that the counts are.
    pub values: usize,
}

/// All light that stands out, and the detector's own if it does.
pub fn all_light<'m>(
    air: &Air,
    problem: &Problem<'m>,
    known: &KnownMoments,
    measured: &[MeanCount],
) -> Result<Found<'m>, FitError> {
    let [light, own] = air.thresholds();
    let (mut search, mut here) = Search::new(air, problem, known, measured)?;
    let mut ambiguous: Vec<Split> = Vec::new();
    while here.codes.len() < MOST_PATHS {
        let place = search.strongest(&here, light);
        // Where other light is still missing, that makes one path look like two.
        let least_gain = place.as_ref().map_or(0.0, |place| place.sigmas.powi(2));
        if let Some(split) = split(&search, &here, least_gain) {
            let pair = split.is_pair.then(|| split.hypothesis.clone());
            ambiguous.push(split);
            if let Some(pair) = pair {
                here = pair;
                continue;
            }
        }
        let Some(place) = place else {
            break;
        };
        here = search.with(&here, &place.code, place.path(search.unit(&here)))?;
    }
    if !has_own(air, &here) {
        let place = search.strongest_own(&here);
        if place.sigmas < own {
            return Err(FitError::OwnNotSeen { sigmas: place.sigmas, needed: own });
        }
        here = search.with(&here, &place.code, place.path(search.unit(&here)))?;
    }
    let splits = ambiguous.into_iter();
    let mut doubts: Vec<Split> = splits.filter_map(|s| beside_all(&search, &here, s)).collect();
    loop {
        let found = finish(&mut search, here, &doubts, known)?;
        let Some((path, rest)) = find_in_doubt(&search, &found, light)? else {
            return Ok(found);
        };
        doubts = doubts.into_iter().filter_map(|split| split.without(path)).collect();
        here = rest;
    }
}

/// The path of another source that the counts need least, by number, and all light without it,
/// if that fits nearly as well: light that stood out before all was fitted may be what that
/// lacked then. A find must lower chi-square as much as it had to stand out.
fn find_in_doubt<'m>(
    search: &Search<'_, 'm>,
    found: &Found<'m>,
    threshold: f64,
) -> Result<Option<(usize, Hypothesis<'m>)>, FitError> {
    let own = &search.air.known[0].code.chips;
    let here = &found.hypothesis;
    let std = found.normal.standard_deviations();
    let is_sure = |path: usize| std[2 * path + 1] * SURE * threshold < 1.0;
    let mut least: Option<(f64, usize, Hypothesis<'m>)> = None;
    for path in 0..here.codes.len() {
        if &here.codes[path].chips == own || is_sure(path) {
            continue;
        }
        let rest = search.without(here, path)?;
        let gain = rest.chi_square - here.chi_square;
        if gain < threshold * threshold && least.as_ref().is_none_or(|(least, ..)| gain < *least) {
            least = Some((gain, path, rest));
        }
    }
    Ok(least.map(|(_, path, rest)| (path, rest)))
}

/// What a split says now that all light is found: that may leave no room for what was likely
/// without it. `None` for one path that was not taken for two, since that was tried anew.
fn beside_all<'m>(
    search: &Search<'_, 'm>,
    here: &Hypothesis<'m>,
    split: Split<'m>,
) -> Option<Split<'m>> {
    if split.paths_when_taken() == here.codes.len() {
        return Some(split);
    }
    let &[first, second] = &split.paths[..] else {
        return None;
    };
    let code = &here.codes[first].chips;
    let known = &search.air.known;
    let Some(candidate) = known.iter().find(|known| &known.code.chips == code) else {
        return Some(split);
    };
    // One path in their place that leads nowhere is none.
    let Ok(one) = search.with_one(here, [first, second]) else {
        return None;
    };
    let close = pairs::Close {
        search,
        here: &one,
        path: first,
        matched: &candidate.matched,
        products: &candidate.matched.products(&search.air.axis, &search.residual(&one)),
        sigma: search.sigma(),
        unit: search.unit(&one),
        least_gain: 0.0,
    };
    Some(split.beside(&close, here.chi_square))
}

/// The last fit, with exact derivatives and weights of the light that was found.
fn finish<'m>(
    search: &mut Search<'_, 'm>,
    here: Hypothesis<'m>,
    doubts: &[Split],
    known: &KnownMoments,
) -> Result<Found<'m>, FitError> {
    let (hypothesis, normal) = search.descent.exactly_weighed(here, known)?;
    let sigma = search.sigma();
    let values = search.descent.weights.values();
    let [pattern, _] =
        search.descent.gains(&hypothesis.codes, &hypothesis.parameters, &hypothesis.expected);
    Ok(Found {
        beyond_normal: beyond_normal(search, &hypothesis, &normal, doubts),
        unit: pattern * search.air.axis.periods,
        hypothesis,
        normal,
        sigma,
        values,
    })
}

/// Whether some path has the detector's own code.
fn has_own(air: &Air, here: &Hypothesis) -> bool {
    let own = &air.known[0].code.chips;
    here.codes.iter().any(|code| &code.chips == own)
}

/// The best way to take a path for two that are close together, with a say on
/// whether the counts tell.
/// Pairs must gain more than `least_gain`.
fn split<'m>(search: &Search<'_, 'm>, here: &Hypothesis<'m>, least_gain: f64) -> Option<Split<'m>> {
    let residual = search.residual(here);
    let sigma = search.sigma();
    let mut best: Option<Split> = None;
    for candidate in search.air.known.iter().filter(|c| search.air.room(c, here) > 0) {
        let products = candidate.matched.products(&search.air.axis, &residual);
        for path in 0..here.codes.len() {
            if here.codes[path].chips != candidate.code.chips {
                continue;
            }
            let found = pairs::split(&pairs::Close {
                search,
                here,
                path,
                matched: &candidate.matched,
                products: &products,
                sigma,
                unit: search.unit(here),
                least_gain,
            });
            let is_better = |split: &Split| {
                best.as_ref().is_none_or(|b| split.hypothesis.chi_square < b.hypothesis.chi_square)
            };
            if let Some(split) = found.filter(is_better) {
                best = Some(split);
            }
        }
    }
    best
}

/// What the normal equations do not say of each path's delay (chips^2) and ln(strength): to be
/// added to their variances.
fn beyond_normal<'m>(
    search: &Search<'_, 'm>,
    hypothesis: &Hypothesis<'m>,
    normal: &Normal,
    doubts: &[Split],
) -> Vec<[f64; 2]> {
    let paths = &hypothesis.parameters.paths;
    let mut spread = vec![0.0; paths.len()];
    // Each says all there is of a path's variance, so that the largest holds.
    let mut bent: Vec<Option<[f64; 2]>> = vec![None; paths.len()];
    // Other paths nearby are in either hypothesis.
    for split in doubts {
        for &path in &split.paths {
            spread[path] += split.spread_of(paths[path].delay_chips);
        }
        let &[first, second] = &split.paths[..] else {
            continue;
        };
        let valley = ridge::beyond_normal(search, hypothesis, normal, [first, second]);
        for (path, added) in [first, second].into_iter().zip(valley.into_iter().flatten()) {
            bent[path] = Some(match bent[path] {
                Some(known) => [known[0].max(added[0]), known[1].max(added[1])],
                None => added,
            });
        }
    }
    let both = spread.into_iter().zip(bent);
    both.map(|(spread, bent)| {
        let [delay, ln_rate] = bent.unwrap_or_default();
        [spread + delay, ln_rate]
    })
    .collect()
}
