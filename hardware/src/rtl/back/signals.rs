//! The names of a module: its own signals and the pins of what is in it.

use std::collections::{HashMap, HashSet};
use std::mem::discriminant;

use rust_hdl_core::atom::AtomKind;

use super::expr::{Expr, SignalId, Statement};
use super::fault::Fault;
use super::names::check_name;
use super::scope::{AtomInfo, CLOCK, Content, RESET, Scope};
use crate::rtl::front::{Description, Marker};

/// Something that a kernel can name.
#[derive(Debug, Clone)]
pub struct KernelSignal {
    /// Name in the Verilog.
    pub name: String,
    /// Bits.
    pub width: u32,
    /// What it is in its module.
    pub role: SignalRole,
    /// Description; empty for pins.
    pub about: String,
    /// Heading in the port list.
    pub heading: Option<String>,
    /// Value of a constant.
    pub value: u128,
    /// Its place in a vector of like signals.
    pub element: Option<Element>,
}

/// A place in a vector of like signals, which are printed as one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// Name of them all.
    pub all: String,
    /// Which of them, from 0.
    pub place: usize,
}

/// What a signal is in its module; numbers index the registers, tables
/// or instances of [`ModuleNames`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SignalRole {
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
    /// The contents of a table.
    Table,
    /// A table's index.
    TableAddress(usize),
    /// A table's entry.
    TableData(usize),
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
    /// Value after reset.
    pub reset: ResetValue,
}

/// A register's value after reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResetValue {
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

/// An instance of another module.
#[derive(Debug, Clone)]
pub struct InstancePins {
    /// Instance name.
    pub name: String,
    /// Index in the scope's children.
    pub child: usize,
    /// Description; empty where its module has one.
    pub about: String,
    /// Its vector of instances, and its place there.
    pub element: Option<Element>,
    /// Ports as (name in the child, signal here).
    pub ports: Vec<(VectorName, SignalId)>,
}

/// Every name of a module.
#[derive(Debug, Default)]
pub struct ModuleNames {
    /// The header, if the block has one.
    pub description: Option<Description>,
    /// All signals.
    pub signals: Vec<KernelSignal>,
    /// Registers, in the order of declaration.
    pub registers: Vec<RegisterPins>,
    /// Tables.
    pub tables: Vec<TablePins>,
    /// Instances, in the order of declaration.
    pub instances: Vec<InstancePins>,
    by_key: HashMap<String, SignalId>,
    vectors: HashMap<String, Vec<SignalId>>,
}

