//! The whole sensor.

use std::sync::Arc;

use super::phase_geometry::{PhaseGeometry, ReferenceStart};
use super::result_stream::StreamPlan;
use super::scan_controller::ScanPlan;
use super::{
    CodeSource, CountClamp, EdgeDetector, PeakDetector, PhaseStepper, ResultStream, ScanController,
    UpdownCorrelator,
};
use crate::code::Code;
use crate::hdl::front::prelude::*;
use crate::model::contract::{Contract, Direction};

/// Transmit generators, each detector's correlators, and the result stream.
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
    reference: Vec<CodeSource>,
    controller: ScanController,
    stepper: Vec<PhaseStepper>,
    edges: Vec<EdgeDetector>,
    correlator: Vec<UpdownCorrelator>,
    clamp: Vec<CountClamp>,
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
        let lanes = contract.lanes;
        let realigns = contract.realigns();
        let parallel = contract.parallel;
        let detectors = contract.reference_codes.len();
        let (codes, source_codes) =
            distinct_codes(&contract.reference_codes[0], &contract.source_codes);
        let geometry = PhaseGeometry::new(
            lanes,
            parallel,
            (contract.scan.first_step % u64::from(lanes)) as u32,
        );
        let starts: Vec<(ReferenceStart, u64)> = contract
            .reference_codes
            .iter()
            .map(|code| reference_start(contract, code, geometry.kept_chips()))
            .collect();
        let looks_ahead = contract.scan.integration_chips > 1;
        let width = |name: &str| {
            let port = contract.ports().into_iter().find(|p| p.name == name);
            port.map_or(1, |p| p.width)
        };
        let sources = source_codes.len() as u32;
        let with_peak = |port| Optional::new(contract.peak.is_some(), port);
        let counts = detectors * parallel as usize;
        let clamps = if contract.saturates() { counts } else { 0 };
        SensorTop {
            i_clk: Input::bit("one cycle per chip"),
            i_rst: Input::bit("synchronous, active high"),
            o_laser: Output::word(sources, "chip of each source, bit m for source m")
                .under("Lasers"),
            o_epoch: Output::bit("o_laser shows the first chip of the reference's code")
                .under("Lasers"),
            i_samples: Input::word(width("i_samples"), samples_about(detectors, lanes))
                .under("Detector"),
            m_axis_tdata: Output::word(width("m_axis_tdata"), "count of a phase step, signed")
                .under("Results, AXI4-Stream"),
            m_axis_tvalid: Output::bit("a result waits").under("Results, AXI4-Stream"),
            m_axis_tready: Input::bit("the receiver takes it").under("Results, AXI4-Stream"),
            m_axis_tlast: Output::bit("it is the scan's last").under("Results, AXI4-Stream"),
            o_overrun: Output::bit("a result was lost since reset")
                .under("Flags, high until reset"),
            o_saturated: Optional::new(
                contract.saturates(),
                Output::bit("a count was clamped since reset").under("Flags, high until reset"),
            ),
            o_peak_step: with_peak(
                Output::word(
                    width("o_peak_step"),
                    peak_about(detectors, "phase step k of the last scan's largest count"),
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
            chips: Wiring::new(codes.len(), source_codes, "next chip of each source"),
            samples: (0..if detectors > 1 { detectors } else { 0 })
                .map(|_| {
                    let lanes = lanes as usize;
                    Wiring::new(lanes, (0..lanes).collect(), "samples of a detector")
                })
                .collect(),
            reference: contract
                .reference_codes
                .iter()
                .zip(&starts)
                .map(|(code, &(_, start))| CodeSource::new(code, start, realigns))
                .collect(),
            controller: ScanController::new(ScanPlan {
                dwell_chips: contract.scan.integration_chips,
                steps: contract.groups(),
                realigns,
                clocks_to_dump: Contract::clocks_to_dump(lanes),
                segments: contract.count_segments.count,
                clocks_to_count: contract.count_segments.clocks(),
            }),
            stepper: starts
                .iter()
                .map(|&(start, _)| PhaseStepper::new(geometry, start, looks_ahead, realigns))
                .collect(),
            edges: (0..detectors).map(|_| EdgeDetector::new(lanes)).collect(),
            correlator: (0..counts)
                .map(|_| UpdownCorrelator::new(lanes, contract.count_segments))
                .collect(),
            clamp: (0..clamps)
                .map(|_| CountClamp::new(contract.exact_count_bits, contract.count_bits))
                .collect(),
            results: ResultStream::new(StreamPlan {
                count_bits: contract.count_bits,
                saturates: contract.saturates(),
                data_bits: contract.tdata_bits,
                detectors: detectors as u32,
                steps: parallel,
                last_steps: contract.last_group_steps() as u32,
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

fn samples_about(detectors: usize, lanes: u32) -> String {
    match detectors {
        1 => "SPAD level, bit 0 earliest".to_owned(),
        _ => format!("SPAD levels, {lanes} samples per detector, bit 0 earliest"),
    }
}

fn describe(contract: &Contract) -> About {
    let scan = &contract.scan;
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
        contract.lanes
    ))
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

/// Where the reference stands in reset, which with realignment is also where
/// a scan's start puts it: chips and delayed lanes, and the chip that the
/// generator gives next.
fn reference_start(contract: &Contract, code: &Code, kept_chips: u32) -> (ReferenceStart, u64) {
    let lanes = u64::from(contract.lanes);
    let whole_chips = contract.scan.first_step / lanes;
    let chip_at = |cycle: i128| {
        let period = i128::from(code.len());
        (cycle - i128::from(whole_chips)).rem_euclid(period) as u64
    };
    // Without realignment reset stands one clock before a scan's first; a
    // scan's start loads what that first clock needs.
    let present_cycle = if contract.realigns() { 0 } else { -1 };
    let is_high = |cycle: i128| code.chips[chip_at(cycle) as usize] == 1;
    let chips = (0..kept_chips)
        .filter(|&back| is_high(present_cycle - i128::from(back)))
        .fold(0, |chips, back| chips | 1 << back);
    let start = ReferenceStart { chips };
    (start, chip_at(present_cycle + 1))
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
            self.reference[d].i_clk.next = self.i_clk.val();
            self.reference[d].i_rst.next = self.i_rst.val();
            self.reference[d].i_advance.next = self.stepper[d].o_advance.val();

            self.stepper[d].i_clk.next = self.i_clk.val();
            self.stepper[d].i_rst.next = self.i_rst.val();
            self.stepper[d].i_chip.next = self.reference[d].o_chip.val();
            self.stepper[d].i_step_end.next = self.controller.o_step_end.val();
            for _ahead in 0..(self.stepper[0].i_step_ends.count()) {
                self.stepper[d].i_step_ends[0].next = self.controller.o_step_ends[0].val();
            }

            self.edges[d].i_clk.next = self.i_clk.val();
            self.edges[d].i_rst.next = self.i_rst.val();
            self.edges[d].i_run.next = self.controller.o_run.val();

            for p in 0..self._parallel {
                for parallel in self._parallel..(self._parallel + 1) {
                    self.correlator[d * parallel + p].i_clk.next = self.i_clk.val();
                    self.correlator[d * parallel + p].i_rst.next = self.i_rst.val();
                    self.correlator[d * parallel + p].i_hits.next = self.edges[d].o_hits.val();
                    for _pairs in 0..(self.edges[0].o_early.count()) {
                        self.correlator[d * parallel + p].i_early[0].next =
                            self.edges[d].o_early[0].val();
                    }
                    self.correlator[d * parallel + p].i_reference.next =
                        self.stepper[d].o_reference[p].val();
                    self.correlator[d * parallel + p].i_dump.next = self.controller.o_dump.val();
                }
            }
        }
        for c in 0..(self.correlator.len()) {
            for _exact in self.o_saturated.count()..1 {
                self.results.i_count[c].next = self.correlator[c].o_count.val();
                for s in 0..(self.peak.len()) {
                    self.peak[s].i_count[c].next = self.correlator[c].o_count.val();
                }
            }
            for _saturates in 0..self.o_saturated.count() {
                self.clamp[c].i_count.next = self.correlator[c].o_count.val();
                self.results.i_count[c].next = self.clamp[c].o_count.val();
                self.results.i_clamped[c].next = self.clamp[c].o_clamped.val();
                for s in 0..(self.peak.len()) {
                    self.peak[s].i_count[c].next = self.clamp[c].o_count.val();
                }
            }
        }
        for _one_detector in (self.samples.len())..1 {
            self.edges[0].i_samples.next = self.i_samples.val();
        }
        for lanes in self._lanes..(self._lanes + 1) {
            for d in 0..(self.samples.len()) {
                for l in 0..self._lanes {
                    self.samples[d].i[l].next = self.i_samples.val().get_bit(lanes * d + l);
                }
                self.edges[d].i_samples.next = self.samples[d].o.val();
            }
        }

        for _realigns in 0..self._realigns {
            for g in 0..self._generators {
                self.transmit[g].i_load[0].next = false;
            }
            self.controller.i_epoch[0].next = self.transmit[0].o_epoch.val();
            for d in 0..self._detectors {
                self.reference[d].i_load[0].next = self.controller.o_start[0].val();
                self.stepper[d].i_start[0].next = self.controller.o_start[0].val();
            }
        }

        self.results.i_clk.next = self.i_clk.val();
        self.results.i_rst.next = self.i_rst.val();
        self.results.i_counted.next = self.controller.o_counted.val();
        self.results.i_last.next = self.controller.o_last.val();
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
            self.peak[0].i_last.next = self.controller.o_last.val();
            self.o_peak_step[0].next = self.peak[0].o_step.val();
            self.o_peak_count[0].next = self.peak[0].o_count.val();
            self.o_peak_valid[0].next = self.peak[0].o_valid.val();
        }
    }
}
