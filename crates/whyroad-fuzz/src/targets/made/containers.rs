//! Recordings of few messages: the fixtures' own records, those of a topic but the first ones left out.

use super::super::fixture;
use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};

const MCAP: &[u8] = b"\x89MCAP0\r\n";
const BAG: &[u8] = b"#ROSBAG V2.0\n";

/// A record of MCAP: what it is, and its content.
type Record = (u8, Vec<u8>);

fn u64_at(bytes: &[u8], at: usize) -> usize {
    bytes[at..at + 8].iter().rev().fold(0, |n, &b| n << 8 | usize::from(b))
}

fn u32_at(bytes: &[u8], at: usize) -> usize {
    bytes[at..at + 4].iter().rev().fold(0, |n, &b| n << 8 | usize::from(b))
}

/// Schemas, channels and messages of a file, those in chunks, too.
fn records(mut bytes: &[u8], out: &mut Vec<Record>) {
    while bytes.len() >= 9 {
        let (op, length) = (bytes[0], u64_at(bytes, 1));
        let body = &bytes[9..9 + length];
        match op {
            0x03..=0x05 => out.push((op, body.to_vec())),
            0x06 => {
                let words = u32_at(body, 28);
                let packed = &body[32 + words + 8..];
                let mut unpacked = Vec::new();
                match &body[32..32 + words] {
                    b"lz4" => lz4_flex::frame::FrameDecoder::new(packed).read_to_end(&mut unpacked),
                    b"zstd" => ruzstd::decoding::StreamingDecoder::new(packed)
                        .expect("a fixture")
                        .read_to_end(&mut unpacked),
                    _ => (&mut &*packed).read_to_end(&mut unpacked),
                }
                .expect("a fixture");
                records(&unpacked, out);
            }
            0x0f => return,
            _ => {}
        }
        bytes = &bytes[9 + length..];
    }
}

fn framed(records: &[Record]) -> Vec<u8> {
    let mut out = Vec::new();
    for (op, body) in records {
        out.push(*op);
        out.extend((body.len() as u64).to_le_bytes());
        out.extend(body);
    }
    out
}

/// A file of these records, each by itself or all in a chunk without a checksum.
fn mcap(records: &[Record], chunk: Option<&str>) -> Vec<u8> {
    let content = framed(records);
    let body = match chunk {
        None => content,
        Some(compression) => {
            let packed = if compression == "lz4" { lz4(&content) } else { content.clone() };
            let mut chunk = vec![0; 16];
            chunk.extend((content.len() as u64).to_le_bytes());
            chunk.extend([0; 4]);
            chunk.extend((compression.len() as u32).to_le_bytes());
            chunk.extend(compression.bytes());
            chunk.extend((packed.len() as u64).to_le_bytes());
            chunk.extend(packed);
            framed(&[(0x06, chunk)])
        }
    };
    let end = framed(&[(0x0f, vec![0; 4]), (0x02, vec![0; 20])]);
    [MCAP, &framed(&[(0x01, vec![0; 8])]), &body, &end, MCAP].concat()
}

fn lz4(bytes: &[u8]) -> Vec<u8> {
    let mut out = lz4_flex::frame::FrameEncoder::new(Vec::new());
    out.write_all(bytes).expect("written to memory");
    out.finish().expect("written to memory")
}

/// The first `most` messages of each channel, and what they need.
fn first_messages(name: &str, most: usize) -> Vec<Record> {
    let mut all = Vec::new();
    let file = fixture(name);
    records(file.get(MCAP.len()..).unwrap_or_default(), &mut all);
    let mut seen: BTreeMap<Vec<u8>, usize> = BTreeMap::new();
    all.retain(|(op, body)| {
        // Schemas and channels come again in the summary, messages are counted by their channel.
        let (key, most) =
            if *op == 0x05 { (body[..2].to_vec(), most) } else { ([&[*op], &body[..2]].concat(), 1) };
        let count = seen.entry(key).or_default();
        *count += 1;
        *count <= most
    });
    all
}

/// Recordings in ROS 2's, protobuf's and JSON's encoding, with `most` messages of each channel.
pub fn mcaps(most: usize) -> Vec<Vec<u8>> {
    let all = ["mcap/ros2_lz4.mcap", "mcap/foxglove_zstd.mcap", "mcap/fleet.mcap"]
        .map(|name| first_messages(name, most));
    let mut out: Vec<Vec<u8>> = all.iter().map(|records| mcap(records, None)).collect();
    out.push(mcap(&all[2], Some("")));
    out.push(mcap(&all[2], Some("lz4")));
    out
}

/// The recording in JSON, which needs a mapping.
pub fn fleet(most: usize) -> Vec<u8> {
    mcap(&first_messages("mcap/fleet.mcap", most), None)
}

/// A record of a bag: its header and its data.
fn bag_record(header: &[u8], data: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    for part in [header, data] {
        out.extend((part.len() as u32).to_le_bytes());
        out.extend(part);
    }
    out
}

/// The value of a field of a record's header.
fn field<'h>(mut header: &'h [u8], name: &[u8]) -> &'h [u8] {
    while header.len() > 4 {
        let (one, rest) = header[4..].split_at(u32_at(header, 0));
        if let Some(value) = one.strip_prefix(name).and_then(|v| v.strip_prefix(b"=")) {
            return value;
        }
        header = rest;
    }
    &[]
}

/// Connections, and the first `most` messages of each.
fn bag_records(mut bytes: &[u8], most: usize, seen: &mut BTreeMap<Vec<u8>, usize>, out: &mut Vec<u8>) {
    while bytes.len() >= 8 {
        let (header, rest) = bytes[4..].split_at(u32_at(bytes, 0));
        let (data, rest) = rest[4..].split_at(u32_at(rest, 0));
        match field(header, b"op") {
            [0x05] => bag_records(data, most, seen, out),
            [op @ (0x02 | 0x07)] => {
                let count = seen.entry([&[*op], field(header, b"conn")].concat()).or_default();
                *count += 1;
                if *count <= if *op == 0x07 { 1 } else { most } {
                    out.extend(bag_record(header, data));
                }
            }
            _ => {}
        }
        bytes = rest;
    }
}

/// Bags with `most` messages of each connection: each record by itself, in a plain chunk, and in one of LZ4.
pub fn bags(most: usize) -> Vec<Vec<u8>> {
    let file = fixture("rosbag/plain.bag");
    let mut records = Vec::new();
    bag_records(file.get(BAG.len()..).unwrap_or_default(), most, &mut BTreeMap::new(), &mut records);
    let chunk = |compression: &str, packed: &[u8]| {
        let mut header = Vec::new();
        let size = (records.len() as u32).to_le_bytes();
        for (name, value) in [("op", &[5][..]), ("compression", compression.as_bytes()), ("size", &size)] {
            header.extend(((name.len() + 1 + value.len()) as u32).to_le_bytes());
            header.extend([name.as_bytes(), b"=", value].concat());
        }
        [BAG, &bag_record(&header, packed)].concat()
    };
    vec![[BAG, &records].concat(), chunk("none", &records), chunk("lz4", &lz4(&records))]
}
