//! Hardware blocks, written as they read: `#[block]` over the struct, `#[kernel]` over what it does.
//!
//! rust-hdl simulates the body of `fn update` and writes Verilog from a syntax tree of it, for
//! which it has a macro of its own; that knows nothing of what is decided when the hardware is built
//! but loops, and no concatenation. `#[kernel]` makes the same tree, in which everything else
//! that Rust says is settled. One rule tells the two times apart: **what reads no signal by `.val()`
//! is elaboration**, and leaves no gate.
//!
//! ```ignore
//! #[block(edge_detector)]
//! /// one hit per rising edge
//! ///
//! /// Of two neighbouring samples at most one is a rising edge.
//! ///
//! /// - Latency: 1 clock
//! pub struct EdgeDetector {
//!     lanes: usize,
//!     #[set(lanes.div_ceil(2))]
//!     pairs: usize,
//!     /// samples that are high after a low one
//!     #[width(lanes)]
//!     rising: Local<Word>,
//!     /// the hit is the earlier sample of its pair
//!     #[when(lanes > 1)]
//!     #[width(pairs)]
//!     early: Optional<Register<Word>>,
//! }
//!
//! #[kernel]
//! impl Logic for EdgeDetector {
//!     fn update(&mut self) {
//!         self.last_sample.next = self.i_samples.val().get_bit(self.lanes - 1);
//!         if self.early.is_present() {                 // a generate-if
//!             self.find_early();
//!         } else if self.i_run.val() {                 // a multiplexer
//!             self.hits.next = self.i_samples.val();
//!         }
//!     }
//!
//!     fn find_early(&mut self) { ... }
//! }
//! ```
//!
//! # Kernels
//! - `place.next = value;` drives a signal. A value is made of signals by `.val()`, literals, the
//!   operators of rust-hdl, `get_bit`, `replace_bit`, `all`, `any`, `xor`, `bit_cast` and `signed_cast`;
//!   `word.slice(low, width)` is a part of a word, `gather(width, |place| bit)` puts bits side by side.
//! - `if C { A } else { B }` without `.val()` in C leaves one of both, as a statement and as a value;
//!   with `C && D` for a D of signals it leaves `if D { A }`, or nothing. Any other `if` is a multiplexer.
//! - `for`, `let` and numbers (positions, widths, indices) are elaboration: any expression of Rust.
//! - `self.part(numbers);` does what the kernel's function `part` says, `self.bundle.part(numbers);` what that of a bundle does.
//! - `connect! { part from other: i_row, i_go }` drives inputs of a part, those that are there, with what has their names: the
//!   inputs of the block where `other` is `self` or its ports, outputs `o_row` and `o_go` of another part. From a part to `self` it
//!   connects outputs. `connect! { self: valid }` shows a signal at `o_valid`.
//!
//! Anything else is refused where it stands: a condition that mixes both times otherwise, a number that
//! reads a signal, and every construct of Rust that is not hardware.
//!
//! # Blocks
//! `#[block(module)]` makes the constructor `new` and rust-hdl's `Block`. `new` takes the
//! parameters, which are the fields of which nothing says how they are made, and parts that are `#[given]`;
//! `#[set(expression)]` follows from those above it, and every part is as its field says, in which all fields
//! above it have their names. Without a module's name the block is a bundle: ports, registers and parts that stand in the block which has it, as if they were declared there. `#[kernel]` over a plain
//! `impl` gives it functions, which that block calls. `#[shown]` over a bundle makes its ports the block's own for whoever
//! has the block; the block's kernel names the bundle.
//!
//! Doc comments are the comments of the Verilog, in which `{expression}` stands for its value. That of the block,
//! which stands behind `#[block]`, is its module's header: title, notes, and as items `- Label: text` labelled facts;
//! `#[when(condition)]` before a paragraph or an item leaves it out where that does not hold. `#[block(module, .calls())]` adds
//! to it, and `#[block(expression)]` is all of it. That of a row of like signals stands beside the first.
//! `#[size(least..=most)]` of a parameter, a `usize`, makes it one of the module where instances differ in it.
//!
//! Beside a field:
//! `#[width(bits)]`, of any integer type, and `#[reset(value)]`, or `#[reset(value, constant)]` for a reset to a constant
//! of the block; `#[value(number)]` of a constant, and `#[number]` if it is not a pattern of bits; `#[when(condition)]` of an `Optional`; `#[each(n in numbers)]` of a `Vec`;
//! `#[under("heading")]` over ports or constants, up to another heading, an empty one, or another kind of field; `#[about(text)]` for a comment that one expression
//! makes; `#[is(expression)]` for any other part.

use proc_macro::TokenStream;

mod block;
mod connect;
mod elaboration;
mod kernel;
mod text;

/// Makes a block's constructor from its fields; see the crate's documentation.
#[proc_macro_attribute]
pub fn block(arguments: TokenStream, item: TokenStream) -> TokenStream {
    block::expand(arguments.into(), item.into())
        .unwrap_or_else(syn::Error::into_compile_error)
        .into()
}

/// Makes a block's `fn update` from a kernel; see the crate's documentation.
#[proc_macro_attribute]
pub fn kernel(arguments: TokenStream, item: TokenStream) -> TokenStream {
    kernel::expand(arguments.into(), item.into())
        .unwrap_or_else(syn::Error::into_compile_error)
        .into()
}
