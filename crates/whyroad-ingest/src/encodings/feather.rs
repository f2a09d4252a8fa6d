//! Feather (Arrow IPC) files as AV2 writes them, read column by column. A file that was cut short keeps its
//! readable record batches.

mod guard;

use super::columns::Columns;
use arrow_array::RecordBatch;
use arrow_ipc::reader::{FileReader, StreamReader};
use std::io::Cursor;
use std::panic::catch_unwind;

/// What could be read of a feather file.
pub(crate) struct Feather {
    pub columns: Columns,
    /// Set when the file ends before its footer: what the reader said.
    pub truncated: Option<String>,
}

const MAGIC: &[u8] = b"ARROW1";

/// Reads all record batches. `Err` when it is not an Arrow file.
pub(crate) fn read(bytes: &[u8]) -> Result<Feather, String> {
    if !bytes.starts_with(MAGIC) {
        return Err("the file does not begin as an Arrow IPC (feather) file".to_owned());
    }
    let reason = match guard::check_file(bytes).and_then(|()| read_file(bytes)) {
        Ok(batches) => return Ok(Feather { columns: Columns(batches), truncated: None }),
        Err(reason) => reason,
    };
    // The file format is a stream between two magic words, so the part before a cut can be read as a stream.
    // Zeros pad the first word to 8 bytes (C++) or 64 (Rust); the stream begins with 0xFFFFFFFF.
    let start = bytes.iter().skip(MAGIC.len()).position(|b| *b != 0).map_or(bytes.len(), |p| p + MAGIC.len());
    Ok(Feather { columns: Columns(read_stream(sound_part(&bytes[start..]))), truncated: Some(reason) })
}

fn read_file(bytes: &[u8]) -> Result<Vec<RecordBatch>, String> {
    let read =
        || FileReader::try_new(Cursor::new(bytes), None).and_then(|r| r.collect::<Result<Vec<_>, _>>());
    match catch_unwind(read) {
        Ok(batches) => batches.map_err(|e| e.to_string()),
        Err(_) => Err("its content contradicts its schema".to_owned()),
    }
}

fn read_stream(bytes: &[u8]) -> Vec<RecordBatch> {
    let read = || match StreamReader::try_new(Cursor::new(bytes), None) {
        Ok(stream) => stream.map_while(Result::ok).collect(),
        Err(_) => Vec::new(),
    };
    catch_unwind(read).unwrap_or_default()
}

/// The messages of a stream up to the first that is broken or cut short.
fn sound_part(stream: &[u8]) -> &[u8] {
    let mut at = 0;
    while let Some(next) = guard::next_message(stream, at) {
        at = next;
    }
    &stream[..at]
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test says what went wrong by failing")]
mod tests {
    use super::*;
    use arrow_array::{Float64Array, StringArray};
    use arrow_ipc::CompressionType;
    use arrow_ipc::writer::{FileWriter, IpcWriteOptions};
    use std::sync::Arc;

    fn file(compression: Option<CompressionType>) -> Vec<u8> {
        let numbers = Float64Array::from_iter_values((0..40).map(f64::from));
        let texts = StringArray::from_iter_values((0..40).map(|n| format!("track {n}")));
        let batch = RecordBatch::try_from_iter([("x", Arc::new(numbers) as _), ("id", Arc::new(texts) as _)])
            .unwrap();
        let options = IpcWriteOptions::default().try_with_compression(compression).unwrap();
        let mut out = FileWriter::try_new_with_options(Vec::new(), &batch.schema(), options).unwrap();
        out.write(&batch).unwrap();
        out.finish().unwrap();
        out.into_inner().unwrap()
    }

    /// Impossible sizes are written at every position of the file, and so into every declared length and offset: the
    /// reader never panics and never allocates the declared size. 2^45 bytes would end the process.
    #[test]
    fn sizes_that_lie_anywhere_in_a_file_are_refused_before_memory_is_taken() {
        for compression in [None, Some(CompressionType::LZ4_FRAME)] {
            let whole = file(compression);
            assert!(read(&whole).is_ok_and(|f| f.truncated.is_none() && f.columns.0[0].num_rows() == 40));
            let mut refused = 0;
            for at in (0..whole.len() - 8).step_by(4) {
                for lie in
                    [1_i64 << 45, (1 << 45) + 8, i64::MAX, -1, i64::from(i32::MAX), i64::from(i32::MIN)]
                {
                    let mut damaged = whole.clone();
                    damaged[at..at + 8].copy_from_slice(&lie.to_le_bytes());
                    let rows = |f: &Feather| f.columns.0.iter().map(RecordBatch::num_rows).sum::<usize>();
                    let kept = read(&damaged);
                    assert!(kept.as_ref().map_or(0, rows) <= 40, "{at} {lie}");
                    refused += usize::from(kept.is_err() || kept.is_ok_and(|f| f.truncated.is_some()));
                }
            }
            assert!(refused > 100, "{refused}");
        }
    }
}
