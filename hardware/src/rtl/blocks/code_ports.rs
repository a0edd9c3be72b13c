//! What every source of chips has in common: its ports.

use crate::rtl::front::prelude::*;
use crate::sensor::registers::Seed;

/// Ports of a source of chips.
#[block]
pub struct CodePorts {
    reloads: bool,
    /// What is set from outside of the code.
    seed: Option<Seed>,
    /// go on to the next chip
    pub i_advance: Input<bool>,
    /// start again as after reset; wins over i_advance
    #[when(reloads)]
    pub i_load: Optional<Input<bool>>,
    /// the second register's first chips at i_load, earliest in bit 0{taps_about(seed)}
    #[when(seed.is_some())]
    #[width(seed.map_or(0, |seed| seed.bits))]
    pub i_seed: Optional<Input<Word>>,
    /// present chip
    pub o_chip: Output<bool>,
    /// the present chip is the one that reset gives
    pub o_epoch: Output<bool>,
}

/// Where the taps are beside these chips.
pub(super) fn taps_about(seed: Option<Seed>) -> String {
    match seed.filter(Seed::has_taps) {
        None => String::new(),
        Some(Seed { degree, bits, .. }) => format!("; its taps in [{}:{degree}]", bits - 1),
    }
}
