//! Compares signed counts, some bits in a clock.

use super::CountPiece;
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
    unsigned_count: Local<Word>,
    unsigned_other: Local<Word>,
    count_bits: Vec<Wiring>,
    other_bits: Vec<Wiring>,
    piece: Vec<CountPiece>,
    _count_bits: usize,
    _pieces: usize,
    _bits: usize,
    _top_bits: usize,
}

impl CountComparison {
    /// For the counts of a peak detector.
    pub fn new(plan: &PeakPlan) -> CountComparison {
        let bits = plan.count_bits;
        let sizes: Vec<u32> = (0..plan.pieces)
            .map(|piece| plan.piece_bits(piece))
            .collect();
        let cut = |about: &str| -> Vec<Wiring> {
            sizes
                .iter()
                .map(|&size| Wiring::new(size as usize, (0..size as usize).collect(), about))
                .collect()
        };
        CountComparison {
            i_clk: Input::bit("one piece per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_count: Input::word(bits, "a count, signed"),
            i_other: Input::word(bits, "what it is compared with, signed"),
            o_greater: Output::bit("the count is greater"),
            about: describe(plan),
            unsigned_count: Local::word(bits, "the count with the other one's sign"),
            unsigned_other: Local::word(bits, "the other one with the count's sign"),
            count_bits: cut("piece of the count"),
            other_bits: cut("piece of the other one"),
            piece: (0..plan.pieces)
                .map(|piece| CountPiece::new(plan.piece_bits(piece), piece > 0))
                .collect(),
            _count_bits: bits as usize,
            _pieces: plan.pieces as usize,
            _bits: sizes[0] as usize,
            _top_bits: sizes[sizes.len() - 1] as usize,
        }
    }
}

fn describe(plan: &PeakPlan) -> About {
    let mut about = About::new("count_comparison", "whether a signed count is greater")
        .note("With their signs exchanged, signed numbers compare as unsigned ones.");
    if plan.pieces > 1 {
        about = about
            .note("A piece a clock, the lowest bits first. Both counts stand still meanwhile.");
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
        for sign in (self._count_bits - 1)..self._count_bits {
            self.unsigned_count.next = self
                .i_count
                .val()
                .replace_bit(sign, self.i_other.val().get_bit(sign));
            self.unsigned_other.next = self
                .i_other
                .val()
                .replace_bit(sign, self.i_count.val().get_bit(sign));
        }
        for size in self._bits..(self._bits + 1) {
            for p in 0..(self._pieces - 1) {
                for b in 0..self._bits {
                    self.count_bits[p].i[b].next = self.unsigned_count.val().get_bit(size * p + b);
                    self.other_bits[p].i[b].next = self.unsigned_other.val().get_bit(size * p + b);
                }
            }
            for top in (self._pieces - 1)..self._pieces {
                for b in 0..self._top_bits {
                    self.count_bits[top].i[b].next =
                        self.unsigned_count.val().get_bit(size * top + b);
                    self.other_bits[top].i[b].next =
                        self.unsigned_other.val().get_bit(size * top + b);
                }
            }
        }
        for p in 0..self._pieces {
            self.piece[p].i_clk.next = self.i_clk.val();
            self.piece[p].i_rst.next = self.i_rst.val();
            self.piece[p].i_count.next = self.count_bits[p].o.val();
            self.piece[p].i_other.next = self.other_bits[p].o.val();
        }
        for p in 1..self._pieces {
            self.piece[p].i_below[0].next = self.piece[p - 1].o_greater.val();
        }
        for top in (self._pieces - 1)..self._pieces {
            self.o_greater.next = self.piece[top].o_greater.val();
        }
    }
}
