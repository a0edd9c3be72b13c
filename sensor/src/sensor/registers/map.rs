//! The table of registers as a host sees it: addresses, fields, access, values before a host writes.

use std::sync::Arc;

use serde::Serialize;

use super::{CONTROL, LOST_BITS, PEAKS, RegisterPlan, SCANS_BITS, STATUS, state};
use crate::code::{Code, Generator};
use crate::scan::Timing;
use crate::sensor::track::{FRACTION_BITS, PATIENCE_BITS, SHARE_BITS};

/// A register, as a host sees it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Register")]
pub struct MappedRegister {
    /// Its name.
    pub name: String,
    /// Address of its lowest byte.
    pub address: u32,
    /// What it is.
    pub about: String,
    /// From bit 0 up; bits between them read as 0.
    pub fields: Vec<RegisterField>,
}

/// Bits of a register with one meaning.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct RegisterField {
    /// Its name.
    pub name: String,
    /// Its lowest bit.
    pub first_bit: u32,
    /// How many it has.
    #[serde(rename = "width_bits")]
    pub width: u32,
    /// What a host may do with it.
    pub access: Access,
    /// What it holds before a host writes to it; none where that changes by itself.
    pub reset: Option<u32>,
    /// What it means.
    pub about: String,
}

/// What a host may do with a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Access {
    /// Read it.
    Read,
    /// Read and write it.
    ReadWrite,
    /// Read it, and clear it by writing 1.
    WriteOneToClear,
}

impl RegisterPlan {
    /// All registers, in the order of their addresses.
    pub fn map(&self, timing: &Timing, codes: &[Arc<Code>]) -> Vec<MappedRegister> {
        let words = self.initial_words(timing, codes);
        let mut map = Vec::new();
        let mut word = |name: &str, about: &str, access: Access, fields: &[(&str, u32, &str)]| {
            let (number, mut first_bit, mut all) = (map.len(), 0, Vec::new());
            for &(name, width, about) in fields {
                let value = words[number] >> first_bit & (u32::MAX >> (32 - width));
                all.push(RegisterField {
                    name: name.to_owned(),
                    first_bit,
                    width,
                    access,
                    reset: Some(value),
                    about: about.to_owned(),
                });
                first_bit += width;
            }
            let address = 4 * number as u32;
            map.push(MappedRegister {
                name: name.to_owned(),
                address,
                about: about.to_owned(),
                fields: all,
            });
        };
        word("MAGIC", "\"gold\" in ASCII", Access::Read, &[("VALUE", 32, "0x676f6c64")]);
        word("VERSION", "of this register map", Access::Read, &[("VALUE", 32, "version")]);
        let identity = "number of this hardware: of clock, codes and widths";
        word("IDENTITY_LOW", identity, Access::Read, &[("VALUE", 32, "lower half")]);
        word("IDENTITY_HIGH", identity, Access::Read, &[("VALUE", 32, "upper half")]);
        word(
            "SHAPE",
            "what the sensor has",
            Access::Read,
            &[
                ("SAMPLES", 8, "samples per chip, S"),
                ("DETECTORS", 8, "detectors"),
                ("PARALLEL", 8, "phase steps at once"),
                ("SOURCES", 8, "lasers"),
            ],
        );
        word("PERIOD", "of the references' code", Access::Read, &[("CHIPS", 32, "chips")]);
        let least = format!("integration time of a phase step, at least {}", self.least_chips);
        word("CHIPS", "setting", Access::ReadWrite, &[("CHIPS", self.chips_bits, &least)]);
        let groups = "groups of phase steps in a scan, at least 1";
        word("GROUPS", "setting", Access::ReadWrite, &[("GROUPS", self.groups_bits, groups)]);
        let first = format!(
            "first phase step of a scan, less than {}{}",
            self.period_chips << self.sample_bits,
            match self.fixed_samples {
                Some(samples) =>
                    format!("; whole chips count, and {samples} samples are always added"),
                None => String::new(),
            }
        );
        let step_bits = self.delay_bits + self.sample_bits;
        word("FIRST", "setting", Access::ReadWrite, &[("STEP", step_bits, &first)]);
        for (number, seed) in self.seeds.iter().enumerate() {
            let about = format!(
                "first chips of the {}LFSR of source {}'s code, the earliest in bit 0",
                match &codes[seed.source].generator {
                    Generator::Gold { .. } => "second ",
                    _ => "",
                },
                seed.source.0
            );
            let taps = format!(
                "of these {0} chips those whose XOR is the next one, the earliest in the lowest bit, which has to be set",
                seed.degree
            );
            let fields = [("CHIPS", seed.degree, &*about), ("TAPS", seed.degree, &*taps)];
            let name = format!("SEED_{number}");
            word(&name, "setting", Access::ReadWrite, &fields[..1 + usize::from(seed.has_taps())]);
        }
        if self.track.is_some() {
            let gain = "halvings of the window's way to the peak: gain 1, 1/2, 1/4, ...";
            let threshold = "halvings of the followed light below which a window has lost it";
            let patience =
                "windows without it, one after another, until a scan looks for the target";
            word(
                "TRACK",
                "setting",
                Access::ReadWrite,
                &[
                    ("ENABLE", 1, "a window follows the peak that a scan has found"),
                    ("GAIN", SHARE_BITS, gain),
                    ("THRESHOLD", SHARE_BITS, threshold),
                    ("PATIENCE", PATIENCE_BITS, patience),
                ],
            );
        }
        map.extend(self.state_map());
        map
    }

