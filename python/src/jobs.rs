//! The jobs: codes, emit, expected, simulate, scans, estimate, cosim.

use std::path::PathBuf;

use goldtof::code::{CodeSpec, Family, correlate, parse_polynomials, parse_seeds, report};
use goldtof::cosim::StimulusKind;
use goldtof::cosim::engine::Engine;
use goldtof::cosim::latency::Latency;
use goldtof::cosim::window::Window;
use goldtof::deliver::Prefix;
use goldtof::estimate::report::expected_errors;
use goldtof::histogram::Histogram;
use goldtof::photons::{DetectorModel, StepCount};
use goldtof::recorded::{
    Assessment, BinResidual, RecordedHistogram, RecordedScan, StepResidual, assess,
    assess_histogram, expected_bins,
};
use goldtof::response::{CountMoments, MeanResponse, SecondMoments};
use goldtof::scene::{Architecture, DetectorIndex, Scene};
use goldtof::sensor::Sensor;
use goldtof::simulate::{Tier, scans::Prepared};
use goldtof::{CosimOptions, EmitOptions, OwnRtl, Rtl, SimulateOptions};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

use crate::errors::{bad_argument, failed, of_cosim, of_scans};
use crate::scene::{PyScene, detector_of};
use crate::values::to_python;
use crate::waiting::wait_for;

/// One of several, by the name that it has in JSON.
fn named<T: Copy + Serialize>(all: &[T], name: &str, what: &str) -> PyResult<T> {
    let name_of = |one: &T| match serde_json::to_value(one) {
        Ok(serde_json::Value::String(name)) => name,
        _ => String::new(),
    };
    all.iter()
        .copied()
        .find(|one| name_of(one) == name)
        .ok_or_else(|| {
            let names: Vec<String> = all.iter().map(name_of).collect();
            bad_argument(format!(
                "there is no {what} {name:?}; there are {}",
                names.join(", ")
            ))
        })
}

/// Bounds of the command line.
const MOST_REPETITIONS: u64 = 1_000_000;
const MOST_CLOCKS: u64 = 1 << 50;

fn within(value: u64, most: u64, what: &str) -> PyResult<()> {
    match (1..=most).contains(&value) {
        true => Ok(()),
        false => Err(bad_argument(format!(
            "{what} is {value}, and has to be 1 to {most}"
        ))),
    }
}

fn tier(name: &str) -> PyResult<Tier> {
    named(&Tier::ALL, name, "fidelity")
}

fn engine(name: &str) -> PyResult<Engine> {
    match name {
        "auto" => Ok(Engine::Auto),
        "lanes" => Ok(Engine::Lanes),
        "lockstep" => Ok(Engine::Lockstep),
        _ => Err(bad_argument(format!(
            "there is no engine {name:?}; there are auto, lanes and lockstep"
        ))),
    }
}

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
    spec.polynomials = polynomials
        .map(parse_polynomials)
        .transpose()
        .map_err(bad_argument)?;
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
        return Err(bad_argument(
            "two codes of the same length, of chips 0 and 1, are correlated",
        ));
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
        prefix: match prefix {
            Some(prefix) => prefix.parse().map_err(bad_argument)?,
            None => Prefix::default(),
        },
    };
    let scene = scene.scene().clone();
    let emission = wait_for(python, None, move |_| {
        let emission = goldtof::emit(&scene, &options).map_err(failed)?;
        goldtof::deliver::write(&emission, &out).map_err(failed)?;
        Ok(emission)
    })?;
    to_python(python, &emission.document())
}

/// What the counts of a detector's scan are expected to be, exactly.
///
/// Arrays of one number for each phase step: means and variances of signed and total
/// count and their covariance; and the numbers that follow of its strongest path: bias,
/// standard deviation, Cramer-Rao bound (``expected_bias_m``, ``expected_std_m``,
/// ``bound_m``; None where there is none, with the reason). Of a sensor that keeps a
/// histogram the arrays are ``bin_mean`` and ``bin_std``, one number for each bin.
#[pyfunction]
#[pyo3(signature = (scene, *, detector=None, fidelity="expected", estimator=None))]
pub(crate) fn expected<'py>(
    python: Python<'py>,
    scene: &PyScene,
    detector: Option<&str>,
    fidelity: &str,
    estimator: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.with_estimator(estimator)?;
    let (detector, tier) = (detector_of(&scene, detector)?, tier(fidelity)?);
    let (columns, errors) = wait_for(python, None, move |_| {
        let sensor = Sensor::new(&scene);
        let columns = match sensor.interface().histogram {
            Some(_) => columns_of_bins(&sensor, detector)?,
            None => columns_of_steps(&sensor, detector, tier)?,
        };
        Ok((columns, expected_errors(&sensor, detector)))
    })?;
    let told = to_python(python, &errors)?;
    for (name, column) in columns {
        told.set_item(name, PyArray1::from_vec(python, column))?;
    }
    Ok(told)
}

