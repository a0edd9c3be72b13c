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
    pub i_write: Input<bool>,
    /// Where.
    pub i_write_address: Input<Word>,
    /// What.
    pub i_data: Input<Word>,
    /// Whether a word is read, and the one before it goes on to `o_word`; otherwise both hold.
    pub i_read: Input<bool>,
    /// Which.
    pub i_address: Input<Word>,
    /// The word that was read last but one.
    pub o_word: Output<Word>,
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
            i_write: Net::bit(""),
            i_write_address: Net::word(address_bits, ""),
            i_data: Net::word(width, ""),
            i_read: Net::bit(""),
            i_address: Net::word(address_bits, ""),
            o_word: Net::word(width, ""),
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
        if self.i_read.val() {
            let read = self._words.get(word(self.i_address.val())).copied();
            let before = std::mem::replace(&mut self._read, read.unwrap_or(0));
            self.o_word.next = Word::new(before, self.i_data.val().bits() as u32);
        }
        if self.i_write.val()
            && let Some(written) = self._words.get_mut(word(self.i_write_address.val()))
        {
            *written = self.i_data.val().value();
        }
    }

    fn hdl(&self) -> Verilog {
        let size = |name: &str, value| (name.to_owned(), value);
        Marker::Given {
            module: "block_memory",
            text: include_str!("../back/block_memory.v"),
            sizes: vec![
                size("WORDS", self._words.len() as u32),
                size("ADDRESS_BITS", self.i_address.val().bits() as u32),
                size("BITS", self.i_data.val().bits() as u32),
            ],
            sees_reset: false,
            contents: None,
            about: self._about.clone(),
        }
        .into_hdl()
    }
}
