//! What the hardware of a scene promises at its ports: widths, latency, order of
//! results, and how the ports lie in a record.
//!
//! Emitter and reference model build on this and on nothing else in common.

pub mod contract;
pub mod layout;
pub mod peak;
