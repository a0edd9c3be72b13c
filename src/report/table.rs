//! Tables whose columns are declared once, with name, unit and what a row has there. CSV, JSON,
//! Parquet and the curves of charts are made of them here, and nowhere else.

use serde_json::{Map, Number, Value as Json};

use super::coordinate::{AxisScale, ChartAxis, ChartPoint};
use crate::math::NORMAL_95;
use crate::printable::csv_field;

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// Whole numbers.
    Integer,
    /// Numbers.
    Number,
    /// `true` or `false`.
    Truth,
    /// Texts.
    Text,
    /// Texts that are in quotes in CSV, whatever they have in them.
    Quoted,
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableColumn {
    /// Its name; of numbers with a unit, with the unit.
    pub name: String,
    /// What it holds.
    pub kind: ColumnKind,
    /// Unit of its numbers, where they have one.
    pub unit: Option<String>,
}

/// What a row has in a column.
#[derive(Debug, Clone, PartialEq)]
pub enum TableValue {
    /// Nothing.
    None,
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// `true` or `false`.
    Truth(bool),
    /// A text.
    Text(String),
}

/// A row: what it has in each column, and the name of the curve that it is of.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name of its curve.
    pub name: String,
    /// A value for each column.
    pub values: Vec<TableValue>,
}

/// Rows in columns.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// The columns, in their order.
    pub columns: Vec<TableColumn>,
    /// The rows, in theirs.
    pub rows: Vec<Row>,
}

/// A text is not a table of these columns.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Unreadable(String);

/// What can stand in a column.
pub trait TableCell {
    /// The kind of such a column.
    const KIND: ColumnKind;
    /// What a row has there.
    fn value(self) -> TableValue;
}

/// A text that is always in quotes.
pub struct Quoted<'a>(pub &'a str);

/// Implements [`TableCell`].
macro_rules! cell {
    ($($type:ty: $kind:ident, $self:ident => $value:expr;)*) => {$(
        impl TableCell for $type {
            const KIND: ColumnKind = ColumnKind::$kind;
            fn value($self) -> TableValue { $value }
        }
    )*};
}

cell! {
    f64: Number, self => TableValue::Number(self);
    i64: Integer, self => TableValue::Integer(self);
    u64: Integer, self => i64::try_from(self).map_or(TableValue::Number(self as f64), TableValue::Integer);
    u32: Integer, self => TableValue::Integer(self.into());
    bool: Truth, self => TableValue::Truth(self);
    &str: Text, self => TableValue::Text(self.to_owned());
    String: Text, self => TableValue::Text(self);
    Quoted<'_>: Quoted, self => TableValue::Text(self.0.to_owned());
}

impl<C: TableCell> TableCell for Option<C> {
    const KIND: ColumnKind = C::KIND;
    fn value(self) -> TableValue {
        self.map_or(TableValue::None, TableCell::value)
    }
}

/// A number and the ends of its interval, where it has one.
pub trait WithInterval {
    /// The number, lower end, upper end.
    fn spread(self) -> [Option<f64>; 3];
}

impl WithInterval for f64 {
    fn spread(self) -> [Option<f64>; 3] {
        [Some(self), None, None]
    }
}

impl WithInterval for [Option<f64>; 3] {
    fn spread(self) -> [Option<f64>; 3] {
        self
    }
}

impl<S: WithInterval> WithInterval for Option<S> {
    fn spread(self) -> [Option<f64>; 3] {
        self.map_or([None; 3], WithInterval::spread)
    }
}

/// Declares columns named after the fields they show.
macro_rules! fields {
    ($columns:expr, $row:pat => $of:expr; $($field:ident),+) => {
        $columns$(.column(stringify!($field), |$row| $of.$field))+
    };
}
pub(crate) use fields;

/// A table in the making: its rows are of these.
pub struct Columns<'a, T> {
    of: &'a [T],
    table: Table,
}

impl<'a, T> Columns<'a, T> {
    /// Declares a column.
    pub fn column<C: TableCell>(
        mut self,
        name: &str,
        value: impl Fn(&'a T) -> C,
    ) -> Columns<'a, T> {
        self.table.columns.push(TableColumn::new(name, C::KIND));
        for (row, of) in self.table.rows.iter_mut().zip(self.of) {
            row.values.push(value(of).value());
        }
        self
    }

    /// Declares three: of numbers and of both ends of their intervals, `std_m`, `std_low_m` and
    /// `std_high_m`.
    pub fn interval<S: WithInterval>(
        self,
        name: &str,
        value: impl Fn(&'a T) -> S,
    ) -> Columns<'a, T> {
        let (stem, unit) = match name.strip_suffix("_m") {
            Some(stem) => (stem, "_m"),
            None => (name, ""),
        };
        self.column(name, |of| value(of).spread()[0])
            .column(&format!("{stem}_low{unit}"), |of| value(of).spread()[1])
            .column(&format!("{stem}_high{unit}"), |of| value(of).spread()[2])
    }

