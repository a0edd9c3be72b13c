//! The registers by which a host sets the scan: one table of what there is, where, and what it does.
//!
//! Verilog, reference model, SystemRDL, C header, the host's accessors and the page of the manual follow
//! from it. Addresses are of bytes; a register has 32 bits.
//!
//! Three kinds of places: words in a memory (identification and settings, which the hardware takes over
//! at a scan's start), two registers of state, and the last peak.

use std::sync::Arc;

use goldtof_system::digest::sha256_of_all;

use super::interface::Interface;
use crate::code::{Code, Generator};
use crate::scan::Timing;
use crate::scene::{Scene, SourceIndex, Target};

/// Bits of an address.
pub const ADDRESS_BITS: u32 = 12;
/// "gold", by which a host knows the register map.
pub const MAGIC: u32 = 0x676f_6c64;
/// Of the register map.
pub const VERSION: u32 = 1;
/// Address of the register that starts and stops.
pub const CONTROL: u32 = 0x400;
/// Address of the register with flags and counters.
pub const STATUS: u32 = 0x404;
/// Address of the first detector's last peak: its step, and four bytes on its count. Others follow.
pub const PEAKS: u32 = 0x500;
/// Words of identification before the settings.
pub const IDENTITY_WORDS: usize = 6;
/// Settings before the seeds: chips, groups, first step.
pub const SCAN_WORDS: usize = 3;
/// Clocks by which the transmit generators run ahead of the lasers, so that their chip can be
/// compared with the reference's delay in time.
pub const CHIPS_AHEAD: u64 = 3;
/// Bits of the counter of lost groups.
pub const LOST_BITS: u32 = 8;
/// Bits of the counter of scans.
pub const SCANS_BITS: u32 = 16;

/// Bits of the state that CONTROL and STATUS read as.
pub mod state {
    /// Scans follow one another.
    pub const RUN: u32 = 0;
    /// One scan is asked for.
    pub const SINGLE: u32 = 1;
    /// A scan is under way, or prepared.
    pub const BUSY: u32 = 2;
    /// A result was lost.
    pub const OVERRUN: u32 = 3;
    /// A count was clamped.
    pub const SATURATED: u32 = 4;
    /// Settings were refused.
    pub const REFUSED: u32 = 5;
    /// Groups that were lost.
    pub const LOST: u32 = 8;
    /// Scans that have ended.
    pub const SCANS: u32 = 16;
}

/// What the registers of a sensor are like.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RegisterPlan {
    /// Bits of the chips of a phase step: any number of them is counted without overflow.
    pub chips_bits: u32,
    /// Bits of the number of groups of phase steps.
    pub groups_bits: u32,
    /// Bits of the whole chips of the first step's delay.
    pub delay_bits: u32,
    /// Bits of the samples of that delay within a chip, log2 S.
    pub sample_bits: u32,
    /// Samples of the delay within a chip where a host cannot set them: steps at once that are whole
    /// chips never change them.
    pub fixed_samples: Option<u32>,
    /// Fewest chips of a phase step: a power of two.
    pub least_chips: u64,
    /// Chips of the references' code, L'.
    pub period_chips: u64,
    /// Codes with a seed that a host sets: the first source of each, and its bits.
    pub seeds: Vec<Seed>,
    /// Groups of a scan over the whole code period, if it has whole ones. Such scans follow one another
    /// without a gap.
    pub whole_groups: Option<u64>,
    /// Detectors with a peak.
    pub peaks: u32,
    /// Of the hardware, for a host that has its scene.
    pub identity: [u32; 2],
    /// Shape of the sensor as a host needs it; see [`shape`].
    pub shape: u32,
}

/// A seed that a host sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seed {
    /// The first source with the code.
    pub source: SourceIndex,
    /// Degree n of its polynomials.
    pub bits: u32,
}

/// What a host sets, in the registers' own numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Settings {
    /// Chips of a phase step.
    pub chips: u64,
    /// Groups of steps in a scan.
    pub groups: u64,
    /// Its first phase step.
    pub first_step: u64,
    /// Of the second LFSR of each code that has one to be set: its first chips, the earliest in bit 0.
    pub seeds: Vec<u64>,
}

