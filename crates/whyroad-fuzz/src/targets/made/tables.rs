//! Tables in Arrow's and Parquet's formats.

use arrow_array::builder::{Float64Builder, ListBuilder, StringBuilder};
use arrow_array::types::Int8Type;
use arrow_array::{
    ArrayRef, BooleanArray, Date32Array, Decimal128Array, DictionaryArray, DurationMillisecondArray,
    Float32Array, Float64Array, Int8Array, Int64Array, LargeStringArray, NullArray, RecordBatch, StringArray,
    StructArray, TimestampNanosecondArray, UInt16Array,
};
use arrow_ipc::CompressionType;
use arrow_ipc::writer::{FileWriter, IpcWriteOptions};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_writer::ArrowWriterOptions;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use std::sync::Arc;

const T0: i64 = 315_966_253_660_357_000;

fn numbers(rows: i64, value: impl Fn(f64) -> f64) -> ArrayRef {
    Arc::new(Float64Array::from_iter_values((0..rows).map(|i| value(i as f64))))
}

fn integers(rows: i64, value: impl Fn(i64) -> i64) -> ArrayRef {
    Arc::new(Int64Array::from_iter_values((0..rows).map(value)))
}

fn texts(rows: i64, value: &str) -> ArrayRef {
    Arc::new(StringArray::from_iter_values((0..rows).map(|_| value)))
}

fn batch(columns: Vec<(&str, ArrayRef)>) -> RecordBatch {
    RecordBatch::try_from_iter(columns).expect("the columns are equally long")
}

/// As AV2 writes it.
pub fn feather(batch: &RecordBatch) -> Vec<u8> {
    feather_with(batch, Some(CompressionType::LZ4_FRAME))
}

/// Packed and not.
pub fn feathers(batch: &RecordBatch) -> Vec<Vec<u8>> {
    vec![feather_with(batch, None), feather(batch)]
}

fn feather_with(batch: &RecordBatch, compression: Option<CompressionType>) -> Vec<u8> {
    let options = IpcWriteOptions::default().try_with_compression(compression);
    let mut out =
        FileWriter::try_new_with_options(Vec::new(), &batch.schema(), options.expect("LZ4 is built in"))
            .expect("a file in memory");
    out.write(batch).expect("written");
    out.into_inner().expect("finished")
}

/// With dictionaries and statistics.
pub fn parquet(batch: &RecordBatch) -> Vec<u8> {
    parquet_with(batch, ArrowWriterOptions::new())
}

/// Without dictionaries, statistics, compression and Arrow's own schema: most of its bytes are values.
pub fn plain_parquet(batch: &RecordBatch) -> Vec<u8> {
    let properties = WriterProperties::builder()
        .set_dictionary_enabled(false)
        .set_statistics_enabled(EnabledStatistics::None)
        .build();
    parquet_with(batch, ArrowWriterOptions::new().with_properties(properties).with_skip_arrow_metadata(true))
}

fn parquet_with(batch: &RecordBatch, options: ArrowWriterOptions) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut out =
        ArrowWriter::try_new_with_options(&mut bytes, batch.schema(), options).expect("a file in memory");
    out.write(batch).expect("written");
    out.close().expect("finished");
    bytes
}

pub fn annotations(rows: i64) -> RecordBatch {
    batch(vec![
        ("timestamp_ns", integers(rows, |i| T0 + i * 100_000_000)),
        ("track_uuid", texts(rows, "a")),
        ("category", texts(rows, "REGULAR_VEHICLE")),
        ("length_m", numbers(rows, |_| 4.5)),
        ("width_m", numbers(rows, |_| 1.8)),
        ("height_m", numbers(rows, |_| 1.5)),
        ("qw", numbers(rows, |_| 1.0)),
        ("qx", numbers(rows, |_| 0.0)),
        ("qy", numbers(rows, |_| 0.0)),
        ("qz", numbers(rows, |_| 0.0)),
        ("tx_m", numbers(rows, |i| 20.0 + i)),
        ("ty_m", numbers(rows, |_| 0.0)),
        ("tz_m", numbers(rows, |_| 0.5)),
        ("num_interior_pts", integers(rows, |_| 40)),
    ])
}

pub fn poses(rows: i64) -> RecordBatch {
    batch(vec![
        ("timestamp_ns", integers(rows, |i| T0 + i * 100_000_000)),
        ("qw", numbers(rows, |_| 1.0)),
        ("qx", numbers(rows, |_| 0.0)),
        ("qy", numbers(rows, |_| 0.0)),
        ("qz", numbers(rows, |_| 0.0)),
        ("tx_m", numbers(rows, |i| i)),
        ("ty_m", numbers(rows, |_| 0.0)),
        ("tz_m", numbers(rows, |_| 0.0)),
    ])
}

