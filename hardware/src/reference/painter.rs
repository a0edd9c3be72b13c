//! Input records from what drives the inputs.

use std::ops::Range;

use super::levels::Levels;
use super::predictor::Surroundings;
use crate::photons::Pulse;
use crate::scan::Sample;
use crate::scene::Polarity;
use crate::sensor::cells::CellChange;
use crate::sensor::interface::Interface;
use crate::sensor::layout::{Field, Record};
use crate::sensor::port::{PortRole, Use};

/// Paints input records: of some clocks, as many as there are words for.
#[derive(Debug, Clone)]
pub(super) struct InputPainter {
    record: Record,
    lanes: u32,
    polarity: Polarity,
}

impl InputPainter {
    /// Of records that are laid out like this.
    pub(super) fn new(record: &Record, interface: &Interface) -> InputPainter {
        InputPainter {
            record: record.clone(),
            lanes: interface.lanes(),
            polarity: interface.polarity,
        }
    }

    /// Paints the detectors' samples over records of zeros; what the levels do besides, as
    /// [`Levels::paint`] says.
    pub(super) fn samples(
        &self,
        levels: &mut Levels,
        (clocks, pulses): (Range<u64>, &[Vec<Pulse>]),
        inputs: &mut [u64],
        hits: &mut [Vec<Sample>],
        changes: &mut Vec<Vec<CellChange>>,
    ) {
        let words = self.record.words;
        let field = self.record.field(PortRole::Samples);
        let paint = |input: usize, clock: usize, bits: u64| {
            // S divides 64, so an input's samples never cross words.
            let bit = field.shift + input as u32 * self.lanes;
            inputs[clock * words + field.word + (bit / 64) as usize] |= bits << (bit % 64);
        };
        levels.paint(clocks, pulses, paint, hits, changes);
        if self.polarity == Polarity::Low {
            for (word, bits) in field.words() {
                inputs.chunks_exact_mut(words).for_each(|record| record[word] ^= bits);
            }
        }
    }

    /// Paints the levels that rest but where the surroundings say otherwise, and what a host drives.
    pub(super) fn surroundings(&self, surroundings: &Surroundings, inputs: &mut [u64]) {
        for field in &self.record.fields {
            match field.port.role.usage() {
                Use::Level { rest } => self.level(field, rest, surroundings, inputs),
                Use::Host => self.host(field, surroundings, inputs),
                _ => {}
            }
        }
    }

    fn level(&self, field: &Field, rest: bool, surroundings: &Surroundings, inputs: &mut [u64]) {
        let words = self.record.words;
        let clocks = &surroundings.clocks;
        let at = |clock: u64| (clock.clamp(clocks.start, clocks.end) - clocks.start) as usize;
        let mut paint = |clocks: Range<usize>, level: bool| {
            for (word, bits) in field.words() {
                let records =
                    inputs[clocks.start * words..clocks.end * words].chunks_exact_mut(words);
                for record in records {
                    record[word] = if level { record[word] | bits } else { record[word] & !bits };
                }
            }
        };
        if rest {
            paint(0..at(clocks.end), rest);
        }
        for other in surroundings.away_from_rest(field.port.role) {
            paint(at(other.start)..at(other.end), !rest);
        }
    }

    fn host(&self, field: &Field, surroundings: &Surroundings, inputs: &mut [u64]) {
        let words = self.record.words;
        let clocks = &surroundings.clocks;
        for (range, host) in &surroundings.host {
            let value = host.of(field.port.role) << field.shift;
            for clock in range.start.max(clocks.start)..range.end.min(clocks.end) {
                inputs[(clock - clocks.start) as usize * words + field.word] |= value;
            }
        }
    }
}
