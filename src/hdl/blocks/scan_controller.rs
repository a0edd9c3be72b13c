//! Counts chips and phase steps.

use super::StateMatch;
use super::sequence_counter::SequenceCounter;
use crate::hdl::front::prelude::*;

/// Says when a phase step, and when a scan, ends. With several steps at once
/// a step here is a group of them.
#[derive(Debug, Clone, LogicBlock)]
pub struct ScanController {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// The next clock begins a code period.
    pub i_epoch: Optional<Input<bool>>,
    /// The present clock belongs to a scan.
    pub o_run: Output<bool>,
    /// The next clock is the last of a phase step.
    pub o_step_ends: Optional<Output<bool>>,
    /// Last clock of a phase step.
    pub o_step_end: Output<bool>,
    /// A scan begins with the next clock.
    pub o_start: Optional<Output<bool>>,
    /// A step's last hits are in the total; a bit for each of its segments.
    pub o_dump: Output<Word>,
    /// The step's count is there in the next clock.
    pub o_counts: Optional<Output<bool>>,
    /// The step's count is there.
    pub o_counted: Output<bool>,
    /// It is the scan's last.
    pub o_last: Output<bool>,
    about: About,
    dwell_reset: Optional<Constant>,
    dwell_load: Optional<Constant>,
    dwell_taps: Optional<Constant>,
    dwell_ending: Optional<Constant>,
    steps_load: Optional<Constant>,
    steps_taps: Optional<Constant>,
    steps_ending: Optional<Constant>,
    run: Register<bool>,
    dwell: Optional<Register<Word>>,
    step_ends: Optional<Register<bool>>,
    step_end: Optional<Register<bool>>,
    steps: Optional<Register<Word>>,
    last_step: Optional<Register<bool>>,
    scan_end: Optional<Register<bool>>,
    may_start: Optional<Register<bool>>,
    dwell_match: Optional<StateMatch>,
    steps_match: Optional<StateMatch>,
    step_ended: Register<Word>,
    scan_ended: Register<Word>,
    ends_step: Local<bool>,
    ends_scan: Local<bool>,
    dumps: Wiring,
    _toggles: usize,
    _single_chips: usize,
    _single_step: usize,
    _dwell_top: usize,
    _steps_top: usize,
    _to_dump: usize,
    _segments: usize,
    _to_count: usize,
}

/// What a scan controller counts.
#[derive(Debug, Clone, Copy)]
pub struct ScanPlan {
    /// Chips per phase step.
    pub dwell_chips: u64,
    /// Steps, or groups of steps at once, per scan.
    pub steps: u64,
    /// A scan waits for the code's epoch.
    pub realigns: bool,
    /// Clocks from a step's last one until its hits are in the total.
    pub clocks_to_dump: u32,
    /// Segments of the total.
    pub segments: u32,
    /// Clocks from the dump of the lowest segment to the whole count.
    pub clocks_to_count: u32,
    /// Whether `o_counts` is there.
    pub counts_early: bool,
}

