//! The whole sensor.

use std::sync::Arc;

use super::phase_stepper::ReferenceStart;
use super::{
    CodeSource, EdgeDetector, PhaseStepper, ResultStream, ScanController, UpdownCorrelator,
};
use crate::code::Code;
use crate::hdl::front::prelude::*;
use crate::model::contract::{Contract, Direction};

/// Transmit generators, one detector's correlator, and the result stream.
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
    about: About,
    laser: Register<Word>,
    epoch: Register<bool>,
    transmit: Vec<CodeSource>,
    chips: Wiring,
    reference: CodeSource,
    controller: ScanController,
    stepper: PhaseStepper,
    edges: EdgeDetector,
    correlator: UpdownCorrelator,
    results: ResultStream,
    _generators: usize,
    _realigns: usize,
}

impl SensorTop {
    /// The hardware that keeps `contract`, which has one detector and
    /// `parallel` = 1.
    pub fn new(contract: &Contract) -> SensorTop {
        let lanes = contract.lanes;
        let realigns = contract.realigns();
        let reference_code = &contract.reference_codes[0];
        let (codes, source_codes) = distinct_codes(reference_code, &contract.source_codes);
        let (start, generator_start) = reference_start(contract);
        let width = |name: &str| {
            let port = contract.ports().into_iter().find(|p| p.name == name);
            port.map_or(1, |p| p.width)
        };
        let sources = source_codes.len() as u32;
        SensorTop {
            i_clk: Input::bit("one cycle per chip"),
            i_rst: Input::bit("synchronous, active high"),
            o_laser: Output::word(sources, "chip of each source, bit m for source m")
                .under("Lasers"),
            o_epoch: Output::bit("o_laser shows the first chip of the reference's code")
                .under("Lasers"),
            i_samples: Input::word(width("i_samples"), "SPAD level, bit 0 earliest")
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
            about: describe(contract),
            laser: Register::word(sources, 0, "chip of each source"),
            epoch: Register::bit(false, "o_laser shows the first chip of the code"),
            transmit: codes
                .iter()
                .map(|code| CodeSource::new(code, 0, realigns))
                .collect(),
            chips: Wiring::new(codes.len(), source_codes, "next chip of each source"),
            reference: CodeSource::new(reference_code, generator_start, realigns),
            controller: ScanController::new(
                contract.scan.integration_chips,
                contract.scan.steps,
                realigns,
            ),
            stepper: PhaseStepper::new(lanes, start, realigns),
            edges: EdgeDetector::new(lanes),
            correlator: UpdownCorrelator::new(lanes, contract.exact_count_bits),
            results: ResultStream::new(
                contract.exact_count_bits,
                contract.count_bits,
                contract.tdata_bits,
            ),
            _generators: codes.len(),
            _realigns: usize::from(realigns),
        }
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
fn reference_start(contract: &Contract) -> (ReferenceStart, u64) {
    let code = &contract.reference_codes[0];
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
    let start = ReferenceStart {
        present: is_high(present_cycle),
        previous: is_high(present_cycle - 1),
        delayed_lanes: (contract.scan.first_step % lanes) as u32,
    };
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

        self.reference.i_clk.next = self.i_clk.val();
        self.reference.i_rst.next = self.i_rst.val();
        self.reference.i_advance.next = self.stepper.o_advance.val();

        self.stepper.i_clk.next = self.i_clk.val();
        self.stepper.i_rst.next = self.i_rst.val();
        self.stepper.i_chip.next = self.reference.o_chip.val();
        self.stepper.i_step_end.next = self.controller.o_step_end.val();

        for _realigns in 0..self._realigns {
            for g in 0..self._generators {
                self.transmit[g].i_load[0].next = false;
            }
            self.controller.i_epoch[0].next = self.transmit[0].o_epoch.val();
            self.reference.i_load[0].next = self.controller.o_start[0].val();
            self.stepper.i_start[0].next = self.controller.o_start[0].val();
        }

        self.edges.i_clk.next = self.i_clk.val();
        self.edges.i_rst.next = self.i_rst.val();
        self.edges.i_samples.next = self.i_samples.val();
        self.edges.i_run.next = self.controller.o_run.val();

        self.correlator.i_clk.next = self.i_clk.val();
        self.correlator.i_rst.next = self.i_rst.val();
        self.correlator.i_hits.next = self.edges.o_hits.val();
        self.correlator.i_reference.next = self.stepper.o_reference.val();
        self.correlator.i_step_end.next = self.controller.o_step_end.val();
        self.correlator.i_scan_end.next = self.controller.o_scan_end.val();

        self.results.i_clk.next = self.i_clk.val();
        self.results.i_rst.next = self.i_rst.val();
        self.results.i_total.next = self.correlator.o_total.val();
        self.results.i_dump.next = self.correlator.o_dump.val();
        self.results.i_last.next = self.correlator.o_last.val();
        self.results.i_ready.next = self.m_axis_tready.val();
        self.m_axis_tdata.next = self.results.o_data.val();
        self.m_axis_tvalid.next = self.results.o_valid.val();
        self.m_axis_tlast.next = self.results.o_last.val();
        self.o_overrun.next = self.results.o_overrun.val();
        for _saturates in 0..self.o_saturated.count() {
            self.o_saturated[0].next = self.results.o_saturated[0].val();
        }
    }
}
