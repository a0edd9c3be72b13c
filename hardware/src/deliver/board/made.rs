//! What a board's project is, as the manifest has it.

use goldtof_wire::Identity;
use serde::Serialize;

use super::plan::UartClock;
use super::pll::{Dividers, Frequency};
use crate::deliver::design::EmittedFile;
use crate::wire::ScanSums;

/// A board's project, as the manifest has it.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BoardProject {
    /// Name of the board.
    pub name: String,
    /// Its device.
    pub part: String,
    /// Files in the folder `board`; `make` there ends with a bitstream.
    pub files: Vec<EmittedFile>,
    /// The chip period that the scene asks for.
    pub asked_chip_period_ps: f64,
    /// The one that the PLL makes, which is the manifest's scene's.
    pub chip_period_ps: f64,
    /// The clock of which one cycle is one chip, exactly.
    pub chip_clock: Frequency,
    /// Edge or bit clock of the gears, exactly.
    pub fast_clock: Frequency,
    /// The board's oscillator.
    pub oscillator_hz: u64,
    /// Primitive of the PLL.
    pub pll: String,
    /// Its dividers.
    pub pll_dividers: Dividers,
    /// The line to the host.
    pub uart: UartClock,
    /// Bits per second that the host has to set.
    pub baud_hz: u32,
    /// Share of it that results take.
    pub line_use_fraction: f64,
    /// Pins of each detector.
    pub pins_per_detector: u32,
    /// Taps of the delay of a detector's second pin; 0 without one.
    pub delay_taps: u32,
    /// Where each port of `board_top` is.
    pub pins: Vec<BoardPin>,
    /// What a check of its Verilog has to know.
    #[serde(skip)]
    pub bench: Bench,
}

/// What the hostile surroundings of a board have to know of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Bench {
    /// The scene's and the board's numbers, as a C++ compiler is told of them.
    pub numbers: Vec<String>,
    /// What the device says of itself.
    pub identity: Option<Identity>,
    /// The scene's text, if the device holds it.
    pub text: String,
    /// Scans that are added up.
    pub sums: Option<ScanSums>,
}

/// A port's pin.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct BoardPin {
    /// Port of `board_top`.
    pub port: String,
    /// Ball or number of the device.
    pub site: String,
    /// What the board calls it.
    pub label: String,
    /// I/O standard.
    pub io_standard: String,
}
