//! One phase step, photon by photon.

use super::avalanches::Avalanches;
use super::crosstalk::Others;
use super::detector::DetectorModel;
use super::pixel::PixelPulses;
use super::random::StreamKey;
use super::registration::{Detection, Registration};
use super::reorder::ReorderBuffer;
use super::time::ChipTime;
use crate::scan::Group;

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
    /// The next pulse at any of the detector's inputs, for how many chips it is high, and at which of them.
    #[inline]
    pub fn next_pulse(&mut self) -> Option<(Detection, f64, usize)> {
        match self {
            GroupDetections::OfSpad(model, detections) => {
                detections.next().map(|detection| (detection, model.pulse_width_chips, 0))
            }
            GroupDetections::OfPixel(pulses) => pulses.next_at_input(),
        }
    }
}

impl Iterator for GroupDetections<'_> {
    type Item = Detection;

    #[inline]
    fn next(&mut self) -> Option<Detection> {
        match self {
            GroupDetections::OfSpad(_, detections) => detections.next(),
            GroupDetections::OfPixel(pulses) => pulses.next().map(|(detection, _)| detection),
        }
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
