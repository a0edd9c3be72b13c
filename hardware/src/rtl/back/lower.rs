//! From rust-hdl's syntax tree to sized expressions: names resolved, every literal given its width.

use std::collections::HashSet;

use rust_hdl_core::ast::{
    VerilogBlock, VerilogBlockOrConditional, VerilogConditional, VerilogExpression, VerilogOp,
    VerilogOpUnary, VerilogStatement,
};

use super::concat::{binary, concat, concat_bits, not};
use super::expr::{BinaryOp, Expr, SignalId, Statement, UnaryOp};
use super::fault::Fault;
use super::scope::{literal_value, literal_width};
use super::signals::ModuleNames;
use crate::rtl::front::tree::gathered_bits;

/// Lowers a kernel.
pub fn lower(kernel: &VerilogBlock, names: &ModuleNames) -> Result<Vec<Statement>, Fault> {
    let mut statements = Vec::new();
    Lowering { names }.block(kernel, &mut statements)?;
    Ok(statements)
}

/// Signals whose value a kernel gathers bit by bit.
pub fn gathered(kernel: &VerilogBlock, names: &ModuleNames) -> Result<HashSet<SignalId>, Fault> {
    let mut found = HashSet::new();
    for statement in kernel {
        if let VerilogStatement::Assignment(target, VerilogExpression::Unsigned(_)) = statement
            && let VerilogExpression::Signal(name) = target
        {
            found.insert(Lowering { names }.find(name, "d")?);
        }
    }
    Ok(found)
}

struct Lowering<'a> {
    names: &'a ModuleNames,
}

fn unsupported<T>(construct: &str) -> Result<T, Fault> {
    Err(Fault::Unsupported { construct: construct.to_owned() })
}

