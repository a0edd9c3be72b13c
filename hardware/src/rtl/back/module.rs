//! One Verilog module, ready to print.

use super::alias::resolve;
use super::drive::{Drives, drives_of};
use super::expr::{Expr, SignalId, Statement, UnaryOp};
use super::fault::{Fault, FaultyDescription};
use super::lower::{gathered, lower};
use super::scope::{AtomInfo, Content, Scope};
use super::signals::{
    Element, KernelSignal, ModuleNames, ResetValue, SignalRole, TablePins, VectorName,
};
use crate::rtl::front::Description;
use rust_hdl_core::atom::AtomKind;

/// A module without its constants' values, so that instances that differ in
/// nothing else share it.
#[derive(Debug, Default)]
pub struct VerilogModule {
    /// Name and header.
    pub description: Description,
    /// Every signal, under its final name.
    pub signals: Vec<KernelSignal>,
    /// Ports in the order of declaration.
    pub ports: Vec<SignalId>,
    /// Named constants in the order of declaration.
    pub constants: Vec<SignalId>,
    /// Tables of single bits.
    pub tables: Vec<TablePins>,
    /// Wires that are not ports.
    pub wires: Vec<SignalId>,
    /// Registers and their values after reset.
    pub registers: Vec<(SignalId, ResetValue)>,
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
}

/// An instance of another module.
#[derive(Debug)]
pub struct Instance {
    /// Instance name.
    pub name: String,
    /// Its vector of instances, and its place there.
    pub element: Option<Element>,
    /// Index in the scope's children.
    pub child: usize,
    /// Description; empty where its module has one.
    pub about: String,
    /// Ports as (name in the child, what is connected).
    pub connections: Vec<(VectorName, Expr)>,
}

impl VerilogModule {
    /// Sizes of its instances.
    pub fn sizes_below(&self, scope: &Scope) -> Vec<Vec<(String, u32)>> {
        let sizes = |instance: &Instance| scope.children[instance.child].size_values();
        self.instances.iter().map(sizes).collect()
    }

    /// Translates `scope`, without its children.
    pub fn of(scope: &Scope) -> Result<VerilogModule, FaultyDescription> {
        let mut named = scope.name.clone();
        translate(scope, &mut named).map_err(|fault| FaultyDescription { module: named, fault })
    }

    /// A module that is given, of which its ports are known.
    pub fn given(scope: &Scope, name: &str) -> VerilogModule {
        let signal = |atom: &AtomInfo| KernelSignal {
            name: atom.outer_key.clone(),
            width: atom.width,
            role: match atom.kind {
                AtomKind::InputParameter => SignalRole::Input,
                _ => SignalRole::Output,
            },
            about: String::new(),
            heading: None,
            value: 0,
            element: None,
        };
        VerilogModule {
            description: Description { module: name.to_owned(), ..Description::default() },
            signals: scope.atoms.iter().map(signal).collect(),
            ports: (0..scope.atoms.len()).collect(),
            ..VerilogModule::default()
        }
    }

    /// What a clocked statement assigns: the register behind its input pin.
    pub fn register_of(&self, d: SignalId) -> SignalId {
        match self.signals[d].role {
            SignalRole::RegisterD(index) => self.registers[index].0,
            _ => d,
        }
    }
}

fn translate(scope: &Scope, named: &mut String) -> Result<VerilogModule, Fault> {
    let Content::Kernel(kernel) = &scope.content else {
        return Err(Fault::Unsupported { construct: "a marker without a block".to_owned() });
    };
    let names = ModuleNames::of(scope)?;
    let description = names
        .description
        .clone()
        .ok_or(Fault::Unsupported { construct: "a block without an `About`".to_owned() })?;
    named.clone_from(&description.module);
    let mut statements = lower(kernel, &names)?;
    statements.extend(names.clocking());
    let mut drives = drives_of(&statements, &names)?;
    let gathered = gathered(kernel, &names)?;
    resolve(&mut drives, &names, &gathered)?;
    let mut wires = Wires {
        signals: names.signals.clone(),
        merged: vec![false; names.signals.len()],
        declared: Vec::new(),
        assigns: Vec::new(),
    };
    let (mut last, first): (Vec<_>, Vec<_>) =
        drives.order.iter().partition(|id| gathered.contains(id));
    for id in first {
        wires.drive(id, &drives.combinational[&id], &drives, &names);
    }
    for table in &names.tables {
        let index = Box::new(drives.combinational[&table.address].clone());
        let contents = table.contents;
        let entry = Expr::Lookup { table: contents, index };
        wires.assign(table.data, entry);
    }
    // What is put together bit by bit stands last, in the order of declaration.
    last.sort();
    for id in last {
        wires.drive(id, &drives.combinational[&id], &drives, &names);
    }
    let instances = wires.connect(&drives, &names);
    let with_role = |wanted: &[SignalRole]| -> Vec<SignalId> {
        (0..names.signals.len()).filter(|&id| wanted.contains(&names.signals[id].role)).collect()
    };
    Ok(VerilogModule {
        description,
        ports: with_role(&[SignalRole::Input, SignalRole::Output]),
        constants: with_role(&[SignalRole::Constant]),
        tables: names.tables.clone(),
        wires: wires.declared,
        registers: names.registers.iter().map(|r| (r.q, r.reset)).collect(),
        assigns: wires.assigns,
        clocked: drives.clocked,
        instances,
        signals: wires.signals,
    })
}

