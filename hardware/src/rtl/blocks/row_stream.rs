//! The counts of a row of detectors as AXI4-Stream, out of a memory.
//!
//! Counts come and go at one a clock, so that those of a step never overtake one another; a step that ends
//! while results of the one before still wait is lost.
//!
//! Cost (ECP5, 64 detectors, docs/pixels.md): 27 LUTs, 28 flip-flops, and a memory of 20 DPR16X4 with 72
//! LUTs that choose among them.

use crate::rtl::front::prelude::*;
use crate::sensor::rows::RowPlan;

#[block(row_stream)]
/// counts of a row of detectors as AXI4-Stream
///
/// The sensor cannot stall: counts of a step that ends while others still wait are lost, and o_overrun
/// stays high until reset.
///
/// The first place of the memory is free as soon as the first result is offered, so that it is written
/// before it is known whether the others may be.
///
/// - Latency: 1 clock from i_counted to o_valid
pub struct RowStream {
    plan: RowPlan,
    bits: u32,
    data_bits: u32,
    #[set(plan.address_bits())]
    address_bits: u32,
    /// a count of a step is there
    pub i_store: Input<bool>,
    /// of this detector
    #[width(address_bits)]
    pub i_place: Input<Word>,
    /// the count, signed
    #[width(bits)]
    pub i_count: Input<Word>,
    /// the first of them may be offered in the next clock
    pub i_counted: Input<bool>,
    /// they are the scan's last
    pub i_last: Input<bool>,
    /// the receiver takes the result
    pub i_ready: Input<bool>,
    /// count of the step, signed
    #[width(data_bits)]
    pub o_data: Output<Word>,
    /// a result waits
    pub o_valid: Output<bool>,
    /// the result is the scan's last
    pub o_last: Output<bool>,
    /// a result was lost since reset
    pub o_overrun: Output<bool>,
    #[width(address_bits)]
    #[value(u128::from(plan.detectors - 1))]
    last_place: Constant,
    #[is(LookupMemory::new(address_bits, bits, "counts that wait"))]
    memory: LookupMemory,
    /// the result
    #[width(bits)]
    count: Register<Word>,
    /// detector of the next one
    #[width(address_bits)]
    next_place: Register<Word>,
    valid: Register<bool>,
    /// others of its step come after the result that waits
    more: Register<bool>,
    /// the step is the scan's last
    last: Register<bool>,
    overrun: Register<bool>,
    /// the counts of the step that comes are kept
    keeps: Register<bool>,
    blocked: Local<bool>,
    load: Local<bool>,
    /// the next result is offered
    goes: Local<bool>,
    /// a count is written
    writes: Local<bool>,
}

#[kernel]
impl Logic for RowStream {
    fn update(&mut self) {
        let bits = self.address_bits as usize;
        self.blocked.next = self.more.val() | (self.valid.val() & !self.i_ready.val());
        self.load.next = self.i_counted.val() & !self.blocked.val();
        self.goes.next = self.load.val() | (self.more.val() & self.i_ready.val());
        self.valid.next = self.i_counted.val() | self.blocked.val();
        if self.i_counted.val() {
            self.keeps.next = self.load.val();
        }
        if self.i_counted.val() & self.blocked.val() {
            self.overrun.next = true;
        }
        if self.load.val() {
            self.more.next = true;
            self.last.next = self.i_last.val();
        }
        if self.goes.val() {
            self.count.next = self.memory.o_word.val();
            self.next_place.next = self.next_place.val() + 1;
            if self.next_place.val() == self.last_place.val() {
                self.next_place.next = bit_cast(false, bits);
                self.more.next = false;
            }
        }
        self.store();
        self.o_data.next = bit_cast(signed_cast(self.count.val()), self.data_bits as usize);
        self.o_last.next = self.last.val() & !self.more.val();
        connect! { self: valid, overrun }
    }

    /// Those of a step that is lost stay out, but for the first, whose place is free.
    fn store(&mut self) {
        self.writes.next = self.keeps.val() | !self.i_place.val().any();
        if self.i_counted.val() {
            self.writes.next = self.load.val();
        }
        self.memory.i_write.next = self.i_store.val() & self.writes.val();
        self.memory.i_write_address.next = self.i_place.val();
        self.memory.i_data.next = self.i_count.val();
        self.memory.i_address.next = self.next_place.val();
    }
}
