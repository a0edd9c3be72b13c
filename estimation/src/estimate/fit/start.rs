//! Where the fit of one path starts: at the phase estimate and the rate.

use std::sync::Arc;

use super::parameters::{FitParameters, PathParameters, share_of_ones};
use super::template::Template;
use crate::code::Code;
use crate::estimate::phase::estimate_at;
use crate::estimate::{CountingTier, NoEstimate, calibration_offset_ps};
use crate::photons::DeadTime;
use crate::response::MeanCount;
use crate::scan::Step;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// A start, and the number of the step where the peak is.
pub struct Start {
    pub parameters: FitParameters,
    pub peak: Step,
}

/// Least share of the light that a start attributes to the path.
const LEAST_SHARE: f64 = 0.02;

/// Largest share of the light that a start attributes to the path: with all of it, a count of the
/// other sign would be impossible.
const MOST_SHARE: f64 = 0.999;

/// The phase estimate for the delay. For the light, with q the code's share of
/// ones and e the excess on-light: detections per chip give the mean light
/// m = q e + constant, corrected for the dead time, and without dead time the peak
/// would be r / N = (q (e + constant) - (1 - q) constant) / m, that is
/// e / m = (r / N + 1 - 2 q) / (2 q (1 - q)). Where few counts make this negative, or larger than
/// possible, the fit starts from a little light, or nearly all.
pub fn start(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    counts: &[MeanCount],
) -> Result<Start, NoEstimate> {
    let signed: Vec<f64> = counts.iter().map(|count| count.signed).collect();
    let spad = &sensor.scene().detectors[detector];
    let code = &sensor.scene().sources[spad.reference].code;
    let peak = PeakShape::of(sensor, code).best_match(&signed);
    let largest = counts[peak];
    if signed.iter().all(|&count| count == largest.signed) || largest.total <= 0.0 {
        return Err(NoEstimate::Flat { count: largest.signed as i64 });
    }
    let offset_ps = calibration_offset_ps(sensor, detector, tier);
    let phase = estimate_at(&signed, peak, sensor.timing(), offset_ps);

    let ones = share_of_ones(code);
    let sample_ps = sensor.clock().sample_period_ps();
    let seen = match tier {
        CountingTier::Events => 1.0,
        CountingTier::Sampled => (spad.pulse_width_ps / sample_ps).min(1.0),
    };
    let detected = largest.total / sensor.timing().scan.integration_chips as f64 / seen;
    let dead_time = DeadTime::of(spad, sensor.clock().chips(spad.dead_time_ps));
    let mean = dead_time.primary(detected) * (1.0 - spad.afterpulsing_probability);
    let zeros = 1.0 - ones;
    if ones * zeros <= 0.0 {
        return Err(NoEstimate::NotModulated);
    }
    let contrast = (largest.signed / largest.total + zeros - ones) / (2.0 * ones * zeros);
    let rate = mean * contrast.clamp(LEAST_SHARE, MOST_SHARE / ones);
    Ok(Start {
        parameters: FitParameters {
            paths: vec![PathParameters {
                code: Arc::clone(code),
                delay_chips: sensor.clock().chips(phase.delay_ps),
                ln_rate: rate.ln(),
            }],
            walk: None,
            constant: mean - rate * ones,
        },
        peak: Step::at(peak),
    })
}

/// The shape of a code's peak, step by step, to where it has gone, and those that interleaving
/// puts beside it, and a chip more.
pub struct PeakShape {
    values: Vec<f64>,
    is_full: bool,
}

impl PeakShape {
    pub fn of(sensor: &Sensor, code: &Code) -> PeakShape {
        PeakShape {
            values: shape(code, sensor.clock().samples_per_chip),
            is_full: sensor.timing().scan.is_full(),
        }
    }

