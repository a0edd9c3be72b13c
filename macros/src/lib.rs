//! `#[kernel]`: what a hardware block does, written as it reads.
//!
//! rust-hdl's `#[hdl_gen]` turns the body of `fn update` into a syntax tree that the back end
//! writes as Verilog. Of what is decided when the hardware is built it knows loops only.
//! `#[kernel]` adds the rest and hands its result to `#[hdl_gen]`. One rule tells the two times
//! apart: **what reads no signal by `.val()` is elaboration**, and leaves no gate.
//!
//! ```ignore
//! #[kernel]
//! fn update(&mut self) {
//!     let top = self.plan.lanes - 1;                   // a name for a number
//!     self.last.d.next = self.i_samples.val().get_bit(top);
//!     if self.early.is_present() {                     // a generate-if
//!         self.o_early.next = self.early.q.val();
//!     } else if self.plan.lanes > 4 {                  // another one
//!         self.o_hits.next = self.hits.q.val() >> (self.plan.lanes - 4);
//!     } else if self.i_run.val() {                     // a multiplexer
//!         self.o_hits.next = self.hits.q.val();
//!     }
//! }
//! ```
//!
//! - `if C { A } else { B }` without `.val()` in C becomes `for _if in 0..usize::from(C) { A }`
//!   and `for _else in usize::from(C)..1 { B }`, loops of one trip or none.
//! - `let n = E;` puts E where `n` stands later in its block.
//! - A bit position, a shift or an index of a vector may be any expression of elaboration,
//!   with loop variables added, subtracted or multiplied. rust-hdl takes loop variables and
//!   literals only, so the macro makes a loop of one trip around the statement.
//!
//! Anything else is refused where it stands: a condition that mixes both times; bounds,
//! conditions and casts that name a loop variable, because rust-hdl evaluates them outside of the
//! loop; and every construct of Rust that rust-hdl does not translate.

use proc_macro::TokenStream;

mod elaboration;
mod kernel;

/// Makes a block's `fn update` from a kernel; see the crate's documentation.
#[proc_macro_attribute]
pub fn kernel(arguments: TokenStream, item: TokenStream) -> TokenStream {
    kernel::expand(arguments.into(), item.into())
        .unwrap_or_else(syn::Error::into_compile_error)
        .into()
}
