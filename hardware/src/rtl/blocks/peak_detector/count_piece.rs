//! Compares some bits of two counts.
//!
//! A piece needs a single carry chain and no test for equality. The sign of a difference comes from the
//! chain's last sum; a comparison's carry would have to leave the chain, which costs ECP5 a tenth of its
//! clock.

use crate::rtl::front::prelude::*;

#[block(count_piece)]
/// whether some bits of a count are greater
///
/// What the bits below say joins the difference as a bit under its lowest, which decides where all others
/// are equal.
///
/// - Latency: 1 clock
pub struct CountPiece {
    /// bits of a piece
    #[size(1..=usize::MAX)]
    bits: usize,
    /// bits of a count
    #[width(bits)]
    pub i_count: Input<Word>,
    /// bits of what it is compared with
    #[width(bits)]
    pub i_other: Input<Word>,
    /// the count is greater by the bits below
    pub i_below: Input<bool>,
    /// the count was greater by the bits so far
    pub o_greater: Output<bool>,
    /// negative if the count is greater
    #[width(bits + 2)]
    difference: Local<Word>,
    /// only its sign counts; linters know by the name
    unused: Local<bool>,
    greater: Register<bool>,
}

#[kernel]
impl Logic for CountPiece {
    fn update(&mut self) {
        let bits = self.bits + 2;
        self.difference.next = (bit_cast(self.i_other.val(), bits) << 1)
            - (bit_cast(self.i_count.val(), bits) << 1).replace_bit(0, self.i_below.val());
        self.unused.next = self.difference.val().all();
        self.greater.next = self.difference.val().get_bit(self.bits + 1);
        self.o_greater.next = self.greater.val();
    }
}