    /// The table, whose rows are named by its first column.
    pub fn table(mut self) -> Table {
        for row in &mut self.table.rows {
            row.name = row.values.first().map_or_else(String::new, TableValue::text);
        }
        self.table
    }
}

impl TableColumn {
    /// A column; its unit is the last part of its name.
    pub fn new(name: &str, kind: ColumnKind) -> TableColumn {
        let unit = match name.rsplit('_').next() {
            Some(unit @ ("m" | "s")) => Some(unit),
            Some("cps") => Some("1/s"),
            _ => None,
        };
        TableColumn { name: name.to_owned(), kind, unit: unit.map(str::to_owned) }
    }

    /// What a field of a CSV file is here; none if it is nothing that the column holds.
    pub fn read(&self, field: &str) -> Option<TableValue> {
        match self.kind {
            ColumnKind::Text | ColumnKind::Quoted => Some(TableValue::Text(field.to_owned())),
            _ if field.is_empty() => Some(TableValue::None),
            ColumnKind::Integer => field.parse().ok().map(TableValue::Integer),
            ColumnKind::Number => field.parse().ok().map(TableValue::Number),
            ColumnKind::Truth => field.parse().ok().map(TableValue::Truth),
        }
    }

    fn shown(&self, value: &TableValue) -> String {
        match self.kind {
            ColumnKind::Quoted => format!("\"{}\"", value.text()),
            _ => csv_field(&value.csv()),
        }
    }
}

impl TableValue {
    /// As CSV has it, without quotes: numbers in the fewest digits that read back to the same
    /// double, tiny and huge ones with an exponent.
    fn csv(&self) -> String {
        match *self {
            TableValue::Number(number)
                if number != 0.0 && !(1e-4..1e15).contains(&number.abs()) =>
            {
                format!("{number:e}")
            }
            _ => self.text(),
        }
    }

    /// As people read it: numbers in the fewest digits that read back to the same double.
    pub fn text(&self) -> String {
        match self {
            TableValue::None => String::new(),
            TableValue::Integer(number) => number.to_string(),
            TableValue::Number(number) => number.to_string(),
            TableValue::Truth(truth) => truth.to_string(),
            TableValue::Text(text) => text.clone(),
        }
    }

    /// Its number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match *self {
            TableValue::Integer(number) => Some(number as f64),
            TableValue::Number(number) => Some(number),
            _ => None,
        }
    }

    fn json(&self) -> Json {
        match self {
            TableValue::None => Json::Null,
            TableValue::Integer(number) => Json::from(*number),
            TableValue::Number(number) => {
                Number::from_f64(*number).map_or(Json::Null, Json::Number)
            }
            TableValue::Truth(truth) => Json::from(*truth),
            TableValue::Text(text) if text.is_empty() => Json::Null,
            TableValue::Text(text) => Json::from(text.as_str()),
        }
    }
}

