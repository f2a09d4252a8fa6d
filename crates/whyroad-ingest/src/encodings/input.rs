//! Where readers take their bytes from: a file or a folder, on disk or in memory (which fuzz targets and tests have).

use crate::encodings::text::utf8_input;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Cursor, Read, Seek};
use std::path::{Path, PathBuf};

/// The bytes of one file.
#[derive(Clone)]
pub(crate) enum Input<'a> {
    File(Cow<'a, Path>),
    Memory(&'a [u8]),
}

/// Bytes that can be read from any position.
pub(crate) trait ReadSeek: Read + Seek {}

impl<T: Read + Seek> ReadSeek for T {}

impl<'a> Input<'a> {
    /// Opens it; also its length in bytes.
    pub fn open(&self) -> io::Result<(Box<dyn ReadSeek + 'a>, u64)> {
        match self {
            Input::File(path) => {
                let file = File::open(path)?;
                let length = file.metadata()?.len();
                Ok((Box::new(file), length))
            }
            Input::Memory(bytes) => Ok((Box::new(Cursor::new(*bytes)), bytes.len() as u64)),
        }
    }

    /// All of it.
    pub fn bytes(&self) -> io::Result<Cow<'a, [u8]>> {
        match self {
            Input::File(path) => fs::read(path).map(Cow::Owned),
            Input::Memory(bytes) => Ok(Cow::Borrowed(bytes)),
        }
    }

    /// All of it as UTF-8.
    pub fn text(&self) -> io::Result<Cow<'a, str>> {
        utf8_input(self.bytes()?)
    }
}

impl<'a> From<&'a Path> for Input<'a> {
    fn from(path: &'a Path) -> Self {
        Input::File(Cow::Borrowed(path))
    }
}

impl<'a> From<&'a PathBuf> for Input<'a> {
    fn from(path: &'a PathBuf) -> Self {
        path.as_path().into()
    }
}

impl<'a> From<&'a [u8]> for Input<'a> {
    fn from(bytes: &'a [u8]) -> Self {
        Input::Memory(bytes)
    }
}

/// A folder whose files are known by name; in memory, parts of a name are separated by `/`.
#[derive(Clone, Copy)]
pub(crate) enum Folder<'a> {
    Disk(&'a Path),
    Memory(&'a BTreeMap<String, Vec<u8>>),
}

impl<'a> Folder<'a> {
    /// The file of this name; `None` when the folder has none.
    pub fn file(self, name: &str) -> Option<Input<'a>> {
        match self {
            Folder::Disk(dir) => {
                let path = dir.join(name);
                path.is_file().then_some(Input::File(Cow::Owned(path)))
            }
            Folder::Memory(files) => files.get(name).map(|bytes| Input::Memory(bytes)),
        }
    }

    /// Names of what lies in the folder, sorted; links that lead nowhere included.
    pub fn names(self) -> Vec<String> {
        let mut names: Vec<String> = match self {
            Folder::Disk(dir) => fs::read_dir(dir)
                .map(|entries| {
                    entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect()
                })
                .unwrap_or_default(),
            Folder::Memory(files) => files.keys().cloned().collect(),
        };
        names.sort();
        names
    }

    /// True when the folder has a file of this name.
    pub fn has(self, name: &str) -> bool {
        self.file(name).is_some()
    }

    /// Name of a file in messages.
    pub fn label(self, name: &str) -> String {
        match self {
            Folder::Disk(dir) => dir.join(name).display().to_string(),
            Folder::Memory(_) => name.to_owned(),
        }
    }

    /// Name of the folder in messages.
    pub fn own_label(self) -> String {
        match self {
            Folder::Disk(dir) => dir.display().to_string(),
            Folder::Memory(_) => "memory".to_owned(),
        }
    }
}
