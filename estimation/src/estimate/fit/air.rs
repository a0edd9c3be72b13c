//! What light may be in the air.

use std::sync::Arc;

use super::descent::Hypothesis;
use super::hadamard::{CodeSet, Scales};
use super::template::{Axis, Matched, Template};
use crate::code::Code;
use crate::math::normal_cdf;

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
pub struct Candidate {
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
        let found = here.codes.iter().filter_map(|code| self.set.index_of(code));
        found.for_each(|index| scales.leave_out(index));
        scales
    }
}

/// What may be in the air, prepared for all scans of a detector.
#[derive(Debug)]
pub struct Air {
    pub axis: Axis,
    /// Codes that are known, the detector's own first.
    pub known: Vec<Candidate>,
    /// Sets of codes that unknown sensors may have.
    pub sets: Vec<UnknownCodes>,
    pub sigma_chips: f64,
}

/// The deviation that the largest of so many places exceeds in a share of scans.
fn threshold(places: f64, share: f64) -> f64 {
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match places * normal_cdf(-middle) > share {
            true => low = middle,
            false => high = middle,
        }
    }
    high
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
    pub fn room(&self, candidate: &Candidate, here: &Hypothesis) -> usize {
        let used = here.codes.iter().filter(|c| c.chips == candidate.code.chips);
        candidate.most.saturating_sub(used.count())
    }
}
