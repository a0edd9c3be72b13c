//! What a window that follows its own peak is expected to do: from the exact mean counts, without random numbers.

use crate::estimate::{CountingTier, calibration_offset_ps};
use crate::photons::DetectorModel;
use crate::response::{MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::Step;
use crate::scene::{DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// Places between two phase steps at which the expected counts are known.
const PLACES: usize = 8;
/// Places of the fraction of a position that a target which moves goes through.
const FRACTIONS: usize = 16;
/// Standard deviations by which a window's light has to be above the threshold for a target to be held.
const MARGIN_SIGMAS: f64 = 3.0;
/// Values of a normal number, in standard deviations, and their weights: means of smooth functions are exact enough.
const NORMAL: [(f64, f64); 7] = [
    (-3.0, 0.005_8),
    (-2.0, 0.054_3),
    (-1.0, 0.242_0),
    (0.0, 0.395_8),
    (1.0, 0.242_0),
    (2.0, 0.054_3),
    (3.0, 0.005_8),
];

/// Mean counts round a peak, and their variance.
#[derive(Debug, Clone)]
pub(super) struct Peak {
    samples_per_chip: usize,
    /// Mean counts, [`PLACES`] of them a step, from two chips before the light's delay on.
    counts: Vec<f64>,
    /// Variance of a step's count: nearly the same for all.
    pub variance: f64,
}

/// What the rule makes of a window on average.
#[derive(Debug, Clone, Copy)]
struct Seen {
    /// Distance from the window's middle, in steps.
    offset: f64,
    /// Sum of the counts.
    light: f64,
}

impl Peak {
    /// Of a path that stands still; counts of a tier.
    pub fn new(
        sensor: &Sensor,
        detector: DetectorIndex,
        path: PathIndex,
        tier: CountingTier,
    ) -> Result<Peak, MeanResponseError> {
        let clock = sensor.clock();
        let samples_per_chip = clock.samples_per_chip as usize;
        let reach = 2 * samples_per_chip;
        let offset_ps = calibration_offset_ps(sensor, detector, tier);
        let light_ps = sensor.scene().paths[path].delay_ps + offset_ps;
        let steps_per_period = sensor.timing().scan.steps_per_period;
        let place = (light_ps / clock.sample_period_ps()).round();
        let first = (place as i64 - reach as i64).rem_euclid(steps_per_period as i64) as u64;
        // The light comes at a whole step, and then later and later within one.
        let to_place_ps = place * clock.sample_period_ps() - light_ps;
        let round = sensor.with(|scene| {
            scene.scan.first_step = first;
            scene.scan.steps = (2 * reach as u64 + 1).min(steps_per_period);
        });
        let model = DetectorModel::new(&round, detector);
        let response = MeanResponse::of_tier(&model, tier)?;
        let mut counts = vec![0.0; 2 * reach * PLACES + 1];
        for within in 0..PLACES {
            let later_ps = within as f64 / PLACES as f64 * clock.sample_period_ps();
            let means = response.delayed(to_place_ps + later_ps)?.mean_counts_on_average();
            for (step, mean) in means.iter().enumerate() {
                // Step `step` is so far before the light's delay.
                if let Some(place) = (step * PLACES).checked_sub(within) {
                    counts[place] = mean.signed;
                }
            }
        }
        let middle = [Step::at(reach / 2), Step::at(3 * reach / 2)];
        let moments = SecondMoments::new(&response)?.of_steps(&middle);
        let variance = moments.iter().map(|moment| moment.signed_variance).sum::<f64>() / 2.0;
        Ok(Peak { samples_per_chip, counts, variance })
    }

    /// Expected count of a phase step so many steps behind the light's delay.
    fn count(&self, behind: f64) -> f64 {
        let last = self.counts.len() - 1;
        let place =
            ((behind + 2.0 * self.samples_per_chip as f64) * PLACES as f64).clamp(0.0, last as f64);
        let before = (place as usize).min(last - 1);
        let share = place - before as f64;
        (1.0 - share) * self.counts[before] + share * self.counts[before + 1]
    }

    /// The largest count.
    pub fn height(&self) -> f64 {
        self.count(0.0)
    }

    /// Sum of a window's counts with the light in its middle.
    fn light(&self) -> f64 {
        self.seen(0.0, 0.0).light
    }

    /// Of a window whose middle the light is `offset` steps behind in the middle of its time, and from which it goes
    /// away by `walk` steps in each phase step.
    fn seen(&self, offset: f64, walk: f64) -> Seen {
        let half = self.samples_per_chip;
        let mean = |steps: std::ops::Range<usize>| -> f64 {
            steps
                .map(|step| {
                    let from_middle = step as f64 + 0.5 - half as f64;
                    self.count(from_middle - offset - walk * from_middle)
                })
                .sum()
        };
        let (early, late) = (mean(0..half), mean(half..2 * half));
        let sigma = (half as f64 * self.variance).sqrt();
        let mut seen = Seen { offset: 0.0, light: early + late };
        for (early_sigmas, early_weight) in NORMAL {
            for (late_sigmas, late_weight) in NORMAL {
                let early = early + early_sigmas * sigma;
                let late = late + late_sigmas * sigma;
                let all = (early + late).max(f64::MIN_POSITIVE);
                let share = ((late - early) / all).clamp(-1.0, 1.0);
                seen.offset += early_weight * late_weight * share * half as f64 / 2.0;
            }
        }
        seen
    }

    /// The same of a position so many steps before the light, whose fraction is anything: how far behind the position
    /// the light is seen.
    fn seen_from(&self, before: f64, walk: f64) -> Seen {
        let mut mean = Seen { offset: 0.0, light: 0.0 };
        for fraction in 0..FRACTIONS {
            let within = (fraction as f64 + 0.5) / FRACTIONS as f64;
            for (middle, share) in middles(within) {
                let seen = self.seen(before - middle, walk);
                mean.offset += share * (seen.offset + middle) / FRACTIONS as f64;
                mean.light += share * seen.light / FRACTIONS as f64;
            }
        }
        mean
    }

    /// Standard deviation of what a window says of the light's delay, in steps.
    fn std(&self) -> f64 {
        let steps = 2.0 * self.samples_per_chip as f64;
        0.5 * self.samples_per_chip as f64 * (steps * self.variance).sqrt() / self.light()
    }

    /// Standard deviation of the position, in steps: of a loop of the first order whose windows err independently.
    pub fn position_std(&self, gain: f64) -> f64 {
        self.std() * (gain / (2.0 - gain)).sqrt()
    }

    /// How far from the light's delay the position of a target at rest stays, in steps; the delay is `place` steps.
    pub fn bias_at_rest(&self, place: f64, gain: f64) -> f64 {
        let sigma = self.position_std(gain);
        // How far the loop thinks to be from the light, if the position is on average so far behind it.
        let pull = |behind: f64| -> f64 {
            let of = |(sigmas, weight): (f64, f64)| {
                let position = place + behind + sigmas * sigma;
                let pulls = middles((position + 0.5).rem_euclid(1.0)).into_iter();
                let pulls = pulls.map(|(middle, share)| {
                    share * (self.seen(place - position - middle, 0.0).offset + middle)
                });
                weight * pulls.sum::<f64>()
            };
            NORMAL.into_iter().map(of).sum()
        };
        root(-1.0, 1.0, pull)
    }

    /// How far behind the middle of a window's time the position is that follows from it, in steps, of a target that goes
    /// `way` steps from window to window, of which it is in a phase step `share`; none where it is not held.
    pub fn lag(&self, way: f64, share: f64, gain: f64) -> Option<f64> {
        let (size, walk) = (way.abs(), way * share);
        // The later half of a window sees a target that goes away longer than the earlier one: the sign matters.
        let pull = |before: f64| gain * self.seen_from(before * way.signum(), walk).offset.abs();
        let before = (1..=20 * self.samples_per_chip)
            .map(|tenth| f64::from(tenth as u32) / 10.0)
            .take_while(|before| {
                let light = self.seen_from(before * way.signum(), walk).light;
                light > 0.5 * self.light()
            })
            .find(|before| pull(*before) >= size)?;
        let before = root((before - 0.1).max(0.0), before, |at| size - pull(at));
        Some(way.signum() * (size - before))
    }

    /// Steps from window to window of the fastest target that is held.
    pub fn fastest(&self, sign: f64, share: f64, gain: f64, threshold: f64) -> f64 {
        let sigma = (2.0 * self.samples_per_chip as f64 * self.variance).sqrt();
        let least = threshold * self.light() + MARGIN_SIGMAS * sigma;
        let most_pull = |way: f64| {
            (0..20 * self.samples_per_chip)
                .map(|tenth| f64::from(tenth as u32) / 10.0)
                .map(|before| self.seen_from(before * sign, sign * way * share))
                .take_while(|seen| seen.light >= least)
                .map(|seen| gain * seen.offset.abs())
                .fold(0.0, f64::max)
        };
        root(0.0, gain * self.samples_per_chip as f64, |way| most_pull(way) - way)
    }
}

/// How far from the position the windows' middles are, and how often, where half a step behind the position is so much
/// of a step behind a whole one: at the position on average.
fn middles(within: f64) -> [(f64, f64); 2] {
    [(-within, 1.0 - within), (1.0 - within, within)]
}

/// Where a function that falls, or does not rise again, becomes negative.
fn root(mut low: f64, mut high: f64, function: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        match function(middle) > 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An ideal triangle of 8 steps, 1000 high.
    fn triangle(variance: f64) -> Peak {
        let count = |place: i32| 1000.0 * (1.0 - f64::from(place.abs()) / 64.0).max(0.0);
        Peak { samples_per_chip: 8, counts: (-128..=128).map(count).collect(), variance }
    }

    /// D / 2A of a triangle: 2 h d over S h within half a step, and (2 u - 3 u^2 / 2) / (1 - u^2 / 2) of half a chip at
    /// u chips, to what steps make of integrals.
    #[test]
    fn the_offset_is_that_of_a_triangle() {
        let peak = triangle(1e-6);
        for offset in [-0.5, -0.25, 0.0, 0.125, 0.5] {
            let seen = peak.seen(offset, 0.0);
            assert!((seen.offset - offset).abs() < 1e-3, "{offset}: {seen:?}");
            assert!((seen.light - 8000.0).abs() < 1.0, "{seen:?}");
        }
        for u in [0.25_f64, 0.5, 0.75, 1.0] {
            let expected = 4.0 * (2.0 * u - 1.5 * u * u) / (1.0 - 0.5 * u * u);
            let seen = peak.seen(8.0 * u, 0.0);
            assert!((seen.offset - expected).abs() < 0.05, "{u}: {seen:?}, expected {expected}");
        }
    }

    /// The bound of a slope h / S in 2 S steps of variance V is S sqrt(V / (2 S)) / h, and the rule's own is no worse.
    #[test]
    fn a_window_scatters_as_the_bound_of_a_triangle() {
        let peak = triangle(400.0);
        let bound = 8.0 / 1000.0 * (400.0_f64 / 16.0).sqrt();
        assert!((peak.position_std(1.0) / bound - 1.0).abs() < 1e-9);
        assert!((peak.position_std(0.25) / bound - (1.0_f64 / 7.0).sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_target_at_rest_is_where_it_is() {
        let peak = triangle(100.0);
        for place in [50.0, 50.3, 50.5, 50.9] {
            // Between windows on both sides the corner of the triangle leaves at most 3 / (32 S).
            assert!(peak.bias_at_rest(place, 0.25).abs() < 0.0125, "{place}");
        }
    }

    /// A loop of the first order lags (1 - g) / g windows' way; the fastest target needs half a chip a window at gain 1.
    #[test]
    fn lag_and_fastest_target_are_those_of_a_first_order_loop() {
        let peak = triangle(1.0);
        for (way, gain) in [(0.1, 1.0), (-0.1, 0.5), (0.05, 0.25)] {
            let lag = peak.lag(way, 0.0, gain).expect("it is held");
            let expected = -way * (1.0 - gain) / gain;
            assert!((lag - expected).abs() < 0.02, "{way} {gain}: {lag}, expected {expected}");
        }
        for gain in [1.0, 0.25] {
            let fastest = peak.fastest(1.0, 0.0, gain, 0.5);
            assert!((fastest / (4.0 * gain) - 1.0).abs() < 0.06, "{gain}: {fastest}");
            assert!(peak.lag(1.1 * 4.0 * gain, 0.0, gain).is_none());
        }
    }
}
