//! Counts as an AXI4-Stream.

use crate::rtl::front::prelude::*;
use crate::sensor::contract::TotalCount;

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
    /// Total count of each detector, if they are sent.
    pub i_total: Vec<Input<Word>>,
    /// Which of them were clamped.
    pub i_clamped: Vec<Input<bool>>,
    /// New counts are there in the next clock; if there are several.
    pub i_pre_counted: Optional<Input<bool>>,
    /// New counts are there.
    pub i_counted: Input<bool>,
    /// They are the scan's last.
    pub i_last: Input<bool>,
    /// The receiver takes the result.
    pub i_ready: Input<bool>,
    /// The count, sign-extended, and above it the total, zero-extended.
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
    total: Optional<Register<Word>>,
    waiting_total: Vec<Register<Word>>,
    detector: Vec<Register<Word>>,
    valid: Register<bool>,
    last: Register<bool>,
    overrun: Register<bool>,
    ends: Optional<Register<bool>>,
    next_ends: Vec<Register<bool>>,
    moves_up: Optional<Register<bool>>,
    more: Optional<Register<bool>>,
    changes: Optional<Register<bool>>,
    saturated: Optional<Register<bool>>,
    clamped: Optional<Wiring>,
    clamped_last: Optional<Wiring>,
    later_ends: Optional<Local<bool>>,
    next: Optional<Local<Word>>,
    next_detector: Optional<Local<Word>>,
    signed_count: Optional<Local<Word>>,
    blocked: Local<bool>,
    load: Local<bool>,
    _single: usize,
    _detectors: usize,
    _steps: usize,
    _last_steps: usize,
    _compacts: usize,
    _is_short: usize,
    _short_at_once: usize,
    _whole_end: usize,
    _short_end: usize,
    _behind_whole: usize,
    _behind_short: usize,
    _first_later: usize,
    _first_short: usize,
    _first_whole: usize,
    _back_to_back: usize,
    _data_bits: usize,
    _signed_bits: usize,
    _further: usize,
}

/// What a result stream carries.
#[derive(Debug, Clone, Copy)]
pub struct StreamPlan {
    /// Bits of the counts.
    pub count_bits: u32,
    /// Counts may have been clamped.
    pub saturates: bool,
    /// The totals, if they are sent.
    pub total: Option<TotalCount>,
    /// Bits of the stream's words.
    pub data_bits: u32,
    /// Detectors.
    pub detectors: u32,
    /// Phase steps at once.
    pub steps: u32,
    /// Phase steps of a scan's last group.
    pub last_steps: u32,
    /// Groups may come in successive clocks.
    pub back_to_back: bool,
}

