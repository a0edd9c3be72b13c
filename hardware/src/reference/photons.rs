//! Photons as stimulus: simulated detections, or recorded ones, and a consumer that always takes.

use std::sync::Arc;

use super::stimulus::{Drive, RESET_CLOCKS, Stimulus, first_sample, scan_start};
use crate::photons::fast::Recorder;
use crate::photons::{DetectorModel, Pulse, PulseStream};
use crate::scan::{Group, Sample, Sampling};
use crate::sensor::interface::Interface;

/// The sampled pulses of every input, scan after scan.
pub struct Photons<'a> {
    recorders: Vec<Arc<Recorder<'a>>>,
    interface: &'a Interface,
    seed: u64,
    /// The repetition of the seed that the first scan is.
    first: u64,
    scan: u64,
    streams: Vec<PulseStream<'a>>,
}

impl<'a> Photons<'a> {
    /// Streams of the scene's detectors, in their order. The n-th scan is the
    /// n-th repetition of the seed.
    pub fn new(models: &'a [DetectorModel], interface: &'a Interface, seed: u64) -> Photons<'a> {
        Photons::from_scan(models, interface, seed, 0)
    }

    /// The same from repetition `first` of the seed on: it is the run's first scan.
    pub fn from_scan(
        models: &'a [DetectorModel],
        interface: &'a Interface,
        seed: u64,
        first: u64,
    ) -> Photons<'a> {
        let recorders = models.iter().map(|model| Arc::new(Recorder::new(model))).collect();
        let mut photons =
            Photons { recorders, interface, seed, first, scan: 0, streams: Vec::new() };
        photons.start_scan();
        photons
    }

    fn start_scan(&mut self) {
        let repetition = self.first + self.scan;
        let stream = |of| PulseStream::of_groups(of, self.seed, repetition, Group(0), None);
        self.streams = self.recorders.iter().map(stream).collect();
    }
}

impl Stimulus for Photons<'_> {
    fn drive(&mut self, drive: &mut Drive) {
        let clocks = drive.surroundings.clocks.clone();
        if clocks.start < RESET_CLOCKS {
            drive.surroundings.resets.push(0..RESET_CLOCKS);
        }
        let sampling = self.interface.timing.sampling();
        let until = sampling.first_sample(clocks.end);
        let origin = first_sample(self.interface, RESET_CLOCKS);
        let start_of = |scan| origin + sampling.samples_of(scan_start(self.interface, scan));
        loop {
            // A full scan's stream runs on into the next scan by itself.
            let start = start_of(self.scan);
            if until > start {
                let inputs = drive.pulses.chunks_mut(self.interface.input_cells.count as usize);
                for (stream, inputs) in self.streams.iter_mut().zip(inputs) {
                    let known: Vec<usize> = inputs.iter().map(Vec::len).collect();
                    stream.advance_inputs(Sample(until - start), inputs);
                    for (pulses, known) in inputs.iter_mut().zip(known) {
                        pulses[known..].iter_mut().for_each(|pulse| pulse.shift(start));
                    }
                }
            }
            if !self.interface.realigns() || start_of(self.scan + 1) >= until {
                return;
            }
            self.scan += 1;
            self.start_scan();
        }
    }
}

/// Pulses that were recorded, in place of simulated ones: those of one scan.
pub struct RecordedPulses {
    /// Input by input, from the first scan's first sample on.
    pulses: Arc<Vec<Vec<Pulse>>>,
    next: Vec<usize>,
    origin: Sample,
    sampling: Sampling,
}

impl RecordedPulses {
    /// For a sensor with this interface.
    pub fn new(pulses: Arc<Vec<Vec<Pulse>>>, interface: &Interface) -> RecordedPulses {
        RecordedPulses {
            next: vec![0; pulses.len()],
            pulses,
            origin: first_sample(interface, RESET_CLOCKS),
            sampling: interface.timing.sampling(),
        }
    }
}

impl Stimulus for RecordedPulses {
    fn drive(&mut self, drive: &mut Drive) {
        let clocks = drive.surroundings.clocks.clone();
        if clocks.start < RESET_CLOCKS {
            drive.surroundings.resets.push(0..RESET_CLOCKS);
        }
        let until = self.sampling.first_sample(clocks.end);
        let of_detectors = self.pulses.iter().zip(&mut self.next).zip(&mut drive.pulses);
        for ((recorded, next), pulses) in of_detectors {
            while let Some(pulse) = recorded.get(*next).filter(|p| p.first + self.origin.0 < until)
            {
                let mut pulse = *pulse;
                pulse.shift(self.origin);
                pulses.push(pulse);
                *next += 1;
            }
        }
    }
}
