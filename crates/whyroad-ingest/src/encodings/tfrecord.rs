//! TFRecord files: records one after the other, each with its length and two checksums (TensorFlow's documentation,
//! "TFRecords format details"; CRC-32C by Castagnoli, RFC 3720 B.4, masked by rotation and a constant).

use super::input::{Input, ReadSeek};
use crate::file_reader::FileReader;
use std::io::{self, Read, SeekFrom};

/// Length (8) and its checksum (4).
const HEADER: u64 = 12;
/// Checksum of the record.
const FOOTER: u64 = 4;
/// The constant of the mask.
const MASK_DELTA: u32 = 0xa282_ead8;
/// A record longer than this is not a scenario: its length is wrong.
const MAX_RECORD: u64 = 1 << 30;

/// What is wrong with a record.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RecordError {
    #[error("the record at byte {at} needs {wanted} bytes, the file has {have} left")]
    Truncated { at: u64, wanted: u64, have: u64 },
    #[error("the length of the record at byte {0} does not fit its checksum")]
    Length(u64),
    #[error("the record at byte {0} does not fit its checksum")]
    Content(u64),
    #[error(transparent)]
    Io(#[from] io::Error),
}

const TABLE: [u32; 256] = {
    let mut table = [0u32; 256];
    let mut i = 0;
    while i < 256 {
        let mut crc = i as u32;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ 0x82f6_3b78 } else { crc >> 1 };
            bit += 1;
        }
        table[i] = crc;
        i += 1;
    }
    table
};

fn crc32c(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &b| (crc >> 8) ^ TABLE[((crc ^ u32::from(b)) & 0xff) as usize])
}

fn masked(bytes: &[u8]) -> u32 {
    crc32c(bytes).rotate_right(15).wrapping_add(MASK_DELTA)
}

fn header(file: &mut dyn ReadSeek, at: u64, end: u64) -> Result<u64, RecordError> {
    if end - at < HEADER {
        return Err(RecordError::Truncated { at, wanted: HEADER, have: end - at });
    }
    let (mut length, mut sum) = ([0; 8], [0; 4]);
    file.seek(SeekFrom::Start(at))?;
    file.read_exact(&mut length)?;
    file.read_exact(&mut sum)?;
    let wanted = u64::from_le_bytes(length);
    if masked(&length) != u32::from_le_bytes(sum) || wanted > MAX_RECORD {
        return Err(RecordError::Length(at));
    }
    let (wanted, have) = (wanted + FOOTER, end - at - HEADER);
    if wanted > have { Err(RecordError::Truncated { at, wanted, have }) } else { Ok(wanted - FOOTER) }
}

/// Where the records begin. A record whose header is wrong or that is cut short is the last one; reading it says why.
/// Empty when the file does not begin as a TFRecord.
pub(crate) fn offsets<'a>(input: impl Into<Input<'a>>) -> io::Result<Vec<u64>> {
    let (mut file, end) = input.into().open()?;
    let (mut at, mut out) = (0, Vec::new());
    while at < end {
        let length = header(&mut *file, at, end);
        if out.is_empty() && matches!(length, Err(RecordError::Length(_))) {
            return Ok(out);
        }
        out.push(at);
        match length {
            Ok(length) => at += HEADER + length + FOOTER,
            Err(RecordError::Io(e)) => return Err(e),
            Err(_) => break,
        }
    }
    Ok(out)
}

/// The record that begins at byte `at`.
pub(crate) fn read<'a>(input: impl Into<Input<'a>>, at: u64) -> Result<Vec<u8>, RecordError> {
    let (mut file, end) = input.into().open()?;
    let length = header(&mut *file, at, end.max(at))?;
    let mut record = vec![0; length as usize];
    file.read_exact(&mut record)?;
    let mut sum = [0; 4];
    file.read_exact(&mut sum)?;
    if masked(&record) == u32::from_le_bytes(sum) { Ok(record) } else { Err(RecordError::Content(at)) }
}

/// For [`crate::readers`].
pub(crate) const READER: FileReader = FileReader {
    name: "tfrecord",
    read: |bytes| {
        offsets(bytes).is_ok_and(|all| !all.is_empty() && all.iter().all(|at| read(bytes, *at).is_ok()))
    },
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_of_the_standard() {
        // RFC 3720 B.4: 32 zeros, 32 ones, 0..31; and the check value of the CRC catalog.
        let rising: Vec<u8> = (0..32).collect();
        assert_eq!(
            [crc32c(&[0; 32]), crc32c(&[0xff; 32]), crc32c(&rising)],
            [0x8a91_36aa, 0x62a8_ab43, 0x46dd_794e]
        );
        assert_eq!(crc32c(b"123456789"), 0xe306_9283);
    }
}
