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
//! A [`Sensor`] is the door: it loads a scene, and emits, simulates, co-simulates, grades,
//! estimates, or runs the main job, each with options that have defaults. The functions of the
//! same names also tell how far they are. The feature `cli` is the program; it is on by default,
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
//! let sensor = goldtof::Sensor::load("scenes/quick.toml")?;
//! let expected = sensor.expected()?;
//! let options = goldtof::SimulateOptions { repetitions: 200, ..Default::default() };
//! let simulated = sensor.simulate(&options)?;
//! let (expected, simulated) = (&expected.estimates[0], &simulated.estimates[0]);
//! let ratio = simulated.std_m.unwrap() / expected.expected_std_m.unwrap();
//! assert!((ratio - 1.0).abs() < 0.2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// Links to what is private lead its next maintainer on (`--document-private-items`).
#![allow(rustdoc::private_intra_doc_links)]
// What the program alone calls.
#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports))]

pub mod batch;
#[cfg(feature = "cli")]
pub mod cli;
pub mod code;
pub mod cosim;
pub mod deliver;
mod digest;
pub mod document;
mod door;
pub mod estimate;
mod exact;
pub(crate) mod files;
pub mod grade;
pub mod histogram;
pub(crate) mod interrupt;
pub(crate) mod light;
pub(crate) mod math;
pub mod photons;
pub mod plan;
pub(crate) mod printable;
pub(crate) mod programs;
pub mod recorded;
#[doc(hidden)]
pub mod reference;
#[doc(hidden)]
pub mod report;
pub mod response;
#[doc(hidden)]
pub mod rtl;
mod run;
pub mod scan;
pub mod scene;
pub mod sensor;
#[doc(hidden)]
pub mod shard;
pub mod simulate;
pub mod study;
pub mod version;

pub use cosim::own::OwnRtl;
pub use door::{
    CosimFailed, CosimOptions, EmitOptions, EstimateError, EstimateOptions, Progress, cosim, grade,
    simulate,
};
pub use files::{FileError, OutputFolder};
pub use grade::{Bounds as ProofBounds, GradeOptions, GradeStimulus};
pub use interrupt::watch as watch_signals;
pub use light::SPEED_OF_LIGHT_M_PER_S;
pub use programs::set_time_limit as set_tool_time_limit;
pub use report::provenance::Provenance;
pub use run::{Run, RunError, RunEvent, RunOptions, run};
pub use sensor::Sensor;
pub use simulate::SimulateOptions;
