//! Counts chips and phase steps.
//!
//! Latency: `o_dump` comes `clocks_to_dump` clocks after a step's last one. Both counters are
//! LFSRs: a binary counter of the same length would cost a carry chain and limit the clock.
//! Their ends are recognised early, so that every flag comes from a register.

use super::StateMatch;
use super::sequence_counter::SequenceCounter;
use crate::rtl::front::prelude::*;
use crate::sensor::contract::Contract;

/// Says when a phase step, and when a scan, ends. With several steps at once
/// a step here is a group of them.
#[block(ScanPlan)]
pub struct ScanController {
    /// one chip per cycle
    pub i_clk: Input<bool>,
    /// synchronous, active high
    pub i_rst: Input<bool>,
    /// the next clock is the first of a code period
    #[when(plan.realigns)]
    pub i_epoch: Optional<Input<bool>>,
    /// the present clock belongs to a scan
    pub o_run: Output<bool>,
    /// the next clock is the last of a phase step
    #[when(plan.looks_ahead())]
    pub o_step_ends: Optional<Output<bool>>,
    /// last clock of a phase step
    pub o_step_end: Output<bool>,
    /// a scan begins with the next clock
    #[when(plan.realigns)]
    pub o_start: Optional<Output<bool>>,
    /// the total has just taken in a step's last hits, segment by segment
    #[width(plan.segments)]
    pub o_dump: Output<Word>,
    /// the step's count is there in the next clock
    #[when(plan.counts_early)]
    pub o_counts: Optional<Output<bool>>,
    /// the step's count is there
    pub o_counted: Output<bool>,
    /// it is the scan's last
    pub o_last: Output<bool>,
    #[is(describe(*plan))]
    about: About,
    /// Chip counter a chip before a step's first
    #[when(plan.counts_chips() && !plan.realigns)]
    #[width(plan.dwell().width())]
    #[value(plan.dwell().state_before_the_first())]
    dwell_reset: Optional<Constant>,
    /// Chip counter at a step's first chip
    #[when(plan.counts_chips())]
    #[width(plan.dwell().width())]
    #[value(plan.dwell().state(0))]
    dwell_load: Optional<Constant>,
    /// Taps of the chip counter
    #[when(plan.counts_chips())]
    #[width(plan.dwell().width())]
    #[value(plan.dwell().taps())]
    dwell_taps: Optional<Constant>,
    #[when(plan.counts_chips())]
    #[about(if plan.dwell_in_pieces() {
        "Chip counter three chips before a step's last"
    } else {
        "Chip counter two chips before a step's last"
    })]
    #[width(plan.dwell().width())]
    #[value(plan.dwell().state(plan.dwell_count_at_end()))]
    dwell_ending: Optional<Constant>,
    /// Step counter at a scan's first step
    #[when(plan.counts_steps())]
    #[width(plan.step().width())]
    #[value(plan.step().state(0))]
    steps_load: Optional<Constant>,
    /// Taps of the step counter
    #[when(plan.counts_steps())]
    #[width(plan.step().width())]
    #[value(plan.step().taps())]
    steps_taps: Optional<Constant>,
    /// Step counter one step before a scan's last
    #[when(plan.counts_steps())]
    #[width(plan.step().width())]
    #[value(plan.step().state(plan.step_count_at_end()))]
    steps_ending: Optional<Constant>,
    /// the present clock belongs to a scan
    run: Register<bool>,
    #[is(plan.chip_counter())]
    dwell: Optional<Register<Word>>,
    /// the next clock is the last of a phase step
    #[when(plan.looks_ahead())]
    step_ends: Optional<Register<bool>>,
    /// last clock of a phase step
    #[when(plan.looks_ahead())]
    step_end: Optional<Register<bool>>,
    /// steps of the present scan
    #[when(plan.counts_steps())]
    #[width(plan.step().width())]
    #[reset(plan.step().state(0), steps_load)]
    steps: Optional<Register<Word>>,
    /// the present step is the scan's last
    #[when(plan.counts_steps())]
    last_step: Optional<Register<bool>>,
    /// last clock of a scan
    #[when(plan.looks_ahead() && plan.counts_steps())]
    scan_end: Optional<Register<bool>>,
    /// the present clock is a scan's last, or belongs to none
    #[when(plan.realigns && plan.looks_ahead())]
    #[reset(true)]
    may_start: Optional<Register<bool>>,
    #[when(plan.dwell_in_pieces())]
    #[is(StateMatch::new(plan.dwell().width()))]
    dwell_match: Optional<StateMatch>,
    #[when(plan.steps_in_pieces())]
    #[is(StateMatch::new(plan.step().width()))]
    steps_match: Optional<StateMatch>,
    /// the end of a step on its way through the correlator
    #[width(plan.to_counted())]
    step_ended: Register<Word>,
    /// the end of a scan on its way through the correlator
    #[width(plan.to_counted())]
    scan_ended: Register<Word>,
    /// last clock of a phase step
    ends_step: Local<bool>,
    /// last clock of a scan
    ends_scan: Local<bool>,
    /// dump of each segment
    #[width(plan.segments)]
    dumps: Wiring,
    plan: Plan<ScanPlan>,
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

