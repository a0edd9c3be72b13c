//! Recognises a counter's state in pieces.

use crate::hdl::front::prelude::*;

/// Bits that are compared in one piece.
const PIECE_BITS: u32 = 8;

/// Compares a state with the one that is waited for.
#[derive(Debug, Clone, LogicBlock)]
pub struct StateMatch {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// The state.
    pub i_state: Input<Word>,
    /// The state that is waited for.
    pub i_wanted: Input<Word>,
    /// Whether they were equal one clock ago.
    pub o_matched: Output<bool>,
    about: About,
    equal: Local<Word>,
    piece: Vec<Wiring>,
    all_equal: Wiring,
    matched: Register<Word>,
    _pieces: usize,
    _piece_bits: usize,
    _whole_pieces: usize,
    _rest_bits: usize,
}

impl StateMatch {
    /// Widest state for which comparing at once keeps the clock.
    pub const WIDEST_AT_ONCE: u32 = 12;

    /// For states of `width` bits.
    pub fn new(width: u32) -> StateMatch {
        let pieces = width.div_ceil(PIECE_BITS) as usize;
        let bits_of = |piece: u32| PIECE_BITS.min(width - piece * PIECE_BITS) as usize;
        StateMatch {
            i_clk: Input::bit("one state per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_state: Input::word(width, "state of a counter"),
            i_wanted: Input::word(width, "the state that is waited for"),
            o_matched: Output::bit("they were equal one clock ago"),
            about: About::new("state_match", "recognises a state of a counter")
                .note("The pieces of a wide comparison have a register each.")
                .fact("Latency", "1 clock")
                .fact("Rate", "one state per clock"),
            equal: Local::word(width, "bits that are equal"),
            piece: (0..pieces as u32)
                .map(|piece| {
                    let bits = bits_of(piece);
                    Wiring::new(bits, (0..bits).collect(), "bits of a piece")
                })
                .collect(),
            all_equal: Wiring::new(pieces, (0..pieces).collect(), "pieces that are equal"),
            matched: Register::word(pieces as u32, 0, "pieces that were equal"),
            _pieces: pieces,
            _piece_bits: PIECE_BITS as usize,
            _whole_pieces: (width / PIECE_BITS) as usize,
            _rest_bits: (width % PIECE_BITS) as usize,
        }
    }
}

impl Logic for StateMatch {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, matched);
        self.equal.next = !(self.i_state.val() ^ self.i_wanted.val());
        for size in self._piece_bits..(self._piece_bits + 1) {
            for p in 0..self._whole_pieces {
                for b in 0..self._piece_bits {
                    self.piece[p].i[b].next = self.equal.val().get_bit(size * p + b);
                }
            }
            for p in self._whole_pieces..self._pieces {
                for b in 0..self._rest_bits {
                    self.piece[p].i[b].next = self.equal.val().get_bit(size * p + b);
                }
            }
        }
        for p in 0..self._pieces {
            self.all_equal.i[p].next = self.piece[p].o.val().all();
        }
        self.matched.d.next = self.all_equal.o.val();
        self.o_matched.next = self.matched.q.val().all();
    }
}
