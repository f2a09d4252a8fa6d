//! ROS 1 bags (format 2.0) record by record, in the file's order: connections and messages, also those in chunks
//! (plain, bz2, lz4). Source: the ROS wiki, "Bags/Format/2.0". One chunk is in memory at a time; indexes are skipped,
//! so a bag without an index (`.bag.active`) is read as far as it goes.

use super::input::Input;
use super::mcap_records::{Channel, Message, Schema};
use crate::file_reader::FileReader;
use std::collections::BTreeMap;
use std::io::{self, BufReader, Read};
use std::rc::Rc;

const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// Largest record; a greater length is damage, bytes.
const MAX_RECORD: u64 = 1 << 31;
/// Most headers of connections; a greater number is damage.
const MAX_CONNECTIONS: usize = 100_000;

/// Why reading stopped, or what was skipped.
#[derive(Debug, thiserror::Error)]
pub(crate) enum BagError {
    #[error("it does not begin as a ROS bag of format 2.0")]
    Magic,
    #[error("it ends inside a record that begins at byte {0}")]
    Truncated(u64),
    #[error("the chunk at byte {at} cannot be unpacked: {reason}")]
    Chunk { at: u64, reason: String },
    #[error("the record at byte {0} is not a bag record")]
    Malformed(u64),
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// A record's header: `name=value` fields, each with its length before it.
struct Header<'a>(BTreeMap<&'a [u8], &'a [u8]>);

impl<'a> Header<'a> {
    fn parse(mut bytes: &'a [u8]) -> Option<Self> {
        let mut out = BTreeMap::new();
        while !bytes.is_empty() {
            let field = sized(&mut bytes)?;
            let at = field.iter().position(|b| *b == b'=')?;
            out.insert(&field[..at], &field[at + 1..]);
        }
        Some(Self(out))
    }

    fn get(&self, name: &str) -> Option<&'a [u8]> {
        self.0.get(name.as_bytes()).copied()
    }

    fn int(&self, name: &str) -> Option<u32> {
        Some(u32::from_le_bytes(self.get(name)?.try_into().ok()?))
    }

    fn op(&self) -> Option<u8> {
        self.get("op")?.first().copied()
    }

    fn text(&self, name: &str) -> Option<String> {
        Some(String::from_utf8_lossy(self.get(name)?).into_owned())
    }
}

/// Takes a length and that number of bytes.
fn sized<'a>(bytes: &mut &'a [u8]) -> Option<&'a [u8]> {
    let (length, rest) = bytes.split_first_chunk::<4>()?;
    let (head, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    *bytes = rest;
    Some(head)
}

#[derive(Default)]
struct Reader {
    connections: BTreeMap<u32, Channel>,
}