impl ScanPlan {
    /// That of a sensor.
    pub fn of(contract: &Contract) -> ScanPlan {
        let detectors = contract.reference_codes.len() as u32;
        ScanPlan {
            dwell_chips: contract.timing.scan.integration_chips,
            steps: contract.groups(),
            realigns: contract.realigns(),
            clocks_to_dump: Contract::clocks_to_dump(contract.lanes()),
            segments: contract.count_segments.count,
            clocks_to_count: contract.clocks_of_counting(),
            counts_early: detectors * contract.parallel() > 1,
        }
    }

    /// Whether chips are counted; a step of one or two ends without.
    pub(super) fn counts_chips(&self) -> bool {
        self.dwell_chips > 2
    }

    pub(super) fn counts_steps(&self) -> bool {
        self.steps > 1
    }

    /// Whether a step's end is known a clock early.
    fn looks_ahead(&self) -> bool {
        self.dwell_chips > 1
    }

    /// Whether every other chip ends a step.
    fn toggles(&self) -> bool {
        self.dwell_chips == 2
    }

    pub(super) fn dwell(&self) -> SequenceCounter {
        SequenceCounter::new(self.dwell_chips.saturating_sub(2))
    }

    pub(super) fn step(&self) -> SequenceCounter {
        SequenceCounter::new(self.steps.saturating_sub(1))
    }

    fn dwell_in_pieces(&self) -> bool {
        self.dwell().width() > StateMatch::WIDEST_AT_ONCE
    }

    fn steps_in_pieces(&self) -> bool {
        self.looks_ahead() && self.step().width() > StateMatch::WIDEST_AT_ONCE
    }

    /// Chips counted when the step's end is recognised. A comparison in pieces
    /// takes a clock more.
    fn dwell_count_at_end(&self) -> u64 {
        let early = 3 + u64::from(self.dwell_in_pieces());
        self.dwell_chips.saturating_sub(early)
    }

    /// Steps counted when the scan's end is recognised.
    fn step_count_at_end(&self) -> u64 {
        self.steps.saturating_sub(2)
    }

    fn dwell_top(&self) -> usize {
        self.dwell().width() as usize - 1
    }

    fn steps_top(&self) -> usize {
        self.step().width() as usize - 1
    }

    fn to_dump(self) -> usize {
        self.clocks_to_dump as usize
    }

    fn to_counted(self) -> usize {
        (self.clocks_to_dump + self.clocks_to_count) as usize
    }

    fn chip_counter(&self) -> Optional<Register<Word>> {
        let counter = self.dwell();
        let (first, constant) = if self.realigns {
            (counter.state(0), "dwell_load")
        } else {
            // The clock between reset and run counts too, so that no enable is
            // needed: one made of logic costs an FPGA a global buffer and its
            // delay.
            (counter.state_before_the_first(), "dwell_reset")
        };
        let register = Register::word(counter.width(), first, "chips of the present step");
        Optional::new(self.counts_chips(), register.reset_to(constant))
    }
}

impl ScanController {
    /// A controller.
    pub fn new(plan: ScanPlan) -> ScanController {
        ScanController::build(&plan)
    }
}

