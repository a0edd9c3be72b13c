//! goldtof: Verilog, co-simulation and photon-level simulation of DS-CDMA
//! indirect time-of-flight (iToF) sensors.
//!
//! The way of one scene through the crate: [`scene`] reads and checks it,
//! [`code`] makes its codes, [`sensor`] fixes what the hardware promises at its
//! ports, `rtl` describes that hardware and [`deliver`] emits it as Verilog,
//! [`photons`] makes the light and the detections, [`mod@reference`] predicts every
//! port at every clock, [`mod@cosim`] runs the Verilog beside it, [`response`] says what
//! counts are expected, and [`mod@estimate`] turns counts into a distance. [`mod@simulate`]
//! does it many times, and [`study`] learns from that.
//!
//! The doors are [`run()`], [`emit()`], [`simulate()`], [`cosim()`] and [`estimate()`]:
//! each takes a [`scene::Scene`] and its options. The feature `cli` is the program; it is on
//! by default, and a library user can do without (`default-features = false`).
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
//! use std::path::Path;
//!
//! let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
//! let fidelity = goldtof::simulate::Tier::Expected;
//! let options = goldtof::SimulateOptions { fidelity, ..Default::default() };
//! let simulation = goldtof::simulate(&scene, &options)?;
//! assert!((simulation.estimates[0].true_distance_m - 3.2).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// Links to what is private lead its next maintainer on (`--document-private-items`).
#![allow(rustdoc::private_intra_doc_links)]
// What the program alone calls.
#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports))]

#[cfg(feature = "cli")]
pub mod cli;
mod door;
pub mod plan;
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
pub use goldtof_verification::{batch, cosim, grade};

pub use cosim::own::OwnRtl;
pub use door::{
    CosimFailed, CosimOptions, EmitOptions, EstimateError, EstimateOptions, Rtl, cosim, emit,
    estimate, grade, simulate, simulate_watched,
};
pub use files::{FileError, OutputFolder};
pub use grade::{Bounds as ProofBounds, GradeOptions, GradeStimulus};
pub use interrupt::watch as watch_signals;
pub use light::SPEED_OF_LIGHT_M_PER_S;
pub use programs::set_time_limit as set_tool_time_limit;
pub use report::provenance::Provenance;
pub use run::{Run, RunError, RunEvent, RunOptions, run};
pub use simulate::SimulateOptions;