    /// Number of the step at which the counts, plus or minus a constant, look most
    /// like the peak: of least squares of height and constant, the place
    /// where the height is the most standard deviations above zero.
    ///
    /// Every step of the peak has light of its own, so that at low light this finds
    /// it where the largest single count misses: a triangle of 2 S steps has the
    /// signal-to-noise ratio of sqrt(2 S / 3) times the largest of them.
    pub fn best_match(&self, signed: &[f64]) -> usize {
        let steps = signed.len();
        let middle = self.values.len() / 2;
        // A short period has room for one turn.
        let half = if self.is_full { middle.min(steps.saturating_sub(1) / 2) } else { middle };
        let shape = &self.values[middle - half..=middle + half];
        // The counts round all steps; outside of a scan of a part there are none.
        let wrapped = |place: usize| signed[(place + steps - half % steps) % steps];
        let around: Vec<f64> = match self.is_full {
            true => (0..steps + 2 * half).map(wrapped).collect(),
            false => [&vec![0.0; half], signed, &vec![0.0; half]].concat(),
        };
        let mut best = (0, f64::NEG_INFINITY);
        let mut sums = vec![Sums::default(); PEAKS_AT_ONCE];
        for first in (0..steps).step_by(PEAKS_AT_ONCE) {
            let peaks = PEAKS_AT_ONCE.min(steps - first);
            sums.fill(Sums::default());
            for (offset, &shape) in shape.iter().enumerate() {
                // Peaks at which this offset is a step of the scan.
                let inside = match self.is_full {
                    true => 0..peaks,
                    false => {
                        let [from, to] = [half, half + steps]
                            .map(|end| end.saturating_sub(first + offset).min(peaks));
                        from..to
                    }
                };
                let counts = &around[first + offset..];
                for (sums, &count) in sums[inside.clone()].iter_mut().zip(&counts[inside]) {
                    sums.add(shape, count);
                }
            }
            for (place, sums) in sums[..peaks].iter().enumerate() {
                let score = sums.score();
                if score > best.1 {
                    best = (first + place, score);
                }
            }
        }
        best.0
    }
}

/// Peaks whose sums are added up side by side: one after another each addition would wait for the
/// one before.
const PEAKS_AT_ONCE: usize = 64;

/// Sums over the steps of a peak.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    number: f64,
    shape: f64,
    shape_squared: f64,
    count: f64,
    shape_count: f64,
}

impl Sums {
    #[inline(always)]
    fn add(&mut self, shape: f64, count: f64) {
        self.number += 1.0;
        self.shape += shape;
        self.shape_squared += shape * shape;
        self.count += count;
        self.shape_count += shape * count;
    }

    /// Standard deviations of the height above zero, but for the scale of the counts' scatter.
    fn score(&self) -> f64 {
        let covariance = self.shape_count - self.count * self.shape / self.number;
        covariance / (self.shape_squared - self.shape * self.shape / self.number).sqrt()
    }
}

fn shape(code: &Code, samples_per_chip: u32) -> Vec<f64> {
    let half = ((1_i64 << code.interleave) + 1) * i64::from(samples_per_chip);
    let lags = (-half..=half).map(|offset| offset as f64 / f64::from(samples_per_chip));
    let template = Template::new(code, code, 0.0).into_iter();
    template.flat_map(|template| lags.clone().map(move |lag| template.at(lag)[0])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{CodeSpec, Family};

    #[test]
    fn a_template_is_a_triangle_on_flat_ground_and_alternates_if_interleaved() {
        let m_sequence = |interleave| {
            let spec = CodeSpec { degree: Some(5), interleave, ..CodeSpec::new(Family::MSequence) };
            let code = spec.build().expect("an m-sequence");
            // Sums of sign times chip, in place of those of sign times sign.
            let signs = 2.0 * code.weight() as f64 - code.len() as f64;
            let of_signs = |sum: f64| (2.0 * sum - signs) / code.len() as f64;
            shape(&code, 4).into_iter().map(of_signs).collect::<Vec<f64>>()
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
