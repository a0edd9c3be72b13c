//! Finds the peak of every scan.
//!
//! Counts are compared one after another and in pieces, so that one short carry chain serves a detector; a
//! host that looks through the counts itself saves all of it.
//!
//! Cost (ECP5, docs/resources.md): 38 LUTs, 87 flip-flops with all that is in it.

mod count_choice;
mod count_comparison;
mod count_piece;
mod running_maximum;

pub use self::count_choice::CountChoice;
pub use self::count_comparison::CountComparison;
pub use self::count_piece::CountPiece;
use self::running_maximum::RunningMaximum;
use super::result_stream::counts_about;
use crate::rtl::front::prelude::*;
use crate::sensor::peak::PeakPlan;

#[block(peak_detector)]
/// phase step and count of every scan's largest count
///
/// The running argmax of the scan (eq. 15); the first of equal counts is the peak. It sits before the
/// result stream: counts that the stream loses take part.
#[when(has_turns)]
/// The counts of a group stand still until the next group's, and have their turns one after another.
///
/// - Latency: {plan.clocks_to_peak()} clocks from a scan's last i_counted to o_valid
/// - Rate: a count of each detector every {plan.clocks_per_count()} clocks
pub struct PeakDetector {
    plan: PeakPlan,
    detectors: usize,
    #[set(plan.parallel as usize)]
    parallel: usize,
    #[set(plan.step_bits as usize)]
    step_bits: usize,
    #[set(plan.count_bits as usize)]
    count_bits: usize,
    /// Whether the counts of a group have turns.
    #[set(plan.parallel > 1)]
    has_turns: bool,
    #[set(plan.wraps_after.is_some())]
    wraps: bool,
    #[set(plan.wraps_after == Some(plan.first_step))]
    starts_at_top: bool,
    #[set(plan.clocks_to_compare() as usize)]
    compared: usize,
    #[set(compared - 1)]
    last_compared: usize,
    #[set(plan.clocks_per_count() as usize)]
    clocks_per_count: usize,
    /// Counts of a scan's last group.
    #[set(plan.last_steps as usize)]
    last_steps: usize,
    /// {counts_about(detectors, parallel)}
    #[each(_count in 0..detectors * parallel)]
    #[width(plan.count_bits)]
    pub i_count: Vec<Input<Word>>,
    /// new counts are there
    pub i_counted: Input<bool>,
    /// they are the scan's last
    pub i_last: Input<bool>,
    /// phase step of the last scan's peak
    #[width(detectors * step_bits)]
    pub o_step: Output<Word>,
    /// its count, signed
    #[width(detectors * count_bits)]
    pub o_count: Output<Word>,
    /// they have just changed
    pub o_valid: Output<bool>,
    /// of a scan
    #[width(plan.step_bits)]
    #[value(u128::from(plan.first_step))]
    #[number]
    first_step: Constant,
    /// the step before the code period's last
    #[when(wraps)]
    #[width(plan.step_bits)]
    #[value(u128::from(plan.wraps_after.unwrap_or(1)).saturating_sub(1))]
    #[number]
    one_before_top: Optional<Constant>,
    #[when(has_turns)]
    #[width(plan.parallel)]
    #[value(1)]
    first_turn: Optional<Constant>,
    /// a count's turn on its way through the comparison
    #[width(compared)]
    compares: Register<Word>,
    /// the count that was compared is kept or dropped
    kept: Register<bool>,
    /// the counts are the scan's last
    last_group: Register<bool>,
    /// one bit: which count's turn it is
    #[when(has_turns)]
    #[width(plan.parallel)]
    turn: Optional<Register<Word>>,
    /// the group's last count has its turn
    #[when(has_turns)]
    last_turn: Optional<Local<bool>>,
    /// the count is its group's last
    #[when(has_turns)]
    group_ends: Optional<Register<bool>>,
    /// the count is its scan's last
    #[when(has_turns)]
    scan_ends: Optional<Register<bool>>,
    /// the next count's turn
    #[when(has_turns)]
    next_turn: Optional<Local<bool>>,
    /// the next count is a scan's first
    #[reset(true)]
    first: Register<bool>,
    /// it is the scan's last
    ends: Register<bool>,
    /// phase step of the count that was compared
    #[width(plan.step_bits)]
    #[reset(u128::from(plan.first_step), first_step)]
    step: Register<Word>,
    /// this phase step is the code period's last
    #[when(wraps)]
    #[reset(starts_at_top)]
    at_top: Optional<Register<bool>>,
    /// the scan's last count has been compared
    done: Register<bool>,
    /// o_step and o_count have just changed
    valid: Register<bool>,
    #[each(_detector in 0..detectors)]
    #[is(RunningMaximum::new(plan))]
    maximum: Vec<RunningMaximum>,
}

