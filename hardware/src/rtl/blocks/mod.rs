//! The sensor's blocks, one file each, in rust-hdl.
//!
//! Timing, with t the posedge at which chip n leaves the transmit generators
//! (so that `o_laser` shows it after t): the sample word of chip n is on
//! `i_samples` at posedge t + 1, and the reference chips that belong to it
//! stand in the phase stepper after t.
//!
//! Costs are of the first row of docs/resources.md, or what a row differs from it; a carry cell
//! counts as two LUTs.

mod accumulator;
mod bin_adder;
mod bin_bank;
mod cell_combiner;
mod chip_table;
mod code_ports;
mod code_source;
mod correlator_bank;
mod count_clamp;
mod detector_channel;
mod edge_detector;
mod histogram_channel;
mod histogram_control;
mod histogram_top;
mod hit_counter;
mod lfsr;
mod peak_detector;
mod phase_stepper;
mod pixel;
mod pixel_array;
mod quad_counter;
mod register_file;
mod result_stream;
mod row_stream;
mod row_sums;
mod scan_controller;
mod scan_registers;
mod scan_sequencer;
mod segmented_total;
mod sensor_shell;
mod sensor_top;
mod sequence_counter;
mod square;
mod state_match;
mod step_ends;
mod target_tracker;
mod updown_correlator;
mod word_ports;
mod word_total;

pub use accumulator::Accumulator;
pub use bin_adder::BinAdder;
pub use bin_bank::BinBank;
pub use cell_combiner::CellCombiner;
pub use chip_table::ChipTableGenerator;
pub use code_ports::CodePorts;
pub use code_source::{CodeSource, Interleaver};
pub use correlator_bank::CorrelatorBank;
pub use count_clamp::CountClamp;
pub use detector_channel::DetectorChannel;
pub use edge_detector::EdgeDetector;
pub use histogram_channel::HistogramChannel;
pub use histogram_control::HistogramControl;
pub use histogram_top::HistogramTop;
pub use hit_counter::HitCounter;
pub use lfsr::LfsrGenerator;
pub use peak_detector::{CountChoice, CountComparison, CountPiece, PeakDetector};
pub use phase_stepper::PhaseStepper;
pub use pixel::Pixel;
pub use pixel_array::PixelArray;
pub use quad_counter::QuadCounter;
pub use register_file::RegisterFile;
pub use result_stream::{Groups, ResultStream};
pub use row_stream::RowStream;
pub use row_sums::RowSums;
pub use scan_controller::ScanController;
pub use scan_registers::{CountRegister, ScanRegisters};
pub use scan_sequencer::ScanSequencer;
pub use segmented_total::SegmentedTotal;
pub use sensor_shell::SensorShell;
pub use sensor_top::SensorTop;
pub(crate) use sequence_counter::SequenceCounter;
pub use square::SquareGenerator;
pub use state_match::StateMatch;
pub use step_ends::StepEnds;
pub use target_tracker::TargetTracker;
pub use updown_correlator::UpdownCorrelator;
pub use word_ports::WordPorts;
pub use word_total::WordTotal;

/// Of a row of like signals only the first is explained.
fn first_of(place: usize, about: &str) -> &str {
    if place == 0 { about } else { "" }
}
