//! Counts chips and phase steps.
//!
//! | port | |
//! |---|---|
//! | `i_epoch`, `o_start` | a code period begins; a scan does |
//! | `o_run`, `o_pre_last_chip`, `o_last_chip` | of the present chip |
//! | `o_dump` | a step's last hits are in the total |
//! | `o_pre_counted`, `o_counted`, `o_scan_counted` | its count is there |
//!
//! Latency: `o_dump` comes `clocks_to_dump` clocks after a step's last one. Both counters are
//! LFSRs: a binary counter of the same length would cost a carry chain and limit the clock.
//! Their ends are recognised early, so that every flag comes from a register.
//!
//! Cost (ECP5, docs/resources.md): 8 LUTs, 45 flip-flops.

use super::StateMatch;
use super::sequence_counter::SequenceCounter;
use crate::rtl::front::prelude::*;
use crate::sensor::interface::{Correlator, Interface};

/// Says when a phase step, and when a scan, ends. With several steps at once
/// a step here is a group of them.
#[block(describe(plan))]
pub struct ScanController {
    plan: ScanPlan,
    /// the next clock is the first of a code period
    #[when(plan.realigns)]
    pub i_epoch: Optional<Input<bool>>,
    /// the present chip belongs to a scan
    pub o_run: Output<bool>,
    /// it is the last but one of a phase step
    #[when(plan.looks_ahead())]
    pub o_pre_last_chip: Optional<Output<bool>>,
    /// it is the last of a phase step
    pub o_last_chip: Output<bool>,
    /// a scan begins with the next clock
    #[when(plan.realigns)]
    pub o_start: Optional<Output<bool>>,
    #[about(dump_about(plan.segments))]
    #[width(plan.segments)]
    pub o_dump: Output<Word>,
    /// the step's count is there in the next clock
    #[when(plan.counts_early)]
    pub o_pre_counted: Optional<Output<bool>>,
    /// the step's count is there
    pub o_counted: Output<bool>,
    /// the count of the scan's last step is there
    pub o_scan_counted: Output<bool>,
    #[when(plan.counts_chips())]
    #[under(plan.chip_counter().heading("Chip counter"))]
    #[about("")]
    #[width(plan.chip_counter().width())]
    #[value(plan.chip_counter().taps())]
    chip_count_taps: Optional<Constant>,
    /// one shift before a step's first chip
    #[when(plan.counts_chips() && !plan.realigns)]
    #[under(plan.chip_counter().heading("Chip counter"))]
    #[width(plan.chip_counter().width())]
    #[value(plan.chip_counter().state_before_the_first())]
    chip_count_reset: Optional<Constant>,
    /// at a step's first chip
    #[when(plan.counts_chips())]
    #[under(plan.chip_counter().heading("Chip counter"))]
    #[width(plan.chip_counter().width())]
    #[value(plan.chip_counter().state(0))]
    chip_count_first: Optional<Constant>,
    #[when(plan.counts_chips())]
    #[under(plan.chip_counter().heading("Chip counter"))]
    #[about(plan.chip_count_end_about())]
    #[width(plan.chip_counter().width())]
    #[value(plan.chip_counter().state(plan.chips_at_end()))]
    chip_count_end: Optional<Constant>,
    #[when(plan.counts_steps())]
    #[under(plan.step_counter().heading("Step counter"))]
    #[about("")]
    #[width(plan.step_counter().width())]
    #[value(plan.step_counter().taps())]
    step_count_taps: Optional<Constant>,
    /// at a scan's first step
    #[when(plan.counts_steps())]
    #[under(plan.step_counter().heading("Step counter"))]
    #[width(plan.step_counter().width())]
    #[value(plan.step_counter().state(0))]
    step_count_first: Optional<Constant>,
    #[when(plan.counts_steps())]
    #[under(plan.step_counter().heading("Step counter"))]
    #[about(format!("{}, one step before a scan's last", shifts_on(plan.steps_at_end())))]
    #[width(plan.step_counter().width())]
    #[value(plan.step_counter().state(plan.steps_at_end()))]
    step_count_end: Optional<Constant>,
    run: Register<bool>,
    #[is(plan.chip_count())]
    chip_count: Optional<Register<Word>>,
    #[when(plan.looks_ahead())]
    pre_last_chip: Optional<Register<bool>>,
    #[when(plan.looks_ahead())]
    last_chip: Optional<Register<bool>>,
    #[when(plan.counts_steps())]
    #[width(plan.step_counter().width())]
    #[reset(plan.step_counter().state(0), step_count_first)]
    step_count: Optional<Register<Word>>,
    /// the present step is the scan's last
    #[when(plan.counts_steps())]
    last_step: Optional<Register<bool>>,
    /// the present chip is the scan's last
    #[named("scan_last_chip")]
    #[when(plan.looks_ahead() && plan.counts_steps())]
    last_chip_of_scan: Optional<Register<bool>>,
    /// the present chip is a scan's last, or belongs to none
    #[when(plan.realigns && plan.looks_ahead())]
    #[reset(true)]
    may_start: Optional<Register<bool>>,
    #[when(plan.chip_count_in_pieces())]
    #[is(StateMatch::new(plan.chip_counter().width() as usize))]
    chip_count_match: Optional<StateMatch>,
    #[when(plan.step_count_in_pieces())]
    #[is(StateMatch::new(plan.step_counter().width() as usize))]
    step_count_match: Optional<StateMatch>,
    /// bit n: a step's last chip was n + 1 clocks ago
    #[width(plan.to_counted())]
    step_done: Register<Word>,
    /// bit n: a scan's last chip was n + 1 clocks ago
    #[width(plan.to_counted())]
    scan_done: Register<Word>,
    /// the present chip is the scan's last
    scan_last_chip: Local<bool>,
    #[when(plan.chip_count_in_pieces())]
    chip_count_matched: Optional<Local<bool>>,
    #[when(plan.step_count_in_pieces())]
    step_count_matched: Optional<Local<bool>>,
}

