//! Signals that are another, or some bits of one, under a second name: they
//! need no wire.

use std::collections::{HashMap, HashSet};

use super::drive::Drives;
use super::expr::{Expr, SignalId, Statement};
use super::fault::Fault;
use super::signals::{ModuleNames, SignalRole};

/// Takes such signals out of `drives` and puts what they are in their places.
pub fn resolve(
    drives: &mut Drives,
    names: &ModuleNames,
    gathered: &HashSet<SignalId>,
) -> Result<(), Fault> {
    let mut known: HashMap<SignalId, Expr> = HashMap::new();
    let shown = shown_at_ports(drives, names);
    loop {
        let mut found = HashMap::new();
        for &id in &drives.order {
            let value = replaced(&drives.combinational[&id], &known)?;
            let is_another = match &value {
                Expr::Slice { .. } => gathered.contains(&id),
                Expr::Signal { .. } => {
                    gathered.contains(&id) || shown.contains(&id) || is_second_name(&value, names)
                }
                _ => false,
            };
            if names.signals[id].role == SignalRole::Local && is_another {
                found.insert(id, value);
            }
        }
        // Of a vector all elements have another name, or none.
        let is_whole = |id: &SignalId| names.siblings(*id).iter().all(|id| found.contains_key(id));
        let whole: Vec<SignalId> = found.keys().copied().filter(is_whole).collect();
        found.retain(|id, _| whole.contains(id));
        if found == known {
            break;
        }
        known = found;
    }
    drives.order.retain(|id| !known.contains_key(id));
    for value in drives.combinational.values_mut() {
        *value = replaced(value, &known)?;
    }
    drives.clocked = statements(&drives.clocked, &known)?;
    Ok(())
}

fn replaced(expr: &Expr, known: &HashMap<SignalId, Expr>) -> Result<Expr, Fault> {
    expr.replaced(&|id| known.get(&id).cloned())
}

/// Locals that are no more than what a port shows.
fn shown_at_ports(drives: &Drives, names: &ModuleNames) -> Vec<SignalId> {
    let is_output = |id: &&SignalId| names.signals[**id].role == SignalRole::Output;
    let shown = drives.order.iter().filter(is_output);
    shown
        .filter_map(|id| match drives.combinational[id] {
            Expr::Signal { id, .. } => Some(id),
            _ => None,
        })
        .collect()
}

/// A local that stands for a whole signal. The output of an instance gets the
/// local's name instead, which says more.
fn is_second_name(value: &Expr, names: &ModuleNames) -> bool {
    match value {
        Expr::Signal { id, .. } => {
            !matches!(names.signals[*id].role, SignalRole::InstanceOutput(_))
        }
        _ => false,
    }
}

fn statements(
    block: &[Statement],
    known: &HashMap<SignalId, Expr>,
) -> Result<Vec<Statement>, Fault> {
    let of = |statement: &Statement| {
        Ok(match statement {
            Statement::Assign { target, value } => {
                Statement::Assign { target: *target, value: replaced(value, known)? }
            }
            Statement::If { test, yes, no } => Statement::If {
                test: replaced(test, known)?,
                yes: statements(yes, known)?,
                no: statements(no, known)?,
            },
        })
    };
    block.iter().map(of).collect()
}
