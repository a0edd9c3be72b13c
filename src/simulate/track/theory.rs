//! What a window that follows its own peak is expected to do, from the exact mean counts: of a target that moves without random
//! numbers, of one at rest by the rule itself, with counts that are drawn.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::estimate::{CountingTier, calibration_offset_ps};
use crate::math::normal_cdf;
use crate::photons::DetectorModel;
use crate::reference::tracking::{Follower, WindowSums};
use crate::response::{MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::Step;
use crate::scene::{DetectorIndex, PathIndex};
use crate::sensor::Sensor;
use crate::sensor::track::{LIGHT_HALVINGS, TrackPlan, TrackSetting};

/// Places between two phase steps at which the expected counts are known.
const PLACES: usize = 8;
/// Places of the fraction of a position that a target which moves goes through.
const FRACTIONS: usize = 16;
/// Standard deviations by which a window's light has to be above the threshold for a target to be held.
const MARGIN_SIGMAS: f64 = 3.0;
/// Values of a normal number, in standard deviations, and their weights: Gauss and Hermite's, which give means of polynomials
/// of a degree up to 13 exactly (Abramowitz and Stegun, table 25.10, scaled).
const NORMAL: [(f64, f64); 7] = [
    (-3.750_439_718, 0.000_548_269),
    (-2.366_759_411, 0.030_757_124),
    (-1.154_405_395, 0.240_123_179),
    (0.0, 0.457_142_857),
    (1.154_405_395, 0.240_123_179),
    (2.366_759_411, 0.030_757_124),
    (3.750_439_718, 0.000_548_269),
];
/// Windows that are drawn of a target at rest, and those before them in which its loop settles.
const DRAWN: usize = 50_000;
const SETTLING: usize = 200;
const SEED: u64 = 0x7472_6163;

/// Mean counts round a peak, and their variance.
#[derive(Debug, Clone)]
pub(super) struct MeanPeak {
    samples_per_chip: usize,
    /// Mean counts, [`PLACES`] of them a step, from two chips before the light's delay on.
    counts: Vec<f64>,
    /// Variance of a step's count, mean over a window: it is nearly the same for all of them.
    variance: f64,
}

/// What the rule makes of a window on average.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    /// Distance from the window's middle, in steps.
    offset: f64,
    /// Sum of the counts.
    light: f64,
    /// Variance of the distance by the counts' noise, in steps^2.
    variance: f64,
    /// Variance of the mean distance between the two middles that a position leads to, in steps^2.
    middles_variance: f64,
}

/// Where a loop follows a target, in steps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Followed {
    /// How far the position is behind the target in the middle of the window's time, on average.
    pub bias: f64,
    /// Its standard deviation.
    pub std: f64,
}

impl MeanPeak {
    /// Of a path that stands still; counts of a tier.
    pub fn new(
        sensor: &Sensor,
        detector: DetectorIndex,
        path: PathIndex,
        tier: CountingTier,
    ) -> Result<MeanPeak, MeanResponseError> {
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
        Ok(MeanPeak { samples_per_chip, counts, variance })
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
        let (mut offset, mut square) = (0.0, 0.0);
        for (early_sigmas, early_weight) in NORMAL {
            for (late_sigmas, late_weight) in NORMAL {
                let early = early + early_sigmas * sigma;
                let late = late + late_sigmas * sigma;
                let all = (early + late).max(f64::MIN_POSITIVE);
                let said = ((late - early) / all).clamp(-1.0, 1.0) * 0.5 * half as f64;
                offset += early_weight * late_weight * said;
                square += early_weight * late_weight * said * said;
            }
        }
        let variance = square - offset * offset;
        Seen { offset, light: early + late, variance, middles_variance: 0.0 }
    }

    /// The same of the two middles that a position leads to, so many steps before the light, on average: how far behind
    /// the position the light is seen. `within` is as for [`middles`].
    fn seen_between(&self, before: f64, walk: f64, within: f64) -> Seen {
        let [near, far] = middles(within).map(|(middle, share)| {
            let seen = self.seen(before - middle, walk);
            (share, Seen { offset: seen.offset + middle, ..seen })
        });
        let middles_variance = near.0 * far.0 * (near.1.offset - far.1.offset).powi(2);
        Seen { middles_variance, ..Seen::mean([near, far]) }
    }

