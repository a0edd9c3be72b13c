//! The hardware of exactly one scene: [`rtl`] describes it and writes it as Verilog, [`parts`]
//! says which parts the scene needs and what they take of an FPGA, [`mod@reference`] predicts every
//! port at every clock, and [`deliver`] emits the design with what an FPGA flow needs.

// Links to what is private lead its next maintainer on (`--document-private-items`).
#![allow(rustdoc::private_intra_doc_links)]

use goldtof_physics::photons;
use goldtof_sensor::{code, document, scan, scene, sensor};
use goldtof_system::{files, printable};

pub mod deliver;
pub mod parts;
pub mod reference;
pub mod rtl;
pub mod wire;
