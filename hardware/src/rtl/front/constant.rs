//! Named constants.

use rust_hdl_core::ast::VerilogLiteral;
use rust_hdl_core::atom::{Atom, AtomKind};
use rust_hdl_core::block::Block;
use rust_hdl_core::constraint::PinConstraint;
use rust_hdl_core::logic::Logic;
use rust_hdl_core::probe::Probe;
use rust_hdl_core::signal::get_signal_id;
use rust_hdl_core::synth::VCDValue;
use rust_hdl_core::type_descriptor::{TypeDescriptor, TypeKind};

use super::net::vcd_bits;
use super::word::Word;

/// A constant of the circuit: a `localparam` where all instances of a module
/// agree on it, a `parameter` otherwise.
#[derive(Debug, Clone)]
pub struct Constant {
    value: Word,
    about: String,
    heading: Option<String>,
    is_number: bool,
    id: usize,
}

impl Constant {
    /// `value` in `width` bits; `about` becomes its comment in the Verilog.
    pub fn new(value: u128, width: u32, about: impl Into<String>) -> Constant {
        Constant {
            value: Word::new(value, width),
            about: about.into(),
            heading: None,
            is_number: false,
            id: get_signal_id(),
        }
    }

    /// Puts it under `heading` among the module's constants.
    pub fn under(mut self, heading: impl Into<String>) -> Constant {
        self.heading = Some(heading.into());
        self
    }

    /// Makes it a number, which is written as such, and not a pattern of bits.
    pub fn number(mut self) -> Constant {
        self.is_number = true;
        self
    }

    /// The value.
    pub fn val(&self) -> Word {
        self.value
    }
}

impl Atom for Constant {
    fn bits(&self) -> usize {
        self.value.bits()
    }

    fn connected(&self) -> bool {
        true
    }

    fn changed(&self) -> bool {
        false
    }

    fn kind(&self) -> AtomKind {
        AtomKind::Constant
    }

    /// The descriptor's name carries the constant's description, after the
    /// heading and a line break if there is one; its kind is signed for a number.
    fn descriptor(&self) -> TypeDescriptor {
        TypeDescriptor {
            name: match &self.heading {
                Some(heading) => format!("{heading}\n{}", self.about),
                None => self.about.clone(),
            },
            kind: match self.is_number {
                true => TypeKind::Signed(self.value.bits()),
                false => TypeKind::Bits(self.value.bits()),
            },
        }
    }

    fn vcd(&self) -> VCDValue {
        vcd_bits(self.value.value(), self.value.bits() as u32)
    }

    fn id(&self) -> usize {
        self.id
    }

    fn verilog(&self) -> VerilogLiteral {
        self.value.value().into()
    }

    fn constraints(&self) -> Vec<PinConstraint> {
        Vec::new()
    }
}

impl Logic for Constant {
    fn update(&mut self) {}
}

impl Block for Constant {
    fn connect_all(&mut self) {}
    fn update_all(&mut self) {}

    fn has_changed(&self) -> bool {
        false
    }

    fn accept(&self, name: &str, probe: &mut dyn Probe) {
        probe.visit_atom(name, self);
    }
}
