//! A piece of a running maximum.

use crate::hdl::front::prelude::*;

/// Some bits of the largest count so far; the bits below are a clock behind.
#[derive(Debug, Clone, LogicBlock)]
pub struct MaximumPiece {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// These bits of a count.
    pub i_piece: Input<Word>,
    /// Highest piece: there is a count.
    pub i_take: Optional<Input<bool>>,
    /// Highest piece: it is the scan's first.
    pub i_first: Optional<Input<bool>>,
    /// Other pieces: the count is greater by the bits above.
    pub i_greater: Optional<Input<bool>>,
    /// Other pieces: the bits above are equal.
    pub i_equal: Optional<Input<bool>>,
    /// These bits of the maximum.
    pub o_piece: Output<Word>,
    /// The count is greater than the maximum; to be known a clock later by the
    /// piece below, at once if there is none.
    pub o_greater: Output<bool>,
    /// So far they are equal, for the piece below.
    pub o_equal: Optional<Output<bool>>,
    about: About,
    sign: Optional<Constant>,
    piece: Register<Word>,
    exceeds: Local<bool>,
    replaces: Local<bool>,
    greater: Optional<Register<bool>>,
    equal: Optional<Register<bool>>,
}

impl MaximumPiece {
    /// `bits` bits of the maximum; the highest piece has the sign.
    pub fn new(bits: u32, is_highest: bool, is_lowest: bool) -> MaximumPiece {
        let highest = |about: &str| Optional::new(is_highest, Input::bit(about));
        let other = |about: &str| Optional::new(!is_highest, Input::bit(about));
        let note = if is_highest && is_lowest {
            "A count replaces a smaller one; of equal ones the first stays (eq. 15)."
        } else {
            "Counts are compared from the highest bits down, every piece a clock behind the one \
             above it: a count that is greater there replaces the bits here, one that is equal \
             there does so if it is greater here. Of equal counts the first stays (eq. 15)."
        };
        let when_higher = |bit| Optional::new(!is_lowest, bit);
        MaximumPiece {
            i_clk: Input::bit("one count per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_piece: Input::word(
                bits,
                if is_highest {
                    "highest bits of a count, signed"
                } else {
                    "bits of a count"
                },
            ),
            i_take: highest("there is a count"),
            i_first: highest("it is the scan's first"),
            i_greater: other("the count is greater by the bits above"),
            i_equal: other("the bits above are equal"),
            o_piece: Output::word(bits, "these bits of the largest count so far"),
            o_greater: Output::bit("the count is greater"),
            o_equal: Optional::new(!is_lowest, Output::bit("the bits so far are equal")),
            about: About::new("maximum_piece", "bits of the largest count so far")
                .note(note)
                .fact("Latency", "1 clock")
                .fact("Rate", "one count per clock"),
            sign: Optional::new(
                is_highest,
                Constant::new(
                    1 << (bits - 1),
                    bits,
                    "Makes signed numbers compare as unsigned",
                ),
            ),
            piece: Register::word(bits, 0, "these bits of the largest count so far"),
            exceeds: Local::bit("these bits of the count are greater"),
            replaces: Local::bit("the count's bits become the maximum's"),
            greater: when_higher(Register::bit(false, "the count is greater")),
            equal: when_higher(Register::bit(false, "the bits so far are equal")),
        }
    }
}

impl Logic for MaximumPiece {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, piece);
        for _highest in 0..self.sign.count() {
            self.exceeds.next = (self.piece.q.val() ^ self.sign[0].val())
                < (self.i_piece.val() ^ self.sign[0].val());
            self.replaces.next =
                self.i_take[0].val() & (self.i_first[0].val() | self.exceeds.val());
        }
        for _other in self.sign.count()..1 {
            self.exceeds.next = self.piece.q.val() < self.i_piece.val();
            self.replaces.next =
                self.i_greater[0].val() | (self.i_equal[0].val() & self.exceeds.val());
        }
        if self.replaces.val() {
            self.piece.d.next = self.i_piece.val();
        }
        self.o_piece.next = self.piece.q.val();
        for _lowest in self.greater.count()..1 {
            self.o_greater.next = self.replaces.val();
        }
        for _higher in 0..self.greater.count() {
            dff_setup!(self, i_clk, greater[0], equal[0]);
            self.greater[0].d.next = self.replaces.val();
            for _highest in 0..self.i_take.count() {
                self.equal[0].d.next = self.i_take[0].val()
                    & !self.i_first[0].val()
                    & (self.piece.q.val() == self.i_piece.val());
            }
            for _other in self.i_take.count()..1 {
                self.equal[0].d.next =
                    self.i_equal[0].val() & (self.piece.q.val() == self.i_piece.val());
            }
            self.o_greater.next = self.greater[0].q.val();
            self.o_equal[0].next = self.equal[0].q.val();
        }
    }
}
