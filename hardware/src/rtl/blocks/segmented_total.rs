//! A running total in segments, each with a carry chain of its own.
//!
//! Latency of a total in segments: 1 clock to the lowest one, 1 more for each above it, and 2 to
//! `o_count`. A chain of carries is no longer than a segment, whatever the width.

use super::Accumulator;
use crate::rtl::front::prelude::*;
use crate::sensor::interface::CountSegments;

#[block(segmented_total, .size(
    ("HIGHEST_BITS", "bits of the highest segment"),
    segments.top_bits as usize,
    2..=usize::MAX,
    move |bits| {
        SegmentedTotal::new(CountSegments { top_bits: bits as u32, ..segments }, addend_bits)
    },
))]
/// a running total in segments, and its growth per phase step
///
/// Carry and borrow reach the next segment one clock later, and so does i_dump.
pub struct SegmentedTotal {
    segments: CountSegments,
    addend_bits: usize,
    #[set(segments.count as usize - 2)]
    middle_count: usize,
    #[set(segments.lower_bits as usize)]
    lower_bits: usize,
    #[set(segments.top_bits as usize)]
    top_bits: usize,
    /// what to add, signed
    #[width(addend_bits)]
    pub i_addend: Input<Word>,
    /// bit s: segment s holds the last addend of a phase step
    #[width(segments.count)]
    pub i_dump: Input<Word>,
    /// growth within the last phase step
    #[width(segments.bits())]
    pub o_count: Output<Word>,
    #[is(Accumulator::new(lower_bits, addend_bits, false, true))]
    lowest: Accumulator,
    #[each(_segment in 0..middle_count)]
    #[is(Accumulator::new(lower_bits, 2, true, true))]
    middle: Vec<Accumulator>,
    #[is(Accumulator::new(top_bits, 2, true, false))]
    highest: Accumulator,
}

#[kernel]
impl Logic for SegmentedTotal {
    fn update(&mut self) {
        let above = self.middle_count;
        let bits = self.lower_bits;
        self.lowest.i_addend.next = self.i_addend.val();
        self.lowest.i_dump.next = self.i_dump.val().get_bit(0);
        for s in 0..self.middle.len() {
            self.middle[s].i_dump.next = self.i_dump.val().get_bit(s + 1);
        }
        self.highest.i_dump.next = self.i_dump.val().get_bit(above + 1);
        if above > 0 {
            self.middle[0].i_addend.next = self.lowest.o_carry.val();
            self.middle[0].i_borrow.next = self.lowest.o_borrow.val();
            for s in 1..self.middle.len() {
                self.middle[s].i_addend.next = self.middle[s - 1].o_carry.val();
                self.middle[s].i_borrow.next = self.middle[s - 1].o_borrow.val();
            }
            self.highest.i_addend.next = self.middle[above - 1].o_carry.val();
            self.highest.i_borrow.next = self.middle[above - 1].o_borrow.val();
        } else {
            self.highest.i_addend.next = self.lowest.o_carry.val();
            self.highest.i_borrow.next = self.lowest.o_borrow.val();
        }
        self.o_count.next = gather(bits * (above + 1) + self.top_bits, |b| {
            if b < bits {
                self.lowest.o_count.val().get_bit(b)
            } else if b / bits <= above {
                self.middle[b / bits - 1].o_count.val().get_bit(b % bits)
            } else {
                self.highest.o_count.val().get_bit(b - bits * (above + 1))
            }
        });
    }
}