pub fn scenario(rows: i64) -> RecordBatch {
    batch(vec![
        ("observed", Arc::new(BooleanArray::from_iter((0..rows).map(|_| Some(true))))),
        ("track_id", texts(rows, "AV")),
        ("object_type", texts(rows, "vehicle")),
        ("timestep", integers(rows, |i| i)),
        ("position_x", numbers(rows, |i| i)),
        ("position_y", numbers(rows, |_| 0.0)),
        ("heading", numbers(rows, |_| 0.0)),
        ("velocity_x", numbers(rows, |_| 10.0)),
        ("velocity_y", numbers(rows, |_| 0.0)),
        ("num_timestamps", integers(rows, |_| rows)),
        ("start_timestamp", integers(rows, |_| T0)),
        ("city", texts(rows, "pittsburgh")),
    ])
}

pub fn table_ego(rows: i64) -> RecordBatch {
    batch(vec![
        ("time_s", numbers(rows, |i| i / 10.0)),
        ("x_m", numbers(rows, |i| i)),
        ("y_m", numbers(rows, |_| 0.0)),
        ("heading_rad", numbers(rows, |_| 0.0)),
    ])
}

pub fn egomotion(rows: i64) -> RecordBatch {
    batch(vec![
        ("timestamp", integers(rows, |i| i * 50_000)),
        ("qw", numbers(rows, |_| 1.0)),
        ("qx", numbers(rows, |_| 0.0)),
        ("qy", numbers(rows, |_| 0.0)),
        ("qz", numbers(rows, |_| 0.0)),
        ("x", numbers(rows, |i| 0.5 * i)),
        ("y", numbers(rows, |_| 0.0)),
        ("z", numbers(rows, |_| 0.0)),
        ("vx", numbers(rows, |_| 10.0)),
        ("vy", numbers(rows, |_| 0.0)),
    ])
}

pub fn obstacles(rows: i64) -> RecordBatch {
    batch(vec![
        ("timestamp_us", integers(rows, |i| i * 100_000)),
        ("track_id", texts(rows, "1")),
        ("label_class", texts(rows, "automobile")),
        ("center_x", numbers(rows, |_| 20.0)),
        ("center_y", numbers(rows, |_| 0.0)),
        ("center_z", numbers(rows, |_| 0.8)),
        ("size_x", numbers(rows, |_| 4.5)),
        ("size_y", numbers(rows, |_| 1.8)),
        ("size_z", numbers(rows, |_| 1.5)),
        ("orientation_x", numbers(rows, |_| 0.0)),
        ("orientation_y", numbers(rows, |_| 0.0)),
        ("orientation_z", numbers(rows, |_| 0.0)),
        ("orientation_w", numbers(rows, |_| 1.0)),
        ("reference_frame", texts(rows, "rig")),
        ("source", texts(rows, "lidar")),
    ])
}

pub fn pai_clips() -> RecordBatch {
    batch(vec![
        ("clip_id", texts(2, "25cd4769-5dcf-4b53-a351-bf2c5deb6124")),
        ("chunk", integers(2, |i| i)),
        ("clip_is_valid", Arc::new(BooleanArray::from(vec![true, false]))),
        ("country", texts(2, "Germany")),
        ("platform_class", texts(2, "hyperion_8")),
    ])
}

/// A column of each type that cells are read from, and some that they are not.
pub fn of_many_types() -> RecordBatch {
    let words = DictionaryArray::<Int8Type>::from_iter([Some("car"), None]);
    let decimals = Decimal128Array::from(vec![Some(1234), None]).with_precision_and_scale(10, 2);
    let mut lists = ListBuilder::new(Float64Builder::new());
    lists.append_value([Some(1.0), None]);
    lists.append_null();
    let mut names = ListBuilder::new(StringBuilder::new());
    names.append_value([Some("a"), Some("b")]);
    names.append_value([] as [Option<&str>; 0]);
    let parts: Vec<(&str, ArrayRef)> = vec![("x", numbers(2, |i| i)), ("y", texts(2, "y"))];
    let parts = StructArray::try_from(parts).expect("the columns are equally long");
    batch(vec![
        ("bool", Arc::new(BooleanArray::from(vec![Some(true), None]))),
        ("i8", Arc::new(Int8Array::from(vec![Some(-1), None]))),
        ("u16", Arc::new(UInt16Array::from(vec![7, 8]))),
        ("i64", integers(2, |i| T0 + i)),
        ("f32", Arc::new(Float32Array::from(vec![Some(0.1), None]))),
        ("f64", numbers(2, |i| i / 3.0)),
        ("text", texts(2, "12.5")),
        ("long", Arc::new(LargeStringArray::from(vec!["a", "b"]))),
        ("word", Arc::new(words)),
        ("time", Arc::new(TimestampNanosecondArray::from(vec![Some(T0), None]))),
        ("date", Arc::new(Date32Array::from(vec![20_000, -1]))),
        ("decimal", Arc::new(decimals.expect("ten digits"))),
        ("list", Arc::new(lists.finish())),
        ("names", Arc::new(names.finish())),
        ("parts", Arc::new(parts)),
    ])
}

/// Types that Feather has and Parquet does not write.
pub fn of_other_types() -> RecordBatch {
    batch(vec![
        ("null", Arc::new(NullArray::new(2))),
        ("span", Arc::new(DurationMillisecondArray::from(vec![Some(5), None]))),
    ])
}
