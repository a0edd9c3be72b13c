//! The whole sensor.
//!
//! | port | |
//! |---|---|
//! | `o_laser`, `o_epoch` | chips of the sources, and the first of the reference's code |
//! | `i_samples` | sampled levels of the detectors |
//! | `m_axis_*` | counts of the phase steps, an AXI4-Stream |
//! | `o_overrun`, `o_saturated` | a result was lost, or clamped |
//! | `o_peak_*` | peak of each scan |
//!
//! Latency `result_latency_clocks` from a step's last samples to `m_axis_tvalid`. Sources that
//! follow one code share its generator; docs/resources.md has what each option costs.

use std::sync::Arc;

use super::result_stream::StreamPlan;
use super::scan_controller::ScanPlan;
use super::{CodeSource, DetectorChannel, PeakDetector, ResultStream, ScanController};
use crate::code::Code;
use crate::rtl::front::prelude::*;
use crate::scene::Polarity;
use crate::sensor::interface::{Correlator, Interface};
use crate::sensor::port::Direction;

/// Transmit generators, the scan, a channel for each detector, and the results.
#[block(describe(&interface, &counts))]
pub struct SensorTop {
    interface: Interface,
    counts: Correlator,
    #[set(distinct_codes(&interface.reference_codes[0], &interface.source_codes))]
    codes: DistinctCodes,
    #[set(interface.reference_codes.len())]
    detectors: usize,
    #[set(interface.lanes() as usize)]
    lanes: usize,
    #[set(interface.parallel() as usize)]
    parallel: usize,
    /// chip of each source, bit m for source m
    #[under("Lasers")]
    #[width(codes.of_sources.len())]
    pub o_laser: Output<Word>,
    /// o_laser shows the first chip of the reference's code
    #[under("Lasers")]
    pub o_epoch: Output<bool>,
    /// Sampled levels of the detectors.
    #[under("Detector")]
    #[about(samples_about(detectors, interface.lanes(), interface.polarity))]
    #[width(width(&interface, "i_samples"))]
    pub i_samples: Input<Word>,
    /// Count of a phase step.
    #[under(RESULTS)]
    #[about(data_about(&counts))]
    #[width(width(&interface, "m_axis_tdata"))]
    pub m_axis_tdata: Output<Word>,
    /// a result waits
    #[under(RESULTS)]
    pub m_axis_tvalid: Output<bool>,
    /// the receiver takes it
    #[under(RESULTS)]
    pub m_axis_tready: Input<bool>,
    /// it is the scan's last
    #[under(RESULTS)]
    pub m_axis_tlast: Output<bool>,
    /// a result was lost since reset
    #[under(FLAGS)]
    pub o_overrun: Output<bool>,
    /// A count was clamped since reset.
    #[under(FLAGS)]
    #[when(interface.saturates())]
    #[about(saturated_about(&counts))]
    pub o_saturated: Optional<Output<bool>>,
    /// Phase step of each detector's peak in the last scan.
    #[under(PEAK)]
    #[when(counts.peak.is_some())]
    #[about(peak_about(detectors, "step k of the last scan's peak"))]
    #[width(width(&interface, "o_peak_step"))]
    pub o_peak_step: Optional<Output<Word>>,
    /// Its count.
    #[under(PEAK)]
    #[when(counts.peak.is_some())]
    #[about(peak_about(detectors, "the count, signed"))]
    #[width(width(&interface, "o_peak_count"))]
    pub o_peak_count: Optional<Output<Word>>,
    /// high for one clock when they have changed
    #[under(PEAK)]
    #[when(counts.peak.is_some())]
    pub o_peak_valid: Optional<Output<bool>>,
    #[width(codes.of_sources.len())]
    laser: Register<Word>,
    epoch: Register<bool>,
    #[each(code in codes.all.iter())]
    #[is(CodeSource::new(code, 0, interface.realigns()))]
    transmit: Vec<CodeSource>,
    #[width(codes.of_sources.len())]
    chips: Local<Word>,
    #[is(ScanController::new(ScanPlan::of(&interface, &counts)))]
    controller: ScanController,
    #[each(code in interface.reference_codes.iter())]
    #[is(DetectorChannel::new(interface.clone(), counts, code.clone()))]
    channel: Vec<DetectorChannel>,
    #[is(ResultStream::new(stream(&interface, &counts)))]
    results: ResultStream,
    #[each(peak in counts.peak.iter())]
    #[is(PeakDetector::new(*peak, detectors))]
    peak: Vec<PeakDetector>,
}

