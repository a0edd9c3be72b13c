//! A module as it is printed: vectors of like signals packed into one, like statements and
//! instances as loops.

use std::collections::{HashMap, HashSet};

use super::expr::{Expr, SignalId, Statement};
use super::lines::{BitStatement, VerilogLine, folded, joined, lines, loops_joined};
use super::module::{Assign, Instance, VerilogModule};
use super::number::Num;
use super::signals::{Element, KernelSignal, ResetValue, SignalRole, vectors};
use super::term::{HasNumbers, Leaf, Says, Term, slope_of};

/// What counts the trips of loops in clocked statements, the innermost first.
pub const INDICES: [&str; 3] = ["i", "j", "k"];
/// The same of loops that make hardware.
pub const GENERATED: [&str; 2] = ["g", "h"];

/// A module's text, without its header and constants.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Sheet {
    /// Ports in the order of declaration.
    pub ports: Vec<Declaration>,
    /// Registers and wires that are not ports.
    pub declarations: Vec<Declaration>,
    /// Continuous assignments.
    pub assigns: Vec<VerilogLine>,
    /// Instances of other modules.
    pub groups: Vec<InstanceGroup>,
    /// Registers and their values after reset.
    pub resets: Vec<VerilogLine>,
    /// Statements of the clocked block.
    pub clocked: Vec<VerilogLine>,
}

/// A port, register or wire.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Declaration {
    /// How it is declared.
    pub kind: &'static str,
    /// Bits.
    pub width: Num,
    /// Its name.
    pub name: String,
    /// Description.
    pub about: String,
    /// Heading in the port list.
    pub heading: Option<String>,
}

/// Instances of one module: one, or a vector of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InstanceGroup {
    /// Name of an instance.
    pub name: String,
    /// How many there are.
    pub count: Num,
    /// Description; empty where their module has one.
    pub about: String,
    /// Sizes of each.
    pub sizes: Vec<(String, Num)>,
    /// What an instance's ports are connected to.
    pub connections: Vec<(String, Term)>,
}

impl InstanceGroup {
    /// Whether it is a vector, and not a single instance.
    pub fn is_family(&self) -> bool {
        self.count.constant() != Some(1)
    }
}

impl HasNumbers for Sheet {
    fn each_leaf(&mut self, see: &mut dyn FnMut(Leaf)) {
        for declaration in self.ports.iter_mut().chain(&mut self.declarations) {
            see(Leaf::Number(Says::Size, &mut declaration.width));
            see(Leaf::Name(&mut declaration.name));
        }
        self.assigns.each_leaf(see);
        for group in &mut self.groups {
            see(Leaf::Number(Says::Size, &mut group.count));
            let sizes = group.sizes.iter_mut();
            sizes.for_each(|(_, size)| see(Leaf::Number(Says::Size, size)));
            group.connections.iter_mut().for_each(|(_, term)| term.each_leaf(see));
        }
        self.resets.each_leaf(see);
        self.clocked.each_leaf(see);
    }
}

impl Sheet {
    /// How `module` is printed, the instances of which are `families`; each has `sizes`.
    pub fn of(
        module: &VerilogModule,
        families: &[Vec<usize>],
        sizes: &[Vec<(String, u32)>],
    ) -> Sheet {
        let packing = Packing::of(module);
        let mut assigns = Vec::new();
        let mut extra = Vec::new();
        let mut groups = Vec::new();
        for members in families {
            let sizes = sizes[members[0]].iter();
            let (name, connections) =
                connected(module, &packing, members, &mut assigns, &mut extra);
            groups.push(InstanceGroup {
                name,
                count: (members.len() as u32).into(),
                about: module.instances[members[0]].about.clone(),
                sizes: sizes.map(|(name, size)| (name.clone(), (*size).into())).collect(),
                connections,
            });
        }
        let own = module.assigns.iter();
        let own = own.map(|Assign { target, value }| packing.step(*target, value)).collect();
        let mut all = lines(joined(own), &packing.signals, &GENERATED);
        all.extend(assigns);
        let mut declarations = packing.declarations(module);
        declarations.extend(extra);
        let mut sheet = Sheet {
            ports: packing.ports(module),
            declarations,
            assigns: loops_joined(folded(all)),
            groups,
            resets: packing.resets(module),
            clocked: lines(packing.steps(module, &module.clocked), &packing.signals, &INDICES),
        };
        sheet.drop_second_names();
        sheet.declare_folds();
        sheet
    }

