//! The bins of one sample of the chip: two memories that take turns.
//!
//! | port | |
//! |---|---|
//! | `i_row`, `i_half`, `i_first` | row to be counted, memory that counts, first code period |
//! | `i_read_row`, `i_go` | row to be read from the other memory; the reader goes on |
//! | `i_hit`, `i_bin`, `i_write_row`, `i_write_half` | what comes back, four and five clocks later |
//! | `o_counted`, `o_read` | the bin that counts, two clocks after its row; the bin that is read |
//!
//! A bin is read, and written five clocks after that; its row comes round after a code period, so
//! that nothing has to be handed forward. In the first code period every bin is written: what the
//! memory held before is of no consequence, and nothing has to be cleared.
//!
//! Cost: two memories, 3 registers as wide as a bin, a multiplexer for each bit of `o_counted` and
//! `o_read`.

use crate::rtl::front::prelude::*;

/// Ports of its rows.
const ROWS: &str = "Rows";
/// Ports of what comes back.
const BACK: &str = "What is written";

/// One bin of each row, in two memories.
#[block(BankPlan)]
pub struct BinBank {
    /// one word per cycle
    pub i_clk: Input<bool>,
    /// synchronous, active high
    pub i_rst: Input<bool>,
    /// row of the present word
    #[under(ROWS)]
    #[width(plan.row_bits())]
    pub i_row: Input<Word>,
    /// memory that counts the present word
    #[under(ROWS)]
    pub i_half: Input<bool>,
    /// row to be read from the other memory
    #[under(ROWS)]
    #[width(plan.row_bits())]
    pub i_read_row: Input<Word>,
    /// the reader goes on
    #[under(ROWS)]
    pub i_go: Input<bool>,
    /// memory of the word that reaches o_counted
    #[under(ROWS)]
    pub i_counted_half: Input<bool>,
    /// the word has its hit here
    #[under(BACK)]
    pub i_hit: Input<bool>,
    /// it is one of a frame's first code period
    #[under(BACK)]
    pub i_first: Input<bool>,
    /// the bin with its hit
    #[under(BACK)]
    #[width(plan.bits)]
    pub i_bin: Input<Word>,
    /// its row, a clock later
    #[under(BACK)]
    #[width(plan.row_bits())]
    pub i_write_row: Input<Word>,
    /// its memory, a clock later
    #[under(BACK)]
    pub i_write_half: Input<bool>,
    /// bin of the row that was counted
    #[width(plan.bits)]
    pub o_counted: Output<Word>,
    /// bin of the row that was read
    #[width(plan.bits)]
    pub o_read: Output<Word>,
    #[is(describe(plan))]
    about: About,
    /// memories that go on: the one that counts, and the other with its reader
    #[width(2)]
    goes: Wiring,
    #[each(half in 0..2)]
    #[is(Memory::new(plan.rows, plan.bits, &format!("Bins of memory {half}, one for each row")))]
    bins: Vec<Memory>,
    #[each(half in 0..2)]
    #[about(format!("bin out of memory {half}"))]
    #[width(plan.bits)]
    held: Vec<Register<Word>>,
    /// to be written
    writes: Register<bool>,
    /// what is written
    #[width(plan.bits)]
    written: Register<Word>,
    plan: Plan<BankPlan>,
}

#[derive(Debug, Clone, Copy)]
struct BankPlan {
    rows: u64,
    bits: u32,
}

impl BankPlan {
    fn row_bits(&self) -> u32 {
        row_bits(self.rows)
    }
}

/// Bits of the number of one of so many rows.
pub(super) fn row_bits(rows: u64) -> u32 {
    u64::BITS - (rows - 1).leading_zeros()
}

impl BinBank {
    /// For so many rows of bins of `bits` bits.
    pub fn new(rows: u64, bits: u32) -> BinBank {
        BinBank::build(&BankPlan { rows, bits })
    }
}

fn describe(plan: &BankPlan) -> About {
    About::new("bin_bank", "a histogram's bins of one sample of the chip, twice")
        .note(
            "One memory counts while the other is read. A word's bin is read, goes to the adder that \
             neighbouring samples share, and is written when it comes back. In a frame's first code \
             period every bin is written, 0 where there was no hit, so that counts begin anew.",
        )
        .fact("Memory", format!("2 x {} bins of {} bits", plan.rows, plan.bits))
        .fact(
            "Latency",
            "2 clocks from i_row to o_counted and from i_read_row to o_read; written 6 clocks after i_row",
        )
}

#[kernel]
impl Logic for BinBank {
    fn update(&mut self) {
        dff_setup!(self, i_clk, writes, written);
        self.goes.i[0].next = self.i_go.val() | !self.i_half.val();
        self.goes.i[1].next = self.i_go.val() | self.i_half.val();
        self.writes.d.next = self.i_hit.val() | self.i_first.val();
        if self.i_hit.val() {
            self.written.d.next = self.i_bin.val();
        } else {
            self.written.d.next = bit_cast(false, self.plan.bits as usize);
        }
        for h in 0..2 {
            dff_setup!(self, i_clk, held[h]);
            self.bins[h].clock.next = self.i_clk.val();
            self.bins[h].read.next = self.goes.o.val().get_bit(h);
            self.bins[h].data.next = self.written.q.val();
            self.bins[h].write_address.next = self.i_write_row.val();
            if self.goes.o.val().get_bit(h) {
                self.held[h].d.next = self.bins[h].q.val();
            }
        }
        self.bins[0].write.next = self.writes.q.val() & !self.i_write_half.val();
        self.bins[1].write.next = self.writes.q.val() & self.i_write_half.val();
        if self.i_half.val() {
            self.bins[0].address.next = self.i_read_row.val();
            self.bins[1].address.next = self.i_row.val();
        } else {
            self.bins[0].address.next = self.i_row.val();
            self.bins[1].address.next = self.i_read_row.val();
        }
        if self.i_counted_half.val() {
            self.o_counted.next = self.held[1].q.val();
        } else {
            self.o_counted.next = self.held[0].q.val();
        }
        if self.i_half.val() {
            self.o_read.next = self.held[0].q.val();
        } else {
            self.o_read.next = self.held[1].q.val();
        }
    }
}
