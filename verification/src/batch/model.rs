//! The reference model, clocked in batches, whose state stays between them.

use super::BatchError;
use super::edges::{LastCells, LastSample};
use crate::reference::exercise::Exercised;
use crate::reference::host_ports::HostInputs;
use crate::reference::predictor::{ReferenceModel, StepResult, Surroundings};
use crate::scan::Sample;
use crate::sensor::Sensor;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;
use crate::sensor::port::PortRole;

/// The inputs of a batch of clocks.
#[derive(Debug, Clone, Copy)]
pub struct BatchInputs<'a, W> {
    /// `i_samples`: a word for each detector, or for each of its cells if they have an input each,
    /// clock by clock; bit 0 is the earliest sample, and bits beyond a chip's samples are 0.
    pub samples: &'a [W],
    /// `i_rst` of each clock, high if it is not 0; empty if it is low at all of them.
    pub reset: &'a [u8],
    /// `m_axis_tready` of each clock; empty if it is high at all of them.
    pub ready: &'a [u8],
    /// What a host drives at each clock (`hardware.registers`); empty if it drives nothing.
    pub host: &'a [HostInputs],
}

/// The bit-exact model of a sensor's hardware. Until `i_rst` has been high at a clock,
/// its registers have no values: the model holds all outputs at 0 till then.
#[derive(Debug, Clone)]
pub struct Model {
    reference: ReferenceModel,
    layout: Layout,
    surroundings: Surroundings,
    /// For each detector, of the batch.
    hits: Vec<Vec<Sample>>,
    /// For each detector.
    last_samples: Vec<LastSample>,
    /// In place of these, if cells have an input each.
    last_cells: Vec<LastCells>,
    /// A word of samples without a pulse.
    rest: u64,
    /// The next clock.
    clock: u64,
    /// First clock of the reset that the batch before this one ended in.
    reset_since: Option<u64>,
    /// First clock at which `i_rst` was high.
    first_reset: Option<u64>,
}

impl Model {
    /// A model of this sensor's hardware before its first clock.
    ///
    /// # Errors
    /// When the hardware is not modelled.
    pub fn new(sensor: &Sensor) -> Result<Model, BatchError> {
        let interface = sensor.interface().clone();
        let detectors = interface.reference_codes.len();
        Ok(Model {
            layout: Layout::of(&interface),
            surroundings: Surroundings::default(),
            hits: vec![Vec::new(); detectors],
            last_samples: vec![LastSample::before_all(interface.lanes()); detectors],
            last_cells: match interface.input_cells.count {
                1 => Vec::new(),
                _ => vec![LastCells::before_all(&interface); detectors],
            },
            rest: interface.polarity.rest(interface.lanes()),
            clock: 0,
            reset_since: Some(0),
            first_reset: None,
            reference: ReferenceModel::new(interface)?,
        })
    }

    /// What it models.
    pub fn interface(&self) -> &Interface {
        self.reference.interface()
    }

    /// Where each output port lies in the records that [`Model::clock`] gives.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Clocks so far, which is the number of the next one.
    pub fn clocks(&self) -> u64 {
        self.clock
    }

    /// First clock at which `i_rst` was high, and from which on outputs mean something.
    pub fn first_reset(&self) -> Option<u64> {
        self.first_reset
    }

    /// Results of the phase steps that ended in the clocks so far, in order, whether or
    /// not the stream had room for them. Empties the list.
    pub fn take_results(&mut self) -> impl Iterator<Item = StepResult> {
        self.reference.take_finished()
    }

    /// What its outputs have shown.
    pub(crate) fn exercise(&self) -> &Exercised {
        self.reference.exercise()
    }

    /// Clocks it through a batch. `outputs` is overwritten with a record of
    /// `layout().outputs.words` words for each clock.
    ///
    /// # Errors
    /// When the inputs are not those of this sensor; nothing has changed then.
    pub fn clock<W: Copy + Into<u64>>(
        &mut self,
        inputs: &BatchInputs<W>,
        outputs: &mut Vec<u64>,
    ) -> Result<(), BatchError> {
        let clocks = self.check(inputs)?;
        outputs.resize(clocks * self.layout.outputs.words, 0);
        self.surroundings.clocks = self.clock..self.clock + clocks as u64;
        self.take_resets(inputs.reset);
        self.take_stalls(inputs.ready);
        self.take_host(inputs.host);
        self.take_samples(inputs.samples);
        self.clock = self.surroundings.clocks.end;
        self.reference.predict(&self.surroundings, &self.hits, outputs);
        Ok(())
    }