/// An array, and its name.
type Column = (&'static str, Vec<f64>);

/// What every step is expected to count.
fn columns_of_steps(sensor: &Sensor, detector: DetectorIndex, tier: Tier) -> PyResult<Vec<Column>> {
    let model = DetectorModel::new(sensor, detector);
    let response = MeanResponse::of_tier(&model, tier.counting()).map_err(failed)?;
    let moments = SecondMoments::new(&response).map_err(failed)?.of_scan();
    let column = |of: fn(&CountMoments) -> f64| moments.iter().map(of).collect();
    Ok(vec![
        ("signed_mean", column(|step| step.signed_mean)),
        ("total_mean", column(|step| step.total_mean)),
        ("signed_variance", column(|step| step.signed_variance)),
        ("total_variance", column(|step| step.total_variance)),
        ("covariance", column(|step| step.covariance)),
    ])
}

/// What every bin is expected to count.
fn columns_of_bins(sensor: &Sensor, detector: DetectorIndex) -> PyResult<Vec<Column>> {
    let bins = expected_bins(sensor, detector).map_err(failed)?;
    let column = |of: usize| bins.iter().map(|bin| bin[of]).collect();
    Ok(vec![("bin_mean", column(0)), ("bin_std", column(1))])
}

/// From photons to distance, ``repetitions`` times, in a tier of fidelity: expected,
/// counts, events, sampled or rtl. Gives what ``goldtof simulate --json`` does.
///
/// >>> scene = Scene.parse(QUICK, "quick.toml")
/// >>> path = simulate(scene, fidelity="counts", repetitions=20, seed=3)["estimates"][0]
/// >>> path["estimates"] + path["missed_scans"]
/// 20
#[pyfunction]
#[pyo3(signature = (scene, *, fidelity="expected", repetitions=1, seed=1, engine="auto",
                    estimator=None, on_progress=None))]
#[expect(clippy::too_many_arguments, reason = "keywords, as Python has them")]
pub(crate) fn simulate<'py>(
    python: Python<'py>,
    scene: &PyScene,
    fidelity: &str,
    repetitions: u64,
    seed: u64,
    engine: &str,
    estimator: Option<&str>,
    on_progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.with_estimator(estimator)?;
    within(repetitions, MOST_REPETITIONS, "repetitions")?;
    let options = SimulateOptions {
        fidelity: tier(fidelity)?,
        repetitions,
        engine: self::engine(engine)?,
        seed,
    };
    let simulation = wait_for(python, on_progress, move |watch| {
        goldtof::simulate_watched(&scene, &options, |done, all| watch.progress(done, all))
            .map_err(of_scans)
    })?;
    to_python(python, &simulation)
}

/// The counts of ``repetitions`` simulated scans of one detector: arrays ``signed`` and
/// ``total`` of (repetitions, phase steps); of a sensor that keeps a histogram ``bins`` of
/// (repetitions, bins).
#[pyfunction]
#[pyo3(signature = (scene, *, fidelity="events", repetitions=1, seed=1, detector=None,
                    on_progress=None))]
