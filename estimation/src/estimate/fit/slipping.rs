//! The scatter that light with a clock of its own adds to counts.
//!
//! Its code has an unknown delay, which moves on from step to step. A step's
//! signed count contains the correlation of the reference with that code at the delays that
//! pass within the step. Averaged over all delays it is that of constant light; the deviation from
//! that is scatter, correlated between steps that see nearly the same delays.

use std::sync::Arc;

use goldtof_fft::num_complex::Complex64;

use super::template::{real, spectrum};
use crate::photons::DetectorModel;
use crate::photons::light::ExcessLight;
use crate::response::{CountingTier, Light, LightPath, MeanResponse, MeanResponseError};
use crate::scan::{Step, Timing};

/// All light at a detector whose clock is not the sensor's.
#[derive(Debug)]
pub struct SlippingLight {
    sources: Vec<Slipping>,
}

/// Light of one code that slips past the reference.
#[derive(Debug)]
struct Slipping {
    /// Covariance of two signed counts, in counts^2, where the code is so many phase steps
    /// later beside the reference in one than in the other; round the code's period.
    covariance: Vec<f64>,
    /// The largest signed count at any delay less their mean.
    most: f64,
    /// Phase steps that it slips from one group of steps to the next.
    per_group: f64,
}

impl SlippingLight {
    /// [That](SlippingLight::of) of the scene. Left out is that a drifting clock is off by more in later
    /// scans.
    ///
    /// # Errors
    /// As for the mean response.
    pub fn new(
        model: &DetectorModel,
        tier: CountingTier,
    ) -> Result<SlippingLight, MeanResponseError> {
        let sources = SlippingLight::of(model).map(|light| Slipping::new(model, light, tier));
        Ok(SlippingLight { sources: sources.collect::<Result<_, _>>()? })
    }

    /// Light of a detector that slips past its reference, of codes as long as that. The correlation of other ones averages over
    /// many periods.
    pub fn of(model: &DetectorModel) -> impl Iterator<Item = &ExcessLight> {
        model.slipping().filter(|light| light.code.len() == model.reference.len())
    }

    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.sources.is_empty()
    }

    /// Covariance of the signed counts of two steps, in counts^2.
    pub fn covariance(&self, timing: &Timing, a: Step, b: Step) -> f64 {
        let group = |step: Step| timing.grouping().group_of(step).0 as f64;
        self.at(b.0 as f64 - a.0 as f64, group(b) - group(a))
    }

    /// That of two steps so many apart, on average over where they are in their groups.
    pub fn covariance_apart(&self, timing: &Timing, steps: usize) -> f64 {
        let lanes = timing.parallel as usize;
        let (groups, share) = ((steps / lanes) as f64, (steps % lanes) as f64 / lanes as f64);
        let [same, next] = [groups, groups + 1.0].map(|groups| self.at(steps as f64, groups));
        (1.0 - share) * same + share * next
    }

    /// The reference is a phase step later in each step, and light of another clock moves on from group to group.
    fn at(&self, steps: f64, groups: f64) -> f64 {
        let of_source = |source: &Slipping| source.at(steps + groups * source.per_group);
        self.sources.iter().map(of_source).sum()
    }

    /// What it adds to a signed count at most, beyond its average.
    pub fn most(&self) -> f64 {
        self.sources.iter().map(|source| source.most).sum()
    }

    /// Variance of a signed count.
    pub fn variance(&self) -> f64 {
        self.sources.iter().map(|source| source.at(0.0)).sum()
    }
}

