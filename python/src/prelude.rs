//! What classes and functions are made with.

pub(super) use std::path::PathBuf;

pub(super) use goldtof::scene::DetectorIndex;
pub(super) use goldtof::sensor::Sensor;
pub(super) use numpy::{PyArray1, PyReadonlyArray1};
pub(super) use pyo3::prelude::*;
pub(super) use pyo3::types::PyDict;

pub(super) use crate::errors::{bad_argument, failed};
pub(super) use crate::scene::PyScene;
pub(super) use crate::values::to_python;
pub(super) use crate::waiting::wait_for;
