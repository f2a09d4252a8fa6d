//! MCAP files record by record, in the file's order: schemas, channels, messages, also those in chunks (plain, lz4,
//! zstd). Source: the MCAP specification, version 0. One chunk is in memory at a time; attachments, metadata and
//! indexes are skipped, so a file without an end is read as far as it goes.

use super::input::{Input, ReadSeek};
use crate::file_reader::FileReader;
use std::collections::BTreeMap;
use std::io::{self, BufReader, Read};
use std::rc::Rc;

const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];
/// Largest chunk or message; a greater length is damage, bytes.
const MAX_RECORD: u64 = 1 << 31;

/// How messages of a channel are to be read.
#[derive(Debug, Default)]
pub(crate) struct Schema {
    pub name: String,
    /// `ros2msg`, `protobuf`, `jsonschema`
    pub encoding: String,
    pub data: Vec<u8>,
}

#[derive(Debug)]
pub(crate) struct Channel {
    pub topic: String,
    /// `cdr`, `protobuf`, `json`
    pub encoding: String,
    pub schema: Rc<Schema>,
}

/// One message.
pub(crate) struct Message<'a> {
    pub channel: &'a Channel,
    /// ns
    pub log_time: i64,
    pub data: &'a [u8],
}

/// Why reading stopped before the end of the data.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RecordError {
    #[error("it does not begin as an MCAP file")]
    Magic,
    #[error("it ends inside a record that begins at byte {0}")]
    Truncated(u64),
    #[error("the chunk at byte {at} cannot be unpacked: {reason}")]
    Chunk { at: u64, reason: String },
    #[error("the record at byte {0} is not an MCAP record")]
    Malformed(u64),
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Little-endian fields of a record.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(head)
    }
    fn int<const N: usize>(&mut self) -> Option<u64> {
        let mut wide = [0; 8];
        wide[..N].copy_from_slice(self.take(N)?);
        Some(u64::from_le_bytes(wide))
    }
    fn sized<const N: usize>(&mut self) -> Option<&'a [u8]> {
        let n = usize::try_from(self.int::<N>()?).ok()?;
        self.take(n)
    }
    fn text(&mut self) -> Option<String> {
        Some(String::from_utf8_lossy(self.sized::<4>()?).into_owned())
    }
}

#[derive(Default)]
struct Reader {
    schemas: BTreeMap<u64, Rc<Schema>>,
    channels: BTreeMap<u64, Channel>,
}

