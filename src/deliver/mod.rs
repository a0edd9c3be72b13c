//! The sensor's hardware, described in rust-hdl and emitted as Verilog.
//!
//! [`blocks`] describes the circuits in the language of [`front`], [`back`]
//! writes Verilog from them, and [`emit`] does it for a scene, with what [`flow`]
//! puts beside it for an FPGA team's tools.

mod emission;
mod error;
pub mod flow;
mod write;

pub use emission::{Emission, EmittedFile, LeftOut, Parameters, PeakParameters, emit};
pub use error::HdlError;
pub use write::{write, write_into};
