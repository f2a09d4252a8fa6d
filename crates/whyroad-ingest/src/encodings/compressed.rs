//! Opens a file, plain or compressed: gzip, xz and zstd are recognized by their first bytes, not by name. Everything is
//! unpacked as a stream, and not more than a log of this size can hold: see [`limit`].

use super::input::Input;
use crate::file_reader::FileReader;
use std::io::{self, BufReader, Read};

/// Endings of compressed files.
pub(crate) const ENDINGS: &[&str] = &[".gz", ".xz", ".zst"];

/// Unpacked bytes that any file may have.
const FREE: u64 = 64 << 20;
/// Unpacked bytes per packed byte. Simulated traffic in XML packs to a thirtieth with gzip and to a hundredth with xz;
/// a file of zeros to a thousandth and less.
const MAX_RATIO: u64 = 300;

/// Unpacked size at which reading stops: a file that unpacks to more is not a log.
pub(crate) fn limit(packed: u64) -> u64 {
    packed.saturating_mul(MAX_RATIO).max(FREE)
}

/// The file's unpacked bytes.
pub(crate) fn open<'a>(input: impl Into<Input<'a>>) -> io::Result<Box<dyn Read + 'a>> {
    let (mut file, length) = input.into().open()?;
    let mut magic = Vec::new();
    file.by_ref().take(6).read_to_end(&mut magic)?;
    file.rewind()?;
    let left = limit(length);
    let unpacked: Box<dyn Read + 'a> = match magic.as_slice() {
        [0x1f, 0x8b, ..] => Box::new(flate2::read::MultiGzDecoder::new(file)),
        [0x28, 0xb5, 0x2f, 0xfd, ..] => {
            Box::new(ruzstd::decoding::StreamingDecoder::new(file).map_err(io::Error::other)?)
        }
        [0xfd, b'7', b'z', b'X', b'Z', 0] => Box::new(lzma_rust2::XzReader::new(BufReader::new(file), true)),
        _ => return Ok(Box::new(file)),
    };
    Ok(Box::new(Limited { unpacked, left }))
}

/// Fails when more than `left` bytes are unpacked.
struct Limited<'a> {
    unpacked: Box<dyn Read + 'a>,
    left: u64,
}

impl Read for Limited<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.unpacked.read(buffer)?;
        self.left = self.left.checked_sub(n as u64).ok_or_else(|| {
            io::Error::other(
                "it unpacks to far more than a log of this size can hold; unpack it yourself if it is one",
            )
        })?;
        Ok(n)
    }
}

/// The name without the ending of a compressed file.
pub(crate) fn without_ending(name: &str) -> &str {
    ENDINGS.iter().find_map(|e| name.strip_suffix(e)).unwrap_or(name)
}

/// For [`crate::readers`]: gzip, xz or zstd.
pub(crate) const READER: FileReader = FileReader {
    name: "compressed",
    read: |bytes| {
        let Ok(mut unpacked) = open(bytes) else { return false };
        let mut buffer = vec![0; 1 << 12];
        loop {
            match unpacked.read(&mut buffer) {
                Ok(0) => return true,
                Ok(_) => {}
                Err(_) => return false,
            }
        }
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;
    use std::io::Write as _;
    use std::path::Path;

    #[test]
    fn a_file_that_unpacks_to_gigabytes_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("zeros.xml.gz");
        let mut out =
            flate2::write::GzEncoder::new(File::create(&path).unwrap(), flate2::Compression::best());
        let zeros = vec![0; 1 << 20];
        (0..65).for_each(|_| out.write_all(&zeros).unwrap());
        out.finish().unwrap();
        assert!(path.metadata().unwrap().len() < 100_000);
        refused(&path);
    }

    /// The file is small, and reading it ends with the reason before it is unpacked.
    fn refused(path: &Path) {
        assert!(path.metadata().unwrap().len() < 100_000);
        let mut unpacked = 0;
        let mut bytes = open(path).unwrap();
        let mut buffer = vec![0; 1 << 16];
        let reason = loop {
            match bytes.read(&mut buffer) {
                Ok(0) => panic!("it was read to its end"),
                Ok(n) => unpacked += n as u64,
                Err(e) => break e.to_string(),
            }
        };
        assert!(unpacked <= FREE && reason.contains("unpacks to far more"), "{unpacked} {reason}");
    }

    #[test]
    fn a_zstandard_file_that_unpacks_to_gigabytes_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("zeros.xml.zst");
        // RFC 8878 3.1.1: magic number, a frame header with a window of 128 KiB, blocks of one repeated byte.
        let mut bytes = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x38];
        for last in (0..16_384).map(|i| u32::from(i == 16_383)) {
            let block = (131_072_u32 << 3) | (1 << 1) | last;
            bytes.extend_from_slice(&block.to_le_bytes()[..3]);
            bytes.push(0);
        }
        std::fs::write(&path, bytes).unwrap();
        refused(&path);
    }

    #[test]
    fn an_xz_file_that_unpacks_to_gigabytes_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("zeros.xml.xz");
        // A mebibyte of zeros by Python's lzma; streams may follow one another (The .xz File Format, 2).
        let stream = include_bytes!("../../tests/fixtures/compressed/zeros.xz");
        std::fs::write(&path, stream.repeat(300)).unwrap();
        refused(&path);
    }
}
