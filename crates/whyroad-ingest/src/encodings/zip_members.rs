//! Members of a ZIP archive, read one at a time by name and without unpacking. Stored members only: the archives that
//! we read hold compressed files already. Nothing is written, so names of members cannot lead out of a folder.

use crate::file_reader::FileReader;
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

/// Largest member that is read, bytes; a table of one clip has less than one hundredth of this.
const MAX_MEMBER_BYTES: u64 = 256 << 20;

/// An open archive.
pub(crate) struct ZipMembers<R>(zip::ZipArchive<R>);

impl ZipMembers<BufReader<File>> {
    /// Reads the archive's directory; its members are not touched.
    pub fn open(path: &Path) -> Result<Self, String> {
        let file = File::open(path).map_err(|e| e.to_string())?;
        Self::new(BufReader::new(file))
    }
}

impl<R: Read + Seek> ZipMembers<R> {
    /// The same of an archive that is open.
    pub fn new(reader: R) -> Result<Self, String> {
        zip::ZipArchive::new(reader).map(Self).map_err(|e| e.to_string())
    }

    /// True when the archive has a member of this name.
    pub fn has(&self, name: &str) -> bool {
        self.0.index_for_name(name).is_some()
    }

    /// The content of a member; `None` when the archive does not have it.
    pub fn read(&mut self, name: &str) -> Result<Option<Vec<u8>>, String> {
        let Some(index) = self.0.index_for_name(name) else { return Ok(None) };
        let member = self.0.by_index(index).map_err(|e| e.to_string())?;
        let size = member.size();
        if size > MAX_MEMBER_BYTES {
            return Err(format!("member '{name}' has {size} bytes, more than {MAX_MEMBER_BYTES}"));
        }
        // Not reserved by the declared size, which is untrusted; the reader checks the CRC at the end.
        let mut content = Vec::new();
        member.take(MAX_MEMBER_BYTES + 1).read_to_end(&mut content).map_err(|e| e.to_string())?;
        if content.len() as u64 == size {
            Ok(Some(content))
        } else {
            Err(format!("member '{name}' has {} bytes instead of {size}", content.len()))
        }
    }
}

/// For [`crate::readers`]: with members `a` and `b`.
pub(crate) const READER: FileReader = FileReader {
    name: "zip",
    read: |bytes| {
        let Ok(mut archive) = ZipMembers::new(std::io::Cursor::new(bytes)) else { return false };
        ["a", "b"].map(|name| archive.has(name) && archive.read(name).is_ok()) == [true; 2]
    },
};
