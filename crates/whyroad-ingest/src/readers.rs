//! Every reader of a single file of outside bytes, by name, on bytes in memory: what the fuzz targets run, a million
//! inputs per minute. They are the functions that the adapters call themselves; whole logs in memory are read by
//! [`crate::read_files`].

use crate::{encodings, formats, maps};

pub use crate::file_reader::FileReader;

/// All of them.
pub fn all() -> Vec<FileReader> {
    let of_encodings = encodings::READERS.iter().copied();
    let of_formats = formats::READERS.iter().flat_map(|of_format| of_format.iter().copied());
    of_encodings.chain(of_formats).chain(maps::READERS.iter().copied()).collect()
}
