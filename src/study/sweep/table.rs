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
    /// `true` or `false`.
    Truth,
    /// Texts.
    Text,
}

/// A column of the table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its name; of numbers with a unit, with the unit.
    pub name: String,
    /// What it holds.
    pub kind: Kind,
    /// Unit of its numbers, where they have one.
    pub unit: Option<String>,
}

/// Columns behind those of the axes.
const COLUMNS: [(&str, Kind); 20] = [
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
    ("expectation_holds", Kind::Truth),
    ("bound_m", Kind::Number),
    ("detected_rate_cps", Kind::Number),
    ("remark", Kind::Text),
];

/// All rows, as the file has them: numbers in their shortest form that reads back to
/// the same double, empty where there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The columns, in their order.
    pub columns: Vec<Column>,
    /// The rows, point by point.
    pub rows: Vec<Vec<String>>,
}

/// A point's file is not what was written.
#[derive(Debug, thiserror::Error)]
#[error("a finished point cannot be read back: {0}; remove the sweep's folder, or name another")]
pub struct Unreadable(String);

impl Column {
    fn new(name: &str, kind: Kind) -> Column {
        let unit = match name.rsplit('_').next() {
            Some("m") => Some("m"),
            Some("cps") => Some("1/s"),
            _ => None,
        };
        Column { name: name.to_owned(), kind, unit: unit.map(str::to_owned) }
    }

    fn of_axis(axis: &Axis) -> Column {
        let unit = axis.unit();
        Column {
            name: axis.column(),
            kind: match unit {
                Some(_) => Kind::Number,
                None => Kind::Text,
            },
            unit: unit.filter(|unit| !unit.is_empty()).map(str::to_owned),
        }
    }

    /// Whether a field of a row is what the column holds.
    fn takes(&self, field: &str) -> bool {
        match self.kind {
            Kind::Integer => field.is_empty() || field.parse::<i64>().is_ok(),
            Kind::Number => field.is_empty() || field.parse::<f64>().is_ok(),
            Kind::Truth => field.is_empty() || field.parse::<bool>().is_ok(),
            Kind::Text => true,
        }
    }
}

impl Table {
    /// A table without rows.
    pub(crate) fn new(axes: &[Axis]) -> Table {
        let columns = std::iter::once(Column::new("point", Kind::Integer))
            .chain(axes.iter().map(Column::of_axis))
            .chain(COLUMNS.map(|(name, kind)| Column::new(name, kind)));
        Table { columns: columns.collect(), rows: Vec::new() }
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
                path.expectation_holds.map_or_else(String::new, |holds| holds.to_string()),
                number(path.bound_m),
                path.detected_rate_cps.to_string(),
                remarks(path),
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
        let heading: Vec<&str> = self.names().collect();
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
        if !heading.iter().eq(self.names()) {
            return Err(Unreadable("it has other columns".to_owned()));
        }
        for record in reader.records() {
            let record = record.map_err(unreadable)?;
            let mut fields = self.columns.iter().zip(&record);
            if let Some((column, field)) = fields.find(|(column, field)| !column.takes(field)) {
                let problem = format!("{} is \"{field}\", which is no number", column.name);
                return Err(Unreadable(problem));
            }
            self.rows.push(record.iter().map(str::to_owned).collect());
        }
        Ok(())
    }

    /// The whole table as CSV.
    pub fn csv(&self) -> String {
        self.file(&self.rows)
    }

    fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|column| column.name.as_str())
    }

    /// Rows whose scans contradict what is expected of them.
    pub fn contradicted(&self) -> usize {
        let place = self.place("expectation_holds");
        let contradicts = |row: &&Vec<String>| place.is_some_and(|place| row[place] == "false");
        self.rows.iter().filter(contradicts).count()
    }

    /// Whether no scans contradict what is expected of them.
    pub fn is_as_expected(&self) -> bool {
        self.contradicted() == 0
    }

    /// Place of a column.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    /// Every row as a JSON object.
    pub fn json(&self) -> Vec<Map<String, Json>> {
        let field = |column: &Column, text: &String| {
            let value = match column.kind {
                _ if text.is_empty() => Json::Null,
                Kind::Text => Json::String(text.clone()),
                Kind::Truth => text.parse::<bool>().map_or(Json::Null, Json::from),
                Kind::Integer => text.parse::<i64>().map_or(Json::Null, Json::from),
                Kind::Number => {
                    let number = text.parse().ok().and_then(Number::from_f64);
                    number.map_or(Json::Null, Json::Number)
                }
            };
            (column.name.clone(), value)
        };
        let object = |row: &Vec<String>| {
            let fields = self.columns.iter().zip(row);
            fields.map(|(column, text)| field(column, text)).collect()
        };
        self.rows.iter().map(object).collect()
    }
}

/// What is said of a path's row.
fn remarks(path: &PathStatistics) -> String {
    let contradiction = path.expectation_remark.as_ref();
    let contradiction = contradiction.map(|told| format!("the expectation does not hold: {told}"));
    let remarks: Vec<String> = contradiction.into_iter().chain(path.remark.clone()).collect();
    remarks.join("; ")
}

fn point_fields(point: &Point) -> Vec<String> {
    let values = point.values.iter().map(|(axis, value)| axis.field(value));
    std::iter::once(point.number.to_string()).chain(values).collect()
}