/// Shape of a sensor in a word: samples per chip in bits 7..0, detectors in 15..8, phase steps at once in 23..16, sources
/// in 31..24.
fn shape(interface: &Interface) -> u32 {
    let byte = |value: usize, place: u32| (value as u32 & 0xff) << (8 * place);
    byte(interface.lanes() as usize, 0)
        | byte(interface.reference_codes.len(), 1)
        | byte(interface.parallel() as usize, 2)
        | byte(interface.source_codes.len(), 3)
}

/// Bits of a number.
fn bits(number: u64) -> u32 {
    (u64::BITS - number.leading_zeros()).max(1)
}

/// Whether two sources have one generator.
fn is_same(one: &Arc<Code>, other: &Arc<Code>) -> bool {
    Arc::ptr_eq(one, other)
        || (one.interleave == other.interleave && one.generator == other.generator)
}

/// The codes whose seed a host sets: Gold codes, each once.
fn seeds(codes: &[Arc<Code>]) -> Vec<Seed> {
    let sources = SourceIndex::of(codes);
    sources
        .filter(|&source| !codes[..source.0].iter().any(|code| is_same(code, &codes[source])))
        .filter_map(|source| match &codes[source].generator {
            Generator::Gold { v, .. } => Some(Seed { source, bits: v.degree }),
            _ => None,
        })
        .collect()
}

/// A number that is another for other hardware: of the clock, the codes and every width.
fn identity(interface: &Interface) -> [u32; 2] {
    let Interface { polarity, timing, source_codes, reference_codes, counting, .. } = interface;
    let codes = source_codes.iter().chain(reference_codes);
    let mut texts =
        vec![format!("{polarity:?} {:?} {} {counting:?}", timing.clock, timing.parallel)];
    texts.extend(codes.map(|code| format!("{:?} {}", code.generator, code.interleave)));
    let digest = sha256_of_all(texts);
    let word = |at: usize| u32::from_str_radix(&digest[at..at + 8], 16).unwrap_or(0);
    [word(0), word(8)]
}

impl RegisterPlan {
    /// Of the hardware of a scene, whose interface is known but for this.
    pub(super) fn of(scene: &Scene, interface: &Interface) -> RegisterPlan {
        let timing = &interface.timing;
        let lanes = u64::from(interface.lanes());
        let parallel = u64::from(interface.parallel());
        let most_groups = timing.of_any_scan().groups();
        let grows = !parallel.is_multiple_of(lanes);
        RegisterPlan {
            chips_bits: bits(timing.scan.integration_chips),
            groups_bits: bits(most_groups).min(longest_counter(scene.hardware.target)),
            delay_bits: bits(timing.code_chips() - 1),
            sample_bits: lanes.trailing_zeros(),
            fixed_samples: (!grows).then_some((timing.scan.first_step % lanes) as u32),
            least_chips: least_chips(interface),
            period_chips: timing.code_chips(),
            seeds: seeds(&interface.source_codes),
            whole_groups: timing
                .scan
                .steps_per_period
                .is_multiple_of(parallel)
                .then_some(timing.scan.steps_per_period / parallel),
            peaks: interface.peak().map_or(0, |_| interface.reference_codes.len() as u32),
            identity: identity(interface),
            shape: shape(interface),
        }
    }

    /// Words of settings that the hardware takes over.
    pub fn settings(&self) -> usize {
        SCAN_WORDS + self.seeds.len()
    }

    /// Lanes whose chip depends on a delay that a host sets.
    pub fn lanes(&self) -> u32 {
        if self.fixed_samples.is_some() { 0 } else { (1 << self.sample_bits) - 1 }
    }

    /// Bits of the widest setting.
    pub fn setting_bits(&self) -> u32 {
        let seeds = self.seeds.iter().map(|seed| seed.bits).max().unwrap_or(0);
        self.chips_bits.max(self.groups_bits).max(self.delay_bits + self.sample_bits).max(seeds)
    }

    /// Words in the memory.
    pub fn words(&self) -> usize {
        IDENTITY_WORDS + self.settings()
    }

    /// Bits of the address of a word: the memory has at least 16.
    pub fn word_bits(&self) -> u32 {
        bits(self.words() as u64 - 1).max(4)
    }

    /// Clocks that the settings' take-over takes: one for each word, one to see whether they fit, one to act.
    pub fn take_over_clocks(&self) -> u64 {
        self.settings() as u64 + 2
    }

    /// Clocks from the one at which scans are asked for, while none is under way, to the one after whose
    /// rising edge the lasers show their codes' first chips.
    pub fn start_clocks(&self) -> u64 {
        1 + self.take_over_clocks() + CHIPS_AHEAD
    }