    /// Vectors that are another under a second name need no wire.
    fn drop_second_names(&mut self) {
        while let Some((at, from, to)) = self.second_name() {
            let dropped = self.declarations.iter().position(|one| one.name == from);
            let dropped = dropped.map(|place| self.declarations.remove(place));
            let is_register = dropped.is_some_and(|one| one.kind == "reg ");
            self.assigns.remove(at);
            self.each_name(&mut |name| {
                if *name == from {
                    name.clone_from(&to);
                }
            });
            if is_register && let Some(port) = self.ports.iter_mut().find(|port| port.name == to) {
                port.kind = "output reg ";
            }
        }
    }

    /// An assignment of a whole signal to another, the name that goes, and the one that stays.
    fn second_name(&self) -> Option<(usize, String, String)> {
        let inner = |name: &str| self.declarations.iter().find(|one| one.name == name);
        let is_output = |name: &str| {
            self.ports.iter().any(|port| port.name == name && port.kind == "output wire")
        };
        let is_known =
            |name: &str| inner(name).is_some() || self.ports.iter().any(|port| port.name == name);
        self.assigns.iter().enumerate().find_map(|(at, line)| {
            let VerilogLine::Store { target: Term::Name(target), value: Term::Name(value) } = line
            else {
                return None;
            };
            match (inner(target), inner(value)) {
                (Some(_), Some(wire)) if wire.kind == "wire" => {
                    Some((at, value.clone(), target.clone()))
                }
                (Some(_), _) if is_known(value) => Some((at, target.clone(), value.clone())),
                (None, Some(_)) if is_output(target) => Some((at, value.clone(), target.clone())),
                _ => None,
            }
        })
    }

    /// What a loop builds up is a variable.
    fn declare_folds(&mut self) {
        for line in &self.assigns {
            let VerilogLine::Fold { target: Term::Name(target), .. } = line else {
                continue;
            };
            for one in self.declarations.iter_mut().filter(|one| one.name == *target) {
                one.kind = "reg ";
            }
            for port in self.ports.iter_mut().filter(|port| port.name == *target) {
                port.kind = "output reg ";
            }
        }
    }

    /// Wires that one expression makes, and that expression: each behind those that it is made of.
    pub fn made_at_once(&self) -> Vec<(&Declaration, &Term)> {
        let mut left: Vec<(&Declaration, &Term)> = Vec::new();
        for line in &self.assigns {
            if let VerilogLine::Store { target: Term::Name(target), value } = line {
                let mut wires = self.declarations.iter().filter(|one| one.kind == "wire");
                left.extend(wires.find(|one| one.name == *target).map(|one| (one, value)));
            }
        }
        let mut out = Vec::new();
        while !left.is_empty() {
            let is_left = |name: &str| left.iter().any(|(one, _)| one.name == name);
            let next = left.iter().position(|(_, value)| !value.names(&mut |name| is_left(name)));
            out.push(left.remove(next.expect("nothing is made of itself")));
        }
        out
    }

    /// Whether a loop that makes hardware counts with `index`.
    pub fn generates_with(&self, index: &str) -> bool {
        let has_family = self.groups.iter().any(InstanceGroup::is_family);
        (index == GENERATED[0] && has_family) || loops_with(&self.assigns, index)
    }

    /// Whether a loop of clocked statements counts with `index`.
    pub fn loops_with(&self, index: &str) -> bool {
        loops_with(&self.clocked, index)
    }
}

fn loops_with(lines: &[VerilogLine], index: &str) -> bool {
    lines.iter().any(|line| match line {
        VerilogLine::Store { .. } | VerilogLine::Fold { .. } => false,
        VerilogLine::If { yes, no, .. } => loops_with(yes, index) || loops_with(no, index),
        VerilogLine::Loop { index: own, body, .. } => *own == index || loops_with(body, index),
    })
}

/// Where the signals of a module are in packed ones.
struct Packing {
    /// The module's signals, and behind them the packed ones.
    signals: Vec<KernelSignal>,
    /// Packed signal, and the place of the lowest bit.
    places: HashMap<SignalId, (SignalId, u32)>,
}

/// Whether a signal follows from itself, by what each is made of.
fn is_made_of_itself(signal: SignalId, made_of: &HashMap<SignalId, Vec<SignalId>>) -> bool {
    let (mut ahead, mut seen) = (vec![signal], HashSet::new());
    while let Some(next) = ahead.pop() {
        for &read in made_of.get(&next).into_iter().flatten() {
            if read == signal {
                return true;
            }
            if seen.insert(read) {
                ahead.push(read);
            }
        }
    }
    false
}

