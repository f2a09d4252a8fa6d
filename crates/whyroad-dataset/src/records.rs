//! Values kept on disk between the stages of a build: appended one by one, read back by position. Only the 12-byte
//! position of a record stays in memory.

use crate::DatasetError;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Position of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, serde::Deserialize)]
pub(crate) struct RecordRef {
    offset: u64,
    length: u32,
}

/// A file that is being written.
pub(crate) struct RecordWriter {
    path: PathBuf,
    out: BufWriter<File>,
    at: u64,
}

impl RecordWriter {
    pub fn create(path: &Path) -> Result<Self, DatasetError> {
        let file = File::create(path).map_err(DatasetError::io(path))?;
        Ok(Self { path: path.to_owned(), out: BufWriter::new(file), at: 0 })
    }

    pub fn append<T: Serialize>(&mut self, value: &T) -> Result<RecordRef, DatasetError> {
        let plain = postcard::to_allocvec(value).map_err(|e| DatasetError::broken(&self.path, e))?;
        let packed = lz4_flex::compress_prepend_size(&plain);
        let length = u32::try_from(packed.len()).map_err(|e| DatasetError::broken(&self.path, e))?;
        self.out.write_all(&packed).map_err(DatasetError::io(&self.path))?;
        let at = RecordRef { offset: self.at, length };
        self.at += u64::from(length);
        Ok(at)
    }

    pub fn finish(mut self) -> Result<(), DatasetError> {
        self.out.flush().map_err(DatasetError::io(&self.path))
    }
}

/// Reads one record.
pub(crate) fn read_record<T: DeserializeOwned>(path: &Path, at: RecordRef) -> Result<T, DatasetError> {
    let mut file = File::open(path).map_err(DatasetError::io(path))?;
    let mut packed = vec![0; at.length as usize];
    file.seek(SeekFrom::Start(at.offset))
        .and_then(|_| file.read_exact(&mut packed))
        .map_err(DatasetError::io(path))?;
    let plain = lz4_flex::decompress_size_prepended(&packed).map_err(|e| DatasetError::broken(path, e))?;
    postcard::from_bytes(&plain).map_err(|e| DatasetError::broken(path, e))
}

/// Writes a value atomically.
pub(crate) fn write_value<T: Serialize>(path: &Path, value: &T) -> Result<(), DatasetError> {
    let bytes = postcard::to_allocvec(value).map_err(|e| DatasetError::broken(path, e))?;
    let aside = path.with_extension("writing");
    std::fs::write(&aside, bytes).map_err(DatasetError::io(&aside))?;
    std::fs::rename(&aside, path).map_err(DatasetError::io(path))
}

/// Reads what [`write_value`] wrote.
pub(crate) fn read_value<T: DeserializeOwned>(path: &Path) -> Result<T, DatasetError> {
    let bytes = std::fs::read(path).map_err(DatasetError::io(path))?;
    postcard::from_bytes(&bytes).map_err(|e| DatasetError::broken(path, e))
}
