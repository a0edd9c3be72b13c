//! What a user gets: the Verilog of a scene ([`emit`]), with what [`flow`] puts beside
//! it for an FPGA team's tools.

mod emission;
mod error;
pub mod flow;
pub mod formal;
mod write;

pub use emission::{Emission, EmittedFile, LeftOut, Parameters, PeakParameters, emit};
pub use error::HdlError;
pub use write::{write, write_into};
