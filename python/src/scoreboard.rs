//! The scoreboard, for testbenches in Python.

use goldtof::batch::{Scoreboard, ScoreboardOptions, TestbenchPort};

use crate::guarded::Guarded;
use crate::prelude::*;

/// Compares what a design shows with the reference model, every port at every clock.
///
/// ``ports`` are names and bits of what a clock's record holds, the first at bit 0, one
/// behind the other, in words of 64 bits.
///
/// ``result_latency_clocks="auto"`` takes the design's own latency, which its first result tells.
///
/// Threads may share a scoreboard: calls wait for each other.
#[pyclass(name = "Scoreboard", module = "goldtof", frozen)]
pub(crate) struct PyScoreboard(Guarded<Scoreboard>);

/// Clocks, or "auto".
#[derive(FromPyObject)]
enum LatencyArgument {
    Clocks(u32),
    Word(String),
}

#[pymethods]
impl PyScoreboard {
    #[new]
    #[pyo3(signature = (scene, ports, *, result_latency_clocks=None, peak_latency_clocks=None,
                        is_idle_payload_free=true, batch_clocks=4096))]
    fn new(
        scene: &PyScene,
        ports: Vec<(String, u32)>,
        result_latency_clocks: Option<LatencyArgument>,
        peak_latency_clocks: Option<u32>,
        is_idle_payload_free: bool,
        batch_clocks: u32,
    ) -> PyResult<PyScoreboard> {
        if batch_clocks == 0 || ports.iter().any(|(_, width)| *width == 0) {
            return Err(bad_argument("a batch has at least 1 clock, and a port at least 1 bit"));
        }
        let ports: Vec<TestbenchPort> =
            ports.into_iter().map(|(name, width)| TestbenchPort { name, width }).collect();
        let (result_latency_clocks, finds_latency) = match result_latency_clocks {
            None => (None, false),
            Some(LatencyArgument::Clocks(clocks)) => (Some(clocks), false),
            Some(LatencyArgument::Word(word)) if word == "auto" => (None, true),
            Some(LatencyArgument::Word(word)) => {
                let told =
                    format!("result_latency_clocks is \"{word}\": write clocks, or \"auto\"");
                return Err(bad_argument(told));
            }
        };
        let options = ScoreboardOptions {
            result_latency_clocks,
            finds_latency,
            peak_latency_clocks,
            is_idle_payload_free,
            batch_clocks,
        };
        let scoreboard = Scoreboard::new(&scene.sensor(), &ports, options).map_err(bad_argument)?;
        Ok(PyScoreboard(Guarded::new(scoreboard)))
    }

    /// Words of 64 bits of a clock's record.
    #[getter]
    fn words(&self, python: Python<'_>) -> usize {
        self.0.lock(python).words()
    }

    /// Takes the words of records, uint64, as many as there are. True while no port was
    /// found to differ.
    fn push(&self, python: Python<'_>, words: PyReadonlyArray1<'_, u64>) -> PyResult<bool> {
        let words = words.as_slice()?;
        let mut scoreboard = self.0.lock(python);
        let scoreboard = &mut *scoreboard;
        python.detach(|| scoreboard.push(words));
        Ok(scoreboard.first_mismatch().is_none())
    }

    /// What all clocks so far say: ``verdict`` (match, mismatch or inconclusive),
    /// ``clocks``, ``mismatches``, ``first_mismatch``, ``exercised``, ``missing``, ``latency`` (where
    /// it is not the emitted design's) and ``text``, all of that in words.
    fn summary<'py>(&self, python: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let summary = self.0.lock(python).summary();
        let told = PyDict::new(python);
        told.set_item("verdict", summary.verdict.to_string())?;
        told.set_item("clocks", summary.clocks)?;
        told.set_item("mismatches", summary.mismatches)?;
        told.set_item("first_mismatch", to_python(python, &summary.first_mismatch)?)?;
        told.set_item("exercised", to_python(python, &summary.exercised)?)?;
        told.set_item("missing", &summary.missing)?;
        told.set_item("latency", to_python(python, &summary.latency)?)?;
        told.set_item("text", summary.to_string())?;
        Ok(told)
    }
}