impl Lowering<'_> {
    fn block(&self, block: &VerilogBlock, out: &mut Vec<Statement>) -> Result<(), Fault> {
        for statement in block {
            match statement {
                VerilogStatement::Assignment(target, value) => {
                    let assignment = self.assignment(target, value)?;
                    out.push(assignment);
                }
                VerilogStatement::If(conditional) => {
                    let conditional = self.conditional(conditional)?;
                    out.push(conditional);
                }
                _ => return unsupported("a statement that is neither an assignment nor an `if`"),
            }
        }
        Ok(())
    }

    fn assignment(
        &self,
        target: &VerilogExpression,
        value: &VerilogExpression,
    ) -> Result<Statement, Fault> {
        let VerilogExpression::Signal(name) = target else {
            return unsupported("an assignment to an expression");
        };
        let target = self.find(name, "d")?;
        let signal = &self.names.signals[target];
        let value = self.expression(value, Some(signal.width))?;
        equal_widths(&format!("`{}`", signal.name), signal.width, value.width())?;
        Ok(Statement::Assign { target, value })
    }

    fn conditional(&self, conditional: &VerilogConditional) -> Result<Statement, Fault> {
        let test = self.expression(&conditional.test, Some(1))?;
        equal_widths("the test of an `if`", 1, test.width())?;
        let mut yes = Vec::new();
        self.block(&conditional.then, &mut yes)?;
        let mut no = Vec::new();
        match &conditional.otherwise {
            VerilogBlockOrConditional::Block(block) => self.block(block, &mut no)?,
            VerilogBlockOrConditional::Conditional(statement) => {
                self.block(&vec![(**statement).clone()], &mut no)?;
            }
            VerilogBlockOrConditional::None => {}
        }
        Ok(match (yes.is_empty(), test) {
            // What is left of it is its `else`.
            (true, Expr::Unary(UnaryOp::Not, test)) => {
                Statement::If { test: *test, yes: no, no: Vec::new() }
            }
            (true, test) => Statement::If { test: not(test), yes: no, no: Vec::new() },
            (false, test) => Statement::If { test, yes, no },
        })
    }

    /// `want` is the width of the context, which bare literals and
    /// `signed_cast` take.
    fn expression(&self, e: &VerilogExpression, want: Option<u32>) -> Result<Expr, Fault> {
        match e {
            VerilogExpression::Literal(literal) => {
                let Some(value) = literal_value(literal) else {
                    return unsupported("a negative literal");
                };
                match if literal_width(literal) == 1 { Some(1) } else { want } {
                    Some(width) => Expr::literal(value, width),
                    None => Err(Fault::NoWidth { expression: format!("literal {value}") }),
                }
            }
            VerilogExpression::Signal(name) => {
                let id = self.find(name, "q")?;
                let width = self.names.signals[id].width;
                Ok(Expr::Signal { id, width })
            }
            VerilogExpression::Paren(inner) => self.expression(inner, want),
            VerilogExpression::Cast(inner, width) => {
                let width = *width as u32;
                if self.is_flexible(inner) {
                    return self.expression(inner, Some(width));
                }
                self.expression(inner, None)?.resize(width)
            }
            VerilogExpression::Signed(inner) => match want {
                Some(width) => self.expression(inner, None)?.sign_extend(width),
                None => Err(Fault::NoWidth { expression: "signed_cast".to_owned() }),
            },
            VerilogExpression::Binary(left, op, right) => self.binary(left, op, right, want),
            VerilogExpression::Unary(op, operand) => self.unary(op, operand, want),
            VerilogExpression::Index(base, index) => {
                let index = self.constant(index)?;
                self.expression(base, None)?.slice(index, index)
            }
            VerilogExpression::IndexReplace(base, index, bit) => {
                let index = self.constant(index)?;
                let bit = self.expression(bit, Some(1))?;
                equal_widths("replace_bit", 1, bit.width())?;
                self.expression(base, want)?.replace_bit(index, bit)
            }
            VerilogExpression::Slice(base, width, offset) => {
                let low = self.constant(offset)?;
                self.expression(base, None)?.slice(low + (*width).max(1) as u32 - 1, low)
            }
            VerilogExpression::Unsigned(gathered) => {
                let bit = |bit| {
                    let bit = self.expression(bit, Some(1))?;
                    equal_widths("gather", 1, bit.width())?;
                    Ok(bit)
                };
                let bits: Result<_, _> =
                    gathered_bits(gathered).into_iter().rev().map(bit).collect();
                Ok(match concat_bits(bits?) {
                    Expr::Slice { id, high, low: 0 }
                        if high + 1 == self.names.signals[id].width =>
                    {
                        Expr::Signal { id, width: high + 1 }
                    }
                    value => value,
                })
            }
        }
    }

    fn binary(
        &self,
        left: &VerilogExpression,
        op: &VerilogOp,
        right: &VerilogExpression,
        want: Option<u32>,
    ) -> Result<Expr, Fault> {
        if matches!(op, VerilogOp::Shl | VerilogOp::Shr) {
            let bits = self.constant(right)?;
            let left = self.expression(left, want)?;
            return if matches!(op, VerilogOp::Shl) {
                left.shift_left(bits)
            } else {
                left.shift_right(bits)
            };
        }
        let op = match op {
            VerilogOp::Add => BinaryOp::Add,
            VerilogOp::Sub => BinaryOp::Sub,
            VerilogOp::BitAnd | VerilogOp::LogicalAnd => BinaryOp::And,
            VerilogOp::BitOr | VerilogOp::LogicalOr => BinaryOp::Or,
            VerilogOp::BitXor => BinaryOp::Xor,
            VerilogOp::Eq => BinaryOp::Eq,
            VerilogOp::Ne => BinaryOp::Ne,
            VerilogOp::Lt => BinaryOp::Lt,
            VerilogOp::Le => BinaryOp::Le,
            VerilogOp::Gt => BinaryOp::Gt,
            VerilogOp::Ge => BinaryOp::Ge,
            VerilogOp::Mul | VerilogOp::Shl | VerilogOp::Shr => {
                return unsupported("a multiplication");
            }
        };
        let context = if op.is_comparison() { None } else { want };
        let (a, b) = match (self.is_flexible(left), self.is_flexible(right)) {
            (true, false) => {
                let b = self.expression(right, None)?;
                (self.expression(left, Some(b.width()))?, b)
            }
            (false, true) => {
                let a = self.expression(left, None)?;
                let b = self.expression(right, Some(a.width()))?;
                (a, b)
            }
            (true, true) => (self.expression(left, context)?, self.expression(right, context)?),
            (false, false) => (self.expression(left, None)?, self.expression(right, None)?),
        };
        equal_widths(&format!("operator {op:?}"), a.width(), b.width())?;
        Ok(binary(op, a, b))
    }

    fn unary(
        &self,
        op: &VerilogOpUnary,
        operand: &VerilogExpression,
        want: Option<u32>,
    ) -> Result<Expr, Fault> {
        let op = match op {
            VerilogOpUnary::Not => {
                let context = want.filter(|_| self.is_flexible(operand));
                return Ok(not(self.expression(operand, context)?));
            }
            VerilogOpUnary::All => UnaryOp::All,
            VerilogOpUnary::Any => UnaryOp::Any,
            VerilogOpUnary::Xor => UnaryOp::Parity,
            VerilogOpUnary::Neg => return unsupported("unary minus"),
        };
        let operand = match (op, self.expression(operand, None)?) {
            // Zeros change neither.
            (UnaryOp::Any | UnaryOp::Parity, Expr::Concat(mut parts)) => {
                parts.retain(|part| !part.is_zero());
                concat(parts)
            }
            (_, operand) => operand,
        };
        Ok(if operand.width() == 1 { operand } else { Expr::Unary(op, Box::new(operand)) })
    }

    /// Whether an expression takes its width from its context.
    fn is_flexible(&self, e: &VerilogExpression) -> bool {
        match e {
            VerilogExpression::Literal(literal) => literal_width(literal) != 1,
            VerilogExpression::Signed(_) => true,
            VerilogExpression::Paren(inner) => self.is_flexible(inner),
            VerilogExpression::Binary(left, _, right) => {
                self.is_flexible(left) && self.is_flexible(right)
            }
            VerilogExpression::Unary(VerilogOpUnary::Not, inner) => self.is_flexible(inner),
            _ => false,
        }
    }

    /// A bit position or a shift.
    fn constant(&self, e: &VerilogExpression) -> Result<u32, Fault> {
        let value = match e {
            VerilogExpression::Literal(literal) => literal_value(literal),
            _ => None,
        };
        match value.and_then(|value| u32::try_from(value).ok()) {
            Some(value) => Ok(value),
            None => unsupported("a bit position that is not a number of 32 bits"),
        }
    }

    /// A signal; of a register the pin that is driven, or read.
    fn find(&self, name: &str, pin: &str) -> Result<SignalId, Fault> {
        let found = self.names.find(name).or_else(|| self.names.find(&format!("{name}${pin}")));
        found.ok_or_else(|| Fault::UnknownName { name: name.to_owned() })
    }
}

fn equal_widths(place: &str, left: u32, right: u32) -> Result<(), Fault> {
    if left == right {
        return Ok(());
    }
    Err(Fault::WidthMismatch { place: place.to_owned(), left, right })
}
