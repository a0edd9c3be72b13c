//! The names of a module: its own signals and the pins of what is in it.

use std::collections::{HashMap, HashSet};

use rust_hdl_core::atom::AtomKind;

use super::expr::SignalId;
use super::fault::Fault;
use super::names::check_name;
use super::scope::{Content, Scope};
use crate::rtl::front::{Description, Marker};

/// Something that a kernel can name.
#[derive(Debug, Clone)]
pub struct Signal {
    /// Name in the Verilog.
    pub name: String,
    /// Bits.
    pub width: u32,
    /// What it is in its module.
    pub role: Role,
    /// Description; empty for pins.
    pub about: String,
    /// Heading in the port list.
    pub heading: Option<String>,
    /// Value of a constant.
    pub value: u128,
}

/// What a signal is in its module; numbers index the registers, tables,
/// memories, wirings or instances of [`Names`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Port driven from outside.
    Input,
    /// Port driven by the module.
    Output,
    /// Wire inside.
    Local,
    /// Named constant.
    Constant,
    /// A register's input.
    RegisterD(usize),
    /// A register's content.
    RegisterQ(usize),
    /// A register's clock.
    RegisterClock(usize),
    /// The contents of a table.
    Table,
    /// A table's index.
    TableAddress(usize),
    /// A table's entry.
    TableData(usize),
    /// The contents of a memory.
    Memory,
    /// An input of a memory.
    MemoryIn(usize),
    /// What was read from a memory.
    MemoryQ(usize),
    /// An input of a wiring.
    WiringIn(usize),
    /// The output of a wiring.
    WiringOut(usize),
    /// Input port of an instance.
    InstanceInput(usize),
    /// Output port of an instance.
    InstanceOutput(usize),
}

/// A register of the module.
#[derive(Debug, Clone)]
pub struct RegisterPins {
    /// The register itself.
    pub q: SignalId,
    /// Its clock pin.
    pub clock: SignalId,
    /// Value after reset.
    pub reset: Reset,
}

/// A register's value after reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reset {
    /// A number.
    Literal(u128),
    /// One of the module's constants.
    Constant(SignalId),
}

/// A table of single bits in the module.
#[derive(Debug, Clone)]
pub struct TablePins {
    /// The contents.
    pub contents: SignalId,
    /// Entry 0 first.
    pub bits: Vec<u8>,
    /// Index.
    pub address: SignalId,
    /// Entry.
    pub data: SignalId,
}

/// A memory in the module.
#[derive(Debug, Clone)]
pub struct MemoryPins {
    /// The contents; as wide as a word.
    pub contents: SignalId,
    /// Number of words.
    pub words: u64,
    /// Its clock pin.
    pub clock: SignalId,
    /// Whether a word is written, where, and what.
    pub write: [SignalId; 3],
    /// Whether a word is read, and which.
    pub read: [SignalId; 2],
    /// The word that was read, two clocks later.
    pub q: SignalId,
}

/// Fixed wiring in the module.
#[derive(Debug, Clone)]
pub struct WiringPins {
    /// Inputs.
    pub inputs: Vec<SignalId>,
    /// Output.
    pub output: SignalId,
    /// For every bit of the output, the index of its input.
    pub sources: Vec<usize>,
}

/// An instance of another module.
#[derive(Debug, Clone)]
pub struct InstancePins {
    /// Instance name.
    pub name: String,
    /// Index in the scope's children.
    pub child: usize,
    /// Ports as (name in the child, signal here).
    pub ports: Vec<(String, SignalId)>,
}

/// Every name of a module.
#[derive(Debug, Default)]
pub struct Names {
    /// The header, if the block has one.
    pub description: Option<Description>,
    /// All signals.
    pub signals: Vec<Signal>,
    /// Registers, in the order of declaration.
    pub registers: Vec<RegisterPins>,
    /// Tables.
    pub tables: Vec<TablePins>,
    /// Memories.
    pub memories: Vec<MemoryPins>,
    /// Wirings.
    pub wirings: Vec<WiringPins>,
    /// Instances, in the order of declaration.
    pub instances: Vec<InstancePins>,
    by_key: HashMap<String, SignalId>,
}

