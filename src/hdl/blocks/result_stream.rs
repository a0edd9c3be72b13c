//! Counts as an AXI4-Stream.

use super::CountClamp;
use crate::hdl::front::prelude::*;

/// Offers the counts of a group of phase steps as a stream, one per beat:
/// the first detector's steps, then the next detector's.
#[derive(Debug, Clone, LogicBlock)]
pub struct ResultStream {
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
    /// The receiver takes the result.
    pub i_ready: Input<bool>,
    /// The count, sign-extended.
    pub o_data: Output<Word>,
    /// `o_data` and `o_last` hold a result.
    pub o_valid: Output<bool>,
    /// The result is the scan's last.
    pub o_last: Output<bool>,
    /// A result was lost since reset.
    pub o_overrun: Output<bool>,
    /// A count was clamped since reset.
    pub o_saturated: Optional<Output<bool>>,
    about: About,
    count: Vec<Register<Word>>,
    valid: Register<bool>,
    last: Register<bool>,
    overrun: Register<bool>,
    step: Optional<Register<Word>>,
    detector: Optional<Register<Word>>,
    saturated: Optional<Register<bool>>,
    clamp: Vec<CountClamp>,
    clamped: Optional<Wiring>,
    clamped_last: Optional<Wiring>,
    taken: Optional<Local<bool>>,
    row_ends: Optional<Local<bool>>,
    all_sent: Optional<Local<bool>>,
    blocked: Local<bool>,
    load: Local<bool>,
    _detectors: usize,
    _steps: usize,
    _last_steps: usize,
    _partial: usize,
    _several: usize,
    _data_bits: usize,
}

/// What a result stream carries.
#[derive(Debug, Clone, Copy)]
pub struct StreamPlan {
    /// Bits of the counts that come in.
    pub total_bits: u32,
    /// Bits of the counts that leave; fewer than `total_bits` saturate.
    pub count_bits: u32,
    /// Bits of the stream's words.
    pub data_bits: u32,
    /// Detectors.
    pub detectors: u32,
    /// Phase steps at once.
    pub steps: u32,
    /// Phase steps of a scan's last group.
    pub last_steps: u32,
}

impl ResultStream {
    /// A stream.
    pub fn new(plan: StreamPlan) -> ResultStream {
        let StreamPlan {
            total_bits,
            count_bits,
            data_bits,
            detectors,
            steps,
            ..
        } = plan;
        let counts = (detectors * steps) as usize;
        let saturates = count_bits < total_bits;
        let clamps = if saturates { counts } else { 0 };
        let when_saturating = |part| Optional::new(saturates, part);
        let when_several = |part| Optional::new(counts > 1, part);
        let of = |count: usize| (count as u32 / steps, count as u32 % steps);
        let count_about = |count: usize| match (detectors, steps, of(count)) {
            (1, 1, _) => "count of the step, signed".to_owned(),
            (1, _, (_, step)) => format!("count of step {step} of the group, signed"),
            (_, 1, (detector, _)) => format!("count of detector {detector}, signed"),
            (_, _, (detector, step)) => {
                format!("count of detector {detector}, step {step} of the group, signed")
            }
        };
        let token =
            |count: u32, about: &str| Optional::new(count > 1, Register::word(count, 1, about));
        ResultStream {
            i_clk: Input::bit("at most one group of counts per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_count: (0..counts)
                .map(|count| Input::word(total_bits, count_about(count)))
                .collect(),
            i_counted: Input::bit("new counts are there"),
            i_last: Input::bit("they are the scan's last"),
            i_ready: Input::bit("the receiver takes the result"),
            o_data: Output::word(data_bits, "count of the step, signed"),
            o_valid: Output::bit("a result waits"),
            o_last: Output::bit("the result is the scan's last"),
            o_overrun: Output::bit("a result was lost since reset"),
            o_saturated: Optional::new(saturates, Output::bit("a count was clamped since reset")),
            about: describe(plan),
            count: (0..counts)
                .map(|count| Register::word(count_bits, 0, count_about(count)))
                .collect(),
            valid: Register::bit(false, "a result waits"),
            last: Register::bit(false, "the waiting results are the scan's last"),
            overrun: Register::bit(false, "a result was lost since reset"),
            step: token(steps, "one bit: the step whose count is offered"),
            detector: token(detectors, "one bit: the detector whose count is offered"),
            saturated: Optional::new(
                saturates,
                Register::bit(false, "a count was clamped since reset"),
            ),
            clamp: (0..clamps)
                .map(|_| CountClamp::new(total_bits, count_bits))
                .collect(),
            clamped: when_saturating(Wiring::new(
                counts,
                (0..counts).collect(),
                "counts that do not fit",
            )),
            clamped_last: Optional::new(
                saturates && plan.last_steps < steps,
                Wiring::new(
                    counts,
                    (0..counts)
                        .filter(|&count| of(count).1 < plan.last_steps)
                        .collect(),
                    "those among them that a scan's last group has",
                ),
            ),
            taken: when_several(Local::bit("the receiver takes a result")),
            row_ends: when_several(Local::bit("the result is its detector's last")),
            all_sent: when_several(Local::bit("the result is the group's last")),
            blocked: Local::bit("results still wait"),
            load: Local::bit("new counts are taken over"),
            _detectors: detectors as usize,
            _steps: steps as usize,
            _last_steps: plan.last_steps as usize,
            _partial: usize::from(plan.last_steps < steps),
            _several: usize::from(counts > 1),
            _data_bits: data_bits as usize,
        }
    }
}

fn describe(plan: StreamPlan) -> About {
    let mut about = About::new("result_stream", "counts of the phase steps as AXI4-Stream").note(
        "The sensor cannot stall: results that come while others still wait are lost, and \
         o_overrun stays high until reset.",
    );
    if plan.detectors * plan.steps > 1 {
        about = about.note(format!(
            "A group's {} counts leave in the order of detectors, each detector's in the order \
             of steps. The first register of the first row is offered; counts move up to it.",
            plan.detectors * plan.steps
        ));
    }
    if plan.last_steps < plan.steps {
        about = about.note(format!(
            "A scan's last group has {} steps; the surplus counts are not sent.",
            plan.last_steps
        ));
    }
    if plan.count_bits < plan.total_bits {
        about = about.note(
            "A count that does not fit is clamped to the nearest one that does, and o_saturated \
             stays high until reset.",
        );
    }
    about
        .fact("Latency", "1 clock from i_counted to o_valid")
        .fact("Rate", "one result per clock")
}

impl Logic for ResultStream {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, valid, last, overrun);
        for c in 0..(self.count.len()) {
            dff_setup!(self, i_clk, count[c]);
        }
        self.o_valid.next = self.valid.q.val();
        self.o_overrun.next = self.overrun.q.val();

