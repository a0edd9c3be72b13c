//! Expressions as they are printed: signals by name, and numbers that may depend on loops and
//! parameters.

use super::expr::{BinaryOp, Expr, UnaryOp};
use super::number::Num;
use super::signals::KernelSignal;

/// An expression of the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Term {
    /// A whole signal or constant.
    Name(String),
    /// Bits of a signal, from `low` on.
    Part {
        /// Which signal.
        name: String,
        /// Least significant bit.
        low: Num,
        /// How many.
        width: Num,
    },
    /// A sized literal.
    Literal {
        /// Its value.
        value: u128,
        /// Bits.
        width: Num,
    },
    /// Parts side by side, most significant first.
    Concat(Vec<Term>),
    /// One bit, many times.
    Repeat {
        /// How many times.
        count: Num,
        /// The bit.
        bit: Box<Term>,
    },
    /// An entry of a table of single bits.
    Lookup {
        /// The table.
        table: String,
        /// The entry's index.
        index: Box<Term>,
    },
    /// Operator before one operand.
    Unary(UnaryOp, Box<Term>),
    /// Operator between two operands.
    Binary(BinaryOp, Box<Term>, Box<Term>),
    /// `test ? yes : no`.
    Mux(Box<[Term; 3]>),
}

impl Term {
    /// How `expr` is printed.
    pub fn of(expr: &Expr, signals: &[KernelSignal]) -> Term {
        let boxed = |e: &Expr| Box::new(Term::of(e, signals));
        match expr {
            Expr::Signal { id, .. } => Term::Name(signals[*id].name.clone()),
            Expr::Slice { id, high, low } => Term::part(&signals[*id], *high, *low),
            Expr::Literal { value, width } => {
                Term::Literal { value: *value, width: (*width).into() }
            }
            Expr::Concat(parts) => {
                Term::Concat(parts.iter().map(|p| Term::of(p, signals)).collect())
            }
            Expr::Repeat { count, bit } => Term::Repeat { count: (*count).into(), bit: boxed(bit) },
            Expr::Lookup { table, index } => {
                Term::Lookup { table: signals[*table].name.clone(), index: boxed(index) }
            }
            Expr::Unary(op, operand) => Term::Unary(*op, boxed(operand)),
            Expr::Binary(op, left, right) => Term::Binary(*op, boxed(left), boxed(right)),
            Expr::Mux { test, yes, no } => {
                Term::Mux(Box::new([test, yes, no].map(|e| Term::of(e, signals))))
            }
        }
    }

    /// Whether it names a signal of which `is_meant` holds.
    pub fn names(&self, is_meant: &mut dyn FnMut(&str) -> bool) -> bool {
        let mut found = false;
        self.clone().each_leaf(&mut |leaf| {
            if let Leaf::Name(name) = leaf {
                found |= is_meant(name);
            }
        });
        found
    }

    /// Bits, where the text says so.
    pub fn width(&self) -> Option<Num> {
        match self {
            Term::Part { width, .. } | Term::Literal { width, .. } => Some(width.clone()),
            Term::Repeat { count, .. } => Some(count.clone()),
            Term::Concat(parts) => {
                parts.iter().try_fold(Num::default(), |sum, part| Some(sum.add(&part.width()?)))
            }
            Term::Unary(UnaryOp::Not, operand) => operand.width(),
            Term::Unary(..) | Term::Lookup { .. } => Some(1u32.into()),
            Term::Binary(op, ..) if op.is_comparison() => Some(1u32.into()),
            Term::Binary(_, left, right) => left.width().or_else(|| right.width()),
            Term::Mux(parts) => parts[1].width().or_else(|| parts[2].width()),
            Term::Name(_) => None,
        }
    }

    /// Bits `low ..= high` of a signal.
    pub fn part(signal: &KernelSignal, high: u32, low: u32) -> Term {
        let name = signal.name.clone();
        if low == 0 && high + 1 == signal.width {
            return Term::Name(name);
        }
        Term::Part { name, low: low.into(), width: (high + 1 - low).into() }
    }
}

/// What a number says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Says {
    /// Where something begins; may differ from one trip of a loop to the next.
    Place,
    /// How many there are.
    Size,
}

