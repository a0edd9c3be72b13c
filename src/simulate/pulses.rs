//! The sampled pulses of simulated photons, for what takes them instead of the program: a simulated
//! board (docs/bench.md).

use std::io::{self, Write};

use serde::Serialize;

use crate::photons::{DetectorModel, Pulse};
use crate::reference::photons::Photons;
use crate::reference::stimulus::{
    Drive, RESET_CLOCKS, Stimulus as _, clocks_for_scans, scan_start,
};
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Clocks of a block.
const BLOCK_CLOCKS: u64 = 1 << 16;

/// Pulses that were written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct PulsesReport {
    /// Scans, each with light of its own.
    pub scans: u64,
    /// Samples from the first one behind reset to the end of the last scan.
    pub samples: u64,
    /// Pulses of each input, in the order of detectors in the scene and of their cells.
    pub pulses: Vec<u64>,
}

/// Writes the pulses of so many scans, which `cosim` and `run` with this seed take, too: for each
/// its first sample, from that of the first word behind reset on (8 bytes), its samples (4 bytes) and its
/// input (4 bytes; a detector, or a cell of it that has one), little-endian, in the order of their first samples.
///
/// # Errors
/// When `out` takes no more.
pub fn pulses(
    sensor: &Sensor,
    seed: u64,
    scans: u64,
    out: &mut dyn Write,
) -> io::Result<PulsesReport> {
    let interface = sensor.interface();
    let models: Vec<DetectorModel> = DetectorIndex::of(&sensor.scene().detectors)
        .map(|detector| DetectorModel::new(sensor, detector))
        .collect();
    let mut photons = Photons::new(&models, interface, seed);
    let mut drive = Drive::of(interface);
    // Of a design with registers the first scan begins later, and so do the pulses.
    let origin = sensor.timing().sampling().first_sample(RESET_CLOCKS + 1).0;
    let until_lit = sensor.timing().sampling().samples_of(interface.start_clocks());
    let mut report = PulsesReport {
        scans,
        samples: until_lit + sensor.timing().sampling().samples_of(scan_start(interface, scans)),
        pulses: vec![0; interface.inputs()],
    };
    let last_clock = clocks_for_scans(interface, scans);
    let mut clock = 0;
    while clock < last_clock {
        let until = (clock + BLOCK_CLOCKS).min(last_clock);
        drive.start(clock..until);
        photons.drive(&mut drive);
        let mut block: Vec<(Pulse, u32)> = Vec::new();
        for (detector, pulses) in (0..).zip(&drive.pulses) {
            block.extend(pulses.iter().map(|pulse| (*pulse, detector)));
            report.pulses[detector as usize] += pulses.len() as u64;
        }
        block.sort_by_key(|(pulse, detector)| (pulse.first, *detector));
        for (pulse, detector) in block {
            let samples = (pulse.end.0 - pulse.first.0) as u32;
            out.write_all(&(pulse.first.0 - origin).to_le_bytes())?;
            out.write_all(&samples.to_le_bytes())?;
            out.write_all(&detector.to_le_bytes())?;
        }
        clock = until;
    }
    Ok(report)
}
