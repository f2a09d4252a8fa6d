//! Record batches whose buffers are packed with LZ4, as AV2 has them. The Arrow crate unpacks each buffer through two
//! others; here they are unpacked to where the columns read them, and the crate gets a batch that is not packed. `None`
//! for anything unusual: the Arrow crate reads it then, and says what is wrong.

use super::guard;
use arrow_array::RecordBatch;
use arrow_buffer::Buffer;
use arrow_ipc::convert::try_fb_to_schema;
use arrow_ipc::reader::read_record_batch;
use arrow_ipc::{Block, Buffer as Entry, CompressionType, MetadataVersion, root_as_message};
use arrow_schema::SchemaRef;
use std::collections::HashMap;
use std::sync::Arc;

/// Precedes a buffer that is not packed, in place of its unpacked size.
const NOT_PACKED: i64 = -1;
/// Bytes of that size.
const SIZE_BYTES: usize = size_of::<i64>();
/// Buffers begin at multiples of this, as in the files of others.
const ALIGNED_BYTES: usize = 64;
/// Bytes of a buffer's entry in a message: its offset and its length.
const ENTRY_BYTES: usize = 16;
/// How far a block of LZ4 refers back to the blocks before it.
const WINDOW_BYTES: usize = 1 << 16;
const LZ4_MAGIC: u32 = 0x184d_2204;

/// The record batches of a file, which [`guard::check_file`] accepts.
pub(super) fn read_file(bytes: &[u8]) -> Option<Vec<RecordBatch>> {
    let footer = guard::footer(bytes).ok().filter(|_| bytes.ends_with(super::MAGIC))?;
    let schema = footer.schema()?;
    if footer.dictionaries().is_some_and(|all| !all.is_empty())
        || !schema.endianness().equals_to_target_endianness()
    {
        return None;
    }
    let (schema, version) = (Arc::new(try_fb_to_schema(schema).ok()?), footer.version());
    footer.recordBatches()?.iter().map(|block| batch(bytes, block, &schema, version)).collect()
}

fn batch(bytes: &[u8], block: &Block, schema: &SchemaRef, version: MetadataVersion) -> Option<RecordBatch> {
    let (message, body) = guard::message_and_body(bytes, block).ok()?;
    let packed = root_as_message(message).ok()?.header_as_record_batch()?;
    if packed.compression()?.codec() != CompressionType::LZ4_FRAME {
        return None;
    }
    // The same message with the places of the unpacked buffers.
    let mut own = message.to_vec();
    let entries = packed.buffers()?;
    let entries_at = entries.bytes().as_ptr().addr().checked_sub(message.as_ptr().addr())?;
    let sizes = entries.iter().map(|buffer| unpacked_size(body, buffer));
    let mut unpacked = Vec::with_capacity(sizes.sum::<Option<usize>>()?);
    for (entry, buffer) in own.get_mut(entries_at..)?.chunks_exact_mut(ENTRY_BYTES).zip(entries) {
        let start = unpacked.len();
        unpack(content(body, buffer)?, &mut unpacked)?;
        let (offset, length) = entry.split_at_mut(SIZE_BYTES);
        offset.copy_from_slice(&i64::try_from(start).ok()?.to_le_bytes());
        length.copy_from_slice(&i64::try_from(unpacked.len() - start).ok()?.to_le_bytes());
        unpacked.resize(unpacked.len().next_multiple_of(ALIGNED_BYTES), 0);
    }
    let batch = root_as_message(&own).ok()?.header_as_record_batch()?;
    read_record_batch(&Buffer::from_vec(unpacked), batch, schema.clone(), &HashMap::new(), None, &version)
        .ok()
}

/// The bytes of a buffer.
fn content<'b>(body: &'b [u8], buffer: &Entry) -> Option<&'b [u8]> {
    let at = usize::try_from(buffer.offset()).ok()?;
    body.get(at..at.checked_add(usize::try_from(buffer.length()).ok()?)?)
}

/// Room that a buffer takes at most, with the space after it.
fn unpacked_size(body: &[u8], buffer: &Entry) -> Option<usize> {
    let packed = content(body, buffer)?;
    let size = packed.first_chunk::<SIZE_BYTES>().map_or(0, |size| i64::from_le_bytes(*size));
    Some(usize::try_from(size).unwrap_or(packed.len()) + SIZE_BYTES + ALIGNED_BYTES)
}

