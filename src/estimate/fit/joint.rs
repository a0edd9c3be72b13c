//! Finding all light of a scan: one source of light after another, where what the
//! light so far leaves over stands out, and all of it fitted anew each time.
//!
//! What is left over is taken from the exact expected counts. Against a linear model
//! dead time would make ghosts: it multiplies the light with itself, and a product of
//! shifted Gold codes is a Gold code of the same set.

use std::sync::Arc;

use goldtof_fft::Planner;
use rustfft::num_complex::Complex64;

use super::FitError;
use super::descent::{Descent, Hypothesis};
use super::gauss_newton::WEIGHED_SIGMAS;
use super::hadamard::CodeSet;
use super::known_moments::KnownMoments;
use super::least_squares::Normal;
use super::pairs::{self, Split};
use super::problem::{Parameters, PathParameters, Problem};
use super::template::{Axis, Matched, Template};
use crate::code::Code;
use crate::math::normal_cdf;
use crate::response::MeanCount;

/// Share of scans in which noise may pass for light that is in the air for sure, be it
/// the detector's own or a scene's, and for light of unknown codes.
const FALSE_PLACE: f64 = 3e-3;
const FALSE_LIGHT: f64 = 1e-3;

/// Independent places per chip and code, by trial: thresholds hold the shares above.
const PLACES_PER_CHIP: f64 = 8.0;

/// Further light of a code is looked for this far from its fitted paths; nearer paths
/// are a matter of [`pairs`].
const APART_CHIPS: f64 = 1.25;

/// Most paths of one fit: bounds its time.
const MOST_PATHS: usize = 12;
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

/// What may be in the air, prepared for all scans of a detector.
#[derive(Debug)]
pub struct Air {
    pub axis: Axis,
    /// Codes that are known, the detector's own first.
    pub known: Vec<Candidate>,
    /// Sets of codes that unknown sensors may have, each with the power of a template
    /// and the indices of the codes that are known.
    pub sets: Vec<(CodeSet, f64, Vec<i64>)>,
    pub sigma_chips: f64,
}

/// All light that a scan shows.
#[derive(Debug)]
pub struct Found {
    pub hypothesis: Hypothesis,
    pub normal: Normal,
    /// How much each delay may be off for a hypothesis that fits nearly as well, in
    /// chips: to be added to its standard deviation, squared.
    pub ambiguity_chips: Vec<f64>,
    /// Standard deviation of a signed count, and signed counts of a step for a unit
    /// of a template's value and of light.
    pub sigma: f64,
    pub unit: f64,
    /// Numbers that the counts are.
    pub values: usize,
}

