//! One text for instances of several sizes.
//!
//! How a module's numbers grow with a size shows from the same block one greater. What is made of
//! that is held against what each instance, and the least that the block is for, would be alone:
//! without loops both have to be the same.

use std::collections::HashMap;

use super::expr::UnaryOp;
use super::fault::FaultyDescription;
use super::lines::VerilogLine;
use super::module::VerilogModule;
use super::number::Num;
use super::scope::scopes_of;
use super::sheet::{GENERATED, Sheet, families};
use super::term::{HasNumbers, Term};
use crate::rtl::front::Size;

/// How far above an instance's size it is looked for two of which one follows from the other: of
/// few trips there is no loop.
const FARTHEST: u32 = 8;

/// The sheet of a block of other `sizes`, all of which it takes.
fn of_sizes(block: &[Size], values: &[u32]) -> Result<Sheet, FaultyDescription> {
    let (size, value) = (&block[0], values[0]);
    let scope = scopes_of(&*size.of_size(value))?;
    if values.len() > 1 {
        let rest: Vec<Size> = scope.sizes()[1..].to_vec();
        return of_sizes(&rest, &values[1..]);
    }
    let module = VerilogModule::of(&scope)?;
    let sizes = module.sizes_below(&scope);
    let kinds: Vec<_> = module.instances.iter().map(|i| &scope.children[i.child]).collect();
    let kinds: Vec<_> = kinds.iter().map(|scope| scope.module_name()).zip(&sizes).collect();
    Ok(Sheet::of(&module, &families(&module.instances, &kinds), &sizes))
}

/// One sheet for all `variants`, each with its sizes, of a block that has `sizes`; none where they
/// differ in more.
pub fn sheet_of_all(
    variants: &[(Vec<u32>, Sheet)],
    sizes: &[Size],
) -> Result<Option<Sheet>, FaultyDescription> {
    let (first, _) = &variants[0];
    let varying: Vec<usize> = (0..sizes.len())
        .filter(|&index| variants.iter().any(|(values, _)| values[index] != first[index]))
        .collect();
    if varying.is_empty() {
        return Ok(None);
    }
    let takes = |values: &[u32]| values.iter().zip(sizes).all(|(v, size)| size.takes.contains(v));
    if !variants.iter().all(|(values, _)| takes(values)) {
        return Ok(None);
    }
    let mut known = variants.to_vec();
    for &index in &varying {
        let mut least = first.clone();
        least[index] = *sizes[index].takes.start();
        known.push((least.clone(), of_sizes(sizes, &least)?));
    }
    let bases = variants.iter().flat_map(|(values, _)| (0..FARTHEST).map(move |by| (values, by)));
    for (values, by) in bases {
        let mut base = values.clone();
        varying.iter().for_each(|&index| base[index] += by);
        if takes(&base)
            && let Some(sheet) = grown_from(&base, sizes, &varying)?
            && known.iter().all(|(values, alone)| is_of(&sheet, values, sizes, alone))
        {
            return Ok(Some(sheet));
        }
    }
    Ok(None)
}

/// The sheet of a block, and how it grows with each of its `varying` sizes.
fn grown_from(
    base: &[u32],
    sizes: &[Size],
    varying: &[usize],
) -> Result<Option<Sheet>, FaultyDescription> {
    let alone = of_sizes(sizes, base)?;
    let mut sheet = alone.clone();
    for &index in varying {
        let is_most = base[index] == *sizes[index].takes.end();
        let mut next = base.to_vec();
        next[index] = if is_most { base[index] - 1 } else { base[index] + 1 };
        let next = of_sizes(sizes, &next)?;
        let (from, to) = if is_most { (&next, &alone) } else { (&alone, &next) };
        let Some(slope) = from.slope_to(to) else {
            return Ok(None);
        };
        sheet = sheet.along(&slope, &sizes[index].name, base[index].into());
    }
    Ok(Some(sheet))
}

/// Whether a sheet says of these sizes what `alone` does.
fn is_of(sheet: &Sheet, values: &[u32], sizes: &[Size], alone: &Sheet) -> bool {
    let names = sizes.iter().map(|size| size.name.as_str());
    let values: Vec<(&str, u32)> = names.zip(values.iter().copied()).collect();
    unrolled(sheet.at(&values)) == unrolled(alone.clone())
}

