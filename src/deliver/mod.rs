//! What a user gets: the Verilog of a scene ([`emit`]), with what [`flow`] puts beside
//! it for an FPGA team's tools.

mod emission;
mod error;
pub mod flow;
pub mod formal;
mod write;

pub use crate::rtl::back::{BadPrefix, Prefix};
pub use emission::{
    Emission, EmittedFile, LeftOut, Parameters, PeakParameters, TOP, emit, emit_prefixed,
};
pub use error::HdlError;
pub use write::{write, write_into};
