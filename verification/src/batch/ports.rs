//! One port's values out of the records of many clocks.

use std::ops::Range;

use crate::sensor::layout::{Field, mask};

/// Where the values of a port go, one for each clock.
#[derive(Debug)]
pub enum PortValues<'a> {
    /// Of a port of up to 8 bits.
    U8(&'a mut [u8]),
    /// Of up to 16.
    U16(&'a mut [u16]),
    /// Of up to 32.
    U32(&'a mut [u32]),
    /// Of up to 64; and of a wider one, as many words for each clock as it has, the
    /// lowest first.
    U64(&'a mut [u64]),
}

impl PortValues<'_> {
    /// Copies the port that lies at `field` out of `records` of `words` words each, to the
    /// places from clock `first` on.
    ///
    /// # Panics
    /// When there is not a place for every clock, or places are too narrow: a mistake of
    /// the caller.
    pub fn copy(&mut self, records: &[u64], words: usize, field: &Field, first: usize) {
        let clocks = first..first + records.len() / words;
        let width = field.port.width;
        match (self, words) {
            (PortValues::U64(to), _) if width > 64 => {
                let of_port = width.div_ceil(64) as usize;
                let to = &mut to[clocks.start * of_port..clocks.end * of_port];
                let records = records.chunks_exact(words);
                for (to, record) in to.chunks_exact_mut(of_port).zip(records) {
                    to.copy_from_slice(&record[field.word..field.word + of_port]);
                }
            }
            // Most sensors' ports fit one word: a plain loop, for vectors of them.
            (to, 1) => {
                let (shift, mask) = (field.shift, mask(width));
                to.fill(clocks, field, records.iter().map(|r| r >> shift & mask));
            }
            (to, _) => {
                let records = records.chunks_exact(words);
                to.fill(clocks, field, records.map(|r| field.low_word(r)));
            }
        }
    }

    fn fill(&mut self, clocks: Range<usize>, field: &Field, values: impl Iterator<Item = u64>) {
        let width = field.port.width;
        match self {
            PortValues::U8(to) if width <= 8 => fill(&mut to[clocks], values, |v| v as u8),
            PortValues::U16(to) if width <= 16 => fill(&mut to[clocks], values, |v| v as u16),
            PortValues::U32(to) if width <= 32 => fill(&mut to[clocks], values, |v| v as u32),
            PortValues::U64(to) if width <= 64 => fill(&mut to[clocks], values, |v| v),
            _ => panic!("{} has {width} bits", field.port.name),
        }
    }
}

fn fill<T>(to: &mut [T], values: impl Iterator<Item = u64>, narrow: impl Fn(u64) -> T) {
    for (to, value) in to.iter_mut().zip(values) {
        *to = narrow(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::port::PortRole;

    fn field(width: u32, word: usize, shift: u32) -> Field {
        Field { port: PortRole::Data.port(width), word, shift }
    }

    #[test]
    fn values_come_from_their_bits() {
        let records = [0xabcd_ef01, 1, 0x1234_5678, 2];
        let mut bytes = [0; 3];
        PortValues::U8(&mut bytes).copy(&records, 2, &field(8, 0, 8), 1);
        assert_eq!(bytes, [0, 0xef, 0x56]);
        let mut twelve = [0; 2];
        PortValues::U16(&mut twelve).copy(&records, 2, &field(12, 0, 4), 0);
        assert_eq!(twelve, [0xef0, 0x567]);
        let mut of_one_word = [0; 5];
        PortValues::U8(&mut of_one_word).copy(&records, 1, &field(7, 0, 9), 1);
        assert_eq!(of_one_word, [0, 0x77, 0, 0x2b, 0]);
        let mut words = [0; 4];
        PortValues::U64(&mut words).copy(&records, 2, &field(70, 0, 0), 0);
        assert_eq!(words, records);
    }
}
