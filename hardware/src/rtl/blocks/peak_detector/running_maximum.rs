//! A detector's largest count in a scan, and its phase step. The schedule is shared by all detectors.

use super::{CountChoice, CountComparison};
use crate::rtl::front::prelude::*;
use crate::sensor::peak::PeakPlan;

#[block(running_maximum)]
/// a detector's largest count in a scan, and its phase step
///
/// A count that is greater than the largest so far replaces it; of equal ones the first stays (eq. 15).
/// The scan's largest stands at the outputs until the next scan's.
///
/// - Latency: {plan.clocks_to_compare()} clocks from a count's turn to i_compared, 2 more until it is the
/// largest
pub struct RunningMaximum {
    plan: PeakPlan,
    /// Counts in each choice; none where a group has a single count.
    #[set(if plan.parallel > 1 { plan.choices() } else { Vec::new() })]
    choices: Vec<u32>,
    #[set(plan.parallel > 1)]
    has_turns: bool,
    /// Whether a count that was clamped just before waits for a clock.
    #[set(!has_turns && plan.choosing_clocks > 0)]
    waits: bool,
    #[set(waits || choices.len() > 1)]
    keeps: bool,
    /// Counts of every choice but a smaller last one.
    #[set(choices.first().map_or(0, |&counts| counts as usize))]
    choice_counts: usize,
    /// Choices of as many counts as the first.
    #[set(choices.iter().filter(|counts| **counts == choices[0]).count())]
    even_choices: usize,
    /// Counts of a smaller last choice; 0 without one.
    #[set(choices.get(even_choices).map_or(0, |&counts| counts as usize))]
    last_counts: usize,
    /// {count_about(plan.parallel)}
    #[each(_step in 0..plan.parallel)]
    #[width(plan.count_bits)]
    pub i_count: Vec<Input<Word>>,
    /// whose turn it is
    #[when(has_turns)]
    #[width(plan.parallel)]
    pub i_turn: Optional<Input<Word>>,
    /// the present count has been compared
    pub i_compared: Input<bool>,
    /// it is a scan's first
    pub i_first: Input<bool>,
    /// phase step of the count compared a clock ago
    #[width(plan.step_bits)]
    pub i_step: Input<Word>,
    /// the largest count so far is the scan's
    pub i_done: Input<bool>,
    /// phase step of the last scan's peak
    #[width(plan.step_bits)]
    pub o_step: Output<Word>,
    /// its count, signed
    #[width(plan.count_bits)]
    pub o_count: Output<Word>,
    #[each(_choice in 0..even_choices)]
    #[is(CountChoice::new(plan.count_bits, choice_counts))]
    choice: Vec<CountChoice>,
    #[when(last_counts > 0)]
    #[is(CountChoice::new(plan.count_bits, last_counts))]
    last_choice: Optional<CountChoice>,
    /// what was chosen
    #[when(choices.len() > 1)]
    #[width(plan.count_bits)]
    chosen: Optional<Local<Word>>,
    /// count to be compared
    #[when(keeps)]
    #[width(plan.count_bits)]
    kept: Optional<Register<Word>>,
    /// count to be compared
    #[width(plan.count_bits)]
    present: Local<Word>,
    #[is(CountComparison::new(plan))]
    comparison: CountComparison,
    /// the count is the largest so far
    replaces: Register<bool>,
    /// largest count so far
    #[width(plan.count_bits)]
    largest: Register<Word>,
    /// its phase step
    #[width(plan.step_bits)]
    best_step: Register<Word>,
    #[width(plan.step_bits)]
    step: Register<Word>,
    #[width(plan.count_bits)]
    count: Register<Word>,
}

fn count_about(parallel: u32) -> &'static str {
    match parallel {
        1 => "count of a phase step, signed",
        _ => "counts of the group's steps, signed, step 0 lowest",
    }
}

#[kernel]
impl Logic for RunningMaximum {
    fn update(&mut self) {
        if self.has_turns {
            self.choose();
        }
        self.take_present();
        self.comparison.i_count.next = self.present.val();
        self.comparison.i_other.next = self.largest.val();
        self.replaces.next =
            self.i_compared.val() & (self.i_first.val() | self.comparison.o_greater.val());
        if self.replaces.val() {
            self.largest.next = self.present.val();
            self.best_step.next = self.i_step.val();
        }
        if self.i_done.val() {
            self.step.next = self.best_step.val();
            self.count.next = self.largest.val();
        }
        connect! { self: step, count }
    }

    /// The count whose turn it is, out of some counts at a time.
    fn choose(&mut self) {
        let size = self.choice_counts;
        let even = self.even_choices;
        for c in 0..even {
            for t in 0..size {
                self.choice[c].i_count[t].next = self.i_count[size * c + t].val();
            }
            self.choice[c].i_turn.next = self.i_turn.val().slice(size * c, size);
        }
        if self.last_choice.is_present() {
            for t in 0..self.last_counts {
                self.last_choice.i_count[t].next = self.i_count[size * even + t].val();
            }
            self.last_choice.i_turn.next = self.i_turn.val().slice(size * even, self.last_counts);
        }
        if self.chosen.is_present() {
            self.chosen.next = self.choice[0].o_count.val();
            for c in 1..even {
                self.chosen.next = self.chosen.val() | self.choice[c].o_count.val();
            }
            if self.last_choice.is_present() {
                self.chosen.next = self.chosen.val() | self.last_choice.o_count.val();
            }
        }
    }

    /// The count to be compared.
    fn take_present(&mut self) {
        if self.keeps {
            if self.waits {
                self.kept.next = self.i_count[0].val();
            } else {
                self.kept.next = self.chosen.val();
            }
            self.present.next = self.kept.val();
        } else if self.has_turns {
            self.present.next = self.choice[0].o_count.val();
        } else {
            self.present.next = self.i_count[0].val();
        }
    }
}
