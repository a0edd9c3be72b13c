//! The reference, delayed by a phase that grows with every group of steps.
//!
//! Whole chips of delay cost nothing but a generator that waits; samples of delay cost one choice between
//! two chips for each lane.

mod chip_history;
mod lane_delay;
mod phase_geometry;

use self::chip_history::ChipHistory;
use self::lane_delay::{LaneDelay, window_about};
pub use self::phase_geometry::{PhaseGeometry, ReferenceStart};
use crate::rtl::front::prelude::*;

#[block(phase_stepper)]
/// {title(geometry.parallel)}
#[when(geometry.lanes > 1)]
/// Whole chips of delay come from holding the reference's generator, samples from the choice of a chip for
/// each lane.
///
/// - Latency: 2 clocks from i_chip to o_window
pub struct PhaseStepper {
    geometry: PhaseGeometry,
    start: ReferenceStart,
    looks_ahead: bool,
    realigns: bool,
    /// Whether a scan's first delay comes from outside; the reference then runs before a scan, and
    /// fills the chips by itself.
    is_set: bool,
    /// next chip of the reference
    pub i_chip: Input<bool>,
    /// the present chip is the last but one of a phase step
    #[when(looks_ahead && geometry.grows_by_samples())]
    pub i_pre_last_chip: Optional<Input<bool>>,
    /// last chip of a phase step
    pub i_last_chip: Input<bool>,
    /// a scan begins with the next clock
    #[when(realigns && (!is_set || geometry.grows_by_samples()))]
    pub i_start: Optional<Input<bool>>,
    /// lanes that take the previous chip in a scan's first step
    #[when(is_set && geometry.grows_by_samples())]
    #[width(geometry.lanes - 1)]
    pub i_delayed: Optional<Input<Word>>,
    /// the reference generator goes on to its next chip
    pub o_advance: Output<bool>,
    /// {window_about(geometry.parallel)}
    #[width(geometry.window())]
    pub o_window: Output<Word>,
    #[is(ChipHistory::new(geometry, start, realigns && !is_set))]
    chips: ChipHistory,
    #[is(LaneDelay::new(geometry, looks_ahead, realigns, is_set))]
    lanes: LaneDelay,
}

fn title(parallel: u32) -> String {
    match parallel {
        1 => "the reference, delayed by one more sample with every phase step".to_owned(),
        _ => format!(
            "the reference for {parallel} phase steps at once, each group {parallel} samples later"
        ),
    }
}

#[kernel]
impl Logic for PhaseStepper {
    fn update(&mut self) {
        connect! { self.chips from self: i_chip, i_last_chip }
        self.lanes.i_chips.next = self.chips.o_chips.val();
        if self.lanes.i_last_chip.is_present() {
            self.lanes.i_last_chip.next = self.i_last_chip.val();
            self.chips.i_wrap.next = self.lanes.o_wrap.val();
        }
        connect! { self.lanes from self: i_pre_last_chip }
        if self.i_start.is_present() {
            connect! { self.chips from self: i_start }
            connect! { self.lanes from self: i_start }
        }
        connect! { self.lanes from self: i_delayed }
        self.o_advance.next = self.chips.o_advance.val();
        self.o_window.next = self.lanes.o_window.val();
    }
}
