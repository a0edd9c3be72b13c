//! Who drives what: checks every signal for exactly one driver and turns a
//! kernel into continuous assignments and clocked statements.

use std::collections::{HashMap, HashSet};

use super::expr::{Expr, SignalId, Statement};
use super::fault::Fault;
use super::scope::{CLOCK, RESET};
use super::signals::{ModuleNames, ResetValue, SignalRole};

/// A kernel, taken apart.
#[derive(Debug)]
pub struct Drives {
    /// Value of every combinational signal.
    pub combinational: HashMap<SignalId, Expr>,
    /// Combinational signals in the order of their first assignment.
    pub order: Vec<SignalId>,
    /// Statements that assign registers only.
    pub clocked: Vec<Statement>,
    /// For every signal, whether anything reads it.
    pub is_read: Vec<bool>,
}

/// Takes `kernel` apart.
pub fn drives_of(kernel: &[Statement], names: &ModuleNames) -> Result<Drives, Fault> {
    check_targets(kernel, names)?;
    check_order(kernel, names, &mut vec![false; names.signals.len()])?;
    let mut order = assigned(kernel);
    let mut seen = HashSet::new();
    order.retain(|&id| {
        !matches!(names.signals[id].role, SignalRole::RegisterD(_)) && seen.insert(id)
    });
    let mut combinational = HashMap::new();
    for &id in &order {
        let name = &names.signals[id].name;
        let value = value_of(kernel, id, name, None)?.ok_or_else(|| undriven(name))?;
        combinational.insert(id, value);
    }
    check_driven(kernel, names, &combinational)?;
    let clocked = clocked_part(kernel, names, false);
    let is_read = check_reads(&combinational, &clocked, names)?;
    Ok(Drives { combinational, order, clocked, is_read })
}

fn undriven(name: &str) -> Fault {
    Fault::Undriven { signal: name.to_owned() }
}

/// Only what nothing else drives may be assigned.
fn check_targets(kernel: &[Statement], names: &ModuleNames) -> Result<(), Fault> {
    for id in assigned(kernel) {
        let signal = &names.signals[id];
        let name = signal.name.clone();
        match signal.role {
            SignalRole::Input => return Err(Fault::OwnInputDriven { signal: name }),
            SignalRole::Constant
            | SignalRole::Table
            | SignalRole::RegisterQ(_)
            | SignalRole::TableData(_)
            | SignalRole::InstanceOutput(_) => return Err(Fault::MultipleDrivers { signal: name }),
            _ => {}
        }
    }
    Ok(())
}

/// What a block assigns, in order.
fn assigned(block: &[Statement]) -> Vec<SignalId> {
    let mut targets = Vec::new();
    Statement::each(block, &mut |statement| {
        if let Statement::Assign { target, .. } = statement {
            targets.push(*target);
        }
    });
    targets
}

/// Refuses a signal that is assigned after it was read, which rules out
/// combinational loops inside a module too, and reads of pins that only the
/// kernel drives.
fn check_order(
    kernel: &[Statement],
    names: &ModuleNames,
    read: &mut Vec<bool>,
) -> Result<(), Fault> {
    for statement in kernel {
        let mut fault = None;
        let built_up = |id| match statement {
            Statement::Assign { target, .. } => id == *target && is_local(names, id),
            Statement::If { .. } => false,
        };
        statement.reads().for_each_signal(&mut |id| {
            if built_up(id) {
                return;
            }
            read[id] = true;
            if matches!(names.signals[id].role, SignalRole::RegisterD(_)) {
                fault = Some(Fault::Unsupported {
                    construct: format!("reading `{}`", names.signals[id].name),
                });
            }
        });
        if let Some(fault) = fault {
            return Err(fault);
        }
        match statement {
            Statement::Assign { target, .. } => {
                // What shows the new value without a clock.
                let shown = match names.signals[*target].role {
                    SignalRole::RegisterD(_) => None,
                    SignalRole::TableAddress(table) => Some(names.tables[table].data),
                    _ => Some(*target),
                };
                if let Some(id) = shown.filter(|&id| read[id]) {
                    return Err(Fault::AssignedAfterRead {
                        signal: names.signals[id].name.clone(),
                    });
                }
            }
            Statement::If { yes, no, .. } => {
                check_order(yes, names, read)?;
                check_order(no, names, read)?;
            }
        }
    }
    Ok(())
}

fn is_local(names: &ModuleNames, id: SignalId) -> bool {
    names.signals[id].role == SignalRole::Local
}

