//! Photons as stimulus: simulated detections, a consumer that always takes.

use super::stimulus::{Drive, RESET_CLOCKS, Stimulus, first_sample, scan_start};
use crate::photons::{DetectorModel, PulseStream};
use crate::sensor::contract::Contract;

/// The sampled pulses of every detector, scan after scan.
pub struct Photons<'a> {
    models: &'a [DetectorModel],
    contract: &'a Contract,
    seed: u64,
    scan: u64,
    streams: Vec<PulseStream<'a>>,
}

impl<'a> Photons<'a> {
    /// Streams for the scene's detectors, in their order. The n-th scan is the
    /// n-th repetition of the seed.
    pub fn new(models: &'a [DetectorModel], contract: &'a Contract, seed: u64) -> Photons<'a> {
        let mut photons = Photons {
            models,
            contract,
            seed,
            scan: 0,
            streams: Vec::new(),
        };
        photons.start_scan();
        photons
    }

    fn start_scan(&mut self) {
        let stream = |model| PulseStream::new(model, self.seed, self.scan);
        self.streams = self.models.iter().map(stream).collect();
    }
}

impl Stimulus for Photons<'_> {
    fn drive(&mut self, drive: &mut Drive) {
        let clocks = drive.surroundings.clocks.clone();
        if clocks.start < RESET_CLOCKS {
            drive.surroundings.resets.push(0..RESET_CLOCKS);
        }
        let lanes = u64::from(self.contract.lanes());
        let until = clocks.end * lanes;
        let origin = first_sample(self.contract, RESET_CLOCKS);
        loop {
            // A full scan's stream runs on into the next scan by itself.
            let start = origin + scan_start(self.contract, self.scan) * lanes;
            if until > start {
                for (stream, pulses) in self.streams.iter_mut().zip(&mut drive.pulses) {
                    let from = pulses.len();
                    stream.advance(until - start, pulses);
                    for pulse in &mut pulses[from..] {
                        pulse.first += start;
                        pulse.end += start;
                    }
                }
            }
            let next = origin + scan_start(self.contract, self.scan + 1) * lanes;
            if !self.contract.realigns() || next >= until {
                return;
            }
            self.scan += 1;
            self.start_scan();
        }
    }
}
