//! What can go wrong with a lake, and the message for each.

use parquet::errors::ParquetError;
use std::path::{Path, PathBuf};
use whyroad_model::{Bilingual, Diagnostic, DriveId};

/// Codes of the diagnostics that [`LakeError::diagnostic`] gives; each has a page in `docs/diagnostics/`.
pub const CODES: &[&str] = &[
    "lake.not_a_lake",
    "lake.version",
    "lake.drive_missing",
    "lake.drive_invalid",
    "lake.table_broken",
    "lake.row_order",
    "lake.mined_version",
    "lake.io",
    "lake.url",
    "lake.s3_feature",
    "lake.storage",
    "lake.conditional_writes",
    "lake.changed_meanwhile",
];

/// A lake operation that could not be done at all.
#[derive(Debug, thiserror::Error)]
pub enum LakeError {
    /// The folder has no `whyroad-lake.json`.
    #[error("{} is not a lake: it has no whyroad-lake.json", .0.display())]
    NotALake(PathBuf),
    /// The lake or a drive was written in a layout that this build does not read.
    #[error("{} has lake version {found}; this build reads {}", .path.display(), versions_read(.path).en)]
    Version {
        /// File that states the version.
        path: PathBuf,
        /// Version found.
        found: u32,
        /// Formats of the drives that have to be ingested again, where they are known.
        formats: Vec<String>,
    },
    /// No such drive.
    #[error("drive '{0}' not found in the lake")]
    DriveMissing(DriveId),
    /// The drive breaks a promise of the scene tables and was not written.
    #[error("drive '{drive}' is not valid: {reason}")]
    DriveInvalid {
        /// The drive.
        drive: DriveId,
        /// The promise that it breaks.
        reason: String,
    },
    /// A table cannot be read: damaged, truncated, a column missing or of another type, an invalid value.
    #[error("{}: {reason}", .path.display())]
    TableBroken {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// Rows are not in the order that the file promises.
    #[error("{}: row {row} is out of order (clip, target, frame)", .path.display())]
    RowOrder {
        /// The file.
        path: PathBuf,
        /// First row out of order, from 0.
        row: usize,
    },
    /// A mined folder was written in a layout that this build does not read.
    #[error(
        "{} has episodes version {found}; this build reads {}", .path.display(), crate::mined::EPISODES_VERSION
    )]
    MinedVersion {
        /// The table of episodes.
        path: PathBuf,
        /// Version found, as written.
        found: String,
    },
    /// The file system refused.
    #[error("{}: {source}", .path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Its reason.
        source: std::io::Error,
    },
    /// Not a URL that a lake can have. The URL is not repeated: it may hold a secret.
    #[error("{}", .0.en)]
    Url(Bilingual),
    /// This build has no object stores.
    #[error("{0}: this build has no support for S3")]
    NoS3(String),
    /// The object store refused or failed, also after retries.
    #[error("{url}: {reason}")]
    Storage {
        /// The lake.
        url: String,
        /// Its answer, without secrets.
        reason: String,
    },
    /// The object store ignores the conditions of writes, so that two writers would overwrite each other.
    #[error("{0}: the object store does not support conditional writes (If-Match, If-None-Match)")]
    Unconditional(String),
    /// Another process changed the same files at the same time.
    #[error("{url}: changed by another process at the same time: {}", .what.join(", "))]
    ChangedMeanwhile {
        /// The lake.
        url: String,
        /// Folders of drives, files, or `packs`.
        what: Vec<String>,
    },
}

