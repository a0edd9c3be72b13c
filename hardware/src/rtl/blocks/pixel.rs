//! One detector of a row: its hits, counted for a window.
//!
//! Latency that of edges and correlator, and 1 clock each to the counter and from `i_take` to the row.
//!
//! Cost (ECP5, 8 samples, 64 detectors, docs/pixels.md): 20 LUTs, 20 flip-flops beside edges and
//! correlator, with which it has 38 and 47.

use super::{EdgeDetector, UpdownCorrelator};
use crate::rtl::front::prelude::*;

#[block(pixel)]
/// one detector's hits, counted up and down for a window
///
/// The counter is never cleared: what it grows by within a window has the bits of a window's count, and
/// wrapping does no harm to a difference.
///
/// At a window's end all counters are taken over into a row of registers, which moves on to the adder by
/// one detector a clock while the next window is counted.
pub struct Pixel {
    lanes: usize,
    /// Levels whose edges are counted.
    cells: usize,
    /// Bits of the counter.
    bits: u32,
    /// {if cells > 1 { "level of each cell, bit 0 earliest, cell 0 lowest" } else { "level of the SPAD, bit 0 earliest" }}
    #[width(lanes * cells)]
    pub i_samples: Input<Word>,
    /// the word belongs to a scan
    pub i_run: Input<bool>,
    /// reference of each sample
    #[width(lanes)]
    pub i_reference: Input<Word>,
    /// the counter has a window's last hits
    pub i_take: Input<bool>,
    /// the next detector's place in the row
    #[width(bits)]
    pub i_next: Input<Word>,
    /// this one's
    #[width(bits)]
    pub o_piece: Output<Word>,
    #[is(EdgeDetector::new(lanes, cells))]
    edges: EdgeDetector,
    #[is(UpdownCorrelator::new(lanes, cells * lanes.div_ceil(2), None))]
    correlator: UpdownCorrelator,
    /// hits up less hits down, modulo its width
    #[width(bits)]
    count: Register<Word>,
    #[width(bits)]
    piece: Register<Word>,
}

#[kernel]
impl Logic for Pixel {
    fn update(&mut self) {
        connect! { self.edges from self: i_samples, i_run }
        connect! { self.correlator from self.edges: i_hits, i_early }
        connect! { self.correlator from self: i_reference }
        self.count.next = self.count.val() + signed_cast(self.correlator.o_addend.val());
        if self.i_take.val() {
            self.piece.next = self.count.val();
        } else {
            self.piece.next = self.i_next.val();
        }
        connect! { self: piece }
    }
}
