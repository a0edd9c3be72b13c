//! The proofs of a design: what of it each looks at, and how it is found.

use std::sync::Arc;

use super::numbers::{row_bits, scan_clocks};
use crate::code::Code;
use crate::deliver::design::EmittedDesign;
use crate::rtl::back::BLOCK_MEMORY;
use crate::sensor::histogram::HistogramPlan;
use crate::sensor::interface::{Correlator, Counting, Interface};
use crate::sensor::registers::{RegisterPlan, is_same};

/// A proof of which the module stands in this folder's files.
#[derive(Debug, Clone)]
pub(super) struct Proof {
    /// Name of the proof and of its task.
    pub(super) name: &'static str,
    pub(super) engine: ProofEngine,
    /// Signals of the proof that are those of the design, with their places below `sensor_top`.
    pub(super) seen: Vec<(String, String)>,
    /// Places whose signals the proof drives.
    pub(super) cut: Vec<(String, String)>,
    /// Modules that have their ports only, so that their outputs can be driven.
    emptied: Vec<&'static str>,
    /// Modules whose outputs may be anything at any clock.
    freed: Vec<&'static str>,
    /// Registers that may begin with anything, by their name in each module.
    pub(super) begun: Option<&'static str>,
}

/// How a proof is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ProofEngine {
    /// A search through so many clocks after reset, induction over four clocks with all
    /// equivalences of design and specification as hypotheses, then property directed
    /// reachability for what is left.
    Induction(u32),
    /// Property directed reachability alone.
    Reachability,
    /// Property directed reachability from any state of the registers, with i_rst high.
    InReset,
    /// Induction over so many clocks: from any state on, behind as many in which all that is to
    /// hold does, in reset or not, comes another one. A fault shows within these clocks, however
    /// long the design's counters run before.
    Steps(u32),
    /// No proof but a search through so many clocks after reset.
    Bounded(u32),
}

impl Proof {
    fn new(name: &'static str, engine: ProofEngine) -> Proof {
        let (seen, cut, emptied, freed, begun) = Default::default();
        Proof { name, engine, seen, cut, emptied, freed, begun }
    }

    /// Makes a signal inside readable.
    fn see(&mut self, signal: &str, place: &str) {
        self.seen.push((signal.to_owned(), place.to_owned()));
    }

    /// Drives an output of an emptied module.
    fn drive(&mut self, place: &str, signal: &str) {
        self.cut.push((signal.to_owned(), place.to_owned()));
    }

    /// Whether any module is there with its ports alone.
    pub(super) fn is_cut(&self) -> bool {
        !(self.emptied.is_empty() && self.freed.is_empty())
    }

    /// Whether the module of this name is there with its ports alone.
    pub(super) fn empties(&self, module: &str) -> bool {
        self.emptied.contains(&block(module)) || self.frees(module)
    }

    /// Whether the outputs of the module of this name may be anything.
    pub(super) fn frees(&self, module: &str) -> bool {
        self.freed.contains(&block(module))
    }

    /// The macro with which the registers are mapped; none where they are as they are.
    pub(super) fn register_map(&self) -> Option<&'static str> {
        match self.engine {
            ProofEngine::Steps(_) => None,
            ProofEngine::InReset => Some("-D IN_RESET "),
            _ => Some(""),
        }
    }

    /// Name of the task that looks whether its assertions can be reached; none where they ask
    /// for nothing.
    pub(super) fn cover_task(&self) -> Option<String> {
        (self.engine != ProofEngine::InReset).then(|| format!("{}_cover", self.name))
    }

    /// Clocks within which they are, from any state on.
    pub(super) fn cover_depth(&self) -> u32 {
        match self.engine {
            // The clocks before, the one behind them, and one more.
            ProofEngine::Steps(clocks) => clocks + 2,
            _ => 4,
        }
    }

    /// The options of its task.
    pub(super) fn options(&self) -> Vec<String> {
        let bounded = |depth: u32| vec!["mode bmc".to_owned(), format!("depth {depth}")];
        match self.engine {
            ProofEngine::Steps(_) => bounded(self.cover_depth()),
            ProofEngine::Bounded(clocks) => bounded(clocks),
            _ => vec!["mode prove".to_owned()],
        }
    }

    /// The engine's line in the `.sby` file.
    pub(super) fn engine_line(&self) -> String {
        match self.engine {
            // What shows within the pipelines is found at once; scorr and pdr would look long for it.
            ProofEngine::Induction(clocks) => {
                format!("abc bmc3 -F {clocks}; scorr -F 4 -C 100000; pdr")
            }
            ProofEngine::Reachability | ProofEngine::InReset => "abc pdr".to_owned(),
            ProofEngine::Steps(_) | ProofEngine::Bounded(_) => "abc bmc3".to_owned(),
        }
    }
}

