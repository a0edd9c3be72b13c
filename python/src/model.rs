//! The reference model in batches, numpy in and out.

use goldtof::batch::{self, BatchInputs, HostInputs, Model, PortValues, StepResult};
use goldtof::sensor::port::{PortRole, Use};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArrayDyn, PyReadwriteArray1, PyReadwriteArray2};

use crate::guarded::Guarded;
use crate::prelude::*;

/// Clocks whose records stay in a core's cache.
const BLOCK: usize = 16_384;
/// Blocks after which signals are looked for.
const BLOCKS_BETWEEN_SIGNALS: usize = 256;

/// The bit-exact model of the hardware, clocked in batches; its state stays between them.
///
/// Clock t has the inputs before a rising edge and the outputs after it. Until ``i_rst``
/// has been high the model holds all outputs at 0.
///
/// >>> import numpy as np
/// >>> model = ReferenceModel(Scene.parse(QUICK))
/// >>> samples = np.zeros(6000, np.uint8)
/// >>> samples[::2] = 0x10                         # a hit in every other word
/// >>> reset = np.arange(6000) < 2
/// >>> outputs = model.clock(samples, reset)
/// >>> outputs["o_laser"][2:13]                    # the code's first chips
/// array([0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0], dtype=uint8)
/// >>> results = model.take_results()
/// >>> results["total"], results["clock"]
/// (array([1250, 1250], dtype=uint64), array([2508, 5008], dtype=uint64))
///
/// Threads may share a model: calls wait for each other.
#[pyclass(name = "ReferenceModel", module = "goldtof", frozen)]
pub(crate) struct PyModel(Guarded<OpenModel>);

/// A model, and results that were not taken yet.
struct OpenModel {
    model: Model,
    records: Vec<u64>,
    results: Vec<StepResult>,
}

