//! What belongs to one detector.
//!
//! Latency that of its parts in turn: edges, correlator, clamp. A detector more costs all of this;
//! the scan controller and the stream are shared.
//!
//! Cost (ECP5, docs/resources.md): 92 LUTs, 162 flip-flops with all that is in it.

use std::sync::Arc;

use super::code_ports::taps_about;
use super::code_source::seed_of;
use super::phase_stepper::{PhaseGeometry, ReferenceStart};
use super::step_ends::dump_about;
use super::{
    CodeSource, CorrelatorBank, CountClamp, EdgeDetector, HitCounter, PhaseStepper,
    UpdownCorrelator,
};
use crate::code::Code;
use crate::rtl::front::prelude::*;
use crate::sensor::interface::{Correlator, CountSegments, Interface};
use crate::sensor::registers::Seed;

#[block(detector_channel)]
/// one detector's hits, correlated with its reference
///
/// The reference runs as the code of the detector's source and is delayed by the phase step; a hit
/// counts up or down as the reference says (eq. 11).
#[when(counts.banks > 1)]
/// - Banks: {counts.banks} of up to {counts.bank_steps} steps, each a clock behind the one before it
pub struct DetectorChannel {
    interface: Interface,
    counts: Correlator,
    code: Arc<Code>,
    #[set(interface.lanes() as usize)]
    lanes: usize,
    #[set(counts.pairs as usize)]
    pairs: usize,
    /// Levels whose edges are counted.
    #[set(interface.input_cells.edges() as usize)]
    cells: usize,
    #[set(interface.parallel() as usize)]
    parallel: usize,
    #[set(counts.count_segments)]
    segments: CountSegments,
    /// Whether a host sets scan and code.
    #[set(interface.registers.is_some())]
    is_set: bool,
    /// What a host sets of the code.
    #[set(seed_of(&interface, &code))]
    seed: Option<Seed>,
    /// Whether the reference is loaded before a scan.
    #[set(interface.realigns() || is_set)]
    realigns: bool,
    #[set(interface.timing.scan.integration_chips > 1)]
    looks_ahead: bool,
    #[set(PhaseGeometry::new(
        interface.lanes(),
        interface.parallel(),
        first_samples(&interface),
    ))]
    geometry: PhaseGeometry,
    #[set(reference_start(&interface, &code, geometry.kept_chips()))]
    start: (ReferenceStart, u64),
    /// Banks of correlators; none where a group is a single step.
    #[set(if parallel > 1 { counts.banks as usize } else { 0 })]
    banks: usize,
    /// Steps in every bank but the last.
    #[set(counts.bank_steps.min(interface.parallel()) as usize)]
    bank_steps: usize,
    #[set(if banks > 0 { parallel / bank_steps } else { 0 })]
    whole_banks: usize,
    /// Steps of a smaller last bank; 0 without one.
    #[set(if banks > 0 { parallel % bank_steps } else { 0 })]
    rest_steps: usize,
    /// Banks that work a clock behind another.
    #[set(banks.saturating_sub(1))]
    delays: usize,
    /// Samples of the reference that all banks but the first take.
    #[set(window_bits(lanes, parallel - bank_steps))]
    later_bits: usize,
    #[set(if counts.saturates() { parallel } else { 0 })]
    clamps: usize,
    #[set(counts.total.is_some_and(|total| total.saturates()))]
    total_saturates: bool,
    /// {if cells > 1 { "level of each cell, bit 0 earliest, cell 0 lowest" } else { "level of the SPAD, bit 0 earliest" }}
    #[width(lanes * cells)]
    pub i_samples: Input<Word>,
    /// the present chip belongs to a scan
    pub i_run: Input<bool>,
    /// the present chip is the last but one of a phase step
    #[when(looks_ahead && geometry.grows_by_samples())]
    pub i_pre_last_chip: Optional<Input<bool>>,
    /// last chip of a phase step
    pub i_last_chip: Input<bool>,
    /// a scan begins with the next clock
    #[when(realigns)]
    pub i_start: Optional<Input<bool>>,
    /// second register's chips at i_start, first in bit 0{taps_about(seed)}
    #[when(seed.is_some())]
    #[width(seed.map_or(0, |seed| seed.bits))]
    pub i_seed: Optional<Input<Word>>,
    /// lanes that take the previous chip in a scan's first step
    #[when(is_set && geometry.grows_by_samples())]
    #[width(lanes - 1)]
    pub i_delayed: Optional<Input<Word>>,
    /// {dump_about(segments.count)}
    #[width(segments.count)]
    pub i_dump: Input<Word>,
    /// {count_about(parallel, "signed")}
    #[each(_step in 0..parallel)]
    #[width(counts.count_bits)]
    pub o_count: Vec<Output<Word>>,
    /// hits of a phase step, up and down together
    #[when(counts.total.is_some())]
    #[width(counts.total.map_or(1, |total| total.bits))]
    pub o_total: Optional<Output<Word>>,
    /// {clamped_about(parallel, total_saturates)}
    #[each(_step in 0..clamps)]
    pub o_clamped: Vec<Output<bool>>,
    #[is(if is_set { CodeSource::seeded(&code, seed) } else { CodeSource::new(&code, start.1, realigns) })]
    reference: CodeSource,
    #[is(PhaseStepper::new(geometry, start.0, looks_ahead, realigns, is_set))]
    stepper: PhaseStepper,
    #[is(EdgeDetector::new(lanes, cells))]
    edges: EdgeDetector,
    #[when(banks == 0)]
    #[is(UpdownCorrelator::new(lanes, pairs, Some(segments)))]
    correlator: Optional<UpdownCorrelator>,
    /// hits for the second bank, and so on
    #[each(_bank in 0..delays)]
    #[width(pairs)]
    hits: Vec<Register<Word>>,
    /// the hit is the earlier sample of its pair
    #[each(_bank in 0..if lanes > 1 { delays } else { 0 })]
    #[width(pairs)]
    early: Vec<Register<Word>>,
    /// reference for the second bank's steps and all later ones, and so on
    #[each(_bank in 0..delays)]
    #[width(later_bits)]
    window: Vec<Register<Word>>,
    /// the last bank has no use for the low bits; linters know by the name
    #[when(delays > 0)]
    unused: Optional<Local<bool>>,
    /// {dump_about(segments.count)}
    #[each(_bank in 0..delays)]
    #[width(segments.count)]
    dump: Vec<Register<Word>>,
    #[each(_bank in 0..whole_banks)]
    #[is(CorrelatorBank::new(lanes, pairs, segments, bank_steps))]
    bank: Vec<CorrelatorBank>,
    #[when(rest_steps > 0)]
    #[is(CorrelatorBank::new(lanes, pairs, segments, rest_steps))]
    last_bank: Optional<CorrelatorBank>,
    /// {count_about(parallel, "exact")}
    #[each(_step in 0..parallel)]
    #[width(counts.exact_count_bits)]
    exact: Vec<Local<Word>>,
    #[each(_step in 0..clamps)]
    #[is(CountClamp::new(counts.exact_count_bits as usize, counts.count_bits as usize))]
    clamp: Vec<CountClamp>,
    #[each(total in counts.total.iter())]
    #[is(HitCounter::new(pairs, *total, segments))]
    total: Vec<HitCounter>,
}