/// What of a text may differ where its form does not.
#[derive(Debug)]
pub enum Leaf<'t> {
    /// A number.
    Number(Says, &'t mut Num),
    /// The name of a signal.
    Name(&'t mut String),
}

/// What has numbers in it, in an order of its own.
pub trait HasNumbers: Clone + PartialEq {
    /// Calls `see` with every number, and with every name of a signal.
    fn each_leaf(&mut self, see: &mut dyn FnMut(Leaf));

    /// Calls `see` with every number.
    fn each(&mut self, see: &mut dyn FnMut(Says, &mut Num)) {
        self.each_leaf(&mut |leaf| {
            if let Leaf::Number(says, number) = leaf {
                see(says, number);
            }
        });
    }

    /// Calls `see` with every name of a signal.
    fn each_name(&mut self, see: &mut dyn FnMut(&mut String)) {
        self.each_leaf(&mut |leaf| {
            if let Leaf::Name(name) = leaf {
                see(name);
            }
        });
    }

    /// Its form and its numbers apart.
    fn parted(&self) -> Parted<Self> {
        let (mut form, mut numbers) = (self.clone(), Vec::new());
        form.each(&mut |says, number| numbers.push((says, std::mem::take(number))));
        Parted { form, numbers }
    }

    /// The same where names have values.
    fn at(&self, values: &[(&str, u32)]) -> Self {
        let mut other = self.clone();
        other.each(&mut |_, number| *number = number.at(values));
        other
    }

    /// How much greater the numbers of `next` are; `None` if it differs in more.
    fn slope_to(&self, next: &Self) -> Option<Vec<(Says, Num)>> {
        self.parted().slope_to(&next.parted())
    }

    /// What is this where `name` is `at`, and grows by `slope` with it.
    fn along(&self, slope: &[(Says, Num)], name: &str, at: i128) -> Self {
        let mut other = self.clone();
        let mut slopes = slope.iter();
        other.each(&mut |_, number| {
            if let Some((_, slope)) = slopes.next() {
                *number = number.along(slope, name, at);
            }
        });
        other
    }
}

/// What has numbers, and these apart from it.
#[derive(Debug)]
pub struct Parted<T> {
    /// It with 0 in place of each number.
    form: T,
    /// All numbers, in its order.
    numbers: Vec<(Says, Num)>,
}

impl<T: PartialEq> Parted<T> {
    /// How much greater the numbers of `next` are; `None` if it differs in more.
    pub fn slope_to(&self, next: &Parted<T>) -> Option<Vec<(Says, Num)>> {
        let differences = self.numbers.iter().zip(&next.numbers);
        (self.form == next.form)
            .then(|| differences.map(|((says, a), (_, b))| (*says, b.sub(a))).collect())
    }
}

/// How much greater the numbers of each are than those of the one before, if that is the same all
/// along, and they differ in nothing else.
pub fn slope_of<'t, T: HasNumbers + 't>(
    all: impl IntoIterator<Item = &'t T>,
) -> Option<Vec<(Says, Num)>> {
    let mut all = all.into_iter().map(HasNumbers::parted);
    let (first, mut before) = (all.next()?, all.next()?);
    let slope = first.slope_to(&before)?;
    for next in all {
        if before.slope_to(&next)? != slope {
            return None;
        }
        before = next;
    }
    Some(slope)
}

impl HasNumbers for Term {
    fn each_leaf(&mut self, see: &mut dyn FnMut(Leaf)) {
        match self {
            Term::Name(name) => see(Leaf::Name(name)),
            Term::Part { name, low, width } => {
                see(Leaf::Name(name));
                see(Leaf::Number(Says::Place, low));
                see(Leaf::Number(Says::Size, width));
            }
            Term::Literal { width, .. } => see(Leaf::Number(Says::Size, width)),
            Term::Concat(parts) => parts.iter_mut().for_each(|part| part.each_leaf(see)),
            Term::Repeat { count, bit } => {
                see(Leaf::Number(Says::Size, count));
                bit.each_leaf(see);
            }
            Term::Lookup { table, index } => {
                see(Leaf::Name(table));
                index.each_leaf(see);
            }
            Term::Unary(_, operand) => operand.each_leaf(see),
            Term::Binary(_, left, right) => {
                left.each_leaf(see);
                right.each_leaf(see);
            }
            Term::Mux(parts) => parts.iter_mut().for_each(|part| part.each_leaf(see)),
        }
    }
}

impl<T: HasNumbers> HasNumbers for Vec<T> {
    fn each_leaf(&mut self, see: &mut dyn FnMut(Leaf)) {
        self.iter_mut().for_each(|inner| inner.each_leaf(see));
    }
}
