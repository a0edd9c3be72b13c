//! The bit-exact reference model of the hardware, and the contract at its ports.

pub mod contract;
