//! Failures of the search over a whole code period at low light.

use super::figure::Figure;
use super::run::Run;
use super::run_error::RunError;
use super::sensor::{Light, balanced_gold, sensor};
use crate::report::chart::{Axis, Mark, Panel};
use crate::report::table::Table;
use crate::scene::{EstimatorKind, OtherLight};

const POWERS_PW: [f64; 9] = [0.025, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8];
const INTEGRATION_S: f64 = 104.8e-6;

/// How often the estimate of a whole code period is more than a chip off.
pub fn coarse_search(run: &mut Run) -> Result<Figure, RunError> {
    let mut rows = Vec::new();
    for (estimator, name) in [
        (EstimatorKind::Fft, "largest count (phase)"),
        (EstimatorKind::Model, "shape of the peak (model)"),
    ] {
        for nu in 0..=1 {
            let code = balanced_gold(0, nu)?;
            for power_pw in POWERS_PW {
                let mut scene = sensor(&[Light::new(&code, power_pw)], INTEGRATION_S);
                scene.estimator = estimator;
                scene.other_light = OtherLight::None;
                let failures = run.search(&scene)?.complement();
                rows.push((format!("ν = {nu}, {name}"), power_pw, failures));
            }
        }
    }
    let table = Table::of(&rows)
        .column("series", |row| row.0.as_str())
        .column("power_pw", |row| row.1)
        .interval("failures", |row| row.2)
        .table();
    let panel = Panel::new(
        Axis::log("power_pw", "optical power at the detector (pW)"),
        Axis::linear("failures", "share of scans that miss the target"),
    );
    let title = "Global coarse search: failures at low light, 104.8 µs per phase step";
    let panel = panel.curves(&table, Mark::LineAndDots);
    Ok(Figure::new(title, table, vec![panel]))
}
