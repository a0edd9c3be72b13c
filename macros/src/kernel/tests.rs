//! Each kernel beside the function that makes its tree, written by hand.

use quote::quote;

use super::{TokenStream, expand};

fn expanded(functions: TokenStream) -> Result<String, String> {
    expand(TokenStream::new(), quote!(impl Logic for Circuit { #functions }))
        .map(|item| item.to_string())
        .map_err(|error| error.to_string())
}

fn becomes(kernel: TokenStream, tree: TokenStream) {
    let found = expanded(quote!(fn update(&mut self) { #kernel })).unwrap();
    let as_it_was = quote!(fn update(&mut self) { #kernel });
    let tree = quote!(fn update_tree(&self, into: &mut Vec<ast::VerilogStatement>) { #tree });
    for part in [as_it_was, tree] {
        assert!(found.contains(&part.to_string()), "{found}\nhas no\n{part}");
    }
}

fn is_refused(kernel: TokenStream, message: &str) {
    let found = expanded(quote!(fn update(&mut self) { #kernel })).expect_err("it must be refused");
    assert!(found.contains(message), "{found}");
}

#[test]
fn signals_are_named_with_their_places() {
    becomes(
        quote! {
            self.bank[b + 1].i_hits.next = self.hits[b].q.val();
        },
        quote! {
            into.push(tree::assigned(
                format!("bank${}$i_hits", b + 1),
                tree::signal(format!("hits${}$q", b))
            ));
        },
    );
}

#[test]
fn words_are_cut_and_put_together() {
    becomes(
        quote! {
            self.a.next = gather(self.n, |i| self.b.val().slice(2 * i, (w)).any());
        },
        quote! {
            into.push(tree::assigned(
                format!("a",),
                tree::gathered(self.n, |i| tree::unary(
                    ast::VerilogOpUnary::Any,
                    tree::slice(tree::signal(format!("b",)), 2 * i, w)
                ))
            ));
        },
    );
}

#[test]
fn an_if_without_val_stays_an_if_and_any_other_is_a_multiplexer() {
    becomes(
        quote! {
            if self.early.is_present() {
                self.a.next = true;
            } else if self.b.val() {
                self.a.next = false;
            }
        },
        quote! {
            if self.early.is_present() {
                into.push(tree::assigned(format!("a",), tree::literal(true)));
            } else {
                into.push({
                    let (mut yes, mut no) = (Vec::new(), Vec::new());
                    {
                        let into = &mut yes;
                        into.push(tree::assigned(format!("a",), tree::literal(false)));
                    }
                    {
                        let into = &mut no;
                    }
                    tree::chosen(tree::signal(format!("b",)), yes, no)
                });
            }
        },
    );
    becomes(
        quote! {
            if self.i_load.is_present() && self.i_load.val() {
                self.a.next = if self.wide { self.b.val() } else { self.starts_high };
            }
        },
        quote! {
            if self.i_load.is_present() {
                into.push({
                    let mut yes = Vec::new();
                    {
                        let into = &mut yes;
                        into.push(tree::assigned(
                            format!("a",),
                            if self.wide {
                                { tree::signal(format!("b",)) }
                            } else {
                                { tree::literal(self.starts_high) }
                            }
                        ));
                    }
                    tree::chosen(tree::signal(format!("i_load",)), yes, Vec::new())
                });
            }
        },
    );
}

#[test]
fn what_is_settled_stays_as_it_is_and_parts_are_called() {
    let found = expanded(quote! {
        fn update(&mut self) {
            let n = self.plan.bits - 1;
            for p in n..2 * n {
                self.part();
            }
        }
        fn part(&mut self) {
            self.a.next = self.b.val() >> 2;
        }
    });
    let found = found.unwrap();
    let tree = quote! {
        let n = self.plan.bits - 1;
        for p in n..2 * n {
            self.part_tree(into);
        }
    };
    assert!(found.contains(&tree.to_string()), "{found}");
    assert!(found.contains(&quote!(fn part(&mut self)).to_string()), "{found}");
    assert!(found.contains("fn part_tree"), "{found}");
}

#[test]
fn functions_of_another_form_and_kernels_without_an_update_are_refused() {
    for (functions, message) in [
        (
            quote!(
                fn update(&mut self) {}
                fn part(&self) -> bool {
                    true
                }
            ),
            "no function `fn name",
        ),
        (
            quote!(
                fn connect(&mut self) {}
            ),
            "without a function `update`",
        ),
    ] {
        let found = expanded(functions).expect_err("it must be refused");
        assert!(found.contains(message), "{found}");
    }
}

#[test]
fn conditions_of_both_times_are_refused() {
    let both = "reads no signal, but another part does";
    is_refused(quote!(if self.a.is_present() & self.b.val() {}), both);
    is_refused(quote!(if !(self.b.val() | (self.c.val() & self.plan.wraps)) {}), both);
    is_refused(
        quote!(if self.a.is_present() && self.b.val() {
        } else {
        }),
        "that has an `else`",
    );
}

#[test]
fn signals_are_refused_where_numbers_are_needed() {
    is_refused(quote!(let a = self.b.val();), "needs a `Local`");
    is_refused(quote!(for j in 0..self.b.val() {}), "reads a signal");
    let position = quote!(self.a.next = self.b.val().get_bit(self.c.val()););
    is_refused(position, "a number that reads a signal");
    is_refused(quote!(self.a = self.b.val();), "without `.next`");
}

#[test]
fn other_constructs_of_rust_are_refused() {
    for construct in [
        quote!(match self.a.val() {
            _ => {}
        }),
        quote!(while true {}),
        quote!(return;),
        quote!(self.a.next += 1;),
        quote!(other.helper();),
        quote!(println!("a");),
        quote!(
            fn inner() {}
        ),
        quote!({
            self.a.next = true;
        }),
    ] {
        is_refused(construct, "no statement of a kernel");
    }
    let hardware = "nothing that hardware is made of";
    is_refused(quote!(self.a.next = self.b.val() as u32;), hardware);
    is_refused(quote!(self.a.next = if self.b.val() { true } else { false };), hardware);
    is_refused(quote!(self.a.next = self.b.val() * self.c.val();), hardware);
    is_refused(quote!(self.a.next = -self.b.val();), hardware);
    is_refused(quote!(self.a.next = self.b.val().value();), "none of val()");
    is_refused(quote!(self.a.next = bits(3);), "none of bit_cast");
    is_refused(quote!(self.a.next = other.val();), "no field of `self`");
}

#[test]
fn a_bundles_function_has_the_bundles_name_before_its_signals() {
    becomes(
        quote! {
            self.bank[b + 1].ends.report(3);
        },
        quote! {
            into.extend({
                let mut inner = Vec::new();
                {
                    let into = &mut inner;
                    self.bank[b + 1].ends.report_tree(into, 3);
                }
                tree::within(&format!("bank${}$ends", b + 1), inner)
            });
        },
    );
}

#[test]
fn a_bundle_has_functions_and_no_update_of_its_own() {
    let of_bundle = |functions| {
        expand(TokenStream::new(), quote!(impl Ends { #functions }))
            .map(|item| item.to_string())
            .map_err(|error| error.to_string())
    };
    let found = of_bundle(quote! {
        pub fn report(&mut self) { self.a.next = true; }
    });
    let expected = quote! {
        impl Ends {
            pub fn report(&mut self) { self.a.next = true; }
            pub fn report_tree(&self, into: &mut Vec<ast::VerilogStatement>) {
                into.push(tree::assigned(format!("a",), tree::literal(true)));
            }
        }
    };
    assert_eq!(found.unwrap(), expected.to_string());
    let refused = of_bundle(quote! { fn update(&mut self) {} });
    assert!(refused.unwrap_err().contains("no function of a bundle"));
}
