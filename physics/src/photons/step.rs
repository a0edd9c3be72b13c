//! One phase step, photon by photon.

use rand_distr::{Distribution, StandardNormal};

use super::avalanches::Avalanches;
use super::crosstalk::Others;
use super::detector::{DetectorModel, JITTER_BOUND_SIGMAS};
use super::pixel::PixelPulses;
use super::random::{Part, StreamKey, StreamRng};
use super::reorder::ReorderBuffer;
use super::time::ChipTime;
use crate::scan::Group;

/// The registered time of a detection, relative to the start of its step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Whole chips.
    pub chip: u64,
    /// Offset inside the chip, 0 <= fraction < 1.
    pub fraction: f64,
}

/// The detections of one group of phase steps in order of registered time, of all light that arrives
/// (eq. 9: every path's and the background's).
#[derive(Debug, Clone)]
pub struct StepDetections<'m> {
    detector: Avalanches<'m>,
    /// Those whose crosstalk it hears.
    others: Option<Box<Others<'m>>>,
    registration: Registration<'m>,
    registered: ReorderBuffer,
    /// No time that is still to be registered comes before it.
    horizon: ChipTime,
    end: ChipTime,
}

impl DetectorModel {
    /// Simulates the light of a group of steps of scan number `repetition`. The result
    /// depends on the arguments alone.
    pub fn step(&self, seed: u64, repetition: u64, group: Group) -> GroupDetections<'_> {
        let key = self.key(seed, repetition, group);
        match &self.pixel {
            None => GroupDetections::OfSpad(self, Box::new(StepDetections::new(self, key))),
            Some(pixel) => GroupDetections::OfPixel(Box::new(PixelPulses::new(self, pixel, key))),
        }
    }
}

/// What one group of phase steps counts, in order: detections of a SPAD, or rising edges of the level
/// that a pixel's cells make.
#[derive(Debug, Clone)]
pub enum GroupDetections<'m> {
    /// Of a detector that is a single SPAD.
    OfSpad(&'m DetectorModel, Box<StepDetections<'m>>),
    /// Of a detector with several cells.
    OfPixel(Box<PixelPulses<'m>>),
}

impl GroupDetections<'_> {
    /// The next one, and for how many chips its pulse is high.
    #[inline]
    pub fn next_pulse(&mut self) -> Option<(Detection, f64)> {
        match self {
            GroupDetections::OfSpad(model, detections) => {
                detections.next().map(|detection| (detection, model.pulse_width_chips))
            }
            GroupDetections::OfPixel(pulses) => pulses.next(),
        }
    }
}

impl Iterator for GroupDetections<'_> {
    type Item = Detection;

    #[inline]
    fn next(&mut self) -> Option<Detection> {
        self.next_pulse().map(|(detection, _)| detection)
    }
}

/// Delay and jitter from the avalanche to its registered time.
#[derive(Debug, Clone)]
pub struct Registration<'m> {
    model: &'m DetectorModel,
    jitter: Option<StreamRng>,
    tail: Option<StreamRng>,
}

impl<'m> Registration<'m> {
    pub fn new(model: &'m DetectorModel, key: &StreamKey) -> Registration<'m> {
        Registration {
            model,
            jitter: model.jitter_chips.map(|_| key.stream(Part::Jitter)),
            tail: model.tail.as_ref().map(|_| key.stream(Part::Tail)),
        }
    }

    /// The registered time of an avalanche.
    #[inline]
    pub fn register(&mut self, avalanche: ChipTime) -> ChipTime {
        let mut shift = self.model.delay_chips;
        if let (Some(rng), Some(sigma)) = (&mut self.jitter, self.model.jitter_chips) {
            let normal: f64 = StandardNormal.sample(rng);
            shift += sigma * normal.clamp(-JITTER_BOUND_SIGMAS, JITTER_BOUND_SIGMAS);
        }
        if let (Some(rng), Some(tail)) = (&mut self.tail, &self.model.tail) {
            shift += tail.draw(rng);
        }
        avalanche.shifted(shift)
    }
}

impl<'m> StepDetections<'m> {
    pub(crate) fn new(model: &'m DetectorModel, key: StreamKey) -> StepDetections<'m> {
        let mut detector = Avalanches::new(model, &key, model.warm_up_chips);
        let others = model.crosstalk.as_deref().map(|coupled| {
            detector.listen();
            Box::new(Others::new(coupled, model, key))
        });
        StepDetections {
            detector,
            others,
            registration: Registration::new(model, &key),
            registered: ReorderBuffer::default(),
            horizon: Avalanches::start(model, &key, model.warm_up_chips),
            end: ChipTime::at_chip(
                i64::try_from(model.timing.scan.integration_chips).unwrap_or(i64::MAX),
            ),
        }
    }

    /// The next avalanche; what is registered from then on comes after its dead time.
    #[inline]
    fn fire(&mut self) -> ChipTime {
        if let Some(others) = &mut self.others {
            // What comes too late to be heard within the step need not be known.
            while let Some((time, place)) = others.first_before(self.detector.next_arrival())
                && self.detector.registered_from(time) < self.end
            {
                others.fire(place, &mut self.detector);
            }
        }
        let (avalanche, ready) = self.detector.fire(self.end);
        if let Some(others) = &mut self.others {
            others.caused_by_own(avalanche, &mut self.detector);
        }
        self.horizon = self.detector.registered_from(ready);
        avalanche
    }
}

impl Iterator for StepDetections<'_> {
    type Item = Detection;

    #[inline]
    fn next(&mut self) -> Option<Detection> {
        loop {
            while let Some((time, ())) = self.registered.pop_before(self.horizon) {
                if time >= self.end {
                    // Nothing that follows is earlier.
                    self.horizon = self.end;
                    return None;
                }
                if let Ok(chip) = u64::try_from(time.chip) {
                    return Some(Detection { chip, fraction: time.fraction });
                }
            }
            if self.horizon >= self.end {
                return None;
            }
            let avalanche = self.fire();
            let time = self.registration.register(avalanche);
            self.registered.insert(time, ());
        }
    }
}
