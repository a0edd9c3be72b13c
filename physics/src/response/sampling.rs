//! Which detections the sampled hardware counts.
//!
//! A detection registered at t makes the level high from t until t + w, and
//! hardware that samples it every T_s, or at the instants of its
//! [`Sampler`], counts a rise between two samples. So
//!
//! - a pulse is *seen* if a sample lies in it: if t is no more than w before the
//!   next sample instant;
//! - a pulse *merges* with the one before if no low sample lies between them. After
//!   a detection at t the first low sample is the first at or after t + w; a
//!   detection counts if it is registered after that instant, and pushes it on
//!   whether it counts or not.
//!
//! A detector that is ready again at r, one dead time D after it fired, thus waits
//! for the sample instants in (r, ceil((r + w - D) / T_s) T_s] until its next pulse
//! counts: none, if pulses are short beside the dead time. How many depends only on
//! where r lies between two instants, so that being ready is a state with one more
//! number, which each instant takes one off.

use std::ops::Range;

use super::MeanResponseError;
use super::light::Light;
use super::tier::CountingTier;
use crate::math::{exponential_normal_density, normal_density};
use crate::photons::DetectorModel;
use crate::photons::tail::Tail;
use crate::scan::Sampler;
use crate::scene::{DetectorIndex, JitterTail};
use crate::sensor::Sensor;

/// A smaller share of detections that merge than this is left out where it cannot be
/// worked out: with jitter, pulses merge at all places of the light nearly alike, which changes
/// the counts' scale and moves an estimate by a tenth of a millimetre at most.
const NEGLIGIBLE_SHARE: f64 = 5e-4;

/// Where the share of merged detections cannot reach this, merging is not worked out.
const NO_SHARE: f64 = 1e-9;

/// Widest jitter, in samples, with which merged pulses are worked out. They are where
/// detections would be without jitter; the differences cancel as long as jitter is
/// small beside a sample.
const LARGEST_JITTER_SAMPLES: f64 = 0.25;

/// Jitter of two detections is taken to reach this many standard deviations of their
/// difference (probability 10^-9 beyond it).
const JITTER_REACH_SIGMAS: f64 = 6.0;

/// Points of an average over jitter.
const JITTER_POINTS: u32 = 400;

/// Most sample instants that a ready detector may have to wait for.
const MOST_WAITS: usize = 64;

/// How the sampled level shows detections.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectionSampling {
    samples_per_chip: f64,
    sampler: Sampler,
    /// A pulse is seen if it is registered no longer than this before a sample.
    seen_chips: f64,
    /// Dead time less pulse width, in chips, if pulses can merge.
    merging: Option<f64>,
}

impl DetectionSampling {
    /// The sampling of a tier; none for a counter that works in continuous time. Where detections are
    /// binned, all of them are seen and none merge.
    ///
    /// # Errors
    /// When more pulses may merge than can be left out, and in a way that is not
    /// worked out.
    pub fn of(
        model: &DetectorModel,
        light: &Light,
        tier: CountingTier,
    ) -> Result<Option<DetectionSampling>, MeanResponseError> {
        let sample_chips = model.timing.clock.sample_period_chips();
        let widest_chips = model.sampler.widest() * sample_chips;
        let seeing = |seen_chips| DetectionSampling {
            samples_per_chip: f64::from(model.timing.clock.samples_per_chip),
            sampler: model.sampler.clone(),
            seen_chips,
            merging: None,
        };
        let sampling = match tier {
            CountingTier::Events => return Ok(None),
            CountingTier::Binned => return Ok(Some(seeing(widest_chips))),
            CountingTier::Sampled => seeing(model.pulse_width_chips.min(widest_chips)),
        };
        let share = merged_share(model, light);
        if share <= NO_SHARE {
            return Ok(Some(sampling));
        }
        match obstacle(model) {
            None => Ok(Some(DetectionSampling {
                merging: Some(model.dead_time_chips - model.pulse_width_chips),
                ..sampling
            })),
            Some(_) if share <= NEGLIGIBLE_SHARE => Ok(Some(sampling)),
            Some(obstacle) => Err(MeanResponseError::PulsesMerge {
                pulse_width_ps: model.timing.clock.ps(model.pulse_width_chips),
                dead_time_ps: model.timing.clock.ps(model.dead_time_chips),
                sample_ps: model.timing.clock.ps(sample_chips),
                share,
                obstacle,
            }),
        }
    }

    /// Whether some detections merge with the one before.
    pub fn merges(&self) -> bool {
        self.merging.is_some()
    }

