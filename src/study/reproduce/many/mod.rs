//! Several paths and sensors in one scan: what the joint fit says of them.

pub mod beside;
mod fits;
pub mod power_ratio;
pub mod two_paths;

pub use fits::Fits;
