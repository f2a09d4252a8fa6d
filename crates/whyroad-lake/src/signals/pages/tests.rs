//! Decoded values equal those of the common Rust reader, for all ways to write the file: pages of both versions, with
//! dictionary and without, one page or many, compressed or not. What is cut off or damaged is an error, and no panic.

use super::*;
use arrow_array::cast::AsArray;
use arrow_array::types::UInt16Type;
use arrow_array::{
    Array, BooleanArray, DictionaryArray, Float64Array, Int64Array, RecordBatch, StringArray, UInt32Array,
};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::Compression;
use parquet::file::metadata::ParquetMetaDataReader;
use parquet::file::properties::{WriterProperties, WriterVersion};
use proptest::prelude::*;
use std::fs::File;
use std::io::Write;

/// How a file is written.
#[derive(Clone, Copy, Debug)]
struct Manner {
    version: WriterVersion,
    dictionary: bool,
    page_rows: usize,
    compression: Compression,
    deltas: bool,
}

fn manner() -> impl Strategy<Value = Manner> {
    let version = prop_oneof![Just(WriterVersion::PARQUET_1_0), Just(WriterVersion::PARQUET_2_0)];
    let compression = prop_oneof![Just(Compression::SNAPPY), Just(Compression::UNCOMPRESSED)];
    (version, any::<bool>(), 1usize..400, compression, any::<bool>()).prop_map(
        |(version, dictionary, page_rows, compression, deltas)| Manner {
            version,
            dictionary,
            page_rows,
            compression,
            deltas,
        },
    )
}

/// Rows in stretches: a number, whether it is known, how often it comes, whether it grows.
fn stretches() -> impl Strategy<Value = Vec<(i64, bool, usize, bool)>> {
    let value = prop_oneof![-3i64..9, any::<i64>()];
    prop::collection::vec((value, prop::bool::weighted(0.7), 1usize..120, any::<bool>()), 1..20)
}

fn batch(stretches: &[(i64, bool, usize, bool)]) -> RecordBatch {
    let rows = || {
        stretches.iter().flat_map(|(value, known, n, grows)| {
            (0..*n as i64).map(move |k| (*value, if *grows { value.wrapping_add(k) } else { *value }, *known))
        })
    };
    let texts =
        StringArray::from_iter(rows().map(|(first, _, known)| known.then(|| format!("word {}", first % 7))));
    let dictionary: DictionaryArray<UInt16Type> = texts.iter().collect();
    RecordBatch::try_from_iter_with_nullable([
        (
            "n",
            Arc::new(Float64Array::from_iter(rows().map(|(_, v, known)| known.then_some(v as f64 / 3.0))))
                as Arc<dyn Array>,
            true,
        ),
        (
            "f",
            Arc::new(BooleanArray::from_iter(rows().map(|(_, v, known)| known.then_some(v % 3 == 0)))),
            true,
        ),
        ("t", Arc::new(dictionary), true),
        ("i", Arc::new(Int64Array::from_iter_values(rows().map(|(_, v, _)| v))), false),
        ("u", Arc::new(UInt32Array::from_iter_values(rows().map(|(_, v, _)| v as u32))), false),
    ])
    .unwrap()
}

fn written(batch: &RecordBatch, manner: Manner) -> File {
    let mut properties = WriterProperties::builder()
        .set_writer_version(manner.version)
        .set_dictionary_enabled(manner.dictionary)
        .set_data_page_row_count_limit(manner.page_rows)
        .set_write_batch_size(manner.page_rows)
        .set_compression(manner.compression);
    if manner.deltas {
        for name in ["i", "u"] {
            properties = properties
                .set_column_dictionary_enabled(name.into(), false)
                .set_column_encoding(name.into(), Encoding::DELTA_BINARY_PACKED);
        }
    }
    // A dictionary array is always written with a dictionary by us.
    let properties = properties.set_column_dictionary_enabled("t".into(), true).build();
    let file = tempfile::tempfile().unwrap();
    let mut writer = ArrowWriter::try_new(&file, batch.schema(), Some(properties)).unwrap();
    writer.write(batch).unwrap();
    writer.close().unwrap();
    file
}

