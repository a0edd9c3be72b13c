//! Codes given chip by chip.
//!
//! | port | |
//! |---|---|
//! | [`CodePorts`] | as every source of chips |
//!
//! Latency 0 clocks from the register to `o_chip`. The table is read without a clock, so that
//! it becomes lookup tables and no memory has to be initialised.

use super::CodePorts;
use crate::rtl::front::prelude::*;

/// An index counter and a constant table.
#[block(TablePlan)]
pub struct ChipTableGenerator {
    /// ports
    #[is(CodePorts::new(plan.reloads))]
    pub io: CodePorts,
    #[is(describe(plan))]
    about: About,
    /// that reset gives
    #[width(plan.index_bits())]
    #[value(plan.load)]
    #[number]
    index_load: Constant,
    #[width(plan.index_bits())]
    #[value(plan.last())]
    #[number]
    last_index: Constant,
    /// index of the present chip
    #[width(plan.index_bits())]
    #[reset(plan.load, index_load)]
    index: Register<Word>,
    #[is(BitTable::new(plan.chips.clone(), plan.index_bits(), "Chips of one period"))]
    chips: BitTable,
}

struct TablePlan {
    chips: Vec<u8>,
    load: u128,
    reloads: bool,
}

impl TablePlan {
    fn last(&self) -> u128 {
        self.chips.len() as u128 - 1
    }

    fn index_bits(&self) -> u32 {
        (u128::BITS - self.last().leading_zeros()).max(1)
    }
}

impl ChipTableGenerator {
    /// The code of `chips`, starting at chip `start`.
    pub fn new(chips: &[u8], start: u64, reloads: bool) -> ChipTableGenerator {
        ChipTableGenerator::build(&TablePlan {
            chips: chips.to_vec(),
            load: u128::from(start),
            reloads,
        })
    }
}

fn describe(plan: &TablePlan) -> About {
    About::new("chip_table_generator", "code given chip by chip")
        .fact("Period", format!("{} chips", plan.chips.len()))
        .fact("Latency", "0 clocks from register to o_chip")
}

#[kernel]
impl Logic for ChipTableGenerator {
    fn update(&mut self) {
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
        if self.io.i_load.is_present() {
            if self.io.i_load.val() {
                self.index.d.next = self.index_load.val();
            }
        }
    }
}