impl Reader {
    /// A connection or a message; anything else is skipped.
    fn record(&mut self, header: &Header<'_>, data: &[u8], each: &mut dyn FnMut(Message<'_>)) -> Option<()> {
        match header.op()? {
            0x07 => {
                let id = header.int("conn")?;
                // The record's own topic is the one that was recorded; its data has that of the publisher.
                let (topic, described) = (header.text("topic")?, Header::parse(data)?);
                let schema = Schema {
                    name: described.text("type")?,
                    encoding: "ros1msg".into(),
                    data: described.get("message_definition").unwrap_or_default().to_vec(),
                };
                if self.connections.len() < MAX_CONNECTIONS {
                    let channel = Channel { topic, encoding: "ros1".into(), schema: Rc::new(schema) };
                    self.connections.entry(id).or_insert(channel);
                }
            }
            0x02 => {
                let (id, time) = (header.int("conn")?, header.get("time")?);
                let (seconds, nanos) = time.split_first_chunk::<4>()?;
                let nanos = u32::from_le_bytes(nanos.try_into().ok()?);
                let log_time = i64::from(u32::from_le_bytes(*seconds)) * 1_000_000_000 + i64::from(nanos);
                if let Some(channel) = self.connections.get(&id) {
                    each(Message { channel, log_time, data });
                }
            }
            _ => {}
        }
        Some(())
    }

    fn chunk(
        &mut self,
        header: &Header<'_>,
        packed: &[u8],
        each: &mut dyn FnMut(Message<'_>),
    ) -> Result<(), String> {
        let size = u64::from(header.int("size").ok_or("its header has no size")?);
        let compression = header.text("compression").ok_or("its header has no compression")?;
        if size > super::compressed::limit(packed.len() as u64) || size > MAX_RECORD {
            return Err(format!("it declares {size} bytes"));
        }
        let mut unpacked = Vec::new();
        match compression.as_str() {
            "none" => unpacked.extend_from_slice(packed),
            "bz2" => unpacked = super::bzip2::unpack(packed, size as usize)?,
            "lz4" => {
                // Never more than the declared size: data that unpacks to more is malicious or damaged.
                let mut decoder = lz4_flex::frame::FrameDecoder::new(packed).take(size + 1);
                decoder.read_to_end(&mut unpacked).map_err(|e| e.to_string())?;
            }
            other => return Err(format!("compression '{other}' is not known")),
        }
        if unpacked.len() as u64 != size {
            return Err("its size differs from the declared size".into());
        }
        let mut rest = unpacked.as_slice();
        while !rest.is_empty() {
            let header = sized(&mut rest).and_then(Header::parse).ok_or("a record in it is malformed")?;
            let data = sized(&mut rest).ok_or("a record in it is cut short")?;
            self.record(&header, data, each).ok_or("a record in it is malformed")?;
        }
        Ok(())
    }
}

/// Calls `each` for every message. A chunk that cannot be unpacked is skipped; the errors state what was lost.
pub(crate) fn read(input: &Input<'_>, each: &mut dyn FnMut(Message<'_>)) -> Vec<BagError> {
    let mut errors = Vec::new();
    if let Err(e) = read_all(input, each, &mut errors) {
        errors.push(e);
    }
    errors
}

fn read_all(
    input: &Input<'_>,
    each: &mut dyn FnMut(Message<'_>),
    lost: &mut Vec<BagError>,
) -> Result<(), BagError> {
    let (file, end) = input.open()?;
    let mut file = BufReader::with_capacity(1 << 16, file);
    let mut magic = [0; MAGIC.len()];
    if file.read_exact(&mut magic).is_err() || magic != MAGIC {
        return Err(BagError::Magic);
    }
    let mut at = MAGIC.len() as u64;
    let mut reader = Reader::default();
    let (mut head, mut body) = (Vec::new(), Vec::new());
    while at < end {
        let length = |at: u64, file: &mut dyn Read| -> Result<u64, BagError> {
            let mut raw = [0; 4];
            if end.saturating_sub(at) < 4 {
                return Err(BagError::Truncated(at));
            }
            file.read_exact(&mut raw)?;
            let n = u64::from(u32::from_le_bytes(raw));
            if n > end - at - 4 { Err(BagError::Truncated(at)) } else { Ok(n) }
        };
        let header_length = length(at, &mut file)?;
        head.resize(header_length as usize, 0);
        file.read_exact(&mut head)?;
        let body_at = at + 4 + header_length;
        let body_length = length(body_at, &mut file).map_err(|e| match e {
            BagError::Truncated(_) => BagError::Truncated(at),
            other => other,
        })?;
        let header = Header::parse(&head).ok_or(BagError::Malformed(at))?;
        match header.op().ok_or(BagError::Malformed(at))? {
            op @ (0x02 | 0x05 | 0x07) if body_length <= MAX_RECORD => {
                body.resize(body_length as usize, 0);
                file.read_exact(&mut body)?;
                if op == 0x05 {
                    if let Err(reason) = reader.chunk(&header, &body, each) {
                        lost.push(BagError::Chunk { at, reason });
                    }
                } else {
                    reader.record(&header, &body, each).ok_or(BagError::Malformed(at))?;
                }
            }
            _ => file.seek_relative(body_length as i64)?,
        }
        at = body_at + 4 + body_length;
    }
    Ok(())
}

/// For [`crate::readers`].
pub(crate) const READER: FileReader =
    FileReader { name: "rosbag-records", read: |bytes| read(&bytes.into(), &mut |_| ()).is_empty() };
