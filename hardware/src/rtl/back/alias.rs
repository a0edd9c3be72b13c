//! Signals that are another, or some bits of one, under a second name: they
//! need no wire.

use std::collections::HashMap;

use super::concat::concat_bits;
use super::drive::Drives;
use super::expr::{Expr, SignalId, Statement};
use super::fault::Fault;
use super::signals::{Names, Role, WiringPins};

/// Takes such signals out of `drives` and puts what they are in their places.
/// Gives the values of the wirings that are left.
pub fn resolve(drives: &mut Drives, names: &Names) -> Result<Vec<(SignalId, Expr)>, Fault> {
    let mut known: HashMap<SignalId, Expr> = HashMap::new();
    let shown = shown_at_ports(drives, names);
    loop {
        let mut found = HashMap::new();
        for &id in &drives.order {
            let value = replaced(&drives.combinational[&id], &known)?;
            if names.signals[id].role == Role::Local
                && (shown.contains(&id) || is_second_name(&value, names))
                && matches!(value, Expr::Signal { .. })
            {
                found.insert(id, value);
            }
        }
        for wiring in &names.wirings {
            let value = replaced(&wired(wiring, drives, names), &known)?;
            if matches!(value, Expr::Signal { .. } | Expr::Slice { .. }) {
                found.insert(wiring.output, value);
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
    let left = names.wirings.iter().filter(|w| !known.contains_key(&w.output));
    Ok(left.map(|w| (w.output, wired(w, drives, names))).collect())
}

fn replaced(expr: &Expr, known: &HashMap<SignalId, Expr>) -> Result<Expr, Fault> {
    expr.replaced(&|id| known.get(&id).cloned())
}

/// Locals that are no more than what a port shows.
fn shown_at_ports(drives: &Drives, names: &Names) -> Vec<SignalId> {
    let is_output = |id: &&SignalId| names.signals[**id].role == Role::Output;
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
fn is_second_name(value: &Expr, names: &Names) -> bool {
    match value {
        Expr::Signal { id, .. } => !matches!(names.signals[*id].role, Role::InstanceOutput(_)),
        _ => false,
    }
}

/// What a wiring carries.
fn wired(wiring: &WiringPins, drives: &Drives, names: &Names) -> Expr {
    let value_of = |source: &usize| drives.combinational[&wiring.inputs[*source]].clone();
    match concat_bits(wiring.sources.iter().rev().map(value_of).collect()) {
        Expr::Slice { id, high, low: 0 } if high + 1 == names.signals[id].width => {
            Expr::Signal { id, width: high + 1 }
        }
        value => value,
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