impl ResultStream {
    /// A stream.
    pub fn new(plan: StreamPlan) -> ResultStream {
        let StreamPlan {
            count_bits,
            saturates,
            total,
            data_bits,
            detectors,
            steps,
            last_steps,
            back_to_back,
        } = plan;
        let counts = (detectors * steps) as usize;
        let total_bits = total.map_or(1, |total| total.bits);
        // Detectors whose totals wait for their results' turn.
        let further = total.map_or(0, |_| detectors - 1);
        let is_short = last_steps < steps;
        let of = |count: usize| (count as u32 / steps, count as u32 % steps);
        let count_about = |count: usize| match (detectors, steps, of(count)) {
            (1, 1, _) => "count of the step, signed".to_owned(),
            (1, _, (_, step)) => format!("count of step {step} of the group, signed"),
            (_, 1, (detector, _)) => format!("count of detector {detector}, signed"),
            (_, _, (detector, step)) => {
                format!("count of detector {detector}, step {step} of the group, signed")
            }
        };
        // The last result but one of a group, and of a scan's last group unless
        // that has only one.
        let whole_end = counts.saturating_sub(2);
        let short_end = match (detectors * last_steps) as usize {
            1 => whole_end,
            sent => sent - 2,
        };
        ResultStream {
            i_clk: Input::bit("at most one group of counts per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_count: (0..counts)
                .map(|count| Input::word(count_bits, count_about(count)))
                .collect(),
            i_total: (0..total.map_or(0, |_| detectors))
                .map(|detector| Input::word(total_bits, total_about(detector, detectors)))
                .collect(),
            i_clamped: (0..if saturates { counts } else { 0 })
                .map(|count| Input::bit(first_of(count, "count 0 was clamped, and so on")))
                .collect(),
            i_pre_counted: Optional::new(
                counts > 1,
                Input::bit("new counts are there in the next clock"),
            ),
            i_counted: Input::bit("new counts are there"),
            i_last: Input::bit("they are the scan's last"),
            i_ready: Input::bit("the receiver takes the result"),
            o_data: Output::word(data_bits, data_about(total)),
            o_valid: Output::bit("a result waits"),
            o_last: Output::bit("the result is the scan's last"),
            o_overrun: Output::bit("a result was lost since reset"),
            o_saturated: Optional::new(saturates, Output::bit("a count was clamped since reset")),
            about: describe(plan),
            count: (0..counts)
                .map(|count| {
                    let about = match count {
                        0 => "the result",
                        1 => "the results that come next",
                        _ => "",
                    };
                    Register::word(count_bits, 0, about)
                })
                .collect(),
            total: Optional::new(
                total.is_some(),
                Register::word(total_bits, 0, "the result's total count"),
            ),
            waiting_total: (1..=further)
                .map(|detector| Register::word(total_bits, 0, total_about(detector, detectors)))
                .collect(),
            detector: (1..if further > 0 { counts } else { 1 })
                .map(|place| {
                    let about = first_of(
                        place - 1,
                        "detectors of those that come next, one-hot from 1",
                    );
                    Register::word(further, 0, about)
                })
                .collect(),
            valid: Register::bit(false, "a result waits"),
            last: Register::bit(false, "the waiting results are the scan's last"),
            overrun: Register::bit(false, "a result was lost since reset"),
            ends: Optional::new(
                counts > 1,
                Register::bit(false, "the result is its group's last"),
            ),
            next_ends: (0..if counts > 1 { counts } else { 0 })
                .map(|count| {
                    let about = "the next one is its group's last; then those behind it";
                    Register::bit(false, first_of(count, about))
                })
                .collect(),
            moves_up: Optional::new(
                counts > 2,
                Register::bit(false, "the results behind the first have yet to move up"),
            ),
            more: Optional::new(
                counts > 1,
                Register::bit(
                    false,
                    "others of its group come after the result that waits",
                ),
            ),
            changes: Optional::new(
                counts > 1,
                Register::bit(
                    false,
                    "the results behind the first move up, or new ones come",
                ),
            ),
            saturated: Optional::new(
                saturates,
                Register::bit(false, "a count was clamped since reset"),
            ),
            clamped: Optional::new(saturates, Wiring::new(counts, (0..counts).collect(), "")),
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
            later_ends: Optional::new(
                counts > 1,
                Local::bit("the result after the one that comes next is the group's last"),
            ),
            next: Optional::new(
                counts > 1,
                Local::word(count_bits, "the result that comes next"),
            ),
            next_detector: Optional::new(
                further > 0,
                Local::word(further.max(1), "its detector, one-hot from 1"),
            ),
            signed_count: Optional::new(
                total.is_some(),
                Local::word(
                    total.map_or(1, |total| total.first_bit),
                    "the count, signed, in whole bytes",
                ),
            ),
            blocked: Local::bit(""),
            load: Local::bit(""),
            _single: usize::from(counts == 1),
            _detectors: detectors as usize,
            _steps: steps as usize,
            _last_steps: last_steps as usize,
            _compacts: usize::from(is_short && detectors > 1),
            _is_short: usize::from(is_short),
            _short_at_once: usize::from(is_short && detectors * last_steps == 1),
            _whole_end: whole_end,
            _short_end: short_end,
            _behind_whole: (whole_end + 1).min(counts - 1),
            _behind_short: (short_end + 1).min(whole_end),
            _first_later: usize::from(whole_end > 0 && short_end > 0),
            _first_short: usize::from(whole_end > 0 && short_end == 0),
            _first_whole: usize::from(whole_end == 0),
            _back_to_back: usize::from(back_to_back),
            _data_bits: data_bits as usize,
            _signed_bits: total.map_or(data_bits, |total| total.first_bit) as usize,
            _further: further as usize,
        }
    }
}

/// Of a row of like signals only the first is explained.
fn first_of(place: usize, about: &str) -> &str {
    if place == 0 { about } else { "" }
}

fn total_about(detector: u32, detectors: u32) -> String {
    match detectors {
        1 => "total count of the group's steps".to_owned(),
        _ => format!("total count of detector {detector}'s steps"),
    }
}

fn data_about(total: Option<TotalCount>) -> String {
    match total {
        None => "count of the step, signed".to_owned(),
        Some(total) => format!(
            "from bit {} its total, below its signed count",
            total.first_bit
        ),
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
                 order of steps.",
                plan.detectors * plan.steps
            ))
            .note(
                "The first register is offered. Those behind it move up a clock later, so that \
                 i_ready reaches few gates; until they have, what comes next is the third's.",
            );
    }
    if plan.total.is_some() {
        about = about.note(
            "A detector's steps have seen the same light: their total count is kept once, and \
             goes out with each of them.",
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
    about.fact("Latency", "1 clock from i_counted to o_valid")
}

impl Logic for ResultStream {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, valid, last, overrun);
        for c in 0..(self.count.len()) {
            dff_setup!(self, i_clk, count[c]);
        }
        for _total in 0..self.total.count() {
            dff_setup!(self, i_clk, total[0]);
        }
        for d in 0..(self.waiting_total.len()) {
            dff_setup!(self, i_clk, waiting_total[d]);
        }
        for c in 0..(self.detector.len()) {
            dff_setup!(self, i_clk, detector[c]);
        }
        self.o_valid.next = self.valid.q.val();
        self.o_overrun.next = self.overrun.q.val();

        for _single in 0..self._single {
            self.o_last.next = self.last.q.val();
            self.blocked.next = self.valid.q.val() & !self.i_ready.val();
            self.load.next = self.i_counted.val() & !self.blocked.val();
        }
        for _several in self._single..1 {
            dff_setup!(self, i_clk, ends[0], more[0], changes[0]);
            for c in 0..(self.next_ends.len()) {
                dff_setup!(self, i_clk, next_ends[c]);
            }
            self.o_last.next = self.last.q.val() & self.ends[0].q.val();
            self.blocked.next = self.more[0].q.val() | (self.valid.q.val() & !self.i_ready.val());
            self.load.next = self.i_counted.val() & !self.blocked.val();
            for _several_counts in self._short_at_once..1 {
                self.more[0].d.next = self.load.val();
            }
            for _single_count in 0..self._short_at_once {
                self.more[0].d.next = self.load.val() & !self.i_last.val();
            }
            for _apart in self._back_to_back..1 {
                self.changes[0].d.next = self.i_pre_counted[0].val();
            }
            for _back_to_back in 0..self._back_to_back {
                self.changes[0].d.next = self.i_pre_counted[0].val() & !self.load.val();
            }
            if self.more[0].q.val() {
                self.more[0].d.next = !(self.i_ready.val() & self.next_ends[0].q.val());
                self.changes[0].d.next = self.i_ready.val();
            }

            for _two in self.moves_up.count()..1 {
                self.next[0].next = self.count[1].q.val();
                self.later_ends[0].next = self.next_ends[1].q.val();
                for _further in 0..self.next_detector.count() {
                    self.next_detector[0].next = self.detector[0].q.val();
                }
            }
            for second in 2..(self.moves_up.count() + 2) {
                dff_setup!(self, i_clk, moves_up[0]);
                self.moves_up[0].d.next = self.more[0].q.val() & self.i_ready.val();
                if self.moves_up[0].q.val() {
                    self.next[0].next = self.count[second].q.val();
                    self.later_ends[0].next = self.next_ends[second].q.val();
                    for _further in 0..self.next_detector.count() {
                        self.next_detector[0].next = self.detector[second - 1].q.val();
                    }
                } else {
                    self.next[0].next = self.count[1].q.val();
                    self.later_ends[0].next = self.next_ends[1].q.val();
                    for _further in 0..self.next_detector.count() {
                        self.next_detector[0].next = self.detector[0].q.val();
                    }
                }
            }
            if self.i_ready.val() | !self.valid.q.val() {
                if self.more[0].q.val() {
                    self.count[0].d.next = self.next[0].val();
                    self.ends[0].d.next = self.next_ends[0].q.val();
                    self.next_ends[0].d.next = self.later_ends[0].val();
                    for d in 0..self._further {
                        if self.next_detector[0].val().get_bit(d) {
                            self.total[0].d.next = self.waiting_total[d].q.val();
                        }
                    }
                } else if self.i_counted.val() {
                    self.count[0].d.next = self.i_count[0].val();
                    for _total in 0..self.total.count() {
                        self.total[0].d.next = self.i_total[0].val();
                    }
                    for _several_counts in self._short_at_once..1 {
                        self.ends[0].d.next = false;
                    }
                    for _single_count in 0..self._short_at_once {
                        self.ends[0].d.next = self.i_last.val();
                    }
                    for _later in 0..self._first_later {
                        self.next_ends[0].d.next = false;
                    }
                    for _short in 0..self._first_short {
                        self.next_ends[0].d.next = self.i_last.val();
                    }
                    for _whole in 0..self._first_whole {
                        for _always in self._is_short..1 {
                            self.next_ends[0].d.next = true;
                        }
                        for _unless_short in 0..self._is_short {
                            self.next_ends[0].d.next = !self.i_last.val();
                        }
                    }
                }
            }
            if self.changes[0].q.val() {
                for c in 1..(self.count.len()) {
                    self.count[c].d.next = self.i_count[c].val();
                }
                for d in 0..self._further {
                    self.waiting_total[d].d.next = self.i_total[d + 1].val();
                }
                for steps in (self._steps)..(self._steps + self._further.min(1)) {
                    for step in 1..self._steps {
                        self.detector[step - 1].d.next = bit_cast(false, self._further);
                    }
                    for d in 1..(self._further + 1) {
                        for step in 0..self._steps {
                            self.detector[steps * d + step - 1].d.next =
                                bit_cast(false, self._further).replace_bit(d - 1, true);
                        }
                    }
                }
                for c in 1..(self.next_ends.len()) {
                    self.next_ends[c].d.next = false;
                }
                for whole in (self._whole_end.max(1))..self._behind_whole {
                    for _always in self._is_short..1 {
                        self.next_ends[whole].d.next = true;
                    }
                    for _unless_short in 0..self._is_short {
                        self.next_ends[whole].d.next = !self.i_last.val();
                    }
                }
                for short in (self._short_end.max(1))..self._behind_short {
                    self.next_ends[short].d.next = self.i_last.val();
                }
                for _compacts in 0..self._compacts {
                    if self.i_last.val() {
                        for last_steps in self._last_steps..(self._last_steps + 1) {
                            for steps in self._steps..(self._steps + 1) {
                                for d in 1..self._detectors {
                                    for step in 0..self._last_steps {
                                        self.count[last_steps * d + step].d.next =
                                            self.i_count[steps * d + step].val();
                                        for _further in 0..self.next_detector.count() {
                                            self.detector[last_steps * d + step - 1].d.next =
                                                bit_cast(false, self._further)
                                                    .replace_bit(d - 1, true);
                                        }
                                    }
                                }
                            }
                        }
                    }
                }
                for _deep in 0..self.moves_up.count() {
                    if self.more[0].q.val() {
                        for c in 1..(self.count.len() - 1) {
                            self.count[c].d.next = self.count[c + 1].q.val();
                            self.next_ends[c].d.next = self.next_ends[c + 1].q.val();
                        }
                        for d in 0..self._further {
                            self.waiting_total[d].d.next = self.waiting_total[d].q.val();
                        }
                        for c in 1..(self.detector.len()) {
                            self.detector[c - 1].d.next = self.detector[c].q.val();
                        }
                    }
                }
            }
        }
        if self.load.val() {
            for _single in 0..self._single {
                self.count[0].d.next = self.i_count[0].val();
                for _total in 0..self.total.count() {
                    self.total[0].d.next = self.i_total[0].val();
                }
            }
            self.last.d.next = self.i_last.val();
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
        for _alone in self.total.count()..1 {
            self.o_data.next = bit_cast(signed_cast(self.count[0].q.val()), self._data_bits);
        }
        for _beside in 0..self.total.count() {
            self.signed_count[0].next =
                bit_cast(signed_cast(self.count[0].q.val()), self._signed_bits);
        }
        for above in self._signed_bits..(self._signed_bits + self.total.count()) {
            self.o_data.next = bit_cast(self.signed_count[0].val(), self._data_bits)
                | (bit_cast(self.total[0].q.val(), self._data_bits) << above);
        }
    }
}