impl ModuleNames {
    /// The names of `scope`.
    pub fn of(scope: &Scope) -> Result<ModuleNames, Fault> {
        let mut names = ModuleNames::default();
        let atom_names = plain_names(scope.atoms.iter().map(|a| a.outer_key.as_str()));
        for (atom, name) in scope.atoms.iter().zip(atom_names) {
            let (role, name) = match atom.kind {
                AtomKind::InputParameter => (SignalRole::Input, name),
                AtomKind::OutputParameter => (SignalRole::Output, name),
                AtomKind::LocalSignal => (SignalRole::Local, name),
                AtomKind::Constant => {
                    (SignalRole::Constant, VectorName::alone(name.name.to_uppercase()))
                }
                _ => {
                    let name = name.name;
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
                Content::Marker(Marker::About(description, _)) => {
                    names.description = Some(description.clone());
                }
                Content::Marker(Marker::Given { about, .. }) => {
                    let are_alike = are_alike(&scope.children, &name);
                    names.add_instance(child, &name, are_alike, index);
                    let instance = names.instances.last_mut();
                    instance.into_iter().for_each(|one| one.about.clone_from(about));
                }
                Content::Marker(marker) => names.add_inline(child, name, marker)?,
                Content::Kernel(_) => {
                    let are_alike = are_alike(&scope.children, &name);
                    names.add_instance(child, &name, are_alike, index);
                }
            }
        }
        names.check()?;
        names.vectors = vectors(&names.signals);
        Ok(names)
    }

    /// Clock and reset go to every instance that has them.
    pub fn clocking(&self) -> Vec<Statement> {
        let ports = self.instances.iter().flat_map(|instance| &instance.ports);
        let clocked = ports.filter_map(|(port, pin)| {
            let is_clock = [CLOCK.0, RESET.0].contains(&port.name.as_str());
            let own = self.find(&port.name).filter(|_| is_clock)?;
            Some(Statement::Assign { target: *pin, value: Expr::Signal { id: own, width: 1 } })
        });
        clocked.collect()
    }

    /// The elements of the vector that a signal is in, in their order; or the signal alone.
    pub fn siblings(&self, id: SignalId) -> Vec<SignalId> {
        let element = self.signals[id].element.as_ref();
        let vector = element.and_then(|element| self.vectors.get(&element.all));
        vector.cloned().unwrap_or_else(|| vec![id])
    }

    /// The signal that a kernel calls `key`.
    pub fn find(&self, key: &str) -> Option<SignalId> {
        self.by_key.get(key).copied()
    }

    fn add(
        &mut self,
        key: &str,
        named: VectorName,
        width: u32,
        role: SignalRole,
        about: &str,
    ) -> SignalId {
        let id = self.signals.len();
        self.signals.push(KernelSignal {
            name: named.name,
            width,
            role,
            about: about.to_owned(),
            heading: None,
            value: 0,
            element: named.element,
        });
        self.by_key.insert(key.to_owned(), id);
        id
    }

    fn add_inline(
        &mut self,
        child: &Scope,
        name: VectorName,
        marker: &Marker,
    ) -> Result<(), Fault> {
        match marker {
            Marker::Register { name: given, reset_value, reset_constant, about } => {
                let name = given.clone().map_or(name, VectorName::alone);
                let reset = (*reset_value, reset_constant.as_deref());
                self.add_register(child, &name, reset, about)?;
            }
            Marker::BitTable { bits, about } => self.add_table(child, &name.name, bits, about),
            Marker::About(..) | Marker::Given { .. } => {}
        }
        Ok(())
    }

    fn add_register(
        &mut self,
        child: &Scope,
        name: &VectorName,
        (value, constant): (u128, Option<&str>),
        about: &str,
    ) -> Result<(), Fault> {
        let index = self.registers.len();
        let width = child.width_of("q");
        let reset = match constant {
            None => ResetValue::Literal(value),
            Some(constant) => {
                let id = self
                    .find(constant)
                    .ok_or_else(|| Fault::UnknownName { name: constant.to_owned() })?;
                check_reset_constant(&self.signals[id], &name.name, width, value)?;
                ResetValue::Constant(id)
            }
        };
        let mut pin = |pin: &str, name: VectorName, width, role, about: &str| {
            self.add(&child.pin(pin), name, width, role, about)
        };
        let inner = |pin: &str| VectorName::alone(format!("{}.{pin}", name.name));
        pin("d", inner("d"), width, SignalRole::RegisterD(index), "");
        let q = pin("q", name.between("", "_r"), width, SignalRole::RegisterQ(index), about);
        self.registers.push(RegisterPins { q, reset });
        Ok(())
    }

    fn add_table(&mut self, child: &Scope, name: &str, bits: &[u8], about: &str) {
        let index = self.tables.len();
        let width = child.width_of("address");
        let mut pin = |pin: &str, name: String, width, role, about: &str| {
            self.add(&child.pin(pin), VectorName::alone(name), width, role, about)
        };
        let contents = pin("", name.to_uppercase(), 1 << width, SignalRole::Table, about);
        let address_name = format!("{name}.address");
        let address = pin("address", address_name, width, SignalRole::TableAddress(index), "");
        let data = pin("data", format!("{name}_entry"), 1, SignalRole::TableData(index), "");
        self.tables.push(TablePins { contents, bits: bits.to_vec(), address, data });
    }

    /// Adds an instance; `are_alike` says whether those of its vector have the same ports.
    fn add_instance(&mut self, child: &Scope, name: &VectorName, are_alike: bool, index: usize) {
        let instance = self.instances.len();
        let ports = ports_of(child);
        let port_names = plain_names(ports.clone().map(|a| a.outer_key.as_str()));
        let mut pins = Vec::new();
        for (port, port_name) in ports.zip(&port_names) {
            // An instance's outputs are what the rest of the module reads, so
            // they get the shorter names.
            let is_input = port.kind == AtomKind::InputParameter;
            let role = if is_input {
                SignalRole::InstanceInput(instance)
            } else {
                SignalRole::InstanceOutput(instance)
            };
            let short = |port: &str| match is_input {
                true => port.to_owned(),
                false => port.strip_prefix("o_").unwrap_or(port).to_owned(),
            };
            let all_of =
                |port: &VectorName| port.element.as_ref().map(|element| element.all.clone());
            let all = all_of(port_name).unwrap_or_else(|| port_name.name.clone());
            let of_port = port_names.iter().filter(|other| all_of(other) == Some(all.clone()));
            let place = port_name.element.as_ref().map(|element| element.place);
            let element = match (&name.element, place) {
                (Some(vector), place) if are_alike => Some(Element {
                    all: format!("{}_{}", vector.all, short(&all)),
                    place: vector.place * of_port.count().max(1) + place.unwrap_or(0),
                }),
                (_, Some(place)) => {
                    Some(Element { all: format!("{}_{}", name.name, short(&all)), place })
                }
                (_, None) => None,
            };
            let wire = format!("{}_{}", name.name, short(&port_name.name));
            let wire = VectorName { name: wire, element };
            let id = self.add(&child.pin(&port.outer_key), wire, port.width, role, &port.about);
            pins.push((port_name.clone(), id));
        }
        let element = name.element.clone();
        self.instances.push(InstancePins {
            name: name.name.clone(),
            child: index,
            about: String::new(),
            element,
            ports: pins,
        });
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
    constant: &KernelSignal,
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
    if constant.value != reset_value || constant.role != SignalRole::Constant {
        return Err(Fault::Unsupported {
            construct: format!("a reset of `{register}` that is not its constant's value"),
        });
    }
    Ok(())
}

/// Ports of a block.
fn ports_of(scope: &Scope) -> impl Iterator<Item = &AtomInfo> + Clone {
    let is_port = |atom: &&AtomInfo| {
        matches!(atom.kind, AtomKind::InputParameter | AtomKind::OutputParameter)
    };
    scope.atoms.iter().filter(is_port)
}

/// Whether all blocks of the vector that `name` is in have the same ports.
fn are_alike(children: &[Scope], name: &VectorName) -> bool {
    let Some(element) = &name.element else {
        return true;
    };
    let names = plain_names(children.iter().map(|child| child.name.as_str()));
    let is_one = |other: &VectorName| other.element.as_ref().is_some_and(|e| e.all == element.all);
    let ports = |scope| -> Vec<_> {
        ports_of(scope).map(|port: &AtomInfo| (port.outer_key.clone(), port.width)).collect()
    };
    let mut all = children.iter().zip(&names).filter(|(_, name)| is_one(name));
    let first = all.next().map(|(child, _)| ports(child));
    all.all(|(child, _)| Some(ports(child)) == first)
}

/// A name without `$`, and the vector that it belongs to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VectorName {
    /// Its own name.
    pub name: String,
    /// What the vector's name and the place make of it.
    pub element: Option<Element>,
}

impl VectorName {
    /// What has `before` in front of its name and `after` behind it.
    fn between(&self, before: &str, after: &str) -> VectorName {
        let of = |name: &str| format!("{before}{name}{after}");
        let element = self.element.as_ref();
        let element = element.map(|e| Element { all: of(&e.all), place: e.place });
        VectorName { name: of(&self.name), element }
    }