    /// Control, status and peaks.
    fn state_map(&self) -> Vec<MappedRegister> {
        let field = |name: &str, first_bit, width, access, reset, about: &str| RegisterField {
            name: name.to_owned(),
            first_bit,
            width,
            access,
            reset,
            about: about.to_owned(),
        };
        let (read, clear) = (Access::Read, Access::WriteOneToClear);
        let run = "scans follow one another; 0 ends them after the present one";
        let single = "one scan; 0 again when it begins";
        let control = [
            field("RUN", state::RUN, 1, Access::ReadWrite, Some(1), run),
            field("SINGLE", state::SINGLE, 1, Access::ReadWrite, Some(0), single),
            field("STATE", 2, 30, read, None, "as STATUS has it"),
        ];
        let mut status = vec![
            field("CONTROL", 0, 2, read, None, "as CONTROL has it"),
            field("BUSY", state::BUSY, 1, read, None, "a scan is under way, or prepared"),
            field("OVERRUN", state::OVERRUN, 1, clear, Some(0), "a result was lost"),
            field("SATURATED", state::SATURATED, 1, clear, Some(0), "a count was clamped"),
            field(
                "REFUSED",
                state::REFUSED,
                1,
                clear,
                Some(0),
                "settings did not fit, and scans were stopped",
            ),
            field(
                "LOST",
                state::LOST,
                LOST_BITS,
                read,
                None,
                "groups of results lost since reset, modulo 256",
            ),
            field(
                "SCANS",
                state::SCANS,
                SCANS_BITS,
                read,
                None,
                "scans ended since reset, modulo 65536",
            ),
        ];
        if self.track.is_some() {
            let locked = "a window follows the target, and has its light";
            let lost = "a target was lost, and is looked for";
            let flags = [
                field("LOCKED", state::LOCKED, 1, read, None, locked),
                field("LOCK_LOST", state::LOCK_LOST, 1, clear, Some(0), lost),
            ];
            let place = status.partition_point(|field| field.first_bit < state::LOCKED);
            status.splice(place..place, flags);
        }
        let register = |name: String, address, about: &str, fields: Vec<RegisterField>| {
            MappedRegister { name, address, about: about.to_owned(), fields }
        };
        let mut map = vec![
            register("CONTROL".to_owned(), CONTROL, "starts and stops", control.into()),
            register("STATUS".to_owned(), STATUS, "flags and counters", status),
        ];
        for detector in 0..self.peaks {
            let address = PEAKS + 8 * detector;
            let step = field("STEP", 0, 32, read, None, "phase step, from the scan's first on");
            let count = field("COUNT", 0, 32, read, None, "count, signed");
            let about = format!("last peak of detector {detector}");
            map.push(register(format!("PEAK_STEP_{detector}"), address, &about, vec![step]));
            map.push(register(format!("PEAK_COUNT_{detector}"), address + 4, &about, vec![count]));
        }
        if let Some(track) = &self.track {
            let about = "where the target's peak is, after the last window".to_owned();
            let fields = vec![
                field("FRACTION", 0, FRACTION_BITS, read, None, "of a phase step, in parts of 256"),
                field("STEP", FRACTION_BITS, track.step_bits, read, None, "phase step"),
            ];
            let address = self.position_address();
            map.push(register("TRACK_POSITION".to_owned(), address, &about, fields));
        }
        map
    }
}
