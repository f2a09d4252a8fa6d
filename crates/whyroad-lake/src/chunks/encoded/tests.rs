//! What is encoded here is what Parquet's own reader finds.
#![allow(clippy::unwrap_used)]

use crate::chunks::{Cells, ChunkWriter, Source};
use crate::file::properties;
use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt16Type};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::Compression;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::statistics::Statistics;
use proptest::prelude::*;
use std::sync::Arc;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::{Column, Tri};

/// Flags, words and texts that are always known, in one row group, as Parquet's reader finds them.
fn read_back(
    flags: &[Tri],
    codes: &[u16],
    names: &[&str],
    runs: &[(&str, usize)],
) -> (RecordBatch, Arc<ParquetMetaData>) {
    let text = || DataType::Dictionary(Box::new(DataType::UInt16), Box::new(DataType::Utf8));
    let schema = Schema::new(vec![
        Field::new("id", text(), false),
        Field::new("flag", DataType::Boolean, true),
        Field::new("word", text(), true),
    ]);
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut writer = ChunkWriter::create(file.path(), &schema, properties("row", vec![]).build()).unwrap();
    let names: Vec<String> = names.iter().map(|n| (*n).to_owned()).collect();
    let words = Column::Category { codes: codes.to_vec(), names: names.into() };
    let flags = Column::Flag(flags.to_vec());
    let cells = [Cells::Runs(runs), Cells::Signal(&flags), Cells::Signal(&words)];
    writer.row_group(codes.len(), &cells.map(Source::Cells)).unwrap();
    writer.finish().unwrap();
    let reader = ParquetRecordBatchReaderBuilder::try_new(file.reopen().unwrap()).unwrap();
    let metadata = Arc::clone(reader.metadata());
    let batch = reader.with_batch_size(codes.len().max(1)).build().unwrap().next();
    (batch.unwrap().unwrap(), metadata)
}

fn texts(batch: &RecordBatch, column: usize) -> Vec<Option<String>> {
    let words = batch.column(column).as_dictionary::<UInt16Type>();
    let values = words.values().as_string::<i32>();
    let text = |i: usize| words.key(i).map(|key| values.value(key).to_owned());
    (0..words.len()).map(text).collect()
}

fn check(flags: &[Tri], codes: &[u16], names: &[&str], runs: &[(&str, usize)]) {
    let (batch, metadata) = read_back(flags, codes, names, runs);
    let found: Vec<Option<bool>> = batch.column(1).as_boolean().iter().collect();
    assert_eq!(found, flags.iter().map(|f| f.known()).collect::<Vec<_>>());
    let word = |c: &u16| (*c != UNKNOWN_CODE).then(|| names[usize::from(*c)].to_owned());
    let expected: Vec<Option<String>> = codes.iter().map(word).collect();
    assert_eq!(texts(&batch, 2), expected);
    let repeated = runs.iter().flat_map(|(text, rows)| std::iter::repeat_n(Some((*text).to_owned()), *rows));
    assert_eq!(texts(&batch, 0), repeated.collect::<Vec<_>>());
    let group = metadata.row_group(0);
    let statistics = |column: usize| group.column(column).statistics().unwrap();
    let Statistics::Boolean(of_flags) = statistics(1) else { panic!("no flags") };
    let known = || found.iter().flatten();
    assert_eq!((of_flags.min_opt(), of_flags.max_opt()), (known().min(), known().max()));
    assert_eq!(statistics(1).null_count_opt(), Some((flags.len() - known().count()) as u64));
    let Statistics::ByteArray(of_words) = statistics(2) else { panic!("no words") };
    let bytes = |text: Option<&String>| text.map(|t| t.as_bytes().to_vec());
    let stated = |text: Option<&parquet::data_type::ByteArray>| text.map(|t| t.data().to_vec());
    assert_eq!(stated(of_words.min_opt()), bytes(expected.iter().flatten().min()));
    assert_eq!(stated(of_words.max_opt()), bytes(expected.iter().flatten().max()));
    assert_eq!(statistics(2).null_count_opt(), Some(expected.iter().filter(|w| w.is_none()).count() as u64));
}

fn repeated<T: Clone>(stretches: Vec<(T, usize)>, rows: usize, rest: T) -> Vec<T> {
    let all = stretches.into_iter().flat_map(|(value, n)| std::iter::repeat_n(value, n));
    all.chain(std::iter::repeat(rest)).take(rows).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn what_is_encoded_is_read(
        flags in prop::collection::vec((prop_oneof![Just(Tri::True), Just(Tri::False), Just(Tri::Unknown)],
            prop_oneof![1usize..4, 1usize..200]), 0..30),
        // Dictionaries of 1, 2, 3, 17 and 300 words.
        (codes, words) in prop_oneof![Just(1u16), Just(2), Just(3), Just(17), Just(300)].prop_flat_map(|n| {
            let code = prop_oneof![8 => 0..n, 1 => Just(UNKNOWN_CODE)];
            (prop::collection::vec((code, prop_oneof![3 => 1usize..3, 1 => 1usize..90]), 0..60), Just(n))
        }),
        rows in 1usize..2000,
        cut in any::<prop::sample::Index>(),
    ) {
        let names: Vec<String> = (0..words).map(|i| format!("word {}", (i * 7) % words)).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let at = cut.index(rows);
        let runs = [("drive", at), ("none", 0), ("other", rows - at)];
        check(&repeated(flags, rows, Tri::Unknown), &repeated(codes, rows, UNKNOWN_CODE), &names, &runs);
    }
}

