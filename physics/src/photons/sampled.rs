//! What the hardware sees of the detections: pulses, sampled.

use super::detector::DetectorModel;
use super::step::{Detection, StepDetections};
use crate::scan::{Group, Sample, Sampling};

/// The samples during which one detection's pulse is high.
///
/// Sample s is the level at time s T_s, so a pulse covers the samples with
/// registered time <= s T_s < registered time + pulse width. Sample 0 is the
/// first sample of the first scan's first chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pulse {
    /// First high sample.
    pub first: Sample,
    /// The sample after the last high one.
    pub end: Sample,
}

impl Pulse {
    /// One sample long.
    pub fn of_one(first: Sample) -> Pulse {
        Pulse { first, end: first + 1 }
    }

    /// Numbers its samples as the run's whose sample `start` its own sample 0 is.
    pub fn shift(&mut self, start: Sample) {
        self.first += start.0;
        self.end += start.0;
    }
}

/// The pulses of a running scan, step after step (with `parallel` steps at
/// once, group after group: the steps of a group share their light).
///
/// There is one pulse per detection: pulses may touch or overlap, and the level
/// is high where any of them is. A pulse that lies between two samples leaves no
/// trace. Scans over the whole code period run on into the next repetition;
/// any other scan ends after its last step, because the hardware then waits for
/// the code's first chip: start a new stream for the next repetition.
#[derive(Debug, Clone)]
pub struct PulseStream<'m> {
    model: &'m DetectorModel,
    seed: u64,
    repetition: u64,
    group: Group,
    detections: StepDetections<'m>,
    /// Sample number at which the present group starts.
    group_start: Sample,
    /// Found, but not asked for yet.
    pending: Option<Pulse>,
    /// The group before which it ends, if it is to end before the scan does.
    last: Option<Group>,
    ended: bool,
}

impl<'m> PulseStream<'m> {
    /// The pulses from the start of scan number `repetition` on.
    pub fn new(model: &'m DetectorModel, seed: u64, repetition: u64) -> PulseStream<'m> {
        PulseStream {
            model,
            seed,
            repetition,
            group: Group(0),
            detections: model.step(seed, repetition, Group(0)),
            group_start: Sample(0),
            pending: None,
            last: None,
            ended: false,
        }
    }

    /// The same stream from a group's first pulse on, with the same sample numbers;
    /// `until` is the group before which it ends, none for where it always does.
    pub fn of_groups(
        model: &'m DetectorModel,
        seed: u64,
        repetition: u64,
        first: Group,
        until: Option<Group>,
    ) -> PulseStream<'m> {
        PulseStream {
            group: first,
            detections: model.step(seed, repetition, first),
            group_start: Sample(first.0 * group_samples(model)),
            last: until,
            ..PulseStream::new(model, seed, repetition)
        }
    }

    /// Appends every pulse with `first < until` that has not been
    /// returned yet, in order of `first`.
    pub fn advance(&mut self, until: Sample, out: &mut Vec<Pulse>) {
        loop {
            let Some(pulse) = self.pending.take().or_else(|| self.next_pulse(until)) else {
                return;
            };
            if pulse.first >= until {
                self.pending = Some(pulse);
                return;
            }
            out.push(pulse);
        }
    }

    /// The next pulse, or `None` if none starts before `until`.
    fn next_pulse(&mut self, until: Sample) -> Option<Pulse> {
        loop {
            // Groups that begin later are not even simulated yet.
            if self.ended || self.group_start >= until {
                return None;
            }
            match self.detections.next() {
                Some(detection) => {
                    let pulse = self.sample(detection);
                    if pulse.first < pulse.end {
                        return Some(pulse);
                    }
                }
                None => self.start_next_group(),
            }
        }
    }

    fn start_next_group(&mut self) {
        self.group.0 += 1;
        if self.last == Some(self.group) {
            self.ended = true;
            return;
        }
        if self.group.0 == self.model.timing.groups() {
            if !self.model.timing.is_gapless() {
                self.ended = true;
                return;
            }
            self.group = Group(0);
            self.repetition += 1;
        }
        self.group_start += group_samples(self.model);
        self.detections = self.model.step(self.seed, self.repetition, self.group);
    }

    #[inline]
    fn sample(&self, detection: Detection) -> Pulse {
        let samples_per_chip = self.model.timing.clock.samples_per_chip;
        let chip_start =
            self.group_start + Sampling::new(samples_per_chip).samples_of(detection.chip);
        let sample_at_or_after =
            |chips: f64| chip_start + ceil_to_u64(chips * f64::from(samples_per_chip));
        Pulse {
            first: sample_at_or_after(detection.fraction),
            end: sample_at_or_after(detection.fraction + self.model.pulse_width_chips),
        }
    }
}

/// Samples of a group of steps.
fn group_samples(model: &DetectorModel) -> u64 {
    let timing = &model.timing;
    timing.sampling().samples_of(timing.scan.integration_chips)
}

/// The least integer at or above a value that is not negative.
#[inline]
fn ceil_to_u64(value: f64) -> u64 {
    let whole = value as u64;
    whole + u64::from((whole as f64) < value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ceiling_of_whole_and_broken_values() {
        for (value, ceiling) in [(0.0, 0), (0.2, 1), (1.0, 1), (7.000001, 8)] {
            assert_eq!(ceil_to_u64(value), ceiling, "{value}");
        }
    }
}
