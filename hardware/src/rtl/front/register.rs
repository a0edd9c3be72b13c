//! Registers on the rising clock edge with synchronous reset.

use rust_hdl_core::ast::Verilog;
use rust_hdl_core::logic::Logic;
use rust_hdl_core::prelude::LogicBlock;
use rust_hdl_core::{block, probe};

use super::marker::Marker;
use super::net::{Input, Net, Output, Value};
use super::word::Word;

/// A register. The back end writes it into the clocked `always` of the module
/// that holds it.
#[derive(Debug, Clone, LogicBlock)]
pub struct Register<V: Value> {
    /// Clock; `q` takes `d` at its rising edge.
    pub clock: Input<bool>,
    /// Synchronous reset, active high.
    pub reset: Input<bool>,
    /// What the kernel drives.
    pub d: Input<V>,
    /// What the register holds.
    pub q: Output<V>,
    _name: Option<String>,
    _reset_value: V,
    _reset_constant: Option<String>,
    _about: String,
}

impl<V: Value> Register<V> {
    fn with_pins(d: Input<V>, q: Output<V>, reset_value: V, about: String) -> Self {
        Register {
            clock: Net::bit(""),
            reset: Net::bit(""),
            d,
            q: q.initially(reset_value),
            _name: None,
            _reset_value: reset_value,
            _reset_constant: None,
            _about: about,
        }
    }

    /// Its name in the Verilog, without the `_r`, in place of the field's.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self._name = Some(name.into());
        self
    }

    /// The block's constant that holds the reset value.
    pub fn reset_to(mut self, constant: &str) -> Self {
        self._reset_constant = Some(constant.to_owned());
        self
    }
}

impl Register<bool> {
    /// A single bit.
    pub fn bit(reset_value: bool, about: impl Into<String>) -> Self {
        Self::with_pins(Net::bit(""), Net::bit(""), reset_value, about.into())
    }
}

impl Register<Word> {
    /// A vector of `width` bits.
    pub fn word(width: u32, reset_value: u128, about: impl Into<String>) -> Self {
        Self::with_pins(
            Net::word(width, ""),
            Net::word(width, ""),
            Word::new(reset_value, width),
            about.into(),
        )
    }
}

impl<V: Value> Logic for Register<V> {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            self.q.next = if self.reset.val() { self._reset_value } else { self.d.val() };
        }
    }

    fn connect(&mut self) {
        self.q.connect();
    }

    fn hdl(&self) -> Verilog {
        Marker::Register {
            name: self._name.clone(),
            reset_value: self._reset_value.number(),
            reset_constant: self._reset_constant.clone(),
            about: self._about.clone(),
        }
        .into_hdl()
    }
}
