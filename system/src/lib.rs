//! What goldtof needs of the operating system: files that are whole or not there, external
//! programs, signals, and texts as they may be shown.

// Links to what is private lead its next maintainer on (`--document-private-items`).
#![allow(rustdoc::private_intra_doc_links)]

pub mod digest;
pub mod files;
pub mod interrupt;
pub mod printable;
pub mod programs;
pub mod version;
