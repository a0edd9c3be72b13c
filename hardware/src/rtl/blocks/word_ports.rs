//! What the bins of a histogram are told of a word on its way to them.

use super::bin_bank::row_bits;
use crate::rtl::front::prelude::*;
use crate::sensor::histogram::HistogramPlan;

/// Row, memory and first code period of a word, and what is read meanwhile.
#[block]
pub struct WordPorts {
    plan: HistogramPlan,
    #[set(plan.takes_turns())]
    takes_turns: bool,
    #[set(row_bits(plan.rows))]
    row_bits: u32,
    /// row of the present word
    #[width(row_bits)]
    pub i_row: Input<Word>,
    /// memory that counts the present word
    #[when(takes_turns)]
    pub i_half: Optional<Input<bool>>,
    /// row to be read from the other memory
    #[when(takes_turns)]
    #[width(row_bits)]
    pub i_read_row: Optional<Input<Word>>,
    /// the reader goes on
    #[when(takes_turns)]
    pub i_go: Optional<Input<bool>>,
    /// the word two clocks ago is one of a frame's first code period
    #[when(!takes_turns)]
    pub i_come_first: Optional<Input<bool>>,
    /// memory of the word two clocks ago
    #[when(takes_turns)]
    pub i_come_half: Optional<Input<bool>>,
    /// the word three clocks ago is one of a frame's first code period
    pub i_held_first: Input<bool>,
    /// memory of the word three clocks ago
    #[when(takes_turns)]
    pub i_held_half: Optional<Input<bool>>,
    /// the word five clocks ago is one of a frame's first code period
    pub i_added_first: Input<bool>,
    /// row of the word six clocks ago
    #[width(row_bits)]
    pub i_write_row: Input<Word>,
    /// its memory
    #[when(takes_turns)]
    pub i_write_half: Optional<Input<bool>>,
}
