//! Memories whose modules are given as text: one port that writes, one that reads.

use rust_hdl_core::ast::Verilog;
use rust_hdl_core::logic::Logic;
use rust_hdl_core::prelude::LogicBlock;
use rust_hdl_core::{block, probe};

use super::clock::edge;
use super::marker::Marker;
use super::net::{Input, Net, Output};
use super::optional::Optional;
use super::word::Word;

const IN_BLOCKS: u8 = 0;
const IN_TABLES: u8 = 1;
const OF_REGISTERS: u8 = 2;

/// A memory of words, which synthesizers put into block RAM, with a register behind it: its
/// words have no value at power-up and none after reset, and what is read comes two clocks later. A
/// word that is read while it is written is not to be relied on.
pub type Memory = GivenMemory<IN_BLOCKS>;
/// A memory of words whose port that reads has no clock: synthesizers put it into lookup tables. Words have
/// no value at power-up, and none after reset.
pub type LookupMemory = GivenMemory<IN_TABLES>;
/// The same of words of 32 bits. At power-up it holds what it is given, and reset leaves it as it is: nothing is
/// written then, whatever the registers before it were.
pub type RegisterMemory = GivenMemory<OF_REGISTERS>;

/// A memory.
#[derive(Debug, Clone, LogicBlock)]
pub struct GivenMemory<const KIND: u8> {
    /// Whether a word is written.
    pub i_write: Input<bool>,
    /// Where.
    pub i_write_address: Input<Word>,
    /// What.
    pub i_data: Input<Word>,
    /// Of block RAM whether a word is read, and the one before it goes on to `o_word`; otherwise both hold.
    pub i_read: Optional<Input<bool>>,
    /// Which.
    pub i_address: Input<Word>,
    /// The word there; of block RAM the one that was read last but one.
    pub o_word: Output<Word>,
    _words: Vec<u128>,
    _read: u128,
    _marker: Marker,
}

impl Memory {
    /// A memory of `words` words of `width` bits.
    pub fn new(words: u64, width: u32, about: &str) -> Memory {
        let last = words.saturating_sub(1);
        let address_bits = (u64::BITS - last.leading_zeros()).max(1);
        let sizes = [("WORDS", words as u32), ("ADDRESS_BITS", address_bits), ("BITS", width)];
        let module = ("block_memory", include_str!("../back/block_memory.v"));
        GivenMemory::of(module, &sizes, vec![0; words as usize], None, about)
    }
}

impl LookupMemory {
    /// A memory of words of `width` bits, with addresses of so many.
    pub fn new(address_bits: u32, width: u32, about: &str) -> LookupMemory {
        let sizes = [("ADDRESS_BITS", address_bits), ("BITS", width)];
        let module = ("lookup_memory", include_str!("../back/lookup_memory.v"));
        GivenMemory::of(module, &sizes, vec![0; 1 << address_bits], None, about)
    }
}

impl RegisterMemory {
    /// A memory with addresses of so many bits that begins with these words, and 0 in the others.
    pub fn new(initial: &[u32], address_bits: u32, about: &str) -> RegisterMemory {
        let mut words: Vec<u128> = initial.iter().map(|&word| word.into()).collect();
        words.resize(1 << address_bits, 0);
        let texts: Vec<String> = words.iter().rev().map(|word| format!("32'h{word:08x}")).collect();
        let lines: Vec<String> = texts.chunks(4).map(|words| words.join(", ")).collect();
        let contents = format!("{{\n            {}\n        }}", lines.join(",\n            "));
        let module = ("register_memory", include_str!("../back/register_memory.v"));
        GivenMemory::of(module, &[("ADDRESS_BITS", address_bits)], words, Some(contents), about)
    }
}

impl<const KIND: u8> GivenMemory<KIND> {
    fn of(
        (module, text): (&'static str, &'static str),
        sizes: &[(&str, u32)],
        words: Vec<u128>,
        contents: Option<String>,
        about: &str,
    ) -> GivenMemory<KIND> {
        let size =
            |wanted: &str| sizes.iter().find(|(name, _)| *name == wanted).map(|(_, size)| *size);
        let address_bits = size("ADDRESS_BITS").unwrap_or(1);
        let width = size("BITS").unwrap_or(32);
        GivenMemory {
            i_write: Net::bit(""),
            i_write_address: Net::word(address_bits, ""),
            i_data: Net::word(width, ""),
            i_read: Optional::new((KIND == IN_BLOCKS).then(|| Net::bit(""))),
            i_address: Net::word(address_bits, ""),
            o_word: Net::word(width, ""),
            _words: words,
            _read: 0,
            _marker: Marker::Given {
                module,
                text,
                sizes: sizes.iter().map(|(name, size)| ((*name).to_owned(), *size)).collect(),
                sees_reset: KIND == OF_REGISTERS,
                contents: contents.map(|contents| ("INITIAL".to_owned(), contents)),
                about: about.to_owned(),
            },
        }
    }

    /// The word at the address that is read.
    fn word(&self) -> u128 {
        self._words.get(self.i_address.val().value() as usize).copied().unwrap_or(0)
    }
}

impl<const KIND: u8> Logic for GivenMemory<KIND> {
    fn update(&mut self) {
        let width = self.i_data.val().bits() as u32;
        if self.i_read.is_present() && edge().is_some() && self.i_read.val() {
            let read = self.word();
            let before = std::mem::replace(&mut self._read, read);
            self.o_word.next = Word::new(before, width);
        }
        let writes = edge().is_some_and(|reset| !(reset && KIND == OF_REGISTERS));
        let place = self.i_write_address.val().value() as usize;
        if writes
            && self.i_write.val()
            && let Some(word) = self._words.get_mut(place)
        {
            *word = self.i_data.val().value();
        }
        if !self.i_read.is_present() {
            self.o_word.next = Word::new(self.word(), width);
        }
    }

    fn hdl(&self) -> Verilog {
        self._marker.clone().into_hdl()
    }
}
