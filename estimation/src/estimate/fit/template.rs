//! Signed counts of a scan that light of a code adds, to first order.

use goldtof_fft::num_complex::Complex64;

use crate::code::{Code, correlate};
use crate::estimate::{CountingTier, calibration_offset_ps};
use crate::math::{normal_cdf, normal_density};
use crate::scan::Step;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Corners of a triangle are round within so many standard deviations of the jitter.
const ROUND_SIGMAS: f64 = 6.0;

/// The reference, correlated with a code: a chain of straight lines between chips,
/// with corners as round as the jitter makes them.
#[derive(Debug, Clone)]
pub struct Template {
    /// Sum over a code period of the reference's sign times the code's chip, at lags
    /// of whole chips.
    theta: Vec<f64>,
    sigma_chips: f64,
}

impl Template {
    /// `None` if the codes are not of one length.
    pub fn new(reference: &Code, code: &Code, sigma_chips: f64) -> Option<Template> {
        (reference.len() == code.len()).then(|| {
            let signs = 2.0 * reference.weight() as f64 - reference.len() as f64;
            let counts = correlate(&reference.chips, &code.chips);
            Template {
                theta: counts.iter().map(|&c| 0.5 * (c as f64 + signs)).collect(),
                sigma_chips,
            }
        })
    }

    /// Sum of squares over the steps of a whole code period, less that of their mean, with
    /// sharp corners.
    pub fn power(&self, samples_per_chip: f64) -> f64 {
        let length = self.theta.len();
        // Shares of the two chips beside a step, squared and multiplied, over a chip's steps.
        let squares = (2.0 * samples_per_chip + 1.0 / samples_per_chip) / 3.0;
        let products = (samples_per_chip - 1.0 / samples_per_chip) / 3.0;
        let mean = self.theta.iter().sum::<f64>() / length as f64;
        let of_chip = |chip: usize| {
            let (here, next) = (self.theta[chip] - mean, self.theta[(chip + 1) % length] - mean);
            squares * here * here + products * here * next
        };
        (0..length).map(of_chip).sum()
    }

    /// Value, and slope per chip, where the reference is `lag_chips` behind the code.
    pub fn at(&self, lag_chips: f64) -> [f64; 2] {
        let place = self.place(lag_chips);
        self.beside(place.chip, &place.corner)
    }

    /// Where a lag is.
    fn place(&self, lag_chips: f64) -> Place {
        let nearest = lag_chips.round();
        Place {
            chip: (nearest as i64).rem_euclid(self.theta.len() as i64) as usize,
            corner: Corner::new(lag_chips - nearest, self.sigma_chips),
        }
    }

    /// Value and slope beside the corner at a chip.
    fn beside(&self, chip: usize, corner: &Corner) -> [f64; 2] {
        let length = self.theta.len();
        let here = self.theta[chip];
        let left = here - self.theta[if chip == 0 { length - 1 } else { chip - 1 }];
        let right = self.theta[if chip + 1 == length { 0 } else { chip + 1 }] - here;
        let Corner { beyond, ramp, passed } = corner;
        [here + left * beyond + (right - left) * ramp, left + (right - left) * passed]
    }
}

/// A place on a template: the nearest chip, and where beside the corner there.
struct Place {
    chip: usize,
    corner: Corner,
}

/// A place beside a corner of two straight lines, as round as the jitter makes it.
struct Corner {
    /// Chips past the corner.
    beyond: f64,
    /// What a line from the corner on, of slope 1, has there, and the slope that it has.
    ramp: f64,
    passed: f64,
}

impl Corner {
    fn new(beyond: f64, sigma_chips: f64) -> Corner {
        if beyond.abs() >= ROUND_SIGMAS * sigma_chips {
            let passed = if beyond < 0.0 { 0.0 } else { 1.0 };
            return Corner { beyond, ramp: beyond * passed, passed };
        }
        let sigmas = beyond / sigma_chips;
        let passed = normal_cdf(sigmas);
        Corner { beyond, ramp: beyond * passed + sigma_chips * normal_density(sigmas), passed }
    }
}

/// Spectrum of values.
pub fn spectrum(values: impl Iterator<Item = f64>) -> Vec<Complex64> {
    let mut spectrum: Vec<Complex64> = values.map(Complex64::from).collect();
    let [forward, _] = goldtof_fft::pair(spectrum.len());
    forward.process(&mut spectrum);
    spectrum
}

/// The real values of a spectrum.
pub fn real(mut spectrum: Vec<Complex64>) -> Vec<f64> {
    let length = spectrum.len();
    let [_, inverse] = goldtof_fft::pair(length);
    inverse.process(&mut spectrum);
    spectrum.iter().map(|value| value.re / length as f64).collect()
}

