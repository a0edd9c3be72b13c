//! Statements as they are printed: like ones next to each other as one, or as a loop.

use super::concat::{concat, fused};
use super::expr::{BinaryOp, Expr, SignalId};
use super::number::Num;
use super::signals::KernelSignal;
use super::term::{HasNumbers, Leaf, Parted, Says, Term, slope_of};

/// Fewest statements that become a loop.
const LEAST_TRIPS: usize = 3;
/// Fewest operands that do.
const LEAST_OPERANDS: usize = 5;
/// What counts the operands.
const OPERAND: &str = "m";

/// A statement of bits of packed signals.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BitStatement {
    /// Drives bits of a signal.
    Store {
        /// Which signal.
        id: SignalId,
        /// Its least significant bit that is driven.
        low: u32,
        /// With what; as wide as what is driven.
        value: Expr,
    },
    /// One of two blocks.
    If {
        /// A single bit.
        test: Expr,
        /// Statements for 1.
        yes: Vec<BitStatement>,
        /// Statements for 0.
        no: Vec<BitStatement>,
    },
}

/// A statement of the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum VerilogLine {
    /// Drives a signal, or bits of one.
    Store {
        /// What is driven.
        target: Term,
        /// With what.
        value: Term,
    },
    /// One of two blocks.
    If {
        /// A single bit.
        test: Term,
        /// Statements for 1.
        yes: Vec<VerilogLine>,
        /// Statements for 0.
        no: Vec<VerilogLine>,
    },
    /// What an operator makes of as many operands as there are trips.
    Fold {
        /// What is driven.
        target: Term,
        /// The operator, of which 0 changes nothing.
        op: BinaryOp,
        /// What counts the trips.
        index: &'static str,
        /// How many trips.
        trips: Num,
        /// The operand of one.
        operand: Term,
        /// 0, as wide as an operand.
        zero: Term,
    },
    /// The same again and again.
    Loop {
        /// What counts the trips.
        index: &'static str,
        /// How many trips.
        trips: Num,
        /// The statements of one.
        body: Vec<VerilogLine>,
    },
}

impl HasNumbers for VerilogLine {
    fn each_leaf(&mut self, see: &mut dyn FnMut(Leaf)) {
        match self {
            VerilogLine::Store { target, value } => {
                target.each_leaf(see);
                value.each_leaf(see);
            }
            VerilogLine::If { test, yes, no } => {
                test.each_leaf(see);
                yes.each_leaf(see);
                no.each_leaf(see);
            }
            VerilogLine::Fold { target, trips, operand, zero, .. } => {
                target.each_leaf(see);
                see(Leaf::Number(Says::Size, trips));
                operand.each_leaf(see);
                zero.each_leaf(see);
            }
            VerilogLine::Loop { trips, body, .. } => {
                see(Leaf::Number(Says::Size, trips));
                body.each_leaf(see);
            }
        }
    }
}