impl ScanController {
    /// A controller.
    pub fn new(plan: ScanPlan) -> ScanController {
        let ScanPlan {
            dwell_chips,
            steps,
            realigns,
            ..
        } = plan;
        let counts_chips = dwell_chips > 2;
        let counts_steps = steps > 1;
        let looks_ahead = dwell_chips > 1;
        let dwell = SequenceCounter::new(dwell_chips.saturating_sub(2));
        let step = SequenceCounter::new(steps.saturating_sub(1));
        // A comparison in pieces takes a clock more.
        let dwell_in_pieces = dwell.width() > StateMatch::WIDEST_AT_ONCE;
        let dwell_ending = dwell.state(dwell_chips.saturating_sub(3 + u64::from(dwell_in_pieces)));
        let steps_ending = step.state(steps.saturating_sub(2));
        let chips = |part| Optional::new(counts_chips, part);
        let of_steps = |part| Optional::new(counts_steps, part);
        let constant = |value: u128, counter: &SequenceCounter, about: &str| {
            Constant::new(value, counter.width(), about)
        };
        let order = if realigns {
            "A scan begins with a code period; until it does, run is low."
        } else {
            "Scans follow one another without a gap, because a scan over the whole code period \
             ends where it began."
        };
        let pipeline = plan.clocks_to_dump + plan.clocks_to_count;
        let line = |about: &str| Register::word(pipeline, 0, about);
        ScanController {
            i_clk: Input::bit("one chip per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_epoch: Optional::new(
                realigns,
                Input::bit("the next clock is the first of a code period"),
            ),
            o_run: Output::bit("the present clock belongs to a scan"),
            o_step_ends: Optional::new(
                looks_ahead,
                Output::bit("the next clock is the last of a phase step"),
            ),
            o_step_end: Output::bit("last clock of a phase step"),
            o_start: Optional::new(realigns, Output::bit("a scan begins with the next clock")),
            o_dump: Output::word(
                plan.segments,
                "the total has just taken in a step's last hits, segment by segment",
            ),
            o_counts: Optional::new(
                plan.counts_early,
                Output::bit("the step's count is there in the next clock"),
            ),
            o_counted: Output::bit("the step's count is there"),
            o_last: Output::bit("it is the scan's last"),
            about: about(plan).note(order),
            dwell_reset: Optional::new(
                counts_chips && !realigns,
                constant(
                    dwell.state_before_the_first(),
                    &dwell,
                    "Chip counter a chip before a step's first",
                ),
            ),
            dwell_load: chips(constant(
                dwell.state(0),
                &dwell,
                "Chip counter at a step's first chip",
            )),
            dwell_taps: chips(constant(dwell.taps(), &dwell, "Taps of the chip counter")),
            dwell_ending: chips(constant(
                dwell_ending,
                &dwell,
                if dwell_in_pieces {
                    "Chip counter three chips before a step's last"
                } else {
                    "Chip counter two chips before a step's last"
                },
            )),
            steps_load: of_steps(constant(
                step.state(0),
                &step,
                "Step counter at a scan's first step",
            )),
            steps_taps: of_steps(constant(step.taps(), &step, "Taps of the step counter")),
            steps_ending: of_steps(constant(
                steps_ending,
                &step,
                "Step counter one step before a scan's last",
            )),
            run: Register::bit(false, "the present clock belongs to a scan"),
            dwell: Optional::new(
                counts_chips,
                if realigns {
                    Register::word(dwell.width(), dwell.state(0), "chips of the present step")
                        .reset_to("dwell_load$0")
                } else {
                    // The clock between reset and run counts too, so that no
                    // enable is needed: one made of logic costs an FPGA a global
                    // buffer and its delay.
                    let before = dwell.state_before_the_first();
                    Register::word(dwell.width(), before, "chips of the present step")
                        .reset_to("dwell_reset$0")
                },
            ),
            step_ends: Optional::new(
                looks_ahead,
                Register::bit(false, "the next clock is the last of a phase step"),
            ),
            step_end: Optional::new(
                looks_ahead,
                Register::bit(false, "last clock of a phase step"),
            ),
            steps: Optional::new(
                counts_steps,
                Register::word(step.width(), step.state(0), "steps of the present scan")
                    .reset_to("steps_load$0"),
            ),
            last_step: Optional::new(
                counts_steps,
                Register::bit(false, "the present step is the scan's last"),
            ),
            scan_end: Optional::new(
                looks_ahead && counts_steps,
                Register::bit(false, "last clock of a scan"),
            ),
            may_start: Optional::new(
                realigns && looks_ahead,
                Register::bit(
                    true,
                    "the present clock is a scan's last, or belongs to none",
                ),
            ),
            dwell_match: Optional::new(dwell_in_pieces, StateMatch::new(dwell.width())),
            steps_match: Optional::new(
                looks_ahead && step.width() > StateMatch::WIDEST_AT_ONCE,
                StateMatch::new(step.width()),
            ),
            step_ended: line("the end of a step on its way through the correlator"),
            scan_ended: line("the end of a scan on its way through the correlator"),
            ends_step: Local::bit("last clock of a phase step"),
            ends_scan: Local::bit("last clock of a scan"),
            dumps: Wiring::new(
                plan.segments as usize,
                (0..plan.segments as usize).collect(),
                "dump of each segment",
            ),
            _toggles: usize::from(dwell_chips == 2),
            _single_chips: usize::from(!looks_ahead),
            _single_step: usize::from(!counts_steps),
            _dwell_top: dwell.width() as usize - 1,
            _steps_top: step.width() as usize - 1,
            _to_dump: plan.clocks_to_dump as usize,
            _segments: plan.segments as usize,
            _to_count: plan.clocks_to_count as usize,
        }
    }
}

