//! Doc comments that end up in the Verilog: what stands beside a field, and a module's header.

use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, quote};
use syn::{Attribute, Error, Expr, ExprLit, Lit, Meta, Result};

/// The text of a line of a doc comment.
pub fn doc_line(attribute: &Attribute) -> Option<String> {
    match &attribute.meta {
        Meta::NameValue(meta) if meta.path.is_ident("doc") => match &meta.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value().trim().to_owned()),
            _ => None,
        },
        _ => None,
    }
}

/// The expression of a text, in which `{expression}` stands for what it is at elaboration.
pub fn text(text: &str) -> Result<TokenStream> {
    let (mut format, mut values) = (String::new(), Vec::<Expr>::new());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('{') {
        let mut depth = 1;
        let end = after.find(|c| {
            depth += i32::from(c == '{') - i32::from(c == '}');
            depth == 0
        });
        let end = end.ok_or_else(|| {
            Error::new(Span::call_site(), format!("`{text}` has a bracket without its other one"))
        })?;
        format += before;
        format += "{}";
        values.push(syn::parse_str(&after[..end])?);
        rest = &after[end + 1..];
    }
    if values.is_empty() {
        return Ok(text.to_token_stream());
    }
    format += rest;
    Ok(quote!(format!(#format, #(#values),*)))
}

/// A paragraph of a module's header.
#[derive(Default)]
struct Paragraph {
    /// Under which it stands there.
    when: Option<Expr>,
    /// Of a labelled fact, which is an item of a list.
    label: Option<String>,
    text: String,
}

/// A module's header from the doc comment of its block, as the calls that make it: the first
/// paragraph is the title, `- Label: text` a labelled fact, any other a note. `#[when(condition)]`
/// before a paragraph or a fact leaves it out where the condition does not hold.
pub fn header(module: &str, attributes: &[Attribute]) -> Result<TokenStream> {
    let mut paragraphs = vec![Paragraph::default()];
    for attribute in attributes {
        if attribute.path().is_ident("when") {
            paragraphs
                .push(Paragraph { when: Some(attribute.parse_args()?), ..Paragraph::default() });
            continue;
        }
        let Some(line) = doc_line(attribute) else { continue };
        let fact = line.strip_prefix("- ").and_then(|fact| fact.split_once(": "));
        let last = paragraphs.len() - 1;
        let is_begun = !paragraphs[last].text.is_empty();
        if is_begun && (line.is_empty() || fact.is_some()) {
            paragraphs.push(Paragraph::default());
        }
        let last = paragraphs.len() - 1;
        let Paragraph { label, text, .. } = &mut paragraphs[last];
        let words = match fact {
            Some((name, words)) => {
                *label = Some(name.to_owned());
                words
            }
            None => &line,
        };
        if !text.is_empty() {
            text.push(' ');
        }
        text.push_str(words);
    }
    paragraphs.retain(|paragraph| !paragraph.text.is_empty());
    let mut paragraphs = paragraphs.into_iter();
    let title = paragraphs.next().map_or_else(String::new, |title| title.text);
    let title = text(&title)?;
    let calls: Vec<TokenStream> =
        paragraphs.map(|paragraph| call(&paragraph)).collect::<Result<_>>()?;
    Ok(quote!(About::new(#module, #title) #(#calls)*))
}

fn call(Paragraph { when, label, text }: &Paragraph) -> Result<TokenStream> {
    let words = self::text(text)?;
    Ok(match (when, label) {
        (None, None) => quote!(.note(#words)),
        (Some(when), None) => quote!(.note_if(#when, #words)),
        (None, Some(label)) => quote!(.fact(#label, #words)),
        (Some(when), Some(label)) => quote!(.fact_if(#when, #label, #words)),
    })
}

#[cfg(test)]
mod tests {
    use syn::{ItemStruct, parse_quote};

    use super::*;

    #[test]
    fn expressions_stand_in_brackets() {
        let of = |words: &str| text(words).unwrap().to_string();
        assert_eq!(of("plain words"), quote!("plain words").to_string());
        let made = quote!(format!("{} rows of {} bins", plan.rows, if { n } { 1 } else { 2 }));
        assert_eq!(of("{plan.rows} rows of {if { n } { 1 } else { 2 }} bins"), made.to_string());
        assert!(text("{plan.rows rows").is_err());
    }

    #[test]
    fn a_header_has_title_notes_and_facts() {
        let block: ItemStruct = parse_quote! {
            /// rows
            /// of bins
            ///
            /// Why they
            /// are kept.
            #[when(n > 1)]
            /// There are {n}.
            ///
            /// - Rate: one a clock
            #[when(n > 2)]
            /// - Latency: {n}
            ///   clocks
            struct Rows;
        };
        let expected = quote! {
            About::new("rows", "rows of bins")
                .note("Why they are kept.")
                .note_if(n > 1, format!("There are {}.", n))
                .fact("Rate", "one a clock")
                .fact_if(n > 2, "Latency", format!("{} clocks", n))
        };
        assert_eq!(header("rows", &block.attrs).unwrap().to_string(), expected.to_string());
    }
}