fn describe(plan: ScanPlan) -> About {
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
    let order = if plan.realigns {
        "A scan begins with a code period; until it does, run is low."
    } else {
        "Scans follow one another without a gap, because a scan over the whole code period ends \
         where it began."
    };
    about
        .note(order)
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

#[kernel]
impl Logic for ScanController {
    fn update(&mut self) {
        dff_setup!(self, i_clk, run, step_ended, scan_ended);
        self.o_run.next = self.run.q.val();
        self.find_ends();
        if self.plan.realigns {
            self.wait_for_epoch();
        } else {
            self.run.d.next = true;
            if self.plan.toggles() {
                self.step_ends.d.next = !self.step_ends.q.val();
            }
        }
        if self.plan.counts_chips() {
            self.count_chips();
        }
        if self.plan.counts_steps() {
            self.count_steps();
        }
        self.report();
    }

    /// The last clock of a step, and of a scan.
    fn find_ends(&mut self) {
        if self.plan.looks_ahead() {
            dff_setup!(self, i_clk, step_ends, step_end);
            self.step_end.d.next = self.step_ends.q.val();
            self.ends_step.next = self.step_end.q.val();
            self.o_step_ends.next = self.step_ends.q.val();
            if self.plan.counts_steps() {
                dff_setup!(self, i_clk, scan_end);
                self.scan_end.d.next = self.step_ends.q.val() & self.last_step.q.val();
                self.ends_scan.next = self.scan_end.q.val();
            } else {
                self.ends_scan.next = self.step_end.q.val();
            }
        } else {
            self.ends_step.next = self.run.q.val();
            if self.plan.counts_steps() {
                self.ends_scan.next = self.run.q.val() & self.last_step.q.val();
            } else {
                self.ends_scan.next = self.run.q.val();
            }
        }
        self.o_step_end.next = self.ends_step.val();
    }

    /// A scan begins with an epoch.
    fn wait_for_epoch(&mut self) {
        if self.may_start.is_present() {
            self.o_start.next = self.i_epoch.val() & self.may_start.q.val();
        } else {
            self.o_start.next = self.i_epoch.val() & (!self.run.q.val() | self.ends_scan.val());
        }
        if self.o_start.val() {
            self.run.d.next = true;
        } else if self.ends_scan.val() {
            self.run.d.next = false;
        }
        if self.may_start.is_present() {
            dff_setup!(self, i_clk, may_start);
            if self.plan.counts_steps() {
                self.may_start.d.next = (self.step_ends.q.val() & self.last_step.q.val())
                    | !(self.o_start.val() | (self.run.q.val() & !self.ends_scan.val()));
            } else {
                self.may_start.d.next = self.step_ends.q.val()
                    | !(self.o_start.val() | (self.run.q.val() & !self.ends_scan.val()));
            }
        }
        if self.plan.toggles() {
            self.step_ends.d.next =
                self.o_start.val() | (self.ends_step.val() & !self.ends_scan.val());
        }
    }

    fn count_chips(&mut self) {
        dff_setup!(self, i_clk, dwell);
        if self.plan.dwell_in_pieces() {
            self.dwell_match.i_clk.next = self.i_clk.val();
            self.dwell_match.i_rst.next = self.i_rst.val();
            self.dwell_match.i_state.next = self.dwell.q.val();
            self.dwell_match.i_wanted.next = self.dwell_ending.val();
            self.step_ends.d.next = self.run.q.val() & self.dwell_match.o_matched.val();
        } else {
            self.step_ends.d.next =
                self.run.q.val() & (self.dwell.q.val() == self.dwell_ending.val());
        }
        let top = self.plan.dwell_top();
        if self.ends_step.val() {
            self.dwell.d.next = self.dwell_load.val();
        } else if self.plan.realigns {
            if self.run.q.val() {
                self.dwell.d.next = (self.dwell.q.val() >> 1)
                    .replace_bit(top, (self.dwell.q.val() & self.dwell_taps.val()).xor());
            }
        } else {
            self.dwell.d.next = (self.dwell.q.val() >> 1)
                .replace_bit(top, (self.dwell.q.val() & self.dwell_taps.val()).xor());
        }
    }

    fn count_steps(&mut self) {
        dff_setup!(self, i_clk, steps, last_step);
        if self.plan.steps_in_pieces() {
            self.steps_match.i_clk.next = self.i_clk.val();
            self.steps_match.i_rst.next = self.i_rst.val();
            self.steps_match.i_state.next = self.steps.q.val();
            self.steps_match.i_wanted.next = self.steps_ending.val();
            if self.ends_step.val() {
                self.last_step.d.next = self.steps_match.o_matched.val();
            }
        } else if self.ends_step.val() {
            self.last_step.d.next = self.steps.q.val() == self.steps_ending.val();
        }
        if self.ends_scan.val() {
            self.steps.d.next = self.steps_load.val();
        } else if self.ends_step.val() {
            self.steps.d.next = (self.steps.q.val() >> 1).replace_bit(
                self.plan.steps_top(),
                (self.steps.q.val() & self.steps_taps.val()).xor(),
            );
        }
    }

    /// Tells the rest when a step's hits, and its count, are there.
    fn report(&mut self) {
        self.step_ended.d.next =
            (self.step_ended.q.val() << 1).replace_bit(0, self.ends_step.val());
        self.scan_ended.d.next =
            (self.scan_ended.q.val() << 1).replace_bit(0, self.ends_scan.val());
        let dump = self.plan.to_dump() - 1;
        let counted = self.plan.to_counted() - 1;
        for s in 0..(self.plan.segments as usize) {
            self.dumps.i[s].next = self.step_ended.q.val().get_bit(dump + s);
        }
        if self.plan.counts_early {
            self.o_counts.next = self.step_ended.q.val().get_bit(counted - 1);
        }
        self.o_counted.next = self.step_ended.q.val().get_bit(counted);
        self.o_last.next = self.scan_ended.q.val().get_bit(counted);
        self.o_dump.next = self.dumps.o.val();
    }
}
