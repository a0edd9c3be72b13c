//! Where a run has to begin for a scan to be what it is among all.

use crate::photons::DetectorModel;

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