    /// Whether a batch would be taken, and its clocks.
    ///
    /// # Errors
    /// When the inputs are not those of this sensor.
    pub fn check<W: Copy + Into<u64>>(&self, inputs: &BatchInputs<W>) -> Result<usize, BatchError> {
        let words = self.interface().inputs();
        if !inputs.samples.len().is_multiple_of(words) {
            return Err(BatchError::PartOfAClock { found: inputs.samples.len(), words });
        }
        let clocks = inputs.samples.len() / words;
        if !inputs.host.is_empty() && self.interface().registers.is_none() {
            return Err(BatchError::NoRegisters);
        }
        let lengths = [
            (PortRole::Reset.name(), inputs.reset.len()),
            (PortRole::Ready.name(), inputs.ready.len()),
            ("the host", inputs.host.len()),
        ];
        for (input, found) in lengths {
            if found != 0 && found != clocks {
                return Err(BatchError::Lengths { input, found, clocks });
            }
        }
        let samples = self.interface().lanes();
        let is_too_wide = |word: &W| (*word).into() >> samples != 0;
        match inputs.samples.iter().position(is_too_wide) {
            None => Ok(clocks),
            Some(at) => Err(BatchError::WordTooWide {
                clock: self.clock + (at / words) as u64,
                input: at % words,
                word: inputs.samples[at].into(),
                samples,
            }),
        }
    }

    fn take_resets(&mut self, reset: &[u8]) {
        let clocks = self.surroundings.clocks.clone();
        let resets = &mut self.surroundings.resets;
        resets.clear();
        let first_high = reset.iter().position(|&level| level != 0);
        if let (None, Some(at)) = (self.first_reset, first_high) {
            self.first_reset = Some(clocks.start + at as u64);
        }
        // Before the first reset it is as if there were one.
        let held = match self.first_reset {
            Some(first) => first.clamp(clocks.start, clocks.end) - clocks.start,
            None => clocks.end - clocks.start,
        };
        let level = |at: usize| (at as u64) < held || reset.get(at).is_some_and(|&r| r != 0);
        for (at, clock) in clocks.clone().enumerate() {
            match (level(at), self.reset_since) {
                (true, None) => self.reset_since = Some(clock),
                (false, Some(since)) => {
                    self.reset_since = None;
                    if since < clock {
                        resets.push(since..clock);
                    }
                }
                _ => {}
            }
        }
        if let Some(since) = self.reset_since.filter(|&since| since < clocks.end) {
            resets.push(since..clocks.end);
        }
    }

    fn take_stalls(&mut self, ready: &[u8]) {
        let first = self.surroundings.clocks.start;
        let stalls = &mut self.surroundings.stalls;
        stalls.clear();
        for (clock, _) in (first..).zip(ready).filter(|&(_, &ready)| ready == 0) {
            match stalls.last_mut() {
                Some(stall) if stall.end == clock => stall.end += 1,
                _ => stalls.push(clock..clock + 1),
            }
        }
    }

    fn take_host(&mut self, driven: &[HostInputs]) {
        let first = self.surroundings.clocks.start;
        let host = &mut self.surroundings.host;
        host.clear();
        for (clock, &inputs) in (first..).zip(driven) {
            match host.last_mut() {
                Some((clocks, last)) if clocks.end == clock && *last == inputs => clocks.end += 1,
                _ if inputs == HostInputs::default() => {}
                _ => host.push((clock..clock + 1, inputs)),
            }
        }
    }

