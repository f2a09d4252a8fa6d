//! Opens a file, plain or compressed: gzip, xz and zstd are told apart by their first bytes, whatever the name says.

use std::fs::File;
use std::io::{self, BufReader, Cursor, Read};
use std::path::Path;

/// Endings of compressed files.
pub(crate) const ENDINGS: &[&str] = &[".gz", ".xz", ".zst"];

/// The file's unpacked bytes.
pub(crate) fn open(path: &Path) -> io::Result<Box<dyn Read>> {
    let mut magic = Vec::new();
    File::open(path)?.take(6).read_to_end(&mut magic)?;
    let file = File::open(path)?;
    Ok(match magic.as_slice() {
        [0x1f, 0x8b, ..] => Box::new(flate2::read::MultiGzDecoder::new(file)),
        [0x28, 0xb5, 0x2f, 0xfd, ..] => {
            Box::new(ruzstd::decoding::StreamingDecoder::new(file).map_err(io::Error::other)?)
        }
        [0xfd, b'7', b'z', b'X', b'Z', 0] => {
            // The decoder has no streaming reader: the unpacked file is held in memory. What came before a break is kept.
            let mut unpacked = Vec::new();
            match lzma_rs::xz_decompress(&mut BufReader::new(file), &mut unpacked) {
                Ok(()) => Box::new(Cursor::new(unpacked)),
                Err(e) if unpacked.is_empty() => return Err(io::Error::other(format!("{e:?}"))),
                Err(e) => Box::new(Cursor::new(unpacked).chain(Broken(Some(format!("{e:?}"))))),
            }
        }
        _ => Box::new(file),
    })
}

/// Fails with its reason when it is reached.
struct Broken(Option<String>);

impl Read for Broken {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        self.0.take().map_or(Ok(0), |reason| Err(io::Error::other(reason)))
    }
}

/// The name without the ending of a compressed file.
pub(crate) fn without_ending(name: &str) -> &str {
    ENDINGS.iter().find_map(|e| name.strip_suffix(e)).unwrap_or(name)
}
