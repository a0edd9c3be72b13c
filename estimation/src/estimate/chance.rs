//! Whether a scan's peak could be chance: what noise alone counts, without any light of the source that is
//! ranged. A beam that is blocked, or a laser that is off, leaves counts that have a largest one, too.

use crate::photons::{DetectorModel, StepCount};
use crate::response::{CountingTier, MeanResponse, SecondMoments};
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// From this chance on the largest count is no peak.
pub const NO_PEAK: f64 = 0.5;
/// From this chance on it is told.
pub const DOUBTFUL: f64 = 0.01;

/// The sensor with nothing on its way from the detector's own source to it.
pub fn without_own_light(sensor: &Sensor, detector: DetectorIndex) -> Sensor {
    sensor.with(|scene| {
        let own = scene.detectors[detector].reference;
        scene.paths.retain(|path| path.detector != detector || path.source != own);
    })
}

/// What a phase step counts of light that is not modulated.
#[derive(Debug, Clone, Copy)]
struct Noise {
    /// Mean and variance of the signed count.
    mean: f64,
    variance: f64,
}

impl Noise {
    /// Of the scene's background, in as many hits as were counted where the hardware tells.
    fn of_steps(sensor: &Sensor, detector: DetectorIndex, counts: &[StepCount]) -> Option<Noise> {
        let dark = sensor.with(|scene| {
            // Light of other sources correlates with the reference here and there: what it adds is no chance.
            scene.paths.retain(|path| path.detector != detector);
            // One step says it of all: what the others differ in is less than the noise.
            scene.scan.steps = 1;
            scene.hardware.parallel = 1;
        });
        let model = DetectorModel::new(&dark, detector);
        let response = MeanResponse::of_tier(&model, CountingTier::Sampled).ok()?;
        let step = *SecondMoments::new(&response).ok()?.of_scan().first()?;
        let hits = counts.iter().map(|count| count.total as f64).sum::<f64>() / counts.len() as f64;
        let scale = if hits > 0.0 && step.total_mean > 0.0 { hits / step.total_mean } else { 1.0 };
        Some(Noise { mean: scale * step.signed_mean, variance: scale * step.signed_variance })
    }

    /// At most this share of steps counts so much: the Chernoff bound of the difference of two Poisson
    /// numbers with this mean and variance.
    fn tail(self, count: f64) -> f64 {
        let excess = count - self.mean;
        if excess <= 0.0 || self.variance <= 0.0 {
            return if excess > 0.0 { 0.0 } else { 1.0 };
        }
        let root = excess.hypot(self.variance);
        (root - self.variance - excess * (excess / self.variance).asinh()).exp()
    }
}

/// At most this share of scans without modulated light has a count as large as the largest one of these, from
/// the scene's background or, where there are total counts, as many hits as were counted; none where the
/// theory has nothing to say of such a scan.
pub fn of_steps(sensor: &Sensor, detector: DetectorIndex, counts: &[StepCount]) -> Option<f64> {
    Some(of_largest(counts, Noise::of_steps(sensor, detector, counts)?))
}

/// The same of the phase steps of a histogram, which all see the same hits.
pub fn of_histogram(counts: &[StepCount]) -> f64 {
    let hits = counts.first().map_or(0, |count| count.total);
    of_largest(counts, Noise { mean: 0.0, variance: hits as f64 })
}

fn of_largest(counts: &[StepCount], noise: Noise) -> f64 {
    let largest = counts.iter().map(|count| count.signed).max().unwrap_or(0);
    (counts.len() as f64 * noise.tail(largest as f64)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of the probabilities of the difference of two Poisson numbers of mean 2 and of mean 50
    /// (Skellam's distribution, by its recurrence): the bound is above them, and not by much.
    #[test]
    fn the_bound_is_above_the_exact_tail() {
        let poisson = |mean: f64, most: usize| -> Vec<f64> {
            let next = |p: &mut f64, k: usize| {
                let now = *p;
                *p *= mean / (k + 1) as f64;
                Some(now)
            };
            (0..most).scan((-mean).exp(), next).collect()
        };
        for (mean, count) in [(2.0, 6), (2.0, 11), (50.0, 30), (50.0, 60)] {
            let p = poisson(mean, 250);
            let at_least = |count: usize| -> f64 {
                (0..250 - count).map(|down| p[down] * p[down + count..].iter().sum::<f64>()).sum()
            };
            let noise = Noise { mean: 0.0, variance: 2.0 * mean };
            let ratio = noise.tail(count as f64) / at_least(count);
            assert!((1.0..20.0).contains(&ratio), "{mean}, {count}: {ratio}");
        }
    }
}