/// Samples of the reference that so many phase steps at once take.
fn window_bits(lanes: usize, steps: usize) -> usize {
    lanes + steps - 1
}

fn count_about(parallel: usize, about: &str) -> String {
    match parallel {
        1 => format!("count of a phase step, {about}"),
        _ => format!("counts of the group's steps, {about}, step 0 lowest"),
    }
}

fn clamped_about(parallel: usize, total_saturates: bool) -> &'static str {
    match (parallel, total_saturates) {
        (1, false) => "it was clamped",
        (1, true) => "it was clamped, or the total",
        (_, false) => "which of them were clamped",
        (_, true) => "which of them were clamped; the first also if the total was",
    }
}

/// Samples of the first delay within a chip, where it is known; a host sets any.
pub(super) fn first_samples(interface: &Interface) -> u32 {
    match &interface.registers {
        Some(plan) => plan.fixed_samples.unwrap_or(0),
        None => (interface.timing.scan.first_step % u64::from(interface.lanes())) as u32,
    }
}

/// Where the reference stands in reset, which with realignment is also where
/// a scan's start puts it: chips and delayed lanes, and the chip that the
/// generator gives next.
pub(super) fn reference_start(
    interface: &Interface,
    code: &Code,
    kept_chips: u32,
) -> (ReferenceStart, u64) {
    if interface.registers.is_some() {
        return (ReferenceStart { chips: 0 }, 0);
    }
    let lanes = u64::from(interface.lanes());
    let whole_chips = interface.timing.scan.first_step / lanes;
    let chip_at = |cycle: i128| {
        let period = i128::from(code.len());
        (cycle - i128::from(whole_chips)).rem_euclid(period) as u64
    };
    // Without realignment reset stands one clock before a scan's first; a
    // scan's start loads what that first clock needs.
    let present_cycle = if interface.realigns() { 0 } else { -1 };
    let is_high = |cycle: i128| code.chips[chip_at(cycle) as usize] == 1;
    let chips = (0..kept_chips)
        .filter(|&back| is_high(present_cycle - i128::from(back)))
        .fold(0, |chips, back| chips | 1 << back);
    let start = ReferenceStart { chips };
    (start, chip_at(present_cycle + 1))
}

