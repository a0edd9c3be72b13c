//! Errors as exceptions, with the words of the command line.

use goldtof::CosimFailed;
use goldtof::cosim::error::CosimError;
use goldtof::simulate::scans::ScansError;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;

create_exception!(
    goldtof,
    GoldtofError,
    PyException,
    "What goldtof cannot do, and why, in the words of the command line."
);
create_exception!(
    goldtof,
    SceneError,
    GoldtofError,
    "A scene that cannot be used: file, line, column, and what would be right."
);
create_exception!(
    goldtof,
    ToolError,
    GoldtofError,
    "An external tool (Verilator, g++, Yosys) is missing or fails."
);

/// Any error that is neither the scene's nor a tool's.
pub(crate) fn failed(reason: impl ToString) -> PyErr {
    GoldtofError::new_err(reason.to_string())
}

/// An argument that cannot be meant.
pub(crate) fn bad_argument(reason: impl ToString) -> PyErr {
    PyValueError::new_err(reason.to_string())
}

/// An error of a scene.
pub(crate) fn of_scene(reason: impl ToString) -> PyErr {
    SceneError::new_err(reason.to_string())
}

fn of_tools(error: &CosimError) -> PyErr {
    match error.is_tool() {
        true => ToolError::new_err(error.to_string()),
        false => failed(error),
    }
}

/// An error of a co-simulation.
pub(crate) fn of_cosim(error: CosimFailed) -> PyErr {
    match error {
        CosimFailed::Cosim(error) => of_tools(&error),
        CosimFailed::Hdl(error) => failed(error),
    }
}

/// An error of a simulation.
pub(crate) fn of_scans(error: ScansError) -> PyErr {
    match error {
        ScansError::Cosim(error) => of_tools(&error),
        error => failed(error),
    }
}