#[kernel]
impl Logic for PeakDetector {
    fn update(&mut self) {
        if self.i_counted.val() {
            self.last_group.next = self.i_last.val();
        }
        self.kept.next = self.compares.val().get_bit(self.last_compared);
        if self.has_turns {
            self.take_turns();
        } else {
            self.compares.next = self.compares.val().shifted_in(self.i_counted.val());
            self.ends.next =
                self.compares.val().get_bit(self.last_compared) & self.last_group.val();
        }
        self.count_steps();
        self.done.next = self.ends.val();
        self.valid.next = self.done.val();
        self.o_valid.next = self.valid.val();
        self.compare();
        self.show();
    }

    /// The counts of a group, one after another.
    fn take_turns(&mut self) {
        self.next_turn.next =
            self.compares.val().get_bit(self.clocks_per_count - 1) & !self.group_ends.val();
        self.compares.next =
            self.compares.val().shifted_in(self.i_counted.val() | self.next_turn.val());
        if self.i_counted.val() {
            self.turn.next = self.first_turn.val();
        } else if self.next_turn.val() {
            self.turn.next = self.turn.val() << 1;
        }
        let whole = self.parallel - 1;
        let short = self.last_steps - 1;
        if whole == short {
            self.last_turn.next = self.turn.val().get_bit(whole);
        } else if self.last_group.val() {
            self.last_turn.next = self.turn.val().get_bit(short);
        } else {
            self.last_turn.next = self.turn.val().get_bit(whole);
        }
        self.group_ends.next = self.last_turn.val();
        self.scan_ends.next = self.last_turn.val() & self.last_group.val();
        self.ends.next = self.compares.val().get_bit(self.last_compared) & self.scan_ends.val();
    }

    /// The phase step of the count that was compared.
    fn count_steps(&mut self) {
        if self.kept.val() {
            self.first.next = self.ends.val();
            self.step.next = self.step.val() + 1;
        }
        if self.at_top.is_present() {
            if self.kept.val() {
                self.at_top.next = self.step.val() == self.one_before_top.val();
                if self.at_top.val() {
                    self.step.next = 0.into();
                }
            }
            if self.ends.val() {
                self.at_top.next = self.starts_at_top;
            }
        }
        if self.ends.val() {
            self.step.next = self.first_step.val();
        }
    }

    fn compare(&mut self) {
        let parallel = self.parallel;
        for d in 0..self.detectors {
            for p in 0..parallel {
                self.maximum[d].i_count[p].next = self.i_count[d * parallel + p].val();
            }
            if self.has_turns {
                self.maximum[d].i_turn.next = self.turn.val();
            }
            self.maximum[d].i_compared.next = self.compares.val().get_bit(self.last_compared);
            self.maximum[d].i_first.next = self.first.val();
            self.maximum[d].i_step.next = self.step.val();
            self.maximum[d].i_done.next = self.done.val();
        }
    }

    /// The peaks of all detectors, the first one's lowest.
    fn show(&mut self) {
        let (step_bits, count_bits) = (self.step_bits, self.count_bits);
        self.o_step.next = gather(self.detectors * step_bits, |b| {
            self.maximum[b / step_bits].o_step.val().get_bit(b % step_bits)
        });
        self.o_count.next = gather(self.detectors * count_bits, |b| {
            self.maximum[b / count_bits].o_count.val().get_bit(b % count_bits)
        });
    }
}