impl Packing {
    fn of(module: &VerilogModule) -> Packing {
        let own = &module.signals;
        let mut signals = own.clone();
        let mut packed: HashMap<String, SignalId> = HashMap::new();
        let mut vectors = vectors(own);
        // What one element makes of another would be a loop of the whole, as simulators see it.
        let whole = |id: SignalId| {
            let element = own[id].element.as_ref();
            element.and_then(|element| vectors.get(&element.all)).map_or(id, |all| all[0])
        };
        let mut made_of: HashMap<SignalId, Vec<SignalId>> = HashMap::new();
        for Assign { target, value } in &module.assigns {
            let reads = made_of.entry(whole(*target)).or_default();
            value.for_each_signal(&mut |id| reads.push(whole(id)));
        }
        let looped: Vec<String> = vectors
            .iter()
            .filter(|(_, elements)| is_made_of_itself(elements[0], &made_of))
            .map(|(name, _)| name.clone())
            .collect();
        looped.iter().for_each(|name| _ = vectors.remove(name));
        let mut places = HashMap::new();
        for (id, signal) in own.iter().enumerate() {
            let Some(Element { all, place }) = &signal.element else {
                continue;
            };
            let Some(elements) = vectors.get(all) else {
                continue;
            };
            let whole = *packed.entry(all.clone()).or_insert_with(|| {
                let first = &own[elements[0]];
                signals.push(KernelSignal {
                    name: all.clone(),
                    width: first.width * elements.len() as u32,
                    element: None,
                    ..first.clone()
                });
                signals.len() - 1
            });
            places.insert(id, (whole, *place as u32 * signal.width));
        }
        Packing { signals, places }
    }

    /// Where a signal's bits are.
    fn place(&self, id: SignalId) -> (SignalId, u32) {
        self.places.get(&id).copied().unwrap_or((id, 0))
    }

    fn expr(&self, expr: &Expr) -> Expr {
        let value_of = |id: SignalId| {
            let (whole, low) = *self.places.get(&id)?;
            Some(Expr::Slice { id: whole, high: low + self.signals[id].width - 1, low })
        };
        expr.replaced(&value_of).expect("parts of signals are signals' parts")
    }

    fn step(&self, target: SignalId, value: &Expr) -> BitStatement {
        let (id, low) = self.place(target);
        BitStatement::Store { id, low, value: self.expr(value) }
    }

    fn steps(&self, module: &VerilogModule, statements: &[Statement]) -> Vec<BitStatement> {
        let step = |statement: &Statement| match statement {
            Statement::Assign { target, value } => self.step(module.register_of(*target), value),
            Statement::If { test, yes, no } => BitStatement::If {
                test: self.expr(test),
                yes: self.steps(module, yes),
                no: self.steps(module, no),
            },
        };
        statements.iter().map(step).collect()
    }

