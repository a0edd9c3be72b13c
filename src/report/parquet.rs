//! Tables as Parquet files: int64, double, boolean and UTF-8 columns, null where the CSV has nothing.
//!
//! The format is Apache's, <https://parquet.apache.org/docs/file-format/>. Pages are not
//! compressed: dictionaries make short work of what repeats, and every reader takes them.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};

use super::table::{ColumnKind, Table, TableColumn, TableValue};

/// What is kept under `goldtof` for every reader, and where pandas keeps what it gives as
/// `DataFrame.attrs`.
const KEYS: [&str; 2] = ["goldtof", "PANDAS_ATTRS"];

/// A table could not be written as Parquet.
#[derive(Debug, thiserror::Error)]
#[error("the table cannot be written as Parquet: {0}")]
pub struct ParquetFailed(ParquetError);

impl Table {
    /// The unit of each column that has one, as a file says of itself.
    pub fn units(&self) -> BTreeMap<&str, &str> {
        let units = self.columns.iter().filter_map(|column| {
            let unit = column.unit.as_deref()?;
            Some((column.name.as_str(), unit))
        });
        units.collect()
    }
}

/// Writes tables with the columns of one, each as a group of rows: the same bytes for the same tables. The file's schema
/// is called `name`; its metadata have `about`, which is JSON, under `goldtof` and as the attributes of a
/// frame of pandas.
///
/// # Errors
/// When it cannot be written, or a part grows beyond what the format can number; what a table's making
/// fails with.
pub fn write<E: From<ParquetFailed>>(
    out: impl Write + Send,
    name: &str,
    about: &str,
    columns: &Table,
    tables: impl Iterator<Item = Result<Table, E>>,
) -> Result<(), E> {
    let metadata = KEYS.iter().map(|key| KeyValue::new((*key).to_owned(), about.to_owned()));
    let properties =
        WriterProperties::builder().set_key_value_metadata(Some(metadata.collect())).build();
    let schema = schema(columns, name).map_err(ParquetFailed)?;
    let file = SerializedFileWriter::new(out, schema, Arc::new(properties));
    let mut file = file.map_err(ParquetFailed)?;
    for table in tables {
        group(&mut file, &table?).map_err(ParquetFailed)?;
    }
    file.close().map_err(ParquetFailed)?;
    Ok(())
}

fn group(
    file: &mut SerializedFileWriter<impl Write + Send>,
    table: &Table,
) -> Result<(), ParquetError> {
    let mut group = file.next_row_group()?;
    let mut place = 0;
    while let Some(mut writer) = group.next_column()? {
        fill(table, place, &mut writer)?;
        writer.close()?;
        place += 1;
    }
    group.close()?;
    Ok(())
}

fn schema(table: &Table, name: &str) -> Result<TypePtr, ParquetError> {
    let field = |column: &TableColumn| -> Result<TypePtr, ParquetError> {
        let (physical, logical) = match column.kind {
            ColumnKind::Integer => (Physical::INT64, None),
            ColumnKind::Number => (Physical::DOUBLE, None),
            ColumnKind::Truth => (Physical::BOOLEAN, None),
            ColumnKind::Text | ColumnKind::Quoted => {
                (Physical::BYTE_ARRAY, Some(LogicalType::String))
            }
        };
        let field = Type::primitive_type_builder(&column.name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical);
        Ok(Arc::new(field.build()?))
    };
    let fields: Result<Vec<TypePtr>, ParquetError> = table.columns.iter().map(field).collect();
    Ok(Arc::new(Type::group_type_builder(name).with_fields(fields?).build()?))
}

/// Writes the column at `place`.
fn fill(
    table: &Table,
    place: usize,
    writer: &mut SerializedColumnWriter<'_>,
) -> Result<(), ParquetError> {
    match table.columns[place].kind {
        ColumnKind::Integer => column::<Int64Type>(table, place, writer, |value| match value {
            TableValue::Integer(number) => Some(*number),
            _ => None,
        }),
        ColumnKind::Number => column::<DoubleType>(table, place, writer, TableValue::number),
        ColumnKind::Truth => column::<BoolType>(table, place, writer, |value| match value {
            TableValue::Truth(truth) => Some(*truth),
            _ => None,
        }),
        ColumnKind::Text | ColumnKind::Quoted => {
            column::<ByteArrayType>(table, place, writer, |value| match value {
                TableValue::Text(text) if !text.is_empty() => Some(ByteArray::from(text.as_str())),
                _ => None,
            })
        }
    }
}

fn column<D: DataType>(
    table: &Table,
    place: usize,
    writer: &mut SerializedColumnWriter<'_>,
    value: impl Fn(&TableValue) -> Option<D::T>,
) -> Result<(), ParquetError> {
    let values = table.rows.iter().map(|row| value(&row.values[place]));
    let values: Vec<Option<D::T>> = values.collect();
    // 1 where there is a value, 0 where there is none; values are those that are there.
    let is_there: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let there: Vec<D::T> = values.into_iter().flatten().collect();
    writer.typed::<D>().write_batch(&there, Some(&is_there), None)?;
    Ok(())
}

