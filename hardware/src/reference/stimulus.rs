//! What drives both sides of a co-simulation.

use std::ops::Range;

use crate::photons::Pulse;
use crate::reference::predictor::Surroundings;
use crate::scan::Sample;
use crate::sensor::interface::Interface;

/// Clocks of reset at the start of every run.
pub const RESET_CLOCKS: u64 = 4;

/// The inputs of a block of clocks.
#[derive(Debug, Clone, Default)]
pub struct Drive {
    /// Reset and the result consumer.
    pub surroundings: Surroundings,
    /// For each input the pulses whose first sample lies in the block, in order.
    pub pulses: Vec<Vec<Pulse>>,
}

impl Drive {
    /// For a sensor with this interface.
    pub fn of(interface: &Interface) -> Drive {
        Drive { pulses: vec![Vec::new(); interface.inputs()], ..Drive::default() }
    }

    /// Empties it for the next block, keeping its memory.
    pub fn start(&mut self, clocks: Range<u64>) {
        self.surroundings.clocks = clocks;
        self.surroundings.resets.clear();
        self.surroundings.stalls.clear();
        self.surroundings.skips.clear();
        self.surroundings.host.clear();
        self.surroundings.cells.clear();
        self.pulses.iter_mut().for_each(Vec::clear);
    }
}

/// A source of inputs, asked for blocks that follow one another.
pub trait Stimulus {
    /// Fills in the inputs of the block that `drive` was started with; ends the block earlier where the
    /// run is over.
    fn drive(&mut self, drive: &mut Drive);
}

/// First sample of cycle 0 when reset ends at clock `released`: the word of a
/// cycle is presented one clock after its chip shows on `o_laser`.
pub fn first_sample(interface: &Interface, released: u64) -> Sample {
    interface.timing.sampling().first_sample(released + interface.start_clocks() + 1)
}

/// First cycle of the `scan`-th scan after reset.
pub fn scan_start(interface: &Interface, scan: u64) -> u64 {
    let pitch = interface.timing.scan_pitch_chips();
    let start = u128::from(scan).saturating_mul(pitch);
    let prepared = start.saturating_add(interface.timing.preparation_chips.into());
    u64::try_from(prepared).unwrap_or(u64::MAX)
}

/// Clocks from the start of the run until the last result of the first `scans`
/// scans has been on the stream for a clock, and their peaks at their ports.
pub fn clocks_for_scans(interface: &Interface, scans: u64) -> u64 {
    let last_word = scan_start(interface, scans - 1)
        .saturating_add(interface.scan_clocks())
        .saturating_add(RESET_CLOCKS + interface.start_clocks());
    let beats = interface.beats_of_group();
    let stream = u64::from(interface.result_latency_clocks) + beats;
    let peak = interface.peak_latency_clocks();
    last_word.saturating_add(stream.max(u64::from(peak)) + 1)
}
