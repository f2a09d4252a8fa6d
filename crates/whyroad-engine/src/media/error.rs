//! Why no image could be attached to a drive.

use std::path::{Path, PathBuf};
use whyroad_lake::LakeError;
use whyroad_model::{Bilingual, DriveId, Nanos};

/// No image was attached; the lake is unchanged.
#[derive(Debug, thiserror::Error)]
pub enum MediaError {
    /// The lake or the drive cannot be read or written.
    #[error(transparent)]
    Lake(#[from] LakeError),
    /// The drive has no frames.
    #[error("drive '{0}' has no frames")]
    EmptyDrive(DriveId),
    /// A file or folder cannot be read or written.
    #[error("cannot use {}: {source}", .path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The list cannot be read.
    #[error("cannot read {}: {reason}", .path.display())]
    List {
        /// The list.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// Numbers are missing in a folder with a fixed rate.
    #[error(
        "images are missing between {before} and {after}: at a fixed rate all later ones would be shown too early; \
         give their times with --times"
    )]
    Gap {
        /// The last image before the gap.
        before: String,
        /// The first after it.
        after: String,
    },
    /// No image can be used.
    #[error(
        "none of the images can be used ({} rejected); the drive is from {first} to {last}; the lake is unchanged",
        .rejected.len()
    )]
    NothingUsable {
        /// Start of the drive.
        first: Nanos,
        /// Its last frame.
        last: Nanos,
        /// All of them, with the reason.
        rejected: Vec<(PathBuf, Bilingual)>,
    },
}

impl MediaError {
    pub(super) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> MediaError + '_ {
        |source| MediaError::Io { path: path.to_owned(), source }
    }

    /// In both languages.
    pub fn text(&self) -> Bilingual {
        let zh = match self {
            MediaError::Lake(e) => return e.diagnostic().message,
            MediaError::EmptyDrive(id) => format!("行程“{id}”没有帧"),
            MediaError::Io { path, source } => format!("无法使用 {}：{source}", path.display()),
            MediaError::List { path, reason } => format!("无法读取 {}：{reason}", path.display()),
            MediaError::Gap { before, after } => format!(
                "{before} 与 {after} 之间缺少图片：按固定频率会使其后的图片时间提前；请用 --times 给出时间"
            ),
            MediaError::NothingUsable { first, last, rejected } => format!(
                "没有可用的图片（{} 张不可用）；行程从 {first} 到 {last}；数据湖未改动",
                rejected.len()
            ),
        };
        Bilingual::new(zh, self.to_string())
    }
}
