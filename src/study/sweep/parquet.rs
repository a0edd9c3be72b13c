//! The table as a Parquet file, with typed columns.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use super::table::{Kind, Table};

impl Table {
    /// The table as a Parquet file: one row group, uncompressed. Fields that are empty are
    /// null.
    ///
    /// # Errors
    /// When the library cannot make it.
    pub fn parquet(&self) -> Result<Vec<u8>, ParquetError> {
        let fields: Result<Vec<TypePtr>, ParquetError> = self
            .columns
            .iter()
            .map(|(name, kind)| field(name, *kind))
            .collect();
        let schema = Type::group_type_builder("sweep")
            .with_fields(fields?)
            .build()?;
        let properties = Arc::new(WriterProperties::builder().build());
        let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), properties)?;
        let mut group = writer.next_row_group()?;
        for (place, (_, kind)) in self.columns.iter().enumerate() {
            self.write_column(&mut group, place, *kind)?;
        }
        group.close()?;
        writer.into_inner()
    }

    fn write_column<W: Write + Send>(
        &self,
        group: &mut SerializedRowGroupWriter<W>,
        place: usize,
        kind: Kind,
    ) -> Result<(), ParquetError> {
        let Some(mut column) = group.next_column()? else {
            return Ok(());
        };
        let fields = || self.rows.iter().map(|row| row[place].as_str());
        // 1 where there is a value, 0 where there is none.
        let levels: Vec<i16> = fields().map(|field| i16::from(!field.is_empty())).collect();
        let there = fields().filter(|field| !field.is_empty());
        match kind {
            Kind::Integer => {
                let values: Vec<i64> = there.map(|field| field.parse().unwrap_or(0)).collect();
                column
                    .typed::<Int64Type>()
                    .write_batch(&values, Some(&levels), None)?;
            }
            Kind::Number => {
                let values: Vec<f64> = there.map(|f| f.parse().unwrap_or(f64::NAN)).collect();
                column
                    .typed::<DoubleType>()
                    .write_batch(&values, Some(&levels), None)?;
            }
            Kind::Text => {
                let values: Vec<ByteArray> = there.map(ByteArray::from).collect();
                column
                    .typed::<ByteArrayType>()
                    .write_batch(&values, Some(&levels), None)?;
            }
        }
        column.close()
    }
}

fn field(name: &str, kind: Kind) -> Result<TypePtr, ParquetError> {
    let physical = match kind {
        Kind::Integer => Physical::INT64,
        Kind::Number => Physical::DOUBLE,
        Kind::Text => Physical::BYTE_ARRAY,
    };
    let field = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
    let field = match kind {
        Kind::Text => field.with_converted_type(ConvertedType::UTF8),
        _ => field,
    };
    field.build().map(Arc::new)
}
