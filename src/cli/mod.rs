//! The commands.

pub mod codes;
pub mod plan;
