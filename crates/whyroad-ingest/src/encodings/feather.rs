//! Feather (Arrow IPC) files as AV2 writes them, read column by column. A file that was cut short keeps its
//! readable record batches.

use crate::encodings::columns::Columns;
use arrow_ipc::reader::{FileReader, StreamReader};
use std::io::Cursor;

/// What could be read of a feather file.
pub(crate) struct Feather {
    pub columns: Columns,
    /// Set when the file ends before its footer: what the reader said.
    pub truncated: Option<String>,
}

const MAGIC: &[u8] = b"ARROW1";

/// Reads all record batches. `Err` when it is no Arrow file at all.
pub(crate) fn read(bytes: &[u8]) -> Result<Feather, String> {
    if !bytes.starts_with(MAGIC) {
        return Err("the file does not begin as an Arrow IPC (feather) file".to_owned());
    }
    let whole = FileReader::try_new(Cursor::new(bytes), None).and_then(|r| r.collect::<Result<Vec<_>, _>>());
    let reason = match whole {
        Ok(batches) => return Ok(Feather { columns: Columns(batches), truncated: None }),
        Err(e) => e.to_string(),
    };
    // The file format is a stream between two magic words, so what stands before the cut can be read as a stream.
    // Zeros pad the first word to 8 bytes (C++) or 64 (Rust); the stream begins with 0xFFFFFFFF.
    let start = bytes.iter().skip(MAGIC.len()).position(|b| *b != 0).map_or(bytes.len(), |p| p + MAGIC.len());
    let mut batches = Vec::new();
    if let Ok(stream) = StreamReader::try_new(Cursor::new(&bytes[start..]), None) {
        batches.extend(stream.map_while(Result::ok));
    }
    Ok(Feather { columns: Columns(batches), truncated: Some(reason) })
}
