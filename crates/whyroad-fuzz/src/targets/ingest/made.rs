//! Seeds that no fixture has: small files in the formats of others, made here.

use arrow_array::{ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_ipc::CompressionType;
use arrow_ipc::writer::{FileWriter, IpcWriteOptions};
use parquet::arrow::ArrowWriter;
use std::io::{Read as _, Write as _};
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

fn feather(batch: &RecordBatch) -> Vec<u8> {
    let options = IpcWriteOptions::default().try_with_compression(Some(CompressionType::LZ4_FRAME));
    let mut out =
        FileWriter::try_new_with_options(Vec::new(), &batch.schema(), options.expect("LZ4 is built in"))
            .expect("a file in memory");
    out.write(batch).expect("written");
    out.into_inner().expect("finished")
}

fn parquet(batch: &RecordBatch) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut out = ArrowWriter::try_new(&mut bytes, batch.schema(), None).expect("a file in memory");
    out.write(batch).expect("written");
    out.close().expect("finished");
    bytes
}

pub(super) fn annotations(rows: i64) -> Vec<u8> {
    feather(&batch(vec![
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
    ]))
}

pub(super) fn poses(rows: i64) -> Vec<u8> {
    feather(&batch(vec![
        ("timestamp_ns", integers(rows, |i| T0 + i * 100_000_000)),
        ("qw", numbers(rows, |_| 1.0)),
        ("qx", numbers(rows, |_| 0.0)),
        ("qy", numbers(rows, |_| 0.0)),
        ("qz", numbers(rows, |_| 0.0)),
        ("tx_m", numbers(rows, |i| i)),
        ("ty_m", numbers(rows, |_| 0.0)),
        ("tz_m", numbers(rows, |_| 0.0)),
    ]))
}

pub(super) fn av2_map() -> Vec<u8> {
    let line = |y: f64| {
        let points: Vec<String> =
            (0..4).map(|i| format!(r#"{{"x": {}.0, "y": {y:.1}, "z": 0.0}}"#, 20 * i)).collect();
        format!("[{}]", points.join(", "))
    };
    let lane = |id: u32, next: u32, y: f64, inside: bool| {
        format!(
            r#""{id}": {{"id": {id}, "is_intersection": {inside}, "lane_type": "VEHICLE", "left_lane_boundary": {},
            "right_lane_boundary": {}, "left_lane_mark_type": "DASHED_WHITE", "right_lane_mark_type": "NONE",
            "successors": [{next}], "predecessors": [], "left_neighbor_id": null, "right_neighbor_id": {next}}}"#,
            line(y + 1.8),
            line(y - 1.8)
        )
    };
    let text = format!(
        r#"{{"lane_segments": {{{}, {}}}, "pedestrian_crossings": {{"9": {{"id": 9, "edge1": {}, "edge2": {}}}}},
        "drivable_areas": {{"8": {{"id": 8, "area_boundary": {}}}}}}}"#,
        lane(1, 2, 0.0, false),
        lane(2, 1, 3.6, true),
        line(8.0),
        line(11.0),
        line(-4.0),
    );
    text.into_bytes()
}

pub(super) fn scenario(rows: i64) -> Vec<u8> {
    parquet(&batch(vec![
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
    ]))
}

pub(super) fn ego_parquet(rows: i64) -> Vec<u8> {
    parquet(&batch(vec![
        ("time_s", numbers(rows, |i| i / 10.0)),
        ("x_m", numbers(rows, |i| i)),
        ("y_m", numbers(rows, |_| 0.0)),
        ("heading_rad", numbers(rows, |_| 0.0)),
    ]))
}

/// A `.npy` file of doubles (version 1.0 of NumPy's format).
fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((header.len() as u16).to_le_bytes());
    out.extend(header.bytes());
    out.extend(data);
    out
}

fn doubles(rows: usize, columns: usize, value: impl Fn(usize, usize) -> f64) -> Vec<u8> {
    let data: Vec<u8> = (0..rows)
        .flat_map(|i| (0..columns).map(move |j| (i, j)))
        .flat_map(|(i, j)| value(i, j).to_le_bytes())
        .collect();
    let shape = if columns == 1 { format!("({rows},)") } else { format!("({rows}, {columns})") };
    npy("<f8", &shape, &data)
}

