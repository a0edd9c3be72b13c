//! Memories for registers: one port that writes, one that reads without a clock.

use rust_hdl_core::ast::Verilog;
use rust_hdl_core::logic::Logic;
use rust_hdl_core::prelude::LogicBlock;
use rust_hdl_core::{block, probe};

use super::clock::edge;
use super::marker::Marker;
use super::net::{Input, Net, Output};
use super::word::Word;

/// A memory of words of 32 bits, which synthesizers put into lookup tables. At power-up it holds what it is given,
/// and reset leaves it as it is: nothing is written then, whatever the registers before it were.
#[derive(Debug, Clone, LogicBlock)]
pub struct RegisterMemory {
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
    _words: Vec<u32>,
    _initial: Vec<u32>,
    _about: String,
}

impl RegisterMemory {
    /// A memory with addresses of so many bits that begins with these words, and 0 in the others.
    pub fn new(initial: &[u32], address_bits: u32, about: &str) -> RegisterMemory {
        let mut words = initial.to_vec();
        words.resize(1 << address_bits, 0);
        RegisterMemory {
            i_write: Net::bit(""),
            i_write_address: Net::word(address_bits, ""),
            i_data: Net::word(32, ""),
            i_address: Net::word(address_bits, ""),
            o_word: Net::word(32, ""),
            _initial: words.clone(),
            _words: words,
            _about: about.to_owned(),
        }
    }
}

impl Logic for RegisterMemory {
    fn update(&mut self) {
        let place = |address: Word| address.value() as usize;
        if edge() == Some(false) && self.i_write.val() {
            self._words[place(self.i_write_address.val())] = self.i_data.val().value() as u32;
        }
        self.o_word.next = Word::new(self._words[place(self.i_address.val())].into(), 32);
    }

    fn hdl(&self) -> Verilog {
        let address_bits = self.i_address.val().bits() as u32;
        let words: Vec<String> =
            self._initial.iter().rev().map(|word| format!("32'h{word:08x}")).collect();
        let lines: Vec<String> = words.chunks(4).map(|words| words.join(", ")).collect();
        let initial = format!("{{\n            {}\n        }}", lines.join(",\n            "));
        Marker::Given {
            module: "register_memory",
            text: include_str!("../back/register_memory.v"),
            sizes: vec![("ADDRESS_BITS".to_owned(), address_bits)],
            sees_reset: true,
            contents: Some(("INITIAL".to_owned(), initial)),
            about: self._about.clone(),
        }
        .into_hdl()
    }
}
