//! The registers by which a host sets the scan: one table of what there is, where, and what it does
//! (`map`), and the settings that they hold.
//!
//! Verilog, reference model, SystemRDL, C header, the host's accessors and the page of the manual follow
//! from it. Addresses are of bytes; a register has 32 bits.
//!
//! Three kinds of places: words in a memory (identification and settings, which the hardware takes over
//! at a scan's start), two registers of state, and the last peak.

mod map;

use std::sync::Arc;

use goldtof_system::digest::sha256_of_all;
pub use map::{Access, MappedRegister, RegisterField};

use super::track::{TrackPlan, TrackSetting};
use crate::code::{Code, Generator, Lfsr, is_maximal};
use crate::scan::Timing;
use crate::scene::SourceIndex;

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
/// Address of a setting, numbered from 0.
pub const fn setting_address(number: usize) -> u32 {
    4 * (IDENTITY_WORDS + number) as u32
}
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
    /// A window follows a target, and the last ones had its light.
    pub const LOCKED: u32 = 6;
    /// A target was lost.
    pub const LOCK_LOST: u32 = 7;
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
    /// What follows a target, if the hardware does.
    pub track: Option<TrackPlan>,
    /// Of the hardware, for a host that has its scene.
    pub identity: [u32; 2],
    /// Shape of the sensor, as the register SHAPE has it.
    pub shape: u32,
}

/// A seed that a host sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seed {
    /// The first source with the code.
    pub source: SourceIndex,
    /// Degree n of its polynomials.
    pub degree: u32,
    /// Bits of the setting: those of the seed, and above them as many of taps if a host sets these, too.
    pub bits: u32,
}

impl Seed {
    /// Whether a host sets the taps, too.
    pub fn has_taps(&self) -> bool {
        self.bits > self.degree
    }

    /// The setting that stands for a code's last LFSR; 0 of a code without.
    pub fn of(&self, code: &Code) -> u64 {
        let Some(lfsr) = code.generator.last_lfsr() else {
            return 0;
        };
        let taps = if self.has_taps() { lfsr.taps() } else { 0 };
        lfsr.seed.iter().rev().fold(taps, |state, &chip| state << 1 | u64::from(chip))
    }

    /// The code with this setting.
    pub fn code(&self, code: &Code, setting: u64) -> Code {
        let seed = setting & ((1 << self.degree) - 1);
        let taps = match self.has_taps() {
            true => setting >> self.degree,
            false => code.generator.last_lfsr().map_or(0, Lfsr::taps),
        };
        code.with_last_lfsr(seed, taps)
    }
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
    /// Of the second LFSR of each code that has one to be set: its first chips, the earliest in bit 0, and
    /// its taps ([`Seed`]).
    pub seeds: Vec<u64>,
    /// How a target is followed, if the hardware does that.
    pub track: Option<TrackSetting>,
}

/// The hardware that registers are to be for.
pub(super) struct RegisteredHardware<'a> {
    pub(super) timing: &'a Timing,
    pub(super) source_codes: &'a [Arc<Code>],
    pub(super) detectors: usize,
    /// Clocks from the first bits of a group's counts to the last.
    pub(super) clocks_of_counting: u32,
    /// Fewest chips of a group that a peak detector takes, if there is one.
    pub(super) least_chips_of_peak: Option<u64>,
    /// Whether a host sets taps with seeds.
    pub(super) sets_taps: bool,
    /// Longest counter that keeps the clock.
    pub(super) longest_counter: u32,
    /// What follows a target.
    pub(super) track: Option<TrackPlan>,
    /// All else that tells it from other hardware.
    pub(super) text: String,
}