/// Appends a buffer as one that is not packed.
fn unpack(packed: &[u8], to: &mut Vec<u8>) -> Option<()> {
    let Some((size, frame)) = packed.split_first_chunk::<SIZE_BYTES>() else {
        return packed.is_empty().then_some(());
    };
    let size = i64::from_le_bytes(*size);
    if size == NOT_PACKED {
        to.extend_from_slice(packed);
        return Some(());
    }
    to.extend_from_slice(&NOT_PACKED.to_le_bytes());
    let start = to.len();
    to.resize(start.checked_add(usize::try_from(size).ok()?)?, 0);
    if size == 0 { Some(()) } else { unpack_frame(frame, &mut to[start..]) }
}

/// Unpacks a frame that fills `to` and has no checksum except that of its header, which the fields themselves replace.
fn unpack_frame(frame: &[u8], to: &mut [u8]) -> Option<()> {
    const INDEPENDENT: u8 = 1 << 5;
    const STATES_SIZE: u8 = 1 << 3;
    const VERSION: u8 = 1 << 6;
    let (magic, rest) = frame.split_first_chunk::<4>()?;
    let [flags, _block_size, rest @ ..] = rest else { return None };
    let mut rest = rest;
    if u32::from_le_bytes(*magic) != LZ4_MAGIC || flags & !(INDEPENDENT | STATES_SIZE) != VERSION {
        return None;
    }
    if flags & STATES_SIZE != 0 {
        let (size, after) = rest.split_first_chunk::<8>()?;
        (u64::from_le_bytes(*size) == to.len() as u64).then_some(())?;
        rest = after;
    }
    let (_header_checksum, mut rest) = rest.split_first()?;
    let mut done = 0;
    loop {
        let (size, after) = rest.split_first_chunk::<4>()?;
        let size = u32::from_le_bytes(*size);
        if size == 0 {
            return (after.is_empty() && done == to.len()).then_some(());
        }
        let is_packed = size >> 31 == 0;
        let block;
        (block, rest) = after.split_at_checked((size & 0x7fff_ffff) as usize)?;
        let (before, free) = to.split_at_mut(done);
        done += if !is_packed {
            free.get_mut(..block.len())?.copy_from_slice(block);
            block.len()
        } else if before.is_empty() || flags & INDEPENDENT != 0 {
            lz4_flex::block::decompress_into(block, free).ok()?
        } else {
            let window = &before[before.len().saturating_sub(WINDOW_BYTES)..];
            lz4_flex::block::decompress_into_with_dict(block, free, window).ok()?
        };
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test says what went wrong by failing")]
mod tests {
    use super::*;
    use lz4_flex::frame::{BlockMode, BlockSize, FrameEncoder, FrameInfo};
    use std::io::Write;

    /// Some of it repeats, over more than a block.
    fn content(bytes: usize) -> Vec<u8> {
        let value = |i: usize| if i % 90_000 < 70_000 { (i / 7 * i) as u8 } else { (i % 251) as u8 };
        (0..bytes).map(value).collect()
    }

    #[test]
    fn frames_of_any_kind_are_unpacked_or_left_to_the_library() {
        for bytes in [1, 17, 70_000, 400_000] {
            let content = content(bytes);
            for (mode, size, sums) in [
                (BlockMode::Independent, None, false),
                (BlockMode::Linked, None, false),
                (BlockMode::Linked, Some(bytes as u64), false),
                (BlockMode::Linked, None, true),
            ] {
                let info = FrameInfo::new().block_mode(mode).block_size(BlockSize::Max64KB);
                let info = info.content_size(size).content_checksum(sums);
                let mut encoder = FrameEncoder::with_frame_info(info, Vec::new());
                encoder.write_all(&content).unwrap();
                let frame = encoder.finish().unwrap();
                let mut out = vec![0; bytes];
                let done = unpack_frame(&frame, &mut out);
                assert_eq!(done.is_some(), !sums, "{bytes} {mode:?} {size:?}");
                assert!(sums || out == content, "{bytes} {mode:?} {size:?}");
                // Neither a byte less nor more, nor a part of the frame.
                assert!(unpack_frame(&frame, &mut vec![0; bytes - 1]).is_none());
                assert!(unpack_frame(&frame, &mut vec![0; bytes + 1]).is_none());
                assert!(unpack_frame(&frame[..frame.len() - 1], &mut out).is_none());
            }
        }
    }
}
