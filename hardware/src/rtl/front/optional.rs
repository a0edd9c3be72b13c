//! Parts of a block that only some scenes need.

use std::ops::{Deref, DerefMut};

use rust_hdl_core::block::Block;
use rust_hdl_core::logic::Logic;
use rust_hdl_core::probe::Probe;

use super::net::InputPort;

/// A part that may be left out, used inside `if self.part.is_present()`.
#[derive(Debug, Clone)]
pub struct Optional<B>(Option<B>);

/// Why a kernel has no use for a part that is not there.
const ABSENT: &str = "a kernel names a part where it is present";

impl<B> Optional<B> {
    /// A part, or none.
    pub fn new(part: Option<B>) -> Optional<B> {
        Optional(part)
    }

    /// Whether the hardware has it.
    pub fn is_present(&self) -> bool {
        self.0.is_some()
    }
}

impl<B> Deref for Optional<B> {
    type Target = B;
    fn deref(&self) -> &B {
        self.0.as_ref().expect(ABSENT)
    }
}

impl<B> DerefMut for Optional<B> {
    fn deref_mut(&mut self) -> &mut B {
        self.0.as_mut().expect(ABSENT)
    }
}

impl<P: InputPort> InputPort for Optional<P> {
    fn set_if(&mut self, name: &str, port: &str, value: u128) {
        if let Some(part) = &mut self.0 {
            part.set_if(name, port, value);
        }
    }
}

impl<B: Block> Logic for Optional<B> {
    fn update(&mut self) {}
}

impl<B: Block> Block for Optional<B> {
    fn connect_all(&mut self) {}

    fn update_all(&mut self) {
        if let Some(part) = &mut self.0 {
            part.update_all();
        }
    }

    fn has_changed(&self) -> bool {
        self.0.as_ref().is_some_and(Block::has_changed)
    }

    fn accept(&self, name: &str, probe: &mut dyn Probe) {
        if let Some(part) = &self.0 {
            part.accept(name, probe);
        }
    }
}
