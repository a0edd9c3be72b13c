//! A recorded run: hostile inputs and what the reference model makes of them.

use super::run_length::Runs;
use crate::reference::adversarial::{Adversarial, Means, WrittenRun};
use crate::reference::blocks::Block;
use crate::reference::cover_report::Coverage;
use crate::reference::predictor::{ReferenceError, Skip};
use crate::rtl::blocks::{CountRegister, ScanRegisters};
use crate::sensor::Sensor;
use crate::sensor::interface::Interface;
use crate::sensor::layout::{Field, Layout};
use crate::sensor::port::{Port, PortRole, Use};

/// Longest run: an interpreting simulator takes seconds for it.
pub const MOST_CLOCKS: u64 = 100_000;
/// What the adversary may do in it. The way to one cover point takes no more than a
/// quarter of the run.
const MEANS: Means = Means {
    skips: true,
    most_clocks_of_recipe: 24_000,
    most_clocks_of_talk: 24_000,
    calm_clocks: 2_000,
    clocks_of_large_counts: 40_000,
    clocks_of_close_counts: 0,
};
/// Seed of the adversary: not the one that co-simulation begins with.
const SEED: u64 = 2;

/// What a vector file holds one behind the other: a port, or a counter of the scan.
#[derive(Debug, Clone)]
pub struct VectorColumn {
    /// Its name.
    pub name: String,
    /// Bits.
    pub width: u32,
    /// It counts while `m_axis_tvalid` is high alone.
    pub is_payload: bool,
}

impl VectorColumn {
    fn of(port: &Port) -> VectorColumn {
        let is_payload = port.role.is_payload();
        VectorColumn { name: port.name.clone(), width: port.width, is_payload }
    }
}

/// Ports that share a vector file, from bit 0 up.
#[derive(Debug, Clone)]
pub struct PortGroup {
    /// The ports.
    pub ports: Vec<VectorColumn>,
    /// Their values, clock by clock.
    pub runs: Runs,
    /// Where their bits lie in a record, in the same order.
    parts: Vec<RecordPart>,
    /// The record whose values were added last; 0 before any was.
    last: Vec<u64>,
    /// The value being put together.
    packed: Vec<u64>,
}

/// Bits of ports in one word of a record, which lie as far from each other as in the packed value.
#[derive(Debug, Clone)]
struct RecordPart {
    word: usize,
    bits: u64,
    /// Where bit 0 of the first port is in the word, and in the packed value.
    shift: u32,
    to: u32,
}

impl RecordPart {
    /// Those of some ports. One that has more than one word begins with a word.
    fn of(fields: &[Field]) -> Vec<RecordPart> {
        let mut parts: Vec<RecordPart> = Vec::new();
        let mut to = 0;
        for field in fields {
            for (to, (word, bits)) in (to..).step_by(64).zip(field.words()) {
                let shift = field.shift;
                match parts.last_mut() {
                    Some(part) if part.word == word && shift - part.shift == to - part.to => {
                        part.bits |= bits;
                    }
                    _ => parts.push(RecordPart { word, bits, shift, to }),
                }
            }
            to += field.port.width;
        }
        parts
    }
}

impl PortGroup {
    /// Of ports that lie in records of so many words.
    fn new(fields: &[Field], words: usize) -> PortGroup {
        let group = PortGroup::plain(fields.iter().map(|field| VectorColumn::of(&field.port)));
        PortGroup {
            runs: Runs::with_room(MOST_CLOCKS as usize + 1, group.packed.len()),
            parts: RecordPart::of(fields),
            last: vec![0; words],
            ..group
        }
    }

    /// Values that stand in no record.
    fn plain(ports: impl Iterator<Item = VectorColumn>) -> PortGroup {
        let mut group = PortGroup {
            ports: ports.collect(),
            runs: Runs::default(),
            parts: Vec::new(),
            last: Vec::new(),
            packed: Vec::new(),
        };
        group.packed = vec![0; group.bits().div_ceil(64) as usize];
        group
    }

