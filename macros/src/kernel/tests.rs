//! Each kernel beside what `#[hdl_gen]` gets of it, written by hand.

use quote::quote;
use syn::ItemImpl;

use super::{TokenStream, rewrite};

fn rewritten(body: TokenStream) -> Result<String, String> {
    with_functions(quote!(fn update(&mut self) { #body }))
}

fn with_functions(functions: TokenStream) -> Result<String, String> {
    let item: ItemImpl = syn::parse2(quote!(impl Logic for Block { #functions })).unwrap();
    rewrite(&item)
        .map(|function| {
            let statements = &function.block.stmts;
            quote!(#(#statements)*).to_string()
        })
        .map_err(|error| error.to_string())
}

fn becomes(kernel: TokenStream, expected: TokenStream) {
    // Parsed once, so that tokens are joined alike.
    let expected: syn::Block = syn::parse2(quote!({ #expected })).unwrap();
    let statements = &expected.stmts;
    assert_eq!(rewritten(kernel).unwrap(), quote!(#(#statements)*).to_string());
}

fn is_refused(kernel: TokenStream, message: &str) {
    let found = rewritten(kernel).expect_err("it must be refused");
    assert!(found.contains(message), "{found}");
}

#[test]
fn signals_stay_as_they_are() {
    let kernel = quote! {
        self.a.d.next = (self.b.val() << 1).replace_bit(0, !self.c.val());
        if self.c.val() & (self.a.q.val() == 3) {
            self.d.next = bit_cast(self.b.val(), 4) + signed_cast(self.c.val());
        } else if self.e.val().any() {
            self.d.next = 0.into();
        } else {
            self.d.next = self.f[2].val();
        }
    };
    becomes(kernel.clone(), kernel);
}

#[test]
fn an_if_without_val_is_a_loop_of_one_trip_or_none() {
    becomes(
        quote! {
            if self.early.is_present() & (self.plan.lanes > 4) {
                self.a.next = self.b.val();
            } else if !self.plan.wraps {
                self.a.next = self.c.val();
            } else {
                self.a.next = true;
            }
        },
        quote! {
            for _if in 0..(<usize as ::core::convert::From<bool>>::from(
                self.early.is_present() & (self.plan.lanes > 4)
            )) {
                self.a.next = self.b.val();
            }
            for _else in (<usize as ::core::convert::From<bool>>::from(
                self.early.is_present() & (self.plan.lanes > 4)
            ))..1 {
                for _if in 0..(<usize as ::core::convert::From<bool>>::from(!self.plan.wraps)) {
                    self.a.next = self.c.val();
                }
                for _else in (<usize as ::core::convert::From<bool>>::from(!self.plan.wraps))..1 {
                    self.a.next = true;
                }
            }
        },
    );
}

#[test]
fn both_times_may_follow_one_another_in_a_chain() {
    becomes(
        quote! {
            if self.a.val() {
                self.b.next = true;
            } else if self.plan.wraps {
                self.b.next = false;
            }
        },
        quote! {
            if self.a.val() {
                self.b.next = true;
            } else {
                for _if in 0..(<usize as ::core::convert::From<bool>>::from(self.plan.wraps)) {
                    self.b.next = false;
                }
            }
        },
    );
}

#[test]
fn a_let_stands_for_its_value_until_its_block_ends() {
    becomes(
        quote! {
            let n = self.plan.bits - 1;
            let twice = 2 * n;
            for j in n..twice {
                self.a[j].next = bit_cast(self.b.val(), n + 1);
            }
            if n > 3 {
                let m = n;
                self.n.next = self.c.val() >> m;
            }
        },
        quote! {
            for j in ((self.plan.bits - 1))..((2 * (self.plan.bits - 1))) {
                self.a[j].next = bit_cast(self.b.val(), (self.plan.bits - 1) + 1);
            }
            for _if in 0..(<usize as ::core::convert::From<bool>>::from((self.plan.bits - 1) > 3)) {
                for index1 in (((self.plan.bits - 1)))..((((self.plan.bits - 1))) + 1) {
                    self.n.next = self.c.val() >> index1;
                }
            }
        },
    );
}

#[test]
fn an_index_of_elaboration_becomes_a_loop_variable_once() {
    becomes(
        quote! {
            for p in 0..self.plan.pieces {
                self.a[p].i[self.plan.top].next =
                    self.b.val().get_bit(self.plan.size * p + 1) & self.c[self.plan.top].val();
            }
        },
        quote! {
            for p in (0)..(self.plan.pieces) {
                for index1 in (self.plan.top)..((self.plan.top) + 1) {
                    for index2 in (self.plan.size)..((self.plan.size) + 1) {
                        self.a[p].i[index1].next =
                            self.b.val().get_bit(index2 * p + 1) & self.c[index1].val();
                    }
                }
            }
        },
    );
}

#[test]
fn the_test_of_an_if_may_have_an_index_too() {
    becomes(
        quote! {
            if self.a.val().get_bit(self.plan.top) {
                self.b.next = self.c.val().get_bit(self.plan.top);
            }
        },
        quote! {
            for index1 in (self.plan.top)..((self.plan.top) + 1) {
                if self.a.val().get_bit(index1) {
                    for index2 in (self.plan.top)..((self.plan.top) + 1) {
                        self.b.next = self.c.val().get_bit(index2);
                    }
                }
            }
        },
    );
}

#[test]
fn a_call_stands_for_the_functions_body_which_sees_none_of_its_callers_names() {
    let found = with_functions(quote! {
        fn update(&mut self) {
            let n = 4;
            for p in 0..n {
                self.part();
            }
        }
        fn part(&mut self) {
            let n = 2;
            self.a.next = self.b.val() >> n;
        }
    });
    let expected = quote! {
        for p in (0)..((4)) {
            for index1 in ((2))..(((2)) + 1) {
                self.a.next = self.b.val() >> index1;
            }
        }
    };
    assert_eq!(found.unwrap(), expected.to_string());
}

#[test]
fn functions_that_are_missing_unused_or_call_themselves_are_refused() {
    let refused = |functions, message: &str| {
        let found = with_functions(functions).expect_err("it must be refused");
        assert!(found.contains(message), "{found}");
    };
    refused(
        quote!(
            fn update(&mut self) {
                self.part();
            }
        ),
        "`part` is not a function of this kernel",
    );
    refused(
        quote!(
            fn update(&mut self) {}
            fn part(&mut self) {}
        ),
        "`part` is never called",
    );
    refused(
        quote!(
            fn update(&mut self) {
                self.part();
            }
            fn part(&mut self) {
                self.part();
            }
        ),
        "`part` is called by itself",
    );
    refused(
        quote!(
            fn update(&mut self) {}
            fn part(&self) -> bool {
                true
            }
        ),
        "no function `fn name(&mut self)`",
    );
    refused(
        quote!(
            fn connect(&mut self) {}
        ),
        "`update` is not a function",
    );
}

#[test]
fn conditions_of_both_times_are_refused() {
    let both = "reads no signal, but another part does";
    is_refused(quote!(if self.a.is_present() & self.b.val() {}), both);
    is_refused(quote!(if !(self.b.val() | (self.c.val() & self.plan.wraps)) {}), both);
}

#[test]
fn what_rust_hdl_evaluates_outside_of_a_loop_cannot_depend_on_it() {
    let outside = "cannot depend on the loop variable `p`";
    is_refused(
        quote!(for p in 0..4 {
            if p > 0 {}
        }),
        outside,
    );
    is_refused(
        quote!(for p in 0..4 {
            for q in 0..p {}
        }),
        outside,
    );
    is_refused(
        quote!(for p in 0..4 {
            let q = p + 1;
        }),
        outside,
    );
    let width = quote!(for p in 0..4 {
        self.a.next = bit_cast(self.b.val(), p);
    });
    is_refused(width, outside);
    let element = quote!(for p in 0..4 {
        self.a.next = bit_cast(self.b[p].val(), 4);
    });
    is_refused(element, outside);
    is_refused(
        quote!(self.a.next = bit_cast(self.b.val().get_bit(self.plan.top), 4);),
        "give it a `Local`",
    );
}

#[test]
fn signals_are_refused_where_numbers_are_needed_and_numbers_where_signals_are() {
    is_refused(quote!(let a = self.b.val();), "needs a `Local`");
    is_refused(quote!(for j in 0..self.b.val() {}), "reads a signal");
    let position = quote!(self.a.next = self.b.val().get_bit(self.c.val()););
    is_refused(position, "an index that reads a signal");
    is_refused(quote!(self.a.next = self.plan.wraps;), "no signal");
    is_refused(quote!(let n = 3; self.a.next = n;), "no signal");
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
    is_refused(quote!(self.a.next = bits(3);), "neither bit_cast");
    is_refused(quote!(self.a.next = other.val();), "no field of `self`");
    is_refused(quote!(for (a, b) in 0..3 {}), "another form");
    is_refused(quote!(for j in 0..=3 {}), "another form");
    is_refused(quote!(let (a, b) = (1, 2);), "another form");
    is_refused(quote!(let j = 1; for j in 0..3 {}), "something else");
    is_refused(
        quote!(for j in 0..3 {
            self.a.next = self.b.val().get_bit(j.min(2));
        }),
        "no sum, difference or product",
    );
}
