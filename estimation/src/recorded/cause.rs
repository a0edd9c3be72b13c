//! What may be wrong with a sensor.

use serde::Serialize;

/// What may be wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The sources' power, the transmission, or the detection probability.
    LightLevel,
    /// Dark counts, background, or other light that is not modulated.
    ConstantLight,
    /// The dead time.
    DeadTime,
    /// A constant delay: the detector's, a cable's, or another distance.
    Offset,
    /// The light, the reference or both carry another code.
    Code,
    /// The light is inverted, or counts up and down are swapped.
    Polarity,
    /// The clock's period.
    ChipPeriod,
    /// Counts scatter more, or otherwise, than any of these explains.
    Unexplained,
    /// Counts scatter less than photons can.
    TooEven,
}
