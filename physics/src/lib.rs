//! From photons to counts: [`photons`] draws them one by one, [`response`] says what counts are
//! expected, exactly, and [`histogram`] what follows from counts by arrival time.

// Links to what is private lead its next maintainer on (`--document-private-items`).
#![allow(rustdoc::private_intra_doc_links)]

use goldtof_sensor::{code, light, math, scan, scene, sensor};

pub mod histogram;
pub mod photons;
pub mod response;
