//! Block memories: one port that writes, one that reads, both with a clock.

use rust_hdl_core::ast::Verilog;
use rust_hdl_core::logic::Logic;
use rust_hdl_core::prelude::LogicBlock;
use rust_hdl_core::{block, probe};

use super::clock::edge;
use super::marker::Marker;
use super::net::{Input, Net, Output};
use super::word::Word;

/// A memory of words, which synthesizers put into block RAM, with a register behind it: its
/// words have no value at power-up and none after reset, and what is read comes two clocks later. A
/// word that is read while it is written is not to be relied on.
#[derive(Debug, Clone, LogicBlock)]
pub struct Memory {
    /// Whether a word is written.
    pub write: Input<bool>,
    /// Where.
    pub write_address: Input<Word>,
    /// What.
    pub data: Input<Word>,
    /// Whether a word is read, and the one before it goes on to `q`; otherwise both hold.
    pub read: Input<bool>,
    /// Which.
    pub address: Input<Word>,
    /// The word that was read last but one.
    pub q: Output<Word>,
    _words: Vec<u128>,
    _read: u128,
    _about: String,
}

impl Memory {
    /// A memory of `words` words of `width` bits.
    pub fn new(words: u64, width: u32, about: &str) -> Memory {
        let last = words.saturating_sub(1);
        let address_bits = (u64::BITS - last.leading_zeros()).max(1);
        Memory {
            write: Net::bit(""),
            write_address: Net::word(address_bits, ""),
            data: Net::word(width, ""),
            read: Net::bit(""),
            address: Net::word(address_bits, ""),
            q: Net::word(width, ""),
            _words: vec![0; words as usize],
            _read: 0,
            _about: about.to_owned(),
        }
    }
}

impl Logic for Memory {
    fn update(&mut self) {
        if edge().is_none() {
            return;
        }
        let word = |address: Word| address.value() as usize;
        if self.read.val() {
            let read = self._words.get(word(self.address.val())).copied();
            let before = std::mem::replace(&mut self._read, read.unwrap_or(0));
            self.q.next = Word::new(before, self.data.val().bits() as u32);
        }
        if self.write.val()
            && let Some(written) = self._words.get_mut(word(self.write_address.val()))
        {
            *written = self.data.val().value();
        }
    }

    fn hdl(&self) -> Verilog {
        Marker::Memory { words: self._words.len() as u64, about: self._about.clone() }.into_hdl()
    }
}
