//! What a block is built for.

use std::ops::Deref;

use rust_hdl_core::block::Block;
use rust_hdl_core::logic::Logic;
use rust_hdl_core::probe::Probe;

/// A block's numbers, which decide how its kernel is elaborated; no probe
/// sees them.
#[derive(Debug, Clone)]
pub struct Plan<P>(P);

impl<P> From<P> for Plan<P> {
    fn from(numbers: P) -> Plan<P> {
        Plan(numbers)
    }
}

impl<P> Deref for Plan<P> {
    type Target = P;
    fn deref(&self) -> &P {
        &self.0
    }
}

impl<P> Logic for Plan<P> {
    fn update(&mut self) {}
}

impl<P> Block for Plan<P> {
    fn connect_all(&mut self) {}
    fn update_all(&mut self) {}

    fn has_changed(&self) -> bool {
        false
    }

    fn accept(&self, _name: &str, _probe: &mut dyn Probe) {}
}
