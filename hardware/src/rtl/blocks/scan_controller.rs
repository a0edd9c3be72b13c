//! Counts chips and phase steps.
//!
//! With several steps at once a step here is a group of them.
//!
//! Cost (ECP5, docs/resources.md): 8 LUTs, 45 flip-flops.

use super::sequence_counter::SequenceCounter;
use super::{StateMatch, StepEnds};
use crate::rtl::front::prelude::*;

#[block(scan_controller, .checks(checks(realigns, (counts_chips, chips_at_end), (counts_steps, steps_at_end))))]
/// counts chips per phase step and steps per scan
#[when(counts_chips || counts_steps)]
/// Both counters are LFSRs: the next state costs one gate where a binary counter costs a carry chain. A
/// count's end is a state computed beforehand; it is recognised early, so that every flag comes from a
/// register.
#[when(realigns)]
/// A scan begins with a code period; until it does, o_run is low.
#[when(!realigns)]
/// Scans follow one another without a gap, because a scan over the whole code period ends where it began.
///
/// - Step: {chips} chips
/// - Scan: {steps} phase steps
/// - Latency: {clocks_to_dump} clocks from a step's last chip to o_dump
pub struct ScanController {
    /// Chips per phase step.
    chips: u64,
    /// Steps, or groups of steps at once, per scan.
    steps: u64,
    /// A scan waits for the code's epoch.
    realigns: bool,
    /// Clocks from a step's last one until its hits are in the total.
    clocks_to_dump: u32,
    /// Segments of the total.
    segments: u32,
    /// Clocks from the dump of the lowest segment to the whole count.
    clocks_to_count: u32,
    /// Whether `o_pre_counted` is there.
    counts_early: bool,
    /// Whether chips are counted; a step of one or two ends without.
    #[set(chips > 2)]
    counts_chips: bool,
    #[set(steps > 1)]
    counts_steps: bool,
    /// Whether a step's end is known a clock early.
    #[set(chips > 1)]
    looks_ahead: bool,
    /// Whether every other chip ends a step.
    #[set(chips == 2)]
    toggles: bool,
    #[set(chip_counter(chips))]
    chip_counter: SequenceCounter,
    #[set(step_counter(steps))]
    step_counter: SequenceCounter,
    #[set(chip_counter.width() > StateMatch::WIDEST_AT_ONCE)]
    chip_count_in_pieces: bool,
    #[set(looks_ahead && step_counter.width() > StateMatch::WIDEST_AT_ONCE)]
    step_count_in_pieces: bool,
    /// Chips counted when the step's end is recognised. A comparison in pieces
    /// takes a clock more.
    #[set(chips.saturating_sub(3 + u64::from(chip_count_in_pieces)))]
    chips_at_end: u64,
    /// Steps counted when the scan's end is recognised.
    #[set(steps.saturating_sub(2))]
    steps_at_end: u64,
    /// Where chips are counted from after reset. Without realignment the clock between reset and
    /// run counts too, so that no enable is needed: one made of logic costs an FPGA a global
    /// buffer and its delay.
    #[set(if realigns { chip_counter.state(0) } else { chip_counter.state_before_the_first() })]
    chip_count_at_reset: u128,
    /// the next clock is the first of a code period
    #[when(realigns)]
    pub i_epoch: Optional<Input<bool>>,
    /// the present chip belongs to a scan
    pub o_run: Output<bool>,
    /// it is the last but one of a phase step
    #[when(looks_ahead)]
    pub o_pre_last_chip: Optional<Output<bool>>,
    /// it is the last of a phase step
    pub o_last_chip: Output<bool>,
    /// a scan begins with the next clock
    #[when(realigns)]
    pub o_start: Optional<Output<bool>>,
    #[when(counts_chips)]
    #[under(chip_counter.heading("Chip counter"))]
    #[width(chip_counter.width())]
    #[value(chip_counter.taps())]
    chip_count_taps: Optional<Constant>,
    /// one shift before a step's first chip
    #[when(counts_chips && !realigns)]
    #[width(chip_counter.width())]
    #[value(chip_counter.state_before_the_first())]
    chip_count_reset: Optional<Constant>,
    /// at a step's first chip
    #[when(counts_chips)]
    #[width(chip_counter.width())]
    #[value(chip_counter.state(0))]
    chip_count_first: Optional<Constant>,
    /// {shifts_on(chips_at_end)}, {chips - 1 - chips_at_end} chips before a step's last
    #[when(counts_chips)]
    #[width(chip_counter.width())]
    #[value(chip_counter.state(chips_at_end))]
    chip_count_end: Optional<Constant>,
    #[when(counts_steps)]
    #[under(step_counter.heading("Step counter"))]
    #[width(step_counter.width())]
    #[value(step_counter.taps())]
    step_count_taps: Optional<Constant>,
    /// at a scan's first step
    #[when(counts_steps)]
    #[width(step_counter.width())]
    #[value(step_counter.state(0))]
    step_count_first: Optional<Constant>,
    /// {shifts_on(steps_at_end)}, one step before a scan's last
    #[when(counts_steps)]
    #[width(step_counter.width())]
    #[value(step_counter.state(steps_at_end))]
    step_count_end: Optional<Constant>,
    run: Register<bool>,
    #[when(counts_chips)]
    #[is(Register::word(chip_counter.width(), chip_count_at_reset, "")
        .reset_to(if realigns { "chip_count_first" } else { "chip_count_reset" }))]
    chip_count: Optional<Register<Word>>,
    #[when(looks_ahead)]
    pre_last_chip: Optional<Register<bool>>,
    #[when(looks_ahead)]
    last_chip: Optional<Register<bool>>,
    #[when(counts_steps)]
    #[width(step_counter.width())]
    #[reset(step_counter.state(0), step_count_first)]
    step_count: Optional<Register<Word>>,
    /// the present step is the scan's last
    #[when(counts_steps)]
    last_step: Optional<Register<bool>>,
    /// the present chip is the scan's last
    #[named("scan_last_chip")]
    #[when(looks_ahead && counts_steps)]
    last_chip_of_scan: Optional<Register<bool>>,
    /// the present chip is a scan's last, or belongs to none
    #[when(realigns && looks_ahead)]
    #[reset(true)]
    may_start: Optional<Register<bool>>,
    #[when(chip_count_in_pieces)]
    #[is(StateMatch::new(chip_counter.width() as usize))]
    chip_count_match: Optional<StateMatch>,
    #[when(step_count_in_pieces)]
    #[is(StateMatch::new(step_counter.width() as usize))]
    step_count_match: Optional<StateMatch>,
    #[shown]
    #[is(StepEnds::new("", clocks_to_dump, segments, clocks_to_count, counts_early))]
    ends: StepEnds,
    /// the present chip is the scan's last
    scan_last_chip: Local<bool>,
    #[when(chip_count_in_pieces)]
    chip_count_matched: Optional<Local<bool>>,
    #[when(step_count_in_pieces)]
    step_count_matched: Optional<Local<bool>>,
}

