//! Where the residual of a scan stands out: a code and a delay.

use std::sync::Arc;

use super::air::{KnownCode, MOST_OTHERS};
use super::descent::Hypothesis;
use super::hadamard::HadamardCell;
use super::parameters::PathParameters;
use super::search::FitSearch;
use super::template::{real, spectrum};
use crate::code::Code;

/// Further light of a code is searched for at least this far from its fitted paths; nearer paths
/// are left to [`super::pairs`].
const APART_CHIPS: f64 = 1.25;

/// A place where light stands out.
pub struct StandingOut {
    code: Arc<Code>,
    delay_chips: f64,
    pub sigmas: f64,
    /// In units of the template.
    height: f64,
}

impl StandingOut {
    /// A path there, where a template's height of `unit` is a unit of light.
    pub fn path(&self, unit: f64) -> PathParameters {
        PathParameters {
            code: Arc::clone(&self.code),
            delay_chips: self.delay_chips,
            ln_rate: (self.height / unit).max(1e-9).ln(),
        }
    }
}

impl FitSearch<'_, '_> {
    /// The place that stands out most, if it is above `threshold`.
    pub fn strongest(&self, here: &Hypothesis, threshold: f64) -> Option<StandingOut> {
        let residual = self.residual(here);
        let known = self.air.known.iter().filter(|c| self.air.room(c, here) > 0);
        let known = known.map(|candidate| self.best_of(here, &residual, candidate));
        let others = here
            .parameters
            .paths
            .iter()
            .filter(|path| self.air.known.iter().all(|candidate| !path.has(&candidate.code)));
        let unknown = match others.count() < MOST_OTHERS {
            true => self.best_unknown(here, &residual),
            false => Vec::new(),
        };
        let places = known.chain(unknown).filter(|place| place.sigmas > threshold);
        places.max_by(|a, b| a.sigmas.total_cmp(&b.sigmas))
    }

    /// The likeliest place of the detector's own light.
    pub fn strongest_own(&self, here: &Hypothesis) -> StandingOut {
        self.best_of(here, &self.residual(here), &self.air.known[0])
    }

    fn best_of(&self, here: &Hypothesis, residual: &[f64], candidate: &KnownCode) -> StandingOut {
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
        StandingOut {
            code: Arc::clone(&candidate.code),
            delay_chips: axis.delay_at(best.0 as f64),
            sigmas: best.1 / (power.sqrt() * self.sigma()),
            height: best.1 / power,
        }
    }

    /// The best place of each set of unknown codes.
    fn best_unknown(&self, here: &Hypothesis, residual: &[f64]) -> Vec<StandingOut> {
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
        for unknown in &self.air.sets {
            let scales = unknown.scales_beside(here);
            let best = images.iter().zip(&sub_phases).filter_map(|(image, &phase)| {
                unknown.set.best(image, &scales).map(|cell| (cell, phase))
            });
            let sigmas = |cell: &HadamardCell| {
                cell.product / (unknown.power(cell.index).sqrt() * self.sigma())
            };
            let best = best.max_by(|(a, _), (b, _)| sigmas(a).total_cmp(&sigmas(b)));
            let Some((cell, phase)) = best else { continue };
            let Ok(code) = unknown.set.code(cell.index) else {
                continue;
            };
            places.push(StandingOut {
                code: Arc::new(code),
                delay_chips: axis.delay_at((cell.chip * samples + phase) as f64),
                sigmas: sigmas(&cell),
                height: cell.product / unknown.power(cell.index),
            });
        }
        places
    }

    /// Whether some place is a fitted path's, or next to one.
    fn is_taken(&self, here: &Hypothesis, code: &Code, delay_chips: f64) -> bool {
        let length = code.len() as f64;
        here.parameters.paths.iter().filter(|path| path.has(code)).any(|path| {
            let turns = (path.delay_chips - delay_chips) / length;
            (turns - turns.round()).abs() * length <= APART_CHIPS
        })
    }
}

/// The values of a scan at one sub-chip phase, weighted with the shape of a peak and convolved with
/// the reference: a code in the light shows in it as its chips.
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
        values[middle] + beside.sum::<f64>()
    });
    let signs = reference.chips.iter().map(|&chip| 2.0 * f64::from(chip) - 1.0);
    let both = spectrum(gathered).into_iter().zip(spectrum(signs));
    real(both.map(|(value, code)| value * code).collect())
}
