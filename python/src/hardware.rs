//! Codes, Verilog, and the comparison of Verilog with the reference model.

use goldtof::code::{CodeSpec, Family, correlate, parse_polynomials, parse_seeds, report};
use goldtof::cosim::StimulusKind;
use goldtof::cosim::asked_latency::Latency;
use goldtof::{CosimOptions, EmitOptions, Jobs as _, OwnRtl, Sensor};

use crate::arguments::{self, MOST_CLOCKS, named, within};
use crate::errors::of_cosim;
use crate::prelude::*;

/// A code and its correlation properties, as ``goldtof codes`` has them; ``chips`` is an
/// array of 0 and 1, the first chip first.
///
/// >>> code = codes("gold", degree=5)
/// >>> code["length_chips"], code["chips"][:11]
/// (31, array([0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0], dtype=uint8))
/// >>> code["autocorrelation"]["peak"]
/// 31
#[pyfunction]
#[pyo3(signature = (family, *, degree=None, index=None, interleave=0, polynomials=None,
                    seeds=None, chips=None, allow_non_preferred=false))]
#[expect(clippy::too_many_arguments, reason = "keywords, as Python has them")]
pub(crate) fn codes<'py>(
    python: Python<'py>,
    family: &str,
    degree: Option<u32>,
    index: Option<i64>,
    interleave: u32,
    polynomials: Option<&str>,
    seeds: Option<&str>,
    chips: Option<String>,
    allow_non_preferred: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let family: Family = family.parse().map_err(bad_argument)?;
    let mut spec = CodeSpec::new(family);
    spec.degree = degree;
    spec.index = index;
    spec.interleave = interleave;
    spec.polynomials = polynomials.map(parse_polynomials).transpose().map_err(bad_argument)?;
    spec.seeds = seeds.map(parse_seeds);
    spec.chips = chips;
    spec.allow_non_preferred = allow_non_preferred.then_some(true);
    let report = wait_for(python, None, move |_| report(&spec).map_err(failed))?;
    let told = to_python(python, &report)?;
    let chips: Vec<u8> = report.chips.bytes().map(|chip| chip - b'0').collect();
    told.set_item("chips", PyArray1::from_vec(python, chips))?;
    Ok(told)
}

/// Periodic correlation of two codes of 0 and 1 over one period, at every lag.
///
/// >>> chips = codes("gold", degree=5)["chips"]
/// >>> sorted(set(correlation(chips, chips)[1:].tolist()))
/// [-9, -1, 7]
#[pyfunction]
pub(crate) fn correlation<'py>(
    python: Python<'py>,
    a: PyReadonlyArray1<'py, u8>,
    b: PyReadonlyArray1<'py, u8>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let chips = |array: &PyReadonlyArray1<'_, u8>| -> Vec<u8> {
        array.as_array().iter().copied().collect()
    };
    let (a, b) = (chips(&a), chips(&b));
    if a.len() != b.len() || a.is_empty() || a.iter().chain(&b).any(|&chip| chip > 1) {
        return Err(bad_argument("two codes of the same length, of chips 0 and 1, are correlated"));
    }
    let correlation = wait_for(python, None, move |_| Ok(correlate(&a, &b)))?;
    Ok(PyArray1::from_vec(python, correlation))
}

/// Makes the Verilog of the scene's sensor and what goes with it in the folder ``out``,
/// and gives its manifest. The names of modules, files and macros begin with ``prefix``.
#[pyfunction]
#[pyo3(signature = (scene, out, *, prefix=None))]
pub(crate) fn emit<'py>(
    python: Python<'py>,
    scene: &PyScene,
    out: PathBuf,
    prefix: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = EmitOptions {
        made_by: format!("goldtof emit {}.toml", scene.scene().name),
        prefix: prefix.map(str::parse).transpose().map_err(bad_argument)?,
    };
    let sensor = Sensor::new(scene.scene());
    let emission = wait_for(python, None, move |_| {
        let emission = sensor.emit(&options).map_err(failed)?;
        goldtof::deliver::write(&emission, &out).map_err(failed)?;
        Ok(emission)
    })?;
    to_python(python, &emission.document())
}

/// Runs Verilog beside the reference model, every port at every clock: the emitted one,
/// or your own (``rtl``, a folder, or ``file_lists``; with ``top``, ``include_folders``,
/// ``defines``). Gives what ``goldtof cosim --json`` does; a mismatch is a result.
#[pyfunction]
#[pyo3(signature = (scene, *, rtl=None, file_lists=Vec::new(), top=None,
                    include_folders=Vec::new(), defines=Vec::new(), stimulus="photons",
                    clocks=None, seed=1, latency=None, engine="auto", on_progress=None))]
#[expect(clippy::too_many_arguments, reason = "keywords, as Python has them")]
pub(crate) fn cosim<'py>(
    python: Python<'py>,
    scene: &PyScene,
    rtl: Option<PathBuf>,
    file_lists: Vec<PathBuf>,
    top: Option<String>,
    include_folders: Vec<PathBuf>,
    defines: Vec<String>,
    stimulus: &str,
    clocks: Option<u64>,
    seed: u64,
    latency: Option<&str>,
    engine: &str,
    on_progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let sensor = Sensor::new(scene.scene());
    within(clocks.unwrap_or(1), MOST_CLOCKS, "clocks")?;
    let kinds = [StimulusKind::Photons, StimulusKind::Adversarial];
    let options = CosimOptions {
        own: OwnRtl { folder: rtl, file_lists, top, include_folders, defines },
        made_by: format!("goldtof cosim {}.toml", scene.scene().name),
        stimulus: named(&kinds, stimulus, "stimulus")?,
        clocks,
        seed,
        latency: match latency {
            Some(latency) => latency.parse::<Latency>().map_err(bad_argument)?,
            None => Latency::Emitted,
        },
        engine: arguments::engine(engine)?,
        ..CosimOptions::default()
    };
    let report = wait_for(python, on_progress, move |watch| {
        let done = goldtof::cosim(&sensor, &options, |so_far| watch.hear(so_far));
        Ok(done.map_err(of_cosim)?.report)
    })?;
    to_python(python, &report)
}
