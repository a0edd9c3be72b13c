//! What every source of chips has in common: its ports.

use crate::rtl::front::prelude::*;

/// Ports of a source of chips.
#[block]
pub struct CodePorts {
    reloads: bool,
    /// go on to the next chip
    pub i_advance: Input<bool>,
    /// start again as after reset; wins over i_advance
    #[when(reloads)]
    pub i_load: Optional<Input<bool>>,
    /// present chip
    pub o_chip: Output<bool>,
    /// the present chip is the one that reset gives
    pub o_epoch: Output<bool>,
}
