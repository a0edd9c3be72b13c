//! The whole sensor, with a histogram of arrival times in place of up/down counts.
//!
//! | port | |
//! |---|---|
//! | `o_laser`, `o_epoch` | chips of the sources, and the first of the reference's code |
//! | `i_samples` | sampled levels of the detectors |
//! | `m_axis_*` | rows of the histograms, an AXI4-Stream |
//! | `o_overrun`, `o_saturated` | a frame was lost, or a bin was full |
//!
//! The host correlates: no reference is made here. Latency `result_latency_clocks` from a frame's
//! last samples to `m_axis_tvalid`.

use std::sync::Arc;

use super::sensor_top::{distinct_codes, samples_about};
use super::{CodeSource, HistogramChannel, HistogramControl};
use crate::code::Code;
use crate::rtl::front::prelude::*;
use crate::sensor::histogram::HistogramPlan;
use crate::sensor::interface::Interface;

/// Headings in the list of ports.
const RESULTS: &str = "Rows of the histograms, AXI4-Stream";
const FLAGS: &str = "Flags, high until reset";

/// Transmit generators, a histogram for each detector, and what reads them.
#[block(TopPlan)]
pub struct HistogramTop {
    /// chip of each source, bit m for source m
    #[under("Lasers")]
    #[width(plan.source_codes.len())]
    pub o_laser: Output<Word>,
    /// o_laser shows the first chip of the reference's code
    #[under("Lasers")]
    pub o_epoch: Output<bool>,
    /// Sampled levels of the detectors.
    #[under("Detector")]
    #[about(samples_about(plan.detectors, plan.histogram.row_bins, plan.histogram.polarity))]
    #[width(plan.detectors as u32 * plan.histogram.row_bins)]
    pub i_samples: Input<Word>,
    /// Bins of a row.
    #[under(RESULTS)]
    #[about(format!("bins of a row, {} bits each, bit 0 earliest", plan.histogram.bin_data_bits()))]
    #[width(plan.histogram.row_data_bits())]
    pub m_axis_tdata: Output<Word>,
    /// a row waits
    #[under(RESULTS)]
    pub m_axis_tvalid: Output<bool>,
    /// the receiver takes it
    #[under(RESULTS)]
    pub m_axis_tready: Input<bool>,
    /// it is the frame's last
    #[under(RESULTS)]
    pub m_axis_tlast: Output<bool>,
    #[under(FLAGS)]
    #[about(format!("a {} was lost since reset", plan.lost()))]
    pub o_overrun: Output<bool>,
    /// a bin was full and had a hit since reset
    #[under(FLAGS)]
    #[when(plan.histogram.saturates())]
    pub o_saturated: Optional<Output<bool>>,
    #[is(describe(plan))]
    about: About,
    #[width(plan.source_codes.len())]
    laser: Register<Word>,
    epoch: Register<bool>,
    #[each(code in plan.codes.iter())]
    #[is(CodeSource::new(code, 0, false))]
    transmit: Vec<CodeSource>,
    #[sources(plan.source_codes.clone(), plan.codes.len())]
    chips: Wiring,
    #[each(_detector in 0..plan.shared_words())]
    #[width(plan.histogram.row_bins)]
    samples: Vec<Wiring>,
    #[is(HistogramControl::new(&plan.histogram, plan.detectors))]
    control: HistogramControl,
    #[each(_detector in 0..plan.detectors)]
    #[is(HistogramChannel::new(&plan.histogram))]
    channel: Vec<HistogramChannel>,
    #[each(detector in 0..plan.shared_words())]
    #[about(match detector {
        0 => "row of detector 0, if it is its turn".to_owned(),
        _ => format!("and of detector {detector}"),
    })]
    #[width(plan.histogram.row_data_bits())]
    choice: Vec<Local<Word>>,
    /// row on the stream
    #[width(plan.histogram.row_data_bits())]
    row: Register<Word>,
    #[when(plan.histogram.saturates())]
    #[width(plan.detectors)]
    clamped: Optional<Wiring>,
    #[when(plan.histogram.saturates())]
    saturated: Optional<Register<bool>>,
    plan: Plan<TopPlan>,
}

#[derive(Debug, Clone)]
struct TopPlan {
    histogram: HistogramPlan,
    detectors: usize,
    latency_clocks: u32,
    /// Each code once, the reference's first.
    codes: Vec<Arc<Code>>,
    /// For each source the index of its code.
    source_codes: Vec<usize>,
}

impl TopPlan {
    /// What is lost when the receiver is too slow.
    fn lost(&self) -> &'static str {
        match self.histogram.takes_turns() {
            true => "frame",
            false => "row",
        }
    }

    /// Detectors whose samples have to be taken out of a common word.
    fn shared_words(&self) -> usize {
        match self.detectors {
            1 => 0,
            detectors => detectors,
        }
    }
}

impl HistogramTop {
    /// The hardware that keeps `interface`, which has this histogram.
    pub fn new(interface: &Interface, histogram: &HistogramPlan) -> HistogramTop {
        let (codes, source_codes) =
            distinct_codes(&interface.reference_codes[0], &interface.source_codes);
        HistogramTop::build(&TopPlan {
            histogram: *histogram,
            detectors: interface.reference_codes.len(),
            latency_clocks: interface.result_latency_clocks,
            codes,
            source_codes,
        })
    }
}