impl Table {
    /// A row for each of these, whose columns are to be declared.
    pub fn of<T>(rows: &[T]) -> Columns<'_, T> {
        let row = Row { name: String::new(), values: Vec::new() };
        Columns { of: rows, table: Table { columns: Vec::new(), rows: vec![row; rows.len()] } }
    }

    /// Place of a column.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    /// What a row has in a column.
    pub fn value<'r>(&self, row: &'r Row, column: &str) -> &'r TableValue {
        self.place(column).and_then(|place| row.values.get(place)).unwrap_or(&TableValue::None)
    }

    /// The rows with a property.
    pub fn only(&self, has: impl Fn(&Table, &Row) -> bool) -> Table {
        let rows = self.rows.iter().filter(|row| has(self, row)).cloned();
        Table { columns: self.columns.clone(), rows: rows.collect() }
    }

    /// The rows that have something in a column.
    pub fn with(&self, column: &str) -> Table {
        self.only(|table, row| *table.value(row, column) != TableValue::None)
    }

    /// The same rows, of curves with other names.
    pub fn named(&self, name: impl Fn(&Table, &Row) -> String) -> Table {
        let row = |row: &Row| Row { name: name(self, row), values: row.values.clone() };
        Table { columns: self.columns.clone(), rows: self.rows.iter().map(row).collect() }
    }

    /// The rows of tables of the same columns, in one.
    pub fn joined(tables: &[Table]) -> Table {
        let rows = tables.iter().flat_map(|table| table.rows.iter().cloned());
        let columns = tables.first().map_or_else(Vec::new, |table| table.columns.clone());
        Table { columns, rows: rows.collect() }
    }

    /// Adds the rows of another table, and the columns that it alone has.
    pub fn append(&mut self, other: Table) {
        for column in &other.columns {
            if self.place(&column.name).is_none() {
                self.columns.push(column.clone());
            }
        }
        let number = self.columns.len();
        self.rows.iter_mut().for_each(|row| row.values.resize(number, TableValue::None));
        for row in &other.rows {
            let value = |column: &TableColumn| other.value(row, &column.name).clone();
            let values = self.columns.iter().map(value).collect();
            self.rows.push(Row { name: row.name.clone(), values });
        }
    }

    /// Names of the curves, in the order of the rows.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for row in &self.rows {
            if !names.contains(&row.name) {
                names.push(row.name.clone());
            }
        }
        names
    }

    /// The points of a curve in the units of the axes, in order of x. Texts along x stand side
    /// by side. A column of a value has its interval behind it: both ends, or a standard error.
    pub(super) fn points(
        &self,
        name: &str,
        x: &ChartAxis,
        (column, y): (&str, &ChartAxis),
    ) -> Vec<ChartPoint> {
        let (Some(at), Some(value)) = (self.place(&x.column), self.place(column)) else {
            return Vec::new();
        };
        let along = self.factor(at, x);
        let factor = self.factor(value, y);
        let number = |row: &Row, place: usize| Some(row.values.get(place)?.number()? * factor);
        let behind = |number: usize| self.columns.get(value + number).map_or("", |c| &c.name);
        let interval = |row: &Row, middle: f64| {
            if behind(1).contains("low") && behind(2).contains("high") {
                return number(row, value + 1).zip(number(row, value + 2));
            }
            let is_error = behind(1).contains("std_error");
            let half = NORMAL_95 * number(row, value + 1).filter(|_| is_error)?;
            Some((middle - half, middle + half))
        };
        let mut texts: Vec<&TableValue> = Vec::new();
        for found in self.rows.iter().map(|row| &row.values[at]) {
            if matches!(found, TableValue::Text(_)) && !texts.contains(&found) {
                texts.push(found);
            }
        }
        let point = |row: &Row| {
            let found = &row.values[at];
            let x = match found {
                TableValue::Text(_) => texts.iter().position(|text| *text == found)? as f64,
                _ => found.number()? * along,
            };
            let middle = number(row, value)?;
            // A size has no sign, and no end below zero.
            let is_size = y.scale == AxisScale::Log && middle < 0.0;
            let (y, interval) = match (is_size, interval(row, middle)) {
                (true, interval) => (-middle, interval.map(|(low, high)| (-high, -low))),
                (false, interval) => (middle, interval),
            };
            Some(ChartPoint { x, y, interval })
        };
        let named = self.rows.iter().filter(|row| row.name == name);
        let mut points: Vec<ChartPoint> = named.filter_map(point).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        points
    }

    /// What turns a column's numbers into the unit in the brackets of an axis.
    fn factor(&self, place: usize, axis: &ChartAxis) -> f64 {
        let shown = axis.label.split_once('(').map_or("", |(_, unit)| unit);
        let shown = shown.split([')', ' ']).next().unwrap_or_default();
        match (self.columns[place].unit.as_deref(), shown) {
            (Some("m"), "mm") | (Some("s"), "ms") => 1e3,
            (Some("s"), "us") => 1e6,
            (None, "%") => 1e2,
            _ => 1.0,
        }
    }

    /// The table as CSV (RFC 4180), heading first.
    pub fn csv(&self) -> String {
        self.heading() + &self.rows_csv()
    }

    /// The heading of the CSV.
    pub fn heading(&self) -> String {
        let names: Vec<_> = self.columns.iter().map(|column| csv_field(&column.name)).collect();
        names.join(",") + "\n"
    }

    /// The rows of the CSV.
    pub fn rows_csv(&self) -> String {
        let mut text = String::new();
        for row in &self.rows {
            let fields = self.columns.iter().zip(&row.values);
            let fields: Vec<String> = fields.map(|(column, value)| column.shown(value)).collect();
            text += &fields.join(",");
            text.push('\n');
        }
        text
    }

    /// Adds the rows of a CSV file.
    ///
    /// # Errors
    /// When it has other columns, or a field is nothing that its column holds.
    pub fn read_csv(&mut self, text: &str) -> Result<(), Unreadable> {
        let rows = text.strip_prefix(&self.heading());
        self.read_rows(rows.ok_or_else(|| Unreadable("it has other columns".to_owned()))?)
    }

    /// Adds rows as [`Table::rows_csv`] has them.
    ///
    /// # Errors
    /// When they have another number of fields, or one is nothing that its column holds.
    pub fn read_rows(&mut self, text: &str) -> Result<(), Unreadable> {
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_bytes());
        for record in reader.records() {
            let record = record.map_err(|error| Unreadable(error.to_string()))?;
            if record.len() != self.columns.len() {
                return Err(Unreadable("it has other columns".to_owned()));
            }
            let value = |(column, field): (&TableColumn, &str)| {
                let problem = || format!("{} is \"{field}\", which is not a number", column.name);
                column.read(field).ok_or_else(|| Unreadable(problem()))
            };
            let values: Result<Vec<TableValue>, _> =
                self.columns.iter().zip(&record).map(value).collect();
            self.rows.push(Row { name: String::new(), values: values? });
        }
        Ok(())
    }

    /// Every row as a JSON object.
    pub fn json(&self) -> Vec<Map<String, Json>> {
        let object = |row: &Row| {
            let fields = self.columns.iter().zip(&row.values);
            fields.map(|(column, value)| (column.name.clone(), value.json())).collect()
        };
        self.rows.iter().map(object).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let rows = [
            ("gold", Some(1.5), [0.25, -0.125, 0.5].map(Some)),
            ("gold, again", None, [Some(-2.0); 3]),
        ];
        Table::of(&rows)
            .column("series", |row| row.0)
            .column("time_s", |row| row.1)
            .interval("bias_m", |row| row.2)
            .column("holds", |row| row.1.map(|number| number > 1.0))
            .table()
    }

    #[test]
    fn missing_values_are_empty_fields_and_commas_stay_in_quotes() {
        let csv = "series,time_s,bias_m,bias_low_m,bias_high_m,holds\ngold,1.5,0.25,-0.125,0.5,true\n\
                   \"gold, again\",,-2,-2,-2,\n";
        assert_eq!(table().csv(), csv);
        let mut back = Table { rows: Vec::new(), ..table() };
        back.read_csv(csv).expect("it is the same table");
        assert_eq!((back.csv().as_str(), back.json()), (csv, table().json()));
        let other = csv.replace("1.5", "much");
        let error = back.read_csv(&other).expect_err("no number").to_string();
        assert!(error.contains("time_s is \"much\""), "{error}");
        assert!(back.read_csv("series\n").is_err());
        assert_eq!(csv_field("left, \"old\""), "\"left, \"\"old\"\"\"");
    }

    #[test]
    fn numbers_are_as_short_as_they_can_be_and_read_back_to_the_last_bit() {
        let numbers = [0.1 + 0.2, 100.0, 1e3, 0.25, 1e-3, 5e-324, f64::MAX, -2.5e-300, 0.0];
        let mut table = Table::of(&numbers).column("share", |&number| number).table();
        let csv = "share\n0.30000000000000004\n100\n1000\n0.25\n0.001\n5e-324\n\
                   1.7976931348623157e308\n-2.5e-300\n0\n";
        assert_eq!(table.csv(), csv);
        table.rows.clear();
        table.read_csv(csv).expect("it is the same table");
        assert!(table.rows.iter().map(|row| row.values[0].number()).eq(numbers.map(Some)));
    }

    #[test]
    fn curves_have_the_units_of_their_axes_and_intervals() {
        let x = ChartAxis::linear("time_s", "time (ms)");
        let points = |y: &ChartAxis| table().points("gold", &x, ("bias_m", y));
        let bias = ChartPoint { x: 1500.0, y: 250.0, interval: Some((-125.0, 500.0)) };
        assert_eq!(points(&ChartAxis::linear("bias_m", "bias (mm)")), [bias]);
        assert_eq!(points(&ChartAxis::linear("bias_m", "bias (m)"))[0].y, 0.25);
        // Without a place along x there is no point; of sizes there is no sign.
        let by_name = ChartAxis::linear("series", "");
        let size = table().points("gold, again", &by_name, ("bias_m", &ChartAxis::log("", "(mm)")));
        assert_eq!(size, [ChartPoint { x: 1.0, y: 2000.0, interval: Some((2000.0, 2000.0)) }]);
        assert!(table().points("gold, again", &x, ("bias_m", &by_name)).is_empty());
    }

    #[test]
    fn tables_are_joined_by_the_names_of_their_columns() {
        let mut both = Table::of(&["a"]).column("series", |&name| name).table();
        both.append(table().only(|table, row| table.value(row, "time_s").number().is_some()));
        assert_eq!(both.rows.len(), 2);
        assert!(both.csv().ends_with("a,,,,,\ngold,1.5,0.25,-0.125,0.5,true\n"), "{}", both.csv());
        assert_eq!(both.with("time_s").names(), ["gold"]);
    }
}
