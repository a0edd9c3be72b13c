//! What is wrong with a batch or a testbench.

use crate::reference::predictor::ReferenceError;

/// Why the model cannot be clocked, or a design not be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BatchError {
    /// The hardware is not modelled.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// A host, and no registers.
    #[error(
        "the scene's hardware has no registers that a host reads and writes; ask for them by hardware.registers = \
         \"axi4-lite\""
    )]
    NoRegisters,
    /// Sample words that are not a whole number of clocks.
    #[error(
        "there are {found} sample words, and each clock has {words}, one for each detector, or for each of its \
         cells that have an input of their own"
    )]
    PartOfAClock {
        /// Words that were given.
        found: usize,
        /// Words of a clock.
        words: usize,
    },
    /// Inputs of different length.
    #[error("{input} has {found} clocks, and i_samples has {clocks}")]
    Lengths {
        /// The input that is not as long as the samples.
        input: &'static str,
        /// Its clocks.
        found: usize,
        /// Clocks of the samples.
        clocks: usize,
    },
    /// A sample word with more than the samples of a chip.
    #[error(
        "clock {clock}: the sample word of input {input} is {word:#x}, and a chip has {samples} \
         samples, bit 0 the earliest: bits from {samples} on must be 0"
    )]
    WordTooWide {
        /// Clock since the model was made.
        clock: u64,
        /// Number of the input: that of the detector, if none has several.
        input: usize,
        /// The word.
        word: u64,
        /// Samples of a chip.
        samples: u32,
    },
    /// A latency that no design is held to.
    #[error("a latency of {clocks} clocks is too long; at most {most} are taken")]
    Latency {
        /// The latency asked for.
        clocks: u32,
        /// The longest.
        most: u32,
    },
    /// The latency of a peak that the hardware does not find.
    #[error(
        "the scene's hardware finds no peak (peak_detector), so that there is no latency of it"
    )]
    NoPeak,
    /// A port of the testbench with another width.
    #[error(
        "port {port} has {found} bits in the testbench and {expected} in the sensor of scene {scene}: \
         set the parameter for its width to {expected}"
    )]
    Width {
        /// Name of the port.
        port: String,
        /// Bits in the testbench.
        found: u32,
        /// Bits of the interface.
        expected: u32,
        /// Name of the scene.
        scene: String,
    },
    /// A port that no sensor has.
    #[error("the testbench has a port {port}, and no sensor has one; there are {known}")]
    UnknownPort {
        /// Name of the port.
        port: String,
        /// Those that there are.
        known: String,
    },
    /// A port that is named twice.
    #[error("the testbench has port {0} twice")]
    PortTwice(String),
    /// A port of the interface that the testbench does not have.
    #[error("the testbench has no port {port}, and the sensor of scene {scene} has it")]
    MissingPort {
        /// Name of the port.
        port: String,
        /// Name of the scene.
        scene: String,
    },
}