    /// Registered time of a sample's instant, in chips.
    pub fn instant_chips(&self, sample: i64) -> f64 {
        self.sampler.instant(sample) / self.samples_per_chip
    }

    /// Where a registered time in chips is among the samples ([`Sampler::place`]).
    pub fn place(&self, time: f64) -> f64 {
        self.sampler.place(time * self.samples_per_chip)
    }

    /// From which registered time on, in chips, pulses are seen by a sample and not by the one
    /// before it.
    pub fn seen_from(&self, sample: i64) -> f64 {
        let before = self.instant_chips(sample - 1);
        before.max(self.instant_chips(sample) - self.seen_chips)
    }

    /// Whether no pulse falls between two samples.
    pub fn sees_all(&self) -> bool {
        self.seen_chips * self.samples_per_chip >= self.sampler.widest()
    }

    /// Length of the part of `from..to` (registered times, in chips) in which a
    /// pulse is seen.
    pub fn seen_between(&self, from: f64, to: f64) -> f64 {
        self.seen_until(to) - self.seen_until(from)
    }

    /// The same from instant 0 on.
    fn seen_until(&self, time: f64) -> f64 {
        let last = self.place(time).floor() as i64;
        let next = self.sampler.width(last + 1) / self.samples_per_chip;
        let unseen = next - next.min(self.seen_chips);
        let part = time - self.instant_chips(last) - unseen;
        self.seen_before(last) + part.max(0.0)
    }

    /// The same until a sample's instant.
    fn seen_before(&self, sample: i64) -> f64 {
        if self.sampler.is_even() {
            return sample as f64 * self.seen_chips;
        }
        let samples = self.samples_per_chip as i64;
        let seen_of = |samples: i64| -> f64 {
            let widths = (1..=samples).map(|sample| self.sampler.width(sample));
            widths.map(|width| (width / self.samples_per_chip).min(self.seen_chips)).sum()
        };
        let chips = sample.div_euclid(samples) as f64;
        let of_chips = if chips == 0.0 { 0.0 } else { chips * seen_of(samples) };
        of_chips + seen_of(sample.rem_euclid(samples))
    }

    /// Registered times in a chip at which the number of instants to wait for
    /// changes: sample instants, and a margin after them.
    pub fn breaks(&self) -> Vec<f64> {
        let Some(margin) = self.merging else {
            return Vec::new();
        };
        self.instants().flat_map(|instant| [instant, instant + margin]).collect()
    }

    /// Registered times of a chip's sample instants.
    pub fn instants(&self) -> impl Iterator<Item = f64> {
        (0..self.samples_per_chip as i64).map(|sample| self.instant_chips(sample))
    }

    /// Sample instants that a detector which is ready at a registered time has to
    /// wait for until its next pulse counts.
    pub fn waits(&self, time: f64) -> usize {
        let Some(margin) = self.merging else { return 0 };
        let low = self.place(time - margin).ceil();
        (low - self.place(time).floor()).max(0.0) as usize
    }
}

/// By how much the reference's edges come later in phase `phase` of the `samples_per_chip` of a
/// chip than in phase 0, in chips of registered time: as far as the samples before which they come
/// are apart, or by the phase itself where nothing is sampled.
pub fn phase_chips(sampling: Option<&DetectionSampling>, samples_per_chip: u64, phase: u64) -> f64 {
    match sampling {
        None => phase as f64 / samples_per_chip as f64,
        Some(sampling) => sampling.instant_chips(phase as i64 - 1) - sampling.instant_chips(-1),
    }
}

/// Whether the counts of sampled hardware can be expected, as far as pulses that merge
/// go, in the scene's own light. Prepares no light where none ever merge.
///
/// # Errors
/// Why not.
pub fn check_merging(sensor: &Sensor, detector: DetectorIndex) -> Result<(), MeanResponseError> {
    let spad = &sensor.scene().detectors[detector];
    let reach_ps = spad.pulse_width_ps
        + spad.sampler.widest() * sensor.clock().sample_period_ps()
        + JITTER_REACH_SIGMAS * std::f64::consts::SQRT_2 * spad.jitter_std_ps()
        - spad.dead_time_ps;
    let has_tail = spad.jitter_tail != JitterTail::None;
    if reach_ps <= 0.0 && !has_tail {
        return Ok(());
    }
    let model = DetectorModel::new(sensor, detector);
    let light = Light::of(&model).of_cell(&model);
    DetectionSampling::of(&model, &light, CountingTier::Sampled).map(|_| ())
}