impl LakeError {
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> LakeError + '_ {
        |source| LakeError::Io { path: path.to_owned(), source }
    }

    pub(crate) fn version(path: &Path, found: u32, formats: Vec<String>) -> LakeError {
        LakeError::Version { path: path.to_owned(), found, formats }
    }

    pub(crate) fn broken(path: &Path, reason: impl std::fmt::Display) -> LakeError {
        LakeError::TableBroken { path: path.to_owned(), reason: reason.to_string() }
    }

    /// A table could not be written: the file system refused, or it could not be encoded.
    pub(crate) fn unwritten(path: &Path) -> impl FnOnce(ParquetError) -> LakeError + '_ {
        |e| match e {
            ParquetError::External(cause) => match cause.downcast::<std::io::Error>() {
                Ok(source) => LakeError::io(path)(*source),
                Err(cause) => LakeError::broken(path, cause),
            },
            e => LakeError::broken(path, e),
        }
    }

    /// Stable code.
    pub fn code(&self) -> &'static str {
        match self {
            LakeError::NotALake(_) => "lake.not_a_lake",
            LakeError::Version { .. } => "lake.version",
            LakeError::DriveMissing(_) => "lake.drive_missing",
            LakeError::DriveInvalid { .. } => "lake.drive_invalid",
            LakeError::TableBroken { .. } => "lake.table_broken",
            LakeError::RowOrder { .. } => "lake.row_order",
            LakeError::MinedVersion { .. } => "lake.mined_version",
            LakeError::Io { .. } => "lake.io",
            LakeError::Url(_) => "lake.url",
            LakeError::NoS3(_) => "lake.s3_feature",
            LakeError::Storage { .. } => "lake.storage",
            LakeError::Unconditional(_) => "lake.conditional_writes",
            LakeError::ChangedMeanwhile { .. } => "lake.changed_meanwhile",
        }
    }

    /// The error as a diagnostic, with a hint.
    pub fn diagnostic(&self) -> Diagnostic {
        let zh = match self {
            LakeError::NotALake(p) => format!("{} 不是数据湖：缺少 whyroad-lake.json", p.display()),
            LakeError::Version { path, found, .. } => {
                format!("数据湖版本为 {found}，本程序只能读取版本 {}", versions_read(path).zh)
            }
            LakeError::DriveMissing(d) => format!("数据湖中没有行程“{d}”"),
            LakeError::DriveInvalid { drive, reason } => format!("行程“{drive}”不合法：{reason}"),
            LakeError::TableBroken { reason, .. } => format!("数据表无法读取：{reason}"),
            LakeError::RowOrder { row, .. } => format!("第 {row} 行的顺序不对（应按片段、目标、帧排序）"),
            LakeError::MinedVersion { found, .. } => {
                format!("事件表版本为 {found}，本程序只能读取版本 {}", crate::mined::EPISODES_VERSION)
            }
            LakeError::Io { source, .. } => format!("文件系统出错：{source}"),
            LakeError::Url(why) => why.zh.clone(),
            LakeError::NoS3(url) => format!("{url}：此版本的程序未启用 S3"),
            LakeError::Storage { reason, .. } => format!("对象存储出错：{reason}"),
            LakeError::Unconditional(_) => "该对象存储不支持条件写入（If-Match、If-None-Match）".to_owned(),
            LakeError::ChangedMeanwhile { what, .. } => format!("另一进程同时作了改动：{}", what.join("、")),
        };
        let hint = match self {
            LakeError::NotALake(_) => Bilingual::new(
                "先用 `whyroad ingest FORMAT PATH --lake DIR` 建立数据湖",
                "make one with `whyroad ingest FORMAT PATH --lake DIR`",
            ),
            LakeError::Version { path, found, formats } => version_hint(path, *found, formats),
            LakeError::DriveMissing(_) => Bilingual::new(
                "用 `whyroad inspect --lake DIR` 查看已有行程",
                "`whyroad inspect --lake DIR` lists the drives",
            ),
            LakeError::DriveInvalid { .. } => Bilingual::new(
                "这是导入适配器的缺陷，请附上报告反馈",
                "this is a bug in the adapter; please report it with this message",
            ),
            LakeError::TableBroken { .. } | LakeError::RowOrder { .. } => Bilingual::new(
                "重新导入原始数据：无法读取的行程会被替换",
                "ingest the source again: a drive that cannot be read is replaced",
            ),
            LakeError::MinedVersion { .. } => Bilingual::new(
                "用 `whyroad mine --out DIR --force` 重新生成该文件夹（信号已保存，很快完成）",
                "run `whyroad mine --out DIR --force` again; stored signals make it fast",
            ),
            LakeError::Url(_) => Bilingual::new(
                "写作 `s3://BUCKET/PREFIX`；凭据与地址由环境变量或 ~/.aws 给出",
                "write `s3://BUCKET/PREFIX`; credentials and endpoint come from the environment or ~/.aws",
            ),
            LakeError::NoS3(_) => Bilingual::new(
                "使用发布的程序，或编译时不加 `--no-default-features`",
                "use a released binary, or build without `--no-default-features`",
            ),
            LakeError::Storage { .. } => Bilingual::new(
                "检查凭据、AWS_REGION、AWS_ENDPOINT_URL 与存储桶；再次运行同一命令即可，已发布的不会重复",
                "check credentials, AWS_REGION, AWS_ENDPOINT_URL and the bucket; run the same command again: what \
                 is published is not repeated",
            ),
            LakeError::Unconditional(_) => Bilingual::new(
                "升级该对象存储，或改用支持条件写入的存储",
                "update the object store, or use one that supports conditional writes",
            ),
            LakeError::ChangedMeanwhile { .. } => Bilingual::new(
                "再次运行同一命令：它从现在的数据湖开始",
                "run the same command again: it starts from the lake as it is now",
            ),
            LakeError::Io { .. } => {
                Bilingual::new("检查路径、权限与磁盘空间", "check the path, permissions and free space")
            }
        };
        let d = Diagnostic::error(self.code(), Bilingual::new(zh, self.to_string())).with_hint(hint);
        match self {
            LakeError::NotALake(p) => d.in_file(p.display().to_string()),
            LakeError::Version { path, .. }
            | LakeError::TableBroken { path, .. }
            | LakeError::RowOrder { path, .. }
            | LakeError::MinedVersion { path, .. }
            | LakeError::Io { path, .. } => d.in_file(path.display().to_string()),
            LakeError::Storage { url, .. }
            | LakeError::Unconditional(url)
            | LakeError::ChangedMeanwhile { url, .. } => d.in_file(url.clone()),
            LakeError::DriveMissing(_)
            | LakeError::DriveInvalid { .. }
            | LakeError::Url(_)
            | LakeError::NoS3(_) => d,
        }
    }
}