    /// Bits of all ports.
    pub fn bits(&self) -> u32 {
        self.ports.iter().map(|port| port.width).sum()
    }

    /// For so many clocks.
    fn push_zeros(&mut self, clocks: u64) {
        self.packed.fill(0);
        self.runs.push(&self.packed, clocks);
    }

    /// One value for each port, of at most 64 bits.
    fn push_values(&mut self, values: &[u64]) {
        self.packed.fill(0);
        let mut at = 0;
        for (port, value) in self.ports.iter().zip(values) {
            put(&mut self.packed, at, *value);
            at += port.width;
        }
        self.runs.push(&self.packed, 1);
    }

    /// The values of records that follow one another.
    fn push(&mut self, records: &[u64]) {
        let PortGroup { runs, parts, last, packed, .. } = self;
        let mut before = &last[..];
        // Clocks for which the last value holds on.
        let mut more = 0;
        for record in records.chunks_exact(last.len()) {
            let differs =
                |part: &RecordPart| (record[part.word] ^ before[part.word]) & part.bits != 0;
            if !runs.is_empty() && !parts.iter().any(differs) {
                more += 1;
                continue;
            }
            runs.prolong(std::mem::take(&mut more));
            before = record;
            let value = runs.begin(packed.len(), 1);
            for RecordPart { word, bits, shift, to } in &*parts {
                put(value, *to, (record[*word] & bits) >> shift);
            }
        }
        runs.prolong(more);
        *last = before.to_vec();
    }
}

/// ORs `value` into `packed` at bit `at`.
fn put(packed: &mut [u64], at: u32, value: u64) {
    let (word, shift) = (at as usize / 64, at % 64);
    packed[word] |= value << shift;
    if shift > 0 && value >> (64 - shift) != 0 {
        packed[word + 1] |= value >> (64 - shift);
    }
}

/// Inputs and expected outputs of a testbench.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Every input but the clock.
    pub inputs: PortGroup,
    /// Lasers and epoch, which change from chip to chip. As every output: what
    /// stands there before the first clock, then after each.
    pub chips: PortGroup,
    /// The other outputs, which change from phase step to phase step.
    pub results: PortGroup,
    /// What moves the scan's counters on before each clock, if anything ever does.
    pub skips: Option<Skips>,
    /// Clocks of the run.
    pub clocks: u64,
    /// Times that it enters reset.
    pub resets: u64,
    /// Phase steps whose integration ends in it.
    pub phase_steps: u64,
    /// Scans whose last phase step ends in it.
    pub scans: u64,
    /// Hits that the results on the stream count up.
    pub hits_up: u64,
    /// Hits that they count down.
    pub hits_down: u64,
    /// What it covers.
    pub coverage: Coverage,
}

/// How the scan's counters are moved on.
#[derive(Debug, Clone)]
pub struct Skips {
    /// The counters, from bit 0 up.
    pub registers: Vec<CountRegister>,
    /// What goes into them before each clock.
    pub values: PortGroup,
    /// The first clock before which one moves.
    pub first_clock: u64,
}

/// What drives a testbench, and for how many clocks.
///
/// # Errors
/// When the reference model cannot predict the ports.
pub fn adversary(interface: &Interface) -> Result<(Adversarial, u64), ReferenceError> {
    let adversary = Adversarial::with_means(interface, SEED, MEANS)?;
    let clocks = match ends_with_its_aims(interface) {
        true => adversary.clone().clocks_to_cover(MOST_CLOCKS),
        false => MOST_CLOCKS,
    };
    Ok((adversary, clocks))
}

/// Whether a run is over where the adversary has reached all that it can. Frames of a histogram cannot be cut
/// short, so that hardly any recipe has its place: chance does the rest.
fn ends_with_its_aims(interface: &Interface) -> bool {
    interface.histogram().is_none()
}

