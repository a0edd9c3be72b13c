//! The rows of a sweep: one for each point, detector and path.

use std::collections::HashSet;
use std::hash::{BuildHasher as _, BuildHasherDefault, DefaultHasher};

use super::axis::SweepAxis;
use super::points::{Sweep, SweepPoint};
use crate::report::chart::{Chart, ChartAxis, Mark, Panel};
use crate::report::table::{ColumnKind, Row, Table, TableCell, TableColumn, TableValue, fields};
use crate::simulate::path_statistics::PathStatistics;
use crate::simulate::repeat::Simulation;

/// A table of a sweep without rows: the point, the value of each axis, and what was found.
pub fn empty(axes: &[SweepAxis]) -> Table {
    let mut columns = vec![TableColumn::new("point", ColumnKind::Integer)];
    columns.extend(axes.iter().map(of_axis));
    columns.extend(found(&[]).columns);
    Table { columns, rows: Vec::new() }
}

fn of_axis(axis: &SweepAxis) -> TableColumn {
    let unit = axis.unit();
    TableColumn {
        name: axis.column(),
        kind: if unit.is_some() { ColumnKind::Number } else { ColumnKind::Text },
        unit: unit.filter(|unit| !unit.is_empty()).map(str::to_owned),
    }
}

/// What was found of some paths, in the columns behind those of the axes.
fn found(paths: &[(u64, &PathStatistics)]) -> Table {
    let columns = Table::of(paths)
        .column("detector", |(_, path)| path.detector.as_str())
        .column("source", |(_, path)| path.source.as_str())
        .column("path", |(_, path)| path.path.0 as u64)
        .column("repetitions", |(repetitions, _)| *repetitions);
    let columns = fields!(
        columns, (_, path) => path;
        estimates, missed_scans, missed_fraction, expected_missed_fraction, refused_fraction,
        true_distance_m, mean_distance_m, bias_m, bias_std_error_m, std_m, std_std_error_m,
        expected_bias_m, expected_std_m, expectation_holds, bound_m, detected_rate_cps
    );
    columns.column("remark", |(_, path)| remarks(path)).table()
}

/// The table of a point that was simulated.
pub(super) fn of_point(axes: &[SweepAxis], point: &SweepPoint, simulation: &Simulation) -> Table {
    let paths: Vec<(u64, &PathStatistics)> =
        simulation.estimates.iter().map(|path| (simulation.repetitions, path)).collect();
    let rows = found(&paths).rows.into_iter().map(|row| {
        let values = point_values(point).into_iter().chain(row.values);
        Row { values: values.collect(), ..row }
    });
    Table { rows: rows.collect(), ..empty(axes) }
}

/// The table of a point that the tier cannot do.
pub(super) fn refused(axes: &[SweepAxis], point: &SweepPoint, reason: &str) -> Table {
    let mut table = empty(axes);
    let mut values = point_values(point);
    values.resize(table.columns.len() - 1, TableValue::None);
    values.push(reason.value());
    table.rows.push(Row { name: String::new(), values });
    table
}

