//! The ways in which detections become counts.

use crate::photons::DetectorModel;

/// How detections are turned into counts; each way has its own offset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CountingTier {
    /// The article's continuous-time counter, with its edge delays.
    Events,
    /// The hardware's: a detection counts at the first sample at or after its
    /// registered time, with the reference of that sample.
    Sampled,
    /// Detections of a histogram, each in the bin of the first sample at or after its registered
    /// time: none merges with another, and none falls between two samples.
    Binned,
}

/// Where a tier's window and reference edges lie in registered time, in chips,
/// from where they would be without any delay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeTiming {
    /// Shift of a step's first and last instant.
    pub window: f64,
    /// Shift of the reference's rising edges.
    pub rising: f64,
    /// Shift of its falling edges.
    pub falling: f64,
    /// Within this distance of an edge either sign is equally likely.
    pub transition: f64,
}

impl EdgeTiming {
    /// The timing of a tier.
    ///
    /// A detection is sampled at sample s if it is registered since the sample before,
    /// in ((s - 1) T_s, s T_s] if samples are equally far apart: an edge of the reference at
    /// sample s divides registered times at sample s - 1, and so does a step's first sample.
    pub fn of(model: &DetectorModel, tier: CountingTier) -> EdgeTiming {
        match tier {
            CountingTier::Events => {
                let chips = |ps: f64| model.timing.clock.chips(ps);
                EdgeTiming {
                    window: 0.0,
                    rising: chips(model.counter.rising_delay_ps),
                    falling: chips(model.counter.falling_delay_ps),
                    transition: chips(model.counter.transition_ps),
                }
            }
            CountingTier::Sampled | CountingTier::Binned => {
                let early = model.sampler.instant(-1) * model.timing.clock.sample_period_chips();
                EdgeTiming { window: early, rising: early, falling: early, transition: 0.0 }
            }
        }
    }
}