pub(crate) fn scans<'py>(
    python: Python<'py>,
    scene: &PyScene,
    fidelity: &str,
    repetitions: u64,
    seed: u64,
    detector: Option<&str>,
    on_progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let scene = scene.scene().clone();
    let (detector, tier) = (detector_of(&scene, detector)?, tier(fidelity)?);
    if !tier.draws() {
        return Err(bad_argument(
            "the tier expected draws no counts; expected() has their means",
        ));
    }
    within(repetitions, MOST_REPETITIONS, "repetitions")?;
    if scene.hardware.architecture == Architecture::Histogram {
        return histograms(
            python,
            scene,
            detector,
            tier,
            seed,
            repetitions,
            on_progress,
        );
    }
    let steps = scene.scan.steps as usize;
    let counts = wait_for(python, on_progress, move |watch| {
        let sensor = Sensor::new(&scene);
        let prepared = Prepared::new(&sensor, tier).map_err(of_scans)?;
        let (mut signed, mut total) = (Vec::new(), Vec::new());
        let mut done = 0;
        let taken = prepared.scans(&sensor, detector, seed, 0..repetitions, |counts| {
            done += 1;
            watch.progress(done, repetitions);
            signed.extend(counts.iter().map(|count| count.signed));
            total.extend(counts.iter().map(|count| count.total));
        });
        taken.map_err(of_scans)?;
        Ok((signed, total))
    })?;
    let shape = [counts.0.len() / steps, steps];
    let told = PyDict::new(python);
    told.set_item(
        "signed",
        PyArray1::from_vec(python, counts.0).reshape(shape)?,
    )?;
    let total: Bound<'_, PyArray2<u64>> = PyArray1::from_vec(python, counts.1).reshape(shape)?;
    told.set_item("total", total)?;
    Ok(told)
}

/// The bins of simulated histograms.
fn histograms<'py>(
    python: Python<'py>,
    scene: Scene,
    detector: DetectorIndex,
    tier: Tier,
    seed: u64,
    repetitions: u64,
    on_progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let bins = wait_for(python, on_progress, move |watch| {
        let sensor = Sensor::new(&scene);
        let prepared = Prepared::new(&sensor, tier).map_err(of_scans)?;
        let (mut bins, mut done) = (Vec::new(), 0);
        let taken = prepared.histograms(&sensor, detector, seed, 0..repetitions, |histogram| {
            done += 1;
            watch.progress(done, repetitions);
            bins.extend_from_slice(histogram.bins());
        });
        taken.map_err(of_scans)?;
        Ok(bins)
    })?;
    let rows = repetitions as usize;
    let shape = [rows, bins.len().checked_div(rows).unwrap_or(0)];
    let told = PyDict::new(python);
    told.set_item("bins", PyArray1::from_vec(python, bins).reshape(shape)?)?;
    Ok(told)
}

/// The distance that the counts of a real sensor's scan give, and what seems wrong, as
/// ``goldtof estimate`` has it: ``counts`` are the signed counts of all phase steps,
/// ``total`` the total ones, if the hardware sends them; of a sensor that keeps a histogram
/// ``bins`` are its bins. What is said of every step, or bin, is a dict of arrays.
#[pyfunction]
#[pyo3(signature = (scene, counts=None, *, total=None, bins=None, detector=None, estimator=None))]
pub(crate) fn estimate<'py>(
    python: Python<'py>,
    scene: &PyScene,
    counts: Option<PyReadonlyArray1<'py, i64>>,
    total: Option<PyReadonlyArray1<'py, u64>>,
    bins: Option<PyReadonlyArray1<'py, u64>>,
    detector: Option<&str>,
    estimator: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.with_estimator(estimator)?;
    let detector = detector_of(&scene, detector)?;
    let counts = match (counts, bins) {
        (Some(counts), None) => counts,
        (None, Some(bins)) if total.is_none() => {
            let bins = bins.as_array().iter().copied().collect();
            return of_bins(python, scene, detector, bins);
        }
        _ => {
            return Err(bad_argument(
                "give counts, of phase steps, with total if there are any; or bins, of a histogram",
            ));
        }
    };
    let found = counts.as_array().len();
    let of_totals = total.as_ref().map_or(found, |total| total.as_array().len());
    if found as u64 != scene.scan.steps || of_totals != found {
        let found = if of_totals == found { found } else { of_totals };
        return Err(bad_argument(goldtof::EstimateError::WrongNumberOfCounts {
            found,
            steps: scene.scan.steps,
        }));
    }
    let has_totals = total.is_some();
    let totals: Vec<u64> = match &total {
        Some(total) => total.as_array().iter().copied().collect(),
        None => vec![0; found],
    };
    let pairs = counts
        .as_array()
        .iter()
        .copied()
        .zip(totals)
        .collect::<Vec<_>>();
    let scan = RecordedScan {
        detector,
        counts: pairs
            .into_iter()
            .map(|(signed, total)| StepCount { signed, total })
            .collect(),
        has_totals,
    };
    let assessment = wait_for(python, None, move |_| {
        Ok(assess(&Sensor::new(&scene), &scan))
    })?;
    with_arrays(python, &assessment)
}

