//! The language that the blocks are written in: rust-hdl with run-time widths.
//!
//! rust-hdl fixes a signal's width by const generics, so that every width of
//! every scene would be a type of its own. The types here implement its
//! `Atom`, `Block` and `Logic` with the width as a field. They simulate in rust-hdl's
//! `update_all` loop and answer its probes.
//!
//! `#[block]` over a struct makes its constructor from what stands beside the fields; `#[kernel]`
//! over `impl Logic` makes rust-hdl's syntax tree of what it does, with the means of [`tree`]. The
//! crate `goldtof-macros` documents both.
//!
//! Every register and memory has the one clock and its reset, which no kernel names; a register
//! that is not driven holds.
//!
//! Rules for kernels beyond those of the macro and of rust-hdl:
//! - what reads no signal by `.val()` is elaboration: `if self.part.is_present()` leaves no gate;
//! - a bare literal, and `signed_cast(x)`, take the width of what they meet;
//!   everything else has to agree, or the back end refuses;
//! - `bit_cast(x, w)` zero-extends or truncates; `x.slice(low, w)` is a part of a word;
//! - `gather(w, |place| bit)` puts bits side by side: a concatenation;
//! - a `Local` may be built up: `x.next = x.val() | y`; once something else has read it, it is complete;
//! - `a & b == c` binds as in Rust; the back end prints the parentheses.

mod clock;
mod inline;
mod marker;
mod memory;
mod net;
mod optional;
mod register;
pub mod tree;
mod word;

pub use clock::tick;
pub use inline::BitTable;
pub use marker::{About, Description, Marker, Size, StateCheck, told_by};
pub use memory::{GivenMemory, LookupMemory, Memory, RegisterMemory};
pub use net::{BlockInputs, Constant, Input, InputPort, Local, Net, NetValue, Output};
pub use optional::Optional;
pub use register::Register;
pub use word::{SignedWord, Word, bit_cast, gather, signed_cast};

/// What a block's source file needs in scope, rust-hdl's macros included.
pub mod prelude {
    pub use goldtof_macros::{block, kernel};
    pub use rust_hdl_core::block::Block;
    pub use rust_hdl_core::logic::Logic;
    pub use rust_hdl_core::{ast, probe};

    pub use super::{
        About, BitTable, BlockInputs, Constant, Input, InputPort, Local, LookupMemory, Memory,
        Optional, Output, Register, RegisterMemory, StateCheck, Word, bit_cast, gather,
        signed_cast, tree,
    };
}
