//! Where each port lies in the words that cross between Rust and the model.
//!
//! One clock's inputs, and one clock's outputs, are a record of 64-bit words.
//! Ports follow one another in the interface's order from bit 0 of word 0; one
//! that does not fit into the rest of a word starts the next, and one wider than
//! a word takes whole words.

use super::interface::Interface;
use super::port::{Direction, Port, PortRole};

/// Place of one port in a record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// The port.
    pub port: Port,
    /// Word of its bit 0.
    pub word: usize,
    /// Bit of its bit 0 in that word.
    pub shift: u32,
}

impl Field {
    /// The port's lowest 64 bits in a record: all of it unless it is wider.
    pub fn low_word(&self, record: &[u64]) -> u64 {
        (record[self.word] >> self.shift) & mask(self.port.width)
    }

    /// The port's value in a record, most significant word last.
    pub fn read(&self, record: &[u64]) -> Vec<u64> {
        if self.port.width <= 64 {
            return vec![self.low_word(record)];
        }
        let words = self.port.width.div_ceil(64) as usize;
        record[self.word..self.word + words].to_vec()
    }

    /// The words of a record that hold the port, each with the port's bits in it.
    pub fn words(&self) -> impl Iterator<Item = (usize, u64)> {
        let parts = (0..self.port.width).step_by(64).enumerate();
        let (width, word, shift) = (self.port.width, self.word, self.shift);
        parts.map(move |(part, first)| (word + part, mask(width - first) << shift))
    }

    /// ORs the lowest `width` bits of `value`, at most 64, into a record, from
    /// bit `at` of the port on.
    pub fn or_bits(&self, record: &mut [u64], at: u32, width: u32, value: u64) {
        let first = self.shift + at;
        let (word, shift) = (self.word + first as usize / 64, first % 64);
        let value = value & mask(width);
        record[word] |= value << shift;
        if shift + width > 64 {
            record[word + 1] |= value >> (64 - shift);
        }
    }

    /// `width` bits of the port, at most 64, from bit `at` on.
    pub fn bits(&self, record: &[u64], at: u32, width: u32) -> u64 {
        let first = self.shift + at;
        let (word, shift) = (self.word + first as usize / 64, first % 64);
        let mut value = record[word] >> shift;
        if shift + width > 64 {
            value |= record[word + 1] << (64 - shift);
        }
        value & mask(width)
    }
}

/// The fields of one direction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Record {
    /// Ports in the interface's order; the clock is not among them.
    pub fields: Vec<Field>,
    /// Words per clock, at least 1.
    pub words: usize,
}

impl Record {
    fn pack(ports: impl Iterator<Item = Port>) -> Record {
        let mut fields = Vec::new();
        let (mut word, mut shift) = (0, 0);
        for port in ports {
            if shift > 0 && shift + port.width > 64 {
                word += 1;
                shift = 0;
            }
            let width = port.width;
            fields.push(Field { port, word, shift });
            if width > 64 {
                word += width.div_ceil(64) as usize;
            } else {
                shift += width;
            }
        }
        Record { fields, words: (word + usize::from(shift > 0)).max(1) }
    }

    /// The field of a port that the interface is known to have.
    ///
    /// # Panics
    /// When there is no such port: a mistake of the caller, not of the user.
    pub fn field(&self, role: PortRole) -> &Field {
        let mut fields = self.fields.iter();
        let field = fields.find(|field| field.port.role == role);
        field.unwrap_or_else(|| panic!("the interface has no port {}", role.name()))
    }

    /// Word and shift of a port's lowest bit.
    ///
    /// # Panics
    /// As [`Record::field`].
    pub fn place(&self, role: PortRole) -> (usize, u32) {
        let field = self.field(role);
        (field.word, field.shift)
    }

    /// Bits of the ports before this one, where all ports' bits follow one another.
    pub fn bits_before(&self, role: PortRole) -> usize {
        let before = self.fields.iter().take_while(|field| field.port.role != role);
        before.map(|field| field.port.width as usize).sum()
    }
}

/// Input and output records of an interface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// All inputs but the clock.
    pub inputs: Record,
    /// All outputs.
    pub outputs: Record,
}

impl Layout {
    /// Name of the clock port, which every clock toggles once.
    pub const CLOCK: &'static str = PortRole::Clock.name();

    /// Lays out an interface's ports.
    pub fn of(interface: &Interface) -> Layout {
        let of =
            |direction| {
                Record::pack(interface.ports().into_iter().filter(move |port| {
                    port.direction == direction && port.role != PortRole::Clock
                }))
            };
        Layout { inputs: of(Direction::Input), outputs: of(Direction::Output) }
    }
}

/// The `width` lowest bits.
pub fn mask(width: u32) -> u64 {
    if width >= 64 { u64::MAX } else { (1 << width) - 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(width: u32) -> Port {
        PortRole::Samples.port(width)
    }

    #[test]
    fn a_port_never_straddles_a_word_unless_it_is_wider_than_one() {
        let record = Record::pack([60, 4, 2, 63, 130, 1].into_iter().map(port));
        let places: Vec<_> = record.fields.iter().map(|f| (f.word, f.shift)).collect();
        assert_eq!(places, [(0, 0), (0, 60), (1, 0), (2, 0), (3, 0), (6, 0)]);
        assert_eq!(record.words, 7);
    }

    #[test]
    fn parts_of_a_wide_port_cross_words() {
        let record = Record::pack([1, 150].into_iter().map(port));
        let field = &record.fields[1];
        let mut words = vec![0; record.words];
        field.or_bits(&mut words, 0, 50, 0x3);
        field.or_bits(&mut words, 50, 50, 0x2_aaaa_bbbb_c001);
        field.or_bits(&mut words, 100, 50, u64::MAX);
        let low = 0x3 | 0x2_aaaa_bbbb_c001 << 50;
        let middle = 0x2_aaaa_bbbb_c001 >> 14 | u64::MAX << 36;
        assert_eq!(words, [0, low, middle, (1 << 22) - 1]);
        assert_eq!(field.bits(&words, 50, 50), 0x2_aaaa_bbbb_c001);
        assert_eq!(field.bits(&words, 100, 50), (1 << 50) - 1);
    }

    #[test]
    fn a_field_reads_back_what_was_put_in_its_place() {
        let record = Record::pack([3, 5].into_iter().map(port));
        assert_eq!(record.fields[1].read(&[0b1011_0010]), [0b10110]);
    }
}