/// What a scan controller counts.
#[derive(Debug, Clone, Copy)]
pub struct ScanPlan {
    /// Chips per phase step.
    pub chips: u64,
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
    /// Whether `o_pre_counted` is there.
    pub counts_early: bool,
}

impl ScanPlan {
    /// That of a sensor.
    pub fn of(interface: &Interface, correlator: &Correlator) -> ScanPlan {
        let detectors = interface.reference_codes.len() as u32;
        ScanPlan {
            chips: interface.timing.scan.integration_chips,
            steps: interface.groups(),
            realigns: interface.realigns(),
            clocks_to_dump: Correlator::clocks_to_dump(interface.lanes()),
            segments: correlator.count_segments.count,
            clocks_to_count: correlator.clocks_of_counting(),
            counts_early: detectors * interface.parallel() > 1,
        }
    }

    /// Whether chips are counted; a step of one or two ends without.
    pub(super) fn counts_chips(&self) -> bool {
        self.chips > 2
    }

    pub(super) fn counts_steps(&self) -> bool {
        self.steps > 1
    }

    /// Whether a step's end is known a clock early.
    fn looks_ahead(&self) -> bool {
        self.chips > 1
    }

    /// Whether every other chip ends a step.
    fn toggles(&self) -> bool {
        self.chips == 2
    }

    pub(super) fn chip_counter(&self) -> SequenceCounter {
        SequenceCounter::new(self.chips.saturating_sub(2))
    }

    pub(super) fn step_counter(&self) -> SequenceCounter {
        SequenceCounter::new(self.steps.saturating_sub(1))
    }

    fn chip_count_in_pieces(&self) -> bool {
        self.chip_counter().width() > StateMatch::WIDEST_AT_ONCE
    }

    fn step_count_in_pieces(&self) -> bool {
        self.looks_ahead() && self.step_counter().width() > StateMatch::WIDEST_AT_ONCE
    }

    /// Chips counted when the step's end is recognised. A comparison in pieces
    /// takes a clock more.
    fn chips_at_end(&self) -> u64 {
        let early = 3 + u64::from(self.chip_count_in_pieces());
        self.chips.saturating_sub(early)
    }

    /// Steps counted when the scan's end is recognised.
    fn steps_at_end(&self) -> u64 {
        self.steps.saturating_sub(2)
    }

    fn chip_count_top(&self) -> usize {
        self.chip_counter().width() as usize - 1
    }

    fn step_count_top(&self) -> usize {
        self.step_counter().width() as usize - 1
    }