fn about(plan: ScanPlan) -> About {
    let mut about = About::new(
        "scan_controller",
        "counts chips per phase step and steps per scan",
    );
    if plan.dwell_chips > 2 || plan.steps > 1 {
        about = about.note(
            "Both counters are LFSRs, which pass through as many states as a binary counter and \
             need no carry chain. The states in which they end were computed beforehand, and \
             are recognised a clock early, so that every flag comes from a register.",
        );
    }
    about
        .fact(
            "Dwell",
            format!("{} chips per phase step", plan.dwell_chips),
        )
        .fact("Scan", format!("{} phase steps", plan.steps))
        .fact(
            "Latency",
            format!(
                "{} clocks from a step's last one to o_dump",
                plan.clocks_to_dump
            ),
        )
}

impl Logic for ScanController {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, run, step_ended, scan_ended);
        self.o_run.next = self.run.q.val();

        for _single_chips in 0..self._single_chips {
            self.ends_step.next = self.run.q.val();
            for _single_step in 0..self._single_step {
                self.ends_scan.next = self.run.q.val();
            }
            for _several_steps in self._single_step..1 {
                self.ends_scan.next = self.run.q.val() & self.last_step[0].q.val();
            }
        }
        for _looks_ahead in self._single_chips..1 {
            dff_setup!(self, i_clk, step_ends[0], step_end[0]);
            self.step_end[0].d.next = self.step_ends[0].q.val();
            self.ends_step.next = self.step_end[0].q.val();
            self.o_step_ends[0].next = self.step_ends[0].q.val();
            for _single_step in 0..self._single_step {
                self.ends_scan.next = self.step_end[0].q.val();
            }
            for _several_steps in self._single_step..1 {
                dff_setup!(self, i_clk, scan_end[0]);
                self.scan_end[0].d.next = self.step_ends[0].q.val() & self.last_step[0].q.val();
                self.ends_scan.next = self.scan_end[0].q.val();
            }
        }
        self.o_step_end.next = self.ends_step.val();

        for _waits in 0..self.i_epoch.count() {
            for _at_once in self.may_start.count()..1 {
                self.o_start[0].next =
                    self.i_epoch[0].val() & (!self.run.q.val() | self.ends_scan.val());
            }
            for _known in 0..self.may_start.count() {
                self.o_start[0].next = self.i_epoch[0].val() & self.may_start[0].q.val();
            }
            if self.o_start[0].val() {
                self.run.d.next = true;
            } else if self.ends_scan.val() {
                self.run.d.next = false;
            }
            for _known in 0..self.may_start.count() {
                dff_setup!(self, i_clk, may_start[0]);
                for _single_step in 0..self._single_step {
                    self.may_start[0].d.next = self.step_ends[0].q.val()
                        | !(self.o_start[0].val() | (self.run.q.val() & !self.ends_scan.val()));
                }
                for _several_steps in self._single_step..1 {
                    self.may_start[0].d.next = (self.step_ends[0].q.val()
                        & self.last_step[0].q.val())
                        | !(self.o_start[0].val() | (self.run.q.val() & !self.ends_scan.val()));
                }
            }
            for _toggles in 0..self._toggles {
                self.step_ends[0].d.next =
                    self.o_start[0].val() | (self.ends_step.val() & !self.ends_scan.val());
            }
        }
        for _runs_on in self.i_epoch.count()..1 {
            self.run.d.next = true;
            for _toggles in 0..self._toggles {
                self.step_ends[0].d.next = !self.step_ends[0].q.val();
            }
        }

        for _counts_chips in 0..self.dwell.count() {
            dff_setup!(self, i_clk, dwell[0]);
            for _at_once in self.dwell_match.count()..1 {
                self.step_ends[0].d.next =
                    self.run.q.val() & (self.dwell[0].q.val() == self.dwell_ending[0].val());
            }
            for _in_pieces in 0..self.dwell_match.count() {
                self.dwell_match[0].i_clk.next = self.i_clk.val();
                self.dwell_match[0].i_rst.next = self.i_rst.val();
                self.dwell_match[0].i_state.next = self.dwell[0].q.val();
                self.dwell_match[0].i_wanted.next = self.dwell_ending[0].val();
                self.step_ends[0].d.next = self.run.q.val() & self.dwell_match[0].o_matched.val();
            }
            for top in self._dwell_top..(self._dwell_top + 1) {
                for _waits in 0..self.i_epoch.count() {
                    if self.ends_step.val() {
                        self.dwell[0].d.next = self.dwell_load[0].val();
                    } else if self.run.q.val() {
                        self.dwell[0].d.next = (self.dwell[0].q.val() >> 1).replace_bit(
                            top,
                            (self.dwell[0].q.val() & self.dwell_taps[0].val()).xor(),
                        );
                    }
                }
                for _runs_on in self.i_epoch.count()..1 {
                    if self.ends_step.val() {
                        self.dwell[0].d.next = self.dwell_load[0].val();
                    } else {
                        self.dwell[0].d.next = (self.dwell[0].q.val() >> 1).replace_bit(
                            top,
                            (self.dwell[0].q.val() & self.dwell_taps[0].val()).xor(),
                        );
                    }
                }
            }
        }
        for _counts_steps in 0..self.steps.count() {
            dff_setup!(self, i_clk, steps[0], last_step[0]);
            for _at_once in self.steps_match.count()..1 {
                if self.ends_step.val() {
                    self.last_step[0].d.next = self.steps[0].q.val() == self.steps_ending[0].val();
                }
            }
            for _in_pieces in 0..self.steps_match.count() {
                self.steps_match[0].i_clk.next = self.i_clk.val();
                self.steps_match[0].i_rst.next = self.i_rst.val();
                self.steps_match[0].i_state.next = self.steps[0].q.val();
                self.steps_match[0].i_wanted.next = self.steps_ending[0].val();
                if self.ends_step.val() {
                    self.last_step[0].d.next = self.steps_match[0].o_matched.val();
                }
            }
            for top in self._steps_top..(self._steps_top + 1) {
                if self.ends_scan.val() {
                    self.steps[0].d.next = self.steps_load[0].val();
                } else if self.ends_step.val() {
                    self.steps[0].d.next = (self.steps[0].q.val() >> 1).replace_bit(
                        top,
                        (self.steps[0].q.val() & self.steps_taps[0].val()).xor(),
                    );
                }
            }
        }

        self.step_ended.d.next =
            (self.step_ended.q.val() << 1).replace_bit(0, self.ends_step.val());
        self.scan_ended.d.next =
            (self.scan_ended.q.val() << 1).replace_bit(0, self.ends_scan.val());
        for dump in self._to_dump..(self._to_dump + 1) {
            for s in 0..self._segments {
                self.dumps.i[s].next = self.step_ended.q.val().get_bit(dump - 1 + s);
            }
            for count in self._to_count..(self._to_count + 1) {
                for _early in 0..self.o_counts.count() {
                    self.o_counts[0].next = self.step_ended.q.val().get_bit(dump + count - 2);
                }
                self.o_counted.next = self.step_ended.q.val().get_bit(dump + count - 1);
                self.o_last.next = self.scan_ended.q.val().get_bit(dump + count - 1);
            }
        }
        self.o_dump.next = self.dumps.o.val();
    }
}
