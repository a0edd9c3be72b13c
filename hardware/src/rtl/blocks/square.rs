//! The square wave: chips 1, 0.
//!
//! | port | |
//! |---|---|
//! | [`CodePorts`] | as every source of chips |
//!
//! Latency 0 clocks from the register to `o_chip`. One register that toggles takes the place of
//! a counter and a table.
//!
//! Cost (ECP5, docs/resources.md): 12 LUTs, 56 flip-flops less than Gold codes.

use super::CodePorts;
use crate::rtl::front::prelude::*;

/// A toggle.
#[block(SquarePlan)]
pub struct SquareGenerator {
    /// ports
    #[is(CodePorts::new(plan.reloads))]
    pub io: CodePorts,
    #[is(describe())]
    about: About,
    /// that reset gives
    #[width(1)]
    #[value(plan.load)]
    chip_load: Constant,
    #[width(1)]
    #[reset(plan.load, chip_load)]
    chip: Register<Word>,
}

struct SquarePlan {
    load: u128,
    reloads: bool,
}

impl SquareGenerator {
    /// The wave starting at its chip `start`, 0 or 1; chip 0 is high.
    pub fn new(start: u64, reloads: bool) -> SquareGenerator {
        SquareGenerator::build(&SquarePlan { load: u128::from(start.is_multiple_of(2)), reloads })
    }
}

fn describe() -> About {
    About::new("square_generator", "square wave, chips 1, 0")
        .fact("Period", "2 chips")
        .fact("Latency", "0 clocks from register to o_chip")
}

#[kernel]
impl Logic for SquareGenerator {
    fn update(&mut self) {
        self.io.o_chip.next = self.chip.q.val().get_bit(0);
        self.io.o_epoch.next = self.chip.q.val() == self.chip_load.val();
        if self.io.i_advance.val() {
            self.chip.d.next = !self.chip.q.val();
        }
        if self.io.i_load.is_present() {
            if self.io.i_load.val() {
                self.chip.d.next = self.chip_load.val();
            }
        }
    }
}