/// An assessment whose steps and bins are dicts of arrays.
fn with_arrays<'py>(python: Python<'py>, assessment: &Assessment) -> PyResult<Bound<'py, PyAny>> {
    let told = to_python(python, assessment)?;
    let (steps, bins) = (&assessment.phase_steps, &assessment.bins);
    let of_steps = |of: fn(&StepResidual) -> f64| -> Vec<f64> { steps.iter().map(of).collect() };
    let of_bins = |of: fn(&BinResidual) -> f64| -> Vec<f64> { bins.iter().map(of).collect() };
    let numbers = |numbers: Vec<u64>| PyArray1::from_vec(python, numbers);
    let floats = |floats: Vec<f64>| PyArray1::from_vec(python, floats);
    let table = PyDict::new(python);
    table.set_item(
        "phase_step",
        numbers(steps.iter().map(|s| s.phase_step).collect()),
    )?;
    table.set_item("distance_m", floats(of_steps(|s| s.distance_m)))?;
    let counts: Vec<i64> = steps.iter().map(|step| step.count).collect();
    table.set_item("count", PyArray1::from_vec(python, counts))?;
    table.set_item("expected_count", floats(of_steps(|s| s.expected_count)))?;
    table.set_item(
        "expected_count_std",
        floats(of_steps(|s| s.expected_count_std)),
    )?;
    table.set_item("residual_in_std", floats(of_steps(|s| s.residual_in_std)))?;
    let of_totals = |step: &StepResidual| step.total_residual_in_std.unwrap_or(f64::NAN);
    table.set_item("total_residual_in_std", floats(of_steps(of_totals)))?;
    told.set_item("phase_steps", table)?;
    let table = PyDict::new(python);
    table.set_item("bin", numbers(bins.iter().map(|b| b.bin).collect()))?;
    table.set_item("count", numbers(bins.iter().map(|b| b.count).collect()))?;
    table.set_item("expected_count", floats(of_bins(|b| b.expected_count)))?;
    table.set_item(
        "expected_count_std",
        floats(of_bins(|b| b.expected_count_std)),
    )?;
    table.set_item("residual_in_std", floats(of_bins(|b| b.residual_in_std)))?;
    told.set_item("bins", table)?;
    Ok(told)
}

/// The distance that a histogram gives.
fn of_bins(
    python: Python<'_>,
    scene: Scene,
    detector: DetectorIndex,
    bins: Vec<u64>,
) -> PyResult<Bound<'_, PyAny>> {
    let sensor = Sensor::new(&scene);
    let Some(plan) = sensor.interface().histogram else {
        return Err(bad_argument(
            "bins are of a sensor that keeps a histogram, and this scene's correlates phase step by \
             phase step (hardware.architecture = \"histogram\" keeps one)",
        ));
    };
    if bins.len() as u64 != plan.bins() {
        return Err(bad_argument(format!(
            "{} bins were given, and a histogram of this scene has {}",
            bins.len(),
            plan.bins()
        )));
    }
    let histogram = Histogram::new(bins, plan.row_bins, plan.periods).map_err(bad_argument)?;
    let recorded = RecordedHistogram {
        detector,
        histogram,
    };
    let assessment = wait_for(python, None, move |_| {
        Ok(assess_histogram(&sensor, &recorded))
    })?;
    with_arrays(python, &assessment)
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
    let scene = scene.scene().clone();
    within(clocks.unwrap_or(1), MOST_CLOCKS, "clocks")?;
    let is_own = rtl.is_some() || !file_lists.is_empty();
    let rtl = match is_own {
        true => Rtl::Own(OwnRtl {
            folder: rtl,
            file_lists,
            top,
            include_folders,
            defines,
        }),
        false => Rtl::Emitted {
            made_by: format!("goldtof cosim {}.toml", scene.name),
        },
    };
    let kinds = [StimulusKind::Photons, StimulusKind::Adversarial];
    let options = CosimOptions {
        rtl,
        stimulus: named(&kinds, stimulus, "stimulus")?,
        clocks,
        seed,
        window: Window::Found,
        latency: match latency {
            Some(latency) => latency.parse::<Latency>().map_err(bad_argument)?,
            None => Latency::Emitted,
        },
        engine: self::engine(engine)?,
    };
    let report = wait_for(python, on_progress, move |watch| {
        let progress = |done, all| watch.progress(done, all);
        let done = goldtof::cosim(&scene, &options, progress).map_err(of_cosim)?;
        Ok(done.report)
    })?;
    to_python(python, &report)
}