/// Sample words of one of numpy's types.
#[derive(FromPyObject)]
enum Samples<'py> {
    U8(PyReadonlyArrayDyn<'py, u8>),
    U16(PyReadonlyArrayDyn<'py, u16>),
    U32(PyReadonlyArrayDyn<'py, u32>),
    U64(PyReadonlyArrayDyn<'py, u64>),
}

impl<'py> Samples<'py> {
    /// Those of an array, and their clocks.
    fn of(array: &Bound<'py, PyAny>, inputs: usize) -> PyResult<(Samples<'py>, usize)> {
        let array = &array.py().import("numpy")?.call_method1("ascontiguousarray", (array,))?;
        let shape: Vec<usize> = array.getattr("shape")?.extract()?;
        let is_right = match shape[..] {
            [_] => inputs == 1,
            [_, columns] => columns == inputs,
            _ => false,
        };
        if !is_right {
            return Err(bad_argument(format!(
                "samples have the shape {shape:?}, and this sensor's are (clocks, {inputs}){}",
                if inputs == 1 { " or (clocks,)" } else { "" }
            )));
        }
        let Ok(samples) = array.extract() else {
            let dtype = array.getattr("dtype")?;
            let right = "uint8, uint16, uint32 or uint64";
            return Err(bad_argument(format!("samples are {dtype}, and have to be {right}")));
        };
        Ok((samples, shape[0]))
    }
}

/// Levels of an input, one byte for each clock; none if it is not given.
fn levels(array: Option<&Bound<'_, PyAny>>, name: &str) -> PyResult<Vec<u8>> {
    let Some(array) = array else {
        return Ok(Vec::new());
    };
    if let Ok(levels) = array.extract::<PyReadonlyArray1<'_, bool>>() {
        return Ok(levels.as_array().iter().map(|&high| high.into()).collect());
    }
    if let Ok(levels) = array.extract::<PyReadonlyArray1<'_, u8>>() {
        return Ok(levels.as_array().iter().copied().collect());
    }
    Err(bad_argument(format!("{name} has to be an array of bool or uint8, one for each clock")))
}

/// What a host drives at each clock; nothing if it is not given.
fn driven(ports: Option<&Bound<'_, PyDict>>, clocks: usize) -> PyResult<Vec<HostInputs>> {
    let Some(ports) = ports else {
        return Ok(Vec::new());
    };
    let mut host = vec![HostInputs::default(); clocks];
    for (name, array) in ports {
        let name: String = name.extract()?;
        let Some(role) = PortRole::of(&name).filter(|role| role.usage() == Use::Host) else {
            return Err(bad_argument(format!(
                "host has {name}, which is not a port that a host drives: those are s_axil_awaddr, s_axil_awvalid, \
                 s_axil_wdata, s_axil_wstrb, s_axil_wvalid, s_axil_bready, s_axil_araddr, s_axil_arvalid and \
                 s_axil_rready"
            )));
        };
        let numpy = array.py().import("numpy")?;
        let array = numpy.call_method1("asarray", (array, "uint64"))?;
        let values: PyReadonlyArray1<'_, u64> = array.extract()?;
        let values = values.as_array();
        if values.len() != clocks {
            let found = values.len();
            return Err(bad_argument(format!(
                "{name} has {found} clocks, and samples have {clocks}"
            )));
        }
        for (inputs, value) in host.iter_mut().zip(values) {
            inputs.set(role, *value);
        }
    }
    Ok(host)
}

/// An output port's array while it is filled.
enum Filling<'py> {
    U8(PyReadwriteArray1<'py, u8>),
    U16(PyReadwriteArray1<'py, u16>),
    U32(PyReadwriteArray1<'py, u32>),
    U64(PyReadwriteArray1<'py, u64>),
    Wide(PyReadwriteArray2<'py, u64>),
}

impl<'py> Filling<'py> {
    /// An array for a port of so many bits, and the same as Python sees it.
    fn new(python: Python<'py>, clocks: usize, width: u32) -> (Filling<'py>, Bound<'py, PyAny>) {
        macro_rules! filling {
            ($kind:ident, $array:expr) => {{
                let array = $array;
                (Filling::$kind(array.readwrite()), array.into_any())
            }};
        }
        match width {
            0..=8 => filling!(U8, PyArray1::<u8>::zeros(python, clocks, false)),
            9..=16 => filling!(U16, PyArray1::<u16>::zeros(python, clocks, false)),
            17..=32 => filling!(U32, PyArray1::<u32>::zeros(python, clocks, false)),
            33..=64 => filling!(U64, PyArray1::<u64>::zeros(python, clocks, false)),
            _ => {
                let words = width.div_ceil(64) as usize;
                filling!(Wide, PyArray2::<u64>::zeros(python, [clocks, words], false))
            }
        }
    }

    fn values(&mut self) -> PyResult<PortValues<'_>> {
        Ok(match self {
            Filling::U8(array) => PortValues::U8(array.as_slice_mut()?),
            Filling::U16(array) => PortValues::U16(array.as_slice_mut()?),
            Filling::U32(array) => PortValues::U32(array.as_slice_mut()?),
            Filling::U64(array) => PortValues::U64(array.as_slice_mut()?),
            Filling::Wide(array) => PortValues::U64(array.as_slice_mut()?),
        })
    }
}

impl OpenModel {
    /// Clocks the model through all samples, block by block, and copies every port.
    fn run<W: Copy + Into<u64> + Sync>(
        &mut self,
        python: Python<'_>,
        samples: &[W],
        levels: [&[u8]; 2],
        host: &[HostInputs],
        ports: &mut [PortValues<'_>],
    ) -> PyResult<()> {
        let inputs = self.model.interface().inputs();
        let [reset, ready] = levels;
        let whole = BatchInputs { samples, reset, ready, host };
        // All of it before any of it: a refused batch changes nothing.
        let clocks = python.detach(|| self.model.check(&whole)).map_err(bad_argument)?;
        for first in (0..clocks).step_by(BLOCK * BLOCKS_BETWEEN_SIGNALS) {
            python.check_signals()?;
            let end = (first + BLOCK * BLOCKS_BETWEEN_SIGNALS).min(clocks);
            python
                .detach(|| {
                    for from in (first..end).step_by(BLOCK) {
                        let to = (from + BLOCK).min(end);
                        // Of an input that is not given there are none.
                        let inputs = BatchInputs {
                            samples: &samples[from * inputs..to * inputs],
                            reset: reset.get(from..to).unwrap_or(&[]),
                            ready: ready.get(from..to).unwrap_or(&[]),
                            host: host.get(from..to).unwrap_or(&[]),
                        };
                        self.model.clock(&inputs, &mut self.records)?;
                        self.results.extend(self.model.take_results());
                        let outputs = &self.model.layout().outputs;
                        for (field, values) in outputs.fields.iter().zip(ports.iter_mut()) {
                            values.copy(&self.records, outputs.words, field, from);
                        }
                    }
                    Ok::<(), batch::BatchError>(())
                })
                .map_err(bad_argument)?;
        }
        Ok(())
    }
}

#[pymethods]
impl PyModel {
    /// A model of the scene's hardware before its first clock. ``result_latency_clocks``
    /// and ``peak_latency_clocks`` are those of a design that is not the emitted one.
    #[new]
    #[pyo3(signature = (scene, *, result_latency_clocks=None, peak_latency_clocks=None))]
    fn new(
        scene: &PyScene,
        result_latency_clocks: Option<u32>,
        peak_latency_clocks: Option<u32>,
    ) -> PyResult<PyModel> {
        let sensor = batch::held_to(&scene.sensor(), result_latency_clocks, peak_latency_clocks)
            .map_err(bad_argument)?;
        Ok(PyModel(Guarded::new(OpenModel {
            model: Model::new(&sensor).map_err(failed)?,
            records: Vec::new(),
            results: Vec::new(),
        })))
    }

    /// Clocks the model through a batch.
    ///
    /// ``samples`` has a word for each clock and detector, or each of its cells that have an input of their
    /// own, bit 0 the earliest sample;
    /// ``reset`` and ``ready`` have bool or uint8 for each clock, and are low and high at
    /// all of them if they are left out. Gives an array for each output port: unsigned
    /// integers as narrow as the port allows, or, of a port wider than 64 bits, columns of
    /// 64 bits each, the lowest first. Inputs that are refused change nothing. Ctrl-C ends
    /// the call between two clocks, which ``clocks`` tells; the outputs are lost.
    ///
    /// ``host`` has what a host drives at the registers of a sensor that has them, an array for each of its ports:
    /// ``{"s_axil_awvalid": ..., ...}``; those that are left out are 0.
    #[pyo3(signature = (samples, reset=None, ready=None, host=None))]
    fn clock<'py>(
        &self,
        python: Python<'py>,
        samples: &Bound<'py, PyAny>,
        reset: Option<&Bound<'py, PyAny>>,
        ready: Option<&Bound<'py, PyAny>>,
        host: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mut open = self.0.lock(python);
        let open = &mut *open;
        let (samples, clocks) = Samples::of(samples, open.model.interface().inputs())?;
        let (reset, ready) = (levels(reset, "reset")?, levels(ready, "ready")?);
        let host = driven(host, clocks)?;
        let outputs = PyDict::new(python);
        let mut filling = Vec::new();
        for field in &open.model.layout().outputs.fields {
            let (array, seen) = Filling::new(python, clocks, field.port.width);
            outputs.set_item(&field.port.name, seen)?;
            filling.push(array);
        }
        let mut ports = filling.iter_mut().map(Filling::values).collect::<PyResult<Vec<_>>>()?;
        let levels = [&reset[..], &ready[..]];
        match &samples {
            Samples::U8(words) => open.run(python, words.as_slice()?, levels, &host, &mut ports),
            Samples::U16(words) => open.run(python, words.as_slice()?, levels, &host, &mut ports),
            Samples::U32(words) => open.run(python, words.as_slice()?, levels, &host, &mut ports),
            Samples::U64(words) => open.run(python, words.as_slice()?, levels, &host, &mut ports),
        }?;
        Ok(outputs)
    }

    /// Results of the phase steps that ended in the clocks since the last call, in order:
    /// arrays of ``clock`` (after whose rising edge the step's group comes to the stream,
    /// if nothing stands there any more), ``scan`` since the last reset, ``detector``,
    /// ``step``, ``count`` and ``total``.
    fn take_results<'py>(&self, python: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let results = std::mem::take(&mut self.0.lock(python).results);
        let taken = PyDict::new(python);
        let numbers = |of: fn(&StepResult) -> u64| {
            PyArray1::from_iter(python, results.iter().map(of).collect::<Vec<_>>())
        };
        taken.set_item("clock", numbers(|result| result.clock))?;
        taken.set_item("scan", numbers(|result| result.scan))?;
        taken.set_item("detector", numbers(|result| result.detector.0 as u64))?;
        taken.set_item("step", numbers(|result| result.step))?;
        let counts: Vec<i64> = results.iter().map(|result| result.count).collect();
        taken.set_item("count", PyArray1::from_vec(python, counts))?;
        taken.set_item("total", numbers(|result| result.total))?;
        Ok(taken)
    }

    /// Clocks so far, which is the number of the next one.
    #[getter]
    fn clocks(&self, python: Python<'_>) -> u64 {
        self.0.lock(python).model.clocks()
    }
}
