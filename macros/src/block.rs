//! A block's constructor from its fields.

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
        if words.shown {
            shown = Some((name.clone(), ty.clone()));
        }
        section.holds_for(ty, &mut words.under);
        if words.given {
            parameters.push(quote!(#name: #ty));
            arguments.push(name.clone());
            parts.push(name);
            continue;
        }
        if words.is_of_parameter(ty) {
            parameters.push(quote!(#name: #ty));
            arguments.push(name.clone());
            sizes.extend(words.size.map(|takes| (name, words.doc, takes)));
        } else if let Some(value) = words.set {
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
    let (start, end, logic) = match is_bundle {
        false => (quote!(visit_start_scope), quote!(visit_end_scope), None),
        true => {
            let logic = quote!(impl Logic for #block { fn update(&mut self) {} });
            (quote!(visit_start_namespace), quote!(visit_end_namespace), Some(logic))
        }
    };
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

        impl Inputs for #block {
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
    /// Gives the present heading to a field that has none of its own; an empty one ends a section.
    fn holds_for(&mut self, ty: &Type, under: &mut Option<Expr>) {
        let kind = listed(ty);
        if under.is_some() || kind != self.kind {
            *self = Section { kind, heading: under.take().filter(|heading| !is_empty(heading)) };
        }
        under.clone_from(&self.heading);
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

/// What stands beside a field.
#[derive(Default)]
struct Words {
    doc: String,
    about: Option<Expr>,
    width: Option<Expr>,
    reset: Option<Reset>,
    value: Option<Expr>,
    under: Option<Expr>,
    named: Option<Expr>,
    when: Option<Expr>,
    each: Option<Each>,
    is: Option<Expr>,
    number: bool,
    given: bool,
    shown: bool,
    set: Option<Expr>,
    size: Option<Expr>,
    /// Whether the comment is the first one's of a row of like signals.
    is_of_first: bool,
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
        let mut others = Vec::new();
        for attribute in std::mem::take(&mut field.attrs) {
            let name = attribute.path().get_ident().map(Ident::to_string);
            match name.as_deref().unwrap_or("") {
                "doc" => {
                    words.add_doc(&attribute);
                    others.push(attribute);
                }
                "about" => words.about = Some(attribute.parse_args()?),
                "width" => words.width = Some(attribute.parse_args()?),
                "reset" => words.reset = Some(attribute.parse_args()?),
                "value" => words.value = Some(attribute.parse_args()?),
                "under" => words.under = Some(attribute.parse_args()?),
                "named" => words.named = Some(attribute.parse_args()?),
                "when" => words.when = Some(attribute.parse_args()?),
                "each" => words.each = Some(attribute.parse_args()?),
                "is" => words.is = Some(attribute.parse_args()?),
                "number" => words.number = true,
                "given" => words.given = true,
                "shown" => words.shown = true,
                "set" => words.set = Some(attribute.parse_args()?),
                "size" => words.size = Some(attribute.parse_args()?),
                _ => others.push(attribute),
            }
        }
        field.attrs = others;
        Ok(words)
    }

    /// Whether nothing says how the field is made, and its type is none of a part.
    fn is_of_parameter(&self, ty: &Type) -> bool {
        const PARTS: [&str; 7] =
            ["Input", "Output", "Local", "Register", "Constant", "Optional", "Memory"];
        let is_part = PARTS.iter().any(|part| last_segment(ty).is_ok_and(|s| s.ident == part));
        !is_part && self.is.is_none() && self.set.is_none() && self.each.is_none()
    }

    fn add_doc(&mut self, attribute: &Attribute) {
        if let Some(line) = doc_line(attribute) {
            if !self.doc.is_empty() {
                self.doc.push(' ');
            }
            self.doc.push_str(&line);
        }
    }

    /// The expression that makes a part of type `ty`.
    fn part(mut self, ty: &Type) -> Result<TokenStream> {
        let segment = last_segment(ty)?;
        let part = match segment.ident.to_string().as_str() {
            _ if self.is.is_some() && self.when.is_none() && self.each.is_none() => {
                self.is.take().into_token_stream()
            }
            "Optional" => {
                let when = needed(self.when.take(), ty, "when(condition)")?;
                let part = self.part(argument(segment)?)?;
                return Ok(quote!(Optional::new(if #when { Some(#part) } else { None })));
            }
            "Vec" if self.each.is_some() => {
                let Each { name, numbers } = self.each.take().expect("checked");
                self.is_of_first =
                    self.about.is_none() && self.is.is_none() && !self.doc.is_empty();
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
                let value = needed(self.value.take(), ty, "value(number)")?;
                let width = needed(self.width.take(), ty, "width(bits)")?;
                let about = self.about()?;
                let number = std::mem::take(&mut self.number).then(|| quote!(.number()));
                let constant = quote!(Constant::new(#value, (#width) as u32, #about)#number);
                self.under_heading(constant)
            }
            _ => needed(self.is.take(), ty, "is(expression)")?.into_token_stream(),
        };
        self.refuse_rest(ty)?;
        Ok(part)
    }

    fn net(&mut self, segment: &PathSegment) -> Result<TokenStream> {
        let kind = &segment.ident;
        let about = self.about()?;
        let net = if is_bit(segment)? {
            quote!(#kind::bit(#about))
        } else {
            let width = needed(self.width.take(), segment, "width(bits)")?;
            quote!(#kind::word((#width) as u32, #about))
        };
        Ok(self.under_heading(net))
    }

    fn under_heading(&mut self, part: TokenStream) -> TokenStream {
        match self.under.take() {
            Some(heading) => quote!(#part.under(#heading)),
            None => part,
        }
    }

    fn register(&mut self, segment: &PathSegment) -> Result<TokenStream> {
        let about = self.about()?;
        let (value, constant) = match self.reset.take() {
            Some(reset) => (Some(reset.value), reset.constant),
            None => (None, None),
        };
        let mut register = if is_bit(segment)? {
            let value = value.map_or(quote!(false), |v| v.into_token_stream());
            quote!(Register::bit(#value, #about))
        } else {
            let width = needed(self.width.take(), segment, "width(bits)")?;
            let value = value.map_or(quote!(0), |v| v.into_token_stream());
            quote!(Register::word((#width) as u32, #value, #about))
        };
        if let Some(constant) = constant {
            let constant = constant.to_string();
            register = quote!(#register.reset_to(#constant));
        }
        if let Some(name) = self.named.take() {
            register = quote!(#register.named(#name));
        }
        Ok(register)
    }

    fn about(&mut self) -> Result<TokenStream> {
        let doc = text(&self.doc)?;
        Ok(match self.about.take() {
            Some(about) => about.into_token_stream(),
            None if self.is_of_first => {
                quote!(if nth == 0 { #doc.to_string() } else { String::new() })
            }
            None => doc,
        })
    }

    /// What a part has no use for is a mistake.
    fn refuse_rest(&self, ty: &Type) -> Result<()> {
        let rest = [
            (self.about.is_some(), "about"),
            (self.width.is_some(), "width"),
            (self.reset.is_some(), "reset"),
            (self.value.is_some(), "value"),
            (self.under.is_some(), "under"),
            (self.named.is_some(), "named"),
            (self.when.is_some(), "when"),
            (self.each.is_some(), "each"),
            (self.is.is_some(), "is"),
            (self.number, "number"),
        ];
        match rest.iter().find(|(stands, _)| *stands) {
            Some((_, word)) => Err(Error::new(
                ty.span(),
                format!("a `{}` has no use for `#[{word}]`", quote!(#ty)),
            )),
            None => Ok(()),
        }
    }
}

fn needed<T>(word: Option<T>, at: impl ToTokens, what: &str) -> Result<T> {
    word.ok_or_else(|| {
        let part = at.to_token_stream();
        Error::new_spanned(&at, format!("a `{part}` needs `#[{what}]`"))
    })
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
