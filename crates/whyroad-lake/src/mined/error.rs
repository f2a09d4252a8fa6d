//! Why a mined folder could not be written.

use super::question::MiningQuestion;
use std::path::{Path, PathBuf};

/// The folder could not be written.
#[derive(Debug, thiserror::Error)]
pub enum MinedWriteError {
    /// The file system refused.
    #[error("cannot write {}: {source}", .path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Its reason.
        source: std::io::Error,
    },
    /// A table or message could not be encoded.
    #[error("cannot write {}: {reason}", .path.display())]
    Encoding {
        /// File.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The folder holds the results of another question, or of one that it does not record.
    #[error("{} holds the results of another question", .dir.display())]
    OtherQuestion {
        /// The folder.
        dir: PathBuf,
        /// The question that it answers, where it records one.
        found: Option<Box<MiningQuestion>>,
    },
}

pub(super) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> MinedWriteError + '_ {
    |source| MinedWriteError::Io { path: path.to_owned(), source }
}

pub(super) fn encoding<E: std::fmt::Display>(path: &Path) -> impl FnOnce(E) -> MinedWriteError + '_ {
    |e| MinedWriteError::Encoding { path: path.to_owned(), reason: e.to_string() }
}