    fn take_samples<W: Copy + Into<u64>>(&mut self, samples: &[W]) {
        self.hits.iter_mut().for_each(Vec::clear);
        let first = self.surroundings.clocks.start;
        let detectors = self.last_samples.len();
        let rest = self.rest;
        if !self.last_cells.is_empty() {
            let cells = self.interface().input_cells.count as usize;
            let changes = &mut self.surroundings.cells;
            changes.resize(detectors, Vec::new());
            changes.iter_mut().for_each(Vec::clear);
            for (clock, words) in (first..).zip(samples.chunks_exact(detectors * cells)) {
                let told = changes.iter_mut().zip(&mut self.hits);
                let of_detectors = words.chunks_exact(cells).zip(&mut self.last_cells).zip(told);
                for ((words, last), (changes, hits)) in of_detectors {
                    let words = words.iter().map(|&word| word.into() ^ rest);
                    last.changes(clock, words, changes, hits);
                }
            }
            return;
        }
        if let ([last], [hits]) = (&mut self.last_samples[..], &mut self.hits[..]) {
            for (clock, &word) in (first..).zip(samples) {
                last.hits(clock, word.into() ^ rest, hits);
            }
            return;
        }
        for (clock, words) in (first..).zip(samples.chunks_exact(detectors)) {
            let detectors = self.last_samples.iter_mut().zip(&mut self.hits);
            for (&word, (last, hits)) in words.iter().zip(detectors) {
                last.hits(clock, word.into() ^ rest, hits);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::{self, Polarity};

    #[test]
    fn samples_that_are_low_during_a_pulse_count_as_their_opposites() {
        let scene = scene::load(Path::new("../scenes/quick.toml")).unwrap();
        let high = Sensor::new(&scene);
        let low = high.with(|scene| scene.hardware.polarity = Polarity::Low);
        let words = |n: u64| (n.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 24) as u8;
        let samples: Vec<u8> = (0..6000).map(words).collect();
        let opposites: Vec<u8> = samples.iter().map(|word| !word).collect();
        let run = |sensor: &Sensor, samples: &[u8]| {
            let mut model = Model::new(sensor).unwrap();
            let mut reset = vec![0; samples.len()];
            reset[..2].fill(1);
            let mut outputs = Vec::new();
            model
                .clock(&BatchInputs { samples, reset: &reset, ready: &[], host: &[] }, &mut outputs)
                .unwrap();
            (outputs, model.take_results().map(|result| result.total).collect::<Vec<_>>())
        };
        let (outputs, totals) = run(&high, &samples);
        assert!(totals.len() > 1 && totals[0] > 1000, "{totals:?}");
        assert_eq!(run(&low, &opposites), (outputs, totals));
    }

    /// Two of four cells: the same as one SPAD whose samples are high where those of two or more are.
    #[test]
    fn cells_with_an_input_each_count_as_the_level_that_they_make() {
        let scene = scene::load(Path::new("../scenes/macropixel.toml")).unwrap();
        let pixel = Sensor::new(&scene);
        let single = pixel.with(|scene| {
            let spad = &mut scene.detectors[0];
            (spad.cells, spad.coincidence) = (1, 1);
            spad.cell_outputs = scene::CellOutputs::Combined;
        });
        let words = |n: u64| (n.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 31) as u8 & 0xf;
        let samples: Vec<u8> = (0..24_000).map(words).collect();
        let two_or_more = |cells: &[u8]| {
            let high = |sample: u32| cells.iter().filter(|&word| word >> sample & 1 == 1).count();
            (0..4).fold(0, |word, sample| word | u8::from(high(sample) >= 2) << sample)
        };
        let levels: Vec<u8> = samples.chunks(4).map(two_or_more).collect();
        let run = |sensor: &Sensor, samples: &[u8]| {
            let mut model = Model::new(sensor).unwrap();
            let mut reset = vec![0; 6_000];
            reset[..2].fill(1);
            let mut outputs = Vec::new();
            model
                .clock(&BatchInputs { samples, reset: &reset, ready: &[], host: &[] }, &mut outputs)
                .unwrap();
            (outputs, model.take_results().map(|result| result.total).collect::<Vec<_>>())
        };
        let (outputs, totals) = run(&pixel, &samples);
        assert!(totals.len() > 1 && totals[0] > 1000, "{totals:?}");
        assert_eq!(run(&single, &levels), (outputs, totals));
    }

    #[test]
    fn a_batch_that_is_refused_changes_nothing() {
        let scene = scene::load(Path::new("../scenes/quick.toml")).unwrap();
        let mut model = Model::new(&Sensor::new(&scene)).unwrap();
        let mut outputs = Vec::new();
        let mut clock = |samples: &[u16], reset: &[u8]| {
            let inputs = BatchInputs { samples, reset, ready: &[], host: &[] };
            let told = model.clock(&inputs, &mut outputs);
            (told.map_err(|error| error.to_string()), model.clocks())
        };
        let (told, clocks) = clock(&[0, 0x1ff], &[]);
        assert!(told.unwrap_err().contains("clock 1: the sample word"));
        assert_eq!(clocks, 0);
        let (told, clocks) = clock(&[0, 1], &[1]);
        assert_eq!(told.unwrap_err(), "i_rst has 1 clocks, and i_samples has 2");
        assert_eq!(clocks, 0);
        assert_eq!(clock(&[0, 1], &[1, 1]), (Ok(()), 2));
    }
}
