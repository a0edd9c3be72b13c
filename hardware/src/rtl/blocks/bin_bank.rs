//! The bins of one sample of the chip: a memory, or two that take turns.
//!
//! A bin is read, and written six clocks after that; its row comes round after a code period, so
//! that nothing has to be handed forward. In the first code period every bin is written: what the
//! memory held before is of no consequence, and nothing has to be cleared. Of the bin that
//! comes back only the lowest bit is this bank's own: in the first code period the bin
//! with a hit is 1 and the others are 0, and later no others are written.
//!
//! A bin that counts, and has no hit, is 0 at the output: banks of which one has the hit are joined by
//! an OR. Bins of the first code period leave a single memory as they are.
//!
//! Cost: for each memory a register as wide as a bin, in which the choice costs nothing, since
//! registers can be cleared; of two, a multiplexer for each bit of `o_read`.

use crate::rtl::front::prelude::*;

/// Ports of its rows.
const ROWS: &str = "Rows";
/// Ports of what comes back.
const BACK: &str = "What is written";

/// One bin of each row, in two memories.
#[block(describe(rows, bits, takes_turns))]
pub struct BinBank {
    rows: u64,
    bits: u32,
    /// Whether there are two memories.
    takes_turns: bool,
    #[set(row_bits(rows))]
    row_bits: u32,
    #[set(1 + usize::from(takes_turns))]
    memories: usize,
    /// row of the present word
    #[under(ROWS)]
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
    /// the word two clocks ago has its hit here
    pub i_come_hit: Input<bool>,
    /// it is one of a frame's first code period
    #[when(!takes_turns)]
    pub i_come_first: Optional<Input<bool>>,
    /// its memory
    #[when(takes_turns)]
    pub i_come_half: Optional<Input<bool>>,
    /// the word has its hit here
    #[under(BACK)]
    pub i_hit: Input<bool>,
    /// it is one of a frame's first code period
    pub i_first: Input<bool>,
    /// lowest bit of the bin with its hit
    pub i_lowest: Input<bool>,
    /// the bits above it, a clock later
    #[when(bits > 1)]
    #[width(bits - 1)]
    pub i_above: Optional<Input<Word>>,
    /// its row, a clock later
    #[width(row_bits)]
    pub i_write_row: Input<Word>,
    /// its memory, a clock later
    #[when(takes_turns)]
    pub i_write_half: Optional<Input<bool>>,
    #[under("")]
    #[about(match takes_turns {
        true => "bin out of memory 0; 0 if it counts and has no hit",
        false => "bin out of the memory; 0 without a hit, but for a first code period",
    }.to_owned())]
    #[width(bits)]
    pub o_bin: Output<Word>,
    /// bin out of memory 1, as well
    #[when(takes_turns)]
    #[width(bits)]
    pub o_other: Optional<Output<Word>>,
    /// bin of the row that was read
    #[when(takes_turns)]
    #[width(bits)]
    pub o_read: Optional<Output<Word>>,
    /// memories that go on: the one that counts, and the other with its reader
    #[when(takes_turns)]
    #[width(2)]
    goes: Optional<Local<Word>>,
    #[each(_half in 0..memories)]
    #[is(Memory::new(rows, bits, "bins, one for each row"))]
    memory: Vec<Memory>,
    #[each(half in 0..memories)]
    #[about(match takes_turns {
        true => format!("bin out of memory {half}"),
        false => "bin out of the memory".to_owned(),
    })]
    #[width(bits)]
    held: Vec<Register<Word>>,
    /// to be written
    writes: Register<bool>,
    /// lowest bit of what is written
    lowest: Register<bool>,
    /// what is written
    #[width(bits)]
    written: Local<Word>,
}

/// Bits of the number of one of so many rows.
pub(super) fn row_bits(rows: u64) -> u32 {
    u64::BITS - (rows - 1).leading_zeros()
}

