//! The table as a Parquet file: int64, double and UTF-8 columns, null where the CSV has
//! nothing.
//!
//! The format is Apache's, <https://parquet.apache.org/docs/file-format/>. Pages are not
//! compressed: dictionaries make short work of what repeats, and every reader takes them.

use std::collections::BTreeMap;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
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
        let properties = WriterProperties::builder()
            .set_key_value_metadata(Some(self.about(sweep)))
            .build();
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
        [KEY, PANDAS_KEY]
            .map(|key| KeyValue::new(key.to_owned(), text.clone()))
            .into()
    }
}
