//! The Verilog beside the reference model: [`mod@cosim`] in lock-step and in lanes, [`batch`] for the
//! testbenches of others, [`board`] for what stands round the core, and [`grade`], which says what a stimulus would have found.

// Links to what is private lead its next maintainer on (`--document-private-items`).
#![allow(rustdoc::private_intra_doc_links)]

use goldtof_hardware::{deliver, reference, rtl, wire};
use goldtof_physics::{histogram, photons};
use goldtof_sensor::{document, scan, scene, sensor};
use goldtof_system::{digest, files, interrupt, printable, programs, version};

pub mod batch;
pub mod board;
pub mod cosim;
pub mod grade;