/// The block that a module is one of: those that differ have a number at the end.
fn block(module: &str) -> &str {
    match module.rsplit_once('_') {
        Some((block, number)) if number.bytes().all(|b| b.is_ascii_digit()) => block,
        _ => module,
    }
}

/// Part `number` of a signal of several parts of so many bits.
fn part(signal: &str, number: u32, bits: u32) -> String {
    match bits {
        1 => format!("{signal}[{number}]"),
        _ => format!("{signal}[{}:{}]", (number + 1) * bits - 1, number * bits),
    }
}

/// Clocks in which what is wrong in a pipeline shows.
const PIPELINE_CLOCKS: u32 = 9;

/// The proofs of a design.
pub(super) fn proofs(design: &EmittedDesign) -> Vec<Proof> {
    let interface = design.interface();
    let channels = channels(design);
    let mut codes = Proof::new("codes", ProofEngine::Induction(PIPELINE_CLOCKS));
    let mut proofs = vec![Proof::new("reset", ProofEngine::InReset)];
    match &interface.counting {
        Counting::Correlator(correlator) => {
            if interface.realigns() {
                codes.see("epoch_seen", "controller.i_epoch");
            }
            proofs.extend(match &interface.registers {
                None => {
                    vec![codes, scan(interface, correlator), reference(interface, &channels)]
                }
                Some(plan) => vec![set_codes(plan), registers(plan)],
            });
            // A row's counts and results are words in memories, which are beyond these proofs.
            if correlator.rows.is_none() {
                let stream = stream(interface, &channels);
                proofs.extend([counts(interface, correlator, &channels), stream]);
            }
            proofs.extend(correlator.peak.map(|_| peak(interface, &channels)));
        }
        Counting::Histogram(plan) => {
            let [scan, stream] = ["scan", "stream"].map(|name| frames(name, interface, plan));
            proofs.extend([codes, scan, stream]);
        }
    }
    proofs.push(Proof::new("axis", ProofEngine::Reachability));
    if interface.registers.is_some() {
        proofs.iter_mut().for_each(|proof| proof.freed.push("register_memory"));
    }
    if interface.histogram().is_some() || interface.rows().is_some() {
        // Words in memories are beyond these proofs, and reset does not reach a memory's registers.
        proofs.iter_mut().for_each(|proof| proof.freed.push(BLOCK_MEMORY));
    }
    if interface.rows().is_some() {
        proofs.iter_mut().for_each(|proof| proof.freed.push("lookup_memory"));
    }
    proofs
}

fn scan(interface: &Interface, correlator: &Correlator) -> Proof {
    let mut proof = Proof::new("scan", ProofEngine::Steps(scan_clocks(correlator)));
    let chips = interface.timing.scan.integration_chips;
    let results = correlator.queued(interface.reference_codes.len() as u32 * interface.parallel());
    for (is_there, signal, place) in [
        (true, "run_seen", "o_run"),
        (true, "step_end_seen", "o_last_chip"),
        (true, "dump_seen", "o_dump"),
        (true, "counted_seen", "o_counted"),
        (true, "last_seen", "o_scan_counted"),
        (interface.realigns(), "epoch_seen", "i_epoch"),
        (interface.realigns(), "start_seen", "o_start"),
        (chips > 1, "step_ends_seen", "o_pre_last_chip"),
        (chips > 2, "chip_seen", "chip_count_r"),
        (interface.groups() > 1, "step_seen", "step_count_r"),
        (interface.groups() > 1, "last_step_seen", "last_step_r"),
        (results > 1, "counts_seen", "o_pre_counted"),
    ] {
        if is_there {
            proof.see(signal, &format!("controller.{place}"));
        }
    }
    proof
}

/// Codes as a host sets them, whenever they run.
fn set_codes(plan: &RegisterPlan) -> Proof {
    let mut proof = Proof::new("codes", ProofEngine::Induction(PIPELINE_CLOCKS));
    proof.emptied = vec!["scan_sequencer"];
    proof.freed = vec!["detector_channel"];
    proof.drive("sequencer.o_on", "on");
    if plan.seed_bits() > 0 {
        proof.drive("sequencer.o_seed", "seed");
    }
    proof
}

/// The slave's rules, and settings that are steady while codes run.
fn registers(plan: &RegisterPlan) -> Proof {
    let mut proof = Proof::new("registers", ProofEngine::Reachability);
    proof.freed = vec!["detector_channel"];
    proof.see("on_seen", "sequencer.o_on");
    let mut from = 0;
    let mut see = |place: &str, bits: u32| {
        let signal = format!("settings_seen[{}:{from}]", from + bits - 1);
        proof.see(&signal, &format!("sequencer.{place}"));
        from += bits;
    };
    see("chips_r", plan.chips_bits);
    see("groups_r", plan.groups_bits);
    see("delay_r", plan.delay_bits);
    if plan.lanes() > 0 {
        see("o_delayed", plan.lanes());
    }
    if plan.seed_bits() > 0 {
        see("o_seed", plan.seed_bits());
    }
    proof
}

