//! goldtof: Verilog, co-simulation and photon-level simulation of DS-CDMA
//! indirect time-of-flight (iToF) sensors.
//!
//! The way of one scene through the crate: [`scene`] reads and checks it,
//! [`code`] makes its codes, [`sensor`] fixes what the hardware promises at its
//! ports, `rtl` describes that hardware and [`deliver`] emits it as Verilog,
//! [`photons`] simulates light and detections, [`mod@reference`] predicts every port at every
//! clock, [`mod@cosim`] compares the Verilog with it, [`response`] has the expected counts, and
//! [`mod@estimate`] turns counts into a distance. [`mod@simulate`] repeats that, and [`study`]
//! has sweeps, stress cases and the article's figures.
//!
//! A [`Sensor`] is the door. It loads a scene; its [`Jobs`] emit, simulate, co-simulate, grade,
//! estimate, or run all of it, with options that have defaults. The functions of the same names
//! also tell how far they are. The feature `cli` is the program; it is on by default,
//! and a library user can do without (`default-features = false`).
//!
//! What is left out of this documentation though it is public (the hardware's blocks,
//! the reference model) is there for the tests and benches of this package, and may
//! change at any time.
//!
//! Conventions used everywhere: the first chip, sample or bit is the earliest;
//! bit 0 of a sample word is the earliest sample; one clock cycle is one chip;
//! distance is half the optical path; light travels at
//! [`SPEED_OF_LIGHT_M_PER_S`].
//!
//! ```
//! use goldtof::simulate::Tier;
//! use goldtof::{Jobs as _, Sensor};
//!
//! let sensor = Sensor::load("scenes/quick.toml")?;
//! let expected = sensor.expected()?;
//! let simulated = sensor.simulate(Tier::Counts.scans(200))?;
//! let (expected, simulated) = (&expected.estimates[0], &simulated.estimates[0]);
//! let ratio = simulated.std_m.unwrap() / expected.expected_std_m.unwrap();
//! assert!((ratio - 1.0).abs() < 0.2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// Links to what is private lead its next maintainer on (`--document-private-items`).
#![allow(rustdoc::private_intra_doc_links)]
// What the program alone calls.
#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports))]

#[cfg(feature = "cli")]
pub mod cli;
mod differences;
mod documents;
mod door;
pub mod image;
pub mod plan;
mod progress;
pub mod replay;
#[doc(hidden)]
pub mod report;
mod run;
#[doc(hidden)]
pub mod shard;
pub mod simulate;
pub mod study;

#[doc(inline)]
pub use goldtof_estimation::{estimate, recorded};
pub use goldtof_hardware::deliver;
#[doc(hidden)]
pub use goldtof_hardware::{reference, rtl};
#[doc(inline)]
pub use goldtof_physics::{histogram, photons, response};
#[doc(inline)]
pub use goldtof_sensor::{code, document, scan, scene, sensor};
use goldtof_sensor::{exact, light, math};
pub use goldtof_system::version;
use goldtof_system::{digest, files, interrupt, printable, programs};
#[doc(inline)]
pub use goldtof_verification::{batch, board, cosim, grade};

pub use cosim::CosimOptions;
pub use cosim::own::OwnRtl;
pub use door::{CosimFailed, EmitOptions, EstimateError, EstimateOptions, Jobs, cosim, grade};
pub use files::{FileError, OutputFolder};
pub use grade::{Bounds as ProofBounds, GradeOptions, GradeStimulus};
pub use interrupt::watch as watch_signals;
pub use light::SPEED_OF_LIGHT_M_PER_S;
pub use programs::set_time_limit as set_tool_time_limit;
pub use progress::Progress;
pub use report::provenance::Provenance;
pub use run::{Run, RunError, RunEvent, RunOptions, run};
pub use sensor::Sensor;
pub use simulate::{SimulateOptions, simulate};
