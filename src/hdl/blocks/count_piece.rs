//! Compares some bits of two counts.

use crate::hdl::front::prelude::*;

/// Whether a count is greater than another by some of its bits, or where they
/// are equal by those below.
#[derive(Debug, Clone, LogicBlock)]
pub struct CountPiece {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Bits of the count.
    pub i_count: Input<Word>,
    /// Bits of what it is compared with.
    pub i_other: Input<Word>,
    /// The count is greater by the bits below.
    pub i_below: Optional<Input<bool>>,
    /// The count is greater by the bits so far.
    pub o_greater: Output<bool>,
    about: About,
    negative: Constant,
    difference: Local<Word>,
    greater: Register<bool>,
    _difference_bits: usize,
}

impl CountPiece {
    /// For `bits` bits, compared as unsigned; `has_below` if there are others
    /// below them.
    pub fn new(bits: u32, has_below: bool) -> CountPiece {
        let difference_bits = bits + 1 + u32::from(has_below);
        let about = About::new("count_piece", "whether some bits of a count are greater");
        CountPiece {
            i_clk: Input::bit("one comparison per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_count: Input::word(bits, "bits of a count"),
            i_other: Input::word(bits, "bits of what it is compared with"),
            i_below: Optional::new(
                has_below,
                Input::bit("the count is greater by the bits below"),
            ),
            o_greater: Output::bit("the count was greater by the bits so far"),
            about: if has_below {
                about.note(
                    "The bits below join the difference as a bit under its lowest, which decides \
                     where all others are equal.",
                )
            } else {
                about
            }
            .fact("Latency", "1 clock"),
            negative: Constant::new(
                1 << (difference_bits - 1),
                difference_bits,
                "Sign of the difference",
            ),
            difference: Local::word(
                difference_bits,
                "the other one less the count, negative if the count is greater",
            ),
            greater: Register::bit(false, "the count was greater by the bits so far"),
            _difference_bits: difference_bits as usize,
        }
    }
}

impl Logic for CountPiece {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, greater);
        for _lowest in self.i_below.count()..1 {
            self.difference.next = bit_cast(self.i_other.val(), self._difference_bits)
                - bit_cast(self.i_count.val(), self._difference_bits);
        }
        for _above in 0..self.i_below.count() {
            self.difference.next = (bit_cast(self.i_other.val(), self._difference_bits) << 1)
                - (bit_cast(self.i_count.val(), self._difference_bits) << 1)
                    .replace_bit(0, self.i_below[0].val());
        }
        self.greater.d.next = (self.difference.val() & self.negative.val()).any();
        self.o_greater.next = self.greater.q.val();
    }
}