    fn to_dump(self) -> usize {
        self.clocks_to_dump as usize
    }

    fn to_counted(self) -> usize {
        (self.clocks_to_dump + self.clocks_to_count) as usize
    }

    fn chip_count(&self) -> Optional<Register<Word>> {
        let counter = self.chip_counter();
        let (first, constant) = if self.realigns {
            (counter.state(0), "chip_count_first")
        } else {
            // The clock between reset and run counts too, so that no enable is
            // needed: one made of logic costs an FPGA a global buffer and its
            // delay.
            (counter.state_before_the_first(), "chip_count_reset")
        };
        let register = Register::word(counter.width(), first, "");
        Optional::new(self.counts_chips().then(|| register.reset_to(constant)))
    }

    fn chip_count_end_about(&self) -> String {
        let early = self.chips - 1 - self.chips_at_end();
        let shifts = shifts_on(self.chips_at_end());
        format!("{shifts}, {early} chips before a step's last")
    }

    /// The states that have to follow from one another.
    fn checks(&self) -> Vec<StateCheck> {
        let check = |taps: &str, first: &str, shifts, last: &str| StateCheck {
            taps: taps.to_owned(),
            first: first.to_owned(),
            shifts,
            last: last.to_owned(),
        };
        let chips = |first, shifts, last| check("chip_count_taps", first, shifts, last);
        let mut checks = Vec::new();
        if self.counts_chips() {
            if !self.realigns {
                checks.push(chips("chip_count_reset", 1, "chip_count_first"));
            }
            checks.push(chips("chip_count_first", self.chips_at_end(), "chip_count_end"));
        }
        if self.counts_steps() {
            let shifts = self.steps_at_end();
            checks.push(check("step_count_taps", "step_count_first", shifts, "step_count_end"));
        }
        checks
    }
}

/// How a state comes of a counter's first.
fn shifts_on(shifts: u64) -> String {
    match shifts {
        0 => "the first".to_owned(),
        1 => "1 shift on".to_owned(),
        shifts => format!("{shifts} shifts on"),
    }
}

/// What stands beside a port that dumps totals of some segments.
pub(super) fn dump_about(segments: u32) -> &'static str {
    match segments {
        1 => "the total has just taken in a step's last hits",
        _ => "bit s: segment s has just taken in a step's last hits",
    }
}

fn describe(plan: ScanPlan) -> About {
    let mut about = About::new("scan_controller", "counts chips per phase step and steps per scan");
    if plan.counts_chips() || plan.counts_steps() {
        about = about.note(
            "Both counters are LFSRs: the next state costs one gate where a binary counter costs \
             a carry chain. A count's end is a state computed beforehand; it is recognised early, \
             so that every flag comes from a register.",
        );
    }
    let order = if plan.realigns {
        "A scan begins with a code period; until it does, o_run is low."
    } else {
        "Scans follow one another without a gap, because a scan over the whole code period ends \
         where it began."
    };
    about = about
        .note(order)
        .fact("Step", format!("{} chips", plan.chips))
        .fact("Scan", format!("{} phase steps", plan.steps))
        .fact(
            "Latency",
            format!("{} clocks from a step's last chip to o_dump", plan.clocks_to_dump),
        );
    plan.checks().into_iter().fold(about, About::check)
}

