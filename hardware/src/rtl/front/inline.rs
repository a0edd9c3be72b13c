//! Circuits that the back end writes in place because rust-hdl's kernels
//! cannot say them.

use rust_hdl_core::ast::Verilog;
use rust_hdl_core::logic::Logic;
use rust_hdl_core::prelude::LogicBlock;
use rust_hdl_core::{block, probe};

use super::marker::Marker;
use super::net::{Input, Net, Output};
use super::word::Word;

/// A constant table of single bits, read without a clock.
#[derive(Debug, Clone, LogicBlock)]
pub struct BitTable {
    /// Index of the entry.
    pub address: Input<Word>,
    /// The entry.
    pub data: Output<bool>,
    _bits: Vec<u8>,
    _about: String,
}

impl BitTable {
    /// A table of `bits`, entry 0 first, read by `address_width` address bits.
    pub fn new(bits: Vec<u8>, address_width: u32, about: &str) -> BitTable {
        BitTable {
            address: Net::word(address_width, ""),
            data: Net::bit(""),
            _bits: bits,
            _about: about.to_owned(),
        }
    }
}

impl Logic for BitTable {
    fn update(&mut self) {
        let entry = self._bits.get(self.address.val().value() as usize);
        self.data.next = entry == Some(&1);
    }

    fn hdl(&self) -> Verilog {
        Marker::BitTable { bits: self._bits.clone(), about: self._about.clone() }.into_hdl()
    }
}
