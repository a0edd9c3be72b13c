//! `connect!`: parts of a block connected by the names of their ports.

use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Block, Expr, Ident, Member, Result, Stmt, Token, parse_quote};

/// `target from source: names`, or `shown: names`.
struct Connections {
    target: Expr,
    source: Expr,
    names: Vec<Ident>,
    /// Outputs of the block show signals of these names.
    are_shown: bool,
}

impl Parse for Connections {
    fn parse(input: ParseStream) -> Result<Connections> {
        let target: Expr = input.parse()?;
        let are_shown = input.peek(Token![:]);
        let source = match are_shown {
            true => target.clone(),
            false => {
                let from: Ident = input.parse()?;
                if from != "from" {
                    return Err(syn::Error::new_spanned(from, "write `part from other: ports`"));
                }
                input.parse()?
            }
        };
        input.parse::<Token![:]>()?;
        let names = Punctuated::<Ident, Token![,]>::parse_terminated(input)?.into_iter().collect();
        Ok(Connections { target, source, names, are_shown })
    }
}

impl Connections {
    /// An assignment for each name, where the hardware has what is driven.
    fn statements(&self) -> Vec<Stmt> {
        let (target, source) = (&self.target, &self.source);
        let is_own = is_block_itself(source);
        let connected = |name: &Ident| -> Stmt {
            let text = name.to_string();
            let (to, from) = match (self.are_shown, text.strip_prefix("i_")) {
                (true, _) => (Ident::new(&format!("o_{text}"), name.span()), name.clone()),
                (false, Some(port)) if !is_own => {
                    (name.clone(), Ident::new(&format!("o_{port}"), name.span()))
                }
                (false, _) => (name.clone(), name.clone()),
            };
            parse_quote! {
                if #target.#to.is_present() {
                    #target.#to.next = #source.#from.val();
                }
            }
        };
        self.names.iter().map(connected).collect()
    }
}

/// Whether a place is the block, or among its ports `self.io`.
fn is_block_itself(place: &Expr) -> bool {
    match place {
        Expr::Path(path) => path.path.is_ident("self"),
        Expr::Field(field) => match &field.member {
            Member::Named(name) if name == "io" => is_block_itself(&field.base),
            _ => matches!(&*field.base, Expr::Field(_)) && is_block_itself(&field.base),
        },
        _ => false,
    }
}

/// The statements with every `connect!` written out.
pub fn written_out(block: &Block) -> Result<Block> {
    let mut statements = Vec::new();
    for statement in &block.stmts {
        match statement {
            Stmt::Macro(call) if call.mac.path.is_ident("connect") => {
                let connections: Connections = call.mac.parse_body()?;
                statements.extend(connections.statements());
            }
            Stmt::Expr(expression, semicolon) => {
                statements.push(Stmt::Expr(in_branches(expression)?, *semicolon));
            }
            other => statements.push(other.clone()),
        }
    }
    Ok(Block { stmts: statements, ..block.clone() })
}

/// The same within loops and branches.
fn in_branches(expression: &Expr) -> Result<Expr> {
    let mut expression = expression.clone();
    match &mut expression {
        Expr::ForLoop(repeated) => repeated.body = written_out(&repeated.body)?,
        Expr::Block(block) => block.block = written_out(&block.block)?,
        Expr::If(conditional) => {
            conditional.then_branch = written_out(&conditional.then_branch)?;
            if let Some((_, otherwise)) = &mut conditional.else_branch {
                **otherwise = in_branches(otherwise)?;
            }
        }
        _ => {}
    }
    Ok(expression)
}

#[cfg(test)]
mod tests {
    use quote::{ToTokens, quote};

    use super::*;

    #[test]
    fn ports_are_connected_by_their_names() {
        let block: Block = parse_quote!({
            for a in 0..2 {
                connect! { self.adder[a] from self: i_row }
                connect! { self.adder[a] from self.control: i_go, i_half }
            }
            connect! { self from self.results: o_last }
            connect! { self: valid }
        });
        let expected: Block = parse_quote!({
            for a in 0..2 {
                if self.adder[a].i_row.is_present() {
                    self.adder[a].i_row.next = self.i_row.val();
                }
                if self.adder[a].i_go.is_present() {
                    self.adder[a].i_go.next = self.control.o_go.val();
                }
                if self.adder[a].i_half.is_present() {
                    self.adder[a].i_half.next = self.control.o_half.val();
                }
            }
            if self.o_last.is_present() {
                self.o_last.next = self.results.o_last.val();
            }
            if self.o_valid.is_present() {
                self.o_valid.next = self.valid.val();
            }
        });
        assert_eq!(
            written_out(&block).unwrap().to_token_stream().to_string(),
            quote!(#expected).to_string()
        );
    }
}
