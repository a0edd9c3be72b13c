//! What light a detector's fit looks for.

use std::sync::Arc;

use rayon::prelude::*;

use super::air::{Air, Candidate, MOST_OWN, UnknownCodes};
use super::error::FitError;
use super::hadamard::CodeSet;
use super::problem::Problem;
use super::template::{Axis, Matched, Template};
use crate::code::Code;
use crate::scene::{DetectorIndex, OtherLight};
use crate::sensor::Sensor;

/// Whether a fit is of one path of the detector's own code, and looks for nothing else.
pub fn is_one_path(sensor: &Sensor, detector: DetectorIndex, other: OtherLight) -> bool {
    let paths = known(sensor, detector, other);
    other != OtherLight::Search && paths.iter().map(|(_, most)| most).sum::<usize>() == 1
}

/// Codes that a fit knows, the detector's own first, and of how many paths each.
pub fn known(
    sensor: &Sensor,
    detector: DetectorIndex,
    other: OtherLight,
) -> Vec<(Arc<Code>, usize)> {
    let scene = sensor.scene();
    let own = scene.detectors[detector].reference;
    let own_code = Arc::clone(&scene.sources[own].code);
    match other {
        OtherLight::None => vec![(own_code, 1)],
        OtherLight::Search => vec![(own_code, MOST_OWN)],
        OtherLight::Given => {
            let mut known: Vec<(Arc<Code>, usize)> = vec![(own_code, 0)];
            for path in scene.paths.iter().filter(|path| path.detector == detector) {
                let source = &scene.sources[path.source];
                // The code of another clock is at no delay for a whole scan.
                if !scene.carries_code(path) || !source.clock.is_shared() {
                    continue;
                }
                match known.iter_mut().find(|(code, _)| code.chips == source.code.chips) {
                    Some((_, paths)) => *paths += 1,
                    None => known.push((Arc::clone(&source.code), 1)),
                }
            }
            known[0].1 = known[0].1.max(1);
            known
        }
    }
}

/// What may be in the air of a scan.
///
/// # Errors
/// When a search is asked for without a set of codes, or the scan is too short for
/// light of other codes.
pub fn air(
    sensor: &Sensor,
    detector: DetectorIndex,
    other: OtherLight,
    problem: &Problem,
) -> Result<Air, FitError> {
    let codes = known(sensor, detector, other);
    let needs_all = codes.len() > 1 || other == OtherLight::Search;
    if needs_all && !sensor.timing().scan.is_full() {
        return Err(FitError::NeedsWholeScan {
            steps: sensor.timing().scan.steps,
            steps_per_period: sensor.timing().scan.steps_per_period,
        });
    }
    let axis = Axis::new(sensor, detector, problem.tier, &problem.steps);
    let sigma_chips = problem.model.jitter_chips.unwrap_or(0.0);
    let own = Arc::clone(&codes[0].0);
    // A code of another length repeats at other times: none of its delays stands out.
    let matched = |code: &Arc<Code>| {
        Template::new(&own, code, sigma_chips).map(|template| Matched::new(template, &axis))
    };
    let known: Vec<Candidate> = codes
        .iter()
        .filter_map(|(code, most)| {
            Some(Candidate { matched: matched(code)?, code: Arc::clone(code), most: *most })
        })
        .collect();
    let mut sets = Vec::new();
    if other == OtherLight::Search {
        for set in sets_of(sensor, &own)? {
            let excluded: Vec<i64> = set.index_of(&own).into_iter().collect();
            let powers = powers(&set, &own, axis.samples_per_chip)?;
            sets.push(UnknownCodes::new(set, powers, &excluded));
        }
    }
    Ok(Air { axis, known, sets, sigma_chips })
}

/// Powers of the templates of a set's codes, in the order of their indices.
fn powers(set: &CodeSet, own: &Code, samples_per_chip: f64) -> Result<Vec<f64>, FitError> {
    let power = |index: i64| {
        let code = set.code(index).map_err(|_| FitError::NoGoldSet)?;
        let template = Template::new(own, &code, 0.0).ok_or(FitError::NoGoldSet)?;
        Ok(template.power(samples_per_chip))
    };
    (-2..set.members() as i64 - 2).into_par_iter().map(power).collect()
}

/// The own code's set, and those of the scene's other sources.
fn sets_of(sensor: &Sensor, own: &Arc<Code>) -> Result<Vec<CodeSet>, FitError> {
    let codes =
        std::iter::once(own).chain(sensor.scene().sources.iter().map(|source| &source.code));
    let mut sets: Vec<CodeSet> = Vec::new();
    for code in codes.filter(|code| code.len() == own.len()) {
        if sets.iter().any(|set| set.index_of(code).is_some()) {
            continue;
        }
        sets.extend(CodeSet::of(code));
    }
    match sets.is_empty() {
        true => Err(FitError::NoGoldSet),
        false => Ok(sets),
    }
}
