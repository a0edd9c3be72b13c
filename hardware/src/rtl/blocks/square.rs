//! The square wave, chips 1 and 0: one register that toggles, in place of a counter and a table.
//!
//! Cost (ECP5, docs/resources.md): 12 LUTs, 56 flip-flops less than Gold codes.

use super::CodePorts;
use crate::rtl::front::prelude::*;

#[block(square_generator)]
/// square wave, chips 1, 0
///
/// - Period: 2 chips
/// - Latency: 0 clocks from register to o_chip
pub struct SquareGenerator {
    /// Its first chip, 0 or 1; chip 0 is high.
    start: u64,
    reloads: bool,
    #[set(u128::from(start.is_multiple_of(2)))]
    load: u128,
    /// ports
    #[is(CodePorts::new(reloads, None))]
    pub io: CodePorts,
    /// that reset gives
    #[width(1)]
    #[value(load)]
    chip_load: Constant,
    #[width(1)]
    #[reset(load, chip_load)]
    chip: Register<Word>,
}

#[kernel]
impl Logic for SquareGenerator {
    fn update(&mut self) {
        self.io.o_chip.next = self.chip.val().get_bit(0);
        self.io.o_epoch.next = self.chip.val() == self.chip_load.val();
        if self.io.i_advance.val() {
            self.chip.next = !self.chip.val();
        }
        if self.io.i_load.is_present() && self.io.i_load.val() {
            self.chip.next = self.chip_load.val();
        }
    }
}
