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

use super::{CodeSource, DetectorChannel, PeakDetector, ResultStream, ScanController, SensorPorts};
use crate::code::Code;
use crate::rtl::front::prelude::*;
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
    /// ports
    #[is(SensorPorts::new(interface.clone()))]
    pub io: SensorPorts,
    #[width(codes.of_sources.len())]
    laser: Register<Word>,
    epoch: Register<bool>,
    #[each(code in codes.all.iter())]
    #[is(CodeSource::new(code, 0, interface.realigns()))]
    transmit: Vec<CodeSource>,
    #[width(codes.of_sources.len())]
    chips: Local<Word>,
    #[is(ScanController::new(
        interface.timing.scan.integration_chips,
        interface.groups(),
        interface.realigns(),
        Correlator::clocks_to_dump(interface.lanes()),
        counts.count_segments.count,
        counts.clocks_of_counting(),
        detectors * parallel > 1,
    ))]
    controller: ScanController,
    #[each(code in interface.reference_codes.iter())]
    #[is(DetectorChannel::new(interface.clone(), counts, code.clone()))]
    channel: Vec<DetectorChannel>,
    #[is(ResultStream::new(
        counts.count_bits,
        counts.saturates(),
        counts.total,
        detectors,
        parallel,
        interface.last_group_steps() as usize,
        interface.timing.scan.integration_chips == 1,
    ))]
    results: ResultStream,
    #[each(peak in counts.peak.iter())]
    #[is(PeakDetector::new(*peak, detectors))]
    peak: Vec<PeakDetector>,
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
        if self.io.o_peak_valid.is_present() {
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
        self.io.o_laser.next = self.laser.q.val();
        self.io.o_epoch.next = self.epoch.q.val();
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
            self.channel[d].i_samples.next = self.io.i_samples.val().slice(lanes * d, lanes);
        }
    }

    fn hand_counts(&mut self) {
        let parallel = self.parallel;
        for d in 0..self.channel.len() {
            for p in 0..parallel {
                self.results.i_count[d * parallel + p].next = self.channel[d].o_count[p].val();
                if self.io.o_saturated.is_present() {
                    self.results.i_clamped[d * parallel + p].next =
                        self.channel[d].o_clamped[p].val();
                }
                if self.io.o_peak_valid.is_present() {
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
        self.results.i_ready.next = self.io.m_axis_tready.val();
        self.io.m_axis_tdata.next = self.results.o_data.val();
        self.io.m_axis_tvalid.next = self.results.o_valid.val();
        self.io.m_axis_tlast.next = self.results.o_last.val();
        self.io.o_overrun.next = self.results.o_overrun.val();
        if self.io.o_saturated.is_present() {
            self.io.o_saturated.next = self.results.o_saturated.val();
        }
    }

    fn find_peaks(&mut self) {
        self.peak[0].i_counted.next = self.controller.o_counted.val();
        self.peak[0].i_last.next = self.controller.o_scan_counted.val();
        self.io.o_peak_step.next = self.peak[0].o_step.val();
        self.io.o_peak_count.next = self.peak[0].o_count.val();
        self.io.o_peak_valid.next = self.peak[0].o_valid.val();
    }
}
