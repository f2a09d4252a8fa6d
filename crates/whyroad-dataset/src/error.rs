//! Errors that stop a data set command, and the codes of everything that it can report.

use std::path::{Path, PathBuf};
use whyroad_lake::LakeError;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of this crate's diagnostics, except those of the spec; each has a page in `docs/diagnostics/`.
pub const CODES: &[&str] = &[
    "dataset.io",
    "dataset.release.exists",
    "dataset.release.broken",
    "dataset.work.other",
    "dataset.work.busy",
    "dataset.labels.line",
    "dataset.labels.invalid",
    "dataset.label.uncompared",
    "dataset.split.keep",
    "dataset.labels.drive",
    "dataset.labels.none",
    "dataset.samples.none",
    "dataset.score.unknown",
    "dataset.select.unknown",
    "dataset.licence.unknown",
    "dataset.licence.forbidden",
    "dataset.licence.conflict",
    "dataset.licence.table",
    "dataset.drive.unreadable",
    "dataset.window.incomplete",
    "dataset.image.missing",
    "dataset.image.blur",
    "dataset.group.unknown",
    "dataset.polygon.unused",
    "dataset.split.empty",
    "dataset.split.leak",
    "dataset.split.near",
    "dataset.duplicate.across",
    "dataset.file.missing",
    "dataset.file.extra",
    "dataset.file.hash",
    "dataset.label.stale",
    "dataset.sample.count",
    "dataset.sample.repeated",
    "dataset.shortfall",
    "doubtful.probability.missing",
    "score.prediction.line",
    "score.prediction.repeated",
    "score.class.unknown",
    "score.sample.unknown",
    "score.sample.missing",
    "score.trajectory.short",
    "score.decision.unknown",
];

/// A command that could not be done at all.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// The file system refused.
    #[error("{}: {source}", .path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Its reason.
        source: std::io::Error,
    },
    /// The lake cannot be read.
    #[error(transparent)]
    Lake(#[from] LakeError),
    /// The output exists already: a release never changes.
    #[error("{} exists already; a release never changes", .0.display())]
    Exists(PathBuf),
    /// The work folder belongs to a build with other inputs.
    #[error("{} was left by a build with other inputs", .0.display())]
    OtherWork(PathBuf),
    /// Another build writes into the same folder.
    #[error("another build is working in {}", .0.display())]
    Busy(PathBuf),
    /// The folder is no release.
    #[error("{}: not a release: there is no manifest.json", .0.display())]
    NoRelease(PathBuf),
    /// A file of a release cannot be read.
    #[error("{}: {reason}", .path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The build is refused for these reasons.
    #[error("the build is refused: {} reasons", .0.len())]
    Refused(Vec<Diagnostic>),
    /// The caller asked to stop; the work so far is kept.
    #[error("stopped; run the same command again to continue")]
    Stopped,
}

impl DatasetError {
    /// A failure of the file system at `path`, for `map_err`.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        |source| Self::Io { path: path.to_owned(), source }
    }

    /// A file of a release that cannot be read.
    pub fn broken(path: &Path, reason: impl std::fmt::Display) -> Self {
        Self::Broken { path: path.to_owned(), reason: reason.to_string() }
    }

    /// The error as a diagnostic.
    pub fn diagnostics(&self) -> Vec<Diagnostic> {
        let en = self.to_string();
        let one = |code, zh: String, hint: Option<(&str, &str)>| {
            let d = Diagnostic::error(code, Bilingual::new(zh, en.clone()));
            vec![match hint {
                Some((zh, en)) => d.with_hint(Bilingual::new(zh, en)),
                None => d,
            }]
        };
        match self {
            Self::Io { path, source } => one(
                "dataset.io",
                format!("{}：{source}", path.display()),
                Some(("检查路径、权限与磁盘空间", "check the path, permissions and free space")),
            ),
            Self::Lake(e) => vec![e.diagnostic()],
            Self::Exists(path) => one(
                "dataset.release.exists",
                format!("{} 已存在；发布的数据集不再改动", path.display()),
                Some(("换一个 --out 文件夹", "name another folder with --out")),
            ),
            Self::OtherWork(path) => one(
                "dataset.work.other",
                format!("{} 是输入不同的一次构建留下的", path.display()),
                Some(("加 --restart 丢弃它", "--restart discards it")),
            ),
            Self::Busy(path) => one(
                "dataset.work.busy",
                format!("另一个构建正在使用 {}", path.display()),
                Some((
                    "等它结束，或换一个 --out 文件夹",
                    "wait until it ends, or name another folder with --out",
                )),
            ),
            Self::NoRelease(path) => one(
                "dataset.release.broken",
                format!("{}：不是发布的数据集：其中没有 manifest.json", path.display()),
                None,
            ),
            Self::Broken { path, reason } => {
                one("dataset.release.broken", format!("{}：{reason}", path.display()), None)
            }
            Self::Refused(found) => found.clone(),
            Self::Stopped => vec![],
        }
    }
}