/// The wires of a module, as they come to light.
struct Wires {
    signals: Vec<KernelSignal>,
    /// Signals that have the name of what they drive.
    merged: Vec<bool>,
    declared: Vec<SignalId>,
    assigns: Vec<Assign>,
}

impl Wires {
    /// A combinational signal and its value.
    fn drive(&mut self, id: SignalId, value: &Expr, drives: &Drives, names: &ModuleNames) {
        let role = names.signals[id].role;
        match role {
            SignalRole::TableAddress(_) => return,
            SignalRole::InstanceInput(_) if is_simple(value) => return,
            _ => {}
        }
        if let Some(source) = merge_candidate(id, value, drives, names)
            && !self.merged[source]
        {
            // One wire under one name: the register or the instance drives the port itself.
            self.merged[source] = true;
            self.signals[source].name = self.signals[id].name.clone();
            self.signals[source].element = self.signals[id].element.clone();
            if role == SignalRole::Local {
                self.declared.push(id);
            }
            return;
        }
        if role != SignalRole::Output {
            self.declared.push(id);
        }
        self.assigns.push(Assign { target: id, value: value.clone() });
    }

    fn assign(&mut self, target: SignalId, value: Expr) {
        if !self.merged.get(target).is_some_and(|merged| *merged) {
            self.declared.push(target);
        }
        self.assigns.push(Assign { target, value });
    }

    /// The instances, and the wires from their outputs.
    fn connect(&mut self, drives: &Drives, names: &ModuleNames) -> Vec<Instance> {
        let instances = names.instances.iter();
        instances
            .map(|instance| Instance {
                name: instance.name.clone(),
                element: instance.element.clone(),
                child: instance.child,
                about: instance.about.clone(),
                connections: instance
                    .ports
                    .iter()
                    .map(|(port, id)| (port.clone(), self.connection(*id, drives, names)))
                    .collect(),
            })
            .collect()
    }

    /// A wire that takes all elements of a vector, some of which have no other use.
    fn leave_unused(&mut self, vector: &[SignalId]) {
        let all = vector.iter().rev();
        let all = all.map(|&id| Expr::Signal { id, width: self.signals[id].width });
        let value = Expr::Unary(UnaryOp::All, Box::new(Expr::Concat(all.collect())));
        let first = &self.signals[vector[0]];
        let name = first.element.as_ref().map_or(&first.name, |element| &element.all);
        let unused = KernelSignal {
            name: format!("unused_{name}"),
            width: 1,
            role: SignalRole::Local,
            about: "not every bit has another use; linters know by the name".to_owned(),
            element: None,
            ..first.clone()
        };
        self.signals.push(unused);
        self.assign(self.signals.len() - 1, value);
    }

    fn connection(&mut self, id: SignalId, drives: &Drives, names: &ModuleNames) -> Expr {
        let own = Expr::Signal { id, width: names.signals[id].width };
        if let SignalRole::InstanceInput(_) = names.signals[id].role {
            let value = &drives.combinational[&id];
            return if is_simple(value) { value.clone() } else { own };
        }
        let is_read = |id: &SignalId| drives.is_read[*id];
        let siblings = names.siblings(id);
        if !siblings.iter().any(is_read) {
            let signal = &mut self.signals[id];
            // Linters know by this name that it is meant.
            signal.name.push_str("_unused");
            if let Some(element) = &mut signal.element {
                element.all.push_str("_unused");
            }
        } else if siblings[0] == id && !siblings.iter().all(is_read) {
            self.leave_unused(&siblings);
        }
        if !self.merged[id] {
            self.declared.push(id);
        }
        own
    }
}

/// What may stand in a port map without a name of its own.
fn is_simple(value: &Expr) -> bool {
    match value {
        Expr::Signal { .. } | Expr::Slice { .. } | Expr::Literal { .. } => true,
        Expr::Concat(parts) => parts.iter().all(is_simple),
        Expr::Unary(UnaryOp::Not, operand) => is_simple(operand),
        Expr::Binary(op, left, right) => op.is_bitwise() && is_simple(left) && is_simple(right),
        _ => false,
    }
}

/// The register or instance output that may take the driven signal's name. Of a vector
/// all elements may, or none.
fn merge_candidate(
    id: SignalId,
    value: &Expr,
    drives: &Drives,
    names: &ModuleNames,
) -> Option<SignalId> {
    let source_of = |id: SignalId, value: Option<&Expr>| match value {
        Some(Expr::Signal { id: source, .. }) => {
            match (names.signals[id].role, names.signals[*source].role) {
                (SignalRole::Output, SignalRole::RegisterQ(_)) => Some(*source),
                (SignalRole::Output | SignalRole::Local, SignalRole::InstanceOutput(_)) => {
                    Some(*source)
                }
                _ => None,
            }
        }
        _ => None,
    };
    let source = source_of(id, Some(value))?;
    let of_source = names.siblings(source);
    if names.siblings(id) == [id] && of_source.len() > 1 {
        // Each element of the vector may be another port.
        let is_shown = |one: &SignalId| {
            let shows = |id: &SignalId| {
                names.signals[*id].role == SignalRole::Output
                    && names.siblings(*id) == [*id]
                    && source_of(*id, drives.combinational.get(id)) == Some(*one)
            };
            drives.order.iter().any(shows)
        };
        return of_source.iter().all(is_shown).then_some(source);
    }
    let siblings = names.siblings(id).into_iter();
    let sources: Option<Vec<SignalId>> =
        siblings.map(|id| source_of(id, drives.combinational.get(&id))).collect();
    (sources? == of_source).then_some(source)
}
