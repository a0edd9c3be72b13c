//! What the hardware sees of the detections: pulses, sampled.

use std::collections::VecDeque;
use std::sync::Arc;

use super::detector::DetectorModel;
use super::fast::{CHIP_BITS, Recorder, RegisteredSteps, RegisteredTicks};
use super::registration::Detection;
use super::step::GroupDetections;
use crate::scan::{Group, Sample, Sampler, Sampling};

/// The samples during which one detection's pulse is high.
///
/// Sample s is the level at its instant, s T_s if samples are equally far apart, so a pulse covers
/// the samples with registered time <= instant < registered time + pulse width. Sample 0 is the
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

/// The level at the samples, high wherever any pulse is. It is low before the first.
#[derive(Debug, Clone, Default)]
pub struct Level {
    /// The sample after the last high one; none before the first pulse.
    low_from: Option<Sample>,
}

impl Level {
    /// Whether a pulse, which begins no earlier than the one before it, begins with a high
    /// sample after a low one.
    #[inline]
    pub fn rises(&mut self, pulse: &Pulse) -> bool {
        let rises = self.low_from.is_none_or(|low_from| low_from < pulse.first);
        self.low_from = self.low_from.max(Some(pulse.end));
        rises
    }
}

/// The pulses at a detector's inputs in a running scan, step after step (with `parallel` steps at
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
    detections: Detections<'m>,
    /// Sample number at which the present group starts.
    group_start: Sample,
    /// The group before which it ends, if it is to end before the scan does.
    last: Option<Group>,
    ended: bool,
}

