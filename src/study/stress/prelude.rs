//! What cases are made with.

pub(super) use super::case::{Case, CaseError, CaseMeasurement, cases, ensure, worst};
pub(super) use super::reading::*;
pub(super) use crate::code::{CodeSpec, Family};
pub(super) use crate::estimate::{CountingTier, NoEstimate};
pub(super) use crate::math::SampleStatistics;
pub(super) use crate::photons::StepCount;
pub(super) use crate::response::{CountSampler, MeanResponse, SecondMoments};
pub(super) use crate::scan::Step;
pub(super) use crate::scene::{DetectorIndex, EstimatorKind, Scene};
pub(super) use crate::sensor::Sensor;
pub(super) use crate::simulate::Tier;
