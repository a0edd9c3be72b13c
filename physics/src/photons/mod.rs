//! Light and detections: from a scene to the registered times of a SPAD.
//!
//! [`DetectorModel`] holds what one detector sees of a sensor, in chips.
//! [`DetectorModel::step`] simulates one phase step, photon by photon, as an
//! iterator over [`Detection`]s; [`PulseStream`] turns the steps of a scan into
//! the sampled pulses that the hardware gets, and [`count_step`] counts a step
//! as the article's continuous-time counter does. [`crate::response`] says what
//! the counts are on average, and their variance, without random numbers.
//!
//! Every step depends on nothing but the sensor, the seed and its own number, so
//! steps may be made in any order, on any thread, or many side by side.
//!
//! ```
//! # mod goldtof {
//! #     pub use goldtof_sensor::*;
//! #     pub use goldtof_physics::*;
//! # }
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
//! use std::path::Path;
//!
//! use goldtof::photons::{DetectorModel, count_step};
//! use goldtof::scan::Step;
//! use goldtof::scene::DetectorIndex;
//! use goldtof::sensor::Sensor;
//!
//! let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
//! let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
//! let (seed, scan) = (1, 0);
//! let count = count_step(&model, seed, scan, Step::at(21));
//! assert!(count.total > 0);
//! assert_eq!(count, count_step(&model, seed, scan, Step::at(21)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod afterpulsing;
mod avalanches;
mod cell_levels;
pub(crate) mod counter;
mod crosstalk;
mod dead_time;
pub(crate) mod detector;
pub mod fast;
mod full;
pub mod light;
pub mod memory;
pub(crate) mod movement;
pub(crate) mod paths;
mod pixel;
pub mod random;
mod registration;
mod reorder;
mod sampled;
pub(crate) mod shape;
mod step;
pub(crate) mod tail;
pub(crate) mod time;

pub use cell_levels::CellLevels;
pub use counter::{StepCount, count_step};
pub use dead_time::DeadTime;
pub use detector::DetectorModel;
pub use full::OptionalPart;
pub use registration::Detection;
pub use sampled::{Level, Pulse, PulseStream};
pub use shape::{LightGate, PulseShape, Strand};
pub use step::{GroupDetections, StepDetections};
