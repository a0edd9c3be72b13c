//! What belongs to one detector.

use super::phase_geometry::{PhaseGeometry, ReferenceStart};
use super::scan_controller::dump_about;
use super::{
    CodeSource, CorrelatorBank, CountClamp, EdgeDetector, HitCounter, PhaseStepper,
    UpdownCorrelator,
};
use crate::code::Code;
use crate::rtl::front::prelude::*;
use crate::sensor::contract::Contract;

/// One detector's hits, its reference, and the counts of its phase steps.
#[derive(Debug, Clone, LogicBlock)]
pub struct DetectorChannel {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Sampled level of the detector.
    pub i_samples: Input<Word>,
    /// The present clock belongs to a scan.
    pub i_run: Input<bool>,
    /// The present chip is the last but one of a group of steps.
    pub i_pre_last_chip: Optional<Input<bool>>,
    /// Last chip of a group of steps.
    pub i_last_chip: Input<bool>,
    /// First clock of a scan comes next.
    pub i_start: Optional<Input<bool>>,
    /// A group's last hits are in; one bit for each segment of the count.
    pub i_dump: Input<Word>,
    /// Counts of the group's steps.
    pub o_count: Vec<Output<Word>>,
    /// Total count of each of them.
    pub o_total: Optional<Output<Word>>,
    /// Which of them were clamped; the first also when the total was.
    pub o_clamped: Vec<Output<bool>>,
    about: About,
    reference: CodeSource,
    stepper: PhaseStepper,
    edges: EdgeDetector,
    correlator: Vec<UpdownCorrelator>,
    bank: Vec<CorrelatorBank>,
    exact: Vec<Local<Word>>,
    clamp: Vec<CountClamp>,
    total: Vec<HitCounter>,
    _bank_steps: usize,
    _last_bank_steps: usize,
    _total_clamps: usize,
}

