//! Finding further light in what a fit leaves over of a scan.
//!
//! The scan's residual, correlated with the reference once more, is an image of
//! the light that is missing (the reference's spectrum is nearly flat); its
//! correlation with the right code has a peak at the light's delay.

use std::sync::Arc;

use goldtof_fft::Planner;
use rustfft::num_complex::Complex64;

use super::problem::{Parameters, PathParameters, Problem};
use super::{FitError, OtherLight};
use crate::code::{Code, Generator, GoldSet};
use crate::estimate::calibration_offset_ps;
use crate::estimate::phase::first_maximum;
use crate::response::MeanCount;
use crate::sensor::Sensor;

/// How far above the largest value that noise is expected to have among all
/// places searched a peak must stand to count, in standard deviations.
const MARGIN_SIGMAS: f64 = 1.2;

/// A path that the residual shows.
pub struct Found {
    pub code: Arc<Code>,
    pub path: PathParameters,
}

/// The codes to look for, one list of candidates for each path wanted.
pub fn wanted(
    sensor: &Sensor,
    detector: usize,
    other: OtherLight,
) -> Result<Vec<Vec<Arc<Code>>>, FitError> {
    let own = sensor.scene().detectors[detector].reference;
    match other {
        OtherLight::None => Ok(Vec::new()),
        OtherLight::Given => {
            let mut lit: Vec<usize> = sensor
                .scene()
                .paths
                .iter()
                .filter(|path| path.detector == detector && path.transmission > 0.0)
                .map(|path| path.source)
                .filter(|&source| {
                    let source = &sensor.scene().sources[source];
                    source.mean_power_w > 0.0 && source.extinction_ratio > 1.0
                })
                .collect();
            // The fit already has one path of the reference's source.
            if let Some(first) = lit.iter().position(|&source| source == own) {
                lit.remove(first);
            }
            Ok(lit
                .into_iter()
                .map(|source| vec![Arc::clone(&sensor.scene().sources[source].code)])
                .collect())
        }
        OtherLight::Search => Ok(vec![other_members(&sensor.scene().sources[own].code)?]),
    }
}

/// The codes of a Gold code's set, but itself.
fn other_members(code: &Code) -> Result<Vec<Arc<Code>>, FitError> {
    let Generator::Gold { u, v } = &code.generator else {
        return Err(FitError::NoGoldSet);
    };
    let set = GoldSet {
        u: u.clone(),
        v: v.clone(),
    };
    // Its own index counts from itself: 0.
    let indices = (1..set.length() as i64).chain([-2, -1]);
    indices
        .map(|index| {
            let generator = set.generator(index).map_err(|_| FitError::NoGoldSet)?;
            let member = Code::new(generator, code.interleave).map_err(|_| FitError::NoGoldSet)?;
            Ok(Arc::new(member))
        })
        .collect()
}

/// The candidate, and its delay and strength, that stands out most in the
/// residual of a fit; `None` if there are several and none stands out.
pub fn strongest(
    sensor: &Sensor,
    detector: usize,
    problem: &Problem,
    fitted: &Parameters,
    counts: &[MeanCount],
    candidates: &[Arc<Code>],
) -> Result<Option<Found>, FitError> {
    let samples_per_chip = sensor.clock().samples_per_chip as usize;
    let own = &sensor.scene().sources[sensor.scene().detectors[detector].reference].code;
    let known = Problem {
        codes: problem.codes[..fitted.paths.len()].to_vec(),
        ..problem.clone()
    };
    let expected = known.means(fitted)?;
    let residual: Vec<f64> = by_phase_step(sensor, counts)
        .zip(by_phase_step(sensor, &expected))
        .map(|(count, mean)| count - mean)
        .collect();
    let mut transform = Transform::new(own);
    let image = transform.image(&average_over_chip(&residual, samples_per_chip));

    let mut best: Option<Peak> = None;
    for pair in candidates.chunks(2) {
        if pair.iter().any(|code| code.len() != own.len()) {
            continue;
        }
        for (code, values) in pair.iter().zip(transform.correlate(&image, pair)) {
            let peak = Peak::of(code, &values);
            if best.as_ref().is_none_or(|best| peak.sigmas > best.sigmas) {
                best = Some(peak);
            }
        }
    }
    // Of n normal numbers the largest is about sqrt(2 ln n). Light that is known
    // to be there, with a single candidate, is where its peak is.
    let places = candidates.len() as f64 * own.len() as f64;
    let significant = (2.0 * places.ln()).sqrt() + MARGIN_SIGMAS;
    let is_known = candidates.len() == 1;
    let Some(best) = best.filter(|peak| is_known || peak.sigmas > significant) else {
        return Ok(None);
    };

    // Now phase by phase, beside the reference's own peak in the same units.
    let measured: Vec<f64> = by_phase_step(sensor, counts).collect();
    let (delay_steps, height) = transform.peak_of_phases(&residual, &best.code, samples_per_chip);
    let (_, own_height) = transform.peak_of_phases(&measured, own, samples_per_chip);
    let step_ps = sensor.clock().sample_period_ps();
    let offset_ps = calibration_offset_ps(sensor, detector, problem.tier);
    let ratio = match own_height > 0.0 {
        true => (height / own_height).clamp(1e-3, 1e3),
        false => 1.0,
    };
    Ok(Some(Found {
        path: PathParameters {
            delay_chips: sensor
                .clock()
                .chips(delay_steps as f64 * step_ps - offset_ps),
            ln_rate: fitted.paths[0].ln_rate + ratio.ln(),
        },
        code: best.code,
    }))
}

