//! The whole sensor.

use std::sync::Arc;

use super::result_stream::StreamPlan;
use super::scan_controller::ScanPlan;
use super::{CodeSource, DetectorChannel, PeakDetector, ResultStream, ScanController};
use crate::code::Code;
use crate::rtl::front::prelude::*;
use crate::sensor::contract::{Contract, Direction};

/// Transmit generators, the scan, a channel for each detector, and the results.
#[derive(Debug, Clone, LogicBlock)]
pub struct SensorTop {
    /// Clock, one cycle per chip.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Chips of the sources.
    pub o_laser: Output<Word>,
    /// First chip of the reference's code.
    pub o_epoch: Output<bool>,
    /// Sampled level of the detector.
    pub i_samples: Input<Word>,
    /// Count of a phase step.
    pub m_axis_tdata: Output<Word>,
    /// A result waits.
    pub m_axis_tvalid: Output<bool>,
    /// The receiver takes it.
    pub m_axis_tready: Input<bool>,
    /// It is the scan's last.
    pub m_axis_tlast: Output<bool>,
    /// A result was lost.
    pub o_overrun: Output<bool>,
    /// A count was clamped.
    pub o_saturated: Optional<Output<bool>>,
    /// Phase step of each detector's peak in the last scan.
    pub o_peak_step: Optional<Output<Word>>,
    /// Its count.
    pub o_peak_count: Optional<Output<Word>>,
    /// They have just changed.
    pub o_peak_valid: Optional<Output<bool>>,
    about: About,
    laser: Register<Word>,
    epoch: Register<bool>,
    transmit: Vec<CodeSource>,
    chips: Wiring,
    samples: Vec<Wiring>,
    controller: ScanController,
    channel: Vec<DetectorChannel>,
    results: ResultStream,
    peak: Vec<PeakDetector>,
    _generators: usize,
    _realigns: usize,
    _lanes: usize,
    _detectors: usize,
    _parallel: usize,
}

impl SensorTop {
    /// The hardware that keeps `contract`.
    pub fn new(contract: &Contract) -> SensorTop {
        let lanes = contract.lanes();
        let realigns = contract.realigns();
        let parallel = contract.parallel();
        let detectors = contract.reference_codes.len();
        let (codes, source_codes) =
            distinct_codes(&contract.reference_codes[0], &contract.source_codes);
        let width = |name: &str| {
            let port = contract.ports().into_iter().find(|p| p.name == name);
            port.map_or(1, |p| p.width)
        };
        let sources = source_codes.len() as u32;
        let with_peak = |port| Optional::new(contract.peak.is_some(), port);
        SensorTop {
            i_clk: Input::bit("one cycle per chip"),
            i_rst: Input::bit("synchronous, active high; pulse it after power-up"),
            o_laser: Output::word(sources, "chip of each source, bit m for source m")
                .under("Lasers"),
            o_epoch: Output::bit("o_laser shows the first chip of the reference's code")
                .under("Lasers"),
            i_samples: Input::word(width("i_samples"), samples_about(detectors, lanes))
                .under("Detector"),
            m_axis_tdata: Output::word(width("m_axis_tdata"), data_about(contract))
                .under("Results, AXI4-Stream"),
            m_axis_tvalid: Output::bit("a result waits").under("Results, AXI4-Stream"),
            m_axis_tready: Input::bit("the receiver takes it").under("Results, AXI4-Stream"),
            m_axis_tlast: Output::bit("it is the scan's last").under("Results, AXI4-Stream"),
            o_overrun: Output::bit("a result was lost since reset")
                .under("Flags, high until reset"),
            o_saturated: Optional::new(
                contract.saturates(),
                Output::bit(saturated_about(contract)).under("Flags, high until reset"),
            ),
            o_peak_step: with_peak(
                Output::word(
                    width("o_peak_step"),
                    peak_about(detectors, "step k of the last scan's peak"),
                )
                .under(PEAK),
            ),
            o_peak_count: with_peak(
                Output::word(
                    width("o_peak_count"),
                    peak_about(detectors, "the count, signed"),
                )
                .under(PEAK),
            ),
            o_peak_valid: Optional::new(
                contract.peak.is_some(),
                Output::bit("high for one clock when they have changed").under(PEAK),
            ),
            about: describe(contract),
            laser: Register::word(sources, 0, "chip of each source"),
            epoch: Register::bit(false, "o_laser shows the first chip of the code"),
            transmit: codes
                .iter()
                .map(|code| CodeSource::new(code, 0, realigns))
                .collect(),
            chips: Wiring::new(codes.len(), source_codes, ""),
            samples: (0..if detectors > 1 { detectors } else { 0 })
                .map(|_| {
                    let lanes = lanes as usize;
                    Wiring::new(lanes, (0..lanes).collect(), "")
                })
                .collect(),
            controller: ScanController::new(ScanPlan {
                chips: contract.timing.scan.integration_chips,
                steps: contract.groups(),
                realigns,
                clocks_to_dump: Contract::clocks_to_dump(lanes),
                segments: contract.count_segments.count,
                clocks_to_count: contract.clocks_of_counting(),
                counts_early: detectors as u32 * parallel > 1,
            }),
            channel: contract
                .reference_codes
                .iter()
                .map(|code| DetectorChannel::new(contract, code))
                .collect(),
            results: ResultStream::new(StreamPlan {
                count_bits: contract.count_bits,
                saturates: contract.saturates(),
                total: contract.total,
                data_bits: contract.tdata_bits,
                detectors: detectors as u32,
                steps: parallel,
                last_steps: contract.last_group_steps() as u32,
                back_to_back: contract.timing.scan.integration_chips == 1,
            }),
            peak: contract
                .peak
                .iter()
                .map(|plan| PeakDetector::new(plan, detectors as u32))
                .collect(),
            _generators: codes.len(),
            _realigns: usize::from(realigns),
            _lanes: lanes as usize,
            _detectors: detectors,
            _parallel: parallel as usize,
        }
    }
}