/// Bits of a port that the interface has.
fn width(interface: &Interface, name: &str) -> u32 {
    let port = interface.ports().into_iter().find(|p| p.name == name);
    port.map_or(1, |p| p.width)
}

fn stream(interface: &Interface, counts: &Correlator) -> StreamPlan {
    StreamPlan {
        count_bits: counts.count_bits,
        saturates: counts.saturates(),
        total: counts.total,
        data_bits: interface.tdata_bits,
        detectors: interface.reference_codes.len(),
        steps: interface.parallel() as usize,
        last_steps: interface.last_group_steps() as usize,
        back_to_back: interface.timing.scan.integration_chips == 1,
    }
}

/// Headings in the list of ports.
const RESULTS: &str = "Results, AXI4-Stream";
const FLAGS: &str = "Flags, high until reset";
const PEAK: &str = "Peak of a scan, steady until the next scan's";

fn peak_about(detectors: usize, about: &str) -> String {
    match detectors {
        1 => about.to_owned(),
        _ => format!("{about}; detector 0 lowest"),
    }
}

fn saturated_about(counts: &Correlator) -> &'static str {
    match counts.total {
        None => "a count was clamped since reset",
        Some(_) => "a count or a total was clamped since reset",
    }
}

fn data_about(counts: &Correlator) -> String {
    match counts.total {
        None => "count of a phase step, signed".to_owned(),
        Some(total) => format!("from bit {} its hits, below its signed count", total.first_bit),
    }
}

pub(super) fn samples_about(detectors: usize, lanes: u32, polarity: Polarity) -> String {
    let about = match detectors {
        1 => "SPAD level, bit 0 earliest".to_owned(),
        _ => format!("SPAD levels, {lanes} samples per detector, bit 0 earliest"),
    };
    match polarity {
        Polarity::High => about,
        Polarity::Low => about + ", low during a pulse",
    }
}

fn describe(interface: &Interface, counts: &Correlator) -> About {
    let about = describe_counts(interface, counts);
    match counts.total {
        None => about,
        Some(total) => about.fact(
            "Totals",
            format!(
                "{} bits, unsigned, in m_axis_tdata[{}:{}]{}",
                total.bits,
                interface.tdata_bits - 1,
                total.first_bit,
                if total.saturates() { ", clamped" } else { "" }
            ),
        ),
    }
}

fn describe_counts(interface: &Interface, counts: &Correlator) -> About {
    let scan = &interface.timing.scan;
    let outputs = interface.ports().iter().filter(|p| p.direction == Direction::Output).count();
    About::new(
        "sensor_top",
        "DS-CDMA indirect time-of-flight sensor, lasers out, SPAD samples in",
    )
    .note(format!(
        "One clock cycle is one chip of {} samples. The sample word of a chip is expected on \
         i_samples one cycle after o_laser shows the chip. In reset all {outputs} outputs are 0.",
        interface.lanes()
    ))
    .note(
        "Registers have no values at power-up: before the first scan i_rst has to be high at one \
         rising edge of i_clk at least. Without that the outputs mean nothing.",
    )
    .fact(
        "Scan",
        format!(
            "{} phase steps from step {}, {} chips each",
            scan.steps, scan.first_step, scan.integration_chips
        ),
    )
    .fact(
        "Counts",
        format!(
            "{} bits, signed{}",
            counts.count_bits,
            if counts.saturates() {
                ", clamped"
            } else {
                "; no stimulus can overflow them"
            }
        ),
    )
    .fact(
        "Latency",
        format!(
            "m_axis_tvalid {} clocks after the one at which a step's last word is on i_samples",
            interface.result_latency_clocks
        ),
    )
    .fact("Rate", "one chip per clock")
}

/// Codes of which each has one generator.
#[derive(Debug, Clone)]
pub(super) struct DistinctCodes {
    /// Each once, the reference's first.
    pub(super) all: Vec<Arc<Code>>,
    /// For each source the index of its code.
    pub(super) of_sources: Vec<usize>,
}

