//! What the back end refuses to write.

use thiserror::Error;

/// A description that has no single meaning in hardware, and where it stands.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("module {module}: {fault}")]
pub struct FaultyDescription {
    /// Module, or the field where the module has no name.
    pub module: String,
    /// What is wrong.
    pub fault: Fault,
}

/// What is wrong with a block's description.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Fault {
    /// A combinational signal that keeps its value on some path.
    #[error(
        "`{signal}` is not driven on every path, which makes a latch; drive it before the `if`"
    )]
    Latch {
        /// The signal.
        signal: String,
    },
    /// Operands, or a target and its value, of unequal widths.
    #[error("{place}: {left} bits meet {right} bits; cast one to the other's width")]
    WidthMismatch {
        /// Operator or target.
        place: String,
        /// Width on the left.
        left: u32,
        /// Width on the right.
        right: u32,
    },
    /// A literal that does not fit where it stands.
    #[error("literal {value} does not fit in {width} bits")]
    OversizeLiteral {
        /// The literal.
        value: u128,
        /// Bits there are.
        width: u32,
    },
    /// A literal or `signed_cast` with nothing to take its width from.
    #[error("{expression} has no width here; use bit_cast(.., width)")]
    NoWidth {
        /// What has none.
        expression: String,
    },
    /// A name that is not a field of the block.
    #[error("`{name}` is not a signal, constant or loop variable of this block")]
    UnknownName {
        /// The name as rust-hdl has it.
        name: String,
    },
    /// A second driver for a signal.
    #[error("`{signal}` has more than one driver")]
    MultipleDrivers {
        /// The signal.
        signal: String,
    },
    /// A block that drives its own input.
    #[error("`{signal}` is the block's own input and cannot be driven from inside")]
    OwnInputDriven {
        /// The port.
        signal: String,
    },
    /// A signal that nothing drives.
    #[error("`{signal}` is not driven")]
    Undriven {
        /// The signal.
        signal: String,
    },
    /// A signal or constant that nothing reads.
    #[error("`{signal}` is never read")]
    Unread {
        /// The signal or constant.
        signal: String,
    },
    /// A signal read and then assigned: rust-hdl reads the old value, Verilog
    /// the new one.
    #[error("`{signal}` is assigned after it was read; assign it first, or use two signals")]
    AssignedAfterRead {
        /// The signal.
        signal: String,
    },
    /// A bit outside of a vector.
    #[error("bit {bit} of a value of {width} bits")]
    OutOfRange {
        /// The bit.
        bit: u32,
        /// Bits there are.
        width: u32,
    },
    /// A name that Verilog reserves or does not allow, or that is taken.
    #[error("`{name}` cannot be a Verilog name: {reason}")]
    BadName {
        /// The name.
        name: String,
        /// Why not.
        reason: &'static str,
    },
    /// What this back end does not translate.
    #[error("{construct} is not supported in a kernel")]
    Unsupported {
        /// What it is.
        construct: String,
    },
}
