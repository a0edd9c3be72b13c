//! Ports and local signals.

use std::marker::PhantomData;

use rust_hdl_core::ast::VerilogLiteral;
use rust_hdl_core::atom::{Atom, AtomKind};
use rust_hdl_core::block::Block;
use rust_hdl_core::constraint::PinConstraint;
use rust_hdl_core::direction::{self, Direction};
use rust_hdl_core::logic::Logic;
use rust_hdl_core::probe::Probe;
use rust_hdl_core::signal::get_signal_id;
use rust_hdl_core::synth::VCDValue;
use rust_hdl_core::type_descriptor::{TypeDescriptor, TypeKind};

use super::word::Word;

/// What a net carries: a [`Word`], or a `bool` for a single bit that kernels
/// test with `if`.
pub trait NetValue: Copy + PartialEq + std::fmt::Debug {
    /// The value in `width` bits.
    fn fit(self, width: u32) -> Self;
    /// A number in `width` bits.
    fn of(number: u128, width: u32) -> Self;
    /// The bits as a number.
    fn number(self) -> u128;
}

impl NetValue for bool {
    fn fit(self, _width: u32) -> bool {
        self
    }
    fn of(number: u128, _width: u32) -> bool {
        number & 1 == 1
    }
    fn number(self) -> u128 {
        u128::from(self)
    }
}

impl NetValue for Word {
    fn fit(self, width: u32) -> Word {
        Word::new(self.value(), width)
    }
    fn of(number: u128, width: u32) -> Word {
        Word::new(number, width)
    }
    fn number(self) -> u128 {
        self.value()
    }
}

/// A signal of run-time width, rust-hdl's `Signal` otherwise.
#[derive(Debug, Clone)]
pub struct Net<D: Direction, V: NetValue> {
    /// What the kernel drives it with.
    pub next: V,
    val: V,
    changed: bool,
    width: u32,
    about: String,
    heading: Option<String>,
    is_number: bool,
    id: usize,
    direction: PhantomData<D>,
}

/// A port driven from outside the block.
pub type Input<V> = Net<direction::In, V>;
/// A port driven by the block.
pub type Output<V> = Net<direction::Out, V>;
/// A signal inside the block.
pub type Local<V> = Net<direction::Local, V>;
/// A constant of the circuit: a `localparam` where all instances of a module
/// agree on it, a `parameter` otherwise.
pub type Constant = Net<Fixed, Word>;

/// Driven by nothing.
#[derive(Debug, Clone)]
pub struct Fixed;

impl Direction for Fixed {
    const KIND: AtomKind = AtomKind::Constant;
}

impl<D: Direction, V: NetValue> Net<D, V> {
    fn with_width(width: u32, about: impl Into<String>) -> Self {
        Net {
            next: V::of(0, width),
            val: V::of(0, width),
            changed: false,
            width,
            about: about.into(),
            heading: None,
            is_number: false,
            id: get_signal_id(),
            direction: PhantomData,
        }
    }

    /// Whether the hardware has it, as an [`Optional`](super::Optional) says.
    pub fn is_present(&self) -> bool {
        true
    }

    /// Starts with `value` in place of zero.
    pub(super) fn initially(mut self, value: V) -> Self {
        self.next = value;
        self
    }

    /// Puts a port or constant under `heading` in the module's list of them, unless that is empty.
    pub fn under(mut self, heading: impl Into<String>) -> Self {
        self.heading = Some(heading.into()).filter(|heading| !heading.is_empty());
        self
    }
}

impl<D: Direction> Net<D, bool> {
    /// A single bit; `about` becomes its comment in the Verilog.
    pub fn bit(about: impl Into<String>) -> Self {
        Self::with_width(1, about)
    }
}

impl<D: Direction> Net<D, Word> {
    /// A vector of `width` bits; `about` becomes its comment in the Verilog.
    pub fn word(width: u32, about: impl Into<String>) -> Self {
        Self::with_width(width, about)
    }
}