/// Records a run that begins in reset.
///
/// # Errors
/// When the reference model cannot predict the ports.
pub fn record(sensor: &Sensor) -> Result<Recording, ReferenceError> {
    let interface = sensor.interface();
    let names: Vec<String> =
        sensor.scene().detectors.iter().map(|detector| detector.name.clone()).collect();
    let layout = Layout::of(interface);
    let outputs = layout.outputs.fields.iter().cloned();
    let (chips, results): (Vec<Field>, Vec<Field>) =
        outputs.partition(|field| field.port.role.usage() == Use::Code);
    let mut adversary = Adversarial::with_means(interface, SEED, MEANS)?;
    if ends_with_its_aims(interface) {
        adversary = adversary.ending_there();
    }
    let mut run = WrittenRun::new(adversary, MOST_CLOCKS);
    let mut inputs = PortGroup::new(&layout.inputs.fields, layout.inputs.words);
    let mut chips = PortGroup::new(&chips, layout.outputs.words);
    let mut results = PortGroup::new(&results, layout.outputs.words);
    chips.push_zeros(1);
    results.push_zeros(1);
    let (mut resets, mut phase_steps, mut scans) = (0, 0, 0);
    let reset = layout.inputs.field(PortRole::Reset);
    let mut in_reset = false;
    let mut skips = Vec::new();
    let mut block = Block::default();
    while run.make(&mut block) {
        inputs.push(&block.records.inputs);
        for words in block.records.inputs.chunks_exact(layout.inputs.words) {
            let was_in_reset = std::mem::replace(&mut in_reset, reset.low_word(words) == 1);
            resets += u64::from(in_reset && !was_in_reset);
        }
        chips.push(&block.records.expected);
        results.push(&block.records.expected);
        for result in run.take_finished() {
            phase_steps += 1;
            scans += u64::from(result.step + 1 == interface.timing.scan.steps);
        }
        skips.extend_from_slice(&block.skips);
    }
    let clocks = run.clocks_made();
    let table = run.reference().cover_table();
    let exercise = &block.exercise;
    if let Some(plan) = interface.histogram() {
        (phase_steps, scans) = (exercise.phase_steps, exercise.phase_steps / plan.bins());
    }
    let coverage = Coverage::new(interface, table, &exercise.covered, &names, Some(MEANS));
    Ok(Recording {
        inputs,
        chips,
        results,
        skips: Skips::of(interface, &skips, clocks),
        clocks,
        resets,
        phase_steps,
        scans,
        hits_up: exercise.detectors.iter().map(|d| d.hits_up).sum(),
        hits_down: exercise.detectors.iter().map(|d| d.hits_down).sum(),
        coverage,
    })
}

impl Skips {
    /// As words for each clock of a run; none if there are none.
    fn of(interface: &Interface, skips: &[Skip], clocks: u64) -> Option<Skips> {
        let first_clock = skips.first()?.clock;
        let mut registers = ScanRegisters::of(interface);
        let mut values = PortGroup::plain(registers.present().map(|register| VectorColumn {
            name: register.path("."),
            width: register.width(),
            is_payload: false,
        }));
        let mut clock = 0;
        for skip in skips {
            values.push_zeros(skip.clock - clock);
            let chips = registers.chips.as_mut();
            let groups = registers.groups.as_mut();
            let chips = chips.map(|register| register.difference(skip.chip, skip.chips));
            let groups = groups.map(|register| register.difference(skip.group.0, skip.groups));
            let moved: Vec<u64> = chips.into_iter().chain(groups).collect();
            values.push_values(&moved);
            clock = skip.clock + 1;
        }
        values.push_zeros(clocks - clock);
        Some(Skips { registers: registers.present().cloned().collect(), values, first_clock })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_packed_across_words() {
        let mut packed = [0; 3];
        put(&mut packed, 0, 0x1);
        put(&mut packed, 1, u64::MAX);
        put(&mut packed, 65, 0x3);
        put(&mut packed, 67, u64::MAX >> 3);
        assert_eq!(packed, [u64::MAX, u64::MAX, 0]);
        put(&mut packed, 128, 0x5);
        assert_eq!(packed[2], 0x5);
    }
}
