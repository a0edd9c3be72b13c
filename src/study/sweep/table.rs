//! The rows of a sweep: one for each point, detector and path.

use serde_json::{Map, Number, Value as Json};

use super::axis::Axis;
use super::points::Point;
use crate::simulate::path_statistics::PathStatistics;
use crate::simulate::repeat::Simulation;

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Whole numbers.
    Integer,
    /// Numbers.
    Number,
    /// Texts.
    Text,
}

/// Columns behind those of the axes.
const COLUMNS: [(&str, Kind); 19] = [
    ("detector", Kind::Text),
    ("source", Kind::Text),
    ("path", Kind::Integer),
    ("repetitions", Kind::Integer),
    ("estimates", Kind::Integer),
    ("missed_scans", Kind::Integer),
    ("missed_fraction", Kind::Number),
    ("expected_missed_fraction", Kind::Number),
    ("true_distance_m", Kind::Number),
    ("mean_distance_m", Kind::Number),
    ("bias_m", Kind::Number),
    ("bias_std_error_m", Kind::Number),
    ("std_m", Kind::Number),
    ("std_std_error_m", Kind::Number),
    ("expected_bias_m", Kind::Number),
    ("expected_std_m", Kind::Number),
    ("bound_m", Kind::Number),
    ("detected_rate_cps", Kind::Number),
    ("remark", Kind::Text),
];

/// All rows, as the file has them: numbers in their shortest form that reads back to
/// the same double, empty where there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name and kind of each column.
    pub columns: Vec<(String, Kind)>,
    /// The rows, point by point.
    pub rows: Vec<Vec<String>>,
}

/// A point's file is not what was written.
#[derive(Debug, thiserror::Error)]
#[error("a finished point cannot be read back: {0}; remove the sweep's folder, or name another")]
pub struct Unreadable(String);

impl Table {
    /// A table without rows.
    pub(crate) fn new(axes: &[Axis]) -> Table {
        let of_axis = |axis: &Axis| match axis.unit() {
            Some(_) => (axis.column(), Kind::Number),
            None => (axis.column(), Kind::Text),
        };
        let point = [("point".to_owned(), Kind::Integer)];
        let others = COLUMNS.map(|(name, kind)| (name.to_owned(), kind));
        let columns = point.into_iter().chain(axes.iter().map(of_axis));
        Table {
            columns: columns.chain(others).collect(),
            rows: Vec::new(),
        }
    }

    /// The rows of a point that was simulated.
    pub(super) fn rows(&self, point: &Point, simulation: &Simulation) -> Vec<Vec<String>> {
        let of_path = |path: &PathStatistics| {
            let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
            let mut row = point_fields(point);
            row.extend([
                path.detector.clone(),
                path.source.clone(),
                path.path.to_string(),
                simulation.repetitions.to_string(),
                path.estimates.to_string(),
                path.missed_scans.to_string(),
                number(path.missed_fraction),
                number(path.expected_missed_fraction),
                path.true_distance_m.to_string(),
                number(path.mean_distance_m),
                number(path.bias_m),
                number(path.bias_std_error_m),
                number(path.std_m),
                number(path.std_std_error_m),
                number(path.expected_bias_m),
                number(path.expected_std_m),
                number(path.bound_m),
                path.detected_rate_cps.to_string(),
                path.remark.clone().unwrap_or_default(),
            ]);
            row
        };
        simulation.estimates.iter().map(of_path).collect()
    }

    /// The row of a point that the tier cannot do.
    pub(super) fn refused(&self, point: &Point, reason: &str) -> Vec<String> {
        let mut row = point_fields(point);
        row.resize(self.columns.len() - 1, String::new());
        row.push(reason.to_owned());
        row
    }

    /// Rows as a file, with the heading.
    pub(super) fn file(&self, rows: &[Vec<String>]) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let heading: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        // Neither can memory be full, nor has a row another number of fields.
        let _ = writer.write_record(&heading);
        for row in rows {
            let _ = writer.write_record(row);
        }
        let bytes = writer.into_inner().unwrap_or_default();
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// Adds the rows of a file.
    pub(crate) fn read(&mut self, text: &str) -> Result<(), Unreadable> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let unreadable = |error: csv::Error| Unreadable(error.to_string());
        let heading = reader.headers().map_err(unreadable)?;
        if !heading.iter().eq(self.columns.iter().map(|(name, _)| name)) {
            return Err(Unreadable("it has other columns".to_owned()));
        }
        for record in reader.records() {
            let record = record.map_err(unreadable)?;
            self.rows.push(record.iter().map(str::to_owned).collect());
        }
        Ok(())
    }

    /// The whole table as CSV.
    pub fn csv(&self) -> String {
        self.file(&self.rows)
    }

    /// The numbers of a column, NaN where there is none.
    pub fn numbers(&self, column: usize) -> impl Iterator<Item = f64> + '_ {
        let number = move |row: &Vec<String>| row[column].parse().unwrap_or(f64::NAN);
        self.rows.iter().map(number)
    }

    /// Place of a column.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|(column, _)| column == name)
    }

    /// Every row as a JSON object.
    pub fn json(&self) -> Vec<Map<String, Json>> {
        let field = |(name, kind): &(String, Kind), text: &String| {
            let value = match kind {
                _ if text.is_empty() => Json::Null,
                Kind::Text => Json::String(text.clone()),
                Kind::Integer => text.parse::<i64>().map_or(Json::Null, Json::from),
                Kind::Number => {
                    let number = text.parse().ok().and_then(Number::from_f64);
                    number.map_or(Json::Null, Json::Number)
                }
            };
            (name.clone(), value)
        };
        let object = |row: &Vec<String>| {
            let fields = self.columns.iter().zip(row);
            fields.map(|(column, text)| field(column, text)).collect()
        };
        self.rows.iter().map(object).collect()
    }
}

fn point_fields(point: &Point) -> Vec<String> {
    let values = point.values.iter().map(|(axis, value)| axis.field(value));
    std::iter::once(point.number.to_string())
        .chain(values)
        .collect()
}
