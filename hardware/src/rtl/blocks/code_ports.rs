//! What every source of chips has in common: its ports.

use crate::rtl::front::prelude::*;

/// Ports of a source of chips.
#[block]
pub struct CodePorts {
    reloads: bool,
    /// Bits of a seed that is set from outside; 0 without.
    seed_bits: u32,
    /// go on to the next chip
    pub i_advance: Input<bool>,
    /// start again as after reset; wins over i_advance
    #[when(reloads)]
    pub i_load: Optional<Input<bool>>,
    /// first chips of the second register, the earliest in bit 0: what i_load gives it
    #[when(seed_bits > 0)]
    #[width(seed_bits)]
    pub i_seed: Optional<Input<Word>>,
    /// present chip
    pub o_chip: Output<bool>,
    /// the present chip is the one that reset gives
    pub o_epoch: Output<bool>,
}