    /// Declarations of `ids`, a packed signal where its first element is.
    fn declared(
        &self,
        ids: impl IntoIterator<Item = (&'static str, SignalId)>,
    ) -> Vec<Declaration> {
        let mut out: Vec<Declaration> = Vec::new();
        for (kind, id) in ids {
            let signal = &self.signals[self.place(id).0];
            if out.iter().any(|known| known.name == signal.name) {
                continue;
            }
            // The port of an instance says what it is.
            let is_said = !matches!(signal.role, SignalRole::InstanceOutput(_));
            out.push(Declaration {
                kind,
                width: signal.width.into(),
                name: signal.name.clone(),
                about: if is_said { signal.about.clone() } else { String::new() },
                heading: signal.heading.clone(),
            });
        }
        out
    }

    fn ports(&self, module: &VerilogModule) -> Vec<Declaration> {
        let is_register = |id: SignalId| {
            let name = &self.signals[self.place(id).0].name;
            let registers = module.registers.iter();
            registers.into_iter().any(|(q, _)| self.signals[self.place(*q).0].name == *name)
        };
        let kind = |id: SignalId| match module.signals[id].role {
            SignalRole::Input => "input  wire",
            _ if is_register(id) => "output reg ",
            _ => "output wire",
        };
        self.declared(module.ports.iter().map(|id| (kind(*id), *id)))
    }

    fn declarations(&self, module: &VerilogModule) -> Vec<Declaration> {
        let ports = self.ports(module);
        let registers = module.registers.iter().map(|(id, _)| ("reg ", *id));
        let wires = module.wires.iter().map(|id| ("wire", *id));
        let all = self.declared(registers.chain(wires));
        let is_port = |name: &str| ports.iter().any(|port| port.name == name);
        all.into_iter().filter(|declaration| !is_port(&declaration.name)).collect()
    }

    fn resets(&self, module: &VerilogModule) -> Vec<VerilogLine> {
        let store = |(id, reset): &(SignalId, ResetValue)| {
            let width = module.signals[*id].width;
            let value = match reset {
                ResetValue::Literal(value) => Expr::Literal { value: *value, width },
                ResetValue::Constant(constant) => Expr::Signal { id: *constant, width },
            };
            self.step(*id, &value)
        };
        lines(joined(module.registers.iter().map(store).collect()), &self.signals, &INDICES)
    }
}

/// Instances that are printed together: those of a vector that are of one kind.
pub fn families<K: PartialEq>(instances: &[Instance], kinds: &[K]) -> Vec<Vec<usize>> {
    let vector = |index: usize| instances[index].element.as_ref().map(|element| &element.all);
    let mut out: Vec<Vec<usize>> = Vec::new();
    for index in 0..instances.len() {
        let is_next = |members: &Vec<usize>| {
            let before = members[members.len() - 1];
            vector(before).is_some() && vector(before) == vector(index)
        };
        match out.last_mut() {
            Some(members) if is_next(members) => members.push(index),
            _ => out.push(vec![index]),
        }
    }
    let is_alike = |members: &[usize]| members.iter().all(|m| kinds[*m] == kinds[members[0]]);
    let split = |members: Vec<usize>| match is_alike(&members) {
        true => vec![members],
        false => members.into_iter().map(|member| vec![member]).collect(),
    };
    out.into_iter().flat_map(split).collect()
}

/// The name of instances, and what they are connected to; adds wires and assignments where that
/// differs in more than its place.
fn connected(
    module: &VerilogModule,
    packing: &Packing,
    members: &[usize],
    assigns: &mut Vec<VerilogLine>,
    extra: &mut Vec<Declaration>,
) -> (String, Vec<(String, Term)>) {
    let first = &module.instances[members[0]];
    let each: Vec<Vec<(String, Expr)>> =
        members.iter().map(|member| connections(&module.instances[*member], packing)).collect();
    if members.len() == 1 {
        let term =
            |(port, value): &(String, Expr)| (port.clone(), Term::of(value, &packing.signals));
        let connections = each[0].iter().map(term).collect();
        return (first.name.clone(), connections);
    }
    let name = first.element.as_ref().map_or(&first.name, |element| &element.all).clone();
    let index = GENERATED[0];
    let mut connected = Vec::new();
    for (number, (port, _)) in each[0].iter().enumerate() {
        let terms: Vec<Term> =
            each.iter().map(|ports| Term::of(&ports[number].1, &packing.signals)).collect();
        let moves = |(says, by): &(Says, Num)| *says == Says::Place || *by == Num::default();
        let term = match slope_of(&terms).filter(|slope| slope.iter().all(moves)) {
            Some(slope) => terms[0].along(&slope, index, 0),
            _ => {
                let width = each[0][number].1.width();
                let mut signals = packing.signals.clone();
                let short = port.strip_prefix("i_").unwrap_or(port);
                // What comes out of them by that name has it already.
                let output = format!("o_{short}");
                let is_taken = each[0].iter().any(|(port, _)| *port == output);
                let short = if is_taken { port } else { short };
                let id = signals.len();
                signals.push(KernelSignal {
                    name: format!("{name}_{short}"),
                    width: width * members.len() as u32,
                    role: SignalRole::Local,
                    about: String::new(),
                    heading: None,
                    value: 0,
                    element: None,
                });
                extra.push(Declaration {
                    kind: "wire",
                    width: signals[id].width.into(),
                    name: signals[id].name.clone(),
                    about: String::new(),
                    heading: None,
                });
                let stores = each.iter().enumerate().map(|(place, ports)| BitStatement::Store {
                    id,
                    low: width * place as u32,
                    value: ports[number].1.clone(),
                });
                assigns.extend(lines(joined(stores.collect()), &signals, &GENERATED));
                let low = Num::default().along(&width.into(), index, 0);
                Term::Part { name: signals[id].name.clone(), low, width: width.into() }
            }
        };
        connected.push((port.clone(), term));
    }
    (name, connected)
}

/// An instance's ports, and what they are connected to; vectors of ports are one.
fn connections(instance: &Instance, packing: &Packing) -> Vec<(String, Expr)> {
    let mut out: Vec<(String, Vec<Expr>)> = Vec::new();
    for (port, value) in &instance.connections {
        let name = port.element.as_ref().map_or(&port.name, |element| &element.all);
        match out.last_mut() {
            Some((last, parts)) if last == name => parts.push(packing.expr(value)),
            _ => out.push((name.clone(), vec![packing.expr(value)])),
        }
    }
    let one = |(name, parts): (String, Vec<Expr>)| {
        (name, super::concat::concat(parts.into_iter().rev().collect()))
    };
    out.into_iter().map(one).collect()
}
