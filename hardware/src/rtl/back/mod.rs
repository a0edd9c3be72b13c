//! Verilog from rust-hdl's syntax tree.
//!
//! The passes: [`scope`] probes a block into plain data, [`signals`] names
//! everything a module has, [`lower`] unrolls loops and sizes every
//! expression, [`drive`] checks drivers and parts combinational from clocked
//! logic, [`alias`] drops second names, [`module`] merges registers and instances with the ports they
//! drive, [`sheet`] packs vectors of like signals and, with [`lines`], makes loops of like statements
//! and instances, [`share`] finds modules that several instances use, [`print`]
//! and [`text`] write them, and [`netlist`] says how they are connected. What has no single meaning is refused ([`fault`]).

mod alias;
mod concat;
mod drive;
mod expr;
mod fault;
mod lines;
mod lower;
mod module;
mod module_type;
mod names;
mod netlist;
mod number;
mod prefix;
mod print;
#[cfg(test)]
mod refusals;
mod scope;
mod share;
mod sheet;
mod signals;
mod term;
mod text;
mod variants;

use rust_hdl_core::block::Block;

pub use fault::{Fault, FaultyDescription};
pub use netlist::{Connections, End, ModuleNetlist, Submodule};
pub use prefix::{BadPrefix, Prefix};
pub use print::BLOCK_MEMORY;
pub use share::ModuleText;

/// Verilog of `top` and every block in it, one text for each module, the top
/// module last. The names of all modules begin with `prefix`; `made_by` ends up in
/// each header.
pub fn verilog_of(
    top: &dyn Block,
    prefix: &Prefix,
    made_by: &str,
) -> Result<Vec<ModuleText>, FaultyDescription> {
    share::modules_of(&scope::scopes_of(top)?, prefix, made_by)
}
