//! A detector's largest count in a scan, and its phase step.

use super::{CountChoice, CountComparison};
use crate::rtl::front::prelude::*;
use crate::sensor::peak::PeakPlan;

/// Running argmax of one detector's counts (eq. 15), kept from a scan's end to
/// the next.
#[derive(Debug, Clone, LogicBlock)]
pub struct RunningMaximum {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Counts of the group's steps.
    pub i_count: Vec<Input<Word>>,
    /// Whose turn it is, if there are several.
    pub i_turn: Optional<Input<Word>>,
    /// The present count has been compared.
    pub i_compared: Input<bool>,
    /// It is the scan's first.
    pub i_first: Input<bool>,
    /// Phase step of the count that was compared a clock ago.
    pub i_step: Input<Word>,
    /// The largest count so far is the scan's.
    pub i_done: Input<bool>,
    /// Phase step of the last scan's peak.
    pub o_step: Output<Word>,
    /// Its count.
    pub o_count: Output<Word>,
    about: About,
    turns: Vec<Wiring>,
    choice: Vec<CountChoice>,
    up_to: Vec<Local<Word>>,
    kept: Optional<Register<Word>>,
    present: Local<Word>,
    comparison: CountComparison,
    replaces: Register<bool>,
    largest: Register<Word>,
    best_step: Register<Word>,
    step: Register<Word>,
    count: Register<Word>,
    _choice: usize,
    _last_choice: usize,
    _clamped: usize,
}

impl RunningMaximum {
    /// For the counts of one detector.
    pub fn new(plan: &PeakPlan) -> RunningMaximum {
        let PeakPlan {
            step_bits,
            count_bits,
            parallel,
            ..
        } = *plan;
        let choices = if parallel > 1 {
            plan.choices()
        } else {
            Vec::new()
        };
        let choice = choices.first().map_or(1, |&counts| counts as usize);
        let is_clamped = parallel == 1 && plan.choosing_clocks > 0;
        let keeps = is_clamped || choices.len() > 1;
        RunningMaximum {
            i_clk: Input::bit("at most one count per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_count: (0..parallel)
                .map(|step| Input::word(count_bits, count_about(step, parallel)))
                .collect(),
            i_turn: Optional::new(parallel > 1, Input::word(parallel, "whose turn it is")),
            i_compared: Input::bit("the present count has been compared"),
            i_first: Input::bit("it is a scan's first"),
            i_step: Input::word(step_bits, "phase step of the count compared a clock ago"),
            i_done: Input::bit("the largest count so far is the scan's"),
            o_step: Output::word(step_bits, "phase step of the last scan's peak"),
            o_count: Output::word(count_bits, "its count, signed"),
            about: describe(plan),
            turns: choices
                .iter()
                .map(|&counts| Wiring::new(counts as usize, (0..counts as usize).collect(), ""))
                .collect(),
            choice: choices
                .iter()
                .map(|&counts| CountChoice::new(count_bits, counts))
                .collect(),
            up_to: (0..choices.len().saturating_sub(1))
                .map(|choice| {
                    Local::word(
                        count_bits,
                        format!("what choices 0 to {} chose", choice + 1),
                    )
                })
                .collect(),
            kept: Optional::new(keeps, Register::word(count_bits, 0, "count to be compared")),
            present: Local::word(count_bits, "count to be compared"),
            comparison: CountComparison::new(plan),
            replaces: Register::bit(false, "the count is the largest so far"),
            largest: Register::word(count_bits, 0, "largest count so far"),
            best_step: Register::word(step_bits, 0, "its phase step"),
            step: Register::word(step_bits, 0, "phase step of the last scan's peak"),
            count: Register::word(count_bits, 0, "count of the last scan's peak"),
            _choice: choice,
            _last_choice: choices.last().map_or(1, |&counts| counts as usize),
            _clamped: usize::from(is_clamped),
        }
    }
}

fn count_about(step: u32, parallel: u32) -> String {
    match parallel {
        1 => "count of a phase step, signed".to_owned(),
        _ => format!("count of step {step} of the group, signed"),
    }
}

fn describe(plan: &PeakPlan) -> About {
    let about = About::new(
        "running_maximum",
        "a detector's largest count in a scan, and its phase step",
    )
    .note(
        "A count that is greater than the largest so far replaces it; of equal ones the first \
         stays (eq. 15). The scan's largest stands at the outputs until the next scan's.",
    );
    about.fact(
        "Latency",
        format!(
            "{} clocks from a count's turn to i_compared, 2 more until it is the largest",
            plan.clocks_to_compare()
        ),
    )
}

impl Logic for RunningMaximum {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, replaces, largest, best_step, step, count);
        for size in self._choice..(self._choice + 1) {
            for c in 0..(self.choice.len().saturating_sub(1)) {
                for t in 0..self._choice {
                    self.turns[c].i[t].next = self.i_turn[0].val().get_bit(size * c + t);
                    self.choice[c].i_count[t].next = self.i_count[size * c + t].val();
                }
            }
            for last in (self.choice.len().saturating_sub(1))..(self.choice.len()) {
                for t in 0..self._last_choice {
                    self.turns[last].i[t].next = self.i_turn[0].val().get_bit(size * last + t);
                    self.choice[last].i_count[t].next = self.i_count[size * last + t].val();
                }
            }
        }
        for c in 0..(self.choice.len()) {
            self.choice[c].i_clk.next = self.i_clk.val();
            self.choice[c].i_rst.next = self.i_rst.val();
            self.choice[c].i_turn.next = self.turns[c].o.val();
        }
        for _several in 0..(self.up_to.len().min(1)) {
            self.up_to[0].next = self.choice[0].o_count.val() | self.choice[1].o_count.val();
        }
        for c in 1..(self.up_to.len()) {
            self.up_to[c].next = self.up_to[c - 1].val() | self.choice[c + 1].o_count.val();
        }
        for _kept in 0..self.kept.count() {
            dff_setup!(self, i_clk, kept[0]);
            for _clamped in 0..self._clamped {
                self.kept[0].d.next = self.i_count[0].val();
            }
            for all in (self.up_to.len().saturating_sub(1))..(self.up_to.len()) {
                self.kept[0].d.next = self.up_to[all].val();
            }
            self.present.next = self.kept[0].q.val();
        }
        for _at_once in self.kept.count()..1 {
            for _single in self.i_turn.count()..1 {
                self.present.next = self.i_count[0].val();
            }
            for _one_choice in 0..self.i_turn.count() {
                self.present.next = self.choice[0].o_count.val();
            }
        }

        self.comparison.i_clk.next = self.i_clk.val();
        self.comparison.i_rst.next = self.i_rst.val();
        self.comparison.i_count.next = self.present.val();
        self.comparison.i_other.next = self.largest.q.val();
        self.replaces.d.next =
            self.i_compared.val() & (self.i_first.val() | self.comparison.o_greater.val());
        if self.replaces.q.val() {
            self.largest.d.next = self.present.val();
            self.best_step.d.next = self.i_step.val();
        }
        if self.i_done.val() {
            self.step.d.next = self.best_step.q.val();
            self.count.d.next = self.largest.q.val();
        }
        self.o_step.next = self.step.q.val();
        self.o_count.next = self.count.q.val();
    }
}