/// How `steps` are printed; loops count with `indices`, the innermost first.
pub fn lines(
    steps: Vec<BitStatement>,
    signals: &[KernelSignal],
    indices: &[&'static str],
) -> Vec<VerilogLine> {
    let line = |step| match step {
        BitStatement::Store { id, low, value } => VerilogLine::Store {
            target: Term::part(&signals[id], low + value.width() - 1, low),
            value: Term::of(&value, signals),
        },
        BitStatement::If { test, yes, no } => VerilogLine::If {
            test: Term::of(&test, signals),
            yes: lines(yes, signals, indices),
            no: lines(no, signals, indices),
        },
    };
    let lines: Vec<VerilogLine> = tidy(steps).into_iter().map(line).flat_map(spread).collect();
    indices.iter().fold(lines, |lines, index| rolled(lines, index))
}

/// Stores of like parts side by side are a store of each.
fn spread(line: VerilogLine) -> Vec<VerilogLine> {
    let VerilogLine::Store { target, value: Term::Concat(parts) } = &line else {
        return vec![line];
    };
    let is_even = |period: usize| {
        let each = |first: usize| slope_of(parts[first..].iter().step_by(period));
        parts.len() > LEAST_TRIPS * period
            && (0..period).all(|first| each(first).is_some_and(|slope| is_of_places(&slope)))
    };
    if !is_even(1) && !is_even(2) {
        return vec![line];
    }
    let (name, mut low) = match target {
        Term::Name(name) => (name, Num::default()),
        Term::Part { name, low, .. } => (name, low.clone()),
        _ => return vec![line],
    };
    let mut lines = Vec::new();
    for part in parts.iter().rev() {
        let Some(width) = part.width() else {
            return vec![line];
        };
        let target = Term::Part { name: name.clone(), low: low.clone(), width: width.clone() };
        low = low.add(&width);
        lines.push(VerilogLine::Store { target, value: part.clone() });
    }
    lines
}

/// Continuous assignments, in which one operator joins many like operands, as loops over them.
pub fn folded(lines: Vec<VerilogLine>) -> Vec<VerilogLine> {
    let fold = |line: VerilogLine| {
        let VerilogLine::Store { target, value: Term::Binary(op, left, right) } = &line else {
            return line;
        };
        let mut operands = vec![(**right).clone()];
        let mut rest = &**left;
        while let Term::Binary(same, left, right) = rest
            && same == op
        {
            operands.push((**right).clone());
            rest = left;
        }
        operands.push(rest.clone());
        operands.reverse();
        let slope = slope_of(&operands).filter(|slope| is_of_places(slope));
        match (slope, operands[0].width()) {
            (Some(slope), Some(width))
                if *op == BinaryOp::Or
                    && operands.len() >= LEAST_OPERANDS
                    // Blocks that each build up a part of one signal would wake each other for ever.
                    && matches!(target, Term::Name(_)) =>
            {
                VerilogLine::Fold {
                    target: target.clone(),
                    op: *op,
                    index: OPERAND,
                    trips: (operands.len() as u32).into(),
                    operand: operands[0].along(&slope, OPERAND, 0),
                    zero: Term::Literal { value: 0, width },
                }
            }
            _ => line,
        }
    };
    lines.into_iter().map(fold).collect()
}

/// Loops of as many trips as one.
pub fn loops_joined(lines: Vec<VerilogLine>) -> Vec<VerilogLine> {
    let mut out: Vec<VerilogLine> = Vec::new();
    for line in lines {
        if let VerilogLine::Loop { index, trips, body } = &line {
            let is_alike = |known: &&mut VerilogLine| match known {
                VerilogLine::Loop { index: own, trips: times, .. } => {
                    own == index && times == trips
                }
                _ => false,
            };
            if let Some(VerilogLine::Loop { body: known, .. }) = out.iter_mut().find(is_alike) {
                known.extend(body.clone());
                continue;
            }
        }
        out.push(line);
    }
    out
}

/// Whether places move, and nothing else.
fn is_of_places(slope: &[(Says, Num)]) -> bool {
    let zero = Num::default();
    slope.iter().any(|(_, by)| *by != zero)
        && slope.iter().all(|(says, by)| *says == Says::Place || *by == zero)
}

/// Runs of like statements as loops.
fn rolled(lines: Vec<VerilogLine>, index: &'static str) -> Vec<VerilogLine> {
    let parted: Vec<Parted<VerilogLine>> = lines.iter().map(HasNumbers::parted).collect();
    let mut out = Vec::new();
    let mut at = 0;
    while at < lines.len() {
        let found = (1..=3).filter_map(|period| Some((period, run(&parted[at..], period)?)));
        let longest =
            found.max_by_key(|(period, (trips, _))| (period * trips, std::cmp::Reverse(*period)));
        match longest {
            Some((period, (trips, slope))) if trips >= LEAST_TRIPS => {
                let first = lines[at..at + period].to_vec();
                out.push(VerilogLine::Loop {
                    index,
                    trips: (trips as u32).into(),
                    body: first.along(&slope, index, 0),
                });
                at += period * trips;
            }
            _ => {
                out.push(lines[at].clone());
                at += 1;
            }
        }
    }
    out
}

/// How many times the first `period` statements come, moved by as much each time, and by how much;
/// `None` if they come once.
fn run(lines: &[Parted<VerilogLine>], period: usize) -> Option<(usize, Vec<(Says, Num)>)> {
    let blocks: Vec<&[Parted<VerilogLine>]> = lines.chunks_exact(period).collect();
    let mut slopes = blocks.windows(2).map(|pair| slope_between(pair[0], pair[1]));
    let slope = slopes.next()?.filter(|slope| is_of_places(slope))?;
    Some((2 + slopes.take_while(|next| next.as_ref() == Some(&slope)).count(), slope))
}

/// How much greater the numbers of as many statements are.
fn slope_between(
    here: &[Parted<VerilogLine>],
    there: &[Parted<VerilogLine>],
) -> Option<Vec<(Says, Num)>> {
    let slopes = here.iter().zip(there).map(|(here, there)| here.slope_to(there));
    Some(slopes.collect::<Option<Vec<_>>>()?.concat())
}

/// What says the same in fewer statements.
fn tidy(steps: Vec<BitStatement>) -> Vec<BitStatement> {
    let mut tests_joined: Vec<BitStatement> = Vec::new();
    for step in steps {
        match (tests_joined.last_mut(), step) {
            (
                Some(BitStatement::If { test, yes, no }),
                BitStatement::If { test: same, yes: more, no: others },
            ) if *test == same => {
                yes.extend(more);
                no.extend(others);
            }
            (_, step) => tests_joined.push(step),
        }
    }
    let mut out = Vec::new();
    let mut stores = Vec::new();
    for (at, step) in tests_joined.iter().enumerate() {
        if tests_joined[at + 1..].iter().any(|later| covers(later, step)) {
            continue;
        }
        if matches!(step, BitStatement::Store { .. }) {
            stores.push(step.clone());
        } else {
            out.extend(joined(std::mem::take(&mut stores)));
            out.push(step.clone());
        }
    }
    out.extend(joined(stores));
    out
}

/// Whether nothing is left of what `step` stores.
fn covers(later: &BitStatement, step: &BitStatement) -> bool {
    match (later, step) {
        (
            BitStatement::Store { id, low, value },
            BitStatement::Store { id: other, low: from, value: before },
        ) => id == other && low <= from && low + value.width() >= from + before.width(),
        _ => false,
    }
}

/// Stores of different bits, in the order of signals as they first come, and in that of bits;
/// neighbours that one expression says as one.
pub fn joined(stores: Vec<BitStatement>) -> Vec<BitStatement> {
    let order: Vec<SignalId> = stores.iter().map(id_of).collect();
    let low_of = |step: &BitStatement| match step {
        BitStatement::Store { low, .. } => *low,
        BitStatement::If { .. } => 0,
    };
    let mut sorted = stores;
    sorted.sort_by_key(|step| (order.iter().position(|id| *id == id_of(step)), low_of(step)));
    let mut out: Vec<BitStatement> = Vec::new();
    for step in sorted {
        if let (
            Some(BitStatement::Store { id, low, value }),
            BitStatement::Store { id: next, low: from, value: above },
        ) = (out.last_mut(), &step)
            && *id == *next
            && *low + value.width() == *from
            && let Some(both) = fused(above, value)
        {
            *value = both;
            continue;
        }
        out.push(step);
    }
    whole(out)
}

/// Most parts of a signal that are stored together.
const MOST_PARTS: usize = 3;

/// Stores of a signal's few parts, none of which has to be worked out, as one of all of it.
fn whole(stores: Vec<BitStatement>) -> Vec<BitStatement> {
    let is_plain = |value: &Expr| {
        matches!(value, Expr::Signal { .. } | Expr::Slice { .. } | Expr::Literal { .. })
    };
    let mut out: Vec<BitStatement> = Vec::new();
    for group in stores.chunk_by(|a, b| id_of(a) == id_of(b)) {
        let mut next = 0;
        let mut parts = Vec::new();
        for step in group {
            match step {
                BitStatement::Store { low, value, .. } if *low == next && is_plain(value) => {
                    next += value.width();
                    parts.insert(0, value.clone());
                }
                _ => break,
            }
        }
        match parts.len() == group.len() && (2..=MOST_PARTS).contains(&parts.len()) {
            true => {
                out.push(BitStatement::Store { id: id_of(&group[0]), low: 0, value: concat(parts) })
            }
            false => out.extend_from_slice(group),
        }
    }
    out
}

fn id_of(step: &BitStatement) -> SignalId {
    match step {
        BitStatement::Store { id, .. } => *id,
        BitStatement::If { .. } => SignalId::MAX,
    }
}