    /// Settings as a scene has them.
    pub fn settings_of(&self, timing: &Timing, codes: &[Arc<Code>]) -> Settings {
        Settings {
            chips: timing.scan.integration_chips,
            groups: timing.groups(),
            first_step: timing.scan.first_step,
            seeds: self.seeds.iter().map(|seed| seed_of(&codes[seed.source])).collect(),
        }
    }

    /// What the memory holds at power-up, in a sensor of this interface.
    pub fn initial_words(&self, interface: &Interface) -> Vec<u32> {
        let settings = self.settings_of(&interface.timing, &interface.source_codes);
        let identity = [
            MAGIC,
            VERSION,
            self.identity[0],
            self.identity[1],
            self.shape,
            self.period_chips as u32,
        ];
        identity.into_iter().chain(settings.words()).collect()
    }

    /// Settings in the words of the memory, from the first setting on; bits that the hardware does not keep are
    /// left out.
    pub fn settings_in(&self, words: &[u32]) -> Settings {
        let masked = |word: u32, bits: u32| u64::from(word) & ((1 << bits) - 1);
        let delay = masked(words[2] >> self.sample_bits, self.delay_bits);
        let samples = match self.fixed_samples {
            Some(samples) => u64::from(samples),
            None => masked(words[2], self.sample_bits),
        };
        let seeds = self.seeds.iter().zip(&words[SCAN_WORDS..]);
        Settings {
            chips: masked(words[0], self.chips_bits),
            groups: masked(words[1], self.groups_bits),
            first_step: (delay << self.sample_bits) + samples,
            seeds: seeds.map(|(seed, &word)| masked(word, seed.bits)).collect(),
        }
    }

    /// Whether the hardware takes these settings.
    pub fn fits(&self, settings: &Settings) -> bool {
        settings.chips >= self.least_chips
            && settings.groups > 0
            && settings.first_step >> self.sample_bits < self.period_chips
    }

    /// Whether scans of these settings follow one another without a gap.
    pub fn is_gapless(&self, settings: &Settings) -> bool {
        self.whole_groups == Some(settings.groups)
    }
}

impl Settings {
    /// As the memory holds them.
    pub fn words(&self) -> Vec<u32> {
        let scan = [self.chips, self.groups, self.first_step];
        scan.into_iter().chain(self.seeds.iter().copied()).map(|word| word as u32).collect()
    }
}

/// The first chips of a Gold code's second LFSR, the earliest in bit 0; 0 of any other code.
pub fn seed_of(code: &Code) -> u64 {
    match &code.generator {
        Generator::Gold { v, .. } => {
            v.seed.iter().rev().fold(0, |state, &chip| state << 1 | u64::from(chip))
        }
        _ => 0,
    }
}

/// Fewest chips of a step that all parts of the hardware have time in, as a power of two.
fn least_chips(interface: &Interface) -> u64 {
    // The end of a step is looked for four chips ahead.
    const SHORTEST: u64 = 16;
    let counting = interface.correlator().map_or(0, |of| u64::from(of.clocks_of_counting()));
    let going_back = 2 * u64::from(interface.parallel().div_ceil(interface.lanes()));
    let peak = interface.peak().map_or(0, |peak| peak.least_chips);
    SHORTEST.max(8 + counting).max(8 + going_back).max(peak).next_power_of_two()
}

/// Longest counter that keeps a target's clock in one carry chain.
pub fn longest_counter(target: Target) -> u32 {
    super::interface::longest_carry_chain(target)
}

impl Interface {
    /// The same hardware with these settings, which fit.
    pub fn with_settings(&self, plan: &RegisterPlan, settings: &Settings) -> Interface {
        let mut interface = self.clone();
        let scan = &mut interface.timing.scan;
        scan.integration_chips = settings.chips;
        scan.steps = settings.groups * u64::from(self.parallel());
        scan.first_step = settings.first_step;
        for (seed, &value) in plan.seeds.iter().zip(&settings.seeds) {
            let before = self.source_codes[seed.source].clone();
            if seed_of(&before) == value {
                continue;
            }
            let after = Arc::new(before.with_second_seed(value));
            let codes = interface.source_codes.iter_mut().chain(&mut interface.reference_codes);
            for code in codes.filter(|code| is_same(code, &before)) {
                *code = after.clone();
            }
        }
        interface
    }
}
