//! Finds the peak of every scan.

use super::RunningMaximum;
use crate::rtl::front::prelude::*;
use crate::sensor::peak::PeakPlan;

/// Running argmax over the scan (eq. 15), for every detector.
#[derive(Debug, Clone, LogicBlock)]
pub struct PeakDetector {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Counts, detector by detector.
    pub i_count: Vec<Input<Word>>,
    /// New counts are there.
    pub i_counted: Input<bool>,
    /// They are the scan's last.
    pub i_last: Input<bool>,
    /// Phase step of the last scan's peak, detector by detector.
    pub o_step: Output<Word>,
    /// Its count.
    pub o_count: Output<Word>,
    /// They have just changed.
    pub o_valid: Output<bool>,
    about: About,
    first_step: Constant,
    one_before_top: Optional<Constant>,
    first_turn: Optional<Constant>,
    compares: Register<Word>,
    kept: Register<bool>,
    last_group: Register<bool>,
    turn: Optional<Register<Word>>,
    last_turn: Optional<Local<bool>>,
    group_ends: Optional<Register<bool>>,
    scan_ends: Optional<Register<bool>>,
    next_turn: Optional<Local<bool>>,
    first: Register<bool>,
    ends: Register<bool>,
    step: Register<Word>,
    at_top: Optional<Register<bool>>,
    done: Register<bool>,
    valid: Register<bool>,
    maximum: Vec<RunningMaximum>,
    steps: Optional<Wiring>,
    counts: Optional<Wiring>,
    _detectors: usize,
    _parallel: usize,
    _starts_at_top: usize,
    _period: usize,
    _compared: usize,
    _turns: usize,
    _short_turns: usize,
    _step_bits: usize,
    _count_bits: usize,
}

impl PeakDetector {
    /// For `detectors` detectors.
    pub fn new(plan: &PeakPlan, detectors: u32) -> PeakDetector {
        let PeakPlan {
            step_bits,
            count_bits,
            parallel,
            last_steps,
            ..
        } = *plan;
        let first_step = u128::from(plan.first_step);
        let starts_at_top = plan.wraps_after == Some(plan.first_step);
        let several = parallel > 1;
        let compared = plan.clocks_to_compare();
        let packed = |bits: u32, about: &str| {
            let bits = (detectors * bits) as usize;
            Optional::new(detectors > 1, Wiring::new(bits, (0..bits).collect(), about))
        };
        PeakDetector {
            i_clk: Input::bit("at most one group of counts per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_count: (0..detectors * parallel)
                .map(|count| Input::word(count_bits, count_about(count, detectors, parallel)))
                .collect(),
            i_counted: Input::bit("new counts are there"),
            i_last: Input::bit("they are the scan's last"),
            o_step: Output::word(detectors * step_bits, "phase step of the last scan's peak"),
            o_count: Output::word(detectors * count_bits, "its count, signed"),
            o_valid: Output::bit("they have just changed"),
            about: describe(plan),
            first_step: Constant::new(first_step, step_bits, "of a scan"),
            one_before_top: Optional::new(
                plan.wraps_after.is_some(),
                Constant::new(
                    u128::from(plan.wraps_after.unwrap_or(1)).saturating_sub(1),
                    step_bits,
                    "the step before the code period's last",
                ),
            ),
            first_turn: Optional::new(several, Constant::new(1, parallel, "")),
            compares: Register::word(
                compared,
                0,
                "a count's turn on its way through the comparison",
            ),
            kept: Register::bit(false, "the count that was compared is kept or dropped"),
            last_group: Register::bit(false, "the counts are the scan's last"),
            turn: Optional::new(
                several,
                Register::word(parallel, 0, "one bit: which count's turn it is"),
            ),
            last_turn: Optional::new(several, Local::bit("the group's last count has its turn")),
            group_ends: Optional::new(
                several,
                Register::bit(false, "the count is its group's last"),
            ),
            scan_ends: Optional::new(
                several,
                Register::bit(false, "the count is its scan's last"),
            ),
            next_turn: Optional::new(several, Local::bit("the next count's turn")),
            first: Register::bit(true, "the next count is a scan's first"),
            ends: Register::bit(false, "it is the scan's last"),
            step: Register::word(
                step_bits,
                first_step,
                "phase step of the count that was compared",
            )
            .reset_to("first_step"),
            at_top: Optional::new(
                plan.wraps_after.is_some(),
                Register::bit(starts_at_top, "this phase step is the code period's last"),
            ),
            done: Register::bit(false, "the scan's last count has been compared"),
            valid: Register::bit(false, "o_step and o_count have just changed"),
            maximum: (0..detectors).map(|_| RunningMaximum::new(plan)).collect(),
            steps: packed(step_bits, ""),
            counts: packed(count_bits, ""),
            _detectors: detectors as usize,
            _parallel: parallel as usize,
            _starts_at_top: usize::from(starts_at_top),
            _period: plan.clocks_per_count() as usize,
            _compared: compared as usize,
            _turns: parallel as usize,
            _short_turns: last_steps as usize,
            _step_bits: step_bits as usize,
            _count_bits: count_bits as usize,
        }
    }
}

fn count_about(count: u32, detectors: u32, parallel: u32) -> String {
    let (detector, step) = (count / parallel, count % parallel);
    match (detectors, parallel) {
        (1, 1) => "count of a phase step, signed".to_owned(),
        (1, _) => format!("count of step {step} of the group, signed"),
        (_, 1) => format!("count of detector {detector}, signed"),
        _ => format!("count of detector {detector}, step {step} of the group, signed"),
    }
}

fn describe(plan: &PeakPlan) -> About {
    let mut about = About::new(
        "peak_detector",
        "phase step and count of every scan's largest count",
    )
    .note(
        "The running argmax of the scan (eq. 15); the first of equal counts is the peak. It sits \
         before the result stream: counts that the stream loses take part.",
    );
    if plan.parallel > 1 {
        about = about.note(
            "The counts of a group stand still until the next group's, and have their turns one \
             after another.",
        );
    }
    about
        .fact(
            "Latency",
            format!(
                "{} clocks from a scan's last i_counted to o_valid",
                plan.clocks_to_peak()
            ),
        )
        .fact(
            "Rate",
            format!(
                "a count of each detector every {} clocks",
                plan.clocks_per_count()
            ),
        )
}

impl Logic for PeakDetector {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(
            self, i_clk, compares, kept, last_group, ends, first, step, done, valid
        );
        if self.i_counted.val() {
            self.last_group.d.next = self.i_last.val();
        }
        for last in (self._compared - 1)..self._compared {
            self.kept.d.next = self.compares.q.val().get_bit(last);
        }
        for _single in self.turn.count()..1 {
            self.compares.d.next =
                (self.compares.q.val() << 1).replace_bit(0, self.i_counted.val());
            for last in (self._compared - 1)..self._compared {
                self.ends.d.next = self.compares.q.val().get_bit(last) & self.last_group.q.val();
            }
        }
        for _several in 0..self.turn.count() {
            dff_setup!(self, i_clk, turn[0], group_ends[0], scan_ends[0]);
            for period in self._period..(self._period + 1) {
                self.next_turn[0].next =
                    self.compares.q.val().get_bit(period - 1) & !self.group_ends[0].q.val();
            }
            self.compares.d.next = (self.compares.q.val() << 1)
                .replace_bit(0, self.i_counted.val() | self.next_turn[0].val());
            if self.i_counted.val() {
                self.turn[0].d.next = self.first_turn[0].val();
            } else if self.next_turn[0].val() {
                self.turn[0].d.next = self.turn[0].q.val() << 1;
            }
            for whole in (self._turns - 1)..self._turns {
                for _whole in (self._short_turns / self._turns)..1 {
                    for short in (self._short_turns - 1)..self._short_turns {
                        if self.last_group.q.val() {
                            self.last_turn[0].next = self.turn[0].q.val().get_bit(short);
                        } else {
                            self.last_turn[0].next = self.turn[0].q.val().get_bit(whole);
                        }
                    }
                }
                for _whole in 0..(self._short_turns / self._turns) {
                    self.last_turn[0].next = self.turn[0].q.val().get_bit(whole);
                }
            }
            self.group_ends[0].d.next = self.last_turn[0].val();
            self.scan_ends[0].d.next = self.last_turn[0].val() & self.last_group.q.val();
            for last in (self._compared - 1)..self._compared {
                self.ends.d.next = self.compares.q.val().get_bit(last) & self.scan_ends[0].q.val();
            }
        }

