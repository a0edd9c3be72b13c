//! The scan's two counters, for simulations that shorten steps and scans.
//!
//! To move one on by some counts, a pattern that depends on the counts alone is XORed into it. Those of a
//! scan that the scene fixes are LFSRs, and so linear: what is wrong with their state stays wrong by as much.
//! Those of a scan that a host sets are binary: what is wrong with their state stays wrong. So a simulation
//! that moves them hides nothing.

use std::collections::HashMap;

use serde::Serialize;
use serde::ser::Serializer;

use super::scan_controller::{chip_counter, step_counter};
use super::scan_sequencer::CHIPS_EARLY;
use super::sequence_counter::SequenceCounter;
use crate::rtl::back::Prefix;
use crate::sensor::interface::Interface;

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
    /// Its module, and the instance of that in the top module.
    module: String,
    instance: &'static str,
    name: &'static str,
    counter: Counter,
    /// States that have been asked for.
    states: HashMap<u64, u64>,
}

/// How a register counts.
#[derive(Debug, Clone)]
enum Counter {
    /// In the order of an LFSR.
    Sequence(SequenceCounter),
    /// In binary, from a number on.
    Binary { first: u64, width: u32 },
}

impl Counter {
    fn width(&self) -> u32 {
        match self {
            Counter::Sequence(counter) => counter.width(),
            Counter::Binary { width, .. } => *width,
        }
    }

    /// The state when so many have been counted, of at most 61 bits.
    fn state(&self, count: u64) -> u64 {
        match self {
            Counter::Sequence(counter) => counter.state(count) as u64,
            Counter::Binary { first, width } => (first + count) & ((1 << width) - 1),
        }
    }

    /// What tells it from another of its width.
    fn kind(&self) -> u128 {
        match self {
            Counter::Sequence(counter) => counter.taps(),
            Counter::Binary { .. } => 0,
        }
    }
}

impl ScanRegisters {
    /// Of the hardware that keeps an interface.
    pub fn of(interface: &Interface) -> ScanRegisters {
        let (module, instance) = match interface.registers {
            None => ("scan_controller", "controller"),
            Some(_) => ("scan_sequencer", "sequencer"),
        };
        let register = |name, counter| CountRegister {
            module: module.to_owned(),
            instance,
            name,
            counter,
            states: HashMap::new(),
        };
        if let Some(plan) = &interface.registers {
            let binary = |first, width| Counter::Binary { first, width };
            let chips = binary(CHIPS_EARLY, plan.chips_bits.max(plan.delay_bits));
            return ScanRegisters {
                chips: Some(register("chip_count_r", chips)),
                groups: Some(register("step_count_r", binary(1, plan.groups_bits))),
            };
        }
        let sequence = Counter::Sequence;
        // Those of a histogram's hardware are not LFSRs.
        let counts = interface.correlator().is_some();
        let (chips, groups) = (interface.timing.scan.integration_chips, interface.groups());
        ScanRegisters {
            chips: (counts && chips > 2)
                .then(|| register("chip_count_r", sequence(chip_counter(chips)))),
            groups: (counts && groups > 1)
                .then(|| register("step_count_r", sequence(step_counter(groups)))),
        }
    }

    /// The same in a design whose modules' names begin with `prefix`.
    pub fn in_design_of(mut self, prefix: &Prefix) -> ScanRegisters {
        for register in self.chips.iter_mut().chain(&mut self.groups) {
            register.module = prefix.of(&register.module);
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
            |register: &CountRegister| (register.name, register.width(), register.counter.kind());
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
        format!("{}{separator}{}", self.instance, self.name)
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
        let mut state = |count| *self.states.entry(count).or_insert_with(|| counter.state(count));
        state(from) ^ state(from + by)
    }
}
