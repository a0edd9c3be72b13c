//! Registers on the rising clock edge with synchronous reset.

use std::ops::{Deref, DerefMut};

use rust_hdl_core::ast::Verilog;
use rust_hdl_core::block::Block;
use rust_hdl_core::logic::Logic;
use rust_hdl_core::probe::Probe;

use super::clock::edge;
use super::marker::Marker;
use super::net::{Input, Net, NetValue, Output};
use super::word::Word;

/// A register. The back end writes it into the clocked `always` of the module
/// that holds it. Kernels drive `next`, and read `val()`.
#[derive(Debug, Clone)]
pub struct Register<V: NetValue> {
    /// What `q` takes at a rising edge; without being driven it holds.
    pub d: Input<V>,
    /// What the register holds.
    pub q: Output<V>,
    name: Option<String>,
    reset_value: V,
    reset_constant: Option<String>,
    about: String,
}

impl<V: NetValue> Register<V> {
    fn with_pins(d: Input<V>, q: Output<V>, reset_value: V, about: String) -> Self {
        Register {
            d: d.initially(reset_value),
            q: q.initially(reset_value),
            name: None,
            reset_value,
            reset_constant: None,
            about,
        }
    }

    /// What it holds.
    pub fn val(&self) -> V {
        self.q.val()
    }

    /// Its name in the Verilog, without the `_r`, in place of the field's.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }

    /// The block's constant that holds the reset value.
    pub fn reset_to(mut self, constant: &str) -> Self {
        self.reset_constant = Some(constant.to_owned());
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

impl<V: NetValue> Deref for Register<V> {
    type Target = Input<V>;
    fn deref(&self) -> &Input<V> {
        &self.d
    }
}

impl<V: NetValue> DerefMut for Register<V> {
    fn deref_mut(&mut self) -> &mut Input<V> {
        &mut self.d
    }
}

impl<V: NetValue> Logic for Register<V> {
    fn update(&mut self) {}

    fn hdl(&self) -> Verilog {
        Marker::Register {
            name: self.name.clone(),
            reset_value: self.reset_value.number(),
            reset_constant: self.reset_constant.clone(),
            about: self.about.clone(),
        }
        .into_hdl()
    }
}

impl<V: NetValue> Block for Register<V> {
    fn connect_all(&mut self) {}

    fn update_all(&mut self) {
        self.d.update_all();
        if let Some(reset) = edge() {
            self.q.next = if reset { self.reset_value } else { self.d.val() };
        }
        self.q.update_all();
        self.d.next = self.q.next;
    }

    fn has_changed(&self) -> bool {
        self.d.has_changed() || self.q.has_changed()
    }

    fn accept(&self, name: &str, probe: &mut dyn Probe) {
        probe.visit_start_scope(name, self);
        self.d.accept("d", probe);
        self.q.accept("q", probe);
        probe.visit_end_scope(name, self);
    }
}