/// Heading of the peak detector's ports.
const PEAK: &str = "Peak of a scan, steady until the next scan's";

fn peak_about(detectors: usize, about: &str) -> String {
    match detectors {
        1 => about.to_owned(),
        _ => format!("{about}; detector 0 lowest"),
    }
}

fn saturated_about(contract: &Contract) -> &'static str {
    match contract.total {
        None => "a count was clamped since reset",
        Some(_) => "a count or a total was clamped since reset",
    }
}

fn data_about(contract: &Contract) -> String {
    match contract.total {
        None => "count of a phase step, signed".to_owned(),
        Some(total) => format!(
            "from bit {} its hits, below its signed count",
            total.first_bit
        ),
    }
}

fn samples_about(detectors: usize, lanes: u32) -> String {
    match detectors {
        1 => "SPAD level, bit 0 earliest".to_owned(),
        _ => format!("SPAD levels, {lanes} samples per detector, bit 0 earliest"),
    }
}

fn describe(contract: &Contract) -> About {
    let about = describe_counts(contract);
    match contract.total {
        None => about,
        Some(total) => about.fact(
            "Totals",
            format!(
                "{} bits, unsigned, in m_axis_tdata[{}:{}]{}",
                total.bits,
                contract.tdata_bits - 1,
                total.first_bit,
                if total.saturates() { ", clamped" } else { "" }
            ),
        ),
    }
}

