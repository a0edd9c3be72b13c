//! The modules of a design and how they are connected.

use std::collections::{BTreeMap, BTreeSet};

use super::expr::{Expr, SignalId, Statement};
use super::module::VerilogModule;
use super::module_type::ModuleType;
use super::scope::{CLOCK, RESET};
use super::signals::{SignalRole, VectorName};

/// A module, the instances in it, and what drives what.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ModuleNetlist {
    /// Its name.
    pub name: String,
    /// Names of its inputs, without clock and reset.
    pub inputs: Vec<String>,
    /// Names of its outputs.
    pub outputs: Vec<String>,
    /// What stands in it, in the order of the Verilog.
    pub instances: Vec<Submodule>,
    /// What its own statements make of what.
    driven: Vec<Driven>,
}

/// A module in a module.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Submodule {
    /// Its own name.
    pub name: String,
    /// Its module's.
    pub module: String,
    /// Names of what its inputs are connected to.
    inputs: Vec<String>,
    /// Of what its outputs are.
    outputs: Vec<String>,
}

/// A net that the module itself drives.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Driven {
    net: String,
    from: Vec<String>,
    is_register: bool,
}

/// One end of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum End {
    /// Input of the module, by its number.
    Input(usize),
    /// Instance, by its number.
    Instance(usize),
    /// Registers and gates of the module itself.
    Own,
    /// Output of the module, by its number.
    Output(usize),
}

/// From one end to another, with the names of the nets.
pub type Connections = BTreeMap<(End, End), BTreeSet<String>>;

impl ModuleNetlist {
    /// That of a module of a design.
    pub(super) fn of(types: &[ModuleType], index: usize) -> ModuleNetlist {
        let this = &types[index];
        let module = &this.module;
        let port = |role: SignalRole| {
            let ports = module.ports.iter().map(|&id| &module.signals[id]);
            let ports = ports.filter(move |port| port.role == role && !is_clock(&port.name));
            ports.map(|port| port.name.clone()).collect()
        };
        let mut netlist = ModuleNetlist {
            name: this.name.clone(),
            inputs: port(SignalRole::Input),
            outputs: port(SignalRole::Output),
            ..ModuleNetlist::default()
        };
        for (instance, &(child, _)) in module.instances.iter().zip(&this.children) {
            let below = &types[child].module;
            let side = |role: SignalRole| {
                let has_role = |named: &VectorName| {
                    let mut ports = below.ports.iter().map(|&id| &below.signals[id]);
                    ports.any(|port| port.name == named.name && port.role == role)
                };
                let ports = instance.connections.iter().filter(|(port, _)| has_role(port));
                nets(module, ports.map(|(_, value)| value))
            };
            netlist.instances.push(Submodule {
                name: instance.name.clone(),
                module: types[child].name.clone(),
                inputs: side(SignalRole::Input),
                outputs: side(SignalRole::Output),
            });
        }
        netlist.driven.extend(module.assigns.iter().map(|assign| Driven {
            net: module.signals[assign.target].name.clone(),
            from: nets(module, [&assign.value]),
            is_register: false,
        }));
        netlist.driven.extend(module.registers.iter().map(|(id, _)| Driven {
            net: module.signals[*id].name.clone(),
            from: Vec::new(),
            is_register: true,
        }));
        netlist.clocked(module, &module.clocked);
        netlist
    }

    /// Adds what clocked statements make of what; what decides between them is one more thing
    /// that they follow from.
    fn clocked(&mut self, module: &VerilogModule, statements: &[Statement]) {
        for statement in statements {
            match statement {
                Statement::Assign { target, value } => self.driven.push(Driven {
                    net: module.signals[module.register_of(*target)].name.clone(),
                    from: nets(module, [value]),
                    is_register: true,
                }),
                Statement::If { test, yes, no } => {
                    let first = self.driven.len();
                    self.clocked(module, yes);
                    self.clocked(module, no);
                    for driven in &mut self.driven[first..] {
                        driven.from.extend(nets(module, [test]));
                    }
                }
            }
        }
    }

    /// What drives what: straight, or through gates that keep nothing.
    pub fn connections(&self) -> Connections {
        let mut connections = Connections::new();
        let mut connect = |to: End, net: &str| {
            for (from, name) in self.sources(net) {
                if from != to {
                    connections.entry((from, to)).or_default().insert(name);
                }
            }
        };
        for (index, instance) in self.instances.iter().enumerate() {
            instance.inputs.iter().for_each(|net| connect(End::Instance(index), net));
        }
        for driven in self.driven.iter().filter(|driven| driven.is_register) {
            driven.from.iter().for_each(|net| connect(End::Own, net));
        }
        for (index, output) in self.outputs.iter().enumerate() {
            connect(End::Output(index), output);
        }
        connections
    }

    /// Where a net's value comes from, and by which name.
    fn sources(&self, net: &str) -> BTreeSet<(End, String)> {
        let mut found = BTreeSet::new();
        let mut seen = BTreeSet::new();
        let mut waiting = vec![net.to_owned()];
        while let Some(net) = waiting.pop() {
            if !seen.insert(net.clone()) {
                continue;
            }
            let drives = |instance: &Submodule| instance.outputs.contains(&net);
            if let Some(input) = self.inputs.iter().position(|input| *input == net) {
                found.insert((End::Input(input), net));
            } else if let Some(instance) = self.instances.iter().position(drives) {
                found.insert((End::Instance(instance), net));
            } else {
                for driven in self.driven.iter().filter(|driven| driven.net == net) {
                    match driven.is_register {
                        true => _ = found.insert((End::Own, net.clone())),
                        false => waiting.extend(driven.from.iter().cloned()),
                    }
                }
            }
        }
        found
    }
}

fn is_clock(name: &str) -> bool {
    [CLOCK.0, RESET.0].contains(&name)
}

/// Names of the nets in some expressions, without constants, clock and reset.
fn nets<'e>(
    module: &VerilogModule,
    expressions: impl IntoIterator<Item = &'e Expr>,
) -> Vec<String> {
    let mut nets = Vec::new();
    for expression in expressions {
        expression.for_each_signal(&mut |id: SignalId| {
            let signal = &module.signals[id];
            let is_net = !matches!(signal.role, SignalRole::Constant | SignalRole::Table);
            if is_net && !is_clock(&signal.name) {
                nets.push(signal.name.clone());
            }
        });
    }
    nets
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An input through a gate to an output, and through an instance to a register and another
    /// output.
    #[test]
    fn what_drives_what_passes_gates_and_ends_at_registers() {
        let named = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        let driven = |net: &str, from: &[&str], is_register| Driven {
            net: net.to_owned(),
            from: named(from),
            is_register,
        };
        let netlist = ModuleNetlist {
            name: "top".to_owned(),
            inputs: named(&["i_a"]),
            outputs: named(&["o_b", "o_c"]),
            instances: vec![Submodule {
                name: "first".to_owned(),
                module: "leaf".to_owned(),
                inputs: named(&["i_a"]),
                outputs: named(&["inner"]),
            }],
            driven: vec![
                driven("glue", &["inner", "i_a"], false),
                driven("o_b", &["glue"], false),
                driven("o_c", &["inner", "glue"], true),
            ],
        };
        let found: Vec<(End, End)> = netlist.connections().into_keys().collect();
        let expected = [
            (End::Input(0), End::Instance(0)),
            (End::Input(0), End::Own),
            (End::Input(0), End::Output(0)),
            (End::Instance(0), End::Own),
            (End::Instance(0), End::Output(0)),
            (End::Own, End::Output(1)),
        ];
        assert_eq!(found, expected);
    }
}