/// Counts the chips of a step.
pub(super) fn chip_counter(chips: u64) -> SequenceCounter {
    SequenceCounter::new(chips.saturating_sub(2))
}

/// Counts the steps of a scan.
pub(super) fn step_counter(steps: u64) -> SequenceCounter {
    SequenceCounter::new(steps.saturating_sub(1))
}

/// The states that have to follow from one another: whether chips and steps are counted, and how
/// many until their ends.
fn checks(realigns: bool, chips: (bool, u64), steps: (bool, u64)) -> Vec<StateCheck> {
    let check = |counter: &str, first: &str, shifts, last: &str| StateCheck {
        taps: format!("{counter}_taps"),
        first: format!("{counter}_{first}"),
        shifts,
        last: format!("{counter}_{last}"),
    };
    let mut checks = Vec::new();
    if chips.0 && !realigns {
        checks.push(check("chip_count", "reset", 1, "first"));
    }
    for (counter, (counts, shifts)) in [("chip_count", chips), ("step_count", steps)] {
        if counts {
            checks.push(check(counter, "first", shifts, "end"));
        }
    }
    checks
}

/// How a state comes of a counter's first.
fn shifts_on(shifts: u64) -> String {
    match shifts {
        0 => "the first".to_owned(),
        1 => "1 shift on".to_owned(),
        shifts => format!("{shifts} shifts on"),
    }
}

