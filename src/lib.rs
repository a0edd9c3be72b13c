//! goldtof: Verilog, co-simulation and photon-level simulation of DS-CDMA
//! indirect time-of-flight (iToF) sensors.
//!
//! The way of one scene through the crate: [`scene`] reads and checks it,
//! [`code`] makes its codes, [`sensor`] fixes what the hardware promises at its
//! ports, [`rtl`] describes that hardware and [`deliver`] emits it as Verilog,
//! [`photons`] makes the light and the detections, [`mod@reference`] predicts every
//! port at every clock, [`cosim`] runs the Verilog beside it, [`response`] says what
//! counts are expected, and [`estimate`] turns counts into a distance. [`simulate`]
//! does it many times, and [`study`] learns from that.
//!
//! Conventions used everywhere: the first chip, sample or bit is the earliest;
//! bit 0 of a sample word is the earliest sample; one clock cycle is one chip;
//! distance is half the optical path; light travels at
//! [`SPEED_OF_LIGHT_M_PER_S`].
//!
//! ```
//! use std::path::Path;
//!
//! use goldtof::{deliver, scene};
//!
//! let scene = scene::load(Path::new("scenes/paper-single.toml"))?;
//! let emission = deliver::emit(&scene, "goldtof emit paper-single.toml")?;
//! assert_eq!(emission.clock_hz, 125e6); // one clock is one chip of 8 ns
//! assert!(emission.files.iter().any(|file| file.name == "gold_generator.v"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod cli;
pub mod code;
pub mod cosim;
pub mod deliver;
pub mod estimate;
pub mod files;
pub mod interrupt;
pub mod light;
pub mod math;
pub mod photons;
pub mod plan;
pub mod printable;
pub mod programs;
pub mod recorded;
pub mod reference;
pub mod report;
pub mod response;
pub mod rtl;
pub mod scan;
pub mod scene;
pub mod sensor;
pub mod simulate;
pub mod study;

pub use light::SPEED_OF_LIGHT_M_PER_S;

/// Version of the package, and of a release build in a git checkout the commit:
/// `0.1.0 (2e9f6d6b1a)`, with `-modified` if files differed from it.
pub const VERSION: &str = env!("GOLDTOF_VERSION");
