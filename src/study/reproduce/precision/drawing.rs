//! How curves of precision are drawn.

use super::curve::{COLUMNS, Curve, POSITIONS, PowerPoint};
use crate::report::chart::{Axis, Legend, Mark, Panel, Point, Scale, Series};
use crate::study::reproduce::bias::level;
use crate::study::reproduce::figure::Table;
use crate::study::reproduce::statistics::Measured;

/// A grey that no data have.
const RING_COLOUR: usize = 6;

/// The data of curves.
pub fn table(curves: &[Curve]) -> Table {
    let mut table = Table::new(&COLUMNS);
    for curve in curves {
        curve.fill(&mut table);
    }
    table
}

/// Standard deviations over all positions, with rings where the coarse stage wavers.
pub fn std_panel(power_label: &str, curves: &[Curve]) -> Panel {
    let mut series = series_of(curves, |point| point.std_m().scaled(1e3));
    let rings = curves.iter().flat_map(|curve| {
        let wavering = curve.points.iter().filter(|point| point.wavers());
        wavering.map(|point| Point::new(point.power_pw, point.std_m().value * 1e3))
    });
    series.extend(ringed(rings.collect()));
    panel(power_label, "standard deviation (mm)", Scale::Log, series, Legend::UpperRight)
}

/// Biases, each the mean over all positions.
pub fn bias_panel(power_label: &str, curves: &[Curve]) -> Panel {
    let series = series_of(curves, |point| point.bias_m().scaled(1e3));
    panel(power_label, "bias (mm)", Scale::Linear, series, Legend::LowerLeft)
}

/// One curve's standard deviations position by position, with rings where the
/// coarse stage wavers, and lines at some limits.
pub fn positions_panel(power_label: &str, curve: &Curve, limits_mm: &[f64]) -> Panel {
    let mut rings = Vec::new();
    let mut series = Vec::new();
    for (number, position) in POSITIONS.iter().enumerate() {
        let at = |point: &PowerPoint| {
            let found = &point.positions[number];
            let drawn = dot(point.power_pw, found.errors.std_m.scaled(1e3));
            (drawn, found.wavers())
        };
        let drawn: Vec<(Point, bool)> = curve.points.iter().map(at).collect();
        rings.extend(drawn.iter().filter(|(_, wavers)| *wavers).map(|(p, _)| *p));
        series.push(Series {
            label: format!("{}, target + {position} T_s", curve.label),
            mark: Mark::LineAndDots,
            colour: number,
            points: drawn.into_iter().map(|(point, _)| point).collect(),
        });
    }
    let powers = || curve.points.iter().map(|point| point.power_pw);
    let ends = [powers().fold(f64::INFINITY, f64::min), powers().fold(f64::NEG_INFINITY, f64::max)];
    for limit_mm in limits_mm {
        series.push(level(format!("{limit_mm} mm"), *limit_mm, ends));
    }
    series.extend(ringed(rings));
    panel(
        power_label,
        "standard deviation (mm), by position of the target",
        Scale::Log,
        series,
        Legend::UpperRight,
    )
}

fn series_of(curves: &[Curve], value: impl Fn(&PowerPoint) -> Measured) -> Vec<Series> {
    let numbered = curves.iter().enumerate();
    let series = numbered.map(|(colour, curve)| Series {
        label: curve.label.clone(),
        mark: Mark::LineAndDots,
        colour,
        points: curve.points.iter().map(|point| dot(point.power_pw, value(point))).collect(),
    });
    series.collect()
}

/// A value with its interval.
pub fn dot(x: f64, shown: Measured) -> Point {
    Point { x, y: shown.value, interval: Some((shown.low, shown.high)) }
}

fn ringed(points: Vec<Point>) -> Option<Series> {
    let points: Vec<Point> = points.into_iter().map(|point| Point::new(point.x, point.y)).collect();
    (!points.is_empty()).then(|| Series {
        label: "coarse stage wavers".to_owned(),
        mark: Mark::Rings,
        colour: RING_COLOUR,
        points,
    })
}

/// A panel over powers.
pub fn panel(
    power_label: &str,
    label: &str,
    scale: Scale,
    series: Vec<Series>,
    legend: Legend,
) -> Panel {
    Panel {
        x: Axis { label: power_label.to_owned(), scale: Scale::Log },
        y: Axis { label: label.to_owned(), scale },
        series,
        legend,
        headroom: 0.06,
    }
}