/// The module that says when steps and scans end, and its instance.
fn controller(interface: &Interface) -> (&'static str, &'static str) {
    match interface.registers {
        None => ("scan_controller", "controller"),
        Some(_) => ("scan_sequencer", "sequencer"),
    }
}

/// For each detector where its reference is delayed; like ones are made by a loop.
fn channels(design: &EmittedDesign) -> Vec<String> {
    let top = design.files.last().map_or("", |file| file.text.as_str());
    let interface = design.interface();
    let detectors = interface.reference_codes.len();
    if interface.rows().is_some() {
        return row_references(interface);
    }
    let channel = |d: usize| match (detectors, top.contains("begin : gen_channel")) {
        (1, _) => "channel".to_owned(),
        (_, true) => format!("gen_channel[{d}].channel"),
        (_, false) => format!("channel_{d}"),
    };
    (0..detectors).map(channel).collect()
}

/// The same of a row, whose detectors share the references of their codes.
fn row_references(interface: &Interface) -> Vec<String> {
    let mut known: Vec<&Arc<Code>> = Vec::new();
    let mut number = |code| {
        known.iter().position(|&before| is_same(before, code)).unwrap_or_else(|| {
            known.push(code);
            known.len() - 1
        })
    };
    let numbers: Vec<usize> = interface.reference_codes.iter().map(&mut number).collect();
    let of_code = |&code: &usize| match known.len() {
        1 => "array.stepper".to_owned(),
        _ => format!("array.gen_stepper[{code}].stepper"),
    };
    numbers.iter().map(of_code).collect()
}

/// The references of all samples of a detector, and their place.
fn window(interface: &Interface, d: u32, channel: &str) -> (String, String) {
    let bits = interface.lanes() + interface.parallel() - 1;
    let stepper = match interface.rows() {
        Some(_) => channel.to_owned(),
        None => format!("{channel}.stepper"),
    };
    (part("windows", d, bits), format!("{stepper}.o_window"))
}

/// All that a detector's channel counts, and its places.
fn counted(interface: &Interface, d: u32, channel: &str) -> Vec<(String, String)> {
    let parallel = interface.parallel();
    let of = |signal, port: &str, bits| (part(signal, d, bits), format!("{channel}.{port}"));
    let mut all = vec![of("counts", "o_count", parallel * interface.count_bits())];
    if interface.saturates() {
        all.push(of("clamped", "o_clamped", parallel));
    }
    all.extend(interface.total().map(|total| of("totals", "o_total", total.bits)));
    all
}

fn reference(interface: &Interface, channels: &[String]) -> Proof {
    // The delay grows to a whole chip, a sample with each step, before the reference waits.
    let clocks = PIPELINE_CLOCKS.max(interface.lanes() + 6);
    let mut proof = Proof::new("reference", ProofEngine::Induction(clocks));
    proof.emptied = vec!["scan_controller"];
    proof.drive("controller.o_last_chip", "ends");
    if interface.timing.scan.integration_chips > 1 {
        proof.drive("controller.o_pre_last_chip", "before_last");
    }
    if interface.realigns() {
        proof.drive("controller.o_start", "start");
    }
    let windows = (0..).zip(channels);
    proof.seen.extend(windows.map(|(d, channel)| window(interface, d, channel)));
    proof
}

fn counts(interface: &Interface, correlator: &Correlator, channels: &[String]) -> Proof {
    let mut proof = Proof::new("counts", ProofEngine::Induction(PIPELINE_CLOCKS));
    let begins = correlator.count_segments.count == 1;
    proof.begun = begins.then_some("base_r");
    let (module, instance) = controller(interface);
    proof.emptied = vec![module, "phase_stepper"];
    proof.drive(&format!("{instance}.o_run"), "run");
    proof.drive(&format!("{instance}.o_dump"), "dumps");
    for (d, channel) in (0..).zip(channels) {
        proof.cut.push(window(interface, d, channel));
        proof.seen.extend(counted(interface, d, channel));
        if begins {
            proof.seen.extend(bases(correlator, interface.parallel(), d, channel));
        }
    }
    proof
}

