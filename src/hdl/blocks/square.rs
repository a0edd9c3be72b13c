//! The square wave: chips 1, 0.

use super::CodePorts;
use crate::hdl::front::prelude::*;

/// A toggle.
#[derive(Debug, Clone, LogicBlock)]
pub struct SquareGenerator {
    /// Ports.
    pub io: CodePorts,
    about: About,
    chip_load: Constant,
    chip: Register<Word>,
}

impl SquareGenerator {
    /// The wave starting at its chip `start`, 0 or 1; chip 0 is high.
    pub fn new(start: u64, reloads: bool) -> SquareGenerator {
        let load = u128::from(start.is_multiple_of(2));
        SquareGenerator {
            io: CodePorts::new(reloads),
            about: About::new("square_generator", "square wave, chips 1, 0")
                .fact("Period", "2 chips")
                .fact("Latency", "0 clocks from register to o_chip")
                .fact("Rate", "one chip per clock with i_advance high"),
            chip_load: Constant::new(load, 1, "Chip that reset gives"),
            chip: Register::word(1, load, "present chip").reset_to("chip_load"),
        }
    }
}

impl Logic for SquareGenerator {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, io.i_clk, chip);
        self.io.o_chip.next = self.chip.q.val().get_bit(0);
        self.io.o_epoch.next = self.chip.q.val() == self.chip_load.val();
        if self.io.i_advance.val() {
            self.chip.d.next = !self.chip.q.val();
        }
        for _load in 0..self.io.i_load.count() {
            if self.io.i_load[0].val() {
                self.chip.d.next = self.chip_load.val();
            }
        }
    }
}
