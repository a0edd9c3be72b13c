//! The bit-exact reference model of the hardware, and the contract at its ports.
//!
//! The model shares nothing with the Verilog but [`contract`]: it takes chips
//! from the code table instead of an LFSR, and hits from the list of pulses
//! instead of an edge detector.

pub mod contract;
pub mod exercise;
pub mod layout;
pub mod level;
mod pattern;
pub mod peak;
mod peak_ports;
pub mod reference;
mod stream;
