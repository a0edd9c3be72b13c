//! Codes given chip by chip.
//!
//! The table is read without a clock, so that it becomes lookup tables and no memory has to be initialised.

use super::CodePorts;
use crate::rtl::front::prelude::*;

#[block(chip_table_generator)]
/// code given chip by chip
///
/// - Period: {table.len()} chips
/// - Latency: 0 clocks from register to o_chip
pub struct ChipTableGenerator {
    table: Vec<u8>,
    start: u64,
    reloads: bool,
    #[set(u128::from(start))]
    load: u128,
    #[set(table.len() as u128 - 1)]
    last: u128,
    #[set((u128::BITS - last.leading_zeros()).max(1))]
    index_bits: u32,
    /// ports
    #[is(CodePorts::new(reloads, None))]
    pub io: CodePorts,
    /// that reset gives
    #[width(index_bits)]
    #[value(load)]
    #[number]
    index_load: Constant,
    #[width(index_bits)]
    #[value(last)]
    #[number]
    last_index: Constant,
    /// index of the present chip
    #[width(index_bits)]
    #[reset(load, index_load)]
    index: Register<Word>,
    #[is(BitTable::new(table.clone(), index_bits, "Chips of one period"))]
    chips: BitTable,
}

#[kernel]
impl Logic for ChipTableGenerator {
    fn update(&mut self) {
        self.chips.address.next = self.index.val();
        self.io.o_chip.next = self.chips.data.val();
        self.io.o_epoch.next = self.index.val() == self.index_load.val();
        if self.io.i_advance.val() {
            if self.index.val() == self.last_index.val() {
                self.index.next = 0.into();
            } else {
                self.index.next = self.index.val() + 1;
            }
        }
        if self.io.i_load.is_present() && self.io.i_load.val() {
            self.index.next = self.index_load.val();
        }
    }
}