        for _one in self._several..1 {
            self.o_last.next = self.last.q.val();
            self.blocked.next = self.valid.q.val() & !self.i_ready.val();
        }
        for _several in 0..self._several {
            for _one_step in self.step.count()..1 {
                self.row_ends[0].next = true;
            }
            for _steps in 0..self.step.count() {
                dff_setup!(self, i_clk, step[0]);
                for top in (self._steps - 1)..self._steps {
                    for _whole in self._partial..1 {
                        self.row_ends[0].next = self.step[0].q.val().get_bit(top);
                    }
                    for _partial in 0..self._partial {
                        for early in (self._last_steps - 1)..self._last_steps {
                            self.row_ends[0].next = self.step[0].q.val().get_bit(top)
                                | (self.last.q.val() & self.step[0].q.val().get_bit(early));
                        }
                    }
                }
            }
            for _one_detector in self.detector.count()..1 {
                self.all_sent[0].next = self.row_ends[0].val();
            }
            for _detectors in 0..self.detector.count() {
                dff_setup!(self, i_clk, detector[0]);
                for top in (self._detectors - 1)..self._detectors {
                    self.all_sent[0].next =
                        self.row_ends[0].val() & self.detector[0].q.val().get_bit(top);
                }
            }
            self.taken[0].next = self.valid.q.val() & self.i_ready.val();
            self.o_last.next = self.last.q.val() & self.all_sent[0].val();
            self.blocked.next = self.valid.q.val() & !(self.i_ready.val() & self.all_sent[0].val());
            if self.taken[0].val() & !self.all_sent[0].val() {
                for _steps in 0..self.step.count() {
                    self.step[0].d.next = self.step[0].q.val() << 1;
                }
                for p in 0..(self._steps - 1) {
                    self.count[p].d.next = self.count[p + 1].q.val();
                }
                if self.row_ends[0].val() {
                    for _detectors in 0..self.detector.count() {
                        self.detector[0].d.next = self.detector[0].q.val() << 1;
                    }
                    for _steps in 0..self.step.count() {
                        self.step[0].d.next = 1.into();
                    }
                    for row in self._steps..(self._steps + 1) {
                        for c in 0..(self._steps * (self._detectors - 1)) {
                            self.count[c].d.next = self.count[c + row].q.val();
                        }
                    }
                }
            }
        }

        self.load.next = self.i_counted.val() & !self.blocked.val();
        if self.load.val() {
            for c in 0..(self.count.len()) {
                for _exact in self.o_saturated.count()..1 {
                    self.count[c].d.next = self.i_count[c].val();
                }
                for _saturates in 0..self.o_saturated.count() {
                    self.count[c].d.next = self.clamp[c].o_count.val();
                }
            }
            self.last.d.next = self.i_last.val();
            for _steps in 0..self.step.count() {
                self.step[0].d.next = 1.into();
            }
            for _detectors in 0..self.detector.count() {
                self.detector[0].d.next = 1.into();
            }
        }
        for _saturates in 0..self.o_saturated.count() {
            dff_setup!(self, i_clk, saturated[0]);
            for c in 0..(self.count.len()) {
                self.clamp[c].i_count.next = self.i_count[c].val();
                self.clamped[0].i[c].next = self.clamp[c].o_clamped.val();
            }
            for _whole in self._partial..1 {
                if self.i_counted.val() & self.clamped[0].o.val().any() {
                    self.saturated[0].d.next = true;
                }
            }
            for _partial in 0..self._partial {
                for c in 0..(self.count.len()) {
                    self.clamped_last[0].i[c].next = self.clamp[c].o_clamped.val();
                }
                if self.i_counted.val()
                    & ((!self.i_last.val() & self.clamped[0].o.val().any())
                        | self.clamped_last[0].o.val().any())
                {
                    self.saturated[0].d.next = true;
                }
            }
            self.o_saturated[0].next = self.saturated[0].q.val();
        }
        self.valid.d.next = self.i_counted.val() | self.blocked.val();
        if self.i_counted.val() & self.blocked.val() {
            self.overrun.d.next = true;
        }
        self.o_data.next = bit_cast(signed_cast(self.count[0].q.val()), self._data_bits);
    }
}
