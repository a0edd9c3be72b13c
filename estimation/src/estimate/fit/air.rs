//! The light that may reach a detector: known codes, and sets of unknown ones.

use std::sync::Arc;

use rayon::prelude::*;

use super::descent::Hypothesis;
use super::error::FitError;
use super::hadamard::{CodeSet, Scales};
use super::problem::Problem;
use super::template::{DelayAxis, Matched, Template};
use crate::code::Code;
use crate::math::{bisected, normal_cdf};
use crate::photons::DetectorModel;
use crate::scene::{DetectorIndex, OtherLight};
use crate::sensor::Sensor;

/// Share of scans in which noise may pass for light that is in the air for sure, be it
/// the detector's own or a scene's, and for light of unknown codes.
const FALSE_PLACE: f64 = 3e-3;
const FALSE_LIGHT: f64 = 1e-3;

/// Independent places per chip and code, by trial: thresholds hold the shares above.
const PLACES_PER_CHIP: f64 = 8.0;

/// Most paths of the own code, and of other sensors, where the scene does not say.
pub const MOST_OWN: usize = 4;
pub const MOST_OTHERS: usize = 8;

/// A code that light may have, and of how many paths.
#[derive(Debug, Clone)]
pub struct KnownCode {
    pub code: Arc<Code>,
    pub matched: Matched,
    pub most: usize,
}

/// A set of codes that unknown sensors may have.
#[derive(Debug)]
pub struct UnknownCodes {
    pub set: CodeSet,
    /// Powers of the templates, in the order of the codes' indices from -2 on.
    powers: Vec<f64>,
    /// Those of the codes that are not known.
    scales: Scales,
}

impl UnknownCodes {
    /// A set, the powers of its templates, and the indices of codes that are known.
    pub fn new(set: CodeSet, powers: Vec<f64>, known: &[i64]) -> UnknownCodes {
        let mut scales = Scales::of_powers(&powers);
        known.iter().for_each(|&index| scales.leave_out(index));
        UnknownCodes { set, powers, scales }
    }

    /// Power of the template of a code.
    pub fn power(&self, index: i64) -> f64 {
        self.powers[(index + 2) as usize]
    }

    /// The scales of the codes that no path has yet.
    pub fn scales_beside(&self, here: &Hypothesis) -> Scales {
        let mut scales = self.scales.clone();
        let found = here.parameters.paths.iter().filter_map(|path| self.set.index_of(&path.code));
        found.for_each(|index| scales.leave_out(index));
        scales
    }
}

/// The light that may be there, prepared for all scans of a detector.
#[derive(Debug)]
pub struct Air {
    pub axis: DelayAxis,
    /// Codes that are known, the detector's own first.
    pub known: Vec<KnownCode>,
    /// Sets of codes that unknown sensors may have.
    pub sets: Vec<UnknownCodes>,
    pub sigma_chips: f64,
}

/// The deviation that the largest of so many places exceeds in a share of scans.
fn threshold(places: f64, share: f64) -> f64 {
    bisected([0.0, 40.0], 60, |sigmas| places * normal_cdf(-sigmas) > share)
}

/// The deviation that own light must exceed that is looked for in so many chips.
pub fn own_threshold(chips: f64) -> f64 {
    threshold(PLACES_PER_CHIP * chips, FALSE_PLACE)
}

impl Air {
    /// The deviations that further light, and the own, must exceed.
    pub fn thresholds(&self) -> [f64; 2] {
        let own_chips = self.axis.len() as f64 / self.axis.samples_per_chip;
        let own = PLACES_PER_CHIP * own_chips;
        let unknown: f64 = self.sets.iter().map(|unknown| unknown.set.members() as f64).sum();
        let codes = self.known.len() as f64 + unknown;
        let share = if self.sets.is_empty() { FALSE_PLACE } else { FALSE_LIGHT };
        [threshold(codes * own, share), own_threshold(own_chips)]
    }

    /// The template of a code, known or not.
    pub fn template_of(&self, code: &Arc<Code>) -> Arc<Template> {
        let known = self.known.iter().find(|c| c.code.chips == code.chips);
        let template = match known {
            Some(candidate) => Some(candidate.matched.template.clone()),
            None => Template::new(&self.known[0].code, code, self.sigma_chips),
        };
        // Codes of other lengths are never candidates.
        Arc::new(template.unwrap_or_else(|| self.known[0].matched.template.clone()))
    }

    /// How many more paths a code may have.
    pub fn room(&self, candidate: &KnownCode, here: &Hypothesis) -> usize {
        let used = here.parameters.paths.iter().filter(|path| path.has(&candidate.code));
        candidate.most.saturating_sub(used.count())
    }
}

/// Whether a fit is of one path of the detector's own code, and looks for nothing else.
pub fn is_one_path(sensor: &Sensor, model: &DetectorModel, other: OtherLight) -> bool {
    let paths = known(sensor, model, other);
    other != OtherLight::Search && paths.iter().map(|(_, most)| most).sum::<usize>() == 1
}

/// Codes that a fit knows, the detector's own first, and of how many paths each.
fn known(sensor: &Sensor, model: &DetectorModel, other: OtherLight) -> Vec<(Arc<Code>, usize)> {
    let own_code = Arc::clone(&model.reference);
    match other {
        OtherLight::None => vec![(own_code, 1)],
        OtherLight::Search => vec![(own_code, MOST_OWN)],
        OtherLight::Given => {
            let mut known: Vec<(Arc<Code>, usize)> = vec![(own_code, 0)];
            let scene = sensor.scene();
            let sources =
                model.modulated_paths().map(|path| &scene.sources[scene.paths[path].source]);
            // The code of another clock is at no delay for a whole scan.
            for source in sources.filter(|source| source.clock.is_shared()) {
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

/// The light that may be in a scan.
///
/// # Errors
/// If a search is asked for without a set of codes, or the scan is too short for
/// light of other codes.
pub fn look_for(
    sensor: &Sensor,
    detector: DetectorIndex,
    other: OtherLight,
    problem: &Problem,
) -> Result<Air, FitError> {
    let codes = known(sensor, problem.model, other);
    let needs_all = codes.len() > 1 || other == OtherLight::Search;
    if needs_all && !sensor.timing().scan.is_full() {
        return Err(FitError::NeedsWholeScan {
            steps: sensor.timing().scan.steps,
            steps_per_period: sensor.timing().scan.steps_per_period,
        });
    }
    let axis = DelayAxis::new(sensor, detector, problem.tier, &problem.steps);
    let sigma_chips = problem.model.jitter_chips.unwrap_or(0.0);
    let own = Arc::clone(&codes[0].0);
    // A code of another length repeats at other times: none of its delays stands out.
    let matched = |code: &Arc<Code>| {
        Template::new(&own, code, sigma_chips).map(|template| Matched::new(template, &axis))
    };
    let known: Vec<KnownCode> = codes
        .iter()
        .filter_map(|(code, most)| {
            Some(KnownCode { matched: matched(code)?, code: Arc::clone(code), most: *most })
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
