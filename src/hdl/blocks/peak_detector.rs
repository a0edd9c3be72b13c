//! Finds the peak of every scan.

use super::RunningMaximum;
use crate::hdl::front::prelude::*;
use crate::model::peak::PeakPlan;

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
    whole_group: Optional<Constant>,
    short_group: Optional<Constant>,
    load: Optional<Wiring>,
    loads: Optional<Register<Word>>,
    waiting: Optional<Register<Word>>,
    last_group: Optional<Register<bool>>,
    first: Register<bool>,
    take: Local<bool>,
    ends: Local<bool>,
    taken: Optional<Register<Word>>,
    ended: Optional<Register<Word>>,
    takes_step: Local<bool>,
    ends_scan: Local<bool>,
    step: Register<Word>,
    at_top: Optional<Register<bool>>,
    done: Register<bool>,
    valid: Register<bool>,
    maximum: Vec<RunningMaximum>,
    steps: Optional<Wiring>,
    counts: Optional<Wiring>,
    _detectors: usize,
    _parallel: usize,
    _several: usize,
    _pieces: usize,
    _starts_at_top: usize,
    _step_bits: usize,
    _count_bits: usize,
}

impl PeakDetector {
    /// For `detectors` detectors.
    pub fn new(plan: &PeakPlan, detectors: u32) -> PeakDetector {
        let PeakPlan {
            step_bits,
            count_bits,
            pieces,
            parallel,
            has_queue,
            ..
        } = *plan;
        let first_step = u128::from(plan.first_step);
        let starts_at_top = plan.wraps_after == Some(plan.first_step);
        let is_short = plan.last_steps < parallel;
        let several = parallel > 1;
        let lags =
            |about: &str| Optional::new(pieces > 1, Register::word((pieces - 1).max(1), 0, about));
        let tokens = |steps: u32| u128::MAX >> (128 - steps);
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
            first_step: Constant::new(first_step, step_bits, "First phase step of a scan"),
            one_before_top: Optional::new(
                plan.wraps_after.is_some(),
                Constant::new(
                    u128::from(plan.wraps_after.unwrap_or(1)).saturating_sub(1),
                    step_bits,
                    "Phase step before the code period's last",
                ),
            ),
            whole_group: Optional::new(
                several,
                Constant::new(tokens(parallel), parallel, "Counts of a group"),
            ),
            short_group: Optional::new(
                several && is_short,
                Constant::new(
                    tokens(plan.last_steps),
                    parallel,
                    "Counts of a scan's last group",
                ),
            ),
            load: Optional::new(
                has_queue,
                Wiring::new(
                    pieces as usize,
                    (0..pieces as usize).collect(),
                    "counts are queued, the highest piece first",
                ),
            ),
            loads: Optional::new(
                has_queue && pieces > 1,
                Register::word((pieces - 1).max(1), 0, "the lower pieces are still to come"),
            ),
            waiting: Optional::new(
                has_queue,
                Register::word(parallel, 0, "a one for each count in the queue"),
            ),
            last_group: Optional::new(
                has_queue,
                Register::bit(false, "counts in the queue are the scan's last"),
            ),
            first: Register::bit(true, "the next count is a scan's first"),
            take: Local::bit("a count's highest piece is compared"),
            ends: Local::bit("the count is the scan's last"),
            taken: lags("counts on their way to the lowest piece"),
            ended: lags("the scan's last count on its way to the lowest piece"),
            takes_step: Local::bit("a count's lowest piece is compared"),
            ends_scan: Local::bit("it is the scan's last"),
            step: Register::word(
                step_bits,
                first_step,
                "phase step of the lowest piece's count",
            )
            .reset_to("first_step"),
            at_top: Optional::new(
                plan.wraps_after.is_some(),
                Register::bit(starts_at_top, "this phase step is the code period's last"),
            ),
            done: Register::bit(false, "the scan's last count has been compared"),
            valid: Register::bit(false, "o_step and o_count have just changed"),
            maximum: (0..detectors).map(|_| RunningMaximum::new(plan)).collect(),
            steps: packed(step_bits, "phase step of each detector's peak"),
            counts: packed(count_bits, "count of each detector's peak"),
            _detectors: detectors as usize,
            _parallel: parallel as usize,
            _several: usize::from(several),
            _pieces: pieces as usize,
            _starts_at_top: usize::from(starts_at_top),
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
    if plan.pieces > 1 {
        about = about.note(
            "Counts are compared in pieces, the highest first, each piece a clock behind the one \
             above it.",
        );
    }
    if plan.parallel > 1 {
        about = about.note(
            "The counts of a group wait in queues, and are compared one per clock while the next \
             group is counted.",
        );
    }
    let from_counted = u32::from(plan.has_queue) + plan.last_steps + plan.pieces;
    about
        .fact(
            "Latency",
            format!("{from_counted} clocks from a scan's last i_counted to o_valid"),
        )
        .fact("Rate", "one count of each detector per clock")
}

impl Logic for PeakDetector {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, first, step, done, valid);

