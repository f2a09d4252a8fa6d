//! What the AV2 adapter reports, one function per code. Texts only.

use super::annotations::Annotations;
use super::map::{Dangling, MapReading};
use crate::phrases::zh;
use std::collections::BTreeMap;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of the AV2 adapter; each has a page in `docs/diagnostics/`.
pub(crate) const CODES: &[&str] = &[
    "av2.log.missing",
    "av2.log.empty",
    "av2.feather.truncated",
    "av2.feather.unreadable",
    "av2.annotations.invalid",
    "av2.annotations.duplicate",
    "av2.annotations.size",
    "av2.annotations.category",
    "av2.ego.box_at_axle",
    "av2.pose.missing",
    "av2.pose.invalid",
    "av2.pose.backward_time",
    "av2.pose.uncovered",
    "av2.map.missing",
    "av2.map.unreadable",
    "av2.map.invalid",
    "av2.map.dangling",
    "av2.map.border",
    "av2.map.turned_edge",
];

fn text(zh: String, en: String) -> Bilingual {
    Bilingual::new(zh, en)
}

pub(super) fn log_missing(place: &str) -> Diagnostic {
    Diagnostic::error(
        "av2.log.missing",
        text(
            format!("{place} 中没有 annotations.feather，也没有 annotations_with_ego.feather"),
            format!("{place} has neither annotations.feather nor annotations_with_ego.feather"),
        ),
    )
    .with_hint(Bilingual::new(
        "请给出一个日志文件夹（其中有 annotations.feather），或包含若干日志文件夹的上级文件夹",
        "name a log folder (one with annotations.feather in it) or a folder of such folders",
    ))
    .in_file(place)
}

pub(super) fn log_empty(file: &str) -> Diagnostic {
    Diagnostic::error(
        "av2.log.empty",
        text(
            "日志中没有一行可用的标注".into(),
            "the log has no usable annotation row, so it has no frames".into(),
        ),
    )
    .with_hint(Bilingual::new(
        "重新下载该日志，或将其移出文件夹",
        "download the log again, or move it out of the folder",
    ))
    .in_file(file)
}

pub(super) fn truncated(file: &str, rows: usize, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "av2.feather.truncated",
        text(
            format!("文件不完整：只读出 {rows} 行，其余丢失（{reason_zh}）", reason_zh = zh(reason)),
            format!("the file is cut short: {rows} rows could be read, the rest is lost ({reason})"),
        ),
    )
    .with_hint(Bilingual::new(
        "重新下载或重新复制该文件，然后再次导入",
        "download or copy the file again, then ingest again",
    ))
    .in_file(file)
}

pub(super) fn unreadable(file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "av2.feather.unreadable",
        text(
            format!("文件无法读取：{reason_zh}", reason_zh = zh(reason)),
            format!("the file cannot be read: {reason}"),
        ),
    )
    .with_hint(Bilingual::new(
        "检查它是否为 AV2 的 feather 文件",
        "check that it is a feather file as AV2 publishes it",
    ))
    .in_file(file)
}

/// Everything about single rows.
pub(super) fn of_rows(
    file: &str,
    a: &Annotations,
    unknown_categories: &BTreeMap<String, usize>,
) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    let dropped = |why: &str| a.count.dropped.get(why).copied().unwrap_or(0);
    if let Some(example) = &a.invalid_example {
        let n = dropped("invalid");
        out.push(Diagnostic::warning(
            "av2.annotations.invalid",
            text(
                format!(
                    "丢弃 {n} 行：位置、旋转、时间或编号无效；例如 {example_zh}",
                    example_zh = zh(example)
                ),
                format!(
                    "{n} rows dropped: position, rotation, time or id is not valid; for example {example}"
                ),
            ),
        ));
    }
    if let Some(example) = &a.duplicate_example {
        let n = dropped("duplicate");
        out.push(Diagnostic::warning(
            "av2.annotations.duplicate",
            text(
                format!("丢弃 {n} 行：同一轨迹同一时刻重复（保留第一行）；例如 {example_zh}", example_zh = zh(example)),
                format!("{n} rows dropped: a second row of a track at one time (the first is kept); for example {example}"),
            ),
        ));
    }
    if a.bad_sizes > 0 {
        let n = a.bad_sizes;
        out.push(Diagnostic::warning(
            "av2.annotations.size",
            text(
                format!("{n} 行的尺寸无效，已记为未知"),
                format!("{n} rows have no valid size; it is set to unknown"),
            ),
        ));
    }
    if !unknown_categories.is_empty() {
        let list: Vec<String> = unknown_categories.iter().map(|(c, n)| format!("{c} ({n})")).collect();
        let list = list.join(", ");
        out.push(Diagnostic::warning(
            "av2.annotations.category",
            text(
                format!("未知类别，记为 unknown：{list}"),
                format!("categories that AV2 does not define, kept as class unknown: {list}"),
            ),
        ));
    }
    out.into_iter().map(|d| d.in_file(file)).collect()
}

pub(super) fn box_at_axle(file: &str) -> Diagnostic {
    Diagnostic::note(
        "av2.ego.box_at_axle",
        Bilingual::new(
            "EGO_VEHICLE 的框中心被写在后轴处；采用其尺寸，并将中心前移到车身中心",
            "the EGO_VEHICLE box has its center on the rear axle; its size is used, its center is moved forward to the middle of the car",
        ),
    )
    .in_file(file)
}