    /// What is not an element of a vector.
    fn alone(name: impl Into<String>) -> VectorName {
        VectorName { name: name.into(), element: None }
    }
}

/// Names without `$`: elements of a vector get `_n`, unless there is only one.
fn plain_names<'a>(keys: impl Iterator<Item = &'a str> + Clone) -> Vec<VectorName> {
    let all: HashSet<&str> = keys.clone().collect();
    let named = |key: &str| {
        let name = key.replace('$', "_");
        let (base, place) = match key.rsplit_once('$') {
            Some((base, place)) => (base, place.parse::<usize>().ok()),
            None => return VectorName::alone(name),
        };
        let is_only = !all.contains(format!("{base}$1").as_str());
        let base = base.replace('$', "_");
        match place {
            Some(0) if is_only => VectorName::alone(base),
            Some(place) => VectorName { name, element: Some(Element { all: base, place }) },
            None => VectorName::alone(name),
        }
    };
    keys.map(named).collect()
}

/// Signals that are elements of one vector: their number, by its name. Those of unlike widths or
/// roles are none, nor are those of which some are missing.
pub fn vectors(signals: &[KernelSignal]) -> HashMap<String, Vec<SignalId>> {
    let mut found: HashMap<String, Vec<SignalId>> = HashMap::new();
    for (id, signal) in signals.iter().enumerate() {
        if let Some(element) = &signal.element {
            found.entry(element.all.clone()).or_default().push(id);
        }
    }
    let is_whole = |ids: &[SignalId]| {
        let first = &signals[ids[0]];
        let is_next = |(place, id): (usize, &SignalId)| {
            let signal = &signals[*id];
            signal.width == first.width
                && signal.element.as_ref().is_some_and(|element| element.place == place)
                && discriminant(&signal.role) == discriminant(&first.role)
        };
        ids.len() > 1 && ids.iter().enumerate().all(is_next)
    };
    let name_is_free = |name: &str| signals.iter().all(|signal| signal.name != name);
    found.retain(|name, ids| {
        let place = |id: &SignalId| signals[*id].element.as_ref().map(|element| element.place);
        ids.sort_by_key(place);
        // A port and what drives it share their name.
        ids.dedup_by_key(|id| place(id));
        is_whole(ids) && name_is_free(name)
    });
    found
}
