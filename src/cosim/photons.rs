//! Photons as stimulus: simulated detections, a consumer that always takes.

use super::stimulus::{Drive, RESET_CLOCKS, Stimulus, first_sample, scan_start};
use crate::model::contract::Contract;
use crate::optics::{DetectorModel, PulseStream};

/// The sampled pulses of a detector, scan after scan.
pub struct Photons<'a> {
    model: &'a DetectorModel,
    contract: &'a Contract,
    seed: u64,
    scan: u64,
    stream: PulseStream<'a>,
}

impl<'a> Photons<'a> {
    /// Streams for a detector. The n-th scan is the n-th repetition of the seed.
    pub fn new(model: &'a DetectorModel, contract: &'a Contract, seed: u64) -> Photons<'a> {
        Photons {
            model,
            contract,
            seed,
            scan: 0,
            stream: PulseStream::new(model, seed, 0),
        }
    }
}

impl Stimulus for Photons<'_> {
    fn drive(&mut self, drive: &mut Drive) {
        let clocks = drive.surroundings.clocks.clone();
        if clocks.start < RESET_CLOCKS {
            drive.surroundings.resets.push(0..RESET_CLOCKS);
        }
        let lanes = u64::from(self.contract.lanes);
        let until = clocks.end * lanes;
        let origin = first_sample(self.contract, RESET_CLOCKS);
        loop {
            // A full scan's stream runs on into the next scan by itself.
            let start = origin + scan_start(self.contract, self.scan) * lanes;
            let from = drive.pulses.len();
            if until > start {
                self.stream.advance(until - start, &mut drive.pulses);
            }
            for pulse in &mut drive.pulses[from..] {
                pulse.first += start;
                pulse.end += start;
            }
            let next = origin + scan_start(self.contract, self.scan + 1) * lanes;
            if !self.contract.realigns() || next >= until {
                return;
            }
            self.scan += 1;
            self.stream = PulseStream::new(self.model, self.seed, self.scan);
        }
    }
}
