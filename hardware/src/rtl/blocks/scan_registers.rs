//! The scan's two counters, for simulations that shorten steps and scans.
//!
//! Both are LFSRs, and so linear: to move one on by some counts, a pattern that
//! depends on the counts alone is XORed into it. What is wrong with its state stays
//! wrong by as much, so that a simulation that moves it hides nothing.

use std::collections::HashMap;

use serde::Serialize;
use serde::ser::Serializer;

use super::scan_controller::{chip_counter, step_counter};
use super::sequence_counter::SequenceCounter;
use crate::rtl::back::Prefix;
use crate::sensor::interface::Interface;

/// Instance of the scan controller in the top module.
const INSTANCE: &str = "controller";
/// Its module.
const MODULE: &str = "scan_controller";

/// The counters of a scan controller; one that a scan does without is not there.
#[derive(Debug, Clone, schemars::JsonSchema)]
#[schemars(with = "RegisterNames")]
pub struct ScanRegisters {
    /// Chips of the present group.
    pub chips: Option<CountRegister>,
    /// Groups of the present scan.
    pub groups: Option<CountRegister>,
}

/// A register that counts.
#[derive(Debug, Clone)]
pub struct CountRegister {
    module: String,
    name: &'static str,
    counter: SequenceCounter,
    /// States that have been asked for.
    states: HashMap<u64, u64>,
}

impl ScanRegisters {
    /// Of the hardware that keeps an interface.
    pub fn of(interface: &Interface) -> ScanRegisters {
        let register = |name, counter| CountRegister {
            module: MODULE.to_owned(),
            name,
            counter,
            states: HashMap::new(),
        };
        // Those of a histogram's hardware are not LFSRs.
        let counts = interface.correlator().is_some();
        let (chips, groups) = (interface.timing.scan.integration_chips, interface.groups());
        ScanRegisters {
            chips: (counts && chips > 2).then(|| register("chip_count_r", chip_counter(chips))),
            groups: (counts && groups > 1).then(|| register("step_count_r", step_counter(groups))),
        }
    }

    /// The same in a design whose modules' names begin with `prefix`.
    pub fn in_design_of(mut self, prefix: &Prefix) -> ScanRegisters {
        for register in self.chips.iter_mut().chain(&mut self.groups) {
            register.module = prefix.of(MODULE);
        }
        self
    }

    /// Those that there are: chips first.
    pub fn present(&self) -> impl Iterator<Item = &CountRegister> {
        self.chips.iter().chain(&self.groups)
    }
}

impl PartialEq for ScanRegisters {
    fn eq(&self, other: &ScanRegisters) -> bool {
        let key =
            |register: &CountRegister| (register.name, register.width(), register.counter.taps());
        self.present().map(key).eq(other.present().map(key))
    }
}

impl Serialize for ScanRegisters {
    /// As the registers' names, from the top module down.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        RegisterNames::of(self).serialize(serializer)
    }
}

/// The registers' names, from the top module down.
#[derive(Serialize, schemars::JsonSchema)]
struct RegisterNames {
    /// Counts the chips of a group of phase steps.
    chips: Option<String>,
    /// Counts the groups of a scan.
    groups: Option<String>,
}

impl RegisterNames {
    fn of(registers: &ScanRegisters) -> RegisterNames {
        let path = |register: &Option<CountRegister>| register.as_ref().map(|r| r.path("."));
        RegisterNames { chips: path(&registers.chips), groups: path(&registers.groups) }
    }
}

impl CountRegister {
    /// Its module.
    pub fn module(&self) -> &str {
        &self.module
    }

    /// Its name there.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Its name in the top module.
    pub fn path(&self, separator: &str) -> String {
        format!("{INSTANCE}{separator}{}", self.name)
    }

    /// Bits.
    pub fn width(&self) -> u32 {
        self.counter.width()
    }

    /// What moves it on by `by` counts when `from` have been counted.
    pub fn difference(&mut self, from: u64, by: u64) -> u64 {
        if by == 0 {
            return 0;
        }
        let counter = &self.counter;
        let mut state = |count| {
            // A counter has at most 61 bits.
            let state = self.states.entry(count);
            *state.or_insert_with(|| counter.state(count) as u64)
        };
        state(from) ^ state(from + by)
    }
}
