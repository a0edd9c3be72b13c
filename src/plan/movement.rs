//! Paths that move: kept or left out.

use super::Part;
use crate::photons::DetectorModel;
use crate::photons::fast::{OutsideDomain, StepCounter};
use crate::scene::{DetectorIndex, Path, PathIndex, Source};
use crate::sensor::Sensor;
use goldtof_hardware::parts::{kept, left_out};

/// The movement of every path together, since one part follows them all.
pub(super) fn part(sensor: &Sensor) -> Part {
    const PART: &str = "moving_paths";
    let paths = PathIndex::of(&sensor.scene().paths)
        .filter_map(|index| describe(index.0, &sensor.scene().paths[index]));
    let clocks = sensor.scene().sources.iter().filter_map(describe_clock);
    let moving: Vec<String> = paths.chain(clocks).collect();
    if moving.is_empty() {
        return left_out(PART, "every path keeps its delay");
    }
    let moving = moving.join(", ");
    kept(
        PART,
        moving
            + &by_plain_loop(sensor)
                .map_or_else(String::new, |why| format!("; photon by photon: {why}")),
    )
}

/// Why movement keeps a detector from the vector lanes, if it does.
fn by_plain_loop(sensor: &Sensor) -> Option<OutsideDomain> {
    DetectorIndex::of(&sensor.scene().detectors)
        .filter_map(|detector| {
            StepCounter::new(&DetectorModel::new(sensor, detector)).outside_domain()
        })
        .find(|why| {
            matches!(
                why,
                OutsideDomain::MovesTooOften { .. } | OutsideDomain::MovesTooQuickly { .. }
            )
        })
}

/// A clock of its own in words.
fn describe_clock(source: &Source) -> Option<String> {
    let clock = source.clock;
    let drift = match clock.drift_per_s {
        0.0 => String::new(),
        drift => format!(" and drifts by {:.3} ppm/s", drift * 1e6),
    };
    (!clock.is_shared()).then(|| {
        format!(
            "the clock of source \"{}\" is off by {:.3} ppm{drift}",
            source.name,
            clock.offset * 1e6
        )
    })
}

fn describe(index: usize, path: &Path) -> Option<String> {
    let movement = path.movement.filter(|movement| !movement.is_neutral())?;
    let mut parts = Vec::new();
    if movement.velocity_m_per_s != 0.0 {
        parts.push(format!("at {} m/s", movement.velocity_m_per_s));
    }
    if let Some(fluctuation) = movement.fluctuation.filter(|f| f.std_m > 0.0) {
        parts.push(format!(
            "by {} mm at random with a correlation time of {} us",
            fluctuation.std_m * 1e3,
            fluctuation.correlation_time_ps / 1e6
        ));
    }
    Some(format!("path {index} moves {}", parts.join(" and ")))
}
