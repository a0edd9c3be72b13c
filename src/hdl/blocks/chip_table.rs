//! Codes given chip by chip.

use super::CodePorts;
use crate::hdl::front::prelude::*;

/// An index counter and a constant table.
#[derive(Debug, Clone, LogicBlock)]
pub struct ChipTableGenerator {
    /// Ports.
    pub io: CodePorts,
    about: About,
    index_load: Constant,
    last_index: Constant,
    index: Register<Word>,
    chips: BitTable,
}

impl ChipTableGenerator {
    /// The code of `chips`, starting at chip `start`.
    pub fn new(chips: &[u8], start: u64, reloads: bool) -> ChipTableGenerator {
        let last = chips.len() as u128 - 1;
        let width = (128 - last.leading_zeros()).max(1);
        let load = u128::from(start);
        ChipTableGenerator {
            io: CodePorts::new(reloads),
            about: About::new("chip_table_generator", "code given chip by chip")
                .fact("Period", format!("{} chips", chips.len()))
                .fact("Latency", "0 clocks from register to o_chip")
                .fact("Rate", "one chip per clock with i_advance high"),
            index_load: Constant::new(load, width, "Index of the chip that reset gives"),
            last_index: Constant::new(last, width, "Index of the last chip"),
            index: Register::word(width, load, "index of the present chip").reset_to("index_load"),
            chips: BitTable::new(chips.to_vec(), width, "Chips of one period"),
        }
    }
}

impl Logic for ChipTableGenerator {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, io.i_clk, index);
        self.chips.address.next = self.index.q.val();
        self.io.o_chip.next = self.chips.data.val();
        self.io.o_epoch.next = self.index.q.val() == self.index_load.val();
        if self.io.i_advance.val() {
            if self.index.q.val() == self.last_index.val() {
                self.index.d.next = 0.into();
            } else {
                self.index.d.next = self.index.q.val() + 1;
            }
        }
        for _load in 0..self.io.i_load.count() {
            if self.io.i_load[0].val() {
                self.index.d.next = self.index_load.val();
            }
        }
    }
}
