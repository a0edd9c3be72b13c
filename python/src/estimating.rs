//! From recorded counts to distances.

use goldtof::histogram::Histogram;
use goldtof::recorded::{Assessment, RecordedHistogram, RecordedScan, assess, assess_histogram};
use goldtof::scene::{DetectorIndex, Scene};
use goldtof::sensor::Sensor;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::bad_argument;
use crate::scene::{PyScene, detector_of};
use crate::values::to_python;
use crate::waiting::wait_for;

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
    let signed: Vec<i64> = counts.as_array().iter().copied().collect();
    let totals: Option<Vec<u64>> = total.map(|total| total.as_array().iter().copied().collect());
    let scan = RecordedScan::new(&scene, detector, &signed, totals.as_deref());
    let scan = scan.map_err(bad_argument)?;
    let assessment = wait_for(python, None, move |_| Ok(assess(&Sensor::new(&scene), &scan)))?;
    with_arrays(python, &assessment)
}

/// An array of a field of some rows, under the field's own name.
macro_rules! set_columns {
    ($table:expr, $rows:expr, [$($field:ident),*]) => {
        $(
            let column = $rows.iter().map(|row| row.$field);
            let column = PyArray1::from_iter($table.py(), column);
            $table.set_item(stringify!($field), column)?;
        )*
    };
}

/// An assessment whose steps and bins are dicts of arrays.
fn with_arrays<'py>(python: Python<'py>, assessment: &Assessment) -> PyResult<Bound<'py, PyAny>> {
    let told = to_python(python, assessment)?;
    let (steps, bins) = (&assessment.phase_steps, &assessment.bins);
    let of_steps = PyDict::new(python);
    set_columns!(
        of_steps,
        steps,
        [phase_step, distance_m, count, expected_count, expected_count_std, residual_in_std]
    );
    let totals = steps.iter().map(|step| step.total_residual_in_std.unwrap_or(f64::NAN));
    of_steps.set_item("total_residual_in_std", PyArray1::from_iter(python, totals))?;
    told.set_item("phase_steps", of_steps)?;
    let of_bins = PyDict::new(python);
    set_columns!(of_bins, bins, [bin, count, expected_count, expected_count_std, residual_in_std]);
    told.set_item("bins", of_bins)?;
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
    let Some(plan) = sensor.interface().histogram() else {
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
    let recorded = RecordedHistogram { detector, histogram };
    let assessment = wait_for(python, None, move |_| Ok(assess_histogram(&sensor, &recorded)))?;
    with_arrays(python, &assessment)
}
