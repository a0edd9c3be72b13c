//! Which code the counts show, if not the scene's.

use std::sync::Arc;

use goldtof_fft::num_complex::Complex64;

use super::Cause;
use super::observed::Observed;
use crate::code::{Code, Generator, GoldSet};
use crate::estimate::fit::template::{real, spectrum};
use crate::estimate::{CountingTier, calibration_offset_ps};
use crate::photons::{DetectorModel, StepCount};
use crate::response::MeanResponse;
use crate::scan::Step;
use crate::scene::Scene;
use crate::sensor::Sensor;

/// Most codes times phase steps that are searched: some ten seconds.
const MOST_WORK: u64 = 1 << 26;
/// Most codes times phase steps of which the exact response is worked out.
const MOST_EXACT_WORK: u64 = 1 << 20;
/// Candidates: others in a set may stand as high as the right one, by chance.
const MOST_CANDIDATES: usize = 5;

/// What light and reference may carry in place of the scene's code, and where that fits the counts
/// best.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    /// It, in words that follow "if".
    pub words: String,
    /// What is wrong then.
    pub cause: Cause,
    /// Code of the light.
    pub light: Arc<Code>,
    /// Code by which counts go up and down.
    pub reference: Arc<Code>,
    /// Delay of the light's peak, in phase steps.
    pub at_step: u64,
    /// Height of the peak over the noise.
    sigmas: f64,
}

/// The best variations of the scene's own code, the best first, and how many there were.
///
/// # Errors
/// Why codes cannot be searched.
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
    let work = others.len() as u64 * scene.scan.steps;
    if work > MOST_WORK {
        return Err(format!(
            "the code's set has {} codes for {} phase steps, more than are searched",
            others.len() + 1,
            scene.scan.steps
        ));
    }
    let comparison = Comparison::new(scene, observed, counts, work <= MOST_EXACT_WORK);
    let own = (Arc::clone(own), comparison.spectra(own));
    let mut candidates = comparison.of_polarities(&own);
    for (name, code) in &others {
        candidates.extend(comparison.of_code(name, code, &own));
    }
    let tried = candidates.len();
    candidates.sort_by(|a, b| b.sigmas.total_cmp(&a.sigmas));
    candidates.truncate(MOST_CANDIDATES);
    Ok((candidates, tried))
}

/// A code's transforms.
struct Spectra {
    /// Of what the detector counts of light that carries it, over a code period.
    light: Vec<Complex64>,
    /// Of the signs that it gives as a reference.
    reference: Vec<Complex64>,
}

/// Spectrum of values less their mean.
fn centred_spectrum(values: Vec<f64>) -> Vec<Complex64> {
    let mut spectrum = spectrum(values.into_iter());
    spectrum[0] = Complex64::ZERO;
    spectrum
}

/// Counts, and the codes that they are compared with.
struct Comparison<'c> {
    scene: &'c Scene,
    observed: Observed<'c>,
    /// Whether what detections hide of later light is taken into account.
    is_exact: bool,
    /// Transform of the scan's signed counts in the order of their phase steps.
    spectrum: Vec<Complex64>,
}