impl RegisteredHardware<'_> {
    fn lanes(&self) -> u32 {
        self.timing.clock.samples_per_chip
    }

    /// Shape in a word: samples per chip in bits 7..0, detectors in 15..8, phase steps at once in 23..16, sources
    /// in 31..24.
    fn shape(&self) -> u32 {
        let byte = |value: usize, place: u32| (value as u32 & 0xff) << (8 * place);
        byte(self.lanes() as usize, 0)
            | byte(self.detectors, 1)
            | byte(self.timing.parallel as usize, 2)
            | byte(self.source_codes.len(), 3)
    }

    /// A number that is another for other hardware: of the clock, the codes and every width. Names of types and
    /// fields are part of it, in their Debug text.
    fn identity(&self) -> [u32; 2] {
        let Timing { clock, parallel, .. } = self.timing;
        let mut texts = vec![format!("{clock:?} {parallel} {}", self.text)];
        let codes = self.source_codes.iter();
        texts.extend(codes.map(|code| format!("{:?} {}", code.generator, code.interleave)));
        texts.extend(self.track.map(|track| format!("{track:?}")));
        let digest = sha256_of_all(texts);
        let word = |at: usize| u32::from_str_radix(&digest[at..at + 8], 16).unwrap_or(0);
        [word(0), word(8)]
    }

    /// Fewest chips of a step that all parts have time in, as a power of two.
    fn least_chips(&self) -> u64 {
        // The end of a step is looked for four chips ahead.
        const SHORTEST: u64 = 16;
        let counting = 8 + u64::from(self.clocks_of_counting);
        let going_back = 8 + 2 * u64::from(self.timing.parallel.div_ceil(self.lanes()));
        let peak = self.least_chips_of_peak.unwrap_or(0);
        SHORTEST.max(counting).max(going_back).max(peak).next_power_of_two()
    }
}

/// Bits of a number.
fn bits(number: u64) -> u32 {
    (u64::BITS - number.leading_zeros()).max(1)
}

/// Whether two codes have one generator.
pub fn is_same(one: &Arc<Code>, other: &Arc<Code>) -> bool {
    Arc::ptr_eq(one, other)
        || (one.interleave == other.interleave && one.generator == other.generator)
}

/// The codes of which a host sets something, each once: Gold codes, whose seed chooses among those of a set, and where
/// taps are set m-sequences, too.
fn seeds(codes: &[Arc<Code>], sets_taps: bool) -> Vec<Seed> {
    let sources = SourceIndex::of(codes);
    let is_set = |generator: &Generator| sets_taps || matches!(generator, Generator::Gold { .. });
    sources
        .filter(|&source| !codes[..source.0].iter().any(|code| is_same(code, &codes[source])))
        .filter_map(|source| {
            let generator = &codes[source].generator;
            let Lfsr { degree, .. } = generator.last_lfsr().filter(|_| is_set(generator))?;
            Some(Seed { source, degree: *degree, bits: *degree << u32::from(sets_taps) })
        })
        .collect()
}

impl RegisterPlan {
    /// Of hardware.
    pub(super) fn of(hardware: &RegisteredHardware) -> RegisterPlan {
        let timing = hardware.timing;
        let (scan, lanes) = (&timing.scan, u64::from(hardware.lanes()));
        let parallel = u64::from(timing.parallel);
        let is_whole = scan.steps_per_period.is_multiple_of(parallel);
        RegisterPlan {
            chips_bits: bits(scan.integration_chips),
            groups_bits: bits(timing.of_any_scan().groups()).min(hardware.longest_counter),
            delay_bits: bits(timing.code_chips() - 1),
            sample_bits: lanes.trailing_zeros(),
            fixed_samples: parallel
                .is_multiple_of(lanes)
                .then_some((scan.first_step % lanes) as u32),
            least_chips: hardware.least_chips(),
            period_chips: timing.code_chips(),
            seeds: seeds(hardware.source_codes, hardware.sets_taps),
            whole_groups: is_whole.then_some(scan.steps_per_period / parallel),
            peaks: hardware.least_chips_of_peak.map_or(0, |_| hardware.detectors as u32),
            track: hardware.track,
            identity: hardware.identity(),
            shape: hardware.shape(),
        }
    }

    /// Words of settings that the hardware takes over.
    pub fn settings(&self) -> usize {
        SCAN_WORDS + self.seeds.len() + usize::from(self.track.is_some())
    }

    /// Which setting says how a target is followed: the last.
    pub fn track_setting(&self) -> Option<usize> {
        self.track.map(|_| SCAN_WORDS + self.seeds.len())
    }

    /// Address of where the window is, if there is one: behind the peaks.
    pub fn position_address(&self) -> u32 {
        PEAKS + 8 * self.peaks
    }

    /// Words that are read behind the state: step and count of each peak, and where the window is.
    pub fn readings(&self) -> u32 {
        2 * self.peaks + u32::from(self.track.is_some())
    }

    /// Lanes whose chip depends on a delay that a host sets.
    pub fn lanes(&self) -> u32 {
        if self.fixed_samples.is_some() { 0 } else { (1 << self.sample_bits) - 1 }
    }

