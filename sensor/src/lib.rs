//! A sensor as its scene describes it.
//!
//! [`scene`] reads and checks the scene, [`code`] makes its codes, [`scan`] has its clock and
//! timing, and [`sensor`] fixes what the hardware promises at its ports. Every other package
//! begins with a [`sensor::Sensor`].

// Links to what is private lead its next maintainer on (`--document-private-items`).
#![allow(rustdoc::private_intra_doc_links)]

use goldtof_system::{digest, files, printable, version};

pub mod code;
pub mod document;
pub mod exact;
pub mod light;
pub mod math;
pub mod scan;
pub mod scene;
pub mod sensor;
