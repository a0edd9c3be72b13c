//! A kernel as rust-hdl simulates it, and the syntax tree of what it says.

use proc_macro2::TokenStream;
use quote::{ToTokens, format_ident, quote};
use syn::{
    BinOp, Block, Error, Expr, ExprCall, ExprIf, ExprMethodCall, Ident, ImplItem, ImplItemFn,
    ItemImpl, Member, Result, ReturnType, Stmt, UnOp,
};

use crate::connect::written_out;
use crate::elaboration::{Time, reads_a_signal, time_of};

/// The `impl Logic` of a block, or the plain `impl` of a bundle, under `#[kernel]`: each function
/// as it is, and one beside it that adds its statements to a tree.
pub fn expand(arguments: TokenStream, item: TokenStream) -> Result<TokenStream> {
    if !arguments.is_empty() {
        return Err(Error::new_spanned(arguments, "`#[kernel]` takes nothing"));
    }
    let item: ItemImpl = syn::parse2(item)?;
    let mut update = None;
    let (mut functions, mut trees) = (Vec::new(), Vec::new());
    for inner in &item.items {
        let ImplItem::Fn(function) = inner else {
            return refuse(inner, "no function of a kernel");
        };
        if !is_plain(function) {
            return refuse(function, "no function `fn name(&mut self, ..)` of a kernel");
        }
        let function = ImplItemFn { block: written_out(&function.block)?, ..function.clone() };
        trees.push(tree_of(&function)?);
        match function.sig.ident == "update" {
            true => update = Some(function),
            false => functions.push(function),
        }
    }
    let block = &item.self_ty;
    let logic = match (&item.trait_, update) {
        (Some((_, logic, _)), Some(update)) => Some(quote! {
            impl #logic for #block {
                #update

                fn hdl(&self) -> ast::Verilog {
                    let mut into = Vec::new();
                    self.update_tree(&mut into);
                    ast::Verilog::Combinatorial(into)
                }
            }
        }),
        (None, None) => None,
        (Some(_), None) => return refuse(block, "without a function `update`"),
        (None, Some(update)) => {
            return refuse(&update.sig, "no function of a bundle, which others call");
        }
    };
    Ok(quote! {
        #logic

        impl #block {
            #(#functions)*
            #(#trees)*
        }
    })
}

/// Whether a function takes `&mut self` and gives nothing.
fn is_plain(function: &ImplItemFn) -> bool {
    let signature = &function.sig;
    signature.receiver().is_some_and(|receiver| receiver.mutability.is_some())
        && matches!(signature.output, ReturnType::Default)
}

fn tree_of(function: &ImplItemFn) -> Result<TokenStream> {
    let (visibility, name) = (&function.vis, name_of_tree(&function.sig.ident));
    let numbers = function.sig.inputs.iter().skip(1);
    let statements = block(&function.block)?;
    Ok(quote! {
        #visibility fn #name(&self, into: &mut Vec<ast::VerilogStatement> #(, #numbers)*) { #statements }
    })
}

fn name_of_tree(function: &Ident) -> Ident {
    format_ident!("{function}_tree", span = function.span())
}

fn block(block: &Block) -> Result<TokenStream> {
    block.stmts.iter().map(statement).collect()
}