/// Bound on the share of detections whose pulse merges with the one before, in the
/// brightest light: those that are registered before the first sample that is surely
/// low. Jitter brings them there as often as its distribution says; that the later one may
/// be late by the tail, too, which keeps the two apart, is left out.
pub fn merged_share(model: &DetectorModel, light: &Light) -> f64 {
    let brightest_per_chip = light.brightest_per_chip();
    // Chance of a detection within some time of the end of the dead time.
    let follows = |chips: f64| {
        let by_afterpulses = model.afterpulsing.map_or(0.0, |afterpulsing| {
            let released = -(-chips / afterpulsing.time_constant_chips).exp_m1();
            afterpulsing.mean_per_avalanche * released
        });
        if chips > 0.0 { -(-brightest_per_chip * chips - by_afterpulses).exp_m1() } else { 0.0 }
    };
    let sample_chips = model.sampler.widest() * model.timing.clock.sample_period_chips();
    let ready_chips = model.pulse_width_chips + sample_chips - model.dead_time_chips;
    let sigma = model.jitter_chips.unwrap_or(0.0) * std::f64::consts::SQRT_2;
    let early = |by: f64| mean_over_gaussian(ready_chips + by, sigma, follows);
    match &model.tail {
        None => early(0.0),
        Some(Tail::Delays(delays)) => delays.iter().map(|[by, share]| share * early(*by)).sum(),
        Some(tail @ Tail::Exponential { share, time_constant_chips: mean }) => {
            let reach = JITTER_REACH_SIGMAS * sigma;
            let density = |by: f64| exponential_normal_density(by, *mean, sigma);
            let by_tail =
                integral((-ready_chips).max(-reach)..tail.longest_chips() + reach, |by| {
                    density(by) * follows(ready_chips + by)
                });
            (1.0 - share) * early(0.0) + share * by_tail
        }
    }
}

/// Mean of a function of a normal number; what is not above zero counts for nothing.
fn mean_over_gaussian(mean: f64, sigma: f64, of: impl Fn(f64) -> f64) -> f64 {
    if sigma <= 0.0 {
        return of(mean);
    }
    let reach = JITTER_REACH_SIGMAS * sigma;
    integral((mean - reach).max(0.0)..mean + reach, |value| {
        normal_density((value - mean) / sigma) / sigma * of(value)
    })
}

/// Integral by the midpoint rule; none of an empty range.
fn integral(range: Range<f64>, of: impl Fn(f64) -> f64) -> f64 {
    let step = (range.end - range.start).max(0.0) / f64::from(JITTER_POINTS);
    let middles = (0..JITTER_POINTS).map(|n| range.start + (f64::from(n) + 0.5) * step);
    middles.map(of).sum::<f64>() * step
}