    /// Which seed a code takes, in a sensor whose sources have these codes.
    pub fn seed_number(&self, code: &Arc<Code>, source_codes: &[Arc<Code>]) -> Option<usize> {
        self.seeds.iter().position(|seed| is_same(code, &source_codes[seed.source]))
    }

    /// Whether a host sets taps, too.
    pub fn sets_taps(&self) -> bool {
        self.seeds.iter().any(Seed::has_taps)
    }

    /// Bits of all seeds.
    pub fn seed_bits(&self) -> u32 {
        self.first_seed_bit(self.seeds.len())
    }

    /// Bits of the seeds before one, where they lie side by side.
    pub fn first_seed_bit(&self, seed: usize) -> u32 {
        self.seeds[..seed].iter().map(|seed| seed.bits).sum()
    }

    /// Bits of the widest setting that a scan takes over.
    pub fn scan_setting_bits(&self) -> u32 {
        let seeds = self.seeds.iter().map(|seed| seed.bits).max().unwrap_or(0);
        let scan = self.chips_bits.max(self.groups_bits).max(self.delay_bits + self.sample_bits);
        scan.max(seeds)
    }

    /// Bits of the widest setting.
    pub fn setting_bits(&self) -> u32 {
        self.scan_setting_bits().max(self.track.map_or(0, |_| TrackSetting::BITS))
    }

    /// Words in the memory.
    pub fn words(&self) -> usize {
        IDENTITY_WORDS + self.settings()
    }

    /// Bits of the address of a word: the memory has at least 16.
    pub fn word_bits(&self) -> u32 {
        bits(self.words() as u64 - 1).max(4)
    }