fn describe_counts(contract: &Contract) -> About {
    let scan = &contract.timing.scan;
    let outputs = contract
        .ports()
        .iter()
        .filter(|p| p.direction == Direction::Output)
        .count();
    About::new(
        "sensor_top",
        "DS-CDMA indirect time-of-flight sensor, lasers out, SPAD samples in",
    )
    .note(format!(
        "One clock cycle is one chip of {} samples. The sample word of a chip is expected on \
         i_samples one cycle after o_laser shows the chip. In reset all {outputs} outputs are 0.",
        contract.lanes()
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
            contract.count_bits,
            if contract.saturates() {
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
            contract.result_latency_clocks
        ),
    )
    .fact("Rate", "one chip per clock")
}

/// Each code once, the reference's first, and for each source the index of
/// its code.
fn distinct_codes(reference: &Arc<Code>, sources: &[Arc<Code>]) -> (Vec<Arc<Code>>, Vec<usize>) {
    let mut codes = vec![reference.clone()];
    let mut indices = Vec::new();
    for code in sources {
        let same = |known: &Arc<Code>| {
            Arc::ptr_eq(known, code)
                || (known.interleave == code.interleave && known.generator == code.generator)
        };
        let index = codes.iter().position(same).unwrap_or_else(|| {
            codes.push(code.clone());
            codes.len() - 1
        });
        indices.push(index);
    }
    (codes, indices)
}

impl Logic for SensorTop {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, laser, epoch);
        for g in 0..self._generators {
            self.transmit[g].i_clk.next = self.i_clk.val();
            self.transmit[g].i_rst.next = self.i_rst.val();
            self.transmit[g].i_advance.next = true;
            self.chips.i[g].next = self.transmit[g].o_chip.val();
        }
        self.laser.d.next = self.chips.o.val();
        self.epoch.d.next = self.transmit[0].o_epoch.val();
        self.o_laser.next = self.laser.q.val();
        self.o_epoch.next = self.epoch.q.val();

        self.controller.i_clk.next = self.i_clk.val();
        self.controller.i_rst.next = self.i_rst.val();

        for d in 0..self._detectors {
            self.channel[d].i_clk.next = self.i_clk.val();
            self.channel[d].i_rst.next = self.i_rst.val();
            self.channel[d].i_run.next = self.controller.o_run.val();
            for _ahead in 0..(self.channel[0].i_pre_last_chip.count()) {
                self.channel[d].i_pre_last_chip[0].next = self.controller.o_pre_last_chip[0].val();
            }
            self.channel[d].i_last_chip.next = self.controller.o_last_chip.val();
            self.channel[d].i_dump.next = self.controller.o_dump.val();
        }
        for _one_detector in (self.samples.len())..1 {
            self.channel[0].i_samples.next = self.i_samples.val();
        }
        for lanes in self._lanes..(self._lanes + 1) {
            for d in 0..(self.samples.len()) {
                for l in 0..self._lanes {
                    self.samples[d].i[l].next = self.i_samples.val().get_bit(lanes * d + l);
                }
                self.channel[d].i_samples.next = self.samples[d].o.val();
            }
        }
        for parallel in self._parallel..(self._parallel + 1) {
            for d in 0..self._detectors {
                for p in 0..self._parallel {
                    self.results.i_count[d * parallel + p].next = self.channel[d].o_count[p].val();
                    for _saturates in 0..self.o_saturated.count() {
                        self.results.i_clamped[d * parallel + p].next =
                            self.channel[d].o_clamped[p].val();
                    }
                    for s in 0..(self.peak.len()) {
                        self.peak[s].i_count[d * parallel + p].next =
                            self.channel[d].o_count[p].val();
                    }
                }
            }
        }

        for d in 0..(self.results.i_total.len()) {
            self.results.i_total[d].next = self.channel[d].o_total[0].val();
        }

        for _realigns in 0..self._realigns {
            for g in 0..self._generators {
                self.transmit[g].i_load[0].next = false;
            }
            self.controller.i_epoch[0].next = self.transmit[0].o_epoch.val();
            for d in 0..self._detectors {
                self.channel[d].i_start[0].next = self.controller.o_start[0].val();
            }
        }

        self.results.i_clk.next = self.i_clk.val();
        self.results.i_rst.next = self.i_rst.val();
        for _several in 0..(self.results.i_pre_counted.count()) {
            self.results.i_pre_counted[0].next = self.controller.o_pre_counted[0].val();
        }
        self.results.i_counted.next = self.controller.o_counted.val();
        self.results.i_last.next = self.controller.o_scan_counted.val();
        self.results.i_ready.next = self.m_axis_tready.val();
        self.m_axis_tdata.next = self.results.o_data.val();
        self.m_axis_tvalid.next = self.results.o_valid.val();
        self.m_axis_tlast.next = self.results.o_last.val();
        self.o_overrun.next = self.results.o_overrun.val();
        for _saturates in 0..self.o_saturated.count() {
            self.o_saturated[0].next = self.results.o_saturated[0].val();
        }
        for _peak in 0..(self.peak.len()) {
            self.peak[0].i_clk.next = self.i_clk.val();
            self.peak[0].i_rst.next = self.i_rst.val();
            self.peak[0].i_counted.next = self.controller.o_counted.val();
            self.peak[0].i_last.next = self.controller.o_scan_counted.val();
            self.o_peak_step[0].next = self.peak[0].o_step.val();
            self.o_peak_count[0].next = self.peak[0].o_count.val();
            self.o_peak_valid[0].next = self.peak[0].o_valid.val();
        }
    }
}