/// Why merged pulses of a detector are not worked out.
fn obstacle(model: &DetectorModel) -> Option<&'static str> {
    let [widest, narrowest] = [model.sampler.widest(), model.sampler.narrowest()]
        .map(|samples| samples * model.timing.clock.sample_period_chips());
    let jitter_samples = model.jitter_chips.unwrap_or(0.0) / narrowest;
    let waits = (model.pulse_width_chips - model.dead_time_chips) / narrowest;
    let is_short = |chips: f64| chips < widest;
    let dead_time = model.dead_time_chips;
    if dead_time > 0.0 && is_short(dead_time) && is_short(model.pulse_width_chips) {
        Some("a dead time and a pulse that are both shorter than a sample")
    } else if model.is_paralyzable {
        Some("recharge = \"passive\"")
    } else if model.tail.is_some() {
        Some("jitter with a tail")
    } else if jitter_samples > LARGEST_JITTER_SAMPLES {
        Some("jitter of more than a quarter of a sample")
    } else if waits > MOST_WAITS as f64 - 2.0 {
        Some("pulses more than 60 samples longer than the dead time")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::{RngExt, SeedableRng};
    use rand_distr::{Distribution, Exp1, StandardNormal};

    use super::*;
    use crate::photons::random::StreamRng;
    use crate::scene::{self, Setting};

    /// The quick scene's detector, with some of its keys' values.
    fn model(settings: &[String]) -> DetectorModel {
        let settings: Vec<Setting> = settings
            .iter()
            .map(|setting| format!("detector.{setting}").parse().expect("a setting"))
            .collect();
        let scene =
            scene::load_with(Path::new("../scenes/quick.toml"), &settings).expect("a scene");
        DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0))
    }

    fn late(sigma_ns: f64, share: f64, constant_ns: f64) -> Vec<String> {
        let mut late = vec![format!("jitter=[\"{sigma_ns} ns\"]")];
        if share > 0.0 {
            let tail = format!("share = {share}, time_constant = \"{constant_ns} ns\"");
            late.push(format!("jitter_tail={{ {tail} }}"));
        }
        late
    }

    /// Pairs of detections, one dead time and an exponential wait apart, each late by jitter
    /// of its own, drawn.
    #[test]
    fn pulses_merge_as_often_as_jitter_brings_them_together() {
        for (width_ns, sigma_ns, share, constant_ns) in [
            (13.0, 1.0, 0.0, 1.0),
            (10.0, 0.3, 0.2, 2.0),
            (12.0, 0.0, 0.05, 3.0),
            (16.0, 0.1, 0.0, 1.0),
        ] {
            let mut settings = late(sigma_ns, share, constant_ns);
            settings.push("dead_time=15 ns".to_owned());
            settings.push("afterpulsing={ probability = 0, time_constant = \"5 ns\" }".to_owned());
            settings.push(format!("pulse_width={width_ns} ns"));
            // 40 million detections a second, in chips of 8 ns.
            let light = Light { paths: Vec::new(), constant_per_chip: 0.04 * 8.0 };
            let found = merged_share(&model(&settings), &light);
            let mut rng = StreamRng::seed_from_u64(7);
            let mut late_ns = || {
                let tail_ns = if rng.random::<f64>() < share { constant_ns } else { 0.0 };
                let normal: f64 = StandardNormal.sample(&mut rng);
                let [wait, exponential]: [f64; 2] = [(); 2].map(|()| Exp1.sample(&mut rng));
                (wait / 0.04, tail_ns * exponential + sigma_ns * normal)
            };
            let draws = 400_000;
            let merges = |_: &i32| {
                let ((_, first_ns), (wait_ns, second_ns)) = (late_ns(), late_ns());
                15.0 + wait_ns + second_ns - first_ns < width_ns + 1.0
            };
            let drawn = (0..draws).filter(merges).count() as f64 / f64::from(draws);
            let error = 5.0 * (drawn / f64::from(draws)).sqrt();
            // A late second one, which keeps the two apart, is left out of the bound.
            assert!(found > drawn - error, "{found} {drawn}");
            assert!(found < drawn / (1.0 - share) + error, "{found} {drawn}");
        }
    }

    /// Pulses of 7 ns behind a dead time of 14 ns: below 10^-6 of the detections merge with a
    /// nanosecond of jitter, 1.9 in 10,000 with a tail (counted photon by photon).
    #[test]
    fn jitter_that_seldom_reaches_so_far_is_no_obstacle() {
        for (sigma_ns, share, range) in [(1.0, 0.0, 0.0..1e-6), (0.0535, 0.25, 1.9e-4..5e-4)] {
            let model = model(&late(sigma_ns, share, 1.5));
            let light = Light::of(&model);
            let found = merged_share(&model, &light);
            assert!(range.contains(&found), "{found}");
            assert!(DetectionSampling::of(&model, &light, CountingTier::Sampled).is_ok());
        }
    }

    fn sampling(seen_chips: f64, merging: Option<f64>) -> DetectionSampling {
        DetectionSampling {
            samples_per_chip: 4.0,
            sampler: Sampler::default(),
            seen_chips,
            merging,
        }
    }

    #[test]
    fn a_pulse_is_seen_just_before_a_sample() {
        let sampling = sampling(0.1, None);
        for (from, to, seen) in [
            (0.0, 0.25, 0.1),
            (0.0, 0.15, 0.0),
            (0.15, 0.25, 0.1),
            (0.2, 0.25, 0.05),
            (-0.25, 1.0, 0.5),
            (0.17, 0.43, 0.08 + 0.03),
        ] {
            let found = sampling.seen_between(from, to);
            assert!((found - seen).abs() < 1e-12, "{from} {to}: {found}");
        }
    }

    /// The first low sample after a pulse, found sample by sample.
    #[test]
    fn a_ready_detector_waits_for_the_first_low_sample() {
        let dead_time = 0.6;
        for pulse_width in [0.3, 0.45, 0.6, 0.71, 1.4] {
            let sampling = sampling(0.25, Some(dead_time - pulse_width));
            for number in 0..97 {
                let fired = 0.013 + f64::from(number) * 0.0377;
                let ready = fired + dead_time;
                let instant = |sample: u32| f64::from(sample) / 4.0;
                let is_low = |sample: &u32| instant(*sample) >= fired + pulse_width;
                let low = (0..100).find(is_low).expect("it ends");
                let waits = (0..=low).filter(|&s| instant(s) > ready).count();
                assert_eq!(sampling.waits(ready), waits, "{pulse_width} {fired}");
            }
        }
    }
}
