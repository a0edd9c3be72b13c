//! Which row a word belongs to, which memory counts, and which row is read.
//!
//! The row counter is a clock ahead of the row, which so goes to all memories from a register that
//! does nothing else. Code periods are counted up to the carry, from where that leaves the right
//! number of them: a carry costs no comparison. Both begin anew by a reset of their registers.
//!
//! Cost: a counter of rows and one of code periods, the row's way in registers; with two memories
//! one more counter of rows.

use super::bin_bank::row_bits;
use crate::rtl::front::prelude::*;
use crate::sensor::histogram::HistogramPlan;

/// Ports of the word's way.
const WORD: &str = "Row, memory and first code period of a word on its way";
/// Ports of the reader.
const READER: &str = "Reader";

#[block(histogram_control)]
/// rows and frames of the histogram
#[when(takes_turns)]
/// A frame ends with the last row of its last code period. If all rows of the frame before it have been
/// taken, or the last is taken at that clock's edge, the memories change places and it is read. If not it
/// is lost, whole, and counts begin anew in its memory.
#[when(!takes_turns)]
/// A frame ends with the last row of its last code period. Its rows come to the stream, one a clock, while
/// the next frame's first code period begins anew in the same bins. A row that comes while one waits is lost.
///
/// o_overrun stays high until reset.
#[when(detectors > 1)]
/// The rows of {detectors} detectors come one detector after the other.
///
/// - Frame: {histogram.periods} code periods of {histogram.rows} chips
/// - Latency: 5 clocks from a frame's last word to o_valid
pub struct HistogramControl {
    histogram: HistogramPlan,
    detectors: usize,
    #[set(u128::from(histogram.rows))]
    rows: u128,
    #[set(row_bits(histogram.rows))]
    row_bits: u32,
    #[set((u64::BITS - (histogram.periods - 1).leading_zeros()).max(1))]
    period_bits: u32,
    /// What code periods are counted from.
    #[set((1 << period_bits) - u128::from(histogram.periods))]
    first_period_value: u128,
    #[set(histogram.periods > 1)]
    has_periods: bool,
    #[set(histogram.takes_turns())]
    takes_turns: bool,
    /// Places on a row's way that have to know its detector.
    #[set(if detectors > 1 { 3 } else { 0 })]
    places_of_detectors: usize,
    /// the receiver takes a row
    pub i_ready: Input<bool>,
    /// words count from now on
    pub o_run: Output<bool>,
    /// row of the present word
    #[under(WORD)]
    #[width(row_bits)]
    pub o_row: Output<Word>,
    /// memory that counts it
    #[when(takes_turns)]
    pub o_half: Optional<Output<bool>>,
    /// the word two clocks ago is one of a frame's first code period
    #[when(!takes_turns)]
    pub o_come_first: Optional<Output<bool>>,
    /// memory of the word two clocks ago
    #[when(takes_turns)]
    pub o_come_half: Optional<Output<bool>>,
    /// the word three clocks ago is one of a frame's first code period
    pub o_held_first: Output<bool>,
    /// memory of the word three clocks ago
    #[when(takes_turns)]
    pub o_held_half: Optional<Output<bool>>,
    /// the word five clocks ago is one of a frame's first code period
    pub o_added_first: Output<bool>,
    /// row of the word six clocks ago
    #[width(row_bits)]
    pub o_write_row: Output<Word>,
    /// its memory
    #[when(takes_turns)]
    pub o_write_half: Optional<Output<bool>>,
    /// row to be read
    #[under(READER)]
    #[when(takes_turns)]
    #[width(row_bits)]
    pub o_read_row: Optional<Output<Word>>,
    /// detector of the row that comes to the stream, one bit for each
    #[when(detectors > 1)]
    #[width(detectors)]
    pub o_read_detector: Optional<Output<Word>>,
    /// it goes on
    #[when(takes_turns)]
    pub o_go: Optional<Output<bool>>,
    /// a row comes to the stream
    pub o_shows: Output<bool>,
    /// a row waits
    #[under("")]
    pub o_valid: Output<bool>,
    /// it is the frame's last
    pub o_last: Output<bool>,
    /// a {if takes_turns { "frame" } else { "row" }} was lost
    pub o_overrun: Output<bool>,
    /// the row before the last
    #[width(row_bits)]
    #[value(rows - 2)]
    #[number]
    last_row_but_one: Constant,
    /// the first code period of a frame, so that the last is all ones
    #[when(has_periods)]
    #[width(period_bits)]
    #[value(first_period_value)]
    #[number]
    first_period: Optional<Constant>,
    /// words come
    runs: Register<bool>,
    /// row of the next word
    #[width(row_bits)]
    ahead: Register<Word>,
    /// the next word's row is the last
    ahead_is_last: Register<bool>,
    /// row of the present word
    #[width(row_bits)]
    row: Register<Word>,
    /// the present word's row is the last
    row_is_last: Register<bool>,
    /// code period of the frame
    #[when(has_periods)]
    #[width(period_bits)]
    #[reset(first_period_value, first_period)]
    period: Optional<Register<Word>>,
    /// the next one, and above it whether the present one is all ones
    #[when(has_periods)]
    #[width(period_bits + 1)]
    next_period: Optional<Local<Word>>,
    /// the present code period is the frame's last
    #[when(has_periods)]
    period_is_last: Optional<Register<bool>>,
    /// the last row of a frame
    ends: Local<bool>,
    /// the first code period of a frame
    #[reset(true)]
    first: Register<bool>,
    /// memory that counts
    #[when(takes_turns)]
    half: Optional<Register<bool>>,
    /// rows of the words 1 to 6 clocks ago
    #[each(_clocks in 1..7)]
    #[width(row_bits)]
    row_before: Vec<Register<Word>>,
    /// memory of the words 1 to 6 clocks ago
    #[when(takes_turns)]
    #[width(6)]
    half_before: Optional<Register<Word>>,
    /// whether the words 1 to 5 clocks ago are of a first code period
    #[width(5)]
    #[reset(31)]
    first_before: Register<Word>,
    /// the reader goes on
    #[when(takes_turns)]
    goes: Optional<Local<bool>>,
    /// a row comes, and the stream takes it
    #[when(!takes_turns)]
    shows: Optional<Local<bool>>,
    /// a frame has been counted since reset
    #[when(!takes_turns)]
    follows: Optional<Register<bool>>,
    /// whether the words 1 to 3 clocks ago found the bins of a whole frame
    #[when(!takes_turns)]
    #[width(3)]
    whole_before: Optional<Register<Word>>,
    /// whether their rows are the last
    #[when(!takes_turns)]
    #[width(3)]
    last_before: Optional<Register<Word>>,
    /// a row of a whole frame comes out of the memory
    #[when(!takes_turns)]
    comes: Optional<Local<bool>>,
    /// rows of the frame before are still to be taken
    #[when(takes_turns)]
    busy: Optional<Local<bool>>,
    /// rows are read
    #[when(takes_turns)]
    reads: Optional<Register<bool>>,
    /// row that is read
    #[when(takes_turns)]
    #[width(row_bits)]
    read_row: Optional<Register<Word>>,
    /// the row that is read is the last
    #[when(takes_turns)]
    read_is_last: Optional<Register<bool>>,
    /// detector that is read, one bit for each
    #[when(detectors > 1)]
    #[width(detectors)]
    #[reset(1)]
    detector: Optional<Register<Word>>,
    #[each(place in 0..places_of_detectors)]
    #[about(match place {
        0 => "detector of the row that is in the memories",
        1 => "of the one that comes out of them",
        _ => "and of the one behind it",
    }.to_owned())]
    #[width(detectors)]
    detector_out: Vec<Register<Word>>,
    /// the last row of the last detector is read
    #[when(takes_turns)]
    read_ends: Optional<Local<bool>>,
    /// a row is in the memories, comes out of them, and is in the register behind them
    #[when(takes_turns)]
    #[width(3)]
    out: Optional<Register<Word>>,
    /// it is a frame's last
    #[when(takes_turns)]
    #[width(3)]
    last_out: Optional<Register<Word>>,
    valid: Register<bool>,
    /// none waits
    #[reset(true)]
    room: Register<bool>,
    last: Register<bool>,
    overrun: Register<bool>,
}