fn point_values(point: &SweepPoint) -> Vec<TableValue> {
    let values = point.values.iter().map(|(axis, value)| match (axis.unit(), value.number) {
        (Some(_), Some(number)) => TableValue::Number(number),
        _ => TableValue::Text(value.text.clone()),
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
    let contradicts =
        |row: &&Row| *table.value(row, "expectation_holds") == TableValue::Truth(false);
    table.rows.iter().filter(contradicts).count()
}

/// Most series: there are no more colours that people tell apart.
const MOST_SERIES: usize = 7;
/// Most values along the first axis: a plot has fewer pixels.
const MOST_VALUES: usize = 2_000;
/// What is drawn, but for the first axis.
const DRAWN: [&str; 6] =
    ["bias_m", "bias_std_error_m", "std_m", "std_std_error_m", "expected_bias_m", "expected_std_m"];

/// The plot of a sweep in the making: what it shows of the rows so far.
pub struct Plot<'s> {
    axes: &'s [SweepAxis],
    /// Points with one value of the first axis.
    stride: usize,
    /// It shows every so many values of the first axis.
    every: usize,
    /// Columns that are drawn, and the rows that are.
    shown: Table,
    names: Vec<String>,
    /// Names that there is no room for, by their hashes.
    left_out: HashSet<u64>,
}

impl Plot<'_> {
    /// A plot without rows.
    pub fn of(sweep: &Sweep) -> Plot<'_> {
        let axes = &sweep.options.over;
        let values = axes.first().map_or(1, |axis| axis.values.len());
        let mut shown = empty(axes);
        let along = axes.first().map_or_else(String::new, SweepAxis::column);
        shown.columns.retain(|column| column.name == along || DRAWN.contains(&&*column.name));
        Plot {
            axes,
            stride: sweep.len() / values,
            every: values.div_ceil(MOST_VALUES),
            shown,
            names: Vec::new(),
            left_out: HashSet::new(),
        }
    }

    /// Takes in rows of a table of the sweep.
    pub fn add(&mut self, table: &Table) {
        for row in &table.rows {
            // Points that were refused have no detector.
            if table.value(row, "detector").text().is_empty() {
                continue;
            }
            let name = self.series_name(table, row);
            if !self.names.contains(&name) {
                if self.names.len() == MOST_SERIES {
                    let hasher = BuildHasherDefault::<DefaultHasher>::default();
                    self.left_out.insert(hasher.hash_one(name));
                    continue;
                }
                self.names.push(name.clone());
            }
            let point = table.value(row, "point").number().unwrap_or_default() as usize;
            if (point / self.stride).is_multiple_of(self.every) {
                let columns = self.shown.columns.iter();
                let values = columns.map(|column| table.value(row, &column.name).clone());
                self.shown.rows.push(Row { name, values: values.collect() });
            }
        }
    }

    /// What it does not show, in words; the table of the name `table` has it.
    pub fn remarks(&self, plot: &str, table: &str) -> Vec<String> {
        let series = self.left_out.len();
        let series = (series > 0)
            .then(|| format!("{plot} has no room for {series} more series; {table} has all"));
        let values = self.axes.first().filter(|_| self.every > 1).map(|axis| {
            let (every, values, key) = (self.every, axis.values.len(), &axis.key);
            format!("{plot} shows 1 of {every} of the {values} values of {key}; {table} has all")
        });
        series.into_iter().chain(values).collect()
    }

    /// Draws it.
    pub fn svg(&self, scene: &str) -> String {
        let along = self.axes.first().map_or_else(String::new, SweepAxis::column);
        let x = match self.axes.first().is_some_and(|axis| axis.by_ratio) {
            true => ChartAxis::log(along.clone(), along),
            false => ChartAxis::linear(along.clone(), along),
        };
        let panel = |column: &str, label: &str| {
            Panel::new(x.clone(), ChartAxis::linear(column, label))
                .curves_of(&self.shown, &format!("expected_{column}"), Mark::Line)
                .curves(&self.shown, Mark::Dots)
        };
        let chart = Chart {
            title: format!("{scene} (dots: simulated, with 95 % intervals; lines: expected)"),
            panels: vec![panel("bias_m", "bias (mm)"), panel("std_m", "standard deviation (mm)")],
        };
        chart.svg()
    }

    /// What a row's series is called: the values of all axes but the first, and
    /// detector and path.
    fn series_name(&self, table: &Table, row: &Row) -> String {
        let others = self.axes.iter().skip(1).map(SweepAxis::column);
        let others = others.map(|column| format!("{column} {}", table.value(row, &column).text()));
        let [detector, path] = ["detector", "path"].map(|name| table.value(row, name).text());
        others.chain([format!("{detector}, path {path}")]).collect::<Vec<_>>().join(", ")
    }
}
