//! Errors as exceptions, with the words of the command line.

use goldtof::CosimFailed;
use goldtof::cosim::error::CosimError;
use goldtof::scene::SceneErrors;
use goldtof::simulate::scans::ScansError;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

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
    "A scene that cannot be used: file, line, column, and what would be right. ``places`` has a \
     dict of ``file``, ``line``, ``column`` (None of what was set) and ``message`` for each error."
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

/// Errors of a scene, whose places Python has as ``places``.
pub(crate) fn of_scene(errors: SceneErrors) -> PyErr {
    let text = errors.to_string();
    match errors {
        SceneErrors::Invalid { errors, .. } => scene_error(text, errors),
        SceneErrors::Unreadable { .. } => scene_error(text, Vec::new()),
    }
}

/// An error of a scene that has no place in its file.
pub(crate) fn of_whole_scene(reason: impl ToString) -> PyErr {
    scene_error(reason.to_string(), Vec::new())
}

fn scene_error(text: String, places: Vec<goldtof::scene::SceneError>) -> PyErr {
    let exception = SceneError::new_err(text);
    let with_places = Python::attach(|python| {
        let list = PyList::empty(python);
        for place in places {
            let told = PyDict::new(python);
            told.set_item("file", place.file)?;
            // A setting is not in the file.
            let known = |number: usize| (place.line > 0).then_some(number);
            told.set_item("line", known(place.line))?;
            told.set_item("column", known(place.column))?;
            told.set_item("message", place.message)?;
            list.append(told)?;
        }
        exception.value(python).setattr("places", list)
    });
    with_places.err().unwrap_or(exception)
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