impl Slipping {
    fn new(
        model: &DetectorModel,
        light: &ExcessLight,
        tier: CountingTier,
    ) -> Result<Slipping, MeanResponseError> {
        let timing = &model.timing;
        let samples = f64::from(timing.clock.samples_per_chip);
        let pitch_chips = timing.scan.integration_chips as f64;
        let scan_chips = timing.scan_chips() as f64;
        let slip = light.movement.as_ref().and_then(|movement| movement.slip);
        let rate = slip.map_or(0.0, |slip| slip.mean_rate(scan_chips));
        let counts = signed_counts(model, light, tier)?;
        let mean = counts.iter().sum::<f64>() / counts.len() as f64;
        Ok(Slipping {
            most: counts.iter().copied().fold(mean, f64::max) - mean,
            covariance: covariance(&counts, samples * rate * timing.scan.integration_chips as f64),
            per_group: samples * rate * pitch_chips,
        })
    }

    /// The covariance for any difference of delays, in phase steps.
    fn at(&self, apart: f64) -> f64 {
        let period = self.covariance.len();
        let whole = apart.floor();
        let part = apart - whole;
        let here = whole.rem_euclid(period as f64) as usize % period;
        let next = (here + 1) % period;
        self.covariance[here] + part * (self.covariance[next] - self.covariance[here])
    }
}

/// Signed counts of a step at every delay of some light, with all other light constant.
fn signed_counts(
    model: &DetectorModel,
    light: &ExcessLight,
    tier: CountingTier,
) -> Result<Vec<f64>, MeanResponseError> {
    let mut whole = model.clone();
    whole.timing.scan.first_step = 0;
    whole.timing.scan.steps = whole.timing.scan.steps_per_period;
    let all: f64 = model.excess.iter().map(ExcessLight::mean_per_chip).sum();
    let others = all - light.mean_per_chip();
    let light = Light {
        paths: vec![LightPath {
            code: Arc::clone(&light.code),
            rate_per_chip: light.rate_per_chip,
            delay_chips: 0.0,
            shape: Arc::clone(&light.shape),
        }],
        constant_per_chip: model.constant_per_chip + others,
    };
    let response = MeanResponse::to_light(&whole, light, tier)?;
    let counts = response.mean_counts_on_average();
    Ok(counts.iter().map(|count| count.signed).collect())
}

/// Covariance, by how far they are apart round the period, of averages of `values` over
/// `width` of them each.
fn covariance(values: &[f64], width: f64) -> Vec<f64> {
    let length = values.len();
    let kept = |(number, value): (usize, Complex64)| {
        let cycles = number.min(length - number) as f64 / length as f64;
        let angle = std::f64::consts::PI * cycles * width;
        let kept = if angle == 0.0 { 1.0 } else { angle.sin() / angle };
        // The mean is not scatter.
        let power = if number == 0 { 0.0 } else { value.norm_sqr() };
        Complex64::from(power * kept * kept / length as f64)
    };
    real(spectrum(values.iter().copied()).into_iter().enumerate().map(kept).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Averages over whole numbers of steps, by plain sums.
    #[test]
    fn covariances_are_those_of_moving_averages() {
        let values: Vec<f64> =
            (0..60).map(|n| f64::from((n * n * 7 + n) % 13) - f64::from(n % 5)).collect();
        // Linear between them: averages by many points of each step.
        let period = values.len();
        let mean = values.iter().sum::<f64>() / period as f64;
        let found = covariance(&values, 0.0);
        for apart in [0, 1, 7, 59] {
            let products =
                (0..period).map(|n| (values[n] - mean) * (values[(n + apart) % period] - mean));
            let expected = products.sum::<f64>() / period as f64;
            assert!((found[apart] - expected).abs() < 1e-9 * found[0], "{apart}");
        }
        // A cosine keeps sin(x) / x of its amplitude.
        let cosine: Vec<f64> =
            (0..60).map(|n| (std::f64::consts::TAU * f64::from(n) * 3.0 / 60.0).cos()).collect();
        let angle = std::f64::consts::PI * 3.0 / 60.0 * 4.5;
        let kept = 0.5 * (angle.sin() / angle).powi(2);
        let found = covariance(&cosine, 4.5);
        assert!((found[0] - kept).abs() < 1e-12);
        assert!((found[10] + kept).abs() < 1e-12);
    }
}
