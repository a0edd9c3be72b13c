//! Detectors that are read out by rows.
//!
//! Latency that of its parts in turn: edges, correlator, row, sums, stream.

use std::sync::Arc;

use super::detector_channel::{first_samples, reference_start};
use super::phase_stepper::{PhaseGeometry, ReferenceStart};
use super::sensor_shell::{DistinctCodes, distinct_codes};
use super::{CodeSource, PhaseStepper, Pixel, RowStream, RowSums};
use crate::code::Code;
use crate::rtl::front::prelude::*;
use crate::sensor::interface::{Correlator, Interface};
use crate::sensor::rows::RowPlan;

#[block(pixel_array)]
/// detectors that are read out by rows
///
/// Detectors that follow one code share its generator, delayed by the phase step. Each counts for a
/// window; the counts of windows are summed in one memory.
pub struct PixelArray {
    interface: Interface,
    counts: Correlator,
    plan: RowPlan,
    #[set(interface.lanes() as usize)]
    lanes: usize,
    /// Levels of each detector whose edges are counted.
    #[set(interface.input_cells.edges() as usize)]
    cells: usize,
    #[set(distinct_codes(&interface.reference_codes[0], &interface.reference_codes))]
    codes: DistinctCodes,
    #[set(interface.realigns())]
    realigns: bool,
    #[set(PhaseGeometry::new(interface.lanes(), 1, first_samples(&interface)))]
    geometry: PhaseGeometry,
    /// Where each reference stands in reset, and the chip that its generator gives next.
    #[set(codes.all.iter().map(|code| reference_start(&interface, code, geometry.kept_chips())).collect())]
    starts: Vec<(ReferenceStart, u64)>,
    #[set(codes.all.iter().cloned().zip(starts.iter().cloned()).collect())]
    references: Vec<(Arc<Code>, (ReferenceStart, u64))>,
    /// level of each detector, bit 0 earliest
    #[each(_detector in 0..plan.detectors)]
    #[width(lanes * cells)]
    pub i_samples: Vec<Input<Word>>,
    /// the present chip belongs to a scan
    pub i_run: Input<bool>,
    /// the present chip is the last but one of a phase step
    #[when(geometry.grows_by_samples())]
    pub i_pre_last_chip: Optional<Input<bool>>,
    /// last chip of a phase step
    pub i_last_chip: Input<bool>,
    /// a scan begins with the next clock
    #[when(realigns)]
    pub i_start: Optional<Input<bool>>,
    /// the counters have a step's last hits in the next clock
    pub i_dump: Input<bool>,
    /// the first count of a step may be offered in the next clock
    pub i_counted: Input<bool>,
    /// the step is the scan's last
    pub i_last: Input<bool>,
    /// the receiver takes the result
    pub i_ready: Input<bool>,
    /// count of the step, signed
    #[width(counts.signed_data_bits())]
    pub o_data: Output<Word>,
    /// a result waits
    pub o_valid: Output<bool>,
    /// the result is the scan's last
    pub o_last: Output<bool>,
    /// a result was lost since reset
    pub o_overrun: Output<bool>,
    #[each(reference in references.iter())]
    #[is(CodeSource::new(&reference.0, reference.1.1, realigns))]
    reference: Vec<CodeSource>,
    #[each(reference in references.iter())]
    #[is(PhaseStepper::new(geometry, reference.1.0, true, realigns, false))]
    stepper: Vec<PhaseStepper>,
    #[each(_detector in 0..plan.detectors)]
    #[is(Pixel::new(lanes, cells, plan.piece_bits))]
    pixel: Vec<Pixel>,
    #[is(RowSums::new(plan, counts.count_bits, counts.clocks_to_dump() - 1))]
    sums: RowSums,
    #[is(RowStream::new(plan, counts.count_bits, counts.signed_data_bits()))]
    stream: RowStream,
}

#[kernel]
impl Logic for PixelArray {
    fn update(&mut self) {
        for r in 0..self.reference.len() {
            self.delay_reference(r);
        }
        self.count_pixels();
        connect! { self.sums from self: i_run, i_dump }
        self.sums.i_piece.next = self.pixel[0].o_piece.val();
        connect! { self.stream from self.sums: i_store, i_place, i_count }
        connect! { self.stream from self: i_counted, i_last, i_ready }
        connect! { self from self.stream: o_data, o_valid, o_last, o_overrun }
    }

    fn delay_reference(&mut self, r: usize) {
        self.reference[r].i_advance.next = self.stepper[r].o_advance.val();
        self.stepper[r].i_chip.next = self.reference[r].o_chip.val();
        connect! { self.stepper[r] from self: i_last_chip, i_pre_last_chip }
        if self.i_start.is_present() {
            self.reference[r].i_load.next = self.i_start.val();
            connect! { self.stepper[r] from self: i_start }
        }
    }

    fn count_pixels(&mut self) {
        let last = self.pixel.len() - 1;
        for d in 0..self.pixel.len() {
            self.pixel[d].i_samples.next = self.i_samples[d].val();
            self.pixel[d].i_reference.next = self.stepper[self.codes.of_sources[d]].o_window.val();
            connect! { self.pixel[d] from self: i_run }
            connect! { self.pixel[d] from self.sums: i_take }
        }
        for d in 0..last {
            self.pixel[d].i_next.next = self.pixel[d + 1].o_piece.val();
        }
        self.pixel[last].i_next.next = self.pixel[last].o_piece.val();
    }
}
