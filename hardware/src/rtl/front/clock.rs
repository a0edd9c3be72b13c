//! The one clock, which all registers and memories have, and its reset.

use std::cell::Cell;

use rust_hdl_core::block::Block;

thread_local! {
    /// The reset at the rising edge that passes.
    static EDGE: Cell<Option<bool>> = const { Cell::new(None) };
}

/// A rising edge of the clock for all registers in a block that has settled, with `i_rst` as
/// `reset`. What follows from it has to settle again.
pub fn tick(block: &mut impl Block, reset: bool) {
    EDGE.set(Some(reset));
    block.update_all();
    EDGE.set(None);
}

/// The reset, while a rising edge passes.
pub(super) fn edge() -> Option<bool> {
    EDGE.get()
}
