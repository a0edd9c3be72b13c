//! Parts of a block that only some scenes need.

use std::ops::{Deref, DerefMut};

use rust_hdl_core::block::Block;
use rust_hdl_core::logic::Logic;
use rust_hdl_core::probe::Probe;

/// A part that may be left out, used inside `if self.part.is_present()`.
///
/// A part left out is kept as a stand-in that no probe sees and no update
/// reaches, because rust-hdl evaluates the arguments of casts even in a
/// branch that elaboration does not take.
#[derive(Debug, Clone)]
pub struct Optional<B> {
    present: bool,
    part: B,
}

impl<B> Optional<B> {
    /// `part`, if `present`.
    pub fn new(present: bool, part: B) -> Optional<B> {
        Optional { present, part }
    }

    /// Whether the hardware has it.
    pub fn is_present(&self) -> bool {
        self.present
    }
}

impl<B> Deref for Optional<B> {
    type Target = B;
    fn deref(&self) -> &B {
        &self.part
    }
}

impl<B> DerefMut for Optional<B> {
    fn deref_mut(&mut self) -> &mut B {
        &mut self.part
    }
}

impl<B: Block> Logic for Optional<B> {
    fn update(&mut self) {}
}

impl<B: Block> Block for Optional<B> {
    fn connect_all(&mut self) {}

    fn update_all(&mut self) {
        if self.present {
            self.part.update_all();
        }
    }

    fn has_changed(&self) -> bool {
        self.present && self.part.has_changed()
    }

    fn accept(&self, name: &str, probe: &mut dyn Probe) {
        if self.present {
            self.part.accept(name, probe);
        }
    }
}
