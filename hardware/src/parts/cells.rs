//! What hardware takes of an FPGA.

use serde::Serialize;

/// Cells of one family of FPGAs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Cells")]
pub struct FpgaCells {
    /// Look-up tables, those of carry chains included.
    pub luts: u64,
    /// Flip-flops.
    pub flip_flops: u64,
}