#[kernel]
impl Logic for ScanController {
    fn update(&mut self) {
        self.o_run.next = self.run.val();
        self.find_ends();
        if self.realigns {
            self.wait_for_epoch();
        } else {
            self.run.next = true;
            if self.toggles {
                self.pre_last_chip.next = !self.pre_last_chip.val();
            }
        }
        if self.counts_chips {
            self.count_chips();
        }
        if self.counts_steps {
            self.count_steps();
        }
        self.ends.step_ends.next = self.o_last_chip.val();
        self.ends.scan_ends.next = self.scan_last_chip.val();
        self.ends.report();
    }

    /// The last chip of a step, and of a scan.
    fn find_ends(&mut self) {
        if self.looks_ahead {
            self.last_chip.next = self.pre_last_chip.val();
            connect! { self: pre_last_chip, last_chip }
        } else {
            self.o_last_chip.next = self.run.val();
        }
        if self.last_chip_of_scan.is_present() {
            self.last_chip_of_scan.next = self.pre_last_chip.val() & self.last_step.val();
            self.scan_last_chip.next = self.last_chip_of_scan.val();
        } else if self.counts_steps {
            self.scan_last_chip.next = self.run.val() & self.last_step.val();
        } else {
            self.scan_last_chip.next = self.o_last_chip.val();
        }
    }

    /// A scan begins with an epoch.
    fn wait_for_epoch(&mut self) {
        if self.may_start.is_present() {
            self.o_start.next = self.i_epoch.val() & self.may_start.val();
        } else {
            self.o_start.next = self.i_epoch.val() & (!self.run.val() | self.scan_last_chip.val());
        }
        if self.o_start.val() {
            self.run.next = true;
        } else if self.scan_last_chip.val() {
            self.run.next = false;
        }
        if self.may_start.is_present() {
            if self.counts_steps {
                self.may_start.next = (self.pre_last_chip.val() & self.last_step.val())
                    | !(self.o_start.val() | (self.run.val() & !self.scan_last_chip.val()));
            } else {
                self.may_start.next = self.pre_last_chip.val()
                    | !(self.o_start.val() | (self.run.val() & !self.scan_last_chip.val()));
            }
        }
        if self.toggles {
            self.pre_last_chip.next =
                self.o_start.val() | (self.o_last_chip.val() & !self.scan_last_chip.val());
        }
    }

    fn count_chips(&mut self) {
        if self.chip_count_in_pieces {
            self.chip_count_match.i_state.next = self.chip_count.val();
            self.chip_count_match.i_wanted.next = self.chip_count_end.val();
            self.chip_count_matched.next = self.chip_count_match.o_matched.val();
            self.pre_last_chip.next = self.run.val() & self.chip_count_matched.val();
        } else {
            self.pre_last_chip.next =
                self.run.val() & (self.chip_count.val() == self.chip_count_end.val());
        }
        if self.o_last_chip.val() {
            self.chip_count.next = self.chip_count_first.val();
        } else if self.realigns {
            if self.run.val() {
                self.shift_chip_count();
            }
        } else {
            self.shift_chip_count();
        }
    }

    fn shift_chip_count(&mut self) {
        let bits = self.chip_counter.width() as usize;
        self.chip_count.next = self.chip_count.val().advanced(bits, self.chip_count_taps.val());
    }

    fn count_steps(&mut self) {
        if self.step_count_in_pieces {
            self.step_count_match.i_state.next = self.step_count.val();
            self.step_count_match.i_wanted.next = self.step_count_end.val();
            self.step_count_matched.next = self.step_count_match.o_matched.val();
            if self.o_last_chip.val() {
                self.last_step.next = self.step_count_matched.val();
            }
        } else if self.o_last_chip.val() {
            self.last_step.next = self.step_count.val() == self.step_count_end.val();
        }
        if self.scan_last_chip.val() {
            self.step_count.next = self.step_count_first.val();
        } else if self.o_last_chip.val() {
            let bits = self.step_counter.width() as usize;
            self.step_count.next = self.step_count.val().advanced(bits, self.step_count_taps.val());
        }
    }
}
