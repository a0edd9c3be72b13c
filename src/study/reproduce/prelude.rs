//! What figures are made with.

pub use super::figure::{Claim, ClaimVerdict, Figure};
pub use super::run::{Run, RunError};
pub use super::sensor::*;
pub use super::statistics::*;
pub use crate::code::Code;
pub use crate::estimate::{CountingTier, distance_m};
pub use crate::report::chart::{Axis, Mark, Panel, Role};
pub use crate::report::table::{Spread, Table};
pub use crate::scene::{DetectorIndex, EstimatorKind, OtherLight, Scene};
pub use crate::sensor::Sensor;
pub use crate::simulate::Tier;
