//! Warnings about a scene, before any work.

use super::output::Output;
use crate::code::{Family, Generator, MOST_HARDWARE_DEGREE};
use crate::estimate::folded;
use crate::light::distance_m;
use crate::scene::PathIndex;
use crate::sensor::Sensor;

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
