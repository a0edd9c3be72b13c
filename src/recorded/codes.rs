//! Which code the counts show, if not the scene's.

use std::sync::Arc;

use goldtof_fft::Planner;
use rustfft::Fft;
use rustfft::num_complex::Complex64;

use super::observed::Observed;
use crate::code::{Code, Generator, GoldSet};
use crate::photons::StepCount;
use crate::scan::Step;
use crate::scene::Scene;

/// Most codes times chips that are searched: some ten seconds.
const MOST_WORK: u64 = 1 << 27;

/// A code of the light and one of the reference, and where they fit the counts best.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    /// What a person would call the code.
    pub name: String,
    pub code: Arc<Code>,
    /// Whether the reference has it too, or the scene's own.
    pub of_reference: bool,
    /// Delay of the light's peak, in phase steps.
    pub at_step: u64,
    /// Height of the peak over the noise.
    pub sigmas: f64,
}

/// The best candidates besides the scene's own code: for the light alone, and for
/// light and reference both; and how many there were.
///
/// # Errors
/// Why there is no search.
pub(super) fn search(
    scene: &Scene,
    observed: Observed,
    counts: &[StepCount],
) -> Result<(Vec<Candidate>, usize), String> {
    if !scene.scan.is_full() {
        return Err("codes are told apart over a whole scan; this one is a window".to_owned());
    }
    let own = &scene.sources[scene.detectors[observed.detector()].reference].code;
    let others = others(scene, own);
    if others.len() as u64 * own.len() > MOST_WORK {
        return Err(format!(
            "the code's set has {} codes of {} chips, more than are searched",
            others.len() + 1,
            own.len()
        ));
    }
    let mut counts = Counts::new(scene, counts);
    let own_reference = counts.spectrum(&signs(own));
    // A histogram is kept without a code: the light's alone can be another one.
    let slots = match observed {
        Observed::Steps(_) => 2,
        Observed::Bins(_) => 1,
    };
    let mut best: [Option<Candidate>; 2] = [None, None];
    for (name, code) in &others {
        let light = counts.spectrum(&levels(code));
        let its_own = counts.spectrum(&signs(code));
        for (slot, reference) in [&own_reference, &its_own].into_iter().take(slots).enumerate() {
            let (at_step, sigmas) = counts.peak(&light, reference);
            if best[slot].as_ref().is_none_or(|best| sigmas > best.sigmas) {
                best[slot] = Some(Candidate {
                    name: name.clone(),
                    code: Arc::clone(code),
                    of_reference: slot == 1,
                    at_step,
                    sigmas,
                });
            }
        }
    }
    Ok((best.into_iter().flatten().collect(), slots * others.len()))
}

/// The codes of the scene's other sources, and of the own code's Gold set.
fn others(scene: &Scene, own: &Code) -> Vec<(String, Arc<Code>)> {
    let of_sources = scene
        .sources
        .iter()
        .filter(|source| source.code.len() == own.len() && source.code.chips != own.chips)
        .map(|source| {
            let name = format!("the code of source \"{}\"", source.name);
            (name, Arc::clone(&source.code))
        });
    let mut found: Vec<_> = of_sources.collect();
    let Generator::Gold { u, v } = &own.generator else {
        return found;
    };
    let set = GoldSet { u: u.clone(), v: v.clone() };
    for index in (1..set.length() as i64).chain([-2, -1]) {
        let generator = set.generator(index).ok();
        let member = generator.and_then(|generator| Code::new(generator, own.interleave).ok());
        let name = match index {
            // The own code's v is advanced by the own index already.
            1.. => format!("the code whose index is {index} higher (modulo {})", set.length()),
            -2 => "the code of index -2".to_owned(),
            _ => "the code of index -1".to_owned(),
        };
        found.extend(member.map(|member| (name, Arc::new(member))));
    }
    found
}

fn signs(code: &Code) -> Vec<f64> {
    let signs = code.chips.iter().map(|&chip| 2.0 * f64::from(chip) - 1.0);
    signs.collect()
}

fn levels(code: &Code) -> Vec<f64> {
    code.chips.iter().map(|&chip| f64::from(chip)).collect()
}

/// A scan's signed counts, averaged over each chip, and their transform.
struct Counts {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    spectrum: Vec<Complex64>,
    /// Standard deviation of an averaged count.
    std: f64,
    samples_per_chip: usize,
}

impl Counts {
    fn new(scene: &Scene, counts: &[StepCount]) -> Counts {
        let samples_per_chip = scene.samples_per_chip as usize;
        let mut by_phase_step = vec![0.0; counts.len()];
        for (j, count) in counts.iter().enumerate() {
            by_phase_step[scene.scan.phase_step(Step::at(j)) as usize] = count.signed as f64;
        }
        let averages: Vec<f64> = by_phase_step
            .chunks(samples_per_chip)
            .map(|chip| chip.iter().sum::<f64>() / chip.len() as f64)
            .collect();
        let mut planner = Planner::new();
        let mut counts = Counts {
            forward: planner.forward(averages.len()),
            inverse: planner.inverse(averages.len()),
            spectrum: Vec::new(),
            std: std_of(&by_phase_step) / (samples_per_chip as f64).sqrt(),
            samples_per_chip,
        };
        counts.spectrum = counts.spectrum(&averages);
        counts
    }

    /// Transform of values less their mean.
    fn spectrum(&self, values: &[f64]) -> Vec<Complex64> {
        let mut spectrum: Vec<Complex64> = values.iter().map(|&v| v.into()).collect();
        self.forward.process(&mut spectrum);
        spectrum[0] = Complex64::ZERO;
        spectrum
    }

    /// Where the correlation of a light's and a reference's code lies best in the
    /// counts (in phase steps), and how many standard deviations high it stands.
    fn peak(&mut self, light: &[Complex64], reference: &[Complex64]) -> (u64, f64) {
        let length = self.spectrum.len() as f64;
        let shape = light.iter().zip(reference).map(|(u, chi)| u * chi.conj());
        let shape: Vec<Complex64> = shape.collect();
        let norm = (shape.iter().map(Complex64::norm_sqr).sum::<f64>() / length).sqrt();
        let product = self.spectrum.iter().zip(&shape);
        let mut match_at: Vec<Complex64> = product.map(|(x, c)| x * c.conj()).collect();
        self.inverse.process(&mut match_at);
        let heights = match_at.iter().map(|value| value.re / length);
        let highest = heights.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        let (at, height) = highest.unwrap_or((0, 0.0));
        let middle = (at * self.samples_per_chip + self.samples_per_chip / 2) as u64;
        (middle, height / (norm * self.std).max(f64::MIN_POSITIVE))
    }
}

/// Standard deviation, without the mean.
fn std_of(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n).sqrt()
}