    /// Clocks that the settings' take-over takes: one for each word, and one each until the last is there, until it
    /// is seen whether they fit, and to act.
    pub fn take_over_clocks(&self) -> u64 {
        self.settings() as u64 + 3
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
            seeds: self.seeds.iter().map(|seed| seed.of(&codes[seed.source])).collect(),
            track: self.track.map(|track| track.setting),
        }
    }

    /// What the memory holds at power-up, in a sensor with this scan and these codes.
    pub fn initial_words(&self, timing: &Timing, codes: &[Arc<Code>]) -> Vec<u32> {
        let settings = self.settings_of(timing, codes);
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
            track: self.track_setting().map(|number| TrackSetting::of_word(words[number])),
        }
    }

    /// Whether the hardware takes these settings.
    pub fn fits(&self, settings: &Settings) -> bool {
        settings.chips >= self.least_chips
            && settings.groups > 0
            && settings.first_step >> self.sample_bits < self.period_chips
    }

    /// Why a host should not write a word, though the hardware takes it: it makes no code like those of the scene.
    /// `source_codes` are the sources' codes.
    pub fn doubt(&self, source_codes: &[Arc<Code>], address: u32, word: u32) -> Option<String> {
        let number = (address as usize / 4).checked_sub(IDENTITY_WORDS + SCAN_WORDS)?;
        let seed = self.seeds.get(number).filter(|seed| seed.has_taps())?;
        let degree = seed.degree;
        let setting = u64::from(word);
        let (chips, taps) = (setting & ((1 << degree) - 1), setting >> degree);
        let is_alone = matches!(source_codes[seed.source].generator, Generator::MSequence(_));
        let why = if taps >> degree != 0 {
            format!("is more than a polynomial of degree {degree} has: {degree} bits")
        } else if taps & 1 == 0 {
            format!("is not of degree {degree}: its lowest bit has to be set")
        } else if !is_maximal(degree, taps) {
            format!(
                "is not a primitive polynomial of degree {degree}: its sequence repeats within the code's {} chips, and so \
                 does what it correlates with",
                (1 << degree) - 1
            )
        } else if is_alone && chips == 0 {
            return Some(format!(
                "CHIPS of SEED_{number} would be 0, from which no LFSR makes a code; at least one bit has to be set"
            ));
        } else {
            return None;
        };
        Some(format!("TAPS of SEED_{number} would be {taps:#x}, which {why}"))
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
        let scan = scan.into_iter().chain(self.seeds.iter().copied()).map(|word| word as u32);
        scan.chain(self.track.map(TrackSetting::word)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{self, Registers, Scene};
    use crate::sensor::Sensor;

    fn sensor(change: impl FnOnce(&mut Scene)) -> Sensor {
        let scene = scene::load(std::path::Path::new("../scenes/quick.toml")).unwrap();
        Sensor::new(&scene).with(|scene| {
            scene.hardware.registers = Registers::Axi4Lite;
            change(scene);
        })
    }

    #[test]
    fn fields_do_not_overlap_and_addresses_are_those_of_words() {
        let sensor = sensor(|scene| scene.hardware.peak_detector = true);
        let plan = sensor.interface().registers.clone().unwrap();
        let interface = sensor.interface();
        let map = plan.map(&interface.timing, &interface.source_codes);
        assert_eq!(map.len(), plan.words() + 2 + 2);
        for pair in map.windows(2) {
            assert!(pair[0].address < pair[1].address, "{} {}", pair[0].name, pair[1].name);
        }
        for register in &map {
            assert!(register.address % 4 == 0 && register.address >> ADDRESS_BITS == 0);
            let mut end = 0;
            for field in &register.fields {
                assert!(field.first_bit >= end, "{} {}", register.name, field.name);
                end = field.first_bit + field.width;
                assert!(field.reset.is_none_or(|value| u64::from(value) >> field.width == 0));
            }
            assert!(end <= 32, "{}", register.name);
        }
    }

    /// A host that has a scene knows its hardware by this number, which follows from the Debug text of
    /// types: a type or field that is renamed must not change it.
    #[test]
    fn hardware_keeps_its_number() {
        for (name, identity) in [
            ("tests/scenes/registers", [0xa062_c12d, 0xefb7_4935]),
            ("tests/scenes/taps", [0xcad3_5d71, 0xe11e_6d45]),
            ("tests/scenes/tracking", [0x362c_28a2, 0x3054_ef6e]),
            ("scenes/macropixel", [0xdef6_20b7, 0x3bcd_ba04]),
        ] {
            let file = format!("../{name}.toml");
            let scene = scene::load(std::path::Path::new(&file)).unwrap();
            let sensor =
                Sensor::new(&scene).with(|scene| scene.hardware.registers = Registers::Axi4Lite);
            let plan = sensor.interface().registers.clone().unwrap();
            assert_eq!(plan.identity, identity, "{name}");
        }
    }

    #[test]
    fn settings_of_a_scene_come_back_from_their_words_and_fit() {
        let sensor = sensor(|_| ());
        let interface = sensor.interface();
        let plan = interface.registers.clone().unwrap();
        let settings = plan.settings_of(&interface.timing, &interface.source_codes);
        assert_eq!(plan.settings_in(&settings.words()), settings);
        assert!(plan.fits(&settings) && plan.is_gapless(&settings));
        assert_eq!(interface.with_settings(&plan, &settings).source_codes, interface.source_codes);
        // 31 chips of 8 samples; 2,500 chips need 12 bits.
        let last = Settings { first_step: 247, chips: 4095, groups: 255, ..settings.clone() };
        assert_eq!(plan.settings_in(&last.words()), last);
        assert!(plan.fits(&last) && !plan.is_gapless(&last));
        for bad in [
            Settings { chips: 15, ..settings.clone() },
            Settings { groups: 0, ..settings.clone() },
            Settings { first_step: 248, ..settings.clone() },
        ] {
            assert!(!plan.fits(&bad), "{bad:?}");
        }
    }

    /// A Gold code's index moves its second LFSR on, and so does the seed.
    #[test]
    fn another_seed_is_another_code_of_the_set() {
        let code = |index: &str| {
            let text = std::fs::read_to_string("../scenes/quick.toml").unwrap();
            let text = text.replace("degree = 5 }", &format!("degree = 5, index = {index} }}"));
            let scene = scene::parse("quick.toml", &text).unwrap();
            scene.sources[0].code.clone()
        };
        let (first, third) = (code("0"), code("3"));
        assert_ne!(first, third);
        let seed = Seed { source: SourceIndex(0), degree: 5, bits: 5 };
        assert_eq!(seed.code(&first, seed.of(&third)), *third);
        // Without its second LFSR it is the first one's m-sequence, of 16 ones in 31 chips.
        assert_eq!(seed.code(&first, 0).weight(), 16);
    }

    /// A host may make two sources' codes one, and both others at once.
    #[test]
    fn codes_that_become_one_another_are_told_apart() {
        let scene = scene::load(std::path::Path::new("../tests/scenes/registers.toml")).unwrap();
        let sensor = Sensor::new(&scene);
        let interface = sensor.interface();
        let plan = interface.registers.as_ref().unwrap();
        let mut settings = plan.settings_of(&interface.timing, &interface.source_codes);
        assert_eq!(settings.seeds.len(), 2);
        settings.seeds.swap(0, 1);
        let swapped = interface.with_settings(plan, &settings).source_codes;
        assert_eq!(swapped[0], interface.source_codes[1]);
        assert_eq!(swapped[1], interface.source_codes[0]);
    }

    /// Without a second LFSR the seed moves the code, and an m-sequence of other taps is another one.
    #[test]
    fn the_taps_of_an_m_sequence_are_its_own() {
        let sensor =
            Sensor::new(&scene::load(std::path::Path::new("../tests/scenes/taps.toml")).unwrap());
        let interface = sensor.interface();
        let plan = interface.registers.as_ref().unwrap();
        let (at, code) = (plan.seeds.len() - 1, &interface.source_codes[1]);
        let Generator::MSequence(lfsr) = &code.generator else { panic!("{code:?}") };
        let (seed, own) = (plan.seeds[at], plan.seeds[at].of(code));
        assert_eq!(seed.code(code, own), **code);
        // x^5 + x^3 + 1 and its reciprocal x^5 + x^2 + 1 run backwards of one another.
        let other = if lfsr.exponents == [5, 2, 0] { 0b00101 } else { 0b01001 };
        let other = seed.code(code, other << 5 | 1).generator.chips();
        let backwards: Vec<u8> = lfsr.chips(31).into_iter().rev().collect();
        assert!((0..31).any(|shift| (0..31).all(|t| other[(t + shift) % 31] == backwards[t])));
        let address = 4 * (IDENTITY_WORDS + SCAN_WORDS + at) as u32;
        assert_eq!(interface.doubt(address, own as u32), None);
        let doubt = interface.doubt(address, (own & !31) as u32).unwrap();
        assert!(doubt.starts_with("CHIPS of SEED_1 would be 0"), "{doubt}");
    }

    /// Another preferred pair with the same first LFSR is other taps: three values of the cross-correlation,
    /// -1, -9 and 7 in 31 chips, are what a Gold set has (Gold 1967).
    #[test]
    fn other_taps_are_the_codes_of_another_pair() {
        let sensor = sensor(|scene| scene.hardware.code_taps = true);
        let interface = sensor.interface();
        let plan = interface.registers.clone().unwrap();
        let code = &interface.source_codes[0];
        let Generator::Gold { u, v } = &code.generator else { panic!("{code:?}") };
        assert_eq!(plan.seeds[0].bits, 10);
        let (mut pairs, own) = (Vec::new(), plan.seeds[0].of(code));
        assert_eq!(plan.seeds[0].code(code, own), **code);
        for taps in (0..32).filter(|&taps| is_maximal(5, taps) && taps != u.taps()) {
            let single = plan.seeds[0].code(code, taps << 5 | 1);
            let second: Vec<i64> =
                single.chips.iter().zip(u.chips(31)).map(|(c, u)| i64::from(c ^ u)).collect();
            let chi = |chip: i64| 2 * chip - 1;
            let values: Vec<i64> = (0..31)
                .map(|lag| {
                    (0..31).map(|t| chi(u.chips(31)[t].into()) * chi(second[(t + lag) % 31])).sum()
                })
                .collect();
            if values.iter().all(|value| [-1, -9, 7].contains(value)) {
                pairs.push(taps);
            }
        }
        // Address 0x024: IDENTITY, three settings, and the seed.
        assert_eq!(interface.doubt(0x24, own as u32), None);
        assert_eq!(interface.doubt(0x20, 0), None);
        for (taps, why) in [
            (0x1f, "not a primitive polynomial of degree 5"),
            (0x02, "not of degree 5"),
            (0x25, "more than a polynomial of degree 5 has: 5 bits"),
        ] {
            let doubt = interface.doubt(0x24, taps << 5 | 1).unwrap();
            assert!(doubt.starts_with(&format!("TAPS of SEED_0 would be {taps:#x}, ")), "{doubt}");
            assert!(doubt.contains(why), "{doubt}");
        }
        // Of the six m-sequences of 31 chips four make a preferred pair with any one.
        assert_eq!(pairs.len(), 4);
        assert!(pairs.contains(&v.taps()));
    }
}
