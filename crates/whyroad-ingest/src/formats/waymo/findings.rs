//! What the Waymo adapter reports, one function per code. Texts only.

use crate::encodings::tfrecord::RecordError;
use crate::phrases::zh;
use crate::report::RowCount;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of the Waymo adapter; each has a page in `docs/diagnostics/`.
pub(crate) const CODES: &[&str] = &[
    "waymo.record.truncated",
    "waymo.record.corrupt",
    "waymo.schema",
    "waymo.ego.missing",
    "waymo.tracks.invalid",
    "waymo.map.invalid",
];

pub(super) fn record(file: &str, e: &RecordError) -> Diagnostic {
    let (code, zh) = match e {
        RecordError::Truncated { at, wanted, have } => (
            "waymo.record.truncated",
            format!("位于字节 {at} 的记录需要 {wanted} 字节，文件只剩 {have} 字节"),
        ),
        RecordError::Length(at) => ("waymo.record.corrupt", format!("位于字节 {at} 的记录长度与校验和不符")),
        RecordError::Content(at) => ("waymo.record.corrupt", format!("位于字节 {at} 的记录与校验和不符")),
        RecordError::Io(e) => ("waymo.record.corrupt", e.to_string()),
    };
    let (zh, en) = (
        format!("{zh}；该记录及其后的内容丢失"),
        format!("{e}; this record is lost, and any after it that cannot be found"),
    );
    Diagnostic::error(code, Bilingual::new(zh, en))
        .with_hint(Bilingual::new("重新下载该文件", "download the file again"))
        .in_file(file)
}

pub(super) fn schema(file: &str, what: &str) -> Diagnostic {
    Diagnostic::error(
        "waymo.schema",
        Bilingual::new(
            format!("记录不是 Scenario 消息：{what_zh}", what_zh = zh(what)),
            format!("the record is not a Scenario message: {what}"),
        ),
    )
    .with_hint(Bilingual::new(
        "需要运动数据集的 scenario 格式（不是 tf_example，也不是感知数据集）",
        "the motion data set's scenario files are needed (not tf_example, not the perception set)",
    ))
    .in_file(file)
}

pub(super) fn ego_missing(file: &str, index: Option<usize>, tracks: usize) -> Diagnostic {
    let index = index.map_or("-".to_owned(), |i| i.to_string());
    Diagnostic::warning(
        "waymo.ego.missing",
        Bilingual::new(
            format!("sdc_track_index（{index}）不是 {tracks} 条轨迹之一：行程没有自车"),
            format!("sdc_track_index ({index}) is outside the {tracks} tracks: the drive has no ego"),
        ),
    )
    .in_file(file)
}

pub(super) fn tracks(file: &str, count: &RowCount, example: &str) -> Diagnostic {
    let n = count.dropped_total();
    Diagnostic::warning(
        "waymo.tracks.invalid",
        Bilingual::new(
            format!("丢弃 {n} 行；例如 {example_zh}", example_zh = zh(example)),
            format!("{n} rows dropped; for example {example}"),
        ),
    )
    .in_file(file)
}

pub(super) fn map(file: &str, count: &RowCount, example: &str) -> Diagnostic {
    let n = count.dropped_total();
    Diagnostic::warning(
        "waymo.map.invalid",
        Bilingual::new(
            format!("丢弃 {n} 个无效的地图要素；例如 {example_zh}", example_zh = zh(example)),
            format!("{n} map features dropped; for example {example}"),
        ),
    )
    .in_file(file)
}
