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
    /// Hits that go together: an avalanche and its afterpulses.
    cluster: f64,
}

impl Noise {
    /// Of so many hits, whose variance without regard to the code's balance is `fano` times as large.
    fn of_hits(sensor: &Sensor, detector: DetectorIndex, hits: f64, fano: f64) -> Noise {
        let chips = &sensor.reference(detector).chips;
        let up = chips.iter().filter(|&&chip| chip == 1).count() as f64 / chips.len() as f64;
        let balance = 2.0 * up - 1.0;
        let variance = fano * hits * (1.0 - balance * balance);
        Noise { mean: hits * balance, variance, cluster: fano.max(1.0) }
    }

    /// In as many hits as were counted where the hardware tells, or else those of the scene without the own
    /// light; none where that has no light at all, or theory has nothing to say of it.
    fn of_steps(sensor: &Sensor, detector: DetectorIndex, counts: &[StepCount]) -> Option<Noise> {
        let dark = without_own_light(sensor, detector).with(|scene| {
            // One step says it of all: what the others differ in is less than the noise.
            scene.scan.steps = 1;
            scene.hardware.parallel = 1;
        });
        let counted =
            counts.iter().map(|count| count.total as f64).sum::<f64>() / counts.len() as f64;
        let expected = || {
            let model = DetectorModel::new(&dark, detector);
            let response = MeanResponse::of_tier(&model, CountingTier::Sampled).ok()?;
            let step = *SecondMoments::new(&response).ok()?.of_scan().first()?;
            (step.total_mean > 0.0).then_some(step)
        };
        let expected = expected();
        let hits = if counted > 0.0 { counted } else { expected?.total_mean };
        let fano = expected.map_or(1.0, |step| {
            let share = step.signed_mean / step.total_mean;
            step.signed_variance / (step.total_mean * (1.0 - share * share)).max(f64::MIN_POSITIVE)
        });
        Some(Noise::of_hits(sensor, detector, hits, fano))
    }

    /// About this share of steps counts so much, or less: the Chernoff bound of the difference of two
    /// Poisson numbers of clusters with this mean and variance.
    fn tail(self, count: f64) -> f64 {
        let (excess, variance) =
            ((count - self.mean) / self.cluster, self.variance / self.cluster.powi(2));
        if excess <= 0.0 || variance <= 0.0 {
            return if excess > 0.0 { 0.0 } else { 1.0 };
        }
        let root = excess.hypot(variance);
        (root - variance - excess * (excess / variance).asinh()).exp()
    }
}

/// At most about this share of scans without modulated light has a count as large as the largest one of
/// these; none of hardware whose counts saturate, without hits, or where theory has nothing to say.
pub fn of_steps(sensor: &Sensor, detector: DetectorIndex, counts: &[StepCount]) -> Option<f64> {
    if sensor.interface().saturates() {
        return None;
    }
    Some(of_largest(counts, Noise::of_steps(sensor, detector, counts)?))
}

/// The same of the phase steps of a histogram, which all see the same hits.
pub fn of_histogram(sensor: &Sensor, detector: DetectorIndex, counts: &[StepCount]) -> Option<f64> {
    let hits = counts.first().map_or(0, |count| count.total);
    let noise = Noise::of_hits(sensor, detector, hits as f64, 1.0);
    (hits > 0).then(|| of_largest(counts, noise))
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
            let noise = Noise { mean: 0.0, variance: 2.0 * mean, cluster: 1.0 };
            let ratio = noise.tail(count as f64) / at_least(count);
            assert!((1.0..20.0).contains(&ratio), "{mean}, {count}: {ratio}");
        }
    }
}
