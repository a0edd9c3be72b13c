//! What figures are made with.

pub use super::figure::{Claim, ClaimVerdict, Figure};
pub use super::run::{FigureError, FigureScans};
pub use super::sensor::*;
pub use super::statistics::*;
pub use crate::code::Code;
pub use crate::estimate::{CountingTier, distance_m};
pub use crate::report::chart::{ChartAxis, DrawingRole, Mark, Panel};
pub use crate::report::table::{Table, WithInterval};
pub use crate::scene::{DetectorIndex, EstimatorKind, OtherLight, Scene};
pub use crate::sensor::Sensor;
pub use crate::simulate::Tier;