/// The detections of a stream's groups, of which the first is the present one.
#[derive(Debug, Clone)]
enum Detections<'m> {
    /// By the plain loop, and the pulse that was found, but not asked for yet, with its input.
    OneByOne { group: GroupDetections<'m>, pending: Option<(Pulse, usize)> },
    /// By the vector lanes, some groups ahead; and how many of the present one's are used.
    Recorded { recorder: Arc<Recorder<'m>>, groups: VecDeque<RegisteredSteps>, used: usize },
}

impl<'m> PulseStream<'m> {
    /// The pulses from the start of scan number `repetition` on.
    pub fn new(model: &'m DetectorModel, seed: u64, repetition: u64) -> PulseStream<'m> {
        let recorder = Arc::new(Recorder::new(model));
        PulseStream::of_groups(&recorder, seed, repetition, Group(0), None)
    }

    /// The same from the plain loop, the referee of the vector lanes: other pulses, of the
    /// same distribution.
    pub fn of_plain_loop(model: &'m DetectorModel, seed: u64, repetition: u64) -> PulseStream<'m> {
        let group = model.step(seed, repetition, Group(0));
        PulseStream {
            model,
            seed,
            repetition,
            group: Group(0),
            detections: Detections::OneByOne { group, pending: None },
            group_start: Sample(0),
            last: None,
            ended: false,
        }
    }

    /// The same stream from a group's first pulse on, with the same sample numbers;
    /// `until` is the group before which it ends, none for where it always does.
    pub fn of_groups(
        recorder: &Arc<Recorder<'m>>,
        seed: u64,
        repetition: u64,
        first: Group,
        until: Option<Group>,
    ) -> PulseStream<'m> {
        let model = recorder.model();
        let detections = match recorder.groups_at_once() {
            Some(_) => Detections::Recorded {
                recorder: Arc::clone(recorder),
                groups: VecDeque::new(),
                used: 0,
            },
            None => {
                let group = model.step(seed, repetition, first);
                Detections::OneByOne { group, pending: None }
            }
        };
        PulseStream {
            model,
            seed,
            repetition,
            group: first,
            detections,
            group_start: Sample(first.0 * group_samples(model)),
            last: until,
            ended: false,
        }
    }

    /// Inputs of its detector.
    pub fn inputs(&self) -> usize {
        self.model.inputs()
    }

    /// Appends every pulse with `first < until` that has not been
    /// returned yet, in order of `first`.
    ///
    /// # Panics
    /// If the detector has several inputs.
    pub fn advance(&mut self, until: Sample, out: &mut Vec<Pulse>) {
        self.advance_inputs(until, std::slice::from_mut(out));
    }

    /// The same of each input.
    ///
    /// # Panics
    /// If the detector has not as many.
    pub fn advance_inputs(&mut self, until: Sample, out: &mut [Vec<Pulse>]) {
        assert_eq!(out.len(), self.model.inputs(), "a list for each input");
        // Groups that begin later are not even simulated yet.
        while !self.ended && self.group_start < until {
            if !self.advance_in_group(until, out) {
                return;
            }
            self.start_next_group();
        }
    }

    /// Whether the group has no further pulses.
    fn advance_in_group(&mut self, until: Sample, out: &mut [Vec<Pulse>]) -> bool {
        let start = self.group_start;
        match &mut self.detections {
            Detections::OneByOne { group, pending } => {
                let model = self.model;
                let sampled = |(detection, width_chips, input)| {
                    (sample((detection, width_chips), model, start), input)
                };
                while let Some((pulse, input)) =
                    pending.take().or_else(|| group.next_pulse().map(sampled))
                {
                    if pulse.first >= until {
                        *pending = Some((pulse, input));
                        return false;
                    }
                    out[input].extend((pulse.first < pulse.end).then_some(pulse));
                }
            }
            Detections::Recorded { groups, used, .. } => {
                if groups.is_empty() {
                    self.record();
                    return self.advance_in_group(until, out);
                }
                let sampler = TickSampler::new(self.model);
                let RegisteredSteps { times, ends, inputs } = &groups[0];
                let left = &times[*used..];
                let first = |&time: &RegisteredTicks| sampler.at_or_after(time.0, start);
                let now = left.partition_point(|time| first(time) < until);
                let pulse = |time: &RegisteredTicks| sampler.pulse(*time, start);
                let level = |(time, end): (&RegisteredTicks, &RegisteredTicks)| Pulse {
                    first: first(time),
                    end: first(end),
                };
                let is_seen = |pulse: &Pulse| pulse.first < pulse.end;
                match (&mut *out, ends.get(*used..*used + now), sampler.sees_all()) {
                    ([out], Some(ends), _) if now > 0 => {
                        out.extend(left[..now].iter().zip(ends).map(level).filter(is_seen));
                    }
                    ([out], _, true) => out.extend(left[..now].iter().map(pulse)),
                    ([out], ..) => out.extend(left[..now].iter().map(pulse).filter(is_seen)),
                    (out, ..) => {
                        for (time, input) in left[..now].iter().zip(&inputs[*used..]) {
                            let pulse = Some(pulse(time)).filter(is_seen);
                            out[usize::from(*input)].extend(pulse);
                        }
                    }
                }
                *used += now;
                if now < left.len() {
                    return false;
                }
            }
        }
        true
    }

    /// Records the present group and some that follow.
    fn record(&mut self) {
        let (mut repetition, mut group) = (self.repetition, self.group);
        let mut jobs = Vec::new();
        if let Detections::Recorded { recorder, groups, .. } = &mut self.detections {
            let most = recorder.groups_at_once().unwrap_or(1);
            loop {
                jobs.push((repetition, group));
                let next = next_group(self.model, repetition, group, self.last);
                match next.filter(|_| jobs.len() < most) {
                    Some(next) => (repetition, group) = next,
                    None => break,
                }
            }
            groups.extend(recorder.record_pulses(self.seed, &jobs));
        }
    }

    fn start_next_group(&mut self) {
        let next = next_group(self.model, self.repetition, self.group, self.last);
        let Some((repetition, number)) = next else {
            self.ended = true;
            return;
        };
        (self.repetition, self.group) = (repetition, number);
        self.group_start += group_samples(self.model);
        match &mut self.detections {
            Detections::OneByOne { group, .. } => {
                *group = self.model.step(self.seed, repetition, number);
            }
            Detections::Recorded { groups, used, .. } => {
                groups.pop_front();
                *used = 0;
            }
        }
    }
}

/// The group that follows one without a gap, with the number of its scan. Up to `last` groups follow one another,
/// whatever scan they are of.
fn next_group(
    model: &DetectorModel,
    repetition: u64,
    group: Group,
    last: Option<Group>,
) -> Option<(u64, Group)> {
    let next = Group(group.0 + 1);
    if let Some(last) = last {
        return (next < last).then_some((repetition, next));
    }
    if next.0 < model.timing.groups() {
        return Some((repetition, next));
    }
    model.timing.is_gapless().then_some((repetition + 1, Group(0)))
}

/// The samples of a detection's pulse in a group that starts at `start`.
#[inline]
fn sample(
    (detection, width_chips): (Detection, f64),
    model: &DetectorModel,
    start: Sample,
) -> Pulse {
    let samples_per_chip = model.timing.clock.samples_per_chip;
    let chip_start = start + Sampling::new(samples_per_chip).samples_of(detection.chip);
    let sample_at_or_after =
        |chips: f64| chip_start + model.sampler.first_from(chips * f64::from(samples_per_chip));
    Pulse {
        first: sample_at_or_after(detection.fraction),
        end: sample_at_or_after(detection.fraction + width_chips),
    }
}

/// The same of registered ticks, of which a sample is a power of two.
#[derive(Debug, Clone, Copy)]
struct TickSampler<'m> {
    sampler: &'m Sampler,
    /// Of the sampler; here, where a loop need not read it again.
    is_even: bool,
    sample_bits: u32,
    width_ticks: u64,
}

impl TickSampler<'_> {
    fn new(model: &DetectorModel) -> TickSampler<'_> {
        TickSampler {
            sampler: &model.sampler,
            is_even: model.sampler.is_even(),
            sample_bits: CHIP_BITS - model.timing.clock.samples_per_chip.ilog2(),
            width_ticks: (model.pulse_width_chips * f64::from(1_u32 << CHIP_BITS)).round() as u64,
        }
    }

    /// Whether no pulse lies between two samples.
    fn sees_all(self) -> bool {
        match self.is_even {
            true => self.width_ticks >> self.sample_bits > 0,
            false => self.samples(self.width_ticks) >= self.sampler.widest(),
        }
    }

    /// Ticks in sample periods, exact below 2^53 of them.
    #[inline]
    fn samples(self, ticks: u64) -> f64 {
        ticks as f64 / (1_u64 << self.sample_bits) as f64
    }

    /// The first sample at which a time in a group that starts at `start` is past.
    #[inline]
    fn at_or_after(self, ticks: u64, start: Sample) -> Sample {
        let within = (1 << self.sample_bits) - 1;
        match self.is_even {
            true => start + ((ticks + within) >> self.sample_bits),
            false => self.at_or_after_uneven(ticks, start),
        }
    }

    #[inline(never)]
    fn at_or_after_uneven(self, ticks: u64, start: Sample) -> Sample {
        start + self.sampler.first_from(self.samples(ticks))
    }

    #[inline]
    fn pulse(self, time: RegisteredTicks, start: Sample) -> Pulse {
        Pulse {
            first: self.at_or_after(time.0, start),
            end: self.at_or_after(time.0 + self.width_ticks, start),
        }
    }
}

/// Samples of a group of steps.
fn group_samples(model: &DetectorModel) -> u64 {
    let timing = &model.timing;
    timing.sampling().samples_of(timing.scan.integration_chips)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pulse_rises_only_after_a_low_sample() {
        let mut level = Level::default();
        let pulses = [(0, 4), (2, 3), (4, 6), (7, 9), (9, 10), (12, 13)];
        let rises = pulses
            .map(|(first, end)| level.rises(&Pulse { first: Sample(first), end: Sample(end) }));
        // The second is within the first, the third and the fifth touch the one before.
        assert_eq!(rises, [true, false, false, true, false, true]);
    }
}
