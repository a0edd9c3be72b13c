//! The table as a Parquet file: int64, double and UTF-8 columns, null where the CSV has
//! nothing.
//!
//! The format is Apache's, <https://parquet.apache.org/docs/file-format/>. Pages are not
//! compressed: dictionaries make short work of what repeats, and every reader takes them.

use std::collections::BTreeMap;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};
use serde::Serialize;

use super::points::Sweep;
use super::store::Definition;
use super::table::{Column, Kind, Table};
use crate::scene::SceneReference;
use crate::version::VERSION;

/// Where pandas keeps what it gives as `DataFrame.attrs`.
const PANDAS_KEY: &str = "PANDAS_ATTRS";
/// The same for every other reader.
const KEY: &str = "goldtof";

/// The table could not be written as Parquet.
#[derive(Debug, thiserror::Error)]
#[error("the table cannot be written as Parquet: {0}; sweep.csv has all of it")]
pub struct ParquetFailed(#[from] ParquetError);

/// What the file says of itself, as JSON.
#[derive(Serialize)]
struct About<'a> {
    goldtof: &'a str,
    scene: SceneReference,
    sweep: Definition,
    units: BTreeMap<&'a str, &'a str>,
}

impl Table {
    /// The whole table as a Parquet file, the same bytes for the same sweep. Its metadata
    /// have, as JSON under `goldtof` and as the attributes of a frame of pandas, what the
    /// numbers are of and the unit of each column that has one.
    ///
    /// # Errors
    /// When a part grows beyond what the format can number.
    pub fn parquet(&self, sweep: &Sweep) -> Result<Vec<u8>, ParquetFailed> {
        let properties =
            WriterProperties::builder().set_key_value_metadata(Some(self.about(sweep))).build();
        let schema = self.schema()?;
        let mut bytes = Vec::new();
        let mut file = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties))?;
        let mut group = file.next_row_group()?;
        let mut place = 0;
        while let Some(mut writer) = group.next_column()? {
            self.fill(place, &mut writer)?;
            writer.close()?;
            place += 1;
        }
        group.close()?;
        file.close()?;
        Ok(bytes)
    }

    fn schema(&self) -> Result<TypePtr, ParquetError> {
        let field = |column: &Column| -> Result<TypePtr, ParquetError> {
            let (physical, logical) = match column.kind {
                Kind::Integer => (Physical::INT64, None),
                Kind::Number => (Physical::DOUBLE, None),
                Kind::Truth => (Physical::BOOLEAN, None),
                Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            };
            let field = Type::primitive_type_builder(&column.name, physical)
                .with_repetition(Repetition::OPTIONAL)
                .with_logical_type(logical);
            Ok(Arc::new(field.build()?))
        };
        let fields: Result<Vec<TypePtr>, ParquetError> = self.columns.iter().map(field).collect();
        let schema = Type::group_type_builder("sweep").with_fields(fields?);
        Ok(Arc::new(schema.build()?))
    }

    /// Writes the column at `place`.
    fn fill(
        &self,
        place: usize,
        writer: &mut SerializedColumnWriter<'_>,
    ) -> Result<(), ParquetError> {
        let texts = || self.rows.iter().map(|row| row[place].as_str());
        // 1 where there is a value, 0 where there is none; values are those that are there.
        let is_there: Vec<i16> = texts().map(|text| i16::from(!text.is_empty())).collect();
        let there = texts().filter(|text| !text.is_empty());
        match self.columns[place].kind {
            Kind::Integer => {
                let values: Vec<i64> = there.filter_map(|text| text.parse().ok()).collect();
                let writer = writer.typed::<Int64Type>();
                writer.write_batch(&values, Some(&is_there), None)?;
            }
            Kind::Number => {
                let values: Vec<f64> = there.filter_map(|text| text.parse().ok()).collect();
                let writer = writer.typed::<DoubleType>();
                writer.write_batch(&values, Some(&is_there), None)?;
            }
            Kind::Truth => {
                let values: Vec<bool> = there.filter_map(|text| text.parse().ok()).collect();
                let writer = writer.typed::<BoolType>();
                writer.write_batch(&values, Some(&is_there), None)?;
            }
            Kind::Text => {
                let values: Vec<ByteArray> = there.map(ByteArray::from).collect();
                let writer = writer.typed::<ByteArrayType>();
                writer.write_batch(&values, Some(&is_there), None)?;
            }
        }
        Ok(())
    }

    /// What the table is of, for every reader and for pandas.
    fn about(&self, sweep: &Sweep) -> Vec<KeyValue> {
        let units = self.columns.iter().filter_map(|column| {
            let unit = column.unit.as_deref()?;
            Some((column.name.as_str(), unit))
        });
        let about = About {
            goldtof: VERSION,
            scene: sweep.scene(),
            sweep: Definition::new(sweep),
            units: units.collect(),
        };
        // It is texts and numbers, which are always JSON.
        let text = serde_json::to_string(&about).unwrap_or_default();
        [KEY, PANDAS_KEY].map(|key| KeyValue::new(key.to_owned(), text.clone())).into()
    }
}