        for _at_once in self.waiting.count()..1 {
            self.take.next = self.i_counted.val();
            self.ends.next = self.i_counted.val() & self.i_last.val();
        }
        for _queued in 0..self.waiting.count() {
            dff_setup!(self, i_clk, waiting[0], last_group[0]);
            self.load[0].i[0].next = self.i_counted.val();
            for _lower in 0..self.loads.count() {
                dff_setup!(self, i_clk, loads[0]);
                self.loads[0].d.next =
                    (self.loads[0].q.val() << 1).replace_bit(0, self.i_counted.val());
                for k in 1..self._pieces {
                    self.load[0].i[k].next = self.loads[0].q.val().get_bit(k - 1);
                }
            }
            self.take.next = self.waiting[0].q.val().get_bit(0);
            for _single in self._several..1 {
                self.waiting[0].d.next = bit_cast(self.i_counted.val(), 1);
                self.ends.next = self.take.val() & self.last_group[0].q.val();
            }
            for _several in 0..self._several {
                self.waiting[0].d.next = self.waiting[0].q.val() >> 1;
                self.ends.next = self.take.val()
                    & !self.waiting[0].q.val().get_bit(1)
                    & self.last_group[0].q.val();
            }
            if self.i_counted.val() {
                self.last_group[0].d.next = self.i_last.val();
                for _several in 0..self._several {
                    self.waiting[0].d.next = self.whole_group[0].val();
                }
            }
            for _short in 0..self.short_group.count() {
                if self.i_counted.val() & self.i_last.val() {
                    self.waiting[0].d.next = self.short_group[0].val();
                }
            }
        }
        if self.take.val() {
            self.first.d.next = self.ends.val();
        }

        for _one_piece in self.taken.count()..1 {
            self.takes_step.next = self.take.val();
            self.ends_scan.next = self.ends.val();
        }
        for _pieces in 0..self.taken.count() {
            dff_setup!(self, i_clk, taken[0], ended[0]);
            self.taken[0].d.next = (self.taken[0].q.val() << 1).replace_bit(0, self.take.val());
            self.ended[0].d.next = (self.ended[0].q.val() << 1).replace_bit(0, self.ends.val());
            for lowest in (self._pieces - 1)..self._pieces {
                self.takes_step.next = self.taken[0].q.val().get_bit(lowest - 1);
                self.ends_scan.next = self.ended[0].q.val().get_bit(lowest - 1);
            }
        }

        if self.takes_step.val() {
            self.step.d.next = self.step.q.val() + 1;
        }
        for _wraps in 0..self.at_top.count() {
            dff_setup!(self, i_clk, at_top[0]);
            if self.takes_step.val() {
                self.at_top[0].d.next = self.step.q.val() == self.one_before_top[0].val();
                if self.at_top[0].q.val() {
                    self.step.d.next = 0.into();
                }
            }
            if self.ends_scan.val() {
                for _at_top in 0..self._starts_at_top {
                    self.at_top[0].d.next = true;
                }
                for _below in self._starts_at_top..1 {
                    self.at_top[0].d.next = false;
                }
            }
        }
        if self.ends_scan.val() {
            self.step.d.next = self.first_step.val();
        }
        self.done.d.next = self.ends_scan.val();
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
            for _queued in 0..self.waiting.count() {
                self.maximum[d].i_load[0].next = self.load[0].o.val();
            }
            self.maximum[d].i_take.next = self.take.val();
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