/// The deviation that the largest of so many places exceeds in a share of scans.
pub fn threshold(places: f64, share: f64) -> f64 {
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

impl Air {
    /// The deviations that further light, and the own, must exceed.
    pub fn thresholds(&self) -> [f64; 2] {
        let own = PLACES_PER_CHIP * self.axis.len() as f64 / self.axis.samples_per_chip;
        let unknown: f64 = self.sets.iter().map(|(set, ..)| set.members() as f64).sum();
        let codes = self.known.len() as f64 + unknown;
        let share = if self.sets.is_empty() {
            FALSE_PLACE
        } else {
            FALSE_LIGHT
        };
        [threshold(codes * own, share), threshold(own, FALSE_PLACE)]
    }

    fn template_of(&self, code: &Arc<Code>) -> Arc<Template> {
        let known = self.known.iter().find(|c| c.code.chips == code.chips);
        let template = match known {
            Some(candidate) => Some(candidate.matched.template.clone()),
            None => Template::new(&self.known[0].code, code, self.sigma_chips),
        };
        // Codes of other lengths are never candidates.
        Arc::new(template.unwrap_or_else(|| self.known[0].matched.template.clone()))
    }

    /// How many more paths a code may have.
    fn room(&self, candidate: &Candidate, here: &Hypothesis) -> usize {
        let used = here
            .codes
            .iter()
            .filter(|c| c.chips == candidate.code.chips);
        candidate.most.saturating_sub(used.count())
    }
}

/// A place where light stands out.
struct Place {
    code: Arc<Code>,
    delay_chips: f64,
    sigmas: f64,
    /// In units of the template.
    height: f64,
}

/// Searches a scan.
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
    ) -> Result<(Search<'a, 'm>, Hypothesis), FitError> {
        let model = problem.model;
        let detected = measured.iter().map(|count| count.total).sum::<f64>()
            / (measured.len() as f64 * air.axis.chips);
        let dead = (detected * model.dead_time_chips).min(0.95);
        let constant = detected / (1.0 - dead);
        let background = Parameters {
            paths: Vec::new(),
            constant,
        };
        let nothing = Problem {
            codes: Vec::new(),
            ..problem.clone()
        };
        let expected = nothing.means(&background)?;
        let weights = known.scan_weights(&nothing, &background, &expected, &air.axis)?;
        let descent = Descent {
            problem,
            measured,
            axis: &air.axis,
            weights,
        };
        let start = descent.hypothesis(Vec::new(), background)?;
        let search = Search { air, descent };
        let start = search.descent.roughly(start, &[])?;
        Ok((search, start))
    }

    /// All light that stands out, and the detector's own if it does.
    pub fn run(mut self, start: Hypothesis, known: &KnownMoments) -> Result<Found, FitError> {
        let [light, own] = self.air.thresholds();
        let mut here = start;
        let mut ambiguous = None;
        while here.codes.len() < MOST_PATHS {
            let place = self.strongest(&here, light);
            // Where other light is still missing, that makes one path look like two.
            let least_gain = place.as_ref().map_or(0.0, |place| place.sigmas.powi(2));
            if let Some(split) = self.split(&here, least_gain)? {
                let is_pair = split.is_pair;
                ambiguous = Some(split.clone());
                if is_pair {
                    here = split.hypothesis;
                    continue;
                }
            }
            let Some(place) = place else {
                break;
            };
            here = self.with(&here, &place)?;
        }
        if !self.has_own(&here) {
            let place = self.strongest_own(&here);
            if place.sigmas < own {
                return Err(FitError::OwnNotSeen {
                    sigmas: place.sigmas,
                    needed: own,
                });
            }
            here = self.with(&here, &place)?;
        }
        self.finish(here, ambiguous, known)
    }

    fn finish(
        &mut self,
        here: Hypothesis,
        ambiguous: Option<Split>,
        known: &KnownMoments,
    ) -> Result<Found, FitError> {
        let problem = self.descent.problem_of(&here.codes);
        let axis = &self.air.axis;
        let (mut hypothesis, mut normal) = (here, None);
        for _ in 0..problem.most_weighings() {
            let (parameters, expected) = (&hypothesis.parameters, &hypothesis.expected);
            self.descent.weights = known.scan_weights(&problem, parameters, expected, axis)?;
            let before = parameters.clone();
            let (settled, found) = self.descent.exactly(self.descent.weighed(hypothesis))?;
            let moved = found.largest_step_sigmas(&settled.parameters.minus(&before));
            (hypothesis, normal) = (settled, Some(found));
            if moved < WEIGHED_SIGMAS {
                break;
            }
        }
        let normal = normal.ok_or(FitError::NotConverged)?;
        let sigma = self.sigma();
        let values = self.descent.weights.values();
        let [pattern, _] = self.descent.gains(
            &hypothesis.codes,
            &hypothesis.parameters,
            &hypothesis.expected,
        );
        Ok(Found {
            ambiguity_chips: ambiguity(&hypothesis, ambiguous.as_ref()),
            unit: pattern * axis.periods,
            hypothesis,
            normal,
            sigma,
            values,
        })
    }

    fn has_own(&self, here: &Hypothesis) -> bool {
        let own = &self.air.known[0].code.chips;
        here.codes.iter().any(|code| &code.chips == own)
    }

    fn templates(&self, codes: &[Arc<Code>]) -> Vec<Arc<Template>> {
        codes
            .iter()
            .map(|code| self.air.template_of(code))
            .collect()
    }

    fn residual(&self, here: &Hypothesis) -> Vec<f64> {
        let pairs = self.descent.measured.iter().zip(&here.expected);
        pairs
            .map(|(count, mean)| count.signed - mean.signed)
            .collect()
    }

    /// Signed counts of a step for a unit of a template's value and of light.
    fn unit(&self, here: &Hypothesis) -> f64 {
        let [pattern, _] = self
            .descent
            .gains(&here.codes, &here.parameters, &here.expected);
        pattern * self.air.axis.periods
    }

    /// The same light and some at `place`, fitted.
    fn with(&self, here: &Hypothesis, place: &Place) -> Result<Hypothesis, FitError> {
        let rate = (place.height / self.unit(here)).max(1e-9);
        let mut codes = here.codes.clone();
        codes.push(Arc::clone(&place.code));
        let problem = self.descent.problem_of(&codes);
        let mut parameters = here.parameters.clone();
        let path = PathParameters {
            delay_chips: place.delay_chips,
            ln_rate: rate.ln(),
        };
        parameters.add_path(path, &problem);
        let templates = self.templates(&codes);
        let start = self.descent.near_hypothesis(here, codes, parameters)?;
        self.descent.roughly(start, &templates)
    }

    /// Whether some place is a fitted path's, or next to one.
    fn is_taken(&self, here: &Hypothesis, code: &Code, delay_chips: f64) -> bool {
        let length = code.len() as f64;
        let paths = here.codes.iter().zip(&here.parameters.paths);
        paths
            .filter(|(fitted, _)| fitted.chips == code.chips)
            .any(|(_, path)| {
                let turns = (path.delay_chips - delay_chips) / length;
                (turns - turns.round()).abs() * length <= APART_CHIPS
            })
    }

    /// The place that stands out most, if it is above `threshold`.
    fn strongest(&self, here: &Hypothesis, threshold: f64) -> Option<Place> {
        let residual = self.residual(here);
        let known = self.air.known.iter().filter(|c| self.air.room(c, here) > 0);
        let known = known.map(|candidate| self.best_of(here, &residual, candidate));
        let others = here.codes.iter().filter(|code| {
            self.air
                .known
                .iter()
                .all(|candidate| candidate.code.chips != code.chips)
        });
        let unknown = match others.count() < MOST_OTHERS {
            true => self.best_unknown(here, &residual),
            false => Vec::new(),
        };
        let places = known
            .chain(unknown)
            .filter(|place| place.sigmas > threshold);
        places.max_by(|a, b| a.sigmas.total_cmp(&b.sigmas))
    }

    fn strongest_own(&self, here: &Hypothesis) -> Place {
        self.best_of(here, &self.residual(here), &self.air.known[0])
    }

    fn best_of(&self, here: &Hypothesis, residual: &[f64], candidate: &Candidate) -> Place {
        let axis = &self.air.axis;
        let products = candidate.matched.products(axis, residual);
        let power = candidate.matched.power();
        let mut best = (0, f64::NEG_INFINITY);
        for (place, &product) in products.iter().enumerate() {
            let delay = axis.delay_at(place as f64);
            if product > best.1 && !self.is_taken(here, &candidate.code, delay) {
                best = (place, product);
            }
        }
        Place {
            code: Arc::clone(&candidate.code),
            delay_chips: axis.delay_at(best.0 as f64),
            sigmas: best.1 / (power.sqrt() * self.sigma()),
            height: best.1 / power,
        }
    }

    /// The best place of each set of unknown codes.
    fn best_unknown(&self, here: &Hypothesis, residual: &[f64]) -> Vec<Place> {
        if self.air.sets.is_empty() {
            return Vec::new();
        }
        let axis = &self.air.axis;
        let samples = axis.samples_per_chip as usize;
        let values = axis.centred(residual);
        let sub_phases: Vec<usize> = match samples {
            1 => vec![0],
            _ => vec![0, samples / 2],
        };
        let images: Vec<Vec<f64>> = sub_phases
            .iter()
            .map(|&phase| image(&values, samples, phase, &self.air.known[0].code))
            .collect();
        let mut places = Vec::new();
        for (set, power, excluded) in &self.air.sets {
            let found: Vec<i64> = here
                .codes
                .iter()
                .filter_map(|code| set.index_of(code))
                .collect();
            let best = images
                .iter()
                .zip(&sub_phases)
                .filter_map(|(image, &phase)| {
                    let allowed =
                        |index: i64| !excluded.contains(&index) && !found.contains(&index);
                    set.best(image, allowed).map(|cell| (cell, phase))
                });
            let best = best.max_by(|(a, _), (b, _)| a.product.total_cmp(&b.product));
            let Some((cell, phase)) = best else { continue };
            let Ok(code) = set.code(cell.index) else {
                continue;
            };
            places.push(Place {
                code: Arc::new(code),
                delay_chips: axis.delay_at((cell.chip * samples + phase) as f64),
                sigmas: cell.product / (power.sqrt() * self.sigma()),
                height: cell.product / power,
            });
        }
        places
    }

    /// The best way to take a path for two that are close together, with a say on
    /// whether the counts tell.
    /// Pairs must gain more than `least_gain`.
    fn split(&self, here: &Hypothesis, least_gain: f64) -> Result<Option<Split>, FitError> {
        let residual = self.residual(here);
        let sigma = self.sigma();
        let mut best: Option<Split> = None;
        for candidate in self.air.known.iter().filter(|c| self.air.room(c, here) > 0) {
            let products = candidate.matched.products(&self.air.axis, &residual);
            for path in 0..here.codes.len() {
                if here.codes[path].chips != candidate.code.chips {
                    continue;
                }
                let found = pairs::split(&pairs::Close {
                    search: self,
                    here,
                    path,
                    matched: &candidate.matched,
                    products: &products,
                    sigma,
                    unit: self.unit(here),
                    least_gain,
                })?;
                let is_better = |split: &Split| {
                    best.as_ref()
                        .is_none_or(|b| split.hypothesis.chi_square < b.hypothesis.chi_square)
                };
                if let Some(split) = found.filter(is_better) {
                    best = Some(split);
                }
            }
        }
        Ok(best)
    }

    /// Two paths in place of one, fitted.
    pub fn with_pair(
        &self,
        here: &Hypothesis,
        path: usize,
        pair: [PathParameters; 2],
    ) -> Result<Hypothesis, FitError> {
        let mut codes = here.codes.clone();
        codes.push(Arc::clone(&here.codes[path]));
        let mut parameters = here.parameters.clone();
        parameters.paths[path] = pair[0];
        parameters.paths.push(pair[1]);
        let templates = self.templates(&codes);
        let start = self.descent.near_hypothesis(here, codes, parameters)?;
        self.descent.roughly(start, &templates)
    }

    /// Standard deviation of a signed count.
    fn sigma(&self) -> f64 {
        self.descent
            .weights
            .signed_sigma(self.air.axis.samples_per_chip)
    }

    /// Where the scan's steps are.
    pub fn axis(&self) -> &Axis {
        &self.air.axis
    }
}

