//! Memories in lookup tables: one port that writes, one that reads without a clock.

use rust_hdl_core::ast::Verilog;
use rust_hdl_core::logic::Logic;
use rust_hdl_core::prelude::LogicBlock;
use rust_hdl_core::{block, probe};

use super::clock::edge;
use super::marker::Marker;
use super::net::{Input, Net, Output};
use super::word::Word;

/// A memory of words whose port that reads has no clock: synthesizers put it into lookup tables. Words have
/// no value at power-up, and none after reset.
#[derive(Debug, Clone, LogicBlock)]
pub struct LookupMemory {
    /// Whether a word is written.
    pub i_write: Input<bool>,
    /// Where.
    pub i_write_address: Input<Word>,
    /// What.
    pub i_data: Input<Word>,
    /// Which is read.
    pub i_address: Input<Word>,
    /// The word there.
    pub o_word: Output<Word>,
    _words: Vec<u128>,
    _about: String,
}

impl LookupMemory {
    /// A memory of words of `width` bits, with addresses of so many.
    pub fn new(address_bits: u32, width: u32, about: &str) -> LookupMemory {
        LookupMemory {
            i_write: Net::bit(""),
            i_write_address: Net::word(address_bits, ""),
            i_data: Net::word(width, ""),
            i_address: Net::word(address_bits, ""),
            o_word: Net::word(width, ""),
            _words: vec![0; 1 << address_bits],
            _about: about.to_owned(),
        }
    }
}

impl Logic for LookupMemory {
    fn update(&mut self) {
        let place = |address: Word| address.value() as usize;
        if edge().is_some() && self.i_write.val() {
            self._words[place(self.i_write_address.val())] = self.i_data.val().value();
        }
        let width = self.i_data.val().bits() as u32;
        self.o_word.next = Word::new(self._words[place(self.i_address.val())], width);
    }

    fn hdl(&self) -> Verilog {
        let size = |name: &str, value| (name.to_owned(), value);
        Marker::Given {
            module: "lookup_memory",
            text: include_str!("../back/lookup_memory.v"),
            sizes: vec![
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
