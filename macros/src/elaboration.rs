//! Which expressions read signals, and which are settled when the hardware is built.

use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use syn::{BinOp, Error, Expr, Result, UnOp};

/// When an expression is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Time {
    /// While the hardware is built.
    Elaboration,
    /// In the hardware.
    Signal,
}

/// When `condition` is evaluated; refuses one that mixes both times.
pub fn time_of(condition: &Expr) -> Result<Time> {
    let operands = operands(condition);
    let signals = operands.iter().filter(|e| reads_a_signal(e)).count();
    match operands.iter().find(|e| !reads_a_signal(e)) {
        None => Ok(Time::Signal),
        Some(_) if signals == 0 => Ok(Time::Elaboration),
        Some(settled) => Err(Error::new_spanned(
            settled,
            "this part of the condition reads no signal, but another part does; \
             write an `if` for each",
        )),
    }
}

/// Whether `.val()` stands anywhere in `expression`.
pub fn reads_a_signal(expression: &Expr) -> bool {
    fn has_val(tokens: TokenStream) -> bool {
        let mut after_dot = false;
        tokens.into_iter().any(|token| {
            let is_member = std::mem::replace(&mut after_dot, is_dot(&token));
            match token {
                TokenTree::Ident(name) => is_member && name == "val",
                TokenTree::Group(group) => has_val(group.stream()),
                _ => false,
            }
        })
    }
    has_val(expression.to_token_stream())
}

/// The parts of a condition that logical operators join.
fn operands(condition: &Expr) -> Vec<&Expr> {
    match condition {
        Expr::Paren(inner) => operands(&inner.expr),
        Expr::Unary(unary) if matches!(unary.op, UnOp::Not(_)) => operands(&unary.expr),
        Expr::Binary(binary)
            if matches!(
                binary.op,
                BinOp::And(_)
                    | BinOp::Or(_)
                    | BinOp::BitAnd(_)
                    | BinOp::BitOr(_)
                    | BinOp::BitXor(_)
            ) =>
        {
            let mut both = operands(&binary.left);
            both.extend(operands(&binary.right));
            both
        }
        other => vec![other],
    }
}

fn is_dot(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == '.')
}
