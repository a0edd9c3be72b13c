//! Counts as an AXI4-Stream.

use crate::hdl::front::prelude::*;

/// Takes the difference of totals at every dump and offers it as a stream.
#[derive(Debug, Clone, LogicBlock)]
pub struct ResultStream {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Sum of all hits so far.
    pub i_total: Input<Word>,
    /// `i_total` has just taken in the last hits of a step.
    pub i_dump: Input<bool>,
    /// The step is the scan's last.
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
    base: Register<Word>,
    difference: Optional<Register<Word>>,
    arrives: Optional<Register<bool>>,
    arrives_last: Optional<Register<bool>>,
    count: Register<Word>,
    valid: Register<bool>,
    last: Register<bool>,
    overrun: Register<bool>,
    saturated: Optional<Register<bool>>,
    fits: Optional<Local<bool>>,
    clamped: Optional<Local<Word>>,
    largest: Optional<Constant>,
    smallest: Optional<Constant>,
    new_result: Local<bool>,
    blocked: Local<bool>,
    _total_bits: usize,
    _count_bits: usize,
    _data_bits: usize,
}

impl ResultStream {
    /// From totals of `total_bits` to counts of `count_bits` in words of
    /// `data_bits`; fewer count than total bits saturate.
    pub fn new(total_bits: u32, count_bits: u32, data_bits: u32) -> ResultStream {
        let saturates = count_bits < total_bits;
        let half = 1u128 << (count_bits - 1);
        let when_saturating = |part| Optional::new(saturates, part);
        let flag = |about: &str| when_saturating(Register::bit(false, about));
        let mut about = About::new("result_stream", "counts of the phase steps as AXI4-Stream")
            .note(
                "The base is the total at the last dump. The sensor cannot stall: a result that \
                 comes while another still waits is lost, and o_overrun stays high until reset.",
            )
            .fact(
                "Latency",
                format!("{} from i_dump to o_valid", clocks(saturates)),
            )
            .fact("Rate", "one result per clock");
        if saturates {
            about = about.note(
                "A count that does not fit is clamped to the nearest one that does, and \
                 o_saturated stays high until reset.",
            );
        }
        ResultStream {
            i_clk: Input::bit("one total per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_total: Input::word(total_bits, "sum over all hits, modulo its width"),
            i_dump: Input::bit("i_total has just taken in a step's last hits"),
            i_last: Input::bit("the step is the scan's last"),
            i_ready: Input::bit("the receiver takes the result"),
            o_data: Output::word(data_bits, "count of the step, signed"),
            o_valid: Output::bit("a result waits"),
            o_last: Output::bit("the result is the scan's last"),
            o_overrun: Output::bit("a result was lost since reset"),
            o_saturated: when_saturating_bit(saturates),
            about,
            base: Register::word(total_bits, 0, "total at the last dump"),
            difference: Optional::new(
                saturates,
                Register::word(total_bits, 0, "count before it is clamped"),
            ),
            arrives: flag("difference_r is a new count"),
            arrives_last: flag("it is the scan's last"),
            count: Register::word(count_bits, 0, "count of the step, signed"),
            valid: Register::bit(false, "a result waits"),
            last: Register::bit(false, "the result is the scan's last"),
            overrun: Register::bit(false, "a result was lost since reset"),
            saturated: flag("a count was clamped since reset"),
            fits: Optional::new(saturates, Local::bit("difference_r fits into a count")),
            clamped: Optional::new(saturates, Local::word(count_bits, "the nearest count")),
            largest: Optional::new(
                saturates,
                Constant::new(half - 1, count_bits, "Largest count"),
            ),
            smallest: Optional::new(saturates, Constant::new(half, count_bits, "Smallest count")),
            new_result: Local::bit("a result arrives"),
            blocked: Local::bit("another result still waits"),
            _total_bits: total_bits as usize,
            _count_bits: count_bits as usize,
            _data_bits: data_bits as usize,
        }
    }
}

fn when_saturating_bit(saturates: bool) -> Optional<Output<bool>> {
    Optional::new(saturates, Output::bit("a count was clamped since reset"))
}

fn clocks(saturates: bool) -> &'static str {
    if saturates { "2 clocks" } else { "1 clock" }
}

impl Logic for ResultStream {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, base, count, valid, last, overrun);
        self.o_valid.next = self.valid.q.val();
        self.o_last.next = self.last.q.val();
        self.o_overrun.next = self.overrun.q.val();
        self.blocked.next = self.valid.q.val() & !self.i_ready.val();
        for _saturating in 0..self.difference.count() {
            dff_setup!(
                self,
                i_clk,
                difference[0],
                arrives[0],
                arrives_last[0],
                saturated[0]
            );
        }
        if self.i_dump.val() {
            self.base.d.next = self.i_total.val();
            for _saturating in 0..self.difference.count() {
                self.difference[0].d.next = self.i_total.val() - self.base.q.val();
            }
        }
        for _exact in self.difference.count()..1 {
            self.new_result.next = self.i_dump.val();
            if self.new_result.val() & !self.blocked.val() {
                self.count.d.next = self.i_total.val() - self.base.q.val();
                self.last.d.next = self.i_last.val();
            }
        }
        for _saturating in 0..self.difference.count() {
            self.arrives[0].d.next = self.i_dump.val();
            self.arrives_last[0].d.next = self.i_last.val();
            self.new_result.next = self.arrives[0].q.val();
            self.fits[0].next = bit_cast(
                signed_cast(bit_cast(self.difference[0].q.val(), self._count_bits)),
                self._total_bits,
            ) == self.difference[0].q.val();
            for sign in (self._total_bits - 1)..self._total_bits {
                if self.fits[0].val() {
                    self.clamped[0].next = bit_cast(self.difference[0].q.val(), self._count_bits);
                } else if self.difference[0].q.val().get_bit(sign) {
                    self.clamped[0].next = self.smallest[0].val();
                } else {
                    self.clamped[0].next = self.largest[0].val();
                }
            }
            if self.new_result.val() & !self.blocked.val() {
                self.count.d.next = self.clamped[0].val();
                self.last.d.next = self.arrives_last[0].q.val();
            }
            if self.new_result.val() & !self.fits[0].val() {
                self.saturated[0].d.next = true;
            }
            self.o_saturated[0].next = self.saturated[0].q.val();
        }
        self.valid.d.next = self.new_result.val() | self.blocked.val();
        if self.new_result.val() & self.blocked.val() {
            self.overrun.d.next = true;
        }
        self.o_data.next = bit_cast(signed_cast(self.count.q.val()), self._data_bits);
    }
}
