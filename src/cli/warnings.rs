//! Warnings about a scene, before any work.

use super::output::Output;
use crate::code::{Family, Generator, MOST_HARDWARE_DEGREE};
use crate::estimate::folded;
use crate::light::distance_m;
use crate::plan::link::LinkBudget;
use crate::printable::printable;
use crate::scene::{DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// Primary detections in a dead time from which a detector counts as saturated: it is ready for
/// less than a tenth of the time, and the code shows in little more than when it becomes ready.
const SATURATED: f64 = 10.0;

/// Warns of what the sensor that a scene describes hardly can do.
pub(super) fn warn(sensor: &Sensor, output: &Output) {
    tell_pixel(sensor, output);
    warn_of_far_paths(sensor, output);
    warn_of_saturation(sensor, output);
}

/// Tells which pixel of an array it is.
fn tell_pixel(sensor: &Sensor, output: &Output) {
    let Some(array) = &sensor.scene().array else { return };
    let (row, column, lens) = (array.row, array.column, &array.lens);
    let dark = match sensor.scene().own_paths(DetectorIndex(0)).next() {
        Some(_) => "",
        None => ", which gets no light of its detector's source",
    };
    output.note(&format!(
        "of the array's {} rows of {} pixels this is row {row}, column {column}{dark} (array.row, \
         array.column); `goldtof image` takes all",
        lens.rows, lens.columns
    ));
}

/// Warns of detectors that the light of one path keeps blind.
fn warn_of_saturation(sensor: &Sensor, output: &Output) {
    let scene = sensor.scene();
    for index in PathIndex::of(&scene.paths) {
        let path = &scene.paths[index];
        let (source, spad) = (&scene.sources[path.source], &scene.detectors[path.detector]);
        let primary_hz = LinkBudget::of(scene, index).primary_hz;
        let in_dead_time = primary_hz * spad.dead_time_ps * 1e-12 / f64::from(spad.cells);
        if in_dead_time > SATURATED {
            output.note(&format!(
                "warning: detector {} saturates: path {index} would fire it {primary_hz:.2e} times a second, \
                 and it is blind for {} ns after each detection; source[{}].mean_power = \"{:.1e} W\" \
                 leaves it ready half of the time",
                printable(&spad.name),
                spad.dead_time_ps * 1e-3,
                printable(&source.name),
                source.mean_power_w / in_dead_time,
            ));
        }
    }
}

/// Warns of paths beyond the unambiguous range; whether there are any.
pub(super) fn warn_of_far_paths(sensor: &Sensor, output: &Output) -> bool {
    for (path, folded) in far_paths(sensor) {
        let advice = longer_code(sensor, path)
            .map_or(String::new(), |degree| format!("; codes of degree {degree} reach that far"));
        output.note(&format!("warning: path {path}: {folded}{advice}"));
    }
    is_far(sensor)
}

/// Whether a path is beyond the unambiguous range.
pub(super) fn is_far(sensor: &Sensor) -> bool {
    far_paths(sensor).next().is_some()
}

fn far_paths(sensor: &Sensor) -> impl Iterator<Item = (PathIndex, String)> {
    let paths = PathIndex::of(&sensor.scene().paths);
    paths.filter_map(|path| Some((path, folded(sensor, path)?)))
}

/// Smallest degree of the path's code family with an unambiguous range beyond the path, as far
/// as the hardware supports it.
fn longer_code(sensor: &Sensor, path: PathIndex) -> Option<u32> {
    let path = &sensor.scene().paths[path];
    let code = &sensor.scene().sources[path.source].code;
    let family = match code.generator {
        Generator::Gold { .. } => Family::Gold,
        Generator::MSequence(_) => Family::MSequence,
        Generator::Square | Generator::Chips(_) => return None,
    };
    let reaches = |degree: u32| {
        let chips = ((1_u64 << degree) - 1) << code.interleave;
        distance_m(sensor.clock().ps(chips as f64)) > path.distance_m()
    };
    // No preferred pair where 4 divides the degree.
    let has_codes = |degree: &u32| family == Family::MSequence || !degree.is_multiple_of(4);
    (3..=MOST_HARDWARE_DEGREE).filter(has_codes).find(|&degree| reaches(degree))
}