fn longs(rows: usize, value: impl Fn(usize) -> i64) -> Vec<u8> {
    let data: Vec<u8> = (0..rows).flat_map(|i| value(i).to_le_bytes()).collect();
    npy("<i8", &format!("({rows},)"), &data)
}

pub(super) fn comma_segment(rows: usize) -> Vec<(String, Vec<u8>)> {
    let time = |i: usize, _: usize| 1000.0 + 0.05 * i as f64;
    let position = |i: usize, j: usize| [-2_700_000.0 + i as f64, -4_300_000.0, 3_850_000.0][j];
    let dbc = "VERSION \"\"\n\nBO_ 36 BRAKE: 8 XXX\n SG_ BRON : 7|1@0+ (1,0) [0|1] \"\" XXX\n\nVAL_ 36 BRON 1 \"on\" 0 \"off\" ;\n";
    let strings = npy("|S8", &format!("({rows},)"), &vec![7u8; 8 * rows]);
    [
        ("1/global_pose/frame_times", doubles(rows, 1, time)),
        ("1/global_pose/frame_positions", doubles(rows, 3, position)),
        ("1/global_pose/frame_velocities", doubles(rows, 3, |_, j| [1.0, 20.0, 3.0][j])),
        ("1/global_pose/frame_orientations", doubles(rows, 4, |_, j| [1.0, 0.0, 0.0, 0.0][j])),
        ("1/global_pose/frame_gps_times", doubles(rows, 2, |i, j| [2000.0, 100.0 + 0.05 * i as f64][j])),
        ("1/processed_log/CAN/speed/t", doubles(rows, 1, time)),
        ("1/processed_log/CAN/speed/value", doubles(rows, 1, |_, _| 20.0)),
        ("1/processed_log/CAN/radar/t", doubles(rows, 1, time)),
        (
            "1/processed_log/CAN/radar/value",
            doubles(rows, 7, |i, j| [30.0, 0.5, -1.0, f64::NAN, f64::NAN, 3.0, f64::from(i == 0)][j]),
        ),
        ("1/processed_log/CAN/raw_can/t", doubles(rows, 1, time)),
        ("1/processed_log/CAN/raw_can/src", longs(rows, |_| 0)),
        ("1/processed_log/CAN/raw_can/address", longs(rows, |i| if i % 2 == 0 { 36 } else { 548 })),
        ("1/processed_log/CAN/raw_can/data", strings),
        ("car.dbc", dbc.into()),
    ]
    .map(|(name, content)| (name.to_owned(), content))
    .to_vec()
}

pub(super) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    out.write_all(bytes).expect("written to memory");
    out.finish().expect("written to memory")
}

pub(super) fn gunzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    flate2::read::GzDecoder::new(bytes).read_to_end(&mut out).expect("a fixture");
    out
}

/// The MCAP fixtures without compression and checksums, so that mutations reach schemas and messages: the records of
/// each chunk directly in the file.
pub(super) fn unchunked_mcap() -> Vec<Vec<u8>> {
    vec![super::fixture("mcap/fleet.mcap")]
}

/// Puts right the lengths' and records' checksums of a TFRecord file, as far as its lengths lead.
#[allow(clippy::ptr_arg, reason = "the type of a target's `repair`")]
pub(super) fn repair_tfrecord(bytes: &mut Vec<u8>) {
    let mut at = 0;
    while let Some(length) = bytes.get(at..at + 8) {
        let length = length.iter().rev().fold(0u64, |n, &b| n << 8 | u64::from(b));
        let sum = masked(&bytes[at..at + 8]).to_le_bytes();
        let Some(place) = bytes.get_mut(at + 8..at + 12) else { return };
        place.copy_from_slice(&sum);
        let Some(end) = usize::try_from(length).ok().and_then(|n| (at + 12).checked_add(n)) else { return };
        let Some(record) = bytes.get(at + 12..end) else { return };
        let sum = masked(record).to_le_bytes();
        let Some(place) = bytes.get_mut(end..end + 4) else { return };
        place.copy_from_slice(&sum);
        at = end + 4;
    }
}

/// CRC-32C (RFC 3720 B.4), masked as TFRecord does.
fn masked(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0x82f6_3b78 } else { c >> 1 })
    };
    (!bytes.iter().fold(!0u32, step)).rotate_right(15).wrapping_add(0xa282_ead8)
}