fn describe(rows: u64, bits: u32, takes_turns: bool) -> About {
    let title = "a histogram's bins of one sample of the chip";
    let back = "A word's bin is read, goes to the adder that neighbouring samples share, and is \
                written when it comes back. In a frame's first code period every bin is written, 0 \
                where there was no hit, so that counts begin anew.";
    if !takes_turns {
        return About::new("bin_bank", title)
            .note(back)
            .fact("Memory", format!("{rows} bins of {bits} bit{}", plural(bits)))
            .fact("Latency", "3 clocks from i_row to o_bin; written 7 clocks after i_row");
    }
    About::new("bin_bank", format!("{title}, twice"))
        .note(format!("One memory counts while the other is read. {back}"))
        .fact("Memory", format!("2 x {rows} bins of {bits} bits"))
        .fact(
            "Latency",
            "3 clocks from i_row to o_bin or o_other, and from i_read_row to o_read; written 7 clocks \
             after i_row",
        )
}

pub(super) fn plural(number: u32) -> &'static str {
    if number == 1 { "" } else { "s" }
}

#[kernel]
impl Logic for BinBank {
    fn update(&mut self) {
        self.writes.next = self.i_hit.val() | self.i_first.val();
        // A bin without a hit is written in a first code period only, in which a hit's is 1.
        self.lowest.next = self.i_hit.val();
        if !self.i_lowest.val() {
            self.lowest.next = false;
        }
        self.written.next = gather(self.bits as usize, |b| {
            if b == 0 { self.lowest.val() } else { self.i_above.val().get_bit(b - 1) }
        });
        for h in 0..self.memory.len() {
            self.memory[h].i_data.next = self.written.val();
            self.memory[h].i_write_address.next = self.i_write_row.val();
        }
        if self.takes_turns {
            self.take_turns();
        } else {
            self.count();
        }
    }

    /// One memory, whose bins are read where they count.
    fn count(&mut self) {
        self.memory[0].i_read.next = true;
        self.memory[0].i_write.next = self.writes.val();
        self.memory[0].i_address.next = self.i_row.val();
        self.held[0].next = self.memory[0].o_word.val();
        if !self.i_come_hit.val() & !self.i_come_first.val() {
            self.held[0].next = bit_cast(false, self.bits as usize);
        }
        self.o_bin.next = self.held[0].val();
    }

    /// One memory counts, the other is read.
    fn take_turns(&mut self) {
        self.goes.next = gather(2, |h| {
            if h == 0 {
                self.i_go.val() | !self.i_half.val()
            } else {
                self.i_go.val() | self.i_half.val()
            }
        });
        for h in 0..2 {
            self.memory[h].i_read.next = self.goes.val().get_bit(h);
            if self.goes.val().get_bit(h) {
                self.held[h].next = self.memory[h].o_word.val();
            }
        }
        // One condition each: of one within another Yosys makes three LUTs for each bit in
        // place of a register's reset.
        if !self.i_come_hit.val() & !self.i_come_half.val() {
            self.held[0].next = bit_cast(false, self.bits as usize);
        }
        if !self.i_come_hit.val() & self.i_come_half.val() {
            self.held[1].next = bit_cast(false, self.bits as usize);
        }
        self.memory[0].i_write.next = self.writes.val() & !self.i_write_half.val();
        self.memory[1].i_write.next = self.writes.val() & self.i_write_half.val();
        if self.i_half.val() {
            self.memory[0].i_address.next = self.i_read_row.val();
            self.memory[1].i_address.next = self.i_row.val();
        } else {
            self.memory[0].i_address.next = self.i_row.val();
            self.memory[1].i_address.next = self.i_read_row.val();
        }
        self.o_bin.next = self.held[0].val();
        self.o_other.next = self.held[1].val();
        if self.i_half.val() {
            self.o_read.next = self.held[0].val();
        } else {
            self.o_read.next = self.held[1].val();
        }
    }
}
