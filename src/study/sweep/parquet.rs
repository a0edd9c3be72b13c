//! A sweep's table as Parquet, with types and units.

use std::collections::HashMap;
use std::sync::Arc;

use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_writer::ArrowWriterOptions;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;

use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_schema::{ArrowError, DataType, Field, Schema};

use super::table::{Kind, Table};

/// Key of the file's metadata under which the sweep's definition stands.
const DEFINITION: &str = "goldtof.sweep";
/// Key of a field's metadata with its unit.
const UNIT: &str = "unit";

/// Why there is no Parquet file.
#[derive(Debug, thiserror::Error)]
pub enum NoParquet {
    /// The table does not fit its own schema.
    #[error("cannot make the Parquet table: {0}")]
    Table(#[from] ArrowError),
    /// It cannot be encoded.
    #[error("cannot write Parquet: {0}")]
    File(#[from] ParquetError),
}

impl Table {
    /// The whole table as a Parquet file: columns, rows and numbers of [`Table::csv`],
    /// null where that is empty; a field's unit is in its metadata under `unit`, the
    /// sweep's `definition` (JSON) in the file's under `goldtof.sweep`.
    ///
    /// # Errors
    /// When the numbers cannot be encoded.
    pub fn parquet(&self, definition: &str) -> Result<Vec<u8>, NoParquet> {
        let fields: Vec<Field> = (0..self.columns.len()).map(|at| self.field(at)).collect();
        let schema = Arc::new(Schema::new(fields));
        let arrays = (0..self.columns.len()).map(|at| self.array(at)).collect();
        let batch = RecordBatch::try_new(schema.clone(), arrays)?;
        let entry = KeyValue::new(DEFINITION.to_owned(), definition.to_owned());
        let properties = WriterProperties::builder()
            .set_created_by(format!("goldtof {}", env!("CARGO_PKG_VERSION")))
            .set_key_value_metadata(Some(vec![entry]))
            .build();
        let options = ArrowWriterOptions::new().with_properties(properties);
        let mut bytes = Vec::new();
        let mut writer = ArrowWriter::try_new_with_options(&mut bytes, schema, options)?;
        writer.write(&batch)?;
        writer.close()?;
        Ok(bytes)
    }

    fn field(&self, at: usize) -> Field {
        let (name, kind) = &self.columns[at];
        let data_type = match kind {
            Kind::Integer => DataType::Int64,
            Kind::Number => DataType::Float64,
            Kind::Text => DataType::Utf8,
        };
        let unit = self.units[at]
            .iter()
            .map(|unit| (UNIT.to_owned(), unit.clone()));
        Field::new(name, data_type, true).with_metadata(unit.collect::<HashMap<_, _>>())
    }

    fn array(&self, at: usize) -> ArrayRef {
        let texts = self.rows.iter().map(|row| row[at].as_str());
        match self.columns[at].1 {
            Kind::Integer => Arc::new(Int64Array::from_iter(texts.map(|text| text.parse().ok()))),
            Kind::Number => Arc::new(Float64Array::from_iter(texts.map(|text| text.parse().ok()))),
            Kind::Text => Arc::new(StringArray::from_iter(
                texts.map(|text| Some(text).filter(|text| !text.is_empty())),
            )),
        }
    }
}
