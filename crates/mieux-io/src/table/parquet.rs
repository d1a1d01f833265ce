//! Tables as Parquet, for data frames: one column of doubles each, missing values null, the remarks as metadata of the
//! file.

use std::sync::Arc;

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::Table;

impl Table {
    /// The bytes of a Parquet file. Columns are named as in [`Self::write_csv`]; the title and the remarks are metadata.
    ///
    /// # Errors
    /// That of the writer.
    pub fn to_parquet(&self) -> Result<Vec<u8>, ParquetError> {
        let column = |name: String| {
            let column = Type::primitive_type_builder(&name, Physical::DOUBLE);
            Ok(Arc::new(column.with_repetition(Repetition::OPTIONAL).build()?))
        };
        let columns: Result<Vec<_>, ParquetError> = self.columns.iter().map(|c| column(c.header())).collect();
        let schema = Arc::new(Type::group_type_builder("table").with_fields(columns?).build()?);
        let title = (!self.title.is_empty()).then(|| ("title".to_owned(), self.title.clone()));
        let remarks = title.into_iter().chain(self.metadata.iter().cloned());
        let remarks = remarks.map(|(key, value)| KeyValue::new(key, value)).collect();
        let properties = WriterProperties::builder().set_key_value_metadata(Some(remarks)).build();
        let mut bytes = Vec::new();
        let mut file = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties))?;
        let mut rows = file.next_row_group()?;
        for column in &self.columns {
            let Some(mut writer) = rows.next_column()? else { break };
            let present: Vec<i16> = column.values.iter().map(|value| i16::from(!value.is_nan())).collect();
            let values: Vec<f64> = column.values.iter().copied().filter(|value| !value.is_nan()).collect();
            writer.typed::<DoubleType>().write_batch(&values, Some(&present), None)?;
            writer.close()?;
        }
        rows.close()?;
        file.close()?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    use super::*;

    #[test]
    fn what_is_written_reads_back() {
        let table = Table::new("milk").with_metadata("material", "whole-milk");
        let table = table.with_column("wavelength", "nm", vec![450.0, 550.0]).unwrap();
        let table = table.with_column("g", "", vec![0.1 + 0.2, f64::NAN]).unwrap();
        let reader = SerializedFileReader::new(bytes::Bytes::from(table.to_parquet().unwrap())).unwrap();
        let remarks = reader.metadata().file_metadata().key_value_metadata().unwrap();
        assert!(remarks.contains(&KeyValue::new("title".into(), "milk".to_owned())));
        assert!(remarks.contains(&KeyValue::new("material".into(), "whole-milk".to_owned())));
        let rows: Vec<Vec<(String, Field)>> =
            reader.get_row_iter(None).unwrap().map(|row| row.unwrap().into_columns()).collect();
        let name = |name: &str, field| (name.to_owned(), field);
        assert_eq!(rows[0], [name("wavelength_nm", Field::Double(450.0)), name("g", Field::Double(0.1 + 0.2))]);
        assert_eq!(rows[1], [name("wavelength_nm", Field::Double(550.0)), name("g", Field::Null)]);
    }
}
