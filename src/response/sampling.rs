//! Which detections the sampled hardware counts.
//!
//! A detection registered at t makes the level high from t until t + w, and
//! hardware that samples it every T_s counts a rise between two samples. So
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

use super::MeanResponseError;
use super::light::Light;
use super::tier::CountingTier;
use crate::photons::DetectorModel;
use crate::scene::{DetectorIndex, JitterTail};
use crate::sensor::Sensor;

/// A smaller share of detections that merge than this is left out where it cannot be
/// worked out: it moves an estimate by a tenth of a millimetre at most.
const NEGLIGIBLE_SHARE: f64 = 1e-4;

/// Where the share of merged detections cannot reach this, merging is not worked out.
const NO_SHARE: f64 = 1e-9;

/// Widest jitter, in samples, with which merged pulses are worked out. They are where
/// detections would be without jitter; the differences cancel as long as jitter is
/// small beside a sample.
const LARGEST_JITTER_SAMPLES: f64 = 0.25;

/// Jitter of two detections is taken to reach this many standard deviations of their
/// difference.
const JITTER_REACH_SIGMAS: f64 = 6.0;

/// The tail of the jitter is taken to reach as far as all but this share of it does.
const TAIL_BEYOND: f64 = 1e-5;

/// Most sample instants that a ready detector may have to wait for.
const MOST_WAITS: usize = 64;

/// How the sampled level shows detections.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    samples_per_chip: f64,
    /// A pulse is seen if it is registered no longer than this before a sample.
    seen_chips: f64,
    /// Dead time less pulse width, in chips, if pulses can merge.
    merging: Option<f64>,
}

impl Sampling {
    /// The sampling of a tier; none for a counter that works in continuous time.
    ///
    /// # Errors
    /// When more pulses may merge than can be left out, and in a way that is not
    /// worked out.
    pub fn of(
        model: &DetectorModel,
        light: &Light,
        tier: CountingTier,
    ) -> Result<Option<Sampling>, MeanResponseError> {
        if tier == CountingTier::Events {
            return Ok(None);
        }
        let sample_chips = model.timing.clock.sample_period_chips();
        let sampling = Sampling {
            samples_per_chip: f64::from(model.timing.clock.samples_per_chip),
            seen_chips: model.pulse_width_chips.min(sample_chips),
            merging: None,
        };
        let share = merged_share(model, light);
        if share <= NO_SHARE {
            return Ok(Some(sampling));
        }
        match obstacle(model) {
            None => Ok(Some(Sampling {
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

    /// How long before a sample a pulse may be registered to be seen by it.
    pub fn seen_chips(&self) -> f64 {
        self.seen_chips
    }

    /// Whether no pulse falls between two samples.
    pub fn sees_all(&self) -> bool {
        self.seen_chips * self.samples_per_chip >= 1.0
    }

    /// Length of the part of `from..to` (registered times, in chips) in which a
    /// pulse is seen.
    pub fn seen_between(&self, from: f64, to: f64) -> f64 {
        self.seen_until(to) - self.seen_until(from)
    }

    /// The same from instant 0 on.
    fn seen_until(&self, time: f64) -> f64 {
        let samples = time * self.samples_per_chip;
        let whole = samples.floor();
        let unseen = 1.0 / self.samples_per_chip - self.seen_chips;
        let part = (samples - whole) / self.samples_per_chip - unseen;
        whole * self.seen_chips + part.max(0.0)
    }

    /// Registered times in a chip at which the number of instants to wait for
    /// changes: sample instants, and a margin after them.
    pub fn breaks(&self) -> Vec<f64> {
        let Some(margin) = self.merging else {
            return Vec::new();
        };
        (0..self.samples_per_chip as u32)
            .map(|sample| f64::from(sample) / self.samples_per_chip)
            .flat_map(|instant| [instant, instant + margin])
            .collect()
    }

    /// Sample instants that a detector which is ready at a registered time has to
    /// wait for until its next pulse counts.
    pub fn waits(&self, time: f64) -> usize {
        let Some(margin) = self.merging else { return 0 };
        let low = ((time - margin) * self.samples_per_chip).ceil();
        (low - (time * self.samples_per_chip).floor()).max(0.0) as usize
    }

    /// Whether a registered time is a sample instant.
    pub fn is_instant(&self, time: f64) -> bool {
        let samples = time * self.samples_per_chip;
        (samples - samples.round()).abs() < 2e-7 * self.samples_per_chip
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
        + sensor.clock().sample_period_ps()
        + JITTER_REACH_SIGMAS * std::f64::consts::SQRT_2 * spad.jitter_std_ps()
        - spad.dead_time_ps;
    let has_tail = spad.jitter_tail != JitterTail::None;
    if reach_ps <= 0.0 && !has_tail {
        return Ok(());
    }
    let model = DetectorModel::new(sensor, detector);
    Sampling::of(&model, &Light::of(&model), CountingTier::Sampled).map(|_| ())
}

/// Bound on the share of detections whose pulse merges with the one before: those
/// that follow it before the first sample that is surely low.
pub fn merged_share(model: &DetectorModel, light: &Light) -> f64 {
    let jitter = model.jitter_chips.unwrap_or(0.0) * std::f64::consts::SQRT_2;
    let sample_chips = model.timing.clock.sample_period_chips();
    let tail = model.tail.as_ref();
    let reach = model.pulse_width_chips
        + sample_chips
        + JITTER_REACH_SIGMAS * jitter
        + tail.map_or(0.0, |tail| tail.exceeded_by(TAIL_BEYOND))
        - model.dead_time_chips;
    if reach <= 0.0 {
        return 0.0;
    }
    let by_light = -(-light.brightest_per_chip() * reach).exp_m1();
    let by_afterpulses = model.afterpulsing.map_or(0.0, |afterpulsing| {
        let released = -(-reach / afterpulsing.time_constant_chips).exp_m1();
        -(-afterpulsing.mean_per_avalanche * released).exp_m1()
    });
    by_light + by_afterpulses - by_light * by_afterpulses
}

/// Why merged pulses of a detector are not worked out.
fn obstacle(model: &DetectorModel) -> Option<&'static str> {
    let sample_chips = model.timing.clock.sample_period_chips();
    let jitter_samples = model.jitter_chips.unwrap_or(0.0) / sample_chips;
    let waits = (model.pulse_width_chips - model.dead_time_chips) / sample_chips;
    let is_short = |chips: f64| chips < sample_chips;
    let dead_time = model.dead_time_chips;
    if dead_time > 0.0 && is_short(dead_time) && is_short(model.pulse_width_chips) {
        Some("a dead time and a pulse that are both shorter than a sample")
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
    use super::*;

    fn sampling(seen_chips: f64, merging: Option<f64>) -> Sampling {
        Sampling { samples_per_chip: 4.0, seen_chips, merging }
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
