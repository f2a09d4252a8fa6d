//! Seeds that no fixture has: small files in the formats of others, made here.

pub mod containers;
pub mod tables;

use super::fixture;
use std::io::{Read as _, Write as _};

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
    let strings = npy("|S8", &format!("({rows},)"), &vec![7u8; 8 * rows]);
    [
        ("global_pose/frame_times", doubles(rows, 1, time)),
        ("global_pose/frame_positions", doubles(rows, 3, position)),
        ("global_pose/frame_velocities", doubles(rows, 3, |_, j| [1.0, 20.0, 3.0][j])),
        ("global_pose/frame_orientations", doubles(rows, 4, |_, j| [1.0, 0.0, 0.0, 0.0][j])),
        ("global_pose/frame_gps_times", doubles(rows, 2, |i, j| [2000.0, 100.0 + 0.05 * i as f64][j])),
        ("processed_log/CAN/speed/t", doubles(rows, 1, time)),
        ("processed_log/CAN/speed/value", doubles(rows, 1, |_, _| 20.0)),
        ("processed_log/CAN/radar/t", doubles(rows, 1, time)),
        (
            "processed_log/CAN/radar/value",
            doubles(rows, 7, |i, j| [30.0, 0.5, -1.0, f64::NAN, f64::NAN, 3.0, f64::from(i == 0)][j]),
        ),
        ("processed_log/CAN/raw_can/t", doubles(rows, 1, time)),
        ("processed_log/CAN/raw_can/src", longs(rows, |_| 0)),
        ("processed_log/CAN/raw_can/address", longs(rows, |i| if i % 2 == 0 { 36 } else { 548 })),
        ("processed_log/CAN/raw_can/data", strings),
        ("car.dbc", DBC.into()),
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

/// One message with a signal of each byte order, and names of values.
pub(super) const DBC: &str = "VERSION \"\"\n\nBO_ 36 BRAKE: 8 XXX\n SG_ BRON : 7|1@0+ (1,0) [0|1] \"\" XXX\n SG_ SPEED : \
    16|12@1- (0.5,-10) [0|0] \"km/h\" XXX\n\nVAL_ 36 BRON 1 \"on\" 0 \"off\" ;\n";

/// One lanelet, in meters and in degrees.
pub(super) const LANELET: &str = r#"<osm>
<node id="1" lat="49.00003" lon="8.0"><tag k="local_x" v="0"/><tag k="local_y" v="3.5"/><tag k="ele" v="1"/></node>
<node id="2" lat="49.00003" lon="8.0005"><tag k="local_x" v="40"/><tag k="local_y" v="3.5"/></node>
<node id="3" lat="49.0" lon="8.0"><tag k="local_x" v="0"/><tag k="local_y" v="0"/></node>
<node id="4" lat="49.0" lon="8.0005"><tag k="local_x" v="40"/><tag k="local_y" v="0"/></node>
<way id="10"><nd ref="1"/><nd ref="2"/><tag k="type" v="line_thin"/><tag k="subtype" v="dashed"/></way>
<way id="11"><nd ref="3"/><nd ref="4"/><tag k="type" v="curbstone"/></way>
<way id="12"><nd ref="2"/><nd ref="4"/><tag k="type" v="stop_line"/></way>
<relation id="20"><member type="way" ref="10" role="left"/><member type="way" ref="11" role="right"/>
<member type="relation" ref="21" role="regulatory_element"/><tag k="type" v="lanelet"/><tag k="subtype" v="road"/>
<tag k="location" v="urban"/><tag k="one_way" v="yes"/><tag k="speed_limit" v="30"/></relation>
<relation id="21"><member type="way" ref="12" role="ref_line"/><member type="way" ref="12" role="refers"/>
<tag k="type" v="regulatory_element"/><tag k="subtype" v="traffic_light"/></relation></osm>"#;

/// A building, a parking place, and signs by position and by lane.
pub(super) const SHAPES: &str = r#"<additional><poly id="p" type="parking" shape="0,0 5,0 5,5"/><poly id="b"
type="building.yes" shape="9,9 12,9 12,12"/><poi id="s" type="sign.stop" x="1" y="2"/><poi id="l" type="sign.speed_limit"
x="3" y="4" z="1"><param key="value" value="50"/></poi></additional>"#;

/// Streams by Python's `bz2.compress`: a text, nothing, and 260 different bytes before a run.
pub(super) fn bzip2() -> Vec<Vec<u8>> {
    const STREAMS: [&[&str]; 3] = [
        &[
            "425a683931415926535906ce0ffa0000031180400434c090a0200020aa83d41a08069a68bc65a4e36c214a791e7c5dc914e142401b383fe8",
        ],
        &["425a683917724538509000000000"],
        &[
            "425a6839314159265359bd32a38f000000ffffdede0d6af77c110a94f848471c06be4dd27650c4d45ba9b9eb23689b05",
            "3f8e383000db36901a68d309a623008c4c27a08cd0008606a6008310c1a26d068cd41a311342aa7a83269e83d48d034d",
            "323101a00064da23d47a8c6a683c6a9e90d07b2a7a8303400d1a0c9a068460d13464c0026080c9a606a7a9e404c1184d",
            "3688f51e81a269a626194d3d02608861a68e1a431793d66b568101645d2ffd47f9006203e9e33236910ae5c54f50fdee",
            "cb702bb00d9a76d8d4ac247f48b6fdc4ee89667e7ca599642920246f2abe77cf383eba66b424b19aa0748f5d7310ec17",
            "5a6abc9fd51be3f156180fa828eaee1189a57bee9a502f9786048aa4148e0391e9abde78c6427ef1093ef3ff4b031f24",
            "9000b08220a3bf1144a25a1248000a15de8e4b618cc8cd66183f61490d34583b901000f43cafbdf794276dc9195be075",
            "8d81c75d885b5d877e835a615d5b3fc18e4fe215597a3e3da2186c6fcd9bd68ef707f19bcb80354a5a9107fe2ee48a70",
            "a1217a65471e",
        ],
    ];
    let bytes = |hex: String| {
        (0..hex.len() / 2).filter_map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).ok()).collect()
    };
    STREAMS.iter().map(|parts| bytes(parts.concat())).collect()
}

