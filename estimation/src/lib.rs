//! From counts to distances: [`estimate`] with the error to expect, and [`recorded`] for the
//! counts of a sensor that was built.

use goldtof_physics::{histogram, photons, response};
use goldtof_sensor::{code, light, math, scan, scene, sensor};
use goldtof_system::{files, printable};

pub mod estimate;
pub mod recorded;