    /// The same of a position whose fraction is anything, on average.
    fn seen_from(&self, before: f64, walk: f64) -> Seen {
        Seen::mean((0..FRACTIONS).map(|fraction| {
            let within = (fraction as f64 + 0.5) / FRACTIONS as f64;
            (1.0 / FRACTIONS as f64, self.seen_between(before, walk, within))
        }))
    }

    /// Standard deviation of the sum of a window's counts, and of the difference of its halves.
    fn sum_std(&self) -> f64 {
        (2.0 * self.samples_per_chip as f64 * self.variance).sqrt()
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

    /// Of a target at rest at a phase step with a fraction; none where it is not held.
    ///
    /// Its windows have the two middles next to it, in an order that follows from the positions. In bright light that order is
    /// fixed, and no noise: so the rule itself is followed, with counts drawn from normal laws.
    pub fn at_rest(&self, place: f64, plan: TrackPlan) -> Option<Followed> {
        let (errors, unlocked) = self.drawn(place, 0.0, plan);
        // Without a count at its peak no window follows.
        if errors.is_empty() || unlocked >= 0.5 {
            return None;
        }
        let count = errors.len() as f64;
        let bias = errors.iter().sum::<f64>() / count;
        let variance = errors.iter().map(|error| (error - bias).powi(2)).sum::<f64>() / count;
        Some(Followed { bias, std: variance.sqrt() })
    }

    /// Errors of the positions of a target that starts at a phase step with a fraction and goes `way` steps from window to
    /// window, and the share of windows that say they have no light.
    fn drawn(&self, mut place: f64, way: f64, plan: TrackPlan) -> (Vec<f64>, f64) {
        let period = plan.period_steps as f64;
        let away = |steps: f64| steps - period * (steps / period).round();
        // What is lost is not looked for again.
        let setting = TrackSetting { is_on: true, patience: u32::MAX, ..plan.setting };
        let mut follower = Follower::new(plan, setting);
        follower.found(place.round() as u64, self.height() as i64);
        let half = self.samples_per_chip;
        let sigma = (half as f64 * self.variance).sqrt();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(SEED);
        let (mut errors, mut unlocked) = (Vec::with_capacity(DRAWN), 0.0);
        for update in 0..SETTLING + DRAWN {
            let Some(first) = follower.window() else { break };
            place += way;
            let mut half_sum = |from: usize| {
                let steps = (from..from + half).map(|step| (first + step as u64) as f64 - place);
                let mean: f64 = steps.map(|behind| self.count(away(behind))).sum();
                let error: f64 = StandardNormal.sample(&mut rng);
                (mean + sigma * error).round() as i64
            };
            let (early, late) = (half_sum(0), half_sum(half));
            follower.counted(WindowSums { all: early + late, slope: late - early });
            if update >= SETTLING {
                unlocked += f64::from(u8::from(!follower.is_locked())) / DRAWN as f64;
                errors.extend(follower.position_steps().map(|position| away(position - place)));
            }
        }
        (errors, unlocked)
    }

    /// Of a target that goes `way` steps from window to window, of which it is in a phase step `share`; none where it is
    /// not held.
    pub fn moving(&self, way: f64, share: f64, gain: f64) -> Option<Followed> {
        const APART: f64 = 0.5;
        let before = self.distance(way, share, gain)?;
        let [below, seen, above] =
            [-APART, 0.0, APART].map(|by| self.seen_from(before + by, way * share));
        let slope = (above.offset - below.offset) / (2.0 * APART);
        Some(Followed { bias: way - before, std: position_std(seen, slope, gain) })
    }

    /// How far before the target the middles of its windows are, in steps: so far that g d is its way from window to window.
    /// Dead time draws the peak to earlier steps: of a slow target that is most of the distance.
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

impl Seen {
    /// Mean of several, with weights that add up to 1.
    fn mean(all: impl IntoIterator<Item = (f64, Seen)>) -> Seen {
        all.into_iter().fold(Seen::default(), |sum, (weight, seen)| Seen {
            offset: sum.offset + weight * seen.offset,
            light: sum.light + weight * seen.light,
            variance: sum.variance + weight * seen.variance,
            middles_variance: sum.middles_variance + weight * seen.middles_variance,
        })
    }
}

/// Standard deviation of the position, in steps, of a loop that sees its target so on average.
///
/// A window that is a step farther behind says K less, with K = 1 at the target and less away from it, so that
/// the loop x' = (1 - g K) x has noise from two sources. Each window's own has the variance s^2 of the counts. And
/// middles are at whole steps and a half, from the position by o - o', with o what is owed, which is anything
/// between 0 and 1 from window to window: 1 - K of that does not cancel, of the variance m^2. Together
///
/// g^2 s^2 / (1 - a^2) + g^2 m^2 / (1 + a),  a = 1 - g K,
///
/// at the target s^2 g / (2 - g). Where the fraction of the position is anything, m^2 = (1 - K)^2 / 6.
fn position_std(seen: Seen, slope: f64, gain: f64) -> f64 {
    let kept = 1.0 - gain * slope;
    let noise = seen.variance / (1.0 - kept * kept);
    let middles = seen.middles_variance / (1.0 + kept);
    gain * (noise + middles).sqrt()
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
    fn triangle(variance: f64) -> MeanPeak {
        drawn_away(0.0, variance)
    }

    /// The same, so many steps before the light's delay, as dead time draws it.
    fn drawn_away(steps: f64, variance: f64) -> MeanPeak {
        let count =
            |place: i32| 1000.0 * (1.0 - (f64::from(place) / 8.0 + steps).abs() / 8.0).max(0.0);
        MeanPeak { samples_per_chip: 8, counts: (-128..=128).map(count).collect(), variance }
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
        for (gain, halvings) in [(1.0_f64, 0), (0.25, 2)] {
            let std = peak.at_rest(100.3, plan(8, halvings)).expect("it is held").std;
            assert!(
                (std / bound / (gain / (2.0 - gain)).sqrt() - 1.0).abs() < 0.05,
                "{gain} {std}"
            );
        }
    }

    /// The plan of a window of so many samples a chip, with a gain of so many halvings.
    fn plan(samples_per_chip: usize, gain_halvings: u32) -> TrackPlan {
        let setting =
            TrackSetting { is_on: true, gain_halvings, threshold_halvings: 1, patience: 15 };
        let sample_bits = samples_per_chip.ilog2();
        TrackPlan { sample_bits, step_bits: 11, period_steps: 2048, count_bits: 24, setting }
    }

    /// Mean and standard deviation of the rule's own errors, with gain 1/4, before a target that goes `way` steps from window
    /// to window.
    fn drawn(peak: &MeanPeak, way: f64) -> (f64, f64) {
        let (errors, _) = peak.drawn(100.3, way, plan(8, 2));
        let count = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / count;
        let variance = errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / count;
        (mean, variance.sqrt())
    }

    /// At two speeds, the second of which makes the scatter larger by half.
    #[test]
    fn drawn_counts_lag_and_scatter_as_expected() {
        let peak = triangle(2500.0);
        let mut stds = Vec::new();
        for way in [0.2, 0.45] {
            let (mean, std) = drawn(&peak, way);
            let expected = peak.moving(way, 0.0, 0.25).expect("it is held");
            assert!((mean - expected.bias).abs() < 0.05, "{way}: {mean}, {expected:?}");
            assert!((std / expected.std - 1.0).abs() < 0.05, "{way}: {std}, {expected:?}");
            stds.push(std);
        }
        assert!(stds[1] > 1.3 * stds[0], "{stds:?}");
    }

    /// A peak that dead time draws to earlier steps is followed by as much earlier, at rest and at any speed, with the
    /// scatter of one that it does not: so the rule itself does.
    #[test]
    fn a_peak_that_dead_time_draws_away_is_followed_there() {
        let ideal = triangle(2500.0);
        for (steps, way) in [(0.56, 0.03), (0.56, -0.03), (1.8, 0.0), (1.8, 0.2), (1.8, -0.2)] {
            let peak = drawn_away(steps, 2500.0);
            let [expected, undrawn] = [&peak, &ideal].map(|peak| {
                let followed = match way == 0.0 {
                    true => peak.at_rest(100.3, plan(8, 2)),
                    false => peak.moving(way, 0.0, 0.25),
                };
                followed.expect("it is held")
            });
            let (bias, undrawn) = (expected.bias, undrawn.bias);
            assert!((bias - (undrawn - steps)).abs() < 0.02, "{steps} {way}: {bias}, {undrawn}");
            if way == 0.0 {
                // What is expected is drawn itself.
                continue;
            }
            let (mean, std) = drawn(&peak, way);
            assert!((mean - bias).abs() < 0.05, "{steps} {way}: {mean}, expected {bias}");
            assert!((std / expected.std - 1.0).abs() < 0.05, "{steps} {way}: {std}, {expected:?}");
        }
    }

    #[test]
    fn nothing_is_expected_where_no_window_follows() {
        let dark =
            MeanPeak { samples_per_chip: 8, counts: vec![0.0; 16 * PLACES + 1], variance: 0.1 };
        assert!(dark.at_rest(100.3, plan(8, 2)).is_none());
    }

    /// Without noise a target at a quarter of a step before a step is between the same two middles for ever, of which the
    /// nearer one has three windows in four: with gain 1 the error is what the middles leave, whatever their order.
    #[test]
    fn a_target_at_rest_scatters_by_its_middles_alone_where_counts_do_not() {
        let count = |place: i32| 1e6 * (1.0 - f64::from(place.abs()) / 8.0 / 4.0).max(0.0);
        let counts: Vec<f64> = (-64..=64).map(count).collect();
        let peak = MeanPeak { samples_per_chip: 4, counts, variance: 1e-9 };
        for place in [100.0, 100.25, 100.5] {
            let followed = peak.at_rest(place, plan(4, 0)).expect("it is held");
            assert!(followed.std < 0.05 && followed.bias.abs() < 0.05, "{place}: {followed:?}");
        }
    }

    /// With two standard deviations between light and threshold one window in 40 says it has no light.
    #[test]
    fn drawn_counts_unlock_as_often_as_expected() {
        let peak = triangle(250_000.0);
        let (_, share) = peak.drawn(100.3, 0.0, plan(8, 2));
        let expected = peak.false_alarms(0.5);
        assert!((0.01..0.04).contains(&expected), "{expected}");
        assert!((share / expected - 1.0).abs() < 0.2, "{share}, expected {expected}");
    }

    #[test]
    fn a_target_at_rest_is_where_it_is() {
        let peak = triangle(100.0);
        for place in [50.0, 50.3, 50.5, 50.9] {
            // Between windows on both sides the corner of the triangle leaves at most 3 / (32 S).
            let bias = peak.at_rest(place, plan(8, 2)).expect("it is held").bias;
            assert!(bias.abs() < 0.0125, "{place}");
        }
    }

    /// A loop of the first order lags (1 - g) / g windows' way; the fastest target needs half a chip a window at gain 1.
    #[test]
    fn lag_and_fastest_target_are_those_of_a_first_order_loop() {
        let peak = triangle(1.0);
        for (way, gain) in [(0.1, 1.0), (-0.1, 0.5), (0.05, 0.25)] {
            let lag = peak.moving(way, 0.0, gain).expect("it is held").bias;
            let expected = -way * (1.0 - gain) / gain;
            assert!((lag - expected).abs() < 0.02, "{way} {gain}: {lag}, expected {expected}");
        }
        for gain in [1.0, 0.25] {
            let fastest = peak.fastest(1.0, 0.0, gain, 0.5);
            assert!((fastest / (4.0 * gain) - 1.0).abs() < 0.06, "{gain}: {fastest}");
            assert!(peak.moving(1.1 * 4.0 * gain, 0.0, gain).is_none());
        }
    }
}
