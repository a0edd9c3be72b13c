//! From recorded counts to distances.

use std::sync::atomic::{AtomicU64, Ordering};

use goldtof::histogram::Histogram;
use goldtof::recorded::{
    Assessment, RecordedCounts, RecordedHistogram, RecordedScan, assess, assess_histogram,
    read_recorded,
};
use goldtof::scene::Scene;
use numpy::PyReadonlyArray2;
use rayon::prelude::*;

use crate::prelude::*;
use crate::scene::detector_of;

/// The distances that scans of a real sensor give, one row of counts each, and what seems wrong:
/// what ``goldtof.estimate`` takes apart, as a list of dicts.
#[pyfunction]
#[pyo3(signature = (scene, counts=None, *, total=None, bins=None, detector=None, estimator=None,
                    on_progress=None))]
#[expect(clippy::too_many_arguments, reason = "keywords, as Python has them")]
pub(crate) fn _estimate<'py>(
    python: Python<'py>,
    scene: &PyScene,
    counts: Option<PyReadonlyArray2<'py, i64>>,
    total: Option<PyReadonlyArray2<'py, u64>>,
    bins: Option<PyReadonlyArray2<'py, u64>>,
    detector: Option<&str>,
    estimator: Option<&str>,
    on_progress: Option<Py<PyAny>>,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let scene = scene.with_estimator(estimator)?;
    let detector = detector_of(&scene, detector)?;
    let assessments = match (counts, bins) {
        (Some(counts), None) => {
            let scans = scans_of(&scene, detector, &counts, total.as_ref())?;
            of_each(python, on_progress, scene, scans, assess)
        }
        (None, Some(bins)) if total.is_none() => {
            let histograms = histograms_of(&scene, detector, &bins)?;
            of_each(python, on_progress, scene, histograms, assess_histogram)
        }
        _ => Err(bad_argument(
            "give counts, of phase steps, with total if there are any; or bins, of a histogram",
        )),
    };
    assessments?.iter().map(|assessment| with_arrays(python, assessment)).collect()
}

/// Assesses each of some scans, on all processors.
fn of_each<T: Send + Sync + 'static>(
    python: Python<'_>,
    on_progress: Option<Py<PyAny>>,
    scene: Scene,
    scans: Vec<T>,
    assess: fn(&Sensor, &T) -> Assessment,
) -> PyResult<Vec<Assessment>> {
    wait_for(python, on_progress, move |watch| {
        let (sensor, done) = (Sensor::new(&scene), AtomicU64::new(0));
        let assessed = |scan: &T| {
            let assessment = assess(&sensor, scan);
            watch.progress(done.fetch_add(1, Ordering::Relaxed) + 1, scans.len() as u64);
            assessment
        };
        Ok(scans.par_iter().map(assessed).collect())
    })
}

/// What is wrong with a scan, with its number where there are several.
fn of_scan(number: usize, scans: usize, wrong: impl std::fmt::Display) -> PyErr {
    match scans {
        1 => bad_argument(wrong),
        _ => bad_argument(format!("scan {number}: {wrong}")),
    }
}

fn scans_of(
    scene: &Scene,
    detector: DetectorIndex,
    counts: &PyReadonlyArray2<i64>,
    total: Option<&PyReadonlyArray2<u64>>,
) -> PyResult<Vec<RecordedScan>> {
    let (counts, total) = (counts.as_array(), total.map(|total| total.as_array()));
    let rows = counts.nrows();
    if let Some(totals) = total.as_ref().map(|total| total.nrows()).filter(|&n| n != rows) {
        return Err(bad_argument(format!(
            "there are counts of {rows} scans, and totals of {totals}"
        )));
    }
    let of_row = |row: usize| {
        let signed = counts.row(row).to_vec();
        let totals = total.as_ref().map(|total| total.row(row).to_vec());
        RecordedScan::new(scene, detector, &signed, totals.as_deref())
            .map_err(|wrong| of_scan(row, rows, wrong))
    };
    (0..rows).map(of_row).collect()
}

fn histograms_of(
    scene: &Scene,
    detector: DetectorIndex,
    bins: &PyReadonlyArray2<u64>,
) -> PyResult<Vec<RecordedHistogram>> {
    let sensor = Sensor::new(scene);
    let Some(plan) = sensor.interface().histogram() else {
        return Err(bad_argument(
            "bins are of a sensor that keeps a histogram, and this scene's correlates phase step by \
             phase step (hardware.architecture = \"histogram\" keeps one)",
        ));
    };
    let bins = bins.as_array();
    if bins.ncols() as u64 != plan.bins() {
        return Err(bad_argument(format!(
            "{} bins were given, and a histogram of this scene has {}",
            bins.ncols(),
            plan.bins()
        )));
    }
    let of_row = |row: usize| {
        let histogram = Histogram::new(bins.row(row).to_vec(), plan.row_bins, plan.periods);
        let histogram = histogram.map_err(|wrong| of_scan(row, bins.nrows(), wrong))?;
        Ok(RecordedHistogram { detector, histogram })
    };
    (0..bins.nrows()).map(of_row).collect()
}

/// The counts, or the bins, that a CSV file has of a detector, as ``goldtof estimate`` reads it.
#[pyfunction]
#[pyo3(signature = (scene, path, *, detector=None))]
pub(crate) fn _recorded<'py>(
    python: Python<'py>,
    scene: &PyScene,
    path: PathBuf,
    detector: Option<&str>,
) -> PyResult<Bound<'py, PyDict>> {
    let sensor = Sensor::new(&scene.summed());
    let detector = detector_of(sensor.scene(), detector)?;
    let missing = || {
        let name = &sensor.scene().detectors[detector].name;
        bad_argument(format!("{}: it has nothing of the detector \"{name}\"", path.display()))
    };
    let told = PyDict::new(python);
    match read_recorded(&path, &sensor).map_err(failed)? {
        RecordedCounts::Scans(scans) => {
            let scan = scans.iter().find(|scan| scan.detector == detector).ok_or_else(missing)?;
            let counts = || scan.counts.iter();
            let signed = counts().map(|count| count.signed);
            told.set_item("counts", PyArray1::from_iter(python, signed))?;
            if scan.has_totals {
                let totals = counts().map(|count| count.total);
                told.set_item("total", PyArray1::from_iter(python, totals))?;
            }
        }
        RecordedCounts::Histograms(histograms) => {
            let one = histograms.iter().find(|one| one.detector == detector);
            let bins = one.ok_or_else(missing)?.histogram.bins();
            told.set_item("bins", PyArray1::from_slice(python, bins))?;
        }
    }
    Ok(told)
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