/// Doubles in rows and columns, in the order of Fortran, integers, and byte strings.
pub(super) fn arrays() -> Vec<Vec<u8>> {
    let mut fortran = doubles(2, 3, |i, j| (i + j) as f64);
    if let Some(at) = fortran.windows(5).position(|w| w == b"False") {
        fortran[at..at + 5].copy_from_slice(b"True ");
    }
    vec![
        doubles(2, 1, |i, _| i as f64),
        doubles(2, 3, |i, j| (10 * i + j) as f64),
        fortran,
        longs(3, |i| i as i64),
        npy("|S8", "(2,)", &[7; 16]),
    ]
}

/// A part with its length in two bytes before it.
fn sized(part: &[u8], rest: &[u8]) -> Vec<u8> {
    [&(part.len() as u16).to_le_bytes(), part, rest].concat()
}

/// A definition and a message, in CDR with either end first and in ROS 1's form.
pub(super) fn ros_messages() -> Vec<Vec<u8>> {
    let definition = b"uint8 x\nint32 C=5\nuint32 y\nstring s\nB[] list\nfloat64[2] z\n============\nMSG: a/B\nint16 e\ntime t";
    let little = b"\0\x01\0\0\x07\0\0\0\x01\0\0\0\x03\0\0\0ab\0\0\x01\0\0\0\x05\0\0\0\x06\0\0\0\x07\0\0\0\0\0\0\0\0\0\xf8\x3f\0\0\0\0\0\0\xf8\x3f";
    let big = b"\0\0\0\0\x07\0\0\0\0\0\0\x01\0\0\0\x03ab\0\0\0\0\0\x01\0\x05\0\0\0\0\0\x06\0\0\0\x07\0\0\0\0\x3f\xf8\0\0\0\0\0\0\x3f\xf8\0\0\0\0\0\0";
    let ros1 = b"\x07\x01\0\0\0\x02\0\0\0ab\x01\0\0\0\x05\0\x06\0\0\0\x07\0\0\0\0\0\0\0\0\0\xf8\x3f\0\0\0\0\0\0\xf8\x3f";
    [little.as_slice(), big, ros1].map(|message| sized(definition, message)).to_vec()
}

