//! Counts as an AXI4-Stream.

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
    /// Which of them were clamped.
    pub i_clamped: Vec<Input<bool>>,
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
    whole_row: Optional<Constant>,
    short_row: Optional<Constant>,
    rows: Optional<Constant>,
    count: Vec<Register<Word>>,
    valid: Register<bool>,
    last: Register<bool>,
    overrun: Register<bool>,
    step: Optional<Register<Word>>,
    detector: Optional<Register<Word>>,
    saturated: Optional<Register<bool>>,
    clamped: Optional<Wiring>,
    clamped_last: Optional<Wiring>,
    row_ends: Optional<Local<bool>>,
    all_sent: Optional<Local<bool>>,
    replaces: Optional<Local<bool>>,
    moves: Optional<Local<bool>>,
    blocked: Local<bool>,
    load: Local<bool>,
    _several: usize,
    _skips: usize,
    _gap: usize,
    _data_bits: usize,
}

/// What a result stream carries.
#[derive(Debug, Clone, Copy)]
pub struct StreamPlan {
    /// Bits of the counts.
    pub count_bits: u32,
    /// Counts may have been clamped.
    pub saturates: bool,
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
            count_bits,
            saturates,
            data_bits,
            detectors,
            steps,
            last_steps,
        } = plan;
        let counts = (detectors * steps) as usize;
        let is_short = last_steps < steps;
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
        let token_start = |present: bool, count: u32, bits: u32, about: &str| {
            Optional::new(present, Constant::new(1 << (count - 1), bits, about))
        };
        ResultStream {
            i_clk: Input::bit("at most one group of counts per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_count: (0..counts)
                .map(|count| Input::word(count_bits, count_about(count)))
                .collect(),
            i_clamped: (0..if saturates { counts } else { 0 })
                .map(|count| Input::bit(format!("clamped: {}", count_about(count))))
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
            whole_row: token_start(steps > 1, steps, steps, "Steps of a group"),
            short_row: token_start(is_short, last_steps, steps, "Steps of a scan's last group"),
            rows: token_start(detectors > 1, detectors, detectors, "Detectors"),
            count: (0..counts)
                .map(|count| Register::word(count_bits, 0, count_about(count)))
                .collect(),
            valid: Register::bit(false, "a result waits"),
            last: Register::bit(false, "the waiting results are the scan's last"),
            overrun: Register::bit(false, "a result was lost since reset"),
            step: token(
                steps,
                "one bit: how many of the detector's steps come after",
            ),
            detector: token(detectors, "one bit: how many detectors come after"),
            saturated: Optional::new(
                saturates,
                Register::bit(false, "a count was clamped since reset"),
            ),
            clamped: Optional::new(
                saturates,
                Wiring::new(counts, (0..counts).collect(), "counts that were clamped"),
            ),
            clamped_last: Optional::new(
                saturates && is_short,
                Wiring::new(
                    counts,
                    (0..counts)
                        .filter(|&count| of(count).1 < last_steps)
                        .collect(),
                    "those among them that a scan's last group has",
                ),
            ),
            row_ends: when_several(Local::bit("the result is its detector's last")),
            all_sent: when_several(Local::bit("the result is the group's last")),
            replaces: when_several(Local::bit(
                "counts are there, and if a result waits it is a group's last",
            )),
            moves: when_several(Local::bit("the counts are replaced or move up")),
            blocked: Local::bit("results still wait"),
            load: Local::bit("new counts are taken over"),
            _several: usize::from(counts > 1),
            _skips: usize::from(is_short && detectors > 1),
            _gap: (steps - last_steps + 1) as usize,
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
        about = about
            .note(format!(
                "A group's {} counts leave in the order of detectors, each detector's in the \
                 order of steps. The first register is offered; counts move up to it.",
                plan.detectors * plan.steps
            ))
            .note(
                "Which way the many registers take is known without the receiver; whether they \
                 take it is one gate from registers and i_ready.",
            );
    }
    if plan.last_steps < plan.steps {
        about = about.note(format!(
            "A scan's last group has {} steps; the surplus counts are not sent.",
            plan.last_steps
        ));
    }
    if plan.saturates {
        about = about.note("o_saturated stays high until reset.");
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
                self.row_ends[0].next = self.step[0].q.val().get_bit(0);
            }
            for _one_detector in self.detector.count()..1 {
                self.all_sent[0].next = self.row_ends[0].val();
            }
            for _detectors in 0..self.detector.count() {
                dff_setup!(self, i_clk, detector[0]);
                self.all_sent[0].next =
                    self.row_ends[0].val() & self.detector[0].q.val().get_bit(0);
            }
            self.o_last.next = self.last.q.val() & self.all_sent[0].val();
            self.blocked.next = self.valid.q.val() & !(self.i_ready.val() & self.all_sent[0].val());
            self.replaces[0].next =
                self.i_counted.val() & (!self.valid.q.val() | self.all_sent[0].val());
            if self.valid.q.val() {
                self.moves[0].next =
                    self.i_ready.val() & (self.i_counted.val() | !self.all_sent[0].val());
            } else {
                self.moves[0].next = self.i_counted.val();
            }
            if self.moves[0].val() {
                for c in 0..(self.count.len() - 1) {
                    self.count[c].d.next = self.count[c + 1].q.val();
                }
                for gap in self._gap..(self._gap + 1) {
                    for _skips in 0..self._skips {
                        if self.row_ends[0].val() & self.last.q.val() {
                            for c in 0..(self.count.len() - self._gap) {
                                self.count[c].d.next = self.count[c + gap].q.val();
                            }
                        }
                    }
                }
                if self.replaces[0].val() {
                    for c in 0..(self.count.len()) {
                        self.count[c].d.next = self.i_count[c].val();
                    }
                }
            }
        }

        self.load.next = self.i_counted.val() & !self.blocked.val();
        if self.load.val() {
            for _one in self._several..1 {
                self.count[0].d.next = self.i_count[0].val();
            }
            self.last.d.next = self.i_last.val();
        }
        for _steps in 0..self.step.count() {
            if self.moves[0].val() {
                self.step[0].d.next = self.step[0].q.val() >> 1;
                if self.row_ends[0].val() | self.replaces[0].val() {
                    self.step[0].d.next = self.whole_row[0].val();
                    for _short in 0..self.short_row.count() {
                        if (self.replaces[0].val() & self.i_last.val())
                            | (!self.replaces[0].val() & self.last.q.val())
                        {
                            self.step[0].d.next = self.short_row[0].val();
                        }
                    }
                }
            }
        }
        for _detectors in 0..self.detector.count() {
            if self.moves[0].val() {
                if self.replaces[0].val() {
                    self.detector[0].d.next = self.rows[0].val();
                } else if self.row_ends[0].val() {
                    self.detector[0].d.next = self.detector[0].q.val() >> 1;
                }
            }
        }
        for _saturates in 0..self.o_saturated.count() {
            dff_setup!(self, i_clk, saturated[0]);
            for c in 0..(self.count.len()) {
                self.clamped[0].i[c].next = self.i_clamped[c].val();
            }
            for _whole in self.clamped_last.count()..1 {
                if self.i_counted.val() & self.clamped[0].o.val().any() {
                    self.saturated[0].d.next = true;
                }
            }
            for _short in 0..self.clamped_last.count() {
                for c in 0..(self.count.len()) {
                    self.clamped_last[0].i[c].next = self.i_clamped[c].val();
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