#[kernel]
impl Logic for HistogramControl {
    fn update(&mut self) {
        self.runs.next = true;
        self.o_run.next = self.runs.val();
        self.ahead_is_last.next = self.ahead.val() == self.last_row_but_one.val();
        if self.runs.val() {
            self.ahead.next = self.ahead.val() + 1;
        }
        if self.ahead_is_last.val() {
            self.ahead.next = bit_cast(false, self.row_bits as usize);
        }
        self.row.next = self.ahead.val();
        self.row_is_last.next = self.ahead_is_last.val();
        if self.has_periods {
            self.count_periods();
        } else {
            self.ends.next = self.row_is_last.val();
            self.first.next = true;
        }
        self.follow_words();
        if self.takes_turns {
            self.follow_memories();
            self.read_frames();
        } else {
            self.send_rows();
        }
        connect! { self: valid, last, overrun }
    }

    fn count_periods(&mut self) {
        self.ends.next = self.row_is_last.val() & self.period_is_last.val();
        let bits = self.period_bits as usize;
        self.next_period.next = bit_cast(self.period.val(), bits + 1) + 1;
        self.period_is_last.next = self.next_period.val().get_bit(bits);
        if self.row_is_last.val() {
            self.first.next = self.period_is_last.val();
            self.period.next = bit_cast(self.next_period.val(), bits);
        }
        if self.ends.val() {
            self.period.next = self.first_period.val();
        }
    }