#[kernel]
impl Logic for DetectorChannel {
    fn update(&mut self) {
        self.reference.i_advance.next = self.stepper.o_advance.val();
        self.stepper.i_chip.next = self.reference.o_chip.val();
        connect! { self.stepper from self: i_last_chip, i_pre_last_chip }
        if self.i_start.is_present() {
            self.reference.i_load.next = self.i_start.val();
            connect! { self.stepper from self: i_start }
        }
        connect! { self.reference from self: i_seed }
        connect! { self.stepper from self: i_delayed }
        connect! { self.edges from self: i_samples, i_run }
        if self.correlator.is_present() {
            self.correlate();
        } else {
            self.feed_banks();
            self.gather_counts();
        }
        self.clamp_counts();
        for t in 0..self.total.len() {
            connect! { self.total[t] from self.edges: i_hits }
            connect! { self.total[t] from self: i_dump }
            self.o_total.next = self.total[t].o_total.val();
        }
    }

    /// One step at a time.
    fn correlate(&mut self) {
        connect! { self.correlator from self.edges: i_hits, i_early }
        self.correlator.i_reference.next = self.stepper.o_window.val();
        connect! { self.correlator from self: i_dump }
        self.exact[0].next = self.correlator.o_count.val();
    }

    /// Each bank works a clock behind the one before it, so that no register has to reach all
    /// correlators within a clock.
    fn feed_banks(&mut self) {
        let size = self.bank_steps;
        if self.delays > 0 {
            self.hits[0].next = self.edges.o_hits.val();
            self.window[0].next = bit_cast(self.stepper.o_window.val(), self.later_bits);
            self.dump[0].next = self.i_dump.val();
        }
        for b in 1..self.window.len() {
            self.hits[b].next = self.hits[b - 1].val();
            self.window[b].next = self.window[b - 1].val() << size;
            self.dump[b].next = self.dump[b - 1].val();
        }
        if self.unused.is_present() {
            self.unused.next = self.window[self.delays - 1].val().all();
        }
        if !self.early.is_empty() {
            self.early[0].next = self.edges.o_early.val();
        }
        for b in 1..self.early.len() {
            self.early[b].next = self.early[b - 1].val();
        }
        self.correlate_in_banks();
    }

    fn correlate_in_banks(&mut self) {
        let size = self.bank_steps;
        let bits = window_bits(self.lanes, size);
        let below = self.parallel - size;
        let later_below = below.saturating_sub(size);
        self.bank[0].i_window.next = self.stepper.o_window.val().slice(below, bits);
        connect! { self.bank[0] from self.edges: i_hits, i_early }
        connect! { self.bank[0] from self: i_dump }
        for b in 1..self.bank.len() {
            self.bank[b].i_window.next = self.window[b - 1].val().slice(later_below, bits);
            self.bank[b].i_hits.next = self.hits[b - 1].val();
            if !self.early.is_empty() {
                self.bank[b].i_early.next = self.early[b - 1].val();
            }
            self.bank[b].i_dump.next = self.dump[b - 1].val();
        }
        if self.last_bank.is_present() {
            self.correlate_in_last_bank();
        }
    }

    /// A bank of fewer steps: its reference is on top as well.
    fn correlate_in_last_bank(&mut self) {
        let last = self.delays - 1;
        let below = self.parallel - self.bank_steps - self.rest_steps;
        let bits = window_bits(self.lanes, self.rest_steps);
        self.last_bank.i_hits.next = self.hits[last].val();
        if self.edges.o_early.is_present() {
            self.last_bank.i_early.next = self.early[last].val();
        }
        self.last_bank.i_window.next = self.window[last].val().slice(below, bits);
        self.last_bank.i_dump.next = self.dump[last].val();
    }

    fn gather_counts(&mut self) {
        let size = self.bank_steps;
        let whole = self.whole_banks;
        for b in 0..whole {
            for q in 0..size {
                self.exact[size * b + q].next = self.bank[b].o_count[q].val();
            }
        }
        for q in 0..self.rest_steps {
            self.exact[size * whole + q].next = self.last_bank.o_count[q].val();
        }
    }

    /// The nearest counts that fit; the first is also marked when the total did not.
    fn clamp_counts(&mut self) {
        for p in 0..self.clamp.len() {
            self.clamp[p].i_count.next = self.exact[p].val();
            self.o_count[p].next = self.clamp[p].o_count.val();
            self.o_clamped[p].next = if self.total_saturates && p == 0 {
                self.clamp[p].o_clamped.val() | self.total[0].o_clamped.val()
            } else {
                self.clamp[p].o_clamped.val()
            };
        }
        for p in self.clamp.len()..self.o_count.len() {
            self.o_count[p].next = self.exact[p].val();
        }
    }
}
