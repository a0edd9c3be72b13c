//! Compares signed counts, some bits in a clock.

use crate::hdl::front::prelude::*;
use crate::model::peak::PeakPlan;

/// Whether one signed count is greater than another, when both have stood
/// still for a clock per piece.
#[derive(Debug, Clone, LogicBlock)]
pub struct CountComparison {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// The count.
    pub i_count: Input<Word>,
    /// What it is compared with.
    pub i_other: Input<Word>,
    /// The count is greater.
    pub o_greater: Output<bool>,
    about: About,
    sign: Constant,
    biased_count: Local<Word>,
    biased_other: Local<Word>,
    count_piece: Vec<Wiring>,
    other_piece: Vec<Wiring>,
    exceeds: Wiring,
    greater: Register<Word>,
    _pieces: usize,
    _bits: usize,
    _top_bits: usize,
    _first_with_tie: usize,
}

impl CountComparison {
    /// For the counts of a peak detector.
    pub fn new(plan: &PeakPlan) -> CountComparison {
        let pieces = plan.pieces as usize;
        let bits = plan.count_bits;
        // Below a piece's bits stands how those below compare.
        let cut = |about: &str| -> Vec<Wiring> {
            (0..plan.pieces)
                .map(|piece| {
                    let size = plan.piece_bits(piece) as usize;
                    let tie = (piece > 0).then_some(size);
                    let sources: Vec<usize> = tie.into_iter().chain(0..size).collect();
                    Wiring::new(sources.len(), sources, about)
                })
                .collect()
        };
        CountComparison {
            i_clk: Input::bit("one piece per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_count: Input::word(bits, "a count, signed"),
            i_other: Input::word(bits, "what it is compared with, signed"),
            o_greater: Output::bit("the count is greater"),
            about: describe(plan),
            sign: Constant::new(
                1 << (bits - 1),
                bits,
                "Makes signed numbers compare as unsigned",
            ),
            biased_count: Local::word(bits, "the count, its sign inverted"),
            biased_other: Local::word(bits, "the other one, its sign inverted"),
            count_piece: cut("piece of the count, and whether it is greater by those below"),
            other_piece: cut("piece of the other one"),
            exceeds: Wiring::new(
                pieces,
                (0..pieces).collect(),
                "pieces of the count that are greater",
            ),
            greater: Register::word(
                plan.pieces,
                0,
                "the count is greater by the bits up to each piece's",
            ),
            _pieces: pieces,
            _bits: plan.piece_bits(0) as usize,
            _top_bits: plan.piece_bits(plan.pieces - 1) as usize,
            _first_with_tie: pieces.saturating_sub(1).max(1),
        }
    }
}

fn describe(plan: &PeakPlan) -> About {
    let mut about = About::new("count_comparison", "whether a signed count is greater");
    if plan.pieces > 1 {
        about = about.note(
            "A piece a clock, the lowest bits first: where the bits of a piece are equal, it is \
             as the piece below says. Both counts stand still meanwhile.",
        );
    }
    let clocks = match plan.pieces {
        1 => "1 clock".to_owned(),
        pieces => format!("{pieces} clocks"),
    };
    about.fact("Latency", clocks)
}

impl Logic for CountComparison {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, greater);
        self.biased_count.next = self.i_count.val() ^ self.sign.val();
        self.biased_other.next = self.i_other.val() ^ self.sign.val();
        for size in self._bits..(self._bits + 1) {
            for p in 0..(self._pieces - 1) {
                for b in 0..self._bits {
                    self.count_piece[p].i[b].next = self.biased_count.val().get_bit(size * p + b);
                    self.other_piece[p].i[b].next = self.biased_other.val().get_bit(size * p + b);
                }
            }
            for top in (self._pieces - 1)..self._pieces {
                for b in 0..self._top_bits {
                    self.count_piece[top].i[b].next =
                        self.biased_count.val().get_bit(size * top + b);
                    self.other_piece[top].i[b].next =
                        self.biased_other.val().get_bit(size * top + b);
                }
            }
            for p in 1..(self._pieces - 1) {
                self.count_piece[p].i[size].next = self.greater.q.val().get_bit(p - 1);
                self.other_piece[p].i[size].next = false;
            }
        }
        for size in self._top_bits..(self._top_bits + 1) {
            for top in self._first_with_tie..self._pieces {
                self.count_piece[top].i[size].next = self.greater.q.val().get_bit(top - 1);
                self.other_piece[top].i[size].next = false;
            }
        }
        for p in 0..self._pieces {
            self.exceeds.i[p].next = self.other_piece[p].o.val() < self.count_piece[p].o.val();
        }
        self.greater.d.next = self.exceeds.o.val();
        for top in (self._pieces - 1)..self._pieces {
            self.o_greater.next = self.greater.q.val().get_bit(top);
        }
    }
}