/// A value per row, as text; `-` where it is unknown.
fn printed(dense: &Dense, rows: usize) -> Vec<String> {
    let mut values: Vec<String> = match &dense.values {
        Values::Numbers(v) => v.iter().map(f64::to_string).collect(),
        Values::Integers(v) => v.iter().map(|x| x.to_string()).collect(),
        Values::Flags(v) => (0..v.len).map(|i| v.get(i).to_string()).collect(),
        Values::Texts(codes, texts) => codes.iter().map(|c| texts[usize::from(*c)].clone()).collect(),
    };
    values.reverse();
    let known = |i: usize| dense.known.as_ref().is_none_or(|k| k.get(i));
    let out = (0..rows).map(|i| if known(i) { values.pop().unwrap() } else { "-".to_owned() }).collect();
    assert_eq!(values.len(), 0, "a value for each known row");
    out
}

fn expected(column: &dyn Array) -> Vec<String> {
    let value = |i: usize| {
        let column = column.as_any();
        let texts = column.downcast_ref::<DictionaryArray<UInt16Type>>();
        if let Some(texts) = texts {
            let words = texts.values().as_string::<i32>();
            return words.value(texts.key(i).unwrap()).to_owned();
        }
        let number = column.downcast_ref::<Float64Array>().map(|c| c.value(i).to_string());
        let flag = || column.downcast_ref::<BooleanArray>().map(|c| c.value(i).to_string());
        let long = || column.downcast_ref::<Int64Array>().map(|c| c.value(i).to_string());
        // Without a sign in the schema, and as it is stored in 32 bits.
        let short = || column.downcast_ref::<UInt32Array>().map(|c| (c.value(i) as i32).to_string());
        number.or_else(flag).or_else(long).or_else(short).unwrap()
    };
    (0..column.len()).map(|i| if column.is_null(i) { "-".to_owned() } else { value(i) }).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn columns_are_what_the_common_reader_gives(stretches in stretches(), manner in manner()) {
        let batch = batch(&stretches);
        let mut file = written(&batch, manner);
        let rows = batch.num_rows();
        let reader = ParquetRecordBatchReaderBuilder::try_new(file.try_clone().unwrap()).unwrap();
        let read_back = reader.with_batch_size(rows).build().unwrap().next().unwrap().unwrap();
        let metadata = ParquetMetaDataReader::new().parse_and_finish(&file).unwrap();
        for (i, column) in read_back.columns().iter().enumerate() {
            let dense = read(&mut file, metadata.row_group(0).column(i), rows).unwrap();
            prop_assert_eq!(printed(&dense, rows), expected(column), "column {}", i);
            let nulls = column.null_count();
            prop_assert_eq!(dense.known.as_ref().map_or(0, |k| rows - k.ones), nulls);
        }
    }

    #[test]
    fn damaged_pages_are_an_error_or_other_values_but_no_panic(
        stretches in stretches(),
        manner in manner(),
        at in any::<prop::sample::Index>(),
        byte in any::<u8>(),
    ) {
        let batch = batch(&stretches);
        let mut file = written(&batch, manner);
        let metadata = ParquetMetaDataReader::new().parse_and_finish(&file).unwrap();
        let group = metadata.row_group(0);
        for column in group.columns() {
            let (start, length) = column.byte_range();
            file.seek(SeekFrom::Start(start + at.index(length as usize) as u64)).unwrap();
            file.write_all(&[byte]).unwrap();
            if let Ok(dense) = read(&mut file, column, batch.num_rows()) {
                let known = dense.known.as_ref().map_or(batch.num_rows(), |k| k.ones);
                let n = match &dense.values {
                    Values::Numbers(v) => v.len(),
                    Values::Integers(v) => v.len(),
                    Values::Flags(v) => v.len,
                    Values::Texts(v, _) => v.len(),
                };
                prop_assert_eq!(n, known);
            }
        }
    }
}

#[test]
fn a_column_of_another_length_is_an_error() {
    let batch = batch(&[(1, true, 100, true)]);
    let manner = Manner {
        version: WriterVersion::PARQUET_1_0,
        dictionary: false,
        page_rows: 1000,
        compression: Compression::SNAPPY,
        deltas: true,
    };
    let mut file = written(&batch, manner);
    let metadata = ParquetMetaDataReader::new().parse_and_finish(&file).unwrap();
    let column = metadata.row_group(0).column(0);
    assert!(read(&mut file, column, 100).is_ok());
    assert!(read(&mut file, column, 99).is_err());
    assert!(read(&mut file, column, 101).is_err());
    // Memory for a bit per row would end the process.
    assert!(read(&mut file, column, 1 << 62).is_err());
    // The file ends in the middle of the column.
    file.set_len(column.byte_range().0 + 10).unwrap();
    assert!(read(&mut file, column, 100).is_err());
}