        if self.kept.q.val() {
            self.first.d.next = self.ends.q.val();
            self.step.d.next = self.step.q.val() + 1;
        }
        for _wraps in 0..self.at_top.count() {
            dff_setup!(self, i_clk, at_top[0]);
            if self.kept.q.val() {
                self.at_top[0].d.next = self.step.q.val() == self.one_before_top[0].val();
                if self.at_top[0].q.val() {
                    self.step.d.next = 0.into();
                }
            }
            if self.ends.q.val() {
                for _at_top in 0..self._starts_at_top {
                    self.at_top[0].d.next = true;
                }
                for _below in self._starts_at_top..1 {
                    self.at_top[0].d.next = false;
                }
            }
        }
        if self.ends.q.val() {
            self.step.d.next = self.first_step.val();
        }
        self.done.d.next = self.ends.q.val();
        self.valid.d.next = self.done.q.val();
        self.o_valid.next = self.valid.q.val();

        for d in 0..self._detectors {
            self.maximum[d].i_clk.next = self.i_clk.val();
            self.maximum[d].i_rst.next = self.i_rst.val();
            for parallel in self._parallel..(self._parallel + 1) {
                for p in 0..self._parallel {
                    self.maximum[d].i_count[p].next = self.i_count[d * parallel + p].val();
                }
            }
            for _several in 0..self.turn.count() {
                self.maximum[d].i_turn[0].next = self.turn[0].q.val();
            }
            for last in (self._compared - 1)..self._compared {
                self.maximum[d].i_compared.next = self.compares.q.val().get_bit(last);
            }
            self.maximum[d].i_first.next = self.first.q.val();
            self.maximum[d].i_step.next = self.step.q.val();
            self.maximum[d].i_done.next = self.done.q.val();
        }
        for _one_detector in self.steps.count()..1 {
            self.o_step.next = self.maximum[0].o_step.val();
            self.o_count.next = self.maximum[0].o_count.val();
        }
        for _detectors in 0..self.steps.count() {
            for d in 0..self._detectors {
                for bits in self._step_bits..(self._step_bits + 1) {
                    for b in 0..self._step_bits {
                        self.steps[0].i[bits * d + b].next =
                            self.maximum[d].o_step.val().get_bit(b);
                    }
                }
                for bits in self._count_bits..(self._count_bits + 1) {
                    for b in 0..self._count_bits {
                        self.counts[0].i[bits * d + b].next =
                            self.maximum[d].o_count.val().get_bit(b);
                    }
                }
            }
            self.o_step.next = self.steps[0].o.val();
            self.o_count.next = self.counts[0].o.val();
        }
    }
}
