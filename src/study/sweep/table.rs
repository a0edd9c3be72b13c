//! The rows of a sweep: one for each point, detector and path.

use super::axis::Axis;
use super::points::Point;
use crate::report::table::{Cell, Column, Kind, Row, Table, Value};
use crate::simulate::path_statistics::PathStatistics;
use crate::simulate::repeat::Simulation;

/// A table of a sweep without rows: the point, the value of each axis, and what was found.
pub fn empty(axes: &[Axis]) -> Table {
    let mut columns = vec![Column::new("point", Kind::Integer)];
    columns.extend(axes.iter().map(of_axis));
    columns.extend(found(&[]).columns);
    Table { columns, rows: Vec::new() }
}

fn of_axis(axis: &Axis) -> Column {
    let unit = axis.unit();
    Column {
        name: axis.column(),
        kind: if unit.is_some() { Kind::Number } else { Kind::Text },
        unit: unit.filter(|unit| !unit.is_empty()).map(str::to_owned),
    }
}

/// What was found of some paths, in the columns behind those of the axes.
fn found(paths: &[(u64, &PathStatistics)]) -> Table {
    Table::of(paths)
        .column("detector", |(_, path)| path.detector.as_str())
        .column("source", |(_, path)| path.source.as_str())
        .column("path", |(_, path)| path.path.0 as u64)
        .column("repetitions", |(repetitions, _)| *repetitions)
        .column("estimates", |(_, path)| path.estimates)
        .column("missed_scans", |(_, path)| path.missed_scans)
        .column("missed_fraction", |(_, path)| path.missed_fraction)
        .column("expected_missed_fraction", |(_, path)| path.expected_missed_fraction)
        .column("true_distance_m", |(_, path)| path.true_distance_m)
        .column("mean_distance_m", |(_, path)| path.mean_distance_m)
        .column("bias_m", |(_, path)| path.bias_m)
        .column("bias_std_error_m", |(_, path)| path.bias_std_error_m)
        .column("std_m", |(_, path)| path.std_m)
        .column("std_std_error_m", |(_, path)| path.std_std_error_m)
        .column("expected_bias_m", |(_, path)| path.expected_bias_m)
        .column("expected_std_m", |(_, path)| path.expected_std_m)
        .column("expectation_holds", |(_, path)| path.expectation_holds)
        .column("bound_m", |(_, path)| path.bound_m)
        .column("detected_rate_cps", |(_, path)| path.detected_rate_cps)
        .column("remark", |(_, path)| remarks(path))
        .table()
}

/// The table of a point that was simulated.
pub(super) fn of_point(axes: &[Axis], point: &Point, simulation: &Simulation) -> Table {
    let paths: Vec<(u64, &PathStatistics)> =
        simulation.estimates.iter().map(|path| (simulation.repetitions, path)).collect();
    let rows = found(&paths).rows.into_iter().map(|row| {
        let values = point_values(point).into_iter().chain(row.values);
        Row { values: values.collect(), ..row }
    });
    Table { rows: rows.collect(), ..empty(axes) }
}

/// The table of a point that the tier cannot do.
pub(super) fn refused(axes: &[Axis], point: &Point, reason: &str) -> Table {
    let mut table = empty(axes);
    let mut values = point_values(point);
    values.resize(table.columns.len() - 1, Value::None);
    values.push(reason.value());
    table.rows.push(Row { name: String::new(), values });
    table
}

fn point_values(point: &Point) -> Vec<Value> {
    let values = point.values.iter().map(|(axis, value)| match (axis.unit(), value.number) {
        (Some(_), Some(number)) => Value::Number(number),
        _ => Value::Text(value.text.clone()),
    });
    std::iter::once((point.number as u64).value()).chain(values).collect()
}

/// What is said of a path's row.
fn remarks(path: &PathStatistics) -> String {
    let contradiction = path.expectation_remark.as_ref();
    let contradiction = contradiction.map(|told| format!("the expectation does not hold: {told}"));
    let remarks: Vec<String> = contradiction.into_iter().chain(path.remark.clone()).collect();
    remarks.join("; ")
}

/// Rows whose scans contradict what is expected of them.
pub fn contradicted(table: &Table) -> usize {
    let contradicts = |row: &&Row| *table.value(row, "expectation_holds") == Value::Truth(false);
    table.rows.iter().filter(contradicts).count()
}
