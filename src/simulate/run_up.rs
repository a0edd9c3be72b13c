//! Scans of one detector, and where a run has to begin for a scan to be what it is among all.

use std::ops::Range;

use crate::photons::DetectorModel;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Scans of one detector, by their numbers among all of a seed.
#[derive(Debug, Clone)]
pub(super) struct Wanted<'s> {
    pub sensor: &'s Sensor,
    pub detector: DetectorIndex,
    pub seed: u64,
    pub scans: Range<u64>,
}

impl Wanted<'_> {
    /// The detector.
    pub fn model(&self) -> DetectorModel {
        DetectorModel::new(self.sensor, self.detector)
    }

    /// Every detector of the sensor.
    pub fn models(&self) -> Vec<DetectorModel> {
        DetectorIndex::of(&self.sensor.scene().detectors)
            .map(|detector| DetectorModel::new(self.sensor, detector))
            .collect()
    }
}

/// The scan that a run has to begin with for scan `first` to be what it is in a run from
/// scan 0 on. Light and detections of a scan are its own; only pulses that are still high
/// reach into the next one.
pub(super) fn begun_by<'m>(
    detectors: impl IntoIterator<Item = &'m DetectorModel>,
    first: u64,
) -> u64 {
    let scans_of_a_pulse = |model: &DetectorModel| {
        let scan_chips = model.timing.scan_chips() as f64;
        (model.pulse_width_chips / scan_chips).ceil() as u64
    };
    let longest = detectors.into_iter().map(scans_of_a_pulse).max();
    // A pulse begins as the scan ends, and lasts for some more.
    first.saturating_sub(1 + longest.unwrap_or(0))
}
