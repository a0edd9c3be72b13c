//! The sensor's hardware, described in rust-hdl and written as Verilog.
//!
//! [`blocks`] describes the circuits in the language of [`front`]; [`back`] writes
//! Verilog from them.

pub mod back;
pub mod blocks;
pub mod front;