pub(super) fn distinct_codes(reference: &Arc<Code>, sources: &[Arc<Code>]) -> DistinctCodes {
    let mut codes = DistinctCodes { all: vec![reference.clone()], of_sources: Vec::new() };
    for code in sources {
        let same = |known: &Arc<Code>| {
            Arc::ptr_eq(known, code)
                || (known.interleave == code.interleave && known.generator == code.generator)
        };
        let index = codes.all.iter().position(same).unwrap_or_else(|| {
            codes.all.push(code.clone());
            codes.all.len() - 1
        });
        codes.of_sources.push(index);
    }
    codes
}

#[kernel]
impl Logic for SensorTop {
    fn update(&mut self) {
        self.transmit_codes();
        self.run_channels();
        self.hand_counts();
        if self.interface.realigns() {
            self.realign();
        }
        self.stream_results();
        if self.o_peak_valid.is_present() {
            self.find_peaks();
        }
    }

    fn transmit_codes(&mut self) {
        for g in 0..self.transmit.len() {
            self.transmit[g].i_advance.next = true;
        }
        self.chips.next = gather(self.codes.of_sources.len(), |source| {
            self.transmit[self.codes.of_sources[source]].o_chip.val()
        });
        self.laser.d.next = self.chips.val();
        self.epoch.d.next = self.transmit[0].o_epoch.val();
        self.o_laser.next = self.laser.q.val();
        self.o_epoch.next = self.epoch.q.val();
    }

    fn run_channels(&mut self) {
        let lanes = self.lanes;
        for d in 0..self.channel.len() {
            self.channel[d].i_run.next = self.controller.o_run.val();
            if self.channel[0].i_pre_last_chip.is_present() {
                self.channel[d].i_pre_last_chip.next = self.controller.o_pre_last_chip.val();
            }
            self.channel[d].i_last_chip.next = self.controller.o_last_chip.val();
            self.channel[d].i_dump.next = self.controller.o_dump.val();
        }
        for d in 0..self.channel.len() {
            self.channel[d].i_samples.next = self.i_samples.val().slice(lanes * d, lanes);
        }
    }

    fn hand_counts(&mut self) {
        let parallel = self.parallel;
        for d in 0..self.channel.len() {
            for p in 0..parallel {
                self.results.i_count[d * parallel + p].next = self.channel[d].o_count[p].val();
                if self.o_saturated.is_present() {
                    self.results.i_clamped[d * parallel + p].next =
                        self.channel[d].o_clamped[p].val();
                }
                if self.o_peak_valid.is_present() {
                    self.peak[0].i_count[d * parallel + p].next = self.channel[d].o_count[p].val();
                }
            }
        }
        for d in 0..self.results.i_total.len() {
            self.results.i_total[d].next = self.channel[d].o_total.val();
        }
    }

    /// Scans wait for the code's epoch; the transmitted codes run on.
    fn realign(&mut self) {
        for g in 0..self.transmit.len() {
            self.transmit[g].i_load.next = false;
        }
        self.controller.i_epoch.next = self.transmit[0].o_epoch.val();
        for d in 0..self.channel.len() {
            self.channel[d].i_start.next = self.controller.o_start.val();
        }
    }

    fn stream_results(&mut self) {
        if self.results.i_pre_counted.is_present() {
            self.results.i_pre_counted.next = self.controller.o_pre_counted.val();
        }
        self.results.i_counted.next = self.controller.o_counted.val();
        self.results.i_last.next = self.controller.o_scan_counted.val();
        self.results.i_ready.next = self.m_axis_tready.val();
        self.m_axis_tdata.next = self.results.o_data.val();
        self.m_axis_tvalid.next = self.results.o_valid.val();
        self.m_axis_tlast.next = self.results.o_last.val();
        self.o_overrun.next = self.results.o_overrun.val();
        if self.o_saturated.is_present() {
            self.o_saturated.next = self.results.o_saturated.val();
        }
    }

    fn find_peaks(&mut self) {
        self.peak[0].i_counted.next = self.controller.o_counted.val();
        self.peak[0].i_last.next = self.controller.o_scan_counted.val();
        self.o_peak_step.next = self.peak[0].o_step.val();
        self.o_peak_count.next = self.peak[0].o_count.val();
        self.o_peak_valid.next = self.peak[0].o_valid.val();
    }
}
