//! Checks the sizes and offsets that an Arrow IPC file declares against the bytes it has, before the Arrow crate
//! allocates by them: damaged files otherwise ask for terabytes. Format: Arrow columnar format, "Serialization and
//! Interprocess Communication"; `Message.fbs`, `File.fbs`.

use arrow_ipc::{Block, Buffer, MessageHeader, RecordBatch, root_as_footer, root_as_message};

/// LZ4 packs at most 255 bytes into one.
const MAX_RATIO: i64 = 255;
const TRAILER: usize = 10;

/// `Err` states what is impossible in the file.
pub(super) fn check_file(bytes: &[u8]) -> Result<(), String> {
    let end = bytes.len().checked_sub(TRAILER).ok_or("it is too short")?;
    let length: [u8; 4] = bytes[end..end + 4].try_into().map_err(|_| "it is too short")?;
    let length =
        usize::try_from(i32::from_le_bytes(length)).map_err(|_| "its footer has a negative length")?;
    let start = end.checked_sub(length).ok_or("its footer is longer than the file")?;
    let footer = root_as_footer(&bytes[start..end]).map_err(|e| format!("its footer is broken: {e}"))?;
    let blocks = footer.recordBatches().into_iter().chain(footer.dictionaries()).flatten();
    for block in blocks {
        check_block(bytes, block)?;
    }
    Ok(())
}

fn check_block(bytes: &[u8], block: &Block) -> Result<(), String> {
    let outside = || "one of its blocks is not inside the file".to_owned();
    let size = |n: i64| usize::try_from(n).ok();
    let (at, head, body) =
        (size(block.offset()), size(i64::from(block.metaDataLength())), size(block.bodyLength()));
    let (Some(at), Some(head), Some(body)) = (at, head, body) else { return Err(outside()) };
    let middle = at.checked_add(head).ok_or_else(outside)?;
    let end = middle.checked_add(body).filter(|&end| end <= bytes.len()).ok_or_else(outside)?;
    let (head, body) = (&bytes[at..middle], &bytes[middle..end]);
    check_message(message(head).ok_or("one of its messages is cut short")?, body)
}

/// The message behind its length, with or without the continuation marker.
fn message(head: &[u8]) -> Option<&[u8]> {
    match head {
        [0xff, 0xff, 0xff, 0xff, rest @ ..] => rest.get(4..),
        rest => rest.get(4..),
    }
}

/// Where the message that begins at `at` ends; `None` when it is broken or cut short.
pub(super) fn next_message(stream: &[u8], at: usize) -> Option<usize> {
    let head = stream.get(at..)?;
    let length: [u8; 4] = head.get(4..8)?.try_into().ok()?;
    let length = usize::try_from(i32::from_le_bytes(length))
        .ok()
        .filter(|&n| head.starts_with(&[0xff; 4]) && n > 0)?;
    let message = head.get(8..8usize.checked_add(length)?)?;
    let body = usize::try_from(root_as_message(message).ok()?.bodyLength()).ok()?;
    let body = head.get(8 + length..(8 + length).checked_add(body)?)?;
    check_message(message, body).ok()?;
    Some(at + 8 + length + body.len())
}

/// Checks a message and the body that belongs to it.
pub(super) fn check_message(message: &[u8], body: &[u8]) -> Result<(), String> {
    let message = root_as_message(message).map_err(|e| format!("one of its messages is broken: {e}"))?;
    let batch = match message.header_type() {
        MessageHeader::RecordBatch => message.header_as_record_batch(),
        MessageHeader::DictionaryBatch => message.header_as_dictionary_batch().and_then(|d| d.data()),
        _ => return Ok(()),
    };
    check_batch(&batch.ok_or("one of its messages has no record batch")?, body)
}

fn check_batch(batch: &RecordBatch<'_>, body: &[u8]) -> Result<(), String> {
    let packed = batch.compression().is_some();
    let mut unpacked = 0i64;
    for buffer in batch.buffers().into_iter().flatten() {
        unpacked = unpacked.saturating_add(check_buffer(buffer, body, packed)?);
    }
    // A row takes at least one bit of some buffer.
    let most = unpacked.saturating_mul(8);
    let lengths = batch.nodes().into_iter().flatten().flat_map(|n| [n.length(), n.null_count()]);
    if lengths.chain([batch.length()]).any(|n| n < 0 || n > most) {
        return Err("it declares more rows than it has bytes for".to_owned());
    }
    Ok(())
}

/// Unpacked size of a buffer.
fn check_buffer(buffer: &Buffer, body: &[u8], packed: bool) -> Result<i64, String> {
    let range = usize::try_from(buffer.offset()).ok().zip(usize::try_from(buffer.length()).ok());
    let inside = range.and_then(|(at, n)| body.get(at..at.checked_add(n)?));
    let inside = inside.ok_or("one of its buffers is not inside its message")?;
    let own = inside.len() as i64;
    if !packed || inside.is_empty() {
        return Ok(own);
    }
    let (size, _) = inside.split_first_chunk::<8>().ok_or("one of its packed buffers is cut short")?;
    match i64::from_le_bytes(*size) {
        -1 => Ok(own),
        size if (0..=own.saturating_mul(MAX_RATIO)).contains(&size) => Ok(size),
        size => Err(format!("one of its buffers of {own} bytes declares {size} unpacked bytes")),
    }
}