/// Signed counts of a full scan in the order of phase steps.
fn by_phase_step<'a>(sensor: &Sensor, counts: &'a [MeanCount]) -> impl Iterator<Item = f64> + 'a {
    let first = sensor.timing().scan.first_step as usize % counts.len();
    let split = counts.len() - first;
    counts[split..]
        .iter()
        .chain(&counts[..split])
        .map(|count| count.signed)
}

fn average_over_chip(values: &[f64], samples_per_chip: usize) -> Vec<f64> {
    let chips = values.chunks(samples_per_chip);
    chips
        .map(|chip| chip.iter().sum::<f64>() / chip.len() as f64)
        .collect()
}

/// The largest correlation of one code.
struct Peak {
    code: Arc<Code>,
    sigmas: f64,
}

impl Peak {
    /// The largest value, against the spread of those more than a chip away.
    fn of(code: &Arc<Code>, values: &[f64]) -> Peak {
        let place = first_maximum(values);
        let length = values.len();
        let others = || {
            let offsets = 2..length.saturating_sub(1);
            offsets.map(|offset| values[(place + offset) % length])
        };
        let number = others().count().max(1) as f64;
        let mean = others().sum::<f64>() / number;
        let variance = others().map(|v| (v - mean).powi(2)).sum::<f64>() / number;
        Peak {
            code: Arc::clone(code),
            sigmas: (values[place] - mean) / variance.sqrt().max(f64::MIN_POSITIVE),
        }
    }
}

/// Correlations over one code period.
struct Transform {
    planner: Planner,
    length: usize,
    reference: Vec<Complex64>,
}

impl Transform {
    fn new(reference: &Code) -> Transform {
        let mut transform = Transform {
            planner: Planner::new(),
            length: reference.chips.len(),
            reference: Vec::new(),
        };
        transform.reference = transform.forward(signs(reference).map(Complex64::from).collect());
        transform
    }

    fn forward(&mut self, mut values: Vec<Complex64>) -> Vec<Complex64> {
        self.planner.forward(self.length).process(&mut values);
        values
    }

    /// Spectrum of the light that a scan, one value per chip, is an image of.
    fn image(&mut self, scan: &[f64]) -> Vec<Complex64> {
        let scan = self.forward(scan.iter().map(|&v| Complex64::from(v)).collect());
        scan.iter()
            .zip(&self.reference)
            .map(|(x, c)| x * c)
            .collect()
    }

    /// Correlation of an image with one or two codes, at every lag.
    fn correlate(&mut self, image: &[Complex64], codes: &[Arc<Code>]) -> [Vec<f64>; 2] {
        let mut packed: Vec<Complex64> = signs(&codes[0]).map(Complex64::from).collect();
        if let Some(second) = codes.get(1) {
            for (value, sign) in packed.iter_mut().zip(signs(second)) {
                value.im = sign;
            }
        }
        // With P = G1 + i G2: conj(G1) + i conj(G2) at f is P at -f.
        let packed = self.forward(packed);
        let mut product: Vec<Complex64> = (0..self.length)
            .map(|f| image[f] * packed[(self.length - f) % self.length])
            .collect();
        self.planner.inverse(self.length).process(&mut product);
        [
            product.iter().map(|v| v.re).collect(),
            product.iter().map(|v| v.im).collect(),
        ]
    }

    /// Phase step and height of the largest correlation with `code`.
    fn peak_of_phases(
        &mut self,
        scan: &[f64],
        code: &Arc<Code>,
        samples_per_chip: usize,
    ) -> (usize, f64) {
        let mut best = (0, f64::NEG_INFINITY);
        for phase in 0..samples_per_chip {
            let of_phase: Vec<f64> = scan[phase..]
                .iter()
                .step_by(samples_per_chip)
                .copied()
                .collect();
            let image = self.image(&of_phase);
            let [values, _] = self.correlate(&image, std::slice::from_ref(code));
            for (chip, &value) in values.iter().enumerate() {
                if value > best.1 {
                    best = (chip * samples_per_chip + phase, value);
                }
            }
        }
        best
    }
}

fn signs(code: &Code) -> impl Iterator<Item = f64> + '_ {
    code.chips.iter().map(|&chip| 2.0 * f64::from(chip) - 1.0)
}
