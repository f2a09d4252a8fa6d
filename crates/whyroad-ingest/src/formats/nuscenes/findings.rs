//! What the nuScenes adapter reports, one function per code. Texts only.

use super::tables::TableError;
use crate::phrases::zh;
use crate::report::RowCount;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of the nuScenes adapter; each has a page in `docs/diagnostics/`.
pub(crate) const CODES: &[&str] = &[
    "nuscenes.table.unreadable",
    "nuscenes.scene.empty",
    "nuscenes.annotations.invalid",
    "nuscenes.category",
    "nuscenes.bus.unreadable",
    "nuscenes.map.unreadable",
    "nuscenes.map.invalid",
];

pub(super) fn table(dir: &str, e: &TableError) -> Diagnostic {
    let (table, reason) = (e.table, &e.reason);
    Diagnostic::error(
        "nuscenes.table.unreadable",
        Bilingual::new(
            format!("无法读取表 {table}：{reason_zh}", reason_zh = zh(reason)),
            format!("table {table} cannot be read: {reason}"),
        ),
    )
    .with_hint(Bilingual::new("重新解压该数据集的元数据包", "unpack the set's metadata archive again"))
    .in_file(format!("{dir}/{table}.json"))
}

pub(super) fn empty(place: &str) -> Diagnostic {
    Diagnostic::error(
        "nuscenes.scene.empty",
        Bilingual::new(
            "该场景没有两个以上的自车位姿或关键帧",
            "the scene has no two ego poses or keyframes, so it has no frames",
        ),
    )
    .with_hint(Bilingual::new("重新解压该数据集的元数据包", "unpack the set's metadata archive again"))
    .in_file(place)
}

pub(super) fn annotations(place: &str, count: &RowCount, example: &str) -> Diagnostic {
    let n = count.dropped_total();
    Diagnostic::warning(
        "nuscenes.annotations.invalid",
        Bilingual::new(
            format!("丢弃 {n} 行标注；例如 {example_zh}", example_zh = zh(example)),
            format!("{n} annotation rows dropped; for example {example}"),
        ),
    )
    .in_file(place)
}

pub(super) fn category(place: &str, names: &str) -> Diagnostic {
    Diagnostic::warning(
        "nuscenes.category",
        Bilingual::new(
            format!("未知类别，记为 unknown：{names}"),
            format!("categories that nuScenes does not define, kept as class unknown: {names}"),
        ),
    )
    .in_file(place)
}

pub(super) fn bus(file: &str) -> Diagnostic {
    Diagnostic::error(
        "nuscenes.bus.unreadable",
        Bilingual::new(
            "总线消息无法读取，行程不带它保留",
            "the bus messages cannot be read; the drive is kept without them",
        ),
    )
    .with_hint(Bilingual::new("重新解压 CAN bus 扩展包", "unpack the CAN bus expansion again"))
    .in_file(file)
}

pub(super) fn map_unreadable(file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "nuscenes.map.unreadable",
        Bilingual::new(
            format!("地图无法读取，行程不带地图保留：{reason_zh}", reason_zh = zh(reason)),
            format!("the map cannot be read; the drive is kept without it: {reason}"),
        ),
    )
    .with_hint(Bilingual::new("需要地图扩展 1.3 版", "the map expansion in version 1.3 is needed"))
    .in_file(file)
}

pub(super) fn map_invalid(file: &str, count: &RowCount, example: &str) -> Diagnostic {
    let n = count.dropped_total();
    Diagnostic::warning(
        "nuscenes.map.invalid",
        Bilingual::new(
            format!("丢弃 {n} 个无效的地图要素；例如 {example_zh}", example_zh = zh(example)),
            format!("{n} map features dropped; for example {example}"),
        ),
    )
    .in_file(file)
}