#[kernel]
impl Logic for ScanController {
    fn update(&mut self) {
        self.o_run.next = self.run.q.val();
        self.find_ends();
        if self.plan.realigns {
            self.wait_for_epoch();
        } else {
            self.run.d.next = true;
            if self.plan.toggles() {
                self.pre_last_chip.d.next = !self.pre_last_chip.q.val();
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

    /// The last chip of a step, and of a scan.
    fn find_ends(&mut self) {
        if self.plan.looks_ahead() {
            self.last_chip.d.next = self.pre_last_chip.q.val();
            self.o_pre_last_chip.next = self.pre_last_chip.q.val();
            self.o_last_chip.next = self.last_chip.q.val();
        } else {
            self.o_last_chip.next = self.run.q.val();
        }
        if self.last_chip_of_scan.is_present() {
            self.last_chip_of_scan.d.next = self.pre_last_chip.q.val() & self.last_step.q.val();
            self.scan_last_chip.next = self.last_chip_of_scan.q.val();
        } else if self.plan.counts_steps() {
            self.scan_last_chip.next = self.run.q.val() & self.last_step.q.val();
        } else {
            self.scan_last_chip.next = self.o_last_chip.val();
        }
    }

    /// A scan begins with an epoch.
    fn wait_for_epoch(&mut self) {
        if self.may_start.is_present() {
            self.o_start.next = self.i_epoch.val() & self.may_start.q.val();
        } else {
            self.o_start.next =
                self.i_epoch.val() & (!self.run.q.val() | self.scan_last_chip.val());
        }
        if self.o_start.val() {
            self.run.d.next = true;
        } else if self.scan_last_chip.val() {
            self.run.d.next = false;
        }
        if self.may_start.is_present() {
            if self.plan.counts_steps() {
                self.may_start.d.next = (self.pre_last_chip.q.val() & self.last_step.q.val())
                    | !(self.o_start.val() | (self.run.q.val() & !self.scan_last_chip.val()));
            } else {
                self.may_start.d.next = self.pre_last_chip.q.val()
                    | !(self.o_start.val() | (self.run.q.val() & !self.scan_last_chip.val()));
            }
        }
        if self.plan.toggles() {
            self.pre_last_chip.d.next =
                self.o_start.val() | (self.o_last_chip.val() & !self.scan_last_chip.val());
        }
    }

    fn count_chips(&mut self) {
        if self.plan.chip_count_in_pieces() {
            self.chip_count_match.i_state.next = self.chip_count.q.val();
            self.chip_count_match.i_wanted.next = self.chip_count_end.val();
            self.chip_count_matched.next = self.chip_count_match.o_matched.val();
            self.pre_last_chip.d.next = self.run.q.val() & self.chip_count_matched.val();
        } else {
            self.pre_last_chip.d.next =
                self.run.q.val() & (self.chip_count.q.val() == self.chip_count_end.val());
        }
        let top = self.plan.chip_count_top();
        if self.o_last_chip.val() {
            self.chip_count.d.next = self.chip_count_first.val();
        } else if self.plan.realigns {
            if self.run.q.val() {
                self.chip_count.d.next = (self.chip_count.q.val() >> 1)
                    .replace_bit(top, (self.chip_count.q.val() & self.chip_count_taps.val()).xor());
            }
        } else {
            self.chip_count.d.next = (self.chip_count.q.val() >> 1)
                .replace_bit(top, (self.chip_count.q.val() & self.chip_count_taps.val()).xor());
        }
    }

    fn count_steps(&mut self) {
        if self.plan.step_count_in_pieces() {
            self.step_count_match.i_state.next = self.step_count.q.val();
            self.step_count_match.i_wanted.next = self.step_count_end.val();
            self.step_count_matched.next = self.step_count_match.o_matched.val();
            if self.o_last_chip.val() {
                self.last_step.d.next = self.step_count_matched.val();
            }
        } else if self.o_last_chip.val() {
            self.last_step.d.next = self.step_count.q.val() == self.step_count_end.val();
        }
        if self.scan_last_chip.val() {
            self.step_count.d.next = self.step_count_first.val();
        } else if self.o_last_chip.val() {
            self.step_count.d.next = (self.step_count.q.val() >> 1).replace_bit(
                self.plan.step_count_top(),
                (self.step_count.q.val() & self.step_count_taps.val()).xor(),
            );
        }
    }

    /// Tells the rest when a step's hits, and its count, are there.
    fn report(&mut self) {
        self.step_done.d.next =
            (self.step_done.q.val() << 1).replace_bit(0, self.o_last_chip.val());
        self.scan_done.d.next =
            (self.scan_done.q.val() << 1).replace_bit(0, self.scan_last_chip.val());
        let dump = self.plan.to_dump() - 1;
        let counted = self.plan.to_counted() - 1;
        if self.plan.counts_early {
            self.o_pre_counted.next = self.step_done.q.val().get_bit(counted - 1);
        }
        self.o_counted.next = self.step_done.q.val().get_bit(counted);
        self.o_scan_counted.next = self.scan_done.q.val().get_bit(counted);
        self.o_dump.next = self.step_done.q.val().slice(dump, self.plan.segments as usize);
    }
}
