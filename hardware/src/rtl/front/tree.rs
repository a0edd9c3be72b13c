//! What `#[kernel]` makes of a kernel: statements and expressions of rust-hdl's syntax tree.

use rust_hdl_core::ast::{
    VerilogBlock, VerilogBlockOrConditional, VerilogConditional, VerilogExpression, VerilogLiteral,
    VerilogOp, VerilogOpUnary, VerilogStatement,
};

/// `signal.next = value`.
pub fn assigned(signal: String, value: VerilogExpression) -> VerilogStatement {
    VerilogStatement::Assignment(VerilogExpression::Signal(signal), value)
}

/// `if test { yes } else { no }`.
pub fn chosen(test: VerilogExpression, yes: VerilogBlock, no: VerilogBlock) -> VerilogStatement {
    let otherwise = VerilogBlockOrConditional::Block(no);
    VerilogStatement::If(VerilogConditional { test, then: yes, otherwise })
}

/// `signal.val()`.
pub fn signal(name: String) -> VerilogExpression {
    VerilogExpression::Signal(name)
}

/// A literal.
pub fn literal(value: impl Into<VerilogLiteral>) -> VerilogExpression {
    VerilogExpression::Literal(value.into())
}

/// A number of elaboration.
pub fn number(value: usize) -> VerilogExpression {
    literal(value as u64)
}

/// `!x`, `x.all()`, `x.any()`, `x.xor()`.
pub fn unary(op: VerilogOpUnary, operand: VerilogExpression) -> VerilogExpression {
    VerilogExpression::Unary(op, Box::new(operand))
}

/// `left op right`.
pub fn binary(
    left: VerilogExpression,
    op: VerilogOp,
    right: VerilogExpression,
) -> VerilogExpression {
    VerilogExpression::Binary(Box::new(left), op, Box::new(right))
}

/// `word.get_bit(place)`.
pub fn bit(word: VerilogExpression, place: usize) -> VerilogExpression {
    VerilogExpression::Index(Box::new(word), Box::new(number(place)))
}

/// `word.slice(low, width)`.
pub fn slice(word: VerilogExpression, low: usize, width: usize) -> VerilogExpression {
    VerilogExpression::Slice(Box::new(word), width, Box::new(number(low)))
}

/// `word.replace_bit(place, bit)`.
pub fn replaced(
    word: VerilogExpression,
    place: usize,
    bit: VerilogExpression,
) -> VerilogExpression {
    VerilogExpression::IndexReplace(Box::new(word), Box::new(number(place)), Box::new(bit))
}

/// `word.shifted_in(bit)`.
pub fn shifted_in(word: VerilogExpression, bit: VerilogExpression) -> VerilogExpression {
    replaced(binary(word, VerilogOp::Shl, number(1)), 0, bit)
}

/// `state.advanced(width, taps)`.
pub fn advanced(
    state: VerilogExpression,
    width: usize,
    taps: VerilogExpression,
) -> VerilogExpression {
    let feedback = unary(VerilogOpUnary::Xor, binary(state.clone(), VerilogOp::BitAnd, taps));
    replaced(binary(state, VerilogOp::Shr, number(1)), width - 1, feedback)
}

/// `signed_cast(word)`.
pub fn signed(word: VerilogExpression) -> VerilogExpression {
    VerilogExpression::Signed(Box::new(word))
}

/// `bit_cast(word, width)`.
pub fn cast(word: VerilogExpression, width: usize) -> VerilogExpression {
    VerilogExpression::Cast(Box::new(word), width)
}

/// `gather(width, |place| bit)`. The tree has no concatenation; zeros of which every bit is
/// replaced, under a cast that nothing else makes, stand for one.
pub fn gathered(width: usize, bit: impl Fn(usize) -> VerilogExpression) -> VerilogExpression {
    let zeros = cast(literal(false), width);
    let all = (0..width).fold(zeros, |word, place| replaced(word, place, bit(place)));
    VerilogExpression::Unsigned(Box::new(all))
}

/// The bits of [`gathered`], bit 0 first.
pub fn gathered_bits(mut word: &VerilogExpression) -> Vec<&VerilogExpression> {
    let mut bits = Vec::new();
    while let VerilogExpression::IndexReplace(below, _, bit) = word {
        bits.insert(0, &**bit);
        word = below;
    }
    bits
}

/// Statements of a bundle, whose signals its block has under the bundle's name.
pub fn within(bundle: &str, mut block: VerilogBlock) -> VerilogBlock {
    block.iter_mut().for_each(|statement| enter_statement(bundle, statement));
    block
}

fn enter_statement(bundle: &str, statement: &mut VerilogStatement) {
    match statement {
        VerilogStatement::Assignment(target, value) => {
            enter(bundle, target);
            enter(bundle, value);
        }
        VerilogStatement::If(VerilogConditional { test, then, otherwise }) => {
            enter(bundle, test);
            then.iter_mut().for_each(|inner| enter_statement(bundle, inner));
            if let VerilogBlockOrConditional::Block(block) = otherwise {
                block.iter_mut().for_each(|inner| enter_statement(bundle, inner));
            }
        }
        other => unreachable!("kernels make no {other:?}"),
    }
}

fn enter(bundle: &str, expression: &mut VerilogExpression) {
    match expression {
        VerilogExpression::Signal(name) => *name = format!("{bundle}${name}"),
        VerilogExpression::Literal(_) => {}
        VerilogExpression::Paren(inner)
        | VerilogExpression::Signed(inner)
        | VerilogExpression::Unsigned(inner)
        | VerilogExpression::Unary(_, inner)
        | VerilogExpression::Cast(inner, _) => enter(bundle, inner),
        VerilogExpression::Binary(left, _, right)
        | VerilogExpression::Index(left, right)
        | VerilogExpression::Slice(left, _, right) => {
            enter(bundle, left);
            enter(bundle, right);
        }
        VerilogExpression::IndexReplace(word, place, bit) => {
            [word, place, bit].into_iter().for_each(|part| enter(bundle, part));
        }
    }
}