impl<'c> Comparison<'c> {
    fn new(
        scene: &'c Scene,
        observed: Observed<'c>,
        counts: &[StepCount],
        is_exact: bool,
    ) -> Comparison<'c> {
        let mut by_phase_step = vec![0.0; counts.len()];
        for (j, count) in counts.iter().enumerate() {
            by_phase_step[scene.scan.phase_step(Step::at(j)) as usize] = count.signed as f64;
        }
        Comparison { scene, observed, is_exact, spectrum: centred_spectrum(by_phase_step) }
    }

    fn spectra(&self, code: &Arc<Code>) -> Spectra {
        let samples = self.scene.samples_per_chip as usize;
        // Of what a chip of 0 and one of 1 stand for.
        let of_chips = |values: [f64; 2]| -> Vec<f64> {
            let chips = code.chips.iter().map(|&chip| values[usize::from(chip)]);
            chips.flat_map(|chip| std::iter::repeat_n(chip, samples)).collect()
        };
        let exact = self.is_exact.then(|| self.response(code)).flatten();
        Spectra {
            light: centred_spectrum(exact.unwrap_or_else(|| of_chips([0.0, 1.0]))),
            reference: centred_spectrum(of_chips([-1.0, 1.0])),
        }
    }

    /// Detections over a code period, of light that carries the code and comes as the scene's
    /// first path does, from the period's start on.
    fn response(&self, code: &Arc<Code>) -> Option<Vec<f64>> {
        let detector = self.observed.detector();
        let own = self.scene.detectors[detector].reference;
        let mut scene = self.scene.clone();
        scene.sources[own].code = Arc::clone(code);
        let sensor = Sensor::new(&scene);
        let model = DetectorModel::new(&sensor, detector);
        let response = MeanResponse::of_tier(&model, CountingTier::Sampled).ok()?;
        let first = scene.paths.iter().find(|path| path.detector == detector)?;
        let offset_ps = calibration_offset_ps(&sensor, detector, CountingTier::Sampled);
        Some(response.delayed(-first.delay_ps - offset_ps).ok()?.mean_bins())
    }

    /// Light and reference with one of two codes each: where their correlation lies best in the
    /// counts, and how many standard deviations of a count over the scan high it stands.
    fn candidate(
        &self,
        cause: Cause,
        words: impl Into<String>,
        [light, reference]: [&(Arc<Code>, Spectra); 2],
    ) -> Candidate {
        let length = self.spectrum.len() as f64;
        let root = |spectrum: &[Complex64]| {
            (spectrum.iter().map(Complex64::norm_sqr).sum::<f64>() / length).sqrt()
        };
        let spectra = light.1.light.iter().zip(&reference.1.reference);
        let shape: Vec<Complex64> = spectra.map(|(u, chi)| u * chi.conj()).collect();
        let product = self.spectrum.iter().zip(&shape);
        let heights = real(product.map(|(x, c)| x * c.conj()).collect());
        let highest = heights.into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        let (at, height) = highest.unwrap_or((0, 0.0));
        let std = root(&self.spectrum) / length.sqrt();
        Candidate {
            words: words.into(),
            cause,
            light: Arc::clone(&light.0),
            reference: Arc::clone(&reference.0),
            at_step: at as u64,
            sigmas: height / (root(&shape) * std).max(f64::MIN_POSITIVE),
        }
    }

    /// Another code of the light alone, of the reference alone and of both. A histogram is kept
    /// without a code: there the light's alone can be another one.
    fn of_code(&self, name: &str, code: &Arc<Code>, own: &(Arc<Code>, Spectra)) -> Vec<Candidate> {
        let other = &(Arc::clone(code), self.spectra(code));
        let of = |words: String, codes| self.candidate(Cause::Code, words, codes);
        let mut found = vec![of(format!("the light alone carries {name}"), [other, own])];
        if let Observed::Steps(_) = self.observed {
            found.push(of(format!("the reference alone has {name}"), [own, other]));
            found.push(of(format!("light and reference carry {name}"), [other, other]));
        }
        found
    }

    /// The own code the other way round, in the light or in the reference.
    fn of_polarities(&self, own: &(Arc<Code>, Spectra)) -> Vec<Candidate> {
        let Some(opposite) = opposite(&own.0) else {
            return Vec::new();
        };
        let spectra = self.spectra(&opposite);
        let opposite = &(opposite, spectra);
        let words = "the light is inverted: the laser is dark where the code's chip is 1";
        let mut found = vec![self.candidate(Cause::Polarity, words, [opposite, own])];
        if let Observed::Steps(_) = self.observed {
            let words = "up and down are swapped: the counts have the opposite sign";
            found.push(self.candidate(Cause::Polarity, words, [own, opposite]));
        }
        found
    }
}

/// The code with every chip the other way round.
fn opposite(code: &Code) -> Option<Arc<Code>> {
    let chips = code.generator.chips().into_iter().map(|chip| 1 - chip).collect();
    Code::new(Generator::Chips(chips), code.interleave).ok().map(Arc::new)
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
