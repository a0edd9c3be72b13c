//! From photons to counts: [`photons`] draws them one by one, [`response`] says what counts are
//! expected, exactly, and [`histogram`] what follows from counts by arrival time.

use goldtof_sensor::{code, light, math, scan, scene, sensor};

pub mod histogram;
pub mod photons;
pub mod response;
