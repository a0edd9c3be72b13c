//! What is settled when the hardware is built: names, and which expressions read signals.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use quote::ToTokens;
use syn::{BinOp, Error, Expr, Ident, Result, UnOp};

/// When an expression is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Time {
    /// While the hardware is built.
    Elaboration,
    /// In the hardware.
    Signal,
}

/// What a name in a kernel stands for.
enum Meaning {
    /// The index of a loop.
    LoopVariable,
    /// The expression behind a `let`.
    Expression(TokenStream),
}

/// The names that are in scope.
#[derive(Default)]
pub struct Names {
    known: Vec<(Ident, Meaning)>,
}

impl Names {
    /// How many names are known; for [`Names::forget`].
    pub fn mark(&self) -> usize {
        self.known.len()
    }

    /// Leaves the scope that began at `mark`.
    pub fn forget(&mut self, mark: usize) {
        self.known.truncate(mark);
    }

    /// Adds the index of a loop.
    pub fn add_loop(&mut self, name: &Ident) -> Result<()> {
        self.add(name, Meaning::LoopVariable)
    }

    /// Adds what a `let` names.
    pub fn add_let(&mut self, name: &Ident, value: &Expr) -> Result<()> {
        if reads_a_signal(value) {
            return Err(Error::new_spanned(
                value,
                "`let` names what is settled at elaboration; what reads a signal by `.val()` \
                 needs a `Local` of the block",
            ));
        }
        let value = self.settled(value, "the value of a `let`")?;
        self.add(name, Meaning::Expression(value.into_token_stream()))
    }

    fn add(&mut self, name: &Ident, meaning: Meaning) -> Result<()> {
        if self.known.iter().any(|(known, _)| known == name) {
            return Err(Error::new(
                name.span(),
                format!("`{name}` is the name of something else here"),
            ));
        }
        self.known.push((name.clone(), meaning));
        Ok(())
    }

    fn meaning(&self, name: &Ident) -> Option<&Meaning> {
        let found = self.known.iter().find(|(known, _)| known == name)?;
        Some(&found.1)
    }

    /// `expression` with the values of `let`s in place of their names.
    pub fn resolved(&self, expression: &Expr) -> Result<Expr> {
        syn::parse2(self.substituted(expression.to_token_stream()))
    }

    /// The same for what must not depend on a loop; `place` says what it is.
    pub fn settled(&self, expression: &Expr, place: &str) -> Result<Expr> {
        if let Some(variable) = self.loop_variable_in(expression) {
            return Err(Error::new(
                variable.span(),
                format!(
                    "{place} cannot depend on the loop variable `{variable}`, because rust-hdl \
                     evaluates it outside of the loop"
                ),
            ));
        }
        self.resolved(expression)
    }

    /// A loop variable that `expression` names.
    pub fn loop_variable_in(&self, expression: &Expr) -> Option<Ident> {
        let mut found = None;
        each_name(expression.to_token_stream(), &mut |name| {
            if matches!(self.meaning(name), Some(Meaning::LoopVariable)) {
                found.get_or_insert(name.clone());
            }
        });
        found
    }

    fn substituted(&self, tokens: TokenStream) -> TokenStream {
        let mut after_dot = false;
        let mut result = TokenStream::new();
        for token in tokens {
            let is_member = std::mem::replace(&mut after_dot, is_dot(&token));
            match token {
                TokenTree::Ident(name) => match self.meaning(&name) {
                    Some(Meaning::Expression(value)) if !is_member => {
                        let group = Group::new(Delimiter::Parenthesis, value.clone());
                        result.extend([TokenTree::from(group)]);
                    }
                    _ => result.extend([TokenTree::from(name)]),
                },
                TokenTree::Group(group) => {
                    let mut inner = Group::new(group.delimiter(), self.substituted(group.stream()));
                    inner.set_span(group.span());
                    result.extend([TokenTree::from(inner)]);
                }
                other => result.extend([other]),
            }
        }
        result
    }
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

/// Calls `see` with every name that is not a member of something.
fn each_name(tokens: TokenStream, see: &mut dyn FnMut(&Ident)) {
    let mut after_dot = false;
    for token in tokens {
        let is_member = std::mem::replace(&mut after_dot, is_dot(&token));
        match token {
            TokenTree::Ident(name) if !is_member => see(&name),
            TokenTree::Group(group) => each_name(group.stream(), see),
            _ => {}
        }
    }
}

fn is_dot(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == '.')
}
