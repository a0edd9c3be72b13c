//! The sensor's blocks, one file each, in rust-hdl.
//!
//! Timing, with t the posedge at which chip n leaves the transmit generators
//! (so that `o_laser` shows it after t): the sample word of chip n is on
//! `i_samples` at posedge t + 1, and the reference chips that belong to it
//! stand in the phase stepper after t.

mod chip_table;
mod code_source;
mod edge_detector;
mod interleaver;
mod lfsr;
mod phase_stepper;
mod result_stream;
mod scan_controller;
mod sensor_top;
mod square;
mod updown_correlator;

pub use chip_table::ChipTableGenerator;
pub use code_source::{CodePorts, CodeSource};
pub use edge_detector::EdgeDetector;
pub use interleaver::Interleaver;
pub use lfsr::LfsrGenerator;
pub use phase_stepper::PhaseStepper;
pub use result_stream::ResultStream;
pub use scan_controller::ScanController;
pub use sensor_top::SensorTop;
pub use square::SquareGenerator;
pub use updown_correlator::UpdownCorrelator;
