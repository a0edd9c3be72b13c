//! Why a scene does not fit a board.

use thiserror::Error;

use crate::wire::SlowLine;

/// Why a scene does not fit a board; each says what would.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BoardError {
    /// No board of that name.
    #[error("there is no board `{name}`; the boards are {boards}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// Those that there are.
        boards: String,
    },
    /// Samples per chip that the pins do not have.
    #[error(
        "clock.samples_per_chip is {found}, and the pins of {board} make {possible}; write one of \
         these, or take another board"
    )]
    Samples {
        /// Samples per chip of the scene.
        found: u32,
        /// The board.
        board: &'static str,
        /// What its pins make.
        possible: String,
    },
    /// More detectors or lasers than pins.
    #[error("the scene has {found} {what}, and {board} has pins for {most}: {pins}")]
    TooMany {
        /// How many.
        found: usize,
        /// Detectors, or lasers.
        what: &'static str,
        /// The board.
        board: &'static str,
        /// For how many it has pins.
        most: usize,
        /// These.
        pins: String,
    },
    /// Faster than the device.
    #[error(
        "a chip of {chip_ns} ns is {what} of {found} {unit}, and {board} takes at most {most} {unit} \
         ({source_name}); use a chip of {least_chip_ns} ns or longer{fewer}"
    )]
    Fast {
        /// The scene's chip period.
        chip_ns: f64,
        /// What is too fast.
        what: &'static str,
        /// How fast it would be.
        found: f64,
        /// In this unit.
        unit: &'static str,
        /// The board.
        board: &'static str,
        /// The limit.
        most: f64,
        /// Where that stands.
        source_name: &'static str,
        /// The shortest chip.
        least_chip_ns: f64,
        /// Another way.
        fewer: String,
    },
    /// No dividers for the chip period.
    #[error(
        "the PLL of {board} ({pll}; {source_name}) makes no chip within 1 % of {chip_ns} ns from \
         {oscillator_mhz} MHz; {nearest}"
    )]
    Pll {
        /// The board.
        board: &'static str,
        /// Its primitive.
        pll: &'static str,
        /// Where its ranges stand.
        source_name: &'static str,
        /// The scene's chip period.
        chip_ns: f64,
        /// The board's oscillator.
        oscillator_mhz: f64,
        /// What would be possible.
        nearest: String,
    },
    /// A delay line that is too short.
    #[error(
        "the second pin of a detector needs a delay of {needed_ns} ns, and DELAYG has {most} taps of \
         about 25 ps (Lattice FPGA-DS-02012); use a chip of {chip_ns} ns or shorter, or {pins_alone} \
         samples per chip, which one pin makes"
    )]
    Delay {
        /// The sample period.
        needed_ns: f64,
        /// Taps.
        most: u32,
        /// The longest chip.
        chip_ns: f64,
        /// Samples per chip without it.
        pins_alone: u32,
    },
    /// More results than the line to the host carries.
    #[error("{board}: {line}")]
    Line {
        /// The board.
        board: &'static str,
        /// What the results take, and what would fit.
        line: Box<SlowLine>,
    },
    /// Results that the bridge cannot carry.
    #[error(
        "a result of this scene, or its scan, is too large for the bridge to {board} (docs/wire.md); \
         use a narrower counter_width, or fewer phase steps"
    )]
    Bridge {
        /// The board.
        board: &'static str,
    },
    /// A scan that cannot be added up.
    #[error(
        "accumulate = {scans}: {board} adds up scans of 4 to 16384 results of up to 128 bits a sum, and this \
         scene has {steps} phase steps of {detectors} detector(s); scan fewer steps, or integrate for longer"
    )]
    Sums {
        /// Scans of a sum.
        scans: u32,
        /// The board.
        board: &'static str,
        /// Phase steps of a scan.
        steps: u64,
        /// Detectors.
        detectors: usize,
    },
    /// Sums that do not fit.
    #[error(
        "the sums of this scan, and the FIFO behind them, take {blocks} {name}, and {board} has {most}; scan \
         fewer steps, or leave out hardware.accumulate and integrate for longer"
    )]
    Memory {
        /// The board.
        board: &'static str,
        /// Blocks of RAM that are needed.
        blocks: u64,
        /// What they are called.
        name: &'static str,
        /// Blocks that there are.
        most: u64,
    },
    /// A text that is not the whole scene.
    #[error(
        "hardware.scene_text: the file's text alone is not the scene, which has {keys} from elsewhere; write \
         them into the file"
    )]
    PartOfText {
        /// The keys.
        keys: String,
    },
    /// A text that is too long.
    #[error(
        "hardware.scene_text: the scene's text has {bytes} bytes, and a device holds 1 to {most}; leave out \
         comments, or this key"
    )]
    LongText {
        /// Its bytes.
        bytes: usize,
        /// Those of a device.
        most: usize,
    },
    /// A pin that cannot be what it was chosen for.
    #[error("--pin {port}={site}: {problem}; {board} has {possible}")]
    Pin {
        /// The top's port.
        port: String,
        /// The site.
        site: String,
        /// What is wrong.
        problem: String,
        /// The board.
        board: &'static str,
        /// What would do.
        possible: String,
    },
}