fn describe(plan: &TopPlan) -> About {
    let histogram = &plan.histogram;
    let about = About::new(
        "sensor_top",
        "DS-CDMA indirect time-of-flight sensor, lasers out, SPAD samples in, histograms out",
    )
    .note(format!(
        "One clock cycle is one chip of {} samples. The sample word of a chip is expected on \
         i_samples one cycle after o_laser shows the chip. In reset all outputs are 0.",
        histogram.row_bins
    ))
    .note(
        "Every rising edge of a detector's level counts in the bin of its sample of the code \
         period: a row for each chip, from the one that o_epoch marks, a bin for each sample. The \
         up/down count of phase step k is the sum of all bins, those negative whose chip of the \
         reference, delayed by k samples, is 0.",
    )
    .note(
        "Registers have no values at power-up: before the first frame i_rst has to be high at one \
         rising edge of i_clk at least. Without that the outputs mean nothing.",
    );
    with_sizes(about, plan)
        .fact(
            "Latency",
            format!(
                "m_axis_tvalid {} clocks after the one at which a frame's last word is on i_samples",
                plan.latency_clocks
            ),
        )
        .fact("Rate", "one chip per clock, and at most one row")
}

/// What a frame is, what a bin holds, what memory keeps.
fn with_sizes(about: About, plan: &TopPlan) -> About {
    let histogram = &plan.histogram;
    about
        .fact(
            "Frame",
            format!(
                "{} code periods, {} rows of {} bins{}",
                histogram.periods,
                histogram.rows,
                histogram.row_bins,
                match plan.detectors {
                    1 => String::new(),
                    detectors => format!(", for {detectors} detectors in turn"),
                }
            ),
        )
        .fact(
            "Bins",
            format!(
                "{} bits, unsigned{}",
                histogram.bin_bits,
                match histogram.saturates() {
                    true => ", clamped",
                    false => "; no stimulus can overflow them",
                }
            ),
        )
        .fact(
            "Memory",
            format!(
                "{} bits: {}",
                histogram.memory_bits(plan.detectors),
                match histogram.takes_turns() {
                    true => "one histogram counts while the other is read",
                    false =>
                        "a frame's rows leave while the next frame's first code period is counted",
                }
            ),
        )
}

#[kernel]
impl Logic for HistogramTop {
    fn update(&mut self) {
        self.transmit_codes();
        self.control.i_ready.next = self.m_axis_tready.val();
        self.run_channels();
        self.offer_rows();
        if self.o_saturated.is_present() {
            self.flag_clamped();
        }
    }

    fn transmit_codes(&mut self) {
        for g in 0..self.transmit.len() {
            self.transmit[g].i_advance.next = true;
            self.chips.i[g].next = self.transmit[g].o_chip.val();
        }
        self.laser.d.next = self.chips.o.val();
        self.epoch.d.next = self.transmit[0].o_epoch.val();
        self.o_laser.next = self.laser.q.val();
        self.o_epoch.next = self.epoch.q.val();
    }

    fn run_channels(&mut self) {
        let lanes = self.plan.histogram.row_bins as usize;
        if self.plan.detectors == 1 {
            self.channel[0].i_samples.next = self.i_samples.val();
        }
        for d in 0..self.samples.len() {
            for l in 0..lanes {
                self.samples[d].i[l].next = self.i_samples.val().get_bit(lanes * d + l);
            }
            self.channel[d].i_samples.next = self.samples[d].o.val();
        }
        for d in 0..self.channel.len() {
            self.channel[d].i_run.next = self.control.o_run.val();
            self.channel[d].i_row.next = self.control.o_row.val();
            self.channel[d].i_held_first.next = self.control.o_held_first.val();
            self.channel[d].i_added_first.next = self.control.o_added_first.val();
            self.channel[d].i_write_row.next = self.control.o_write_row.val();
        }
        if self.plan.histogram.takes_turns() {
            self.name_memories();
        } else {
            for d in 0..self.channel.len() {
                self.channel[d].i_come_first.next = self.control.o_come_first.val();
            }
        }
    }

    fn name_memories(&mut self) {
        for d in 0..self.channel.len() {
            self.channel[d].i_half.next = self.control.o_half.val();
            self.channel[d].i_read_row.next = self.control.o_read_row.val();
            self.channel[d].i_go.next = self.control.o_go.val();
            self.channel[d].i_come_half.next = self.control.o_come_half.val();
            self.channel[d].i_held_half.next = self.control.o_held_half.val();
            self.channel[d].i_write_half.next = self.control.o_write_half.val();
        }
    }

    fn offer_rows(&mut self) {
        let detectors = self.plan.detectors;
        if detectors > 1 {
            self.choice[0].next = self.channel[0].o_bins.val()
                & signed_cast(self.control.o_read_detector.val().get_bit(0));
            for d in 1..detectors {
                self.choice[d].next = self.choice[d - 1].val()
                    | (self.channel[d].o_bins.val()
                        & signed_cast(self.control.o_read_detector.val().get_bit(d)));
            }
            if self.control.o_shows.val() {
                self.row.d.next = self.choice[detectors - 1].val();
            }
        } else if self.control.o_shows.val() {
            self.row.d.next = self.channel[0].o_bins.val();
        }
        self.m_axis_tdata.next = self.row.q.val();
        self.m_axis_tvalid.next = self.control.o_valid.val();
        self.m_axis_tlast.next = self.control.o_last.val();
        self.o_overrun.next = self.control.o_overrun.val();
    }

    fn flag_clamped(&mut self) {
        for d in 0..self.channel.len() {
            self.clamped.i[d].next = self.channel[d].o_clamped.val();
        }
        if self.clamped.o.val().any() {
            self.saturated.d.next = true;
        }
        self.o_saturated.next = self.saturated.q.val();
    }
}
