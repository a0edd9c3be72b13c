//! Where the light is, roughly: the whole shape of the code's peak, not its
//! largest count alone.

use crate::code::Code;
use crate::sensor::Sensor;

/// Number of the step at which the counts, plus or minus a constant, look most
/// like the peak of `code`: of least squares of height and constant, the place
/// where the height is the most standard deviations above zero.
///
/// Every step of the peak has light of its own, so that at low light this finds
/// it where the largest single count misses: a triangle of 2 S steps has the
/// signal-to-noise ratio of sqrt(2 S / 3) times the largest of them.
pub fn best_match(sensor: &Sensor, code: &Code, signed: &[f64]) -> usize {
    let samples_per_chip = sensor.clock().samples_per_chip as usize;
    let steps = signed.len() as i64;
    let is_full = sensor.timing().scan.is_full();
    let template = template(code, samples_per_chip);
    // A short period has room for one turn.
    let half = match is_full {
        true => (template.len() as i64 / 2).min((steps - 1) / 2),
        false => template.len() as i64 / 2,
    };
    let middle = template.len() as i64 / 2;
    let mut best = (0, f64::NEG_INFINITY);
    for peak in 0..steps {
        let [mut number, mut t, mut tt, mut r, mut rt] = [0.0; 5];
        for offset in -half..=half {
            let step = peak + offset;
            let step = if is_full {
                step.rem_euclid(steps)
            } else if (0..steps).contains(&step) {
                step
            } else {
                continue;
            };
            let (shape, count) = (template[(middle + offset) as usize], signed[step as usize]);
            number += 1.0;
            t += shape;
            tt += shape * shape;
            r += count;
            rt += shape * count;
        }
        let score = (rt - r * t / number) / (tt - t * t / number).sqrt();
        if score > best.1 {
            best = (peak as usize, score);
        }
    }
    best.0
}

/// Autocorrelation of the code, step by step, to where its peak and those that
/// interleaving puts beside it have gone, and a chip more.
fn template(code: &Code, samples_per_chip: usize) -> Vec<f64> {
    let chips = &code.chips;
    let reach = (1_usize << code.interleave) + 1;
    let theta: Vec<f64> = (0..=reach + 1)
        .map(|lag| {
            let same = (0..chips.len()).filter(|&i| chips[i] == chips[(i + lag) % chips.len()]);
            2.0 * same.count() as f64 / chips.len() as f64 - 1.0
        })
        .collect();
    let half = (reach * samples_per_chip) as i64;
    (-half..=half)
        .map(|offset| {
            let lag = offset.unsigned_abs() as usize;
            let part = (lag % samples_per_chip) as f64 / samples_per_chip as f64;
            let chip = lag / samples_per_chip;
            theta[chip] + part * (theta[chip + 1] - theta[chip])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{CodeSpec, Family};

    #[test]
    fn a_template_is_a_triangle_on_flat_ground_and_alternates_if_interleaved() {
        let m_sequence = |interleave| {
            let spec = CodeSpec { degree: Some(5), interleave, ..CodeSpec::new(Family::MSequence) };
            template(&spec.build().expect("an m-sequence"), 4)
        };
        // Side lobes of an m-sequence are -1 / 31.
        let ground = -1.0 / 31.0;
        let plain = m_sequence(0);
        assert_eq!(plain.len(), 17);
        for (index, value) in plain.iter().enumerate() {
            let height = (1.0 - (index as f64 - 8.0).abs() / 4.0).max(0.0);
            let expected = ground + height * (1.0 - ground);
            assert!((value - expected).abs() < 1e-12, "{index}: {value}");
        }
        // Eq. 24 for nu = 1: half the peak, turned over, one chip on.
        let interleaved = m_sequence(1);
        let beside = interleaved[interleaved.len() / 2 + 4];
        assert!((beside + 0.5 * (1.0 + ground)).abs() < 1e-12, "{beside}");
    }
}