/// A sheet of numbers without loops, comments and choices of how to say something.
fn unrolled(mut sheet: Sheet) -> Sheet {
    let all = sheet.ports.iter().chain(&sheet.declarations);
    let widths: HashMap<String, Num> =
        all.map(|one| (one.name.clone(), one.width.clone())).collect();
    let mut stores = Vec::new();
    unroll(&sheet.assigns, &widths, &mut stores);
    sheet.assigns = stores;
    for lines in [&mut sheet.resets, &mut sheet.clocked] {
        let mut out = Vec::new();
        unroll(lines, &widths, &mut out);
        *lines = out;
    }
    for group in sheet.groups.iter_mut().filter(|group| !group.is_family()) {
        group.connections.iter_mut().for_each(|(_, term)| {
            *term = plain(&term.at(&[(GENERATED[0], 0)]), &widths);
        });
    }
    for one in sheet.ports.iter_mut().chain(&mut sheet.declarations) {
        one.about.clear();
        one.heading = None;
        // What a loop builds up is a variable.
        one.kind = if one.kind.starts_with("input") { "input" } else { "" };
    }
    sheet
}

/// Statements without loops; those between two tests in one order.
fn unroll(lines: &[VerilogLine], widths: &HashMap<String, Num>, out: &mut Vec<VerilogLine>) {
    let mut stores = Vec::new();
    spread(lines, widths, &mut stores);
    let is_store = |line: &VerilogLine| matches!(line, VerilogLine::Store { .. });
    for run in stores.chunk_by_mut(|a, b| is_store(a) && is_store(b)) {
        run.sort_by_cached_key(|line| format!("{line:?}"));
    }
    out.extend(stores);
}

fn spread(lines: &[VerilogLine], widths: &HashMap<String, Num>, out: &mut Vec<VerilogLine>) {
    for line in lines {
        match line {
            VerilogLine::Store { target, value } => {
                store(&plain(target, widths), &plain(value, widths), widths, out);
            }
            VerilogLine::Loop { index, trips, body } => {
                for trip in 0..trips.constant().unwrap_or(0) as u32 {
                    spread(&body.at(&[(index, trip)]), widths, out);
                }
            }
            VerilogLine::Fold { target, op, index, trips, operand, .. } => {
                let operands = (0..trips.constant().unwrap_or(0) as u32)
                    .map(|trip| operand.at(&[(index, trip)]))
                    .reduce(|all, one| Term::Binary(*op, Box::new(all), Box::new(one)));
                let value = operands.unwrap_or(Term::Concat(Vec::new()));
                spread(&[VerilogLine::Store { target: target.clone(), value }], widths, out);
            }
            VerilogLine::If { test, yes, no } => {
                let (mut when, mut otherwise) = (Vec::new(), Vec::new());
                unroll(yes, widths, &mut when);
                unroll(no, widths, &mut otherwise);
                out.push(VerilogLine::If { test: plain(test, widths), yes: when, no: otherwise });
            }
        }
    }
}

/// A store, of each part where the value is parts side by side.
fn store(target: &Term, value: &Term, widths: &HashMap<String, Num>, out: &mut Vec<VerilogLine>) {
    let place = match target {
        Term::Name(name) => Some((name, Num::default())),
        Term::Part { name, low, .. } => Some((name, low.clone())),
        _ => None,
    };
    let (Some((name, mut low)), Term::Concat(parts)) = (place, value) else {
        out.push(VerilogLine::Store { target: target.clone(), value: value.clone() });
        return;
    };
    for part in parts.iter().rev() {
        let width = match part {
            Term::Name(name) => widths.get(name).cloned().unwrap_or_default(),
            other => other.width().unwrap_or_default(),
        };
        let target = Term::Part { name: name.clone(), low: low.clone(), width: width.clone() };
        out.push(VerilogLine::Store { target: plain(&target, widths), value: part.clone() });
        low = low.add(&width);
    }
}

/// A term in which what is all of a signal has its name.
fn plain(term: &Term, widths: &HashMap<String, Num>) -> Term {
    let boxed = |term: &Term| Box::new(plain(term, widths));
    match term {
        Term::Part { name, low, width }
            if *low == Num::default() && widths.get(name) == Some(width) =>
        {
            Term::Name(name.clone())
        }
        Term::Concat(parts) => {
            let parts = parts.iter().filter(|part| part.width() != Some(Num::default()));
            let mut parts: Vec<Term> = parts.map(|part| plain(part, widths)).collect();
            if parts.len() == 1 { parts.remove(0) } else { Term::Concat(parts) }
        }
        Term::Repeat { count, bit } if count.constant() == Some(1) => plain(bit, widths),
        Term::Repeat { count, bit } => Term::Repeat { count: count.clone(), bit: boxed(bit) },
        Term::Lookup { table, index } => Term::Lookup { table: table.clone(), index: boxed(index) },
        Term::Unary(op, operand) => match (op, operand.width().and_then(|w| w.constant())) {
            (UnaryOp::All | UnaryOp::Any | UnaryOp::Parity, Some(1)) => plain(operand, widths),
            _ => Term::Unary(*op, boxed(operand)),
        },
        Term::Binary(op, left, right) => Term::Binary(*op, boxed(left), boxed(right)),
        Term::Mux(parts) => Term::Mux(Box::new(parts.each_ref().map(|p| plain(p, widths)))),
        other => other.clone(),
    }
}
