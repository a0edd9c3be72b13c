//! What a window that follows its own peak is expected to do: from the exact mean counts, without random numbers.

use crate::estimate::{CountingTier, calibration_offset_ps};
use crate::math::normal_cdf;
use crate::photons::DetectorModel;
use crate::response::{MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::Step;
use crate::scene::{DetectorIndex, PathIndex};
use crate::sensor::Sensor;
use crate::sensor::track::LIGHT_HALVINGS;

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
    /// Variance of a step's count, mean over a window: it is nearly the same for all of them.
    variance: f64,
}

/// What the rule makes of a window on average.
#[derive(Debug, Clone, Copy)]
struct Seen {
    /// Distance from the window's middle, in steps.
    offset: f64,
    /// Sum of the counts.
    light: f64,
    /// Variance of the distance, in steps^2.
    variance: f64,
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
        let window: Vec<Step> = (reach / 2..3 * reach / 2).map(Step::at).collect();
        let moments = SecondMoments::new(&response)?.of_steps(&window);
        let variances = moments.iter().map(|moment| moment.signed_variance);
        let variance = variances.sum::<f64>() / window.len() as f64;
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
        let light = early + late;
        let mut seen = Seen { offset: 0.0, light, variance: 0.0 };
        for (early_sigmas, early_weight) in NORMAL {
            for (late_sigmas, late_weight) in NORMAL {
                let early = early + early_sigmas * sigma;
                let late = late + late_sigmas * sigma;
                let all = (early + late).max(f64::MIN_POSITIVE);
                let share = ((late - early) / all).clamp(-1.0, 1.0);
                seen.offset += early_weight * late_weight * share * half as f64 / 2.0;
            }
        }
        // Of d = S D / (2 A), D and A have the same variance and, as halves have the same one, no covariance.
        let half_chip = 0.5 * half as f64;
        seen.variance = (self.sum_std() / light * half_chip.hypot(seen.offset)).powi(2);
        seen
    }

    /// The same of a position so many steps before the light, whose fraction is anything, on average: how far behind the
    /// position the light is seen, and with what variance.
    fn seen_from(&self, before: f64, walk: f64) -> Seen {
        let mut mean = Seen { offset: 0.0, light: 0.0, variance: 0.0 };
        for fraction in 0..FRACTIONS {
            let within = (fraction as f64 + 0.5) / FRACTIONS as f64;
            for (middle, share) in middles(within) {
                let seen = self.seen(before - middle, walk);
                mean.offset += share * (seen.offset + middle) / FRACTIONS as f64;
                mean.light += share * seen.light / FRACTIONS as f64;
                mean.variance += share * seen.variance / FRACTIONS as f64;
            }
        }
        mean
    }

    /// Standard deviation of the sum of a window's counts, and of the difference of its halves.
    fn sum_std(&self) -> f64 {
        (2.0 * self.samples_per_chip as f64 * self.variance).sqrt()
    }

    /// Standard deviation of the position, in steps, of a target that the windows' middles are so many steps before on
    /// average.
    ///
    /// A window that is a step farther behind says K less, with K = 1 at the target and less away from it, so that
    /// the loop x' = (1 - g K) x has noise from two sources. Each window's own has the variance s^2 of the counts. And
    /// middles are at whole steps and a half, from the position by o - o', with o what is owed, which is anything
    /// between 0 and 1 from window to window: 1 - K of that does not cancel. Together
    ///
    /// g^2 s^2 / (1 - a^2) + g^2 (1 - K)^2 / (6 (1 + a)),  a = 1 - g K,
    ///
    /// at the target s^2 g / (2 - g).
    fn std_about(&self, before: f64, walk: f64, gain: f64) -> f64 {
        const APART: f64 = 0.5;
        let [below, seen, above] = [-APART, 0.0, APART].map(|by| self.seen_from(before + by, walk));
        let slope = (above.offset - below.offset) / (2.0 * APART);
        let kept = 1.0 - gain * slope;
        let noise = seen.variance / (1.0 - kept * kept);
        let middles = (1.0 - slope).powi(2) / (6.0 * (1.0 + kept));
        gain * (noise + middles).sqrt()
    }

    /// The same of a target that goes `way` steps from window to window, of which it is in a phase step `share`;
    /// none where it is not held.
    pub fn position_std(&self, way: f64, share: f64, gain: f64) -> Option<f64> {
        Some(self.std_about(self.distance(way, share, gain)?, way * share, gain))
    }

    /// The share of windows with the target in their middle that say they have not its light. What is expected
    /// of them is the mean of the windows so far, weighed with (1 - 1/16)^n.
    pub fn false_alarms(&self, threshold: f64) -> f64 {
        let weight = 0.5_f64.powi(LIGHT_HALVINGS as i32);
        let expected_variance = weight / (2.0 - weight);
        let std = self.sum_std() * (1.0 + threshold * threshold * expected_variance).sqrt();
        normal_cdf((threshold - 1.0) * self.light() / std)
    }

    /// The share of first windows behind a scan that say they have not the light, and the light over what is expected of
    /// them: S times the peak's count. Of a triangle that is the light, and the share that of all windows; an interleaved
    /// code counts down beside its peak.
    pub fn first_alarms(&self, threshold: f64) -> (f64, f64) {
        let expected = self.samples_per_chip as f64 * self.height();
        let share = normal_cdf((threshold * expected - self.light()) / self.sum_std());
        (share, self.light() / expected)
    }

    /// How far from the light's delay the position of a target at rest stays, in steps; the delay is `place` steps.
    pub fn bias_at_rest(&self, place: f64, gain: f64) -> Option<f64> {
        let sigma = self.position_std(0.0, 0.0, gain)?;
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
        let chip = self.samples_per_chip as f64;
        Some(root(-chip, chip, pull))
    }

    /// How far behind the middle of a window's time the position is that follows from it, in steps, of a target that goes
    /// `way` steps from window to window, of which it is in a phase step `share`; none where it is not held.
    pub fn lag(&self, way: f64, share: f64, gain: f64) -> Option<f64> {
        Some(way - self.distance(way, share, gain)?)
    }

    /// How far before the target the middles of its windows are, in steps: so far that g d is its way from window to window.
    /// Of a target at rest that is where dead time, which draws the peak to earlier steps, lets it be seen.
    fn distance(&self, way: f64, share: f64, gain: f64) -> Option<f64> {
        let (sign, walk) = (1_f64.copysign(way), way * share);
        let chip = self.samples_per_chip as f64;
        // The later half of a window sees a target that goes away longer than the earlier one: the sign matters.
        let seen = |before: f64| self.seen_from(before * sign, walk);
        let short = |before: f64| way.abs() - gain * seen(before).offset * sign;
        let at_rest = root(-chip, chip, |before| -seen(before).offset * sign);
        let before = (0..=20 * self.samples_per_chip)
            .map(|tenth| at_rest + f64::from(tenth as u32) / 10.0)
            .take_while(|before| seen(*before).light > 0.5 * self.light())
            .find(|before| short(*before) <= 0.0)?;
        Some(sign * root(before - 0.1, before, short))
    }

    /// Steps from window to window of the fastest target that is held.
    pub fn fastest(&self, sign: f64, share: f64, gain: f64, threshold: f64) -> f64 {
        let least = threshold * self.light() + MARGIN_SIGMAS * self.sum_std();
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
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::reference::tracking::{Follower, Sums};
    use crate::sensor::track::{TrackPlan, TrackSetting};

    /// An ideal triangle of 8 steps, 1000 high.
    fn triangle(variance: f64) -> Peak {
        drawn_away(0.0, variance)
    }

    /// The same, so many steps before the light's delay, as dead time draws it.
    fn drawn_away(steps: f64, variance: f64) -> Peak {
        let count =
            |place: i32| 1000.0 * (1.0 - (f64::from(place) / 8.0 + steps).abs() / 8.0).max(0.0);
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
        let peak = triangle(2500.0);
        let bound = 8.0 / 1000.0 * (2500.0_f64 / 16.0).sqrt();
        for gain in [1.0, 0.25] {
            let std = peak.position_std(0.0, 0.0, gain).expect("it is held");
            assert!(
                (std / bound / (gain / (2.0 - gain)).sqrt() - 1.0).abs() < 0.05,
                "{gain} {std}"
            );
        }
    }

    /// The rule itself, with gain 1/4, before a target that goes `way` steps from window to window; counts are drawn from
    /// normal laws. Mean and standard deviation of the position's error, and the share of windows that say they have no
    /// light.
    fn drawn(peak: &Peak, way: f64) -> (f64, f64, f64) {
        const PERIOD: f64 = 2048.0;
        let away = |steps: f64| (steps + 0.5 * PERIOD).rem_euclid(PERIOD) - 0.5 * PERIOD;
        let setting =
            TrackSetting { is_on: true, gain_halvings: 2, threshold_halvings: 1, patience: 15 };
        let (step_bits, period_steps) = (11, PERIOD as u64);
        let plan = TrackPlan { sample_bits: 3, step_bits, period_steps, count_bits: 24, setting };
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
        let mut follower = Follower::new(plan, setting);
        let mut place = 100.3;
        follower.found(100, peak.height() as i64);
        let (mut errors, mut unlocked) = (Vec::new(), 0.0);
        for update in 0..20_000 {
            let first = follower.window().expect("it is not lost");
            place += way;
            let count = |step: u64| {
                let mean = peak.count(away((first + step) as f64 - place));
                (mean + peak.variance.sqrt() * normal()).round() as i64
            };
            follower.counted(Sums::of(&(0..16).map(count).collect::<Vec<_>>(), 8));
            unlocked += f64::from(u8::from(!follower.is_locked()));
            if update >= 100 {
                errors.push(away(follower.position_steps().expect("it is not lost") - place));
            }
        }
        let count = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / count;
        let variance = errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / count;
        (mean, variance.sqrt(), unlocked / 20_000.0)
    }

    /// At rest and at two speeds, the second of which makes the scatter larger by half.
    #[test]
    fn drawn_counts_lag_and_scatter_as_expected() {
        let peak = triangle(2500.0);
        let mut stds = Vec::new();
        for way in [0.0, 0.2, 0.45] {
            let (mean, std, _) = drawn(&peak, way);
            let lag = if way == 0.0 { 0.0 } else { peak.lag(way, 0.0, 0.25).expect("it is held") };
            let expected = peak.position_std(way, 0.0, 0.25).expect("it is held");
            assert!((mean - lag).abs() < 0.05, "{way}: {mean}, expected {lag}");
            assert!((std / expected - 1.0).abs() < 0.05, "{way}: {std}, expected {expected}");
            stds.push(std);
        }
        assert!(stds[2] > 1.3 * stds[0], "{stds:?}");
    }

    /// A peak that dead time draws to earlier steps is followed by as much earlier, at rest and at any speed, with the
    /// scatter of one that it does not: so the rule itself does.
    #[test]
    fn a_peak_that_dead_time_draws_away_is_followed_there() {
        let ideal = triangle(2500.0);
        for (steps, way) in [(0.56, 0.03), (0.56, -0.03), (1.8, 0.0), (1.8, 0.2), (1.8, -0.2)] {
            let peak = drawn_away(steps, 2500.0);
            let (mean, std, _) = drawn(&peak, way);
            let bias = match way == 0.0 {
                true => peak.bias_at_rest(100.3, 0.25),
                false => peak.lag(way, 0.0, 0.25),
            };
            let bias = bias.expect("it is held");
            let undrawn = ideal.lag(way, 0.0, 0.25).expect("it is held");
            assert!((bias - (undrawn - steps)).abs() < 0.02, "{steps} {way}: {bias}, {undrawn}");
            assert!((mean - bias).abs() < 0.05, "{steps} {way}: {mean}, expected {bias}");
            let expected = peak.position_std(way, 0.0, 0.25).expect("it is held");
            assert!((std / expected - 1.0).abs() < 0.05, "{steps} {way}: {std}, {expected}");
        }
    }

    /// With two standard deviations between light and threshold one window in 40 says it has no light.
    #[test]
    fn drawn_counts_unlock_as_often_as_expected() {
        let peak = triangle(250_000.0);
        let (_, _, share) = drawn(&peak, 0.0);
        let expected = peak.false_alarms(0.5);
        assert!((0.01..0.04).contains(&expected), "{expected}");
        assert!((share / expected - 1.0).abs() < 0.2, "{share}, expected {expected}");
    }

    #[test]
    fn a_target_at_rest_is_where_it_is() {
        let peak = triangle(100.0);
        for place in [50.0, 50.3, 50.5, 50.9] {
            // Between windows on both sides the corner of the triangle leaves at most 3 / (32 S).
            let bias = peak.bias_at_rest(place, 0.25).expect("it is held");
            assert!(bias.abs() < 0.0125, "{place}");
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