/// The value of `target` after `block`, `before` being its value so far.
fn value_of(
    block: &[Statement],
    target: SignalId,
    name: &str,
    before: Option<Expr>,
) -> Result<Option<Expr>, Fault> {
    let mut current = before;
    let mut is_set_here = false;
    for statement in block {
        match statement {
            Statement::Assign { target: assigned, value, .. } if *assigned == target => {
                let mut is_built_up = false;
                value.for_each_signal(&mut |id| is_built_up |= id == target);
                if is_set_here && !is_built_up {
                    return Err(Fault::MultipleDrivers { signal: name.to_owned() });
                }
                if is_built_up && current.is_none() {
                    return Err(undriven(name));
                }
                is_set_here = true;
                let so_far = |id| if id == target { current.clone() } else { None };
                current = Some(value.replaced(&so_far)?);
            }
            Statement::Assign { .. } => {}
            Statement::If { test, yes, no, .. } => {
                if !assigns(yes, target) && !assigns(no, target) {
                    continue;
                }
                let yes = value_of(yes, target, name, current.clone())?;
                let no = value_of(no, target, name, current.clone())?;
                current = match (yes, no) {
                    (Some(yes), Some(no)) => Some(Expr::Mux {
                        test: Box::new(test.clone()),
                        yes: Box::new(yes),
                        no: Box::new(no),
                    }),
                    _ => {
                        return Err(Fault::Latch { signal: name.to_owned() });
                    }
                };
                is_set_here = true;
            }
        }
    }
    Ok(current)
}

fn assigns(block: &[Statement], wanted: SignalId) -> bool {
    assigned(block).contains(&wanted)
}

fn check_driven(
    kernel: &[Statement],
    names: &ModuleNames,
    combinational: &HashMap<SignalId, Expr>,
) -> Result<(), Fault> {
    for (id, signal) in names.signals.iter().enumerate() {
        let is_driven = match signal.role {
            SignalRole::Output
            | SignalRole::Local
            | SignalRole::TableAddress(_)
            | SignalRole::InstanceInput(_) => combinational.contains_key(&id),
            SignalRole::RegisterD(_) => assigns(kernel, id),
            _ => true,
        };
        if !is_driven {
            return Err(undriven(&signal.name));
        }
    }
    Ok(())
}

/// The statements that assign registers, without the default hold. Inside an `if` a hold may undo
/// what stands before the `if`.
fn clocked_part(block: &[Statement], names: &ModuleNames, is_inside: bool) -> Vec<Statement> {
    let mut kept = Vec::new();
    for statement in block {
        match statement {
            Statement::Assign { target, value, .. } => {
                let SignalRole::RegisterD(index) = names.signals[*target].role else {
                    continue;
                };
                let q = names.registers[index].q;
                let holds = matches!(value, Expr::Signal { id, .. } if *id == q);
                // A hold that comes first is what a register does anyway; a
                // later one undoes an assignment and has to stay.
                if is_inside || !holds || assigns(&kept, *target) {
                    kept.push(statement.clone());
                }
            }
            Statement::If { test, yes, no } => {
                let [yes, no] = [yes, no].map(|block| clocked_part(block, names, true));
                if !yes.is_empty() || !no.is_empty() {
                    kept.push(Statement::If { test: test.clone(), yes, no });
                }
            }
        }
    }
    kept
}

/// Marks what is read, and refuses signals and constants that nothing reads.
/// Outputs of instances may stay unread.
fn check_reads(
    combinational: &HashMap<SignalId, Expr>,
    clocked: &[Statement],
    names: &ModuleNames,
) -> Result<Vec<bool>, Fault> {
    let mut is_read = vec![false; names.signals.len()];
    for value in combinational.values() {
        value.for_each_signal(&mut |id| is_read[id] = true);
    }
    Statement::each(clocked, &mut |statement| {
        statement.reads().for_each_signal(&mut |id| is_read[id] = true);
    });
    for register in &names.registers {
        if let ResetValue::Constant(id) = register.reset {
            is_read[id] = true;
        }
    }
    for (id, signal) in names.signals.iter().enumerate() {
        let must_be_read = match signal.role {
            SignalRole::Input => ![CLOCK.0, RESET.0].contains(&signal.name.as_str()),
            SignalRole::Local
            | SignalRole::Constant
            | SignalRole::RegisterQ(_)
            | SignalRole::TableData(_) => true,
            _ => false,
        };
        // Linters know by this name that it is meant.
        if must_be_read && !is_read[id] && !signal.name.contains("unused") {
            return Err(Fault::Unread { signal: signal.name.clone() });
        }
    }
    Ok(is_read)
}