pub(super) fn pose_missing(dir: &str) -> Diagnostic {
    Diagnostic::warning(
        "av2.pose.missing",
        Bilingual::new(
            "没有 city_SE3_egovehicle.feather：轨迹保留在自车坐标系中，没有自车运动，也没有对地速度",
            "city_SE3_egovehicle.feather is missing: tracks are kept in the ego's frame, without ego motion and without speeds over ground",
        ),
    )
    .in_file(dir)
}

pub(super) fn pose_invalid(file: &str, rows: usize) -> Diagnostic {
    Diagnostic::warning(
        "av2.pose.invalid",
        text(
            format!("丢弃 {rows} 行无效或重复的位姿"),
            format!("{rows} pose rows dropped: invalid, or a second one at the same time"),
        ),
    )
    .in_file(file)
}

pub(super) fn pose_backward(file: &str) -> Diagnostic {
    Diagnostic::warning(
        "av2.pose.backward_time",
        Bilingual::new(
            "位姿的时间有倒退；已按时间排序",
            "pose times run backwards in places; the rows were sorted by time",
        ),
    )
    .in_file(file)
}

pub(super) fn pose_uncovered(file: &str, frames: usize, rows: usize) -> Diagnostic {
    Diagnostic::warning(
        "av2.pose.uncovered",
        text(
            format!("{frames} 帧没有自车位姿，丢弃其中的 {rows} 行标注"),
            format!(
                "{frames} frames have no ego pose; they are left out, and {rows} annotation rows with them"
            ),
        ),
    )
    .in_file(file)
}

/// The poses are at other times than all annotations.
pub(super) fn pose_elsewhere(file: &str, frames: usize) -> Diagnostic {
    Diagnostic::error(
        "av2.pose.uncovered",
        text(
            format!("位姿的时间不含标注的任何一帧（共 {frames} 帧）：自车位姿视为未知"),
            format!(
                "the poses cover none of the {frames} frames with annotations: the ego's pose is unknown"
            ),
        ),
    )
    .with_hint(text(
        "检查两个文件的 timestamp_ns 是否用同一时钟、同一单位（ns）".to_owned(),
        "check that timestamp_ns of both files is of one clock and in ns".to_owned(),
    ))
    .in_file(file)
}

pub(super) fn map_missing(dir: &str) -> Diagnostic {
    Diagnostic::warning(
        "av2.map.missing",
        Bilingual::new(
            "没有 log_map_archive_*.json：凡需要车道、路口或人行横道的信号都将是未知",
            "log_map_archive_*.json is missing: signals that need lanes, junctions or crosswalks will be unknown",
        ),
    )
    .in_file(dir)
}

pub(super) fn map_unreadable(file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "av2.map.unreadable",
        text(
            format!("地图无法读取，行程不带地图保留：{reason_zh}", reason_zh = zh(reason)),
            format!("the map cannot be read; the drive is kept without it: {reason}"),
        ),
    )
    .with_hint(Bilingual::new(
        "重新下载该地图文件，然后再次导入",
        "download the map file again, then ingest again",
    ))
    .in_file(file)
}

/// Everything about the map's contents.
pub(super) fn of_map(file: &str, r: &MapReading) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    if let Some(example) = &r.invalid_example {
        let n = r.count.dropped_total();
        out.push(Diagnostic::warning(
            "av2.map.invalid",
            text(
                format!("丢弃 {n} 个无效的地图要素；例如 {example_zh}", example_zh = zh(example)),
                format!("{n} map features dropped; for example {example}"),
            ),
        ));
    }
    let mut groups: BTreeMap<(bool, &str), Vec<&Dangling>> = BTreeMap::new();
    for d in &r.dangling {
        groups.entry((d.at_border, d.field)).or_default().push(d);
    }
    for ((at_border, field), all) in groups {
        let (n, first) = (all.len(), all[0]);
        let example_en = format!("lane {} names {}", first.lane, first.missing);
        let example_zh = format!("车道 {} 指向 {}", first.lane, first.missing);
        out.push(if at_border {
            Diagnostic::note(
                "av2.map.border",
                text(
                    format!("{n} 个 {field} 指向地图边界之外的车道（车道保留）；例如{example_zh}"),
                    format!("{n} {field} name lanes beyond the map's border (the lanes are kept); for example {example_en}"),
                ),
            )
        } else {
            Diagnostic::warning(
                "av2.map.dangling",
                text(
                    format!("{n} 个 {field} 指向不存在的车道，且不在地图边界（车道保留）；例如{example_zh}"),
                    format!("{n} {field} name lanes that the map does not have, and not at its border (the lanes are kept); for example {example_en}"),
                ),
            )
            .with_hint(Bilingual::new(
                "在地图 JSON 中改正该编号，或重新下载地图",
                "correct the id in the map's JSON, or download the map again",
            ))
        });
    }
    if r.turned_edges > 0 {
        let n = r.turned_edges;
        out.push(Diagnostic::note(
            "av2.map.turned_edge",
            text(
                format!("{n} 条车道的左右边界方向相反；已将右边界反向"),
                format!("{n} lanes have edges that run against each other; the right one was turned round"),
            ),
        ));
    }
    out.into_iter().map(|d| d.in_file(file)).collect()
}