impl Reader {
    fn record(&mut self, op: u8, body: &[u8], each: &mut dyn FnMut(Message<'_>)) -> Option<()> {
        let mut f = Fields(body);
        match op {
            0x03 => {
                let id = f.int::<2>()?;
                let (name, encoding) = (f.text()?, f.text()?);
                let data = f.sized::<4>()?.to_vec();
                self.schemas.insert(id, Rc::new(Schema { name, encoding, data }));
            }
            0x04 => {
                let (id, schema) = (f.int::<2>()?, f.int::<2>()?);
                let (topic, encoding) = (f.text()?, f.text()?);
                let schema = self.schemas.get(&schema).cloned().unwrap_or_default();
                self.channels.insert(id, Channel { topic, encoding, schema });
            }
            0x05 => {
                let channel = f.int::<2>()?;
                f.take(4)?;
                let log_time = f.int::<8>()? as i64;
                f.take(8)?;
                if let Some(channel) = self.channels.get(&channel) {
                    each(Message { channel, log_time, data: f.0 });
                }
            }
            _ => {}
        }
        Some(())
    }

    fn chunk(&mut self, body: &[u8], each: &mut dyn FnMut(Message<'_>)) -> Result<(), String> {
        let mut f = Fields(body);
        let mut header = || {
            f.take(16)?;
            let (size, crc) = (f.int::<8>()?, f.int::<4>()?);
            Some((size, crc, f.text()?, f.sized::<8>()?))
        };
        let (size, crc, compression, packed) = header().ok_or("its header is cut short")?;
        if size > super::compressed::limit(packed.len() as u64) || size > MAX_RECORD {
            return Err(format!("it declares {size} bytes"));
        }
        let mut unpacked = Vec::new();
        // Never more than the declared size: data that unpacks to more is malicious or damaged.
        let limit = size + 1;
        let done = match compression.as_str() {
            "" => packed.take(limit).read_to_end(&mut unpacked),
            "lz4" => lz4_flex::frame::FrameDecoder::new(packed).take(limit).read_to_end(&mut unpacked),
            "zstd" => {
                let decoder = ruzstd::decoding::StreamingDecoder::new(packed).map_err(|e| e.to_string())?;
                decoder.take(limit).read_to_end(&mut unpacked)
            }
            other => return Err(format!("compression '{other}' is not known")),
        };
        done.map_err(|e| e.to_string())?;
        if unpacked.len() as u64 != size {
            return Err("its size differs from the declared size".into());
        }
        let mut sum = flate2::Crc::new();
        sum.update(&unpacked);
        if crc != 0 && crc != u64::from(sum.sum()) {
            return Err("it does not fit its checksum".into());
        }
        let mut rest = Fields(&unpacked);
        while !rest.0.is_empty() {
            let op = rest.int::<1>().unwrap_or_default() as u8;
            let body = rest.sized::<8>().ok_or("a record in it is cut short")?;
            self.record(op, body, each).ok_or("a record in it is malformed")?;
        }
        Ok(())
    }
}

/// True when the file begins as an MCAP file.
fn is_mcap(file: &mut dyn ReadSeek) -> bool {
    let mut magic = [0; 8];
    file.read_exact(&mut magic).is_ok() && magic == MAGIC
}

/// Calls `each` for every message. A chunk that cannot be unpacked is skipped; the errors state what was lost.
pub(crate) fn read(input: &Input<'_>, each: &mut dyn FnMut(Message<'_>)) -> Vec<RecordError> {
    let mut errors = Vec::new();
    if let Err(e) = read_all(input, each, &mut errors) {
        errors.push(e);
    }
    errors
}

fn read_all(
    input: &Input<'_>,
    each: &mut dyn FnMut(Message<'_>),
    lost: &mut Vec<RecordError>,
) -> Result<(), RecordError> {
    let (file, end) = input.open()?;
    let mut file = BufReader::with_capacity(1 << 16, file);
    if !is_mcap(&mut file) {
        return Err(RecordError::Magic);
    }
    let mut at = MAGIC.len() as u64;
    let mut reader = Reader::default();
    let mut body = Vec::new();
    loop {
        if end - at < 9 {
            return Err(RecordError::Truncated(at));
        }
        let mut head = [0; 9];
        file.read_exact(&mut head)?;
        let mut f = Fields(&head[1..]);
        let (op, length) = (head[0], f.int::<8>().unwrap_or_default());
        if length > end - at - 9 {
            return Err(RecordError::Truncated(at));
        }
        match op {
            // The end of the data; after it come indexes and repetitions.
            0x0f | 0x02 => return Ok(()),
            0x03..=0x06 if length <= MAX_RECORD => {
                body.resize(length as usize, 0);
                file.read_exact(&mut body)?;
                if op == 0x06 {
                    if let Err(reason) = reader.chunk(&body, each) {
                        lost.push(RecordError::Chunk { at, reason });
                    }
                } else {
                    reader.record(op, &body, each).ok_or(RecordError::Malformed(at))?;
                }
            }
            _ => file.seek_relative(length as i64)?,
        }
        at += 9 + length;
    }
}

/// For [`crate::readers`].
pub(crate) const READER: FileReader =
    FileReader { name: "mcap-records", read: |bytes| read(&bytes.into(), &mut |_| ()).is_empty() };