impl Names {
    /// The names of `scope`.
    pub fn of(scope: &Scope) -> Result<Names, Fault> {
        let mut names = Names::default();
        let atom_names = plain_names(scope.atoms.iter().map(|a| a.outer_key.as_str()));
        for (atom, name) in scope.atoms.iter().zip(atom_names) {
            let (role, name) = match atom.kind {
                AtomKind::InputParameter => (Role::Input, name),
                AtomKind::OutputParameter => (Role::Output, name),
                AtomKind::LocalSignal => (Role::Local, name),
                AtomKind::Constant => (Role::Constant, name.to_uppercase()),
                _ => {
                    return Err(Fault::Unsupported {
                        construct: format!("`{name}`, neither input, output, local nor constant,"),
                    });
                }
            };
            let id = names.add(&atom.inner_key, name, atom.width, role, &atom.about);
            names.signals[id].value = atom.value;
            names.signals[id].heading.clone_from(&atom.heading);
        }
        let child_names = plain_names(scope.children.iter().map(|c| c.name.as_str()));
        for (index, (child, name)) in scope.children.iter().zip(child_names).enumerate() {
            match &child.content {
                Content::Marker(Marker::About(description)) => {
                    names.description = Some(description.clone());
                }
                Content::Marker(marker) => names.add_inline(child, name, marker)?,
                Content::Kernel(_) => names.add_instance(child, name, index),
            }
        }
        names.check()?;
        Ok(names)
    }

    /// The signal that a kernel calls `key`.
    pub fn find(&self, key: &str) -> Option<SignalId> {
        self.by_key.get(key).copied()
    }

    fn add(&mut self, key: &str, name: String, width: u32, role: Role, about: &str) -> SignalId {
        let id = self.signals.len();
        self.signals.push(Signal {
            name,
            width,
            role,
            about: about.to_owned(),
            heading: None,
            value: 0,
        });
        self.by_key.insert(key.to_owned(), id);
        id
    }

    fn add_inline(&mut self, child: &Scope, name: String, marker: &Marker) -> Result<(), Fault> {
        match marker {
            Marker::Register { name: given, reset_value, reset_constant, about } => {
                let name = given.clone().unwrap_or(name);
                let reset = (*reset_value, reset_constant.as_deref());
                self.add_register(child, &name, reset, about)?;
            }
            Marker::BitTable { bits, about } => self.add_table(child, &name, bits, about),
            Marker::Memory { words, about } => self.add_memory(child, &name, *words, about),
            Marker::Wiring { sources, about } => self.add_wiring(child, name, sources, about),
            Marker::About(_) => {}
        }
        Ok(())
    }

    fn add_register(
        &mut self,
        child: &Scope,
        name: &str,
        (value, constant): (u128, Option<&str>),
        about: &str,
    ) -> Result<(), Fault> {
        let index = self.registers.len();
        let width = child.width_of("q");
        let reset = match constant {
            None => Reset::Literal(value),
            Some(constant) => {
                let id = self
                    .find(constant)
                    .ok_or_else(|| Fault::UnknownName { name: constant.to_owned() })?;
                check_reset_constant(&self.signals[id], name, width, value)?;
                Reset::Constant(id)
            }
        };
        let mut pin = |pin: &str, name: String, width, role, about: &str| {
            self.add(&child.pin(pin), name, width, role, about)
        };
        let clock = pin("clock", format!("{name}.clock"), 1, Role::RegisterClock(index), "");
        pin("d", format!("{name}.d"), width, Role::RegisterD(index), "");
        let q = pin("q", format!("{name}_r"), width, Role::RegisterQ(index), about);
        self.registers.push(RegisterPins { q, clock, reset });
        Ok(())
    }

    fn add_table(&mut self, child: &Scope, name: &str, bits: &[u8], about: &str) {
        let index = self.tables.len();
        let width = child.width_of("address");
        let mut pin = |pin: &str, name: String, width, role, about: &str| {
            self.add(&child.pin(pin), name, width, role, about)
        };
        let contents = pin("", name.to_uppercase(), 1 << width, Role::Table, about);
        let address_name = format!("{name}.address");
        let address = pin("address", address_name, width, Role::TableAddress(index), "");
        let data = pin("data", format!("{name}_entry"), 1, Role::TableData(index), about);
        self.tables.push(TablePins { contents, bits: bits.to_vec(), address, data });
    }