impl Constant {
    /// `value` in `width` bits; `about` becomes its comment in the Verilog.
    pub fn new(value: u128, width: u32, about: impl Into<String>) -> Constant {
        let value = Word::new(value, width);
        Constant { val: value, ..Net::with_width(width, about).initially(value) }
    }

    /// Makes it a number, which is written as such, and not a pattern of bits.
    pub fn number(mut self) -> Constant {
        self.is_number = true;
        self
    }

    /// The value.
    pub fn val(&self) -> Word {
        self.val
    }
}

impl<V: NetValue> Net<direction::In, V> {
    /// The settled value.
    pub fn val(&self) -> V {
        self.val
    }
}

impl<V: NetValue> Net<direction::Out, V> {
    /// The value driven so far.
    pub fn val(&self) -> V {
        self.next.fit(self.width)
    }
}

impl<V: NetValue> Net<direction::Local, V> {
    /// The value driven so far.
    pub fn val(&self) -> V {
        self.next.fit(self.width)
    }
}

/// A block's inputs by name, for testbenches; `name$0`, `name$1` and so on are those of a vector.
pub trait BlockInputs {
    /// Sets the input of that name, if there is one.
    fn set(&mut self, port: &str, value: u128);
}

/// One input, or several, under a field's name.
pub trait InputPort {
    /// Sets it if `port` is its name.
    fn set_if(&mut self, name: &str, port: &str, value: u128);
}

impl<V: NetValue> InputPort for Input<V> {
    fn set_if(&mut self, name: &str, port: &str, value: u128) {
        if name == port {
            self.next = V::of(value, self.width);
        }
    }
}

impl<P: InputPort> InputPort for Vec<P> {
    fn set_if(&mut self, name: &str, port: &str, value: u128) {
        for (place, one) in self.iter_mut().enumerate() {
            one.set_if(&format!("{name}${place}"), port, value);
        }
    }
}

impl<D: Direction, V: NetValue> Atom for Net<D, V> {
    fn bits(&self) -> usize {
        self.width as usize
    }

    fn connected(&self) -> bool {
        true
    }

    fn changed(&self) -> bool {
        self.changed
    }

    fn kind(&self) -> AtomKind {
        D::KIND
    }

    /// The descriptor's name carries the net's description, after the heading
    /// and a line break if there is one; its kind is signed for a number.
    fn descriptor(&self) -> TypeDescriptor {
        TypeDescriptor {
            name: match &self.heading {
                Some(heading) => format!("{heading}\n{}", self.about),
                None => self.about.clone(),
            },
            kind: match self.is_number {
                true => TypeKind::Signed(self.width as usize),
                false => TypeKind::Bits(self.width as usize),
            },
        }
    }

    fn vcd(&self) -> VCDValue {
        vcd_bits(self.val.number(), self.width)
    }

    fn id(&self) -> usize {
        self.id
    }

    fn verilog(&self) -> VerilogLiteral {
        self.val.number().into()
    }

    fn constraints(&self) -> Vec<PinConstraint> {
        Vec::new()
    }
}

impl<D: Direction, V: NetValue> Logic for Net<D, V> {
    fn update(&mut self) {}
}

impl<D: Direction, V: NetValue> Block for Net<D, V> {
    fn connect_all(&mut self) {}

    fn update_all(&mut self) {
        let next = self.next.fit(self.width);
        self.changed = self.val != next;
        self.val = next;
    }

    fn has_changed(&self) -> bool {
        self.changed
    }

    fn accept(&self, name: &str, probe: &mut dyn Probe) {
        probe.visit_atom(name, self);
    }
}

/// Bits for a value-change dump, most significant first.
fn vcd_bits(number: u128, width: u32) -> VCDValue {
    VCDValue::Vector((0..width).rev().map(|bit| ((number >> bit) & 1 == 1).into()).collect())
}
