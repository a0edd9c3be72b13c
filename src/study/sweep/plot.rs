//! Bias and standard deviation over the first axis, a series for each value of the
//! others and each path.

use super::axis::Axis;
use crate::report::chart::{Axis as ChartAxis, Chart, Mark, Panel};
use crate::report::table::{Row, Table};

/// Most series: there are no more colours that people tell apart.
const MOST_SERIES: usize = 7;

/// The plot, and how many series it has no room for.
pub fn plot(table: &Table, title: &str, axes: &[Axis]) -> (String, usize) {
    // Without the rows of points that were refused.
    let ranged = table.only(|table, row| !table.value(row, "detector").text().is_empty());
    let ranged = ranged.named(|table, row| series_name(axes, table, row));
    let mut names: Vec<&str> = Vec::new();
    for row in &ranged.rows {
        if !names.contains(&row.name.as_str()) {
            names.push(&row.name);
        }
    }
    let left_out = names.len().saturating_sub(MOST_SERIES);
    let shown = ranged.only(|_, row| names.iter().take(MOST_SERIES).any(|name| *name == row.name));
    let along = axes.first().map_or_else(String::new, Axis::column);
    let x = match axes.first().is_some_and(|axis| axis.by_ratio) {
        true => ChartAxis::log(along.clone(), along),
        false => ChartAxis::linear(along.clone(), along),
    };
    let panel = |column: &str, label: &str| {
        Panel::new(x.clone(), ChartAxis::linear(column, label))
            .curves_of(&shown, &format!("expected_{column}"), Mark::Line)
            .curves(&shown, Mark::Dots)
    };
    let chart = Chart {
        title: format!("{title} (dots: simulated, with 95 % intervals; lines: expected)"),
        panels: vec![panel("bias_m", "bias (mm)"), panel("std_m", "standard deviation (mm)")],
    };
    (chart.svg(), left_out)
}

/// What a row's series is called: the values of all axes but the first, and
/// detector and path.
fn series_name(axes: &[Axis], table: &Table, row: &Row) -> String {
    let others = axes.iter().skip(1).map(Axis::column);
    let others = others.map(|column| format!("{column} {}", table.value(row, &column).text()));
    let [detector, path] = ["detector", "path"].map(|name| table.value(row, name).text());
    others.chain([format!("{detector}, path {path}")]).collect::<Vec<_>>().join(", ")
}