    fn add_memory(&mut self, child: &Scope, name: &str, words: u64, about: &str) {
        let index = self.memories.len();
        let width = child.width_of("data");
        let contents = self.add(&child.pin(""), name.to_owned(), width, Role::Memory, about);
        let mut input = |pin: &str| {
            let name = format!("{name}.{pin}");
            let width = child.width_of(pin);
            self.add(&child.pin(pin), name, width, Role::MemoryIn(index), "")
        };
        let clock = input("clock");
        let write = ["write", "write_address", "data"].map(&mut input);
        let read = ["read", "address"].map(&mut input);
        let q_name = format!("{name}_q");
        let q = self.add(&child.pin("q"), q_name, width, Role::MemoryQ(index), "");
        self.memories.push(MemoryPins { contents, words, clock, write, read, q });
    }

    fn add_wiring(&mut self, child: &Scope, name: String, sources: &[usize], about: &str) {
        let index = self.wirings.len();
        let pins = child.atoms.iter();
        let pins = pins.filter(|a| a.kind == AtomKind::InputParameter);
        let inputs = pins
            .map(|atom| {
                let pin = &atom.outer_key;
                let role = Role::WiringIn(index);
                self.add(&child.pin(pin), format!("{name}.{pin}"), 1, role, "")
            })
            .collect();
        let width = sources.len() as u32;
        let output = self.add(&child.pin("o"), name, width, Role::WiringOut(index), about);
        self.wirings.push(WiringPins { inputs, output, sources: sources.to_vec() });
    }

    fn add_instance(&mut self, child: &Scope, name: String, index: usize) {
        let instance = self.instances.len();
        let ports = child
            .atoms
            .iter()
            .filter(|a| a.kind != AtomKind::LocalSignal && a.kind != AtomKind::Constant);
        let port_names = plain_names(ports.clone().map(|a| a.outer_key.as_str()));
        let mut pins = Vec::new();
        for (port, port_name) in ports.zip(port_names) {
            // An instance's outputs are what the rest of the module reads, so
            // they get the shorter names.
            let (role, wire) = match port.kind {
                AtomKind::InputParameter => {
                    (Role::InstanceInput(instance), format!("{name}_{port_name}"))
                }
                _ => {
                    let short = port_name.strip_prefix("o_").unwrap_or(&port_name);
                    (Role::InstanceOutput(instance), format!("{name}_{short}"))
                }
            };
            let key = format!("{}${}", child.name, port.outer_key);
            let id = self.add(&key, wire, port.width, role, &port.about);
            pins.push((port_name, id));
        }
        self.instances.push(InstancePins { name, child: index, ports: pins });
    }

    fn check(&self) -> Result<(), Fault> {
        let mut taken = HashSet::new();
        let instances = self.instances.iter().map(|i| i.name.as_str());
        let signals = self.signals.iter().map(|s| s.name.as_str());
        for name in signals.filter(|n| !n.contains('.')).chain(instances) {
            check_name(name)?;
            if !taken.insert(name) {
                return Err(Fault::BadName {
                    name: name.to_owned(),
                    reason: "two things of this module would share it",
                });
            }
        }
        for signal in &self.signals {
            if signal.width == 0 {
                return Err(Fault::OutOfRange { bit: 0, width: 0 });
            }
        }
        Ok(())
    }
}

fn check_reset_constant(
    constant: &Signal,
    register: &str,
    width: u32,
    reset_value: u128,
) -> Result<(), Fault> {
    if constant.width != width {
        return Err(Fault::WidthMismatch {
            place: format!("reset of `{register}`"),
            left: width,
            right: constant.width,
        });
    }
    if constant.value != reset_value || constant.role != Role::Constant {
        return Err(Fault::Unsupported {
            construct: format!("a reset of `{register}` that is not its constant's value"),
        });
    }
    Ok(())
}

/// Names without `$`: elements of a vector get `_n`, unless there is only one.
fn plain_names<'a>(keys: impl Iterator<Item = &'a str> + Clone) -> Vec<String> {
    let all: HashSet<&str> = keys.clone().collect();
    keys.map(|key| match key.strip_suffix("$0") {
        Some(base) if !all.contains(format!("{base}$1").as_str()) => base.replace('$', "_"),
        _ => key.replace('$', "_"),
    })
    .collect()
}
