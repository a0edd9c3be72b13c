//! Whole chips of a reference's delay.

use super::phase_geometry::{PhaseGeometry, ReferenceStart};
use crate::hdl::front::prelude::*;

/// Keeps the reference's present chip and those before it, and delays them by
/// holding the generator.
#[derive(Debug, Clone, LogicBlock)]
pub struct ChipHistory {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Next chip of the reference.
    pub i_chip: Input<bool>,
    /// Last clock of a group of steps, if the delay grows by whole chips then.
    pub i_step_end: Optional<Input<bool>>,
    /// Last clock of a group after which the delay grows by a chip more.
    pub i_wrap: Optional<Input<bool>>,
    /// First clock of a scan comes next.
    pub i_start: Optional<Input<bool>>,
    /// The reference generator goes on.
    pub o_advance: Output<bool>,
    /// The present chip in bit 0, those before it above.
    pub o_chips: Output<Word>,
    about: About,
    chips_load: Constant,
    chips: Register<Word>,
    saved: Optional<Register<Word>>,
    replays: Optional<Register<Word>>,
    hold: Optional<Local<bool>>,
    chip: Optional<Local<bool>>,
    _chips: usize,
    _window_chips: usize,
    _step_chips: usize,
    _replayed: usize,
}

impl ChipHistory {
    /// `realigns` adds the start of later scans.
    pub fn new(geometry: PhaseGeometry, start: ReferenceStart, realigns: bool) -> ChipHistory {
        let kept = geometry.kept_chips();
        let replayed = geometry.replayed_chips();
        let replays =
            |about: &str| Optional::new(replayed > 0, Register::word(replayed.max(1), 0, about));
        let when_replaying = |about: &str| Optional::new(replayed > 0, Local::bit(about));
        ChipHistory {
            i_clk: Input::bit("one chip per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_chip: Input::bit("next chip of the reference"),
            i_step_end: Optional::new(
                geometry.chips() > 0,
                Input::bit("last clock of a phase step"),
            ),
            i_wrap: Optional::new(
                geometry.grows_by_samples(),
                Input::bit("last clock of a step after which the delay grows by a chip more"),
            ),
            i_start: Optional::new(realigns, Input::bit("a scan begins with the next clock")),
            o_advance: Output::bit("the reference generator goes on to its next chip"),
            o_chips: Output::word(
                geometry.window_chips(),
                "reference chips, the present one in bit 0",
            ),
            about: describe(geometry),
            chips_load: Constant::new(
                start.chips,
                kept,
                "Reference chips after reset and at a scan's start",
            ),
            chips: Register::word(
                kept,
                start.chips,
                "reference chips, the present one in bit 0, those before it above",
            )
            .reset_to("chips_load"),
            saved: replays("chips that the reference went back by, the next one on top"),
            replays: replays("which of them are still to come again"),
            hold: when_replaying("the reference generator waits"),
            chip: when_replaying("chip that comes next"),
            _chips: kept as usize,
            _window_chips: geometry.window_chips() as usize,
            _step_chips: geometry.chips() as usize,
            _replayed: replayed as usize,
        }
    }
}

fn describe(geometry: PhaseGeometry) -> About {
    let mut about = About::new(
        "chip_history",
        "the reference's last chips, delayed by holding its generator",
    );
    if geometry.most_chips() > 1 {
        about = about.note(
            "When the delay grows by several chips, the reference goes back by all but one of \
             them; those come again from a register while the generator waits.",
        );
    }
    about
        .fact("Latency", "1 clock from i_chip to o_chips")
        .fact("Rate", "one chip per clock")
}

impl Logic for ChipHistory {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, chips);
        for _within_a_chip in self.i_step_end.count()..1 {
            self.o_advance.next = !self.i_wrap[0].val();
            if !self.i_wrap[0].val() {
                self.chips.d.next =
                    (self.chips.q.val() << 1) | bit_cast(self.i_chip.val(), self._chips);
            }
        }
        for _whole_chips in 0..self.i_step_end.count() {
            for _one_chip in self.saved.count()..1 {
                self.o_advance.next = !self.i_step_end[0].val();
            }
            for _replays in 0..self.saved.count() {
                dff_setup!(self, i_clk, saved[0], replays[0]);
                for top in (self._replayed.saturating_sub(1))..self._replayed {
                    self.hold[0].next =
                        self.i_step_end[0].val() | self.replays[0].q.val().get_bit(top);
                    if self.replays[0].q.val().get_bit(top) {
                        self.chip[0].next = self.saved[0].q.val().get_bit(top);
                    } else {
                        self.chip[0].next = self.i_chip.val();
                    }
                }
                self.o_advance.next = !self.hold[0].val();
                self.saved[0].d.next = self.saved[0].q.val() << 1;
                self.replays[0].d.next = self.replays[0].q.val() << 1;
            }
            for back in self._step_chips..(self._step_chips + 1) {
                if self.i_step_end[0].val() {
                    self.chips.d.next = self.chips.q.val() >> (back - 1);
                    for _replays in 0..self.saved.count() {
                        for _by_samples in 0..self.i_wrap.count() {
                            self.saved[0].d.next =
                                bit_cast(self.chips.q.val(), self._replayed) << 1;
                            self.replays[0].d.next = !bit_cast(false, self._replayed) << 1;
                        }
                        for _by_chips in self.i_wrap.count()..1 {
                            self.saved[0].d.next = bit_cast(self.chips.q.val(), self._replayed);
                            self.replays[0].d.next = !bit_cast(false, self._replayed);
                        }
                    }
                } else {
                    for _one_chip in self.saved.count()..1 {
                        self.chips.d.next =
                            (self.chips.q.val() << 1) | bit_cast(self.i_chip.val(), self._chips);
                    }
                    for _replays in 0..self.saved.count() {
                        self.chips.d.next =
                            (self.chips.q.val() << 1) | bit_cast(self.chip[0].val(), self._chips);
                    }
                }
                for _by_samples in 0..self.i_wrap.count() {
                    if self.i_wrap[0].val() {
                        self.chips.d.next = self.chips.q.val() >> back;
                        self.saved[0].d.next = bit_cast(self.chips.q.val(), self._replayed);
                        self.replays[0].d.next = !bit_cast(false, self._replayed);
                    }
                }
            }
        }

        for _realigns in 0..self.i_start.count() {
            if self.i_start[0].val() {
                self.chips.d.next = self.chips_load.val();
                for _replays in 0..self.saved.count() {
                    self.replays[0].d.next = 0.into();
                }
            }
        }
        self.o_chips.next = bit_cast(self.chips.q.val(), self._window_chips);
    }
}