/// Where a scan's steps are on the axis of delays.
#[derive(Debug, Clone)]
pub struct DelayAxis {
    /// Peak of light without time of flight, in chips.
    pub offset_chips: f64,
    pub samples_per_chip: f64,
    /// Phase step of each step.
    phase_steps: Vec<u64>,
    /// Code periods in a step.
    pub periods: f64,
    /// Chips in a step.
    pub chips: f64,
    is_full: bool,
    steps_per_period: f64,
}

impl DelayAxis {
    /// The axis of some steps of a detector's scan.
    pub fn new(
        sensor: &Sensor,
        detector: DetectorIndex,
        tier: CountingTier,
        steps: &[Step],
    ) -> DelayAxis {
        let scan = &sensor.timing().scan;
        let own = sensor.reference(detector);
        let chips = scan.integration_chips as f64;
        DelayAxis {
            offset_chips: calibration_offset_ps(sensor, detector, tier)
                / sensor.clock().chip_period_ps,
            samples_per_chip: f64::from(sensor.clock().samples_per_chip),
            phase_steps: steps.iter().map(|&step| scan.phase_step(step)).collect(),
            periods: chips / own.len() as f64,
            chips,
            is_full: scan.is_full(),
            steps_per_period: scan.steps_per_period as f64,
        }
    }

    /// Number of steps.
    pub fn len(&self) -> usize {
        self.phase_steps.len()
    }

    /// Whether steps go all round the code period.
    pub fn is_full(&self) -> bool {
        self.is_full
    }

    /// Values and slopes of a template for light of some delay, step by step: those of a phase of a chip
    /// are beside their corners alike.
    pub fn values<'a>(
        &'a self,
        template: &'a Template,
        delay_chips: f64,
    ) -> impl Iterator<Item = [f64; 2]> + 'a {
        let start = self.offset_chips + delay_chips;
        let samples = self.samples_per_chip as u64;
        let phases =
            (0..samples).map(|phase| template.place(phase as f64 / self.samples_per_chip - start));
        let phases: Vec<Place> = phases.collect();
        self.phase_steps.iter().map(move |&k| {
            let Place { chip, corner } = &phases[(k % samples) as usize];
            let chip = (chip + (k / samples) as usize) % template.theta.len();
            template.beside(chip, corner)
        })
    }

    /// The delay of light that peaks at a place in the order of phase steps.
    pub fn delay_at(&self, place: f64) -> f64 {
        (self.first() + place) / self.samples_per_chip - self.offset_chips
    }

    /// Where light of some delay peaks in the order of phase steps.
    pub fn place_of(&self, delay_chips: f64) -> f64 {
        let k = (delay_chips + self.offset_chips) * self.samples_per_chip;
        (k - self.first()).rem_euclid(self.steps_per_period)
    }

    /// The place of a phase step.
    pub fn place_of_phase_step(&self, phase_step: u64) -> f64 {
        (phase_step as f64 - self.first()).rem_euclid(self.steps_per_period)
    }

    /// Phase steps between two places, the short way round.
    pub fn steps_apart(&self, places: f64) -> f64 {
        let turns = places / self.steps_per_period;
        (turns - turns.round()).abs() * self.steps_per_period
    }

    /// Phase step of the first place.
    fn first(&self) -> f64 {
        match self.is_full {
            true => 0.0,
            false => self.phase_steps[0] as f64,
        }
    }

    /// Values of steps in the order of phase steps, their mean taken off.
    pub fn centred(&self, values: &[f64]) -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let first = self.phase_steps.iter().position(|&k| k == 0).unwrap_or(0);
        let split = if self.is_full { first } else { 0 };
        let turned = values[split..].iter().chain(&values[..split]);
        turned.map(|value| value - mean).collect()
    }
}

/// A code's template over a scan, ready to be correlated with residuals.
#[derive(Debug, Clone)]
pub struct Matched {
    pub template: Template,
    /// Spectrum of the template, its mean taken off; empty where the scan does not go
    /// all round the code period.
    spectrum: Vec<Complex64>,
    /// Products of the template with itself at 0, 1, .. phase steps apart.
    overlap: Vec<f64>,
}

