//! Sized expressions, kept in a normal form that prints as an engineer would
//! write it: slices of signals, concatenations, whole-vector operators.

use super::concat::{binary, concat, not, repeat, slice_of_parts};
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

    /// Bits `low ..= high` as an expression that Verilog can write.
    pub fn slice(&self, high: u32, low: u32) -> Result<Expr, Fault> {
        let width = self.width();
        if high >= width {
            return Err(Fault::OutOfRange { bit: high, width });
        }
        if low == 0 && high + 1 == width {
            return Ok(self.clone());
        }
        match self {
            Expr::Signal { id, .. } => Ok(Expr::Slice { id: *id, high, low }),
            Expr::Slice { id, low: base, .. } => Ok(Expr::Slice {
                id: *id,
                high: base + high,
                low: base + low,
            }),
            Expr::Literal { value, .. } => {
                let width = high - low + 1;
                let mask = u128::MAX >> (128 - width);
                Expr::literal((value >> low) & mask, width)
            }
            Expr::Concat(parts) => slice_of_parts(parts, high, low),
            Expr::Repeat { bit, .. } => Ok(repeat((**bit).clone(), high - low + 1)),
            Expr::Unary(UnaryOp::Not, operand) => Ok(not(operand.slice(high, low)?)),
            Expr::Binary(op, left, right)
                if op.is_bitwise() || (low == 0 && !op.is_comparison()) =>
            {
                // The low bits of a sum depend on the low bits of its operands.
                Ok(binary(*op, left.slice(high, low)?, right.slice(high, low)?))
            }
            Expr::Mux { test, yes, no } => Ok(Expr::Mux {
                test: test.clone(),
                yes: Box::new(yes.slice(high, low)?),
                no: Box::new(no.slice(high, low)?),
            }),
            _ => Err(Fault::Unsupported {
                construct: "a slice of a result that has no name".to_owned(),
            }),
        }
    }

    /// Zero-extended, or cut, to `width` bits.
    pub fn resize(self, width: u32) -> Result<Expr, Fault> {
        let own = self.width();
        if width == 0 {
            return Err(Fault::OutOfRange { bit: 0, width: 0 });
        }
        if width <= own {
            return self.slice(width - 1, 0);
        }
        Ok(concat(vec![Expr::zeros(width - own), self]))
    }

    /// Sign-extended to `width` bits.
    pub fn sign_extend(self, width: u32) -> Result<Expr, Fault> {
        let own = self.width();
        if width < own {
            return Err(Fault::WidthMismatch {
                place: "signed_cast".to_owned(),
                left: width,
                right: own,
            });
        }
        let sign = self.slice(own - 1, own - 1)?;
        if own == 1 {
            return Ok(repeat(sign, width));
        }
        Ok(concat(vec![repeat(sign, width - own), self]))
    }

    /// Shifted left by a constant.
    pub fn shift_left(self, bits: u32) -> Result<Expr, Fault> {
        let width = self.width();
        if bits == 0 {
            return Ok(self);
        }
        if bits >= width {
            return Ok(Expr::zeros(width));
        }
        Ok(concat(vec![
            self.slice(width - 1 - bits, 0)?,
            Expr::zeros(bits),
        ]))
    }

    /// Shifted right by a constant, zeros coming in.
    pub fn shift_right(self, bits: u32) -> Result<Expr, Fault> {
        let width = self.width();
        if bits == 0 {
            return Ok(self);
        }
        if bits >= width {
            return Ok(Expr::zeros(width));
        }
        Ok(concat(vec![
            Expr::zeros(bits),
            self.slice(width - 1, bits)?,
        ]))
    }

    /// With the bit at `index` replaced.
    pub fn replace_bit(self, index: u32, bit: Expr) -> Result<Expr, Fault> {
        let width = self.width();
        if index >= width {
            return Err(Fault::OutOfRange { bit: index, width });
        }
        let mut parts = Vec::new();
        if index + 1 < width {
            parts.push(self.slice(width - 1, index + 1)?);
        }
        parts.push(bit);
        if index > 0 {
            parts.push(self.slice(index - 1, 0)?);
        }
        Ok(concat(parts))
    }

    /// With `value_of` in the place of every signal that has one.
    pub fn replaced(&self, value_of: &impl Fn(SignalId) -> Option<Expr>) -> Result<Expr, Fault> {
        let boxed = |e: &Expr| e.replaced(value_of).map(Box::new);
        Ok(match self {
            Expr::Signal { id, .. } => value_of(*id).unwrap_or_else(|| self.clone()),
            Expr::Slice { id, high, low } => match value_of(*id) {
                Some(value) => value.slice(*high, *low)?,
                None => self.clone(),
            },
            Expr::Literal { .. } => self.clone(),
            Expr::Concat(parts) => {
                let parts: Result<_, _> = parts.iter().map(|p| p.replaced(value_of)).collect();
                concat(parts?)
            }
            Expr::Repeat { count, bit } => repeat(bit.replaced(value_of)?, *count),
            Expr::Lookup { table, index } => Expr::Lookup {
                table: *table,
                index: boxed(index)?,
            },
            Expr::Unary(op, operand) => Expr::Unary(*op, boxed(operand)?),
            Expr::Binary(op, left, right) => Expr::Binary(*op, boxed(left)?, boxed(right)?),
            Expr::Mux { test, yes, no } => Expr::Mux {
                test: boxed(test)?,
                yes: boxed(yes)?,
                no: boxed(no)?,
            },
        })
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
