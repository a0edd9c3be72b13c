//! What figures and tables are made with.

pub(super) use std::collections::BTreeMap;

pub(super) use maud::{Markup, html};

pub(super) use super::chart::{ChartAxis, DrawingRole, Mark, Panel};
pub(super) use super::columns::{
    columns, frequency, length, number, paragraph, percent, rate, time,
};
pub(super) use super::coordinate::Coordinate;
pub(super) use super::estimates::{BothEstimates, estimator_name, millimetres};
pub(super) use super::figure::{SvgFigure, coordinate, label, points};
pub(super) use crate::estimate::report::EstimateReport;
pub(super) use crate::scene::{DetectorIndex, EstimatorKind};
pub(super) use crate::sensor::Sensor;
