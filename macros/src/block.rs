//! A block's constructor from its fields.

use std::collections::BTreeMap;

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::parse::{Parse, ParseStream};
use syn::spanned::Spanned;
use syn::{
    Attribute, Error, Expr, Field, Fields, GenericArgument, Ident, ItemStruct, Lit, PathArguments,
    PathSegment, Result, Token, Type, parse_quote,
};

use crate::text::{doc_line, header, text};

/// The struct under `#[block(module)]`, or a bundle of ports under `#[block]`, with its constructor.
pub fn expand(about: TokenStream, item: TokenStream) -> Result<TokenStream> {
    let is_bundle = about.is_empty();
    let mut item: ItemStruct = syn::parse2(item)?;
    let about = match is_bundle {
        true => TokenStream::new(),
        false => syn::parse2::<Description>(about)?.with_header(&item.attrs)?,
    };
    item.attrs.retain(|attribute| !attribute.path().is_ident("when"));
    let Fields::Named(fields) = &mut item.fields else {
        return Err(Error::new_spanned(&item, "a block's fields have names"));
    };
    let (mut parameters, mut values, mut parts) = (Vec::new(), Vec::new(), Vec::new());
    let (mut inputs, mut shown) = (Vec::new(), None);
    let (mut arguments, mut sizes) = (Vec::new(), Vec::new());
    let mut section = Section::default();
    for field in &mut fields.named {
        let name = field.ident.clone().expect("named fields");
        let ty = &field.ty.clone();
        let mut words = Words::taken_from(field)?;
        if words.attributes.remove("shown").is_some() {
            shown = Some((name.clone(), ty.clone()));
        }
        let under = words.take("under")?;
        words.heading = section.heading(ty, under);
        if words.has("given") {
            parameters.push(quote!(#name: #ty));
            arguments.push(name.clone());
            parts.push(name);
            continue;
        }
        if words.is_of_parameter(ty) {
            parameters.push(quote!(#name: #ty));
            arguments.push(name.clone());
            let takes = words.take::<Expr>("size")?;
            sizes.extend(takes.map(|takes| (name, words.doc, takes)));
        } else if let Some(value) = words.take::<Expr>("set")? {
            values.push(quote!(let #name: #ty = #value;));
        } else {
            let part = words.part(ty)?;
            if is_input(ty) {
                inputs.push(name.clone());
            }
            values.push(quote!(let #name = #part;));
            parts.push(name);
            continue;
        }
        // The constructor may be all that asks for it.
        field.attrs.push(parse_quote!(#[allow(dead_code)]));
    }
    if !is_bundle {
        fields.named.push(parse_quote!(about: About));
        parts.push(parse_quote!(about));
    }
    let names: Vec<_> = fields.named.iter().filter_map(|field| field.ident.clone()).collect();
    let block = &item.ident;
    let visibility = &item.vis;
    let sizes =
        sizes.into_iter().map(|(name, doc, takes)| size(block, &arguments, &name, &doc, &takes));
    let sizes: TokenStream = sizes.collect();
    let [start, end] = match is_bundle {
        false => [quote!(visit_start_scope), quote!(visit_end_scope)],
        true => [quote!(visit_start_namespace), quote!(visit_end_namespace)],
    };
    let logic = is_bundle.then(|| quote!(impl Logic for #block { fn update(&mut self) {} }));
    let about = (!is_bundle).then(|| quote!(let about = #about #sizes;));
    let passed_on = shown.as_ref().map(|(bundle, _)| quote!(self.#bundle.set(port, value);));
    let shown = shown.map(|(bundle, ty)| shown_bundle(block, &bundle, &ty));
    Ok(quote! {
        #[derive(Debug, Clone)]
        #item

        #shown

        impl #block {
            /// The block of these numbers.
            #visibility fn new(#(#parameters),*) -> #block {
                #(#values)*
                #about
                #block { #(#names),* }
            }
        }

        #logic

        impl BlockInputs for #block {
            fn set(&mut self, port: &str, value: u128) {
                let _ = (port, value);
                #(self.#inputs.set_if(stringify!(#inputs), port, value);)*
                #passed_on
            }
        }

        impl Block for #block {
            fn connect_all(&mut self) {}

            fn update_all(&mut self) {
                self.update();
                #(self.#parts.update_all();)*
            }

            fn has_changed(&self) -> bool {
                #(self.#parts.has_changed())||*
            }

            fn accept(&self, name: &str, probe: &mut dyn probe::Probe) {
                probe.#start(name, self);
                #(self.#parts.accept(stringify!(#parts), probe);)*
                probe.#end(name, self);
            }
        }
    })
}

/// What describes a block: its module's name, with more calls behind the header that its doc comment
/// makes; or an expression for all of it.
struct Description {
    module: Option<Ident>,
    rest: TokenStream,
}

impl Parse for Description {
    fn parse(input: ParseStream) -> Result<Description> {
        let is_name = |after: ParseStream| {
            after.parse::<Ident>().is_ok() && (after.is_empty() || after.peek(Token![,]))
        };
        let module = match is_name(&input.fork()) {
            true => Some(input.parse()?),
            false => None,
        };
        if module.is_some() && !input.is_empty() {
            input.parse::<Token![,]>()?;
        }
        Ok(Description { module, rest: input.parse()? })
    }
}

impl Description {
    fn with_header(self, attributes: &[Attribute]) -> Result<TokenStream> {
        let rest = self.rest;
        match self.module {
            Some(module) => {
                header(&module.to_string(), attributes).map(|header| quote!(#header #rest))
            }
            None => Ok(rest),
        }
    }
}

/// A parameter in which instances may differ, and the same block with another one.
fn size(block: &Ident, arguments: &[Ident], name: &Ident, doc: &str, takes: &Expr) -> TokenStream {
    let parameter = name.to_string().to_uppercase();
    let others = arguments.iter().filter(|argument| *argument != name);
    quote! {
        .size((#parameter, #doc), #name, #takes, {
            #(let #others = Clone::clone(&#others);)*
            move |#name| #block::new(#(Clone::clone(&#arguments)),*)
        })
    }
}

/// The names in a bundle are the block's own.
fn shown_bundle(block: &Ident, bundle: &Ident, ty: &Type) -> TokenStream {
    quote! {
        impl std::ops::Deref for #block {
            type Target = #ty;
            fn deref(&self) -> &#ty {
                &self.#bundle
            }
        }

        impl std::ops::DerefMut for #block {
            fn deref_mut(&mut self) -> &mut #ty {
                &mut self.#bundle
            }
        }
    }
}

/// The heading over ports, or over constants, that follow one another.
#[derive(Default)]
struct Section {
    kind: Option<Listed>,
    heading: Option<Expr>,
}

/// What is listed under headings.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Listed {
    Port,
    Constant,
}

impl Section {
    /// The heading of a field, which may have its own; an empty one ends a section.
    fn heading(&mut self, ty: &Type, own: Option<Expr>) -> Option<Expr> {
        let kind = listed(ty);
        if own.is_some() || kind != self.kind {
            *self = Section { kind, heading: own.filter(|heading| !is_empty(heading)) };
        }
        self.heading.clone()
    }
}

/// Whether a part is a port or a constant, or some of them.
fn listed(ty: &Type) -> Option<Listed> {
    let segment = last_segment(ty).ok()?;
    match segment.ident.to_string().as_str() {
        "Input" | "Output" => Some(Listed::Port),
        "Constant" => Some(Listed::Constant),
        "Optional" | "Vec" => argument(segment).ok().and_then(listed),
        _ => None,
    }
}

fn is_empty(heading: &Expr) -> bool {
    let Expr::Lit(literal) = heading else { return false };
    matches!(&literal.lit, Lit::Str(text) if text.value().is_empty())
}

/// The attributes of a field that are the macro's own.
const WORDS: [&str; 14] = [
    "about", "each", "given", "is", "named", "number", "reset", "set", "shown", "size", "under",
    "value", "when", "width",
];

/// What stands beside a field.
#[derive(Default)]
struct Words {
    doc: String,
    /// Whether the comment is the first one's of a row of like signals.
    is_of_first: bool,
    /// What holds for it of those above it.
    heading: Option<Expr>,
    /// Those of [`WORDS`] that nothing has taken yet.
    attributes: BTreeMap<String, Attribute>,
}

/// `#[reset(value)]` or `#[reset(value, constant)]`.
struct Reset {
    value: Expr,
    constant: Option<Ident>,
}

impl Parse for Reset {
    fn parse(input: ParseStream) -> Result<Reset> {
        let value = input.parse()?;
        let constant = match input.parse::<Option<Token![,]>>()? {
            Some(_) => Some(input.parse()?),
            None => None,
        };
        Ok(Reset { value, constant })
    }
}

/// `#[each(name in numbers)]`.
struct Each {
    name: Ident,
    numbers: Expr,
}

impl Parse for Each {
    fn parse(input: ParseStream) -> Result<Each> {
        let name = input.parse()?;
        input.parse::<Token![in]>()?;
        let numbers = input.parse()?;
        Ok(Each { name, numbers })
    }
}

impl Words {
    /// Takes the attributes off that are the macro's own.
    fn taken_from(field: &mut Field) -> Result<Words> {
        let mut words = Words::default();
        for attribute in std::mem::take(&mut field.attrs) {
            if let Some(line) = doc_line(&attribute) {
                if !words.doc.is_empty() {
                    words.doc.push(' ');
                }
                words.doc.push_str(&line);
            }
            match attribute.path().get_ident().map(Ident::to_string) {
                Some(name) if WORDS.contains(&name.as_str()) => {
                    words.attributes.insert(name, attribute);
                }
                _ => field.attrs.push(attribute),
            }
        }
        Ok(words)
    }

    /// Whether a word stands there.
    fn has(&self, word: &str) -> bool {
        self.attributes.contains_key(word)
    }

    /// What a word says, if it stands there.
    fn take<T: Parse>(&mut self, word: &str) -> Result<Option<T>> {
        self.attributes.remove(word).map(|attribute| attribute.parse_args()).transpose()
    }

    /// What a word says, without which there is no such part.
    fn needed(&mut self, word: &str, says: &str, at: impl ToTokens) -> Result<Expr> {
        self.take(word)?.ok_or_else(|| {
            let part = at.to_token_stream();
            Error::new_spanned(&at, format!("a `{part}` needs `#[{word}({says})]`"))
        })
    }

    /// Whether nothing says how the field is made, and its type is none of a part.
    fn is_of_parameter(&self, ty: &Type) -> bool {
        const PARTS: [&str; 7] =
            ["Input", "Output", "Local", "Register", "Constant", "Optional", "Memory"];
        let is_part = PARTS.iter().any(|part| last_segment(ty).is_ok_and(|s| s.ident == part));
        !is_part && !["is", "set", "each"].iter().any(|word| self.has(word))
    }

    /// The expression that makes a part of type `ty`.
    fn part(mut self, ty: &Type) -> Result<TokenStream> {
        let segment = last_segment(ty)?;
        let part = match segment.ident.to_string().as_str() {
            _ if self.has("is") && !self.has("when") && !self.has("each") => {
                self.needed("is", "expression", ty)?.into_token_stream()
            }
            "Optional" => {
                let when = self.needed("when", "condition", ty)?;
                let part = self.part(argument(segment)?)?;
                return Ok(quote!(Optional::new(if #when { Some(#part) } else { None })));
            }
            "Vec" if self.has("each") => {
                let Each { name, numbers } = self.take("each")?.expect("it has one");
                self.is_of_first = !self.doc.is_empty() && !self.has("about") && !self.has("is");
                let is_of_first = self.is_of_first;
                let part = self.part(argument(segment)?)?;
                return Ok(match is_of_first {
                    true => quote!((#numbers).enumerate().map(|(nth, #name)| #part).collect()),
                    false => quote!((#numbers).map(|#name| #part).collect()),
                });
            }
            "Input" | "Output" | "Local" => self.net(segment)?,
            "Register" => self.register(segment)?,
            "Constant" => {
                let value = self.needed("value", "number", ty)?;
                let width = self.needed("width", "bits", ty)?;
                let about = self.about()?;
                let number = self.attributes.remove("number").map(|_| quote!(.number()));
                let constant = quote!(Constant::new(#value, (#width) as u32, #about)#number);
                self.under_heading(constant)?
            }
            _ => self.needed("is", "expression", ty)?.into_token_stream(),
        };
        let heading = self.heading.as_ref().map(|_| "under");
        match self.attributes.keys().next().map(String::as_str).or(heading) {
            // What a part has no use for is a mistake.
            Some(word) => Err(Error::new(
                ty.span(),
                format!("a `{}` has no use for `#[{word}]`", quote!(#ty)),
            )),
            None => Ok(part),
        }
    }

    fn net(&mut self, segment: &PathSegment) -> Result<TokenStream> {
        let kind = &segment.ident;
        let about = self.about()?;
        let net = if is_bit(segment)? {
            quote!(#kind::bit(#about))
        } else {
            let width = self.needed("width", "bits", segment)?;
            quote!(#kind::word((#width) as u32, #about))
        };
        self.under_heading(net)
    }

    fn under_heading(&mut self, part: TokenStream) -> Result<TokenStream> {
        let own = self.take("under")?;
        Ok(match self.heading.take().or(own) {
            Some(heading) => quote!(#part.under(#heading)),
            None => part,
        })
    }

    fn register(&mut self, segment: &PathSegment) -> Result<TokenStream> {
        let about = self.about()?;
        let (value, constant) = match self.take("reset")? {
            Some(Reset { value, constant }) => (Some(value.into_token_stream()), constant),
            None => (None, None),
        };
        let mut register = if is_bit(segment)? {
            let value = value.unwrap_or(quote!(false));
            quote!(Register::bit(#value, #about))
        } else {
            let width = self.needed("width", "bits", segment)?;
            let value = value.unwrap_or(quote!(0));
            quote!(Register::word((#width) as u32, #value, #about))
        };
        if let Some(constant) = constant {
            let constant = constant.to_string();
            register = quote!(#register.reset_to(#constant));
        }
        if let Some(name) = self.take::<Expr>("named")? {
            register = quote!(#register.named(#name));
        }
        Ok(register)
    }

    fn about(&mut self) -> Result<TokenStream> {
        let doc = text(&self.doc)?;
        Ok(match self.take::<Expr>("about")? {
            Some(about) => about.into_token_stream(),
            None if self.is_of_first => {
                quote!(if nth == 0 { #doc.to_string() } else { String::new() })
            }
            None => doc,
        })
    }
}

fn last_segment(ty: &Type) -> Result<&PathSegment> {
    match ty {
        Type::Path(path) => Ok(path.path.segments.last().expect("a path has segments")),
        other => Err(Error::new_spanned(other, "a part's type is a path")),
    }
}

/// Whether a part is an input, or some of them.
fn is_input(ty: &Type) -> bool {
    last_segment(ty).is_ok_and(|segment| match segment.ident.to_string().as_str() {
        "Input" => true,
        "Optional" | "Vec" => argument(segment).is_ok_and(is_input),
        _ => false,
    })
}

/// The type between a type's angle brackets.
fn argument(segment: &PathSegment) -> Result<&Type> {
    if let PathArguments::AngleBracketed(arguments) = &segment.arguments
        && let Some(GenericArgument::Type(ty)) = arguments.args.first()
    {
        return Ok(ty);
    }
    Err(Error::new_spanned(segment, "it needs a type in brackets"))
}

/// Whether a net or register is a `bool`, and not a `Word`.
fn is_bit(segment: &PathSegment) -> Result<bool> {
    let value = last_segment(argument(segment)?)?;
    if value.ident == "bool" || value.ident == "Word" {
        return Ok(value.ident == "bool");
    }
    Err(Error::new_spanned(value, "a signal is a `bool` or a `Word`"))
}

#[cfg(test)]
mod tests;
