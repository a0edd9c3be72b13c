//! Counts of a row of detectors, window by window in one memory.
//!
//! Cost (ECP5, 64 detectors, docs/pixels.md): 94 LUTs, 116 flip-flops, 2 block memories.

use crate::rtl::front::prelude::*;
use crate::sensor::rows::RowPlan;

/// Clocks from the row's first register to the count: out of the memory, growth, sum.
const STAGES: usize = 4;

#[block(row_sums)]
/// counts of a row of detectors, summed window by window
///
/// A detector's word has its count so far, and where its counter stood when it was last taken over. A
/// step's first window begins the count anew, and after reset all counters stood at 0: nothing in the
/// memory has to be cleared.
///
/// - Row: {plan.detectors} detectors
#[when(!is_cut)]
/// - Windows: 1 a phase step
#[when(is_cut)]
/// - Windows: {plan.windows} a phase step: one of {plan.first_chips} chips, then of {plan.window_chips}
///
/// - Latency: {STAGES} clocks from o_take to the first detector's count
pub struct RowSums {
    plan: RowPlan,
    /// Bits of a count.
    bits: u32,
    /// Clocks from the chip on o_run to the early dump.
    clocks_to_dump: u32,
    #[set(plan.piece_bits)]
    piece_bits: u32,
    #[set(plan.address_bits())]
    address_bits: u32,
    /// Whether a step has windows before its last.
    #[set(plan.windows > 1)]
    is_cut: bool,
    #[set(u64::BITS - (plan.first_chips.max(2) - 1).leading_zeros())]
    window_bits: u32,
    #[set((piece_bits + if is_cut { bits } else { 0 }) as usize)]
    word_bits: usize,
    /// the present chip belongs to a scan
    #[when(is_cut)]
    pub i_run: Optional<Input<bool>>,
    /// the counters have a step's last hits in the next clock
    pub i_dump: Input<bool>,
    /// the row takes the counters over
    pub o_take: Output<bool>,
    /// the row's first register
    #[width(piece_bits)]
    pub i_piece: Input<Word>,
    /// a step's count is there
    pub o_store: Output<bool>,
    /// of this detector
    #[width(address_bits)]
    pub o_place: Output<Word>,
    /// the count, signed
    #[width(bits)]
    pub o_count: Output<Word>,
    /// chips of a step's first window, less one
    #[when(is_cut)]
    #[width(window_bits)]
    #[value(u128::from(plan.first_chips - 1))]
    first_window: Optional<Constant>,
    /// of those that follow
    #[when(is_cut)]
    #[width(window_bits)]
    #[value(u128::from(plan.window_chips - 1))]
    window: Optional<Constant>,
    #[width(address_bits)]
    #[value(u128::from(plan.detectors - 1))]
    last_place: Constant,
    /// bit n: the chip n + 1 clocks ago belonged to a scan
    #[when(is_cut)]
    #[width(clocks_to_dump)]
    ran: Optional<Register<Word>>,
    /// chips until a window's last hits are in
    #[when(is_cut)]
    #[width(window_bits)]
    remaining: Optional<Register<Word>>,
    /// a window ends
    due: Local<bool>,
    /// the next window is a step's first
    #[when(is_cut)]
    #[reset(true)]
    opens: Optional<Register<bool>>,
    /// no counter was taken over since reset
    #[reset(true)]
    fresh: Register<bool>,
    /// the row takes over
    take: Register<bool>,
    /// that window was a step's first; then on the way to the memory's word
    #[each(_stage in 0..if is_cut { 3 } else { 0 })]
    first: Vec<Register<bool>>,
    /// it was the first since reset
    #[each(_stage in 0..3)]
    after_reset: Vec<Register<bool>>,
    /// it was a step's last; then on the way to the count
    #[each(_stage in 0..if is_cut { STAGES + 1 } else { 0 })]
    ends: Vec<Register<bool>>,
    /// detectors are on their way to the memory
    moves: Register<bool>,
    /// one is
    moves_on: Local<bool>,
    /// bit n: one was n + 1 clocks ago
    #[width(STAGES)]
    moved: Register<Word>,
    /// whose word is read
    #[width(address_bits)]
    read_place: Register<Word>,
    /// whose word is written
    #[width(address_bits)]
    place: Register<Word>,
    #[is(Memory::new(plan.detectors, word_bits as u32, "the count of each detector, and where its counter stood"))]
    memory: Memory,
    /// where the detector's counter stands
    #[each(_stage in 0..3)]
    #[width(piece_bits)]
    piece: Vec<Register<Word>>,
    /// where it stood before
    #[width(piece_bits)]
    stood: Local<Word>,
    /// what it has grown by, signed
    #[width(piece_bits)]
    growth: Register<Word>,
    /// the count before this window
    #[when(is_cut)]
    #[width(bits)]
    base: Optional<Register<Word>>,
    /// the count, signed
    #[width(bits)]
    count: Register<Word>,
}