/// What Parquet's own reader makes of the bytes. That an independent reader has the same of a
/// whole sweep is tested in `python/tests/test_sweep_tables.py`.
#[cfg(test)]
mod tests {
    use std::fs::File;

    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    use super::*;

    /// A row of every kind of column; fields that are not given are empty.
    #[derive(Default)]
    struct Given {
        number: Option<f64>,
        truth: Option<bool>,
        text: Option<String>,
    }

    fn table(rows: &[Given]) -> Table {
        Table::of(rows)
            .column("number", |row| row.number)
            .column("truth", |row| row.truth)
            .column("text", |row| row.text.clone())
            .table()
    }

    fn reader(table: &Table) -> SerializedFileReader<File> {
        let kept = tempfile::tempfile().unwrap();
        let tables = std::iter::once(Ok::<Table, ParquetFailed>(table.clone()));
        write(&kept, "name", "about", table, tables).unwrap();
        SerializedFileReader::new(kept).unwrap()
    }

    /// The fields of all rows, row by row.
    fn fields(table: &Table) -> Vec<Vec<Field>> {
        let reader = reader(table);
        let rows = reader.get_row_iter(None).unwrap();
        rows.map(|row| row.unwrap().into_columns().into_iter())
            .map(|columns| columns.map(|(_, field)| field).collect())
            .collect()
    }

    #[test]
    fn a_table_without_rows_has_all_columns_and_says_what_it_is() {
        let table = table(&[]);
        let reader = reader(&table);
        let file = reader.metadata().file_metadata();
        let names: Vec<&str> = file.schema().get_fields().iter().map(|c| c.name()).collect();
        assert_eq!((names, file.num_rows()), (vec!["number", "truth", "text"], 0));
        assert_eq!(file.schema().name(), "name");
        let about = file.key_value_metadata().unwrap();
        let about = about.iter().find(|about| about.key == "goldtof").unwrap();
        assert_eq!(about.value.as_deref(), Some("about"));
        assert!(fields(&table).is_empty());
    }

    #[test]
    fn fields_that_are_empty_are_null_in_columns_of_every_kind() {
        let truth = Given { truth: Some(false), ..Given::default() };
        let rows = fields(&table(&[truth, Given::default()]));
        assert_eq!(rows[0], [Field::Null, Field::Bool(false), Field::Null]);
        assert_eq!(rows[1], [Field::Null, Field::Null, Field::Null]);
    }

    #[test]
    fn numbers_come_back_bit_for_bit() {
        let numbers = [-0.0, f64::from_bits(1), 0.1, -f64::MAX];
        let rows = fields(&table(&numbers.map(|n| Given { number: Some(n), ..Given::default() })));
        for (row, number) in rows.iter().zip(numbers) {
            let Field::Double(found) = row[0] else {
                panic!("{row:?} has no double");
            };
            assert_eq!(found.to_bits(), number.to_bits());
        }
        let whole = [i64::MIN, -1, 0, i64::MAX];
        let mut table = Table::of(&whole).column("whole", |_| 0_u64).table();
        for (row, number) in table.rows.iter_mut().zip(whole) {
            row.values[0] = TableValue::Integer(number);
        }
        let rows = fields(&table).into_iter().flatten();
        assert_eq!(rows.collect::<Vec<_>>(), whole.map(Field::Long));
    }

    #[test]
    fn texts_come_back_whole_whatever_is_in_them() {
        let texts = ["a, \"b\"\nc", "\u{e4}\u{1f4a1}", " ", "null", "1", "\u{0}"];
        let given = texts.map(|text| Given { text: Some(text.to_owned()), ..Given::default() });
        let rows = fields(&table(&given));
        for (row, text) in rows.iter().zip(texts) {
            assert_eq!(row[2], Field::Str(text.to_owned()));
        }
    }

    /// A page has 20,000 rows at most, and a dictionary ends at 1 MiB.
    #[test]
    fn rows_of_several_pages_stay_in_their_order() {
        let text = |number: i64| format!("the remark of point {number:>12}");
        let value = |number: i64| (number % 3 != 0).then_some(number as f64 / 7.0);
        let given = |n: i64| Given { number: value(n), truth: None, text: Some(text(n)) };
        let rows = fields(&table(&(0..45_000).map(given).collect::<Vec<_>>()));
        assert_eq!(rows.len(), 45_000);
        for (number, row) in (0..).zip(rows) {
            let value = value(number).map_or(Field::Null, Field::Double);
            assert_eq!(row, [value, Field::Null, Field::Str(text(number))]);
        }
    }
}
