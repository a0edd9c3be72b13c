//! Rewriting a kernel into what `#[hdl_gen]` takes.

use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, format_ident, quote_spanned};
use syn::spanned::Spanned;
use syn::{
    BinOp, Block, Error, Expr, ExprAssign, ExprCall, ExprForLoop, ExprIf, ExprMethodCall, Ident,
    ImplItem, ImplItemFn, ItemImpl, Local, Member, Pat, Result, ReturnType, Stmt, UnOp,
    parse_quote, parse_quote_spanned,
};

use crate::elaboration::{Names, Time, reads_a_signal, time_of};

/// The `impl Logic` under `#[kernel]`, with its functions in place of their calls.
pub fn expand(arguments: TokenStream, item: TokenStream) -> Result<TokenStream> {
    if !arguments.is_empty() {
        return Err(Error::new_spanned(arguments, "`#[kernel]` takes nothing"));
    }
    let mut item: ItemImpl = syn::parse2(item)?;
    let mut update = rewrite(&item)?;
    update.attrs.push(parse_quote!(#[::rust_hdl_core::prelude::hdl_gen]));
    item.items = vec![ImplItem::Fn(update)];
    Ok(item.into_token_stream())
}

/// The function `update` of `item`, rewritten.
fn rewrite(item: &ItemImpl) -> Result<ImplItemFn> {
    let mut kernel = Kernel::default();
    for inner in &item.items {
        match inner {
            ImplItem::Fn(function) if is_plain(function) => kernel.functions.push(function.clone()),
            other => return refuse(other, "no function `fn name(&mut self)` of a kernel"),
        }
    }
    let update = Ident::new("update", item.span());
    let statements = kernel.function(&update)?;
    let is_unused = |f: &&ImplItemFn| !kernel.called.contains(&f.sig.ident);
    if let Some(unused) = kernel.functions.iter().find(is_unused) {
        return refuse(&unused.sig.ident, "never called");
    }
    let function = kernel.functions.iter().find(|f| f.sig.ident == update);
    let mut function = function.expect("found before").clone();
    function.block.stmts = statements;
    Ok(function)
}

/// Whether a function takes `&mut self` alone and gives nothing.
fn is_plain(function: &ImplItemFn) -> bool {
    let signature = &function.sig;
    signature.inputs.len() == 1
        && signature.receiver().is_some()
        && matches!(signature.output, ReturnType::Default)
}

#[derive(Default)]
struct Kernel {
    functions: Vec<ImplItemFn>,
    /// Functions whose bodies have been put in place.
    called: Vec<Ident>,
    /// Those around the present statement.
    open: Vec<Ident>,
    names: Names,
    /// Indices that become loops of one trip around the present statement.
    hoisted: Vec<(Ident, Expr)>,
    hoisted_before: usize,
}

impl Kernel {
    /// The body of the kernel's function `name`, which sees no name of its caller.
    fn function(&mut self, name: &Ident) -> Result<Vec<Stmt>> {
        let found = self.functions.iter().find(|f| f.sig.ident == *name);
        let Some(body) = found.map(|f| f.block.clone()) else {
            return refuse(name, "not a function of this kernel");
        };
        if self.open.contains(name) {
            return refuse(name, "called by itself");
        }
        self.open.push(name.clone());
        self.called.push(name.clone());
        let names = std::mem::take(&mut self.names);
        let statements = self.block(&body)?;
        self.names = names;
        self.open.pop();
        Ok(statements)
    }

    fn block(&mut self, block: &Block) -> Result<Vec<Stmt>> {
        let mark = self.names.mark();
        let mut statements = Vec::new();
        for statement in &block.stmts {
            match statement {
                Stmt::Local(local) => self.name(local)?,
                Stmt::Expr(expression, _) => statements.extend(self.statement(expression)?),
                _ => return refuse(statement, "no statement of a kernel"),
            }
        }
        self.names.forget(mark);
        Ok(statements)
    }

    fn name(&mut self, local: &Local) -> Result<()> {
        match (&local.pat, &local.init) {
            (Pat::Ident(name), Some(init))
                if init.diverge.is_none() && name.by_ref.is_none() && name.mutability.is_none() =>
            {
                self.names.add_let(&name.ident, &init.expr)
            }
            _ => refuse(local, "a `let` of another form than `let name = value;`"),
        }
    }

    fn statement(&mut self, expression: &Expr) -> Result<Vec<Stmt>> {
        match expression {
            Expr::Assign(assignment) => {
                let (assignment, loops) = self.hoisting(|k| k.assignment(assignment))?;
                Ok(vec![around(loops, parse_quote!(#assignment;))])
            }
            Expr::If(conditional) => self.conditional(conditional),
            Expr::ForLoop(repeated) => Ok(vec![self.repeated(repeated)?]),
            Expr::MethodCall(call)
                if call.args.is_empty()
                    && call.receiver.to_token_stream().to_string() == "self" =>
            {
                self.function(&call.method)
            }
            other => refuse(other, "no statement of a kernel"),
        }
    }

    fn assignment(&mut self, assignment: &ExprAssign) -> Result<ExprAssign> {
        let next = match &*assignment.left {
            Expr::Field(field) => matches!(&field.member, Member::Named(name) if name == "next"),
            _ => false,
        };
        if !next {
            return refuse(&assignment.left, "assigned without `.next`");
        }
        Ok(ExprAssign {
            left: Box::new(self.place(&assignment.left)?),
            right: Box::new(self.signal(&assignment.right)?),
            ..assignment.clone()
        })
    }

    fn repeated(&mut self, repeated: &ExprForLoop) -> Result<Stmt> {
        let (Pat::Ident(index), Expr::Range(range)) = (&*repeated.pat, &*repeated.expr) else {
            return refuse(repeated, "a loop of another form than `for j in from..to`");
        };
        let (Some(from), Some(to), syn::RangeLimits::HalfOpen(_)) =
            (&range.start, &range.end, &range.limits)
        else {
            return refuse(range, "a range of another form than `from..to`");
        };
        let from = self.bound(from)?;
        let to = self.bound(to)?;
        let mark = self.names.mark();
        self.names.add_loop(&index.ident)?;
        let body = self.block(&repeated.body)?;
        self.names.forget(mark);
        Ok(parse_quote!(for #index in (#from)..(#to) { #(#body)* }))
    }

    fn bound(&self, bound: &Expr) -> Result<Expr> {
        if reads_a_signal(bound) {
            return refuse(bound, "a loop's bound that reads a signal");
        }
        self.names.settled(bound, "a loop's bound")
    }

    fn conditional(&mut self, conditional: &ExprIf) -> Result<Vec<Stmt>> {
        match time_of(&conditional.cond)? {
            Time::Elaboration => self.generated(conditional),
            Time::Signal => {
                let (test, loops) = self.hoisting(|k| k.signal(&conditional.cond))?;
                let then = self.block(&conditional.then_branch)?;
                let mut chosen: ExprIf = parse_quote!(if #test { #(#then)* });
                if let Some((_, branch)) = &conditional.else_branch {
                    let otherwise = self.otherwise(branch)?;
                    let branch: Expr = match otherwise.as_slice() {
                        [Stmt::Expr(Expr::If(chained), _)] => Expr::If(chained.clone()),
                        statements => parse_quote!({ #(#statements)* }),
                    };
                    chosen.else_branch = Some((Default::default(), Box::new(branch)));
                }
                Ok(vec![around(loops, Stmt::Expr(Expr::If(chosen), None))])
            }
        }
    }

    /// A condition of elaboration: a loop of one trip or none for each branch.
    fn generated(&mut self, conditional: &ExprIf) -> Result<Vec<Stmt>> {
        let condition = self.names.settled(&conditional.cond, "this condition")?;
        // A condition that is not a `bool` is refused by the compiler, where it stands.
        let count = quote_spanned!(conditional.cond.span()=>
            <usize as ::core::convert::From<bool>>::from(#condition));
        let then = self.block(&conditional.then_branch)?;
        let mut statements = vec![parse_quote!(for _if in 0..(#count) { #(#then)* })];
        if let Some((_, branch)) = &conditional.else_branch {
            let otherwise = self.otherwise(branch)?;
            statements.push(parse_quote!(for _else in (#count)..1 { #(#otherwise)* }));
        }
        Ok(statements)
    }

    fn otherwise(&mut self, branch: &Expr) -> Result<Vec<Stmt>> {
        match branch {
            Expr::Block(block) => self.block(&block.block),
            Expr::If(chained) => self.conditional(chained),
            other => refuse(other, "no branch of an `if`"),
        }
    }

    /// What a signal is made of, in the hardware.
    fn signal(&mut self, expression: &Expr) -> Result<Expr> {
        let mut result = expression.clone();
        match &mut result {
            Expr::Lit(_) => {}
            Expr::Paren(inner) => *inner.expr = self.signal(&inner.expr)?,
            Expr::Unary(unary) if matches!(unary.op, UnOp::Not(_)) => {
                *unary.expr = self.signal(&unary.expr)?;
            }
            Expr::Binary(binary) if matches!(binary.op, BinOp::Shl(_) | BinOp::Shr(_)) => {
                *binary.left = self.signal(&binary.left)?;
                *binary.right = self.index(&binary.right)?;
            }
            Expr::Binary(binary) if is_translated(&binary.op) => {
                *binary.left = self.signal(&binary.left)?;
                *binary.right = self.signal(&binary.right)?;
            }
            Expr::MethodCall(call) => self.method(call)?,
            Expr::Call(call) => self.cast(call)?,
            Expr::Field(_) | Expr::Index(_) | Expr::Path(_) => {
                return refuse(expression, "no signal; read one by `.val()`");
            }
            other => return refuse(other, "nothing that hardware is made of"),
        }
        Ok(result)
    }

    fn method(&mut self, call: &mut ExprMethodCall) -> Result<()> {
        let arguments = call.args.len();
        match (call.method.to_string().as_str(), arguments) {
            ("val", 0) => *call.receiver = self.place(&call.receiver)?,
            ("all" | "any" | "xor" | "into", 0) => *call.receiver = self.signal(&call.receiver)?,
            ("get_bit", 1) => {
                *call.receiver = self.signal(&call.receiver)?;
                call.args[0] = self.index(&call.args[0])?;
            }
            ("replace_bit", 2) => {
                *call.receiver = self.signal(&call.receiver)?;
                call.args[0] = self.index(&call.args[0])?;
                call.args[1] = self.signal(&call.args[1])?;
            }
            _ => {
                return refuse(
                    &call.method,
                    "none of val(), get_bit(n), replace_bit(n, bit), all(), any(), xor() and \
                     into()",
                );
            }
        }
        Ok(())
    }

    /// `bit_cast(x, width)` or `signed_cast(x)`.
    fn cast(&mut self, call: &mut ExprCall) -> Result<()> {
        let name = call.func.to_token_stream().to_string();
        match (name.as_str(), call.args.len()) {
            ("signed_cast", 1) => call.args[0] = self.signal(&call.args[0])?,
            ("bit_cast", 2) => {
                let place = "what `bit_cast` takes";
                self.names.settled(&call.args[0], place)?;
                let before = self.hoisted.len();
                call.args[0] = self.signal(&call.args[0])?;
                if self.hoisted.len() > before {
                    return refuse(
                        &call.args[0],
                        "an index of a number that is not a literal in a `bit_cast`; give it a \
                         `Local` of its own",
                    );
                }
                call.args[1] = self.names.settled(&call.args[1], "the width of a `bit_cast`")?;
            }
            _ => {
                return refuse(
                    &call.func,
                    "neither bit_cast(x, width) nor signed_cast(x), the functions that kernels \
                     call",
                );
            }
        }
        Ok(())
    }

    /// A field of the block, or of what is in it.
    fn place(&mut self, expression: &Expr) -> Result<Expr> {
        let mut result = expression.clone();
        match &mut result {
            Expr::Path(path) if path.path.is_ident("self") => {}
            Expr::Field(field) => *field.base = self.place(&field.base)?,
            Expr::Index(element) => {
                *element.expr = self.place(&element.expr)?;
                *element.index = self.index(&element.index)?;
            }
            other => return refuse(other, "no field of `self`"),
        }
        Ok(result)
    }

    /// A bit position, a shift, or an index of a vector.
    fn index(&mut self, expression: &Expr) -> Result<Expr> {
        if reads_a_signal(expression) {
            return refuse(expression, "an index that reads a signal");
        }
        if matches!(expression, Expr::Lit(_)) {
            return Ok(expression.clone());
        }
        if self.names.loop_variable_in(expression).is_none() {
            let value = self.names.resolved(expression)?;
            return Ok(self.hoist(value, expression.span()));
        }
        let mut result = expression.clone();
        match &mut result {
            Expr::Path(_) => {}
            Expr::Paren(inner) => *inner.expr = self.index(&inner.expr)?,
            Expr::Binary(binary)
                if matches!(binary.op, BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_)) =>
            {
                *binary.left = self.index(&binary.left)?;
                *binary.right = self.index(&binary.right)?;
            }
            other => {
                return refuse(
                    other,
                    "no sum, difference or product, which is all that loop variables are good for",
                );
            }
        }
        Ok(result)
    }

    /// A loop variable of one value, for what rust-hdl takes no expression.
    fn hoist(&mut self, value: Expr, span: Span) -> Expr {
        let text = value.to_token_stream().to_string();
        let known =
            self.hoisted.iter().find(|(_, other)| other.to_token_stream().to_string() == text);
        let name = match known {
            Some((name, _)) => name.clone(),
            None => {
                self.hoisted_before += 1;
                let name = format_ident!("index{}", self.hoisted_before, span = span);
                self.hoisted.push((name.clone(), value));
                name
            }
        };
        parse_quote!(#name)
    }

    /// What `make` makes, and the indices that it needs loops for.
    fn hoisting<T>(
        &mut self,
        make: impl FnOnce(&mut Self) -> Result<T>,
    ) -> Result<(T, Vec<(Ident, Expr)>)> {
        let outer = std::mem::take(&mut self.hoisted);
        let made = make(self)?;
        Ok((made, std::mem::replace(&mut self.hoisted, outer)))
    }
}

fn around(loops: Vec<(Ident, Expr)>, statement: Stmt) -> Stmt {
    loops.into_iter().rev().fold(statement, |inner, (name, value)| {
        parse_quote_spanned!(value.span()=> for #name in (#value)..((#value) + 1) { #inner })
    })
}

fn is_translated(op: &BinOp) -> bool {
    matches!(
        op,
        BinOp::Add(_)
            | BinOp::Sub(_)
            | BinOp::And(_)
            | BinOp::Or(_)
            | BinOp::BitXor(_)
            | BinOp::BitAnd(_)
            | BinOp::BitOr(_)
            | BinOp::Eq(_)
            | BinOp::Lt(_)
            | BinOp::Le(_)
            | BinOp::Ne(_)
            | BinOp::Ge(_)
            | BinOp::Gt(_)
    )
}

fn refuse<T>(tokens: impl ToTokens, what: &str) -> Result<T> {
    let text = tokens.to_token_stream().to_string();
    let text = match text.char_indices().nth(60) {
        Some((end, _)) => format!("{} ...", &text[..end]),
        None => text,
    };
    Err(Error::new_spanned(tokens, format!("`{text}` is {what}")))
}

#[cfg(test)]
mod tests;
