//! The reference, delayed by a phase step that grows by one sample per step.

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
    /// Last clock of a phase step.
    pub i_step_end: Input<bool>,
    /// First clock of a scan comes next.
    pub i_start: Optional<Input<bool>>,
    /// The reference generator goes on.
    pub o_advance: Output<bool>,
    /// Reference of each sample.
    pub o_reference: Output<Word>,
    about: About,
    present_load: Constant,
    previous_load: Optional<Constant>,
    delayed_load: Optional<Constant>,
    present: Register<bool>,
    previous: Optional<Register<bool>>,
    delayed: Optional<Register<Word>>,
    reference: Register<Word>,
    wrap: Local<bool>,
    _lanes: usize,
}

/// Where the reference stands when a scan begins.
#[derive(Debug, Clone, Copy)]
pub struct ReferenceStart {
    /// `present` after reset and at a scan's start.
    pub present: bool,
    /// `previous` after reset and at a scan's start.
    pub previous: bool,
    /// Lanes that take the previous chip, f = k mod S.
    pub delayed_lanes: u32,
}

impl PhaseStepper {
    /// For `lanes` samples per chip; `realigns` adds the start of later scans.
    pub fn new(lanes: u32, start: ReferenceStart, realigns: bool) -> PhaseStepper {
        let delays = lanes > 1;
        let mask_width = lanes.saturating_sub(1).max(1);
        let mask = (1 << start.delayed_lanes) - 1;
        let reload = "after reset and at a scan's start";
        PhaseStepper {
            i_clk: Input::bit("one chip per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_chip: Input::bit("next chip of the reference"),
            i_step_end: Input::bit("last clock of a phase step"),
            i_start: Optional::new(realigns, Input::bit("a scan begins with the next clock")),
            o_advance: Output::bit("the reference generator goes on to its next chip"),
            o_reference: Output::word(lanes, "reference of each sample, bit 0 earliest"),
            about: About::new(
                "phase_stepper",
                "the reference, delayed by one more sample with every phase step",
            )
            .note(
                "Lanes below the delay take the previous chip, the others the present one. When \
                 all but the last lane are delayed, the next step holds the reference for one \
                 chip instead and starts again without delayed lanes. The mask of delayed lanes \
                 is a thermometer, so that no lane needs a comparator.",
            )
            .fact("Latency", "1 clock from the chips to o_reference")
            .fact("Rate", "one chip per clock"),
            present_load: Constant::new(
                u128::from(start.present),
                1,
                format!("Present chip {reload}"),
            ),
            previous_load: Optional::new(
                delays,
                Constant::new(
                    u128::from(start.previous),
                    1,
                    format!("Previous chip {reload}"),
                ),
            ),
            delayed_load: Optional::new(
                delays,
                Constant::new(mask, mask_width, format!("Delayed lanes {reload}")),
            ),
            present: Register::bit(start.present, "reference chip of the present cycle")
                .reset_to("present_load"),
            previous: Optional::new(
                delays,
                Register::bit(start.previous, "reference chip before it")
                    .reset_to("previous_load$0"),
            ),
            delayed: Optional::new(
                delays,
                Register::word(mask_width, mask, "lanes that take the previous chip")
                    .reset_to("delayed_load$0"),
            ),
            reference: Register::word(lanes, 0, "reference of each sample"),
            wrap: Local::bit("the next step delays by a whole chip more"),
            _lanes: lanes as usize,
        }
    }
}

impl Logic for PhaseStepper {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, present, reference);
        self.o_reference.next = self.reference.q.val();
        for _delays in 0..self.delayed.count() {
            dff_setup!(self, i_clk, previous[0], delayed[0]);
            for top in (self._lanes.saturating_sub(2))..(self._lanes - 1) {
                self.wrap.next = self.i_step_end.val() & self.delayed[0].q.val().get_bit(top);
            }
            self.reference.d.next = (bit_cast(self.delayed[0].q.val(), self._lanes)
                & signed_cast(self.previous[0].q.val()))
                | (!bit_cast(self.delayed[0].q.val(), self._lanes)
                    & signed_cast(self.present.q.val()));
            if self.wrap.val() {
                self.delayed[0].d.next = 0.into();
            } else if self.i_step_end.val() {
                self.delayed[0].d.next = (self.delayed[0].q.val() << 1).replace_bit(0, true);
            }
        }
        for _whole_chips in self.delayed.count()..1 {
            self.wrap.next = self.i_step_end.val();
            self.reference.d.next = signed_cast(self.present.q.val()).into();
        }
        self.o_advance.next = !self.wrap.val();
        if !self.wrap.val() {
            self.present.d.next = self.i_chip.val();
            for _delays in 0..self.delayed.count() {
                self.previous[0].d.next = self.present.q.val();
            }
        }
        for _realigns in 0..self.i_start.count() {
            if self.i_start[0].val() {
                self.present.d.next = self.present_load.val().any();
                for _delays in 0..self.delayed.count() {
                    self.previous[0].d.next = self.previous_load[0].val().any();
                    self.delayed[0].d.next = self.delayed_load[0].val();
                }
            }
        }
    }
}
