//! Expected counts, simulated ones, and the distances that they give.

use goldtof::SimulateOptions;
use goldtof::cosim::engine::Engine;
use goldtof::estimate::estimator::EstimatorInput;
use goldtof::estimate::report::Reporter;
use goldtof::photons::DetectorModel;
use goldtof::recorded::expected_bins;
use goldtof::response::{CountMoments, MeanResponse, SecondMoments};
use goldtof::scene::Architecture;
use goldtof::simulate::Tier;
use goldtof::simulate::scans::PreparedTier;
use numpy::{PyArray2, PyArrayMethods};

use crate::arguments::{self, MOST_REPETITIONS, tier, within};
use crate::errors::of_scans;
use crate::prelude::*;
use crate::scene::detector_of;

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
        let columns = match sensor.interface().histogram() {
            Some(_) => columns_of_bins(&sensor, detector)?,
            None => columns_of_steps(&sensor, detector, tier)?,
        };
        Ok((columns, Reporter::new(&sensor, detector).expected()))
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
    let response = MeanResponse::of_tier(&model, tier.counting(sensor)).map_err(failed)?;
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
        engine: arguments::engine(engine)?,
        seed,
        estimator: None,
    };
    let simulation = wait_for(python, on_progress, move |watch| {
        let sensor = Sensor::new(&scene);
        goldtof::simulate(&sensor, options, |so_far| watch.hear(so_far)).map_err(of_scans)
    })?;
    to_python(python, &simulation)
}

/// The counts of ``repetitions`` simulated scans of one detector: arrays ``signed`` and
/// ``total`` of (repetitions, phase steps); of a sensor that keeps a histogram ``bins`` of
/// (repetitions, bins).
///
/// :func:`estimate` reads counts as the hardware makes them, of samples: those of the tiers
/// ``sampled``, ``counts`` and ``rtl``. The counter of ``events`` takes no samples, and its peak
/// stands elsewhere, by more than a sample.
#[pyfunction]
#[pyo3(signature = (scene, *, fidelity="sampled", repetitions=1, seed=1, detector=None,
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
    let scene = scene.summed();
    let (detector, tier) = (detector_of(&scene, detector)?, tier(fidelity)?);
    if !tier.draws() {
        return Err(bad_argument("the tier expected draws no counts; expected() has their means"));
    }
    within(repetitions, MOST_REPETITIONS, "repetitions")?;
    let steps = scene.scan.steps as usize;
    let is_histogram = scene.hardware.architecture == Architecture::Histogram;
    let (signed, total, bins) = wait_for(python, on_progress, move |watch| {
        let sensor = Sensor::new(&scene);
        let prepared = PreparedTier::new(&sensor, tier, Engine::Auto).map_err(of_scans)?;
        let (mut signed, mut total, mut bins) = (Vec::new(), Vec::new(), Vec::new());
        let mut done = 0;
        let taken = prepared.scans(&sensor, detector, seed, 0..repetitions, &mut |counted| {
            done += 1;
            watch.progress(done, repetitions);
            match counted {
                EstimatorInput::Steps(counts) => {
                    signed.extend(counts.iter().map(|count| count.signed));
                    total.extend(counts.iter().map(|count| count.total));
                }
                EstimatorInput::Bins(histogram) => bins.extend_from_slice(histogram.bins()),
            }
        });
        taken.map_err(of_scans)?;
        Ok((signed, total, bins))
    })?;
    let told = PyDict::new(python);
    if is_histogram {
        let rows = repetitions as usize;
        let shape = [rows, bins.len().checked_div(rows).unwrap_or(0)];
        told.set_item("bins", PyArray1::from_vec(python, bins).reshape(shape)?)?;
        return Ok(told);
    }
    let shape = [signed.len() / steps, steps];
    told.set_item("signed", PyArray1::from_vec(python, signed).reshape(shape)?)?;
    let total: Bound<'_, PyArray2<u64>> = PyArray1::from_vec(python, total).reshape(shape)?;
    told.set_item("total", total)?;
    Ok(told)
}
