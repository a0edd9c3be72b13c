//! The reference, delayed by a phase that grows with every group of steps.

use super::lane_delay::window_about;
use super::phase_geometry::{PhaseGeometry, ReferenceStart};
use super::{ChipHistory, LaneDelay};
use crate::hdl::front::prelude::*;

/// Delays the reference: whole chips by holding its generator, the rest by
/// lane.
#[derive(Debug, Clone, LogicBlock)]
pub struct PhaseStepper {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Next chip of the reference.
    pub i_chip: Input<bool>,
    /// The next clock is the last of a group of steps.
    pub i_step_ends: Optional<Input<bool>>,
    /// Last clock of a group of steps.
    pub i_step_end: Input<bool>,
    /// First clock of a scan comes next.
    pub i_start: Optional<Input<bool>>,
    /// The reference generator goes on.
    pub o_advance: Output<bool>,
    /// Reference of each sample; step p of a group of P takes it from bit
    /// P - 1 - p on.
    pub o_window: Output<Word>,
    about: About,
    chips: ChipHistory,
    lanes: LaneDelay,
}

impl PhaseStepper {
    /// `looks_ahead` if `i_step_ends` is there; `realigns` adds the start of
    /// later scans.
    pub fn new(
        geometry: PhaseGeometry,
        start: ReferenceStart,
        looks_ahead: bool,
        realigns: bool,
    ) -> PhaseStepper {
        PhaseStepper {
            i_clk: Input::bit("one chip per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_chip: Input::bit("next chip of the reference"),
            i_step_ends: Optional::new(
                looks_ahead && geometry.grows_by_samples(),
                Input::bit("the next clock is the last of a phase step"),
            ),
            i_step_end: Input::bit("last clock of a phase step"),
            i_start: Optional::new(realigns, Input::bit("a scan begins with the next clock")),
            o_advance: Output::bit("the reference generator goes on to its next chip"),
            o_window: Output::word(geometry.window(), window_about(geometry.parallel)),
            about: describe(geometry),
            chips: ChipHistory::new(geometry, start, realigns),
            lanes: LaneDelay::new(geometry, looks_ahead, realigns),
        }
    }
}

fn describe(geometry: PhaseGeometry) -> About {
    let title = match geometry.parallel {
        1 => "the reference, delayed by one more sample with every phase step".to_owned(),
        parallel => format!(
            "the reference for {parallel} phase steps at once, delayed by {parallel} more samples \
             with every group"
        ),
    };
    let mut about = About::new("phase_stepper", &title);
    if geometry.lanes > 1 {
        about = about.note(
            "Whole chips of delay come from holding the reference's generator, samples from the \
             choice of a chip for each lane.",
        );
    }
    about
        .fact("Latency", "2 clocks from i_chip to o_window")
        .fact("Rate", "one chip per clock")
}

impl Logic for PhaseStepper {
    #[hdl_gen]
    fn update(&mut self) {
        self.chips.i_clk.next = self.i_clk.val();
        self.chips.i_rst.next = self.i_rst.val();
        self.chips.i_chip.next = self.i_chip.val();
        for _whole_chips in 0..(self.chips.i_step_end.count()) {
            self.chips.i_step_end[0].next = self.i_step_end.val();
        }
        self.lanes.i_clk.next = self.i_clk.val();
        self.lanes.i_rst.next = self.i_rst.val();
        self.lanes.i_chips.next = self.chips.o_chips.val();
        for _by_samples in 0..(self.lanes.i_step_end.count()) {
            self.lanes.i_step_end[0].next = self.i_step_end.val();
            self.chips.i_wrap[0].next = self.lanes.o_wrap[0].val();
        }
        for _ahead in 0..self.i_step_ends.count() {
            self.lanes.i_step_ends[0].next = self.i_step_ends[0].val();
        }
        for _realigns in 0..self.i_start.count() {
            self.chips.i_start[0].next = self.i_start[0].val();
            for _by_samples in 0..(self.lanes.i_start.count()) {
                self.lanes.i_start[0].next = self.i_start[0].val();
            }
        }
        self.o_advance.next = self.chips.o_advance.val();
        self.o_window.next = self.lanes.o_window.val();
    }
}