/// What each total of a detector was at the last dump, and its places.
fn bases(counting: &Correlator, steps: u32, d: u32, channel: &str) -> Vec<(String, String)> {
    let (bits, bank_steps) = (counting.exact_count_bits, counting.bank_steps);
    let whole_banks = steps / bank_steps;
    let correlator = |step: u32| {
        let (bank, step_of_bank) = (step / bank_steps, step % bank_steps);
        let bank = match whole_banks {
            _ if steps == 1 => return "correlator".to_owned(),
            whole if bank == whole && bank > 0 => "last_bank".to_owned(),
            0 | 1 => "bank".to_owned(),
            _ => format!("gen_bank[{bank}].bank"),
        };
        format!("{bank}.gen_correlator[{step_of_bank}].correlator")
    };
    let place = |part: &str| format!("{channel}.{part}.total.base_r");
    let of_step = |q: u32| (part("bases", d * steps + q, bits), place(&correlator(q)));
    let of_total = |bits| (part("total_bases", d, bits), place("total"));
    let total = counting.total.map(|total| of_total(total.exact_bits));
    (0..steps).map(of_step).chain(total).collect()
}

fn stream(interface: &Interface, channels: &[String]) -> Proof {
    let mut proof = Proof::new("stream", ProofEngine::Induction(PIPELINE_CLOCKS));
    let (module, instance) = controller(interface);
    proof.emptied = vec![module, "detector_channel"];
    for (d, channel) in (0..).zip(channels) {
        proof.cut.extend(counted(interface, d, channel));
    }
    if interface.reference_codes.len() as u32 * interface.parallel() > 1 {
        proof.drive(&format!("{instance}.o_pre_counted"), "comes");
    }
    proof.drive(&format!("{instance}.o_counted"), "counted");
    proof.drive(&format!("{instance}.o_scan_counted"), "last");
    proof
}

fn peak(interface: &Interface, channels: &[String]) -> Proof {
    let mut proof = Proof::new("peak", ProofEngine::Bounded(30));
    let (module, instance) = controller(interface);
    proof.emptied = vec![module, "detector_channel"];
    proof.drive(&format!("{instance}.o_counted"), "counted");
    proof.drive(&format!("{instance}.o_scan_counted"), "last");
    for (d, channel) in (0..).zip(channels) {
        proof.cut.extend(counted(interface, d, channel).into_iter().take(1));
    }
    proof
}

/// Rows, code periods and frames of a histogram, and what the memories are told of them; and, in
/// `stream`, rows on the stream.
fn frames(name: &'static str, interface: &Interface, plan: &HistogramPlan) -> Proof {
    let mut proof = Proof::new(name, ProofEngine::Steps(1));
    proof.freed.push("histogram_channel");
    let turns = plan.takes_turns();
    for (is_there, signal, place) in [
        (true, "run_seen", "o_run"),
        (true, "row_seen", "o_row"),
        (true, "ahead_seen", "ahead_r"),
        (true, "ahead_is_last_seen", "ahead_is_last_r"),
        (true, "row_is_last_seen", "row_is_last_r"),
        (true, "first_seen", "first_r"),
        (plan.periods > 1, "period_seen", "period_r"),
        (plan.periods > 1, "period_is_last_seen", "period_is_last_r"),
        (true, "firsts_seen", "first_before_r"),
        (!turns, "come_first_seen", "o_come_first"),
        (true, "held_first_seen", "o_held_first"),
        (true, "added_first_seen", "o_added_first"),
    ] {
        if is_there {
            proof.see(&format!("words.{signal}"), &format!("control.{place}"));
        }
    }
    // Rows of the words before, and the last of them as the memories get it.
    let (bits, kept) = (row_bits(plan), 5 * row_bits(plan));
    proof.see(
        &format!("words.rows_seen[{}:0]", kept - 1),
        &format!("control.row_before_r[{}:0]", kept - 1),
    );
    proof.see(&format!("words.rows_seen[{}:{kept}]", kept + bits - 1), "control.o_write_row");
    if name == "stream" {
        rows(interface, turns, &mut proof);
    }
    proof
}

fn rows(interface: &Interface, turns: bool, proof: &mut Proof) {
    let several = turns && interface.reference_codes.len() > 1;
    for (is_there, signal, place) in [
        (true, "room_seen", "room_r"),
        (true, "shows_seen", "o_shows"),
        (!turns, "follows_seen", "follows_r"),
        (!turns, "wholes_seen", "whole_before_r"),
        (!turns, "lasts_seen", "last_before_r"),
        (turns, "half_seen", "o_half"),
        (turns, "halves_seen", "half_before_r"),
        (turns, "come_half_seen", "o_come_half"),
        (turns, "held_half_seen", "o_held_half"),
        (turns, "write_half_seen", "o_write_half"),
        (turns, "reads_seen", "reads_r"),
        (turns, "read_row_seen", "o_read_row"),
        (turns, "read_is_last_seen", "read_is_last_r"),
        (turns, "out_seen", "out_r"),
        (turns, "last_out_seen", "last_out_r"),
        (turns, "go_seen", "o_go"),
        (several, "detector_seen", "detector_r"),
    ] {
        if is_there {
            proof.see(signal, &format!("control.{place}"));
        }
    }
    if several {
        proof.see("detector_out_seen", "control.detector_out_r");
    }
}
