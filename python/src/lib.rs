//! goldtof for Python: the classes and functions of the package `goldtof`.
//!
//! Jobs that may take long run in a thread of their own (`waiting`) without Python's
//! lock, so that Ctrl-C and other threads work. What jobs report is the JSON of the
//! command line as Python's own types (`values`); what is as long as a scan or a run is
//! a numpy array.

mod arguments;
mod device;
mod errors;
mod estimating;
mod guarded;
mod hardware;
mod model;
mod prelude;
mod recording;
mod scene;
mod scoreboard;
mod simulating;
mod values;
mod waiting;

use pyo3::prelude::*;

#[pymodule]
fn _goldtof(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let python = module.py();
    waiting::remember_process();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("SPEED_OF_LIGHT_M_PER_S", goldtof::SPEED_OF_LIGHT_M_PER_S)?;
    module.add("GoldtofError", python.get_type::<errors::GoldtofError>())?;
    module.add("SceneError", python.get_type::<errors::SceneError>())?;
    module.add("ToolError", python.get_type::<errors::ToolError>())?;
    module.add_class::<scene::PyScene>()?;
    module.add_function(wrap_pyfunction!(scene::_scene, module)?)?;
    module.add_class::<model::PyModel>()?;
    module.add_class::<device::PyDevice>()?;
    module.add_class::<scoreboard::PyScoreboard>()?;
    module.add_function(wrap_pyfunction!(hardware::codes, module)?)?;
    module.add_function(wrap_pyfunction!(hardware::correlation, module)?)?;
    module.add_function(wrap_pyfunction!(hardware::emit, module)?)?;
    module.add_function(wrap_pyfunction!(simulating::expected, module)?)?;
    module.add_function(wrap_pyfunction!(simulating::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(simulating::scans, module)?)?;
    module.add_function(wrap_pyfunction!(estimating::_estimate, module)?)?;
    module.add_function(wrap_pyfunction!(estimating::_recorded, module)?)?;
    module.add_function(wrap_pyfunction!(recording::_replay, module)?)?;
    module.add_function(wrap_pyfunction!(recording::read_tags, module)?)?;
    module.add_function(wrap_pyfunction!(hardware::cosim, module)?)
}