/// The versions of a file that this build reads: packs have a version of the lake's layout, but not of its tables.
fn versions_read(path: &Path) -> Bilingual {
    if path.file_name().is_some_and(|name| name == crate::lake::MARKER) {
        let [loose, packed] = crate::LAYOUTS;
        return Bilingual::new(format!("{loose} 与 {packed}"), format!("{loose} and {packed}"));
    }
    Bilingual::same(crate::LAKE_VERSION.to_string())
}

/// How to continue: by ingesting again into the same lake, or with a newer program.
fn version_hint(path: &Path, found: u32, formats: &[String]) -> Bilingual {
    if found > crate::LAKE_VERSION {
        return Bilingual::new("请升级 whyroad", "use a newer whyroad");
    }
    // The folder of the lake: above `drives/` for a file of a drive.
    let lake = path.ancestors().find(|dir| dir.join("drives").is_dir());
    let lake = lake.map_or_else(|| "LAKE".into(), |dir| dir.display().to_string());
    let formats = if formats.is_empty() { vec!["FORMAT".to_owned()] } else { formats.to_vec() };
    let commands: Vec<String> =
        formats.iter().map(|format| format!("`whyroad ingest {format} PATH --lake {lake}`")).collect();
    Bilingual::new(
        format!("请将原始数据重新导入同一数据湖：{}；行程编号不变，标注与任务继续有效", commands.join("；")),
        format!(
            "ingest the source data again into the same lake: {}; drives keep their ids, labels and tasks stay valid",
            commands.join("; ")
        ),
    )
}