#[kernel]
impl Logic for RowSums {
    fn update(&mut self) {
        if self.is_cut {
            self.cut_step();
        } else {
            self.due.next = self.i_dump.val();
        }
        self.take.next = self.due.val();
        connect! { self: take }
        if self.due.val() {
            self.fresh.next = false;
            self.after_reset[0].next = self.fresh.val();
        }
        for stage in 1..self.after_reset.len() {
            self.after_reset[stage].next = self.after_reset[stage - 1].val();
        }
        self.pass_row();
        self.add_growth();
    }

    /// The last window of a step ends with it, since its first takes what it has beyond whole ones.
    fn cut_step(&mut self) {
        let ahead = self.clocks_to_dump as usize - 1;
        self.ran.next = self.ran.val().shifted_in(self.i_run.val());
        self.remaining.next = self.remaining.val() - 1;
        self.due.next = self.ran.val().get_bit(ahead) & !self.remaining.val().any();
        if self.due.val() {
            self.remaining.next = self.window.val();
        }
        if self.i_dump.val() | !self.ran.val().get_bit(ahead) {
            self.remaining.next = self.first_window.val();
        }
        if self.due.val() {
            self.opens.next = self.i_dump.val();
            self.first[0].next = self.opens.val();
            self.ends[0].next = self.i_dump.val();
        }
        for stage in 1..self.first.len() {
            self.first[stage].next = self.first[stage - 1].val();
        }
        for stage in 1..self.ends.len() {
            self.ends[stage].next = self.ends[stage - 1].val();
        }
    }

    /// One detector a clock to the memory, and back.
    fn pass_row(&mut self) {
        let bits = self.address_bits as usize;
        self.moves_on.next = self.take.val() | self.moves.val();
        self.moves.next = self.moves_on.val();
        if self.moves_on.val() {
            self.read_place.next = self.read_place.val() + 1;
            if self.read_place.val() == self.last_place.val() {
                self.read_place.next = bit_cast(false, bits);
                self.moves.next = false;
            }
        }
        self.moved.next = self.moved.val().shifted_in(self.moves_on.val());
        if self.moved.val().get_bit(STAGES - 1) {
            self.place.next = self.place.val() + 1;
            if self.place.val() == self.last_place.val() {
                self.place.next = bit_cast(false, bits);
            }
        }
        self.memory.i_read.next = true;
        self.memory.i_address.next = self.read_place.val();
        self.memory.i_write.next = self.moved.val().get_bit(STAGES - 1);
        self.memory.i_write_address.next = self.place.val();
        connect! { self: place }
    }

    fn add_growth(&mut self) {
        let piece_bits = self.piece_bits as usize;
        let bits = self.bits as usize;
        self.piece[0].next = self.i_piece.val();
        for stage in 1..self.piece.len() {
            self.piece[stage].next = self.piece[stage - 1].val();
        }
        self.stood.next = self.memory.o_word.val().slice(0, piece_bits);
        if self.after_reset[2].val() {
            self.stood.next = bit_cast(false, piece_bits);
        }
        self.growth.next = self.piece[0].val() - self.stood.val();
        connect! { self: count }
        if self.is_cut {
            self.base.next = self.memory.o_word.val().slice(piece_bits, bits);
            if self.first[2].val() {
                self.base.next = bit_cast(false, bits);
            }
            self.count.next = self.base.val() + signed_cast(self.growth.val());
            self.memory.i_data.next = bit_cast(self.piece[2].val(), self.word_bits)
                | (bit_cast(self.count.val(), self.word_bits) << piece_bits);
            self.o_store.next = self.moved.val().get_bit(STAGES - 1) & self.ends[STAGES].val();
        } else {
            self.count.next = bit_cast(signed_cast(self.growth.val()), bits);
            self.memory.i_data.next = self.piece[2].val();
            self.o_store.next = self.moved.val().get_bit(STAGES - 1);
        }
    }
}
