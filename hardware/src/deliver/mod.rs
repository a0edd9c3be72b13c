//! What a user gets: the Verilog of a scene ([`emit`]), with what [`flow`] puts beside
//! it for an FPGA team's tools.
//!
//! ```
//! # mod goldtof {
//! #     pub use goldtof_sensor::*;
//! #     pub use goldtof_hardware::*;
//! # }
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
//! use std::path::Path;
//!
//! use goldtof::sensor::Sensor;
//!
//! let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
//! let emission = goldtof::deliver::emit(&Sensor::new(&scene), "my-program")?;
//! assert_eq!(emission.top, "sensor_top");
//! let folder = tempfile::tempdir()?;
//! goldtof::deliver::write(&emission, folder.path())?;
//! assert!(folder.path().join("sensor_top.v").is_file());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod board;
mod design;
mod emission;
mod error;
pub mod flow;
pub mod formal;
mod limits;
mod template;
pub mod testbenches;
mod write;

pub use crate::rtl::back::{BadPrefix, Prefix};
pub use design::{EmittedFile, TOP};
pub use emission::{
    BuildParameters, Emission, HistogramParameters, LeftOut, PeakParameters, emit, emit_prefixed,
    verilog,
};
pub use error::HdlError;
pub use write::{write, write_into};