impl DetectorChannel {
    /// The channel of a detector that follows `code`.
    pub fn new(contract: &Contract, code: &Code) -> DetectorChannel {
        let (lanes, parallel) = (contract.lanes(), contract.parallel());
        let Contract {
            count_segments,
            bank_steps,
            ..
        } = *contract;
        let realigns = contract.realigns();
        let looks_ahead = contract.timing.scan.integration_chips > 1;
        let first_delay = (contract.timing.scan.first_step % u64::from(lanes)) as u32;
        let geometry = PhaseGeometry::new(lanes, parallel, first_delay);
        let (start, next_chip) = reference_start(contract, code, geometry.kept_chips());
        let banks = if parallel > 1 { contract.banks() } else { 0 };
        let first_steps = |bank: u32| bank * bank_steps;
        let steps_of = |bank: u32| bank_steps.min(parallel - first_steps(bank));
        let of_steps = |bits: u32, about: &str| -> Vec<Output<Word>> {
            (0..parallel)
                .map(|step| Output::word(bits, step_about(about, step, parallel)))
                .collect()
        };
        let clamps = if contract.saturates() { parallel } else { 0 };
        let total_clamps = contract.total.is_some_and(|total| total.saturates());
        let clamped_about = |step: u32| match step {
            0 if total_clamps => "clamped, or the total",
            _ => "clamped",
        };
        DetectorChannel {
            i_clk: Input::bit("one chip per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_samples: Input::word(lanes, "level of the SPAD, bit 0 earliest"),
            i_run: Input::bit("the present chip belongs to a scan"),
            i_pre_last_chip: Optional::new(
                looks_ahead && geometry.grows_by_samples(),
                Input::bit("the present chip is the last but one of a phase step"),
            ),
            i_last_chip: Input::bit("last chip of a phase step"),
            i_start: Optional::new(realigns, Input::bit("a scan begins with the next clock")),
            i_dump: Input::word(count_segments.count, dump_about(count_segments.count)),
            o_count: of_steps(contract.count_bits, "signed"),
            o_total: Optional::new(
                contract.total.is_some(),
                Output::word(
                    contract.total.map_or(1, |total| total.bits),
                    "hits of a phase step, up and down together",
                ),
            ),
            o_clamped: (0..clamps)
                .map(|step| Output::bit(step_about(clamped_about(step), step, parallel)))
                .collect(),
            about: describe(contract),
            reference: CodeSource::new(code, next_chip, realigns),
            stepper: PhaseStepper::new(geometry, start, looks_ahead, realigns),
            edges: EdgeDetector::new(lanes),
            correlator: (0..u32::from(parallel == 1))
                .map(|_| UpdownCorrelator::new(lanes, count_segments))
                .collect(),
            bank: (0..banks)
                .map(|bank| {
                    let rest = parallel - first_steps(bank);
                    CorrelatorBank::new(lanes, count_segments, steps_of(bank), rest)
                })
                .collect(),
            exact: (0..parallel)
                .map(|step| {
                    let about = step_about("exact", step, parallel);
                    Local::word(contract.exact_count_bits, about)
                })
                .collect(),
            clamp: (0..clamps)
                .map(|_| CountClamp::new(contract.exact_count_bits, contract.count_bits))
                .collect(),
            total: contract
                .total
                .iter()
                .map(|&plan| HitCounter::new(lanes, plan, count_segments))
                .collect(),
            _bank_steps: bank_steps as usize,
            _last_bank_steps: banks.checked_sub(1).map_or(0, steps_of) as usize,
            _total_clamps: usize::from(total_clamps),
        }
    }
}

fn step_about(about: &str, step: u32, parallel: u32) -> String {
    match parallel {
        1 => format!("count of a phase step, {about}"),
        _ => format!("count of step {step} of the group, {about}"),
    }
}

fn describe(contract: &Contract) -> About {
    let about = About::new(
        "detector_channel",
        "one detector's hits, correlated with its reference",
    )
    .note(
        "The reference runs as the code of the detector's source and is delayed by the phase \
         step; a hit counts up or down as the reference says (eq. 11).",
    );
    if contract.banks() > 1 {
        about.fact(
            "Banks",
            format!(
                "{} of up to {} steps, each a clock behind the one before it",
                contract.banks(),
                contract.bank_steps
            ),
        )
    } else {
        about
    }
}

/// Where the reference stands in reset, which with realignment is also where
/// a scan's start puts it: chips and delayed lanes, and the chip that the
/// generator gives next.
fn reference_start(contract: &Contract, code: &Code, kept_chips: u32) -> (ReferenceStart, u64) {
    let lanes = u64::from(contract.lanes());
    let whole_chips = contract.timing.scan.first_step / lanes;
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

impl Logic for DetectorChannel {
    #[hdl_gen]
    fn update(&mut self) {
        self.reference.i_clk.next = self.i_clk.val();
        self.reference.i_rst.next = self.i_rst.val();
        self.reference.i_advance.next = self.stepper.o_advance.val();

        self.stepper.i_clk.next = self.i_clk.val();
        self.stepper.i_rst.next = self.i_rst.val();
        self.stepper.i_chip.next = self.reference.o_chip.val();
        self.stepper.i_last_chip.next = self.i_last_chip.val();
        for _ahead in 0..self.i_pre_last_chip.count() {
            self.stepper.i_pre_last_chip[0].next = self.i_pre_last_chip[0].val();
        }
        for _realigns in 0..self.i_start.count() {
            self.reference.i_load[0].next = self.i_start[0].val();
            self.stepper.i_start[0].next = self.i_start[0].val();
        }

        self.edges.i_clk.next = self.i_clk.val();
        self.edges.i_rst.next = self.i_rst.val();
        self.edges.i_samples.next = self.i_samples.val();
        self.edges.i_run.next = self.i_run.val();

        for c in 0..(self.correlator.len()) {
            self.correlator[c].i_clk.next = self.i_clk.val();
            self.correlator[c].i_rst.next = self.i_rst.val();
            self.correlator[c].i_hits.next = self.edges.o_hits.val();
            for _pairs in 0..(self.edges.o_early.count()) {
                self.correlator[c].i_early[0].next = self.edges.o_early[0].val();
            }
            self.correlator[c].i_reference.next = self.stepper.o_window.val();
            self.correlator[c].i_dump.next = self.i_dump.val();
            self.exact[c].next = self.correlator[c].o_count.val();
        }
        for b in 0..(self.bank.len()) {
            self.bank[b].i_clk.next = self.i_clk.val();
            self.bank[b].i_rst.next = self.i_rst.val();
        }
        for first in 0..(self.bank.len().min(1)) {
            self.bank[first].i_hits.next = self.edges.o_hits.val();
            for _pairs in 0..(self.edges.o_early.count()) {
                self.bank[first].i_early[0].next = self.edges.o_early[0].val();
            }
            self.bank[first].i_window.next = self.stepper.o_window.val();
            self.bank[first].i_dump.next = self.i_dump.val();
        }
        for b in 1..(self.bank.len()) {
            self.bank[b].i_hits.next = self.bank[b - 1].o_hits[0].val();
            for _pairs in 0..(self.edges.o_early.count()) {
                self.bank[b].i_early[0].next = self.bank[b - 1].o_early[0].val();
            }
            self.bank[b].i_window.next = self.bank[b - 1].o_window[0].val();
            self.bank[b].i_dump.next = self.bank[b - 1].o_dump[0].val();
        }
        for size in self._bank_steps..(self._bank_steps + 1) {
            for b in 0..(self.bank.len().saturating_sub(1)) {
                for q in 0..self._bank_steps {
                    self.exact[size * b + q].next = self.bank[b].o_count[q].val();
                }
            }
            for last in (self.bank.len().saturating_sub(1))..(self.bank.len()) {
                for q in 0..self._last_bank_steps {
                    self.exact[size * last + q].next = self.bank[last].o_count[q].val();
                }
            }
        }

        for first in 0..self._total_clamps {
            self.clamp[first].i_count.next = self.exact[first].val();
            self.o_count[first].next = self.clamp[first].o_count.val();
            self.o_clamped[first].next =
                self.clamp[first].o_clamped.val() | self.total[first].o_clamped[0].val();
        }
        for p in self._total_clamps..(self.clamp.len()) {
            self.clamp[p].i_count.next = self.exact[p].val();
            self.o_count[p].next = self.clamp[p].o_count.val();
            self.o_clamped[p].next = self.clamp[p].o_clamped.val();
        }
        for p in (self.clamp.len())..(self.o_count.len()) {
            self.o_count[p].next = self.exact[p].val();
        }
        for t in 0..(self.total.len()) {
            self.total[t].i_clk.next = self.i_clk.val();
            self.total[t].i_rst.next = self.i_rst.val();
            self.total[t].i_hits.next = self.edges.o_hits.val();
            self.total[t].i_dump.next = self.i_dump.val();
            self.o_total[0].next = self.total[t].o_total.val();
        }
    }
}
