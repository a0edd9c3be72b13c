//! The bit-exact reference model of the hardware ([`predictor`]), and what drives it
//! and the Verilog ([`stimulus`]: simulated [`photons`], or an [`adversarial`] one).
//!
//! The model shares nothing with the Verilog but [`crate::sensor`]: it takes chips
//! from the code table instead of an LFSR, and hits from the list of pulses
//! instead of an edge detector.

pub mod adversarial;
mod axis;
mod bin_points;
pub mod blocks;
pub mod canvas;
pub mod cover_report;
pub mod coverage;
pub mod exercise;
mod group_maker;
mod histogram;
pub mod host;
pub mod host_ports;
pub mod level;
pub mod levels;
mod painter;
mod pattern;
mod peak_ports;
pub mod photons;
mod planned;
pub mod predictor;
mod registers;
mod resets;
pub mod stimulus;
mod stream;
pub mod tracking;