fn statement(statement: &Stmt) -> Result<TokenStream> {
    match statement {
        Stmt::Local(local) => {
            let value = local.init.as_ref().map(|init| &*init.expr);
            match value.filter(|value| reads_a_signal(value)) {
                None => Ok(local.into_token_stream()),
                Some(value) => Err(Error::new_spanned(
                    value,
                    "`let` names what is settled at elaboration; what reads a signal by `.val()` \
                     needs a `Local` of the block",
                )),
            }
        }
        Stmt::Expr(Expr::Assign(assignment), _) => {
            let next = match &*assignment.left {
                Expr::Field(field) if matches!(&field.member, Member::Named(n) if n == "next") => {
                    place(&field.base)?
                }
                other => return refuse(other, "assigned without `.next`"),
            };
            let value = signal(&assignment.right)?;
            Ok(quote!(into.push(tree::assigned(#next, #value));))
        }
        Stmt::Expr(Expr::If(conditional), _) => self::conditional(conditional),
        Stmt::Expr(Expr::ForLoop(repeated), _) => {
            if reads_a_signal(&repeated.expr) {
                return refuse(&repeated.expr, "a loop's bound that reads a signal");
            }
            let (index, range, body) = (&repeated.pat, &repeated.expr, block(&repeated.body)?);
            Ok(quote!(for #index in #range { #body }))
        }
        Stmt::Expr(Expr::MethodCall(call), _) if is_within_self(&call.receiver) => called(call),
        other => refuse(other, "no statement of a kernel"),
    }
}

/// Whether a place is the block, or in it.
fn is_within_self(place: &Expr) -> bool {
    match place {
        Expr::Path(path) => path.path.is_ident("self"),
        Expr::Field(field) => is_within_self(&field.base),
        Expr::Index(element) => is_within_self(&element.expr),
        _ => false,
    }
}

/// A function of the block, or of a bundle in it, whose signals then have its name before theirs.
fn called(call: &ExprMethodCall) -> Result<TokenStream> {
    let (receiver, function) = (&call.receiver, name_of_tree(&call.method));
    let numbers: Vec<&Expr> = call.args.iter().map(number).collect::<Result<_>>()?;
    if receiver.to_token_stream().to_string() == "self" {
        return Ok(quote!(self.#function(into #(, #numbers)*);));
    }
    let place = place(receiver)?;
    Ok(quote! {
        into.extend({
            let mut inner = Vec::new();
            { let into = &mut inner; #receiver.#function(into #(, #numbers)*); }
            tree::within(&#place, inner)
        });
    })
}

/// An `if` of elaboration stays one; of signals it is a multiplexer, whose branches are
/// written beside each other.
fn conditional(conditional: &ExprIf) -> Result<TokenStream> {
    let then = block(&conditional.then_branch)?;
    let (settled, test) = split(&conditional.cond);
    if let Some(settled) = settled {
        let None = conditional.else_branch else {
            return refuse(settled, "with a signal in the test of an `if` that has an `else`");
        };
        let test = signal(test)?;
        return Ok(quote! {
            if #settled {
                into.push({
                    let mut yes = Vec::new();
                    { let into = &mut yes; #then }
                    tree::chosen(#test, yes, Vec::new())
                });
            }
        });
    }
    let otherwise = match &conditional.else_branch {
        None => TokenStream::new(),
        Some((_, branch)) => match &**branch {
            Expr::Block(otherwise) => block(&otherwise.block)?,
            Expr::If(chained) => self::conditional(chained)?,
            other => return refuse(other, "no branch of an `if`"),
        },
    };
    match time_of(test)? {
        Time::Elaboration => Ok(quote!(if #test { #then } else { #otherwise })),
        Time::Signal => {
            let test = signal(test)?;
            Ok(quote! {
                into.push({
                    let (mut yes, mut no) = (Vec::new(), Vec::new());
                    { let into = &mut yes; #then }
                    { let into = &mut no; #otherwise }
                    tree::chosen(#test, yes, no)
                });
            })
        }
    }
}

/// What a condition says at elaboration before `&&`, and what in the hardware.
fn split(condition: &Expr) -> (Option<&Expr>, &Expr) {
    match condition {
        Expr::Binary(both)
            if matches!(both.op, BinOp::And(_))
                && !reads_a_signal(&both.left)
                && reads_a_signal(&both.right) =>
        {
            (Some(&both.left), &both.right)
        }
        other => (None, other),
    }
}

/// What a signal is made of, in the hardware.
fn signal(expression: &Expr) -> Result<TokenStream> {
    match expression {
        Expr::Lit(literal) => Ok(quote!(tree::literal(#literal))),
        Expr::Paren(inner) => signal(&inner.expr),
        Expr::Unary(unary) if matches!(unary.op, UnOp::Not(_)) => {
            let operand = signal(&unary.expr)?;
            Ok(quote!(tree::unary(ast::VerilogOpUnary::Not, #operand)))
        }
        Expr::Binary(binary) => {
            let Some(op) = operator(&binary.op) else {
                return refuse(binary, "nothing that hardware is made of");
            };
            let left = signal(&binary.left)?;
            let right = match binary.op {
                BinOp::Shl(_) | BinOp::Shr(_) => {
                    let number = number(&binary.right)?;
                    quote!(tree::number(#number))
                }
                _ => signal(&binary.right)?,
            };
            Ok(quote!(tree::binary(#left, ast::VerilogOp::#op, #right)))
        }
        Expr::MethodCall(call) => method(call),
        Expr::Call(call) => function(call),
        Expr::If(choice) if time_of(&choice.cond)? == Time::Elaboration => {
            let Some((_, otherwise)) = &choice.else_branch else {
                return refuse(choice, "a choice without an `else`");
            };
            let (test, then) = (&choice.cond, last(&choice.then_branch)?);
            let otherwise = match &**otherwise {
                Expr::Block(block) => last(&block.block)?,
                chained => signal(chained)?,
            };
            Ok(quote!(if #test { #then } else { #otherwise }))
        }
        Expr::Block(block) => last(&block.block),
        // A value of elaboration; a signal without `.val()` is refused by the compiler.
        Expr::Field(_) | Expr::Index(_) | Expr::Path(_) => Ok(quote!(tree::literal(#expression))),
        other => refuse(other, "nothing that hardware is made of"),
    }
}

/// The expression that a block ends with.
fn last(block: &Block) -> Result<TokenStream> {
    match block.stmts.as_slice() {
        [settled @ .., Stmt::Expr(expression, None)]
            if settled.iter().all(|statement| matches!(statement, Stmt::Local(_))) =>
        {
            let settled: TokenStream = settled.iter().map(statement).collect::<Result<_>>()?;
            let value = signal(expression)?;
            Ok(quote!({ #settled #value }))
        }
        _ => refuse(block, "more than `let`s and an expression"),
    }
}

fn method(call: &ExprMethodCall) -> Result<TokenStream> {
    let arguments: Vec<&Expr> = call.args.iter().collect();
    let unary = |op: TokenStream| {
        let operand = signal(&call.receiver)?;
        Ok(quote!(tree::unary(ast::VerilogOpUnary::#op, #operand)))
    };
    match (call.method.to_string().as_str(), arguments.as_slice()) {
        ("val", []) => {
            let place = place(&call.receiver)?;
            Ok(quote!(tree::signal(#place)))
        }
        ("into", []) => signal(&call.receiver),
        ("all", []) => unary(quote!(All)),
        ("any", []) => unary(quote!(Any)),
        ("xor", []) => unary(quote!(Xor)),
        ("get_bit", [place]) => {
            let (word, place) = (signal(&call.receiver)?, number(place)?);
            Ok(quote!(tree::bit(#word, #place)))
        }
        ("slice", [low, width]) => {
            let (word, low, width) = (signal(&call.receiver)?, number(low)?, number(width)?);
            Ok(quote!(tree::slice(#word, #low, #width)))
        }
        ("replace_bit", [place, bit]) => {
            let (word, place, bit) = (signal(&call.receiver)?, number(place)?, signal(bit)?);
            Ok(quote!(tree::replaced(#word, #place, #bit)))
        }
        ("shifted_in", [bit]) => {
            let (word, bit) = (signal(&call.receiver)?, signal(bit)?);
            Ok(quote!(tree::shifted_in(#word, #bit)))
        }
        ("advanced", [width, taps]) => {
            let (state, width, taps) = (signal(&call.receiver)?, number(width)?, signal(taps)?);
            Ok(quote!(tree::advanced(#state, #width, #taps)))
        }
        _ => refuse(
            &call.method,
            "none of val(), get_bit(n), slice(low, width), replace_bit(n, bit), shifted_in(bit), \
             advanced(width, taps), all(), any(), xor() and into()",
        ),
    }
}

/// A function that kernels call.
fn function(call: &ExprCall) -> Result<TokenStream> {
    let arguments: Vec<&Expr> = call.args.iter().collect();
    match (call.func.to_token_stream().to_string().as_str(), arguments.as_slice()) {
        ("signed_cast", [word]) => {
            let word = signal(word)?;
            Ok(quote!(tree::signed(#word)))
        }
        ("bit_cast", [word, width]) => {
            let (word, width) = (signal(word)?, number(width)?);
            Ok(quote!(tree::cast(#word, #width)))
        }
        ("gather", [width, Expr::Closure(closure)]) => {
            let (width, place, bit) = (number(width)?, &closure.inputs, signal(&closure.body)?);
            Ok(quote!(tree::gathered(#width, |#place| #bit)))
        }
        _ => refuse(
            &call.func,
            "none of bit_cast(x, width), signed_cast(x) and gather(width, |place| bit), the \
             functions that kernels call",
        ),
    }
}

/// A field of the block, or of what is in it, as the tree names it.
fn place(expression: &Expr) -> Result<TokenStream> {
    let (mut text, mut indices) = (String::new(), Vec::new());
    named(expression, &mut text, &mut indices)?;
    Ok(quote!(format!(#text, #(#indices),*)))
}

fn named<'e>(expression: &'e Expr, text: &mut String, indices: &mut Vec<&'e Expr>) -> Result<()> {
    match expression {
        Expr::Path(path) if path.path.is_ident("self") => Ok(()),
        Expr::Field(field) => {
            named(&field.base, text, indices)?;
            let separator = if text.is_empty() { "" } else { "$" };
            text.push_str(&format!("{separator}{}", field.member.to_token_stream()));
            Ok(())
        }
        Expr::Index(element) => {
            named(&element.expr, text, indices)?;
            text.push_str("${}");
            indices.push(number(&element.index)?);
            Ok(())
        }
        other => refuse(other, "no field of `self`"),
    }
}

/// A width, a bit position, a shift, or an index of a vector.
fn number(expression: &Expr) -> Result<&Expr> {
    match expression {
        Expr::Paren(inner) => number(&inner.expr),
        _ if reads_a_signal(expression) => refuse(expression, "a number that reads a signal"),
        _ => Ok(expression),
    }
}

fn operator(op: &BinOp) -> Option<Ident> {
    let name = match op {
        BinOp::Add(_) => "Add",
        BinOp::Sub(_) => "Sub",
        BinOp::And(_) => "LogicalAnd",
        BinOp::Or(_) => "LogicalOr",
        BinOp::BitXor(_) => "BitXor",
        BinOp::BitAnd(_) => "BitAnd",
        BinOp::BitOr(_) => "BitOr",
        BinOp::Shl(_) => "Shl",
        BinOp::Shr(_) => "Shr",
        BinOp::Eq(_) => "Eq",
        BinOp::Lt(_) => "Lt",
        BinOp::Le(_) => "Le",
        BinOp::Ne(_) => "Ne",
        BinOp::Ge(_) => "Ge",
        BinOp::Gt(_) => "Gt",
        _ => return None,
    };
    Some(format_ident!("{name}"))
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
