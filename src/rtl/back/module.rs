//! One Verilog module, ready to print.

use super::concat::concat_bits;
use super::drive::drives_of;
use super::expr::{Expr, SignalId};
use super::fault::{Fault, Refusal};
use super::lower::{Statement, lower};
use super::scope::{Content, Scope};
use super::signals::{Names, Reset, Role, Signal, TablePins};
use crate::rtl::front::Description;

/// A module without its constants' values, so that instances that differ in
/// nothing else share it.
#[derive(Debug)]
pub struct Module {
    /// Name and header.
    pub description: Description,
    /// Every signal, under its final name.
    pub signals: Vec<Signal>,
    /// Ports in the order of declaration.
    pub ports: Vec<SignalId>,
    /// Named constants in the order of declaration.
    pub constants: Vec<SignalId>,
    /// Tables of single bits.
    pub tables: Vec<TablePins>,
    /// Wires that are no ports.
    pub wires: Vec<SignalId>,
    /// Registers and their values after reset.
    pub registers: Vec<(SignalId, Reset)>,
    /// Continuous assignments.
    pub assigns: Vec<Assign>,
    /// Statements of the clocked block.
    pub clocked: Vec<Statement>,
    /// Instances of other modules.
    pub instances: Vec<Instance>,
}

/// A continuous assignment.
#[derive(Debug)]
pub struct Assign {
    /// The wire.
    pub target: SignalId,
    /// Its value.
    pub value: Expr,
    /// Comments that stand before it.
    pub comments: Vec<String>,
}

/// An instance of another module.
#[derive(Debug)]
pub struct Instance {
    /// Instance name.
    pub name: String,
    /// Index in the scope's children.
    pub child: usize,
    /// Ports as (name in the child, what is connected).
    pub connections: Vec<(String, Expr)>,
}

impl Module {
    /// Translates `scope`, without its children.
    pub fn of(scope: &Scope) -> Result<Module, Refusal> {
        let mut named = scope.name.clone();
        translate(scope, &mut named).map_err(|fault| Refusal {
            module: named,
            fault,
        })
    }

    /// What a clocked statement assigns: the register behind its input pin.
    pub fn register_of(&self, d: SignalId) -> &Signal {
        match self.signals[d].role {
            Role::RegisterD(index) => &self.signals[self.registers[index].0],
            _ => &self.signals[d],
        }
    }
}

fn translate(scope: &Scope, named: &mut String) -> Result<Module, Fault> {
    let Content::Kernel(kernel) = &scope.content else {
        return Err(Fault::Unsupported {
            construct: "a marker without a block".to_owned(),
        });
    };
    let names = Names::of(scope)?;
    let description = names.description.clone().ok_or(Fault::Unsupported {
        construct: "a block without an `About`".to_owned(),
    })?;
    named.clone_from(&description.module);
    let statements = lower(kernel, &names)?;
    let drives = drives_of(&statements, &names)?;
    let mut signals = names.signals.clone();
    let roles = |wanted: &[Role]| -> Vec<SignalId> {
        (0..names.signals.len())
            .filter(|&id| wanted.contains(&names.signals[id].role))
            .collect()
    };

    let mut assigns = Vec::new();
    let mut wires = Vec::new();
    let mut merged = vec![false; signals.len()];
    for &id in &drives.order {
        let driven = &drives.combinational[&id];
        let role = names.signals[id].role;
        match role {
            Role::RegisterClock(_) | Role::TableAddress(_) | Role::WiringIn(_) => continue,
            Role::InstanceInput(_) if is_simple(&driven.value) => continue,
            _ => {}
        }
        if let Some(source) = merge_candidate(role, &driven.value, &names)
            && !merged[source]
        {
            // One wire under one name: the register or the instance drives
            // the port itself.
            merged[source] = true;
            signals[source].name = signals[id].name.clone();
            if role == Role::Local {
                wires.push(id);
            }
            continue;
        }
        if !matches!(role, Role::Output) {
            wires.push(id);
        }
        assigns.push(Assign {
            target: id,
            value: driven.value.clone(),
            comments: driven.comments.clone(),
        });
    }
    for (index, table) in names.tables.iter().enumerate() {
        wires.push(table.data);
        assigns.push(Assign {
            target: table.data,
            value: Expr::Lookup {
                table: names.tables[index].contents,
                index: Box::new(drives.combinational[&table.address].value.clone()),
            },
            comments: Vec::new(),
        });
    }
    for wiring in &names.wirings {
        let value_of = |source: &usize| drives.combinational[&wiring.inputs[*source]].value.clone();
        wires.push(wiring.output);
        assigns.push(Assign {
            target: wiring.output,
            value: concat_bits(wiring.sources.iter().rev().map(value_of).collect()),
            comments: Vec::new(),
        });
    }

    let mut instances = Vec::new();
    for instance in &names.instances {
        let mut connections = Vec::new();
        for (port, id) in &instance.ports {
            let own = Expr::Signal {
                id: *id,
                width: names.signals[*id].width,
            };
            let connected = match names.signals[*id].role {
                Role::InstanceInput(_) => {
                    let value = &drives.combinational[id].value;
                    if is_simple(value) { value.clone() } else { own }
                }
                _ => {
                    if !drives.is_read[*id] {
                        // Verilator knows by this name that it is meant.
                        signals[*id].name.push_str("_unused");
                    }
                    if !merged[*id] {
                        wires.push(*id);
                    }
                    own
                }
            };
            connections.push((port.clone(), connected));
        }
        instances.push(Instance {
            name: instance.name.clone(),
            child: instance.child,
            connections,
        });
    }

    Ok(Module {
        description,
        ports: roles(&[Role::Input, Role::Output]),
        constants: roles(&[Role::Constant]),
        tables: names.tables.clone(),
        wires,
        registers: names.registers.iter().map(|r| (r.q, r.reset)).collect(),
        assigns,
        clocked: drives.clocked,
        instances,
        signals,
    })
}

/// What may stand in a port map without a name of its own.
fn is_simple(value: &Expr) -> bool {
    match value {
        Expr::Signal { .. } | Expr::Slice { .. } | Expr::Literal { .. } => true,
        Expr::Concat(parts) => parts.iter().all(is_simple),
        _ => false,
    }
}

/// The register or instance output that may take the driven signal's name.
fn merge_candidate(role: Role, value: &Expr, names: &Names) -> Option<SignalId> {
    let Expr::Signal { id, .. } = value else {
        return None;
    };
    match (role, names.signals[*id].role) {
        (Role::Output, Role::RegisterQ(_)) => Some(*id),
        (Role::Output | Role::Local, Role::InstanceOutput(_)) => Some(*id),
        _ => None,
    }
}