/// What Parquet's own reader makes of the bytes. That an independent reader has the same of a
/// whole sweep is tested in `python/tests/test_sweep_tables.py`.
#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::Write as _;

    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    use super::*;
    use crate::simulate::Tier;

    fn sweep() -> Sweep {
        Sweep {
            file: "scenes/quick.toml".to_owned(),
            text: include_str!("../../../scenes/quick.toml").to_owned(),
            settings: Vec::new(),
            axes: ["path.distance=3 m, 9 m", "estimate.estimator=fft, model"]
                .map(|axis| axis.parse().unwrap())
                .into(),
            repeat: 20,
            fidelity: Tier::Counts,
            estimator: None,
            seed: 7,
        }
    }

    /// A table of the sweep's columns. In its rows, fields that are not given are empty.
    fn table(rows: &[&[(&str, &str)]]) -> Table {
        let mut table = Table::new(&sweep().axes);
        for given in rows {
            let mut row = vec![String::new(); table.columns.len()];
            for (name, field) in *given {
                row[table.place(name).unwrap()] = (*field).to_owned();
            }
            table.rows.push(row);
        }
        table
    }

    fn reader(table: &Table) -> SerializedFileReader<File> {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&table.parquet(&sweep()).unwrap()).unwrap();
        SerializedFileReader::new(file).unwrap()
    }

    /// The fields of all rows, row by row.
    fn fields(table: &Table) -> Vec<Vec<Field>> {
        let reader = reader(table);
        let rows = reader.get_row_iter(None).unwrap();
        rows.map(|row| row.unwrap().into_columns().into_iter())
            .map(|columns| columns.map(|(_, field)| field).collect())
            .collect()
    }

    fn of_column(table: &Table, name: &str) -> Vec<Field> {
        let place = table.place(name).unwrap();
        let rows = fields(table).into_iter();
        rows.map(|mut row| row.swap_remove(place)).collect()
    }

    #[test]
    fn a_table_without_rows_has_all_columns() {
        let table = table(&[]);
        let reader = reader(&table);
        let file = reader.metadata().file_metadata();
        let columns = file.schema().get_fields();
        let names: Vec<&str> = columns.iter().map(|column| column.name()).collect();
        let expected: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
        assert_eq!((names, file.num_rows()), (expected, 0));
        assert!(fields(&table).is_empty());
    }

    #[test]
    fn fields_that_are_empty_are_null_in_columns_of_every_kind() {
        let only = [("point", "3"), ("expectation_holds", "false"), ("remark", "it moves")];
        let rows = fields(&table(&[&only, &[]]));
        let there = |row: &Vec<Field>| {
            let fields = row.iter().filter(|field| **field != Field::Null);
            fields.cloned().collect::<Vec<_>>()
        };
        let remark = Field::Str("it moves".to_owned());
        assert_eq!(there(&rows[0]), [Field::Long(3), Field::Bool(false), remark]);
        assert_eq!(there(&rows[1]), []);
    }

    #[test]
    fn numbers_come_back_bit_for_bit() {
        let whole = ["-9223372036854775808", "-1", "0", "9223372036854775807"];
        let number = ["-0", "5e-324", "0.1", "-1.7976931348623157e308"];
        let rows: Vec<[(&str, &str); 2]> =
            (0..4).map(|i| [("estimates", whole[i]), ("bias_m", number[i])]).collect();
        let rows: Vec<&[(&str, &str)]> = rows.iter().map(<[_; 2]>::as_slice).collect();
        let table = table(&rows);
        let expected = [i64::MIN, -1, 0, i64::MAX].map(Field::Long);
        assert_eq!(of_column(&table, "estimates"), expected);
        let bits = of_column(&table, "bias_m").into_iter().map(|field| {
            let Field::Double(number) = field else {
                panic!("{field} is no double");
            };
            number.to_bits()
        });
        let expected = [-0.0, f64::from_bits(1), 0.1, -f64::MAX].map(f64::to_bits);
        assert_eq!(bits.collect::<Vec<_>>(), expected);
    }

    #[test]
    fn texts_come_back_whole_whatever_is_in_them() {
        let texts = ["a, \"b\"\nc", "\u{e4}\u{1f4a1}", " ", "null", "1", "\u{0}"];
        let rows: Vec<[(&str, &str); 1]> = texts.iter().map(|text| [("remark", *text)]).collect();
        let rows: Vec<&[(&str, &str)]> = rows.iter().map(<[_; 1]>::as_slice).collect();
        let expected = texts.map(|text| Field::Str(text.to_owned()));
        assert_eq!(of_column(&table(&rows), "remark"), expected);
    }

    /// A page has 20,000 rows at most, and a dictionary ends at 1 MiB.
    #[test]
    fn rows_of_several_pages_stay_in_their_order() {
        let mut table = table(&[]);
        let names = ["point", "bias_m", "remark"];
        table.columns.retain(|column| names.contains(&column.name.as_str()));
        let remark = |number: i64| format!("the remark of point {number:>12}");
        let bias = |number: i64| (number % 3 != 0).then_some(number as f64 / 7.0);
        table.rows.extend((0..45_000).map(|number| {
            let bias = bias(number).map_or_else(String::new, |bias| bias.to_string());
            vec![number.to_string(), bias, remark(number)]
        }));
        let rows = fields(&table);
        assert_eq!(rows.len(), 45_000);
        for (number, row) in (0..).zip(rows) {
            let bias = bias(number).map_or(Field::Null, Field::Double);
            assert_eq!(row, [Field::Long(number), bias, Field::Str(remark(number))]);
        }
    }
}