/// What a scan is an image of, at one sub-chip phase: its values, gathered by the
/// shape of a peak and convolved with the reference.
fn image(values: &[f64], samples: usize, phase: usize, reference: &Code) -> Vec<f64> {
    let length = reference.chips.len();
    let steps = values.len();
    let gathered = (0..length).map(|chip| {
        let middle = chip * samples + phase;
        let offsets = 1..samples;
        let beside = offsets.map(|offset| {
            let share = 1.0 - offset as f64 / samples as f64;
            let both =
                values[(middle + offset) % steps] + values[(middle + steps - offset) % steps];
            share * both
        });
        Complex64::from(values[middle] + beside.sum::<f64>())
    });
    let mut spectrum: Vec<Complex64> = gathered.collect();
    let signs = reference
        .chips
        .iter()
        .map(|&c| Complex64::from(2.0 * f64::from(c) - 1.0));
    let mut code: Vec<Complex64> = signs.collect();
    let mut planner = Planner::new();
    planner.forward(length).process(&mut spectrum);
    planner.forward(length).process(&mut code);
    for (value, code) in spectrum.iter_mut().zip(&code) {
        *value *= code;
    }
    planner.inverse(length).process(&mut spectrum);
    spectrum.iter().map(|v| v.re / length as f64).collect()
}

/// How far off each delay may be for a hypothesis that fits nearly as well.
fn ambiguity(hypothesis: &Hypothesis, split: Option<&Split>) -> Vec<f64> {
    let paths = &hypothesis.parameters.paths;
    let mut squares = vec![0.0; paths.len()];
    let Some(split) = split else { return squares };
    for (delay, square) in paths.iter().map(|p| p.delay_chips).zip(&mut squares) {
        *square = split.spread_of(delay);
    }
    squares.iter().map(|square| f64::sqrt(*square)).collect()
}
