//! Each field beside the expression that makes it, written by hand.

use quote::quote;
use syn::parse::Parser;
use syn::{Expr, Field};

use super::{TokenStream, Words, expand};

fn made(field: TokenStream) -> Result<String, String> {
    let mut field = Field::parse_named.parse2(field).unwrap();
    let ty = field.ty.clone();
    Words::taken_from(&mut field)
        .and_then(|words| words.part(&ty))
        .map(|part| part.to_string())
        .map_err(|error| error.to_string())
}

fn makes(field: TokenStream, expected: TokenStream) {
    let expected: Expr = syn::parse2(expected).unwrap();
    let found: Expr = syn::parse_str(&made(field).unwrap()).unwrap();
    assert_eq!(quote!(#found).to_string(), quote!(#expected).to_string());
}

fn is_refused(field: TokenStream, message: &str) {
    let found = made(field).expect_err("it must be refused");
    assert!(found.contains(message), "{found}");
}

#[test]
fn the_doc_comment_is_the_verilog_comment() {
    makes(
        quote! {
            /// pairs of samples
            /// with a hit
            #[width(plan.pairs)]
            pub o_hits: Output<Word>
        },
        quote!(Output::word((plan.pairs) as u32, "pairs of samples with a hit")),
    );
    makes(
        quote! {
            /// a bit of {plan.bits}
            #[under("Flags")]
            o_bit: Output<bool>
        },
        quote!(Output::bit(format!("a bit of {}", plan.bits)).under("Flags")),
    );
}

#[test]
fn registers_and_constants_have_widths_and_values() {
    makes(
        quote! {
            /// index
            #[width(plan.bits)]
            #[reset(plan.load, index_load)]
            index: Register<Word>
        },
        quote!(Register::word((plan.bits) as u32, plan.load, "index").reset_to("index_load")),
    );
    makes(quote!(#[reset(true)] epoch: Register<bool>), quote!(Register::bit(true, "")));
    makes(quote!(run: Register<bool>), quote!(Register::bit(false, "")));
    makes(
        quote! {
            /// Largest count
            #[width(4)]
            #[value(7)]
            largest: Constant
        },
        quote!(Constant::new(7, (4) as u32, "Largest count")),
    );
}

#[test]
fn optional_and_repeated_parts_are_made_of_their_part() {
    makes(
        quote! {
            #[when(plan.several)]
            #[each(c in 0..plan.counts)]
            #[width(c)]
            turns: Optional<Vec<Local<Word>>>
        },
        quote!(Optional::new(if plan.several {
            Some((0..plan.counts).map(|c| Local::word((c) as u32, "")).collect())
        } else {
            None
        })),
    );
    let row = quote! {
        /// turn
        #[each(c in 0..3)]
        turns: Vec<Local<bool>>
    };
    let first = quote!(if nth == 0 { "turn".to_string() } else { String::new() });
    let made = quote!((0..3).enumerate().map(|(nth, c)| Local::bit(#first)).collect());
    makes(row, made);
    makes(quote!(#[is(Child::new(plan.bits))] child: Child), quote!(Child::new(plan.bits)));
}

#[test]
fn what_is_missing_or_of_no_use_is_refused() {
    is_refused(quote!(a: Input<Word>), "needs `#[width(bits)]`");
    is_refused(quote!(a: Optional<Input<bool>>), "needs `#[when(condition)]`");
    is_refused(quote!(#[width(3)] a: Constant), "needs `#[value(number)]`");
    is_refused(quote!(a: Child), "needs `#[is(expression)]`");
    is_refused(quote!(#[width(3)] a: Input<bool>), "no use for `#[width]`");
    is_refused(quote!(#[when(true)] a: Input<bool>), "no use for `#[when]`");
    is_refused(quote!(a: Input<u8>), "a `bool` or a `Word`");
}

#[test]
fn the_constructor_takes_parameters_and_given_parts_in_their_order() {
    let block = quote! {
        pub struct Edge {
            lanes: usize,
            #[set(lanes / 2)]
            pairs: usize,
            #[width(pairs)]
            o_hits: Output<Word>,
            #[given]
            child: Child,
        }
    };
    let made = expand(quote!(about_of(lanes)), block).unwrap().to_string();
    let constructor = quote! {
        pub fn new(lanes: usize, child: Child) -> Edge {
            let pairs: usize = lanes / 2;
            let o_hits = Output::word((pairs) as u32, "");
            let about = about_of(lanes);
            Edge { lanes, pairs, o_hits, child, about }
        }
    };
    assert!(made.contains(&constructor.to_string()), "{made}");
    // What is not a part is not probed, and the description comes last.
    for (part, is_probed) in [("lanes", false), ("o_hits", true), ("child", true), ("about", true)]
    {
        assert_eq!(made.contains(&format!("self . {part} . accept")), is_probed, "{part}");
    }
}

#[test]
fn names_of_a_shown_bundle_are_the_blocks_own() {
    let of_block = |field: TokenStream| {
        expand(quote!(About::new("a", "b")), quote!(struct Circuit { #field })).unwrap().to_string()
    };
    let shown = of_block(quote! {
        #[shown]
        #[is(Ends::new(3))]
        ends: Ends,
    });
    for part in [
        quote!(
            type Target = Ends;
        ),
        quote!(
            fn deref(&self) -> &Ends {
                &self.ends
            }
        ),
        quote!(self.ends.set(port, value);),
    ] {
        assert!(shown.contains(&part.to_string()), "{shown}\nhas no\n{part}");
    }
    let plain = of_block(quote! {
        #[is(Ends::new(3))]
        ends: Ends,
    });
    assert!(!plain.contains("Deref"), "{plain}");
}