    /// Row and first code period of the words on their way to the memories.
    fn follow_words(&mut self) {
        self.row_before[0].next = self.row.val();
        for c in 1..6 {
            self.row_before[c].next = self.row_before[c - 1].val();
        }
        self.first_before.next = self.first_before.val().shifted_in(self.first.val());
        self.o_row.next = self.row.val();
        self.o_held_first.next = self.first_before.val().get_bit(2);
        self.o_added_first.next = self.first_before.val().get_bit(4);
        self.o_write_row.next = self.row_before[5].val();
    }

    /// Their memory.
    fn follow_memories(&mut self) {
        self.half_before.next = self.half_before.val().shifted_in(self.half.val());
        self.o_half.next = self.half.val();
        self.o_come_half.next = self.half_before.val().get_bit(1);
        self.o_held_half.next = self.half_before.val().get_bit(2);
        self.o_write_half.next = self.half_before.val().get_bit(5);
    }

    /// Offers the rows that the next frame's first code period finds.
    fn send_rows(&mut self) {
        if self.ends.val() {
            self.follows.next = true;
        }
        self.whole_before.next =
            self.whole_before.val().shifted_in(self.follows.val() & self.first.val());
        self.last_before.next = self.last_before.val().shifted_in(self.row_is_last.val());
        self.o_come_first.next = self.first_before.val().get_bit(1);
        self.comes.next = self.whole_before.val().get_bit(2);
        // Two products in place of room or ready, and comes: a single table of three inputs stands
        // before the clock enables of a whole row, and none by the port of ready.
        self.shows.next =
            (self.room.val() & self.comes.val()) | (self.i_ready.val() & self.comes.val());
        if self.i_ready.val() {
            self.valid.next = false;
            self.room.next = true;
        }
        if self.comes.val() {
            self.valid.next = true;
            self.room.next = false;
        }
        if self.shows.val() {
            self.last.next = self.last_before.val().get_bit(2);
        }
        if self.comes.val() & !self.room.val() & !self.i_ready.val() {
            self.overrun.next = true;
        }
        self.o_shows.next = self.shows.val();
    }

    /// Reads the rows of a frame, and offers them.
    fn read_frames(&mut self) {
        self.goes.next = self.room.val() | self.i_ready.val();
        self.busy.next = self.reads.val() | self.out.val().any() | !self.goes.val();
        if self.detectors > 1 {
            self.name_detectors();
        } else {
            self.read_ends.next = self.read_is_last.val();
        }
        if self.goes.val() {
            self.out.next = self.out.val().shifted_in(self.reads.val());
            self.last_out.next = self.last_out.val().shifted_in(self.read_ends.val());
            self.valid.next = self.out.val().get_bit(2);
            self.room.next = !self.out.val().get_bit(2);
            if self.out.val().get_bit(2) {
                self.last.next = self.last_out.val().get_bit(2);
            }
            if self.reads.val() {
                self.read_is_last.next = self.read_row.val() == self.last_row_but_one.val();
                self.read_row.next = self.read_row.val() + 1;
                if self.read_is_last.val() {
                    self.read_row.next = bit_cast(false, self.row_bits as usize);
                }
                self.reads.next = !self.read_ends.val();
            }
        }
        if self.ends.val() & !self.busy.val() {
            self.half.next = !self.half.val();
            self.reads.next = true;
        }
        if self.ends.val() & self.busy.val() {
            self.overrun.next = true;
        }
        self.o_read_row.next = self.read_row.val();
        self.o_go.next = self.goes.val();
        self.o_shows.next = self.goes.val() & self.out.val().get_bit(2);
    }

    /// The detectors take turns, and each row has its detector beside it.
    fn name_detectors(&mut self) {
        let detectors = self.detectors;
        self.read_ends.next = self.read_is_last.val() & self.detector.val().get_bit(detectors - 1);
        if self.goes.val() {
            self.detector_out[0].next = self.detector.val();
            for c in 1..3 {
                self.detector_out[c].next = self.detector_out[c - 1].val();
            }
            if self.read_is_last.val() {
                self.detector.next = self.detector.val() << 1;
            }
            if self.read_ends.val() {
                self.detector.next = bit_cast(true, detectors);
            }
        }
        self.o_read_detector.next = self.detector_out[2].val();
    }
}
