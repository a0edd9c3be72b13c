//! Recorded counts over what was expected, and what is left.

use super::report::Assessment;
use crate::report::chart::{Axis, Chart, ChartError, Legend, Mark, Panel, Point, Scale, Series};

/// Most points of a series: of longer scans the steps round the largest count.
const MOST_POINTS: usize = 400;

/// Counts and expected counts on the left, residuals in standard deviations on the
/// right; of a long scan the steps round the largest count.
///
/// # Errors
/// When the drawing library gives up.
pub fn residual_plot(assessment: &Assessment) -> Result<String, ChartError> {
    let steps = &assessment.phase_steps;
    let largest = (0..steps.len()).max_by_key(|&j| steps[j].count);
    let first = largest.unwrap_or(0).saturating_sub(MOST_POINTS / 2);
    let first = first.min(steps.len().saturating_sub(MOST_POINTS));
    let shown = &steps[first..(first + MOST_POINTS).min(steps.len())];
    let axis = |label: &str| Axis {
        label: label.to_owned(),
        scale: Scale::Linear,
    };
    let of = |value: fn(&super::StepResidual) -> f64| {
        let points = shown.iter().map(|step| Point {
            x: step.distance_m,
            y: value(step),
            interval: None,
        });
        points.collect::<Vec<Point>>()
    };
    let series = |label: &str, mark, colour, points| Series {
        label: label.to_owned(),
        mark,
        colour,
        points,
    };
    let counts = Panel {
        x: axis("distance of the phase step (m)"),
        y: axis("count"),
        series: vec![
            series("expected", Mark::Line, 0, of(|s| s.expected_count)),
            series("recorded", Mark::Dots, 1, of(|s| s.count as f64)),
        ],
        legend: Legend::UpperRight,
        headroom: 0.2,
    };
    let residuals = Panel {
        x: axis("distance of the phase step (m)"),
        y: axis("residual (standard deviations)"),
        series: vec![series("", Mark::Dots, 1, of(|s| s.residual_in_std))],
        legend: Legend::UpperRight,
        headroom: 0.0,
    };
    let chart = Chart {
        title: format!("{}: recorded counts and residuals", assessment.detector),
        panels: vec![counts, residuals],
    };
    chart.svg()
}
