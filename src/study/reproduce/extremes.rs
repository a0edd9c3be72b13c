//! The relative delays at which another code's light moves the phase estimate
//! most, of all that there are.

use std::f64::consts::PI;
use std::sync::Arc;

use goldtof_fft::num_complex::Complex64;

use super::prelude::*;
use crate::code::correlate;

/// Exact biases are taken at so many of the most promising delays to either side.
const CANDIDATES: usize = 8;

/// Relative delays, in phase steps, that move an estimate most when the detector
/// takes part in nothing: those of the largest shift first, then those of the least.
pub struct Candidates {
    latest: Vec<u64>,
    earliest: Vec<u64>,
}

/// A bias and where it is.
#[derive(Debug, Clone, Copy)]
pub struct Extreme {
    /// Delay of the other light relative to the target's, in chips.
    pub relative_delay_chips: f64,
    /// The phase estimator's bias, in metres.
    pub bias_m: f64,
}

impl Candidates {
    /// Goes through all relative delays of whole phase steps. Between chips a
    /// correlation is straight, so that its turning points are among them.
    pub fn of(own: &Code, other: &Code) -> Candidates {
        let theta = correlate(&own.chips, &other.chips);
        let height = own.len() as f64;
        let mut shifts: Vec<(u64, f64)> = (0..theta.len() as u64 * u64::from(SAMPLES_PER_CHIP))
            .map(|delay| (delay, phase_shift(&theta, height, delay as i64)))
            .collect();
        shifts.sort_by(|a, b| a.1.total_cmp(&b.1));
        let delays = |some: &[(u64, f64)]| some.iter().map(|(delay, _)| *delay).collect();
        let count = CANDIDATES.min(shifts.len());
        Candidates {
            earliest: delays(&shifts[..count]),
            latest: delays(&shifts[shifts.len() - count..]),
        }
    }

    /// The least and the largest bias by the exact mean response at these delays,
    /// each code's light of `power_pw`.
    pub fn extremes(
        &self,
        own: &Arc<Code>,
        other: &Arc<Code>,
        power_pw: f64,
        integration_s: f64,
    ) -> Result<[Extreme; 2], FigureError> {
        let at = |delay: u64| -> Result<Extreme, FigureError> {
            let relative_delay_chips = delay as f64 / f64::from(SAMPLES_PER_CHIP);
            let later = TARGET_PS + relative_delay_chips * CHIP_PERIOD_PS;
            let lights = [PathLight::new(own, power_pw), PathLight::new(other, power_pw).at(later)];
            let scene = window(sensor(&lights, integration_s), TARGET_PS, 3);
            Ok(Extreme { relative_delay_chips, bias_m: expected(&scene)?.bias_m })
        };
        let all = self.earliest.iter().chain(&self.latest);
        let found = all.map(|&delay| at(delay)).collect::<Result<Vec<_>, _>>()?;
        let mut ends = [found[0]; 2];
        for extreme in found {
            if extreme.bias_m < ends[0].bias_m {
                ends[0] = extreme;
            }
            if extreme.bias_m > ends[1].bias_m {
                ends[1] = extreme;
            }
        }
        Ok(ends)
    }
}

/// Phase by which the other code's correlation turns the fundamental of a triangle
/// of this height, later positive, for light `delay` phase steps later.
fn phase_shift(theta: &[i64], height: f64, delay: i64) -> f64 {
    let samples = i64::from(SAMPLES_PER_CHIP);
    let mut sum = Complex64::ZERO;
    for offset in -samples..samples {
        let turn = Complex64::from_polar(1.0, -PI * offset as f64 / samples as f64);
        let own = height * (1.0 - offset.abs() as f64 / samples as f64);
        sum += turn * (own + between_chips(theta, offset - delay));
    }
    -sum.arg()
}

/// A correlation so many phase steps from lag zero, straight between chips.
fn between_chips(theta: &[i64], steps: i64) -> f64 {
    let samples = i64::from(SAMPLES_PER_CHIP);
    let length = theta.len() as i64;
    let chip = steps.div_euclid(samples);
    let part = steps.rem_euclid(samples) as f64 / samples as f64;
    let at = |lag: i64| theta[lag.rem_euclid(length) as usize] as f64;
    (1.0 - part) * at(chip) + part * at(chip + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every relative delay of a short code by the exact response, against the few
    /// that the search takes.
    #[test]
    fn no_other_delay_moves_the_estimate_farther() {
        let spec = |index| {
            let spec = crate::code::CodeSpec {
                degree: Some(5),
                index: Some(index),
                ..crate::code::CodeSpec::new(crate::code::Family::Gold)
            };
            Arc::new(spec.build().expect("a Gold code"))
        };
        let (own, other) = (spec(0), spec(3));
        let all = 8 * own.len();
        let few = Candidates::of(&own, &other);
        let every = Candidates { earliest: (0..all).collect(), latest: Vec::new() };
        let ends = |of: &Candidates| {
            let ends = of.extremes(&own, &other, 2.0, 1e-3).expect("biases");
            ends.map(|extreme| extreme.bias_m)
        };
        let (few, every) = (ends(&few), ends(&every));
        for (found, true_end) in few.iter().zip(every) {
            let range = every[1] - every[0];
            assert!((found - true_end).abs() < 0.01 * range, "{few:?}, {every:?}");
        }
    }

    #[test]
    fn a_later_bump_turns_the_phase_to_later() {
        // Another light that peaks half a chip later, as strong as a tenth.
        let mut theta = vec![0; 31];
        theta[0] = 100;
        assert!(phase_shift(&theta, 1000.0, 4) > 0.0);
        assert!(phase_shift(&theta, 1000.0, -4) < 0.0);
        assert!(phase_shift(&theta, 1000.0, 0).abs() < 1e-12);
    }
}
