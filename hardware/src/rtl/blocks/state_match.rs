//! Recognises a counter's state in pieces.
//!
//! A register behind each piece keeps a wide comparison at two levels of logic.
//!
//! Cost (ECP5, docs/resources.md): 20 LUTs, 2 flip-flops for 14 bits.

use crate::rtl::front::prelude::*;

/// Bits that are compared in one piece.
const PIECE_BITS: usize = 8;

#[block(state_match)]
/// recognises a state of a counter
///
/// The pieces of a wide comparison have a register each.
///
/// - Latency: 1 clock
pub struct StateMatch {
    // A single bit is compared by its gate alone, without an AND of all.
    /// bits of a state
    #[size((PIECE_BITS * (pieces - 1) + 1).max(2)..=PIECE_BITS * pieces)]
    width: usize,
    #[set(width.div_ceil(PIECE_BITS))]
    pieces: usize,
    /// state of a counter
    #[width(width)]
    pub i_state: Input<Word>,
    /// the state that is waited for
    #[width(width)]
    pub i_wanted: Input<Word>,
    /// they were equal one clock ago
    pub o_matched: Output<bool>,
    #[width(width)]
    equal: Local<Word>,
    #[width(pieces)]
    all_equal: Local<Word>,
    /// one bit for each piece
    #[width(pieces)]
    matched: Register<Word>,
}

impl StateMatch {
    /// Widest state for which comparing at once keeps the clock.
    pub const WIDEST_AT_ONCE: u32 = 12;
}

#[kernel]
impl Logic for StateMatch {
    fn update(&mut self) {
        self.equal.next = !(self.i_state.val() ^ self.i_wanted.val());
        self.all_equal.next = gather(self.pieces, |piece| {
            self.equal
                .val()
                .slice(PIECE_BITS * piece, PIECE_BITS.min(self.width - PIECE_BITS * piece))
                .all()
        });
        self.matched.next = self.all_equal.val();
        self.o_matched.next = self.matched.val().all();
    }
}