/// A field of a protobuf message that holds bytes (fewer than 128).
fn bytes_field(number: u8, content: &[u8]) -> Vec<u8> {
    [&[number << 3 | 2, content.len() as u8], content].concat()
}

/// A schema (`google/protobuf/descriptor.proto`) of a message with a number, a text, integers and parts of its own
/// type, and such a message.
pub(super) fn protobuf_message() -> Vec<u8> {
    let field = |name: &str, number: u8, label: u8, kind: u8, of: &str| {
        let named = if of.is_empty() { Vec::new() } else { bytes_field(6, of.as_bytes()) };
        let numbers = [3 << 3, number, 4 << 3, label, 5 << 3, kind];
        bytes_field(2, &[bytes_field(1, name.as_bytes()), numbers.to_vec(), named].concat())
    };
    let fields = [
        field("x", 1, 1, 1, ""),
        field("s", 2, 1, 9, ""),
        field("n", 3, 3, 5, ""),
        field("a", 4, 3, 11, ".a.A"),
    ];
    let message = bytes_field(4, &[bytes_field(1, b"A"), fields.concat()].concat());
    let schema = bytes_field(1, &[bytes_field(2, b"a"), message].concat());
    let x = [&[1 << 3 | 1][..], &1.5_f64.to_le_bytes()].concat();
    let own = [x, bytes_field(2, b"text"), bytes_field(3, &[1, 0xac, 2])].concat();
    sized(&schema, &[bytes_field(4, &own), own.clone()].concat())
}

/// A TFRecord file of these records.
pub(super) fn tfrecord(records: &[&[u8]]) -> Vec<u8> {
    let mut out = Vec::new();
    for record in records {
        out.extend((record.len() as u64).to_le_bytes());
        out.extend([0; 4]);
        out.extend(*record);
        out.extend([0; 4]);
    }
    repair_tfrecord(&mut out);
    out
}

/// The records of the Waymo fixture, with the first `most` of all that repeats.
pub(super) fn waymo_records(most: usize) -> Vec<Vec<u8>> {
    let file = fixture("waymo/byhand.tfrecord-00000-of-00001");
    let (mut rest, mut out) = (file.as_slice(), Vec::new());
    while let Some(length) = rest.first_chunk::<8>().map(|n| u64::from_le_bytes(*n) as usize) {
        let Some(record) = rest.get(12..12 + length) else { break };
        out.push(super::cut::protobuf(record, most, 3));
        rest = rest.get(16 + length..).unwrap_or_default();
    }
    out
}

/// An archive of stored members (APPNOTE.TXT 4.3).
pub(super) fn zip(members: &[(&str, &[u8])]) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in members {
        let mut sum = flate2::Crc::new();
        sum.update(content);
        let (sum, size) = (sum.sum().to_le_bytes(), (content.len() as u32).to_le_bytes());
        let shared =
            [&[20, 0, 0, 0, 0, 0, 0, 0, 0, 0], &sum[..], &size, &size, &[name.len() as u8, 0, 0, 0]].concat();
        directory
            .extend([b"PK\x01\x02\x14\0", &shared[..], &[0; 10], &(out.len() as u32).to_le_bytes()].concat());
        directory.extend(name.bytes());
        out.extend([b"PK\x03\x04", &shared[..], name.as_bytes(), content].concat());
    }
    let count = [members.len() as u8, 0];
    let (size, start) = ((directory.len() as u32).to_le_bytes(), (out.len() as u32).to_le_bytes());
    out.extend(directory);
    out.extend([b"PK\x05\x06\0\0\0\0", &count[..], &count, &size, &start, &[0; 2]].concat());
    out
}
