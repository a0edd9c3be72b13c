//! A scene's design on a board: a table of the boards, what a scene needs of one ([`BoardPlan`]), and the
//! files that make a bitstream of it ([`BoardProject`]).
//!
//! What a board cannot do is an error with what it can. Place and route checks routed delays; it
//! checks neither the rates of pins and clock buffers nor the ranges of a PLL.

mod error;
mod made;
mod plan;
mod pll;
mod project;
mod table;

pub use error::BoardError;
pub use made::{Bench, BoardPin, BoardProject};
pub use plan::{Assigned, BoardPlan, PinChoice, PinRole, UartClock};
pub use pll::{Dividers, Feedback, Frequency, Pll};
pub use table::{
    BOARDS, Board, Device, DeviceFamily, FamilyFolder, Gear, GearPads, Pad, Pin, Side,
};

/// Folder of a board's files, beside the design.
pub const BOARD: &str = "board";

/// The program that checks a board among hostile surroundings, with its header `simulated_board.h`.
pub const BENCH: &str = include_str!("../../../../hdl/models/bench.cpp");
/// What stands in the place of the core then.
pub const CORE_BENCH: &str = include_str!("../../../../hdl/models/core_bench.sv");
