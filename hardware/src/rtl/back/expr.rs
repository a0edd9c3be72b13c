//! Sized expressions, kept in a normal form that prints as an engineer would
//! write it: slices of signals, concatenations, whole-vector operators.

use super::fault::Fault;

/// Index of a signal in its module.
pub type SignalId = usize;

/// An expression with a width.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Expr {
    /// A whole signal or named constant.
    Signal {
        /// Which one.
        id: SignalId,
        /// Bits.
        width: u32,
    },
    /// Bits `low ..= high` of a signal.
    Slice {
        /// Which signal.
        id: SignalId,
        /// Most significant bit.
        high: u32,
        /// Least significant bit.
        low: u32,
    },
    /// A sized literal.
    Literal {
        /// Its value.
        value: u128,
        /// Bits.
        width: u32,
    },
    /// Parts side by side, most significant first.
    Concat(Vec<Expr>),
    /// One bit, many times.
    Repeat {
        /// How many times.
        count: u32,
        /// The bit.
        bit: Box<Expr>,
    },
    /// An entry of a table of single bits.
    Lookup {
        /// The table.
        table: SignalId,
        /// The entry's index.
        index: Box<Expr>,
    },
    /// Operator before one operand.
    Unary(UnaryOp, Box<Expr>),
    /// Operator between two operands.
    Binary(BinaryOp, Box<Expr>, Box<Expr>),
    /// `test ? yes : no`.
    Mux {
        /// A single bit.
        test: Box<Expr>,
        /// Value for 1.
        yes: Box<Expr>,
        /// Value for 0.
        no: Box<Expr>,
    },
}

/// Operators with one operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnaryOp {
    /// `~`
    Not,
    /// `&`, to one bit.
    All,
    /// `|`, to one bit.
    Any,
    /// `^`, to one bit.
    Parity,
}

/// Operators with two operands of equal width.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BinaryOp {
    /// `+`
    Add,
    /// `-`
    Sub,
    /// `&`
    And,
    /// `|`
    Or,
    /// `^`
    Xor,
    /// `==`, to one bit.
    Eq,
    /// `!=`, to one bit.
    Ne,
    /// `<`, to one bit.
    Lt,
    /// `<=`, to one bit.
    Le,
    /// `>`, to one bit.
    Gt,
    /// `>=`, to one bit.
    Ge,
}

impl BinaryOp {
    /// Whether every bit of the result depends on the operands' bits at the
    /// same place only.
    pub fn is_bitwise(self) -> bool {
        matches!(self, BinaryOp::And | BinaryOp::Or | BinaryOp::Xor)
    }

    /// Whether the result is one bit, whatever the operands' width.
    pub fn is_comparison(self) -> bool {
        matches!(
            self,
            BinaryOp::Eq | BinaryOp::Ne | BinaryOp::Lt | BinaryOp::Le | BinaryOp::Gt | BinaryOp::Ge
        )
    }
}

impl Expr {
    /// Bits of the value.
    pub fn width(&self) -> u32 {
        match self {
            Expr::Signal { width, .. } | Expr::Literal { width, .. } => *width,
            Expr::Slice { high, low, .. } => high - low + 1,
            Expr::Concat(parts) => parts.iter().map(Expr::width).sum(),
            Expr::Repeat { count, .. } => *count,
            Expr::Lookup { .. } => 1,
            Expr::Unary(UnaryOp::Not, operand) => operand.width(),
            Expr::Unary(..) => 1,
            Expr::Binary(op, left, _) => {
                if op.is_comparison() {
                    1
                } else {
                    left.width()
                }
            }
            Expr::Mux { yes, .. } => yes.width(),
        }
    }

    /// A literal, refused if it does not fit.
    pub fn literal(value: u128, width: u32) -> Result<Expr, Fault> {
        if width < 128 && value >> width != 0 {
            return Err(Fault::OversizeLiteral { value, width });
        }
        Ok(Expr::Literal { value, width })
    }

    pub(super) fn zeros(width: u32) -> Expr {
        Expr::Literal { value: 0, width }
    }

    /// Whether it is the literal 0.
    pub(super) fn is_zero(&self) -> bool {
        matches!(self, Expr::Literal { value: 0, .. })
    }

    /// Calls `visit` for every signal read.
    pub fn for_each_signal(&self, visit: &mut impl FnMut(SignalId)) {
        match self {
            Expr::Signal { id, .. } | Expr::Slice { id, .. } => visit(*id),
            Expr::Literal { .. } => {}
            Expr::Concat(parts) => parts.iter().for_each(|p| p.for_each_signal(visit)),
            Expr::Repeat { bit, .. } => bit.for_each_signal(visit),
            Expr::Lookup { table, index } => {
                visit(*table);
                index.for_each_signal(visit);
            }
            Expr::Unary(_, operand) => operand.for_each_signal(visit),
            Expr::Binary(_, left, right) => {
                left.for_each_signal(visit);
                right.for_each_signal(visit);
            }
            Expr::Mux { test, yes, no } => {
                test.for_each_signal(visit);
                yes.for_each_signal(visit);
                no.for_each_signal(visit);
            }
        }
    }
}

/// A statement of a kernel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Statement {
    /// Drives a whole signal.
    Assign {
        /// What is driven.
        target: SignalId,
        /// With what; as wide as the target.
        value: Expr,
    },
    /// One of two blocks.
    If {
        /// A single bit.
        test: Expr,
        /// Statements for 1.
        yes: Vec<Statement>,
        /// Statements for 0.
        no: Vec<Statement>,
    },
}

impl Statement {
    /// Calls `see` for every statement of a block and of the blocks within, in order.
    pub fn each<'s>(block: &'s [Statement], see: &mut dyn FnMut(&'s Statement)) {
        for statement in block {
            see(statement);
            if let Statement::If { yes, no, .. } = statement {
                Statement::each(yes, see);
                Statement::each(no, see);
            }
        }
    }

    /// The value of an assignment, or the test of an `if`.
    pub fn reads(&self) -> &Expr {
        match self {
            Statement::Assign { value, .. } => value,
            Statement::If { test, .. } => test,
        }
    }
}