#[test]
fn columns_of_several_pages_are_read() {
    let rows = 3 * super::PAGE_ROWS + 11;
    let flags: Vec<Tri> = (0..rows)
        .map(|i| match i % 70_001 {
            0..100 => Tri::Unknown,
            n => Tri::from(n % 3 == 0),
        })
        .collect();
    let codes: Vec<u16> = (0..rows).map(|i| if i < 70_000 { 1 } else { (i % 5) as u16 }).collect();
    let runs = [("a", 1), ("b", super::PAGE_ROWS), ("a", rows - super::PAGE_ROWS - 1)];
    check(&flags, &codes, &["v", "w", "x", "y", "z"], &runs);
}

#[test]
fn columns_in_which_nothing_is_known_are_read() {
    check(&[Tri::Unknown; 100], &[UNKNOWN_CODE; 100], &["a", "b"], &[("d", 100)]);
    check(&[Tri::Unknown; 100], &[UNKNOWN_CODE; 100], &[], &[("d", 100)]);
    // fastparquet fails at a dictionary without entries.
    let (_, metadata) = read_back(&[Tri::Unknown; 100], &[UNKNOWN_CODE; 100], &["a"], &[("d", 100)]);
    assert_eq!(metadata.row_group(0).column(2).dictionary_page_offset(), None);
    assert!(metadata.row_group(0).column(0).dictionary_page_offset().is_some());
}

/// Numbers in one row group, as Parquet's reader finds them; unknown is `None`.
fn numbers_read_back(numbers: &[f64]) -> (Vec<Option<u64>>, Arc<ParquetMetaData>) {
    let schema = Schema::new(vec![Field::new("number", DataType::Float64, true)]);
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut writer = ChunkWriter::create(file.path(), &schema, properties("row", vec![]).build()).unwrap();
    let column = Column::Number(numbers.to_vec());
    writer.row_group(numbers.len(), &[Source::Cells(Cells::Signal(&column))]).unwrap();
    writer.finish().unwrap();
    let reader = ParquetRecordBatchReaderBuilder::try_new(file.reopen().unwrap()).unwrap();
    let metadata = Arc::clone(reader.metadata());
    let batch = reader.with_batch_size(numbers.len().max(1)).build().unwrap().next().unwrap().unwrap();
    let found = batch.column(0).as_primitive::<Float64Type>().iter();
    (found.map(|x| x.map(f64::to_bits)).collect(), metadata)
}

fn check_numbers(numbers: &[f64]) -> Arc<ParquetMetaData> {
    let (found, metadata) = numbers_read_back(numbers);
    let known = |x: &f64| (!x.is_nan()).then(|| x.to_bits());
    assert_eq!(found, numbers.iter().map(known).collect::<Vec<_>>());
    let Some(Statistics::Double(of_numbers)) = metadata.row_group(0).column(0).statistics() else {
        panic!("no numbers")
    };
    let known = || numbers.iter().copied().filter(|x| !x.is_nan());
    // Zeros of either sign are equal.
    assert_eq!(of_numbers.min_opt().copied(), known().min_by(f64::total_cmp));
    assert_eq!(of_numbers.max_opt().copied(), known().max_by(f64::total_cmp));
    let nulls = numbers.len() - known().count();
    assert_eq!(of_numbers.null_count_opt(), Some(nulls as u64));
    metadata
}

/// A pseudo-random number from 1 to 2.
fn scattered(i: usize) -> f64 {
    let bits = (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5bd1_e995;
    f64::from_bits(0x3ff0_0000_0000_0000 | (bits.wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 12))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn numbers_are_read(
        stretches in prop::collection::vec((prop_oneof![
            2 => Just(f64::NAN), 1 => Just(0.0), 1 => Just(-0.0), 1 => Just(f64::INFINITY),
            4 => (0u8..40).prop_map(f64::from), 4 => any::<f64>(),
        ], prop_oneof![3 => 1usize..3, 1 => 1usize..200]), 0..200),
        rows in 1usize..3000,
    ) {
        check_numbers(&repeated(stretches, rows, f64::NAN));
    }
}

#[test]
fn numbers_of_several_pages_are_read() {
    let rows = 2 * super::PAGE_ROWS + 11;
    let hole = |i: usize, x: f64| if i % 1001 < 3 { f64::NAN } else { x };
    // A dictionary; numbers that occur once; numbers that occur once after a beginning in which they repeat.
    let few: Vec<f64> = (0..rows).map(|i| hole(i, scattered(i % 300))).collect();
    let single: Vec<f64> = (0..rows).map(|i| hole(i, scattered(i))).collect();
    let later: Vec<f64> = (0..rows).map(|i| if i < 9000 { 1.5 } else { scattered(i) }).collect();
    let column = |numbers: &[f64]| check_numbers(numbers).row_group(0).column(0).clone();
    assert!(column(&few).dictionary_page_offset().is_some());
    for numbers in [&single, &later] {
        assert_eq!(column(numbers).dictionary_page_offset(), None);
    }
    // Digits without order are not compressed; a long run is.
    assert_eq!(column(&single).compression(), Compression::UNCOMPRESSED);
    assert_eq!(column(&later).compression(), Compression::SNAPPY);
    assert!(column(&later).compressed_size() < column(&later).uncompressed_size());
}

#[test]
fn columns_without_numbers_are_read() {
    check_numbers(&[f64::NAN; 100]);
    check_numbers(&[0.0, -0.0]);
    check_numbers(&[7.0]);
}
