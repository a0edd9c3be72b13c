//! Failures of the search over a whole code period at low light.

use super::figure::{Figure, Table, cells};
use super::run::{Run, RunError};
use super::sensor::{Light, balanced_gold, sensor};
use super::statistics::Measured;
use crate::report::chart::{Axis, Chart, Legend, Mark, Panel, Point, Scale, Series};
use crate::scene::{EstimatorKind, OtherLight};

const POWERS_PW: [f64; 9] = [0.025, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8];
const INTEGRATION_S: f64 = 104.8e-6;

/// How often the estimate of a whole code period is more than a chip off.
pub fn coarse_search(run: &mut Run) -> Result<Figure, RunError> {
    let mut table =
        Table::new(&["series", "power_pw", "failures", "failures_low", "failures_high"]);
    let mut series = Vec::new();
    for (estimator, name) in [
        (EstimatorKind::Fft, "largest count (phase)"),
        (EstimatorKind::Model, "shape of the peak (model)"),
    ] {
        for nu in 0..=1 {
            let code = balanced_gold(0, nu)?;
            let label = format!("ν = {nu}, {name}");
            let mut points = Vec::new();
            for power_pw in POWERS_PW {
                let mut scene = sensor(&[Light::new(&code, power_pw)], INTEGRATION_S);
                scene.estimator = estimator;
                scene.other_light = OtherLight::None;
                let failed = run.search(&scene)?.complement();
                let mut row = vec![Some(power_pw)];
                row.extend(cells(failed));
                table.row(&label, &row);
                points.push(point(power_pw, failed));
            }
            series.push(Series { label, mark: Mark::LineAndDots, colour: series.len(), points });
        }
    }
    let panel = Panel {
        x: Axis { label: "optical power at the detector (pW)".to_owned(), scale: Scale::Log },
        y: Axis { label: "share of scans that miss the target".to_owned(), scale: Scale::Linear },
        series,
        legend: Legend::UpperRight,
        headroom: 0.06,
    };
    Ok(Figure {
        chart: Chart {
            title: "Global coarse search: failures at low light, 104.8 µs per phase step"
                .to_owned(),
            panels: vec![panel],
        },
        table,
        claims: Vec::new(),
        notes: Vec::new(),
    })
}

fn point(x: f64, share: Measured) -> Point {
    Point { x, y: share.value, interval: Some((share.low, share.high)) }
}