impl Matched {
    pub fn new(template: Template, axis: &DelayAxis) -> Matched {
        let steps = axis.len();
        let at_step = |k: usize| template.at(k as f64 / axis.samples_per_chip)[0];
        let (spectrum, overlap) = match axis.is_full() {
            true => {
                let values: Vec<f64> = (0..steps).map(at_step).collect();
                let mean = values.iter().sum::<f64>() / steps as f64;
                let spectrum = spectrum(values.iter().map(|value| value - mean));
                let overlap = real(spectrum.iter().map(|v| v.norm_sqr().into()).collect());
                (spectrum, overlap)
            }
            false => {
                // The peak and a chip beside it, which a scan round it holds.
                let reach = 4 * axis.samples_per_chip as i64;
                let values: Vec<f64> = (-reach..=reach)
                    .map(|k| template.at(k as f64 / axis.samples_per_chip)[0])
                    .collect();
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                let product = |lag: usize| {
                    let pairs = values.iter().zip(values.iter().skip(lag));
                    pairs.map(|(a, b)| (a - mean) * (b - mean)).sum()
                };
                (Vec::new(), (0..values.len()).map(product).collect())
            }
        };
        Matched { template, spectrum, overlap }
    }

    /// Sum of squares of the template.
    pub fn power(&self) -> f64 {
        self.overlap[0]
    }

    /// Product of two templates so many phase steps apart.
    pub fn overlap(&self, steps: f64) -> f64 {
        let last = self.overlap.len() - 1;
        let steps = steps.abs().min(last as f64);
        let below = (steps.floor() as usize).min(last);
        let part = steps - below as f64;
        self.overlap[below] + part * (self.overlap[(below + 1).min(last)] - self.overlap[below])
    }

    /// Product of the template with a scan's values, for light that peaks at each
    /// place in the order of phase steps.
    pub fn products(&self, axis: &DelayAxis, values: &[f64]) -> Vec<f64> {
        let centred = axis.centred(values);
        if self.spectrum.is_empty() {
            return self.products_one_by_one(axis, &centred);
        }
        let spectrum = spectrum(centred.into_iter());
        real(spectrum.iter().zip(&self.spectrum).map(|(v, template)| v * template.conj()).collect())
    }

    fn products_one_by_one(&self, axis: &DelayAxis, centred: &[f64]) -> Vec<f64> {
        let reach = (2.0 * axis.samples_per_chip) as i64;
        (0..centred.len() as i64)
            .map(|place| {
                let offsets = (-reach..=reach).filter_map(|offset| {
                    let value = centred.get(usize::try_from(place + offset).ok()?)?;
                    let lag = offset as f64 / axis.samples_per_chip;
                    Some((self.template.at(lag)[0], *value))
                });
                let seen: Vec<(f64, f64)> = offsets.collect();
                let mean = seen.iter().map(|(t, _)| t).sum::<f64>() / seen.len() as f64;
                seen.iter().map(|(t, value)| (t - mean) * value).sum()
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{CodeSpec, Family};

    fn gold(index: i64) -> Code {
        let spec = CodeSpec { degree: Some(5), index: Some(index), ..CodeSpec::new(Family::Gold) };
        spec.build().expect("a Gold code")
    }

    /// Against the sum that a template stands for, and its slope against differences.
    #[test]
    fn a_template_is_the_reference_times_the_delayed_code() {
        let (reference, code) = (gold(0), gold(7));
        let template = Template::new(&reference, &code, 0.01).expect("one length");
        let fine = 200;
        for lag in [-3.25, 0.4, 11.9, 30.5] {
            // Chips as functions of time, sampled finely; the reference is late by `lag`.
            let chip = |code: &Code, time: f64| {
                f64::from(code.chips[(time.floor() as i64).rem_euclid(31) as usize])
            };
            let sum: f64 = (0..31 * fine)
                .map(|i| (f64::from(i) + 0.5) / f64::from(fine))
                .map(|t| (2.0 * chip(&reference, t - lag) - 1.0) * chip(&code, t))
                .sum::<f64>()
                / f64::from(fine);
            let [value, slope] = template.at(lag);
            assert!((value - sum).abs() < 1e-9, "{lag}: {value} {sum}");
            let step = 1e-4;
            let difference = template.at(lag + step)[0] - template.at(lag - step)[0];
            assert!((slope - 0.5 * difference / step).abs() < 1e-6);
        }
        // At a corner the jitter's mean |x| is in the value: sigma sqrt(2 / pi) / 2.
        let own = Template::new(&reference, &reference, 0.01).expect("one length");
        let bend = (own.at(1.0)[0] - own.at(0.0)[0]) - (own.at(0.0)[0] - own.at(-1.0)[0]);
        let sharp = Template::new(&reference, &reference, 0.0).expect("one length");
        let lower = sharp.at(0.0)[0] - own.at(0.0)[0];
        let sharp_bend = sharp.at(1.0)[0] - 2.0 * sharp.at(0.0)[0] + sharp.at(-1.0)[0];
        let expected = -0.01 * (0.5 / std::f64::consts::PI).sqrt() * sharp_bend;
        assert!((lower - expected).abs() < 1e-9 && bend < 0.0, "{lower} {expected}");
    }
}
