//! From counts to distances: [`estimate`] with the error to expect, and [`recorded`] for the
//! counts of a sensor that was built.
//!
//! # Panics
//! Functions that take the index of a detector or a path panic if the scene does not have it.

// Links to what is private lead its next maintainer on (`--document-private-items`).
#![allow(rustdoc::private_intra_doc_links)]

use goldtof_physics::{histogram, photons, response};
use goldtof_sensor::{code, light, math, scan, scene, sensor};
use goldtof_system::{files, printable};

pub mod estimate;
pub mod recorded;
