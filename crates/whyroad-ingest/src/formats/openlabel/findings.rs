//! What the OpenLABEL adapter reports, one function per code. Texts only.

use crate::phrases::zh;
use serde_json::Value;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of this adapter; each has a page in `docs/diagnostics/`.
pub(crate) const CODES: &[&str] = &[
    "openlabel.file.unreadable",
    "openlabel.time.missing",
    "openlabel.system.missing",
    "openlabel.system.unknown",
    "openlabel.box.invalid",
    "openlabel.class",
];

pub(super) fn unreadable(file: &str, reason: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("不是可读取的 OpenLABEL 文件：{reason_zh}", reason_zh = zh(reason)),
        format!("not a readable OpenLABEL document: {reason}"),
    );
    Diagnostic::error("openlabel.file.unreadable", message).in_file(file)
}

/// `example`: a time that is stated and not understood.
pub(super) fn no_time(file: &str, frames: usize, example: Option<&Value>) -> Diagnostic {
    let message = match example {
        None => Bilingual::new(
            format!("{frames} 帧都没有时间，无法得到行程"),
            format!("none of its {frames} frames has a time; there is no drive without times"),
        ),
        Some(time) => Bilingual::new(
            format!("{frames} 帧的时间均无法理解（例如 {time}），无法得到行程"),
            format!(
                "the times of its {frames} frames are not understood (for example {time}); there is no drive without times"
            ),
        ),
    };
    Diagnostic::error("openlabel.time.missing", message).with_hint(time_hint(example)).in_file(file)
}

pub(super) fn untimed(file: &str, frames: usize, example: Option<&Value>) -> Diagnostic {
    let message = match example {
        None => Bilingual::new(
            format!("{frames} 帧没有时间，已忽略"),
            format!("{frames} frames have no time and are left out"),
        ),
        Some(time) => Bilingual::new(
            format!("{frames} 帧没有时间或其时间无法理解（例如 {time}），已忽略"),
            format!("{frames} frames have no time, or one that is not understood ({time}), and are left out"),
        ),
    };
    Diagnostic::error("openlabel.time.missing", message).with_hint(time_hint(example)).in_file(file)
}

fn time_hint(example: Option<&Value>) -> Bilingual {
    match example {
        None => Bilingual::new(
            "在 frame_properties.timestamp 中写入每帧的时间",
            "write each frame's time into frame_properties.timestamp",
        ),
        Some(_) => Bilingual::new(
            "日期须带 UTC 偏移，例如 2026-01-15T10:30:00Z 或 2026-01-15T18:30:00+08:00；也可写数字（s、ms、µs、ns）",
            "a date has to state its offset from UTC, as in 2026-01-15T10:30:00Z or 2026-01-15T18:30:00+08:00; a number (s, \
             ms, us, ns) is understood, too",
        ),
    }
}

pub(super) fn no_system(file: &str) -> Diagnostic {
    let message = Bilingual::new(
        "没有类型为 scene_cs、geo_cs 或 local_cs 的坐标系，位置没有参照",
        "no coordinate system of type scene_cs, geo_cs or local_cs: positions refer to nothing",
    );
    Diagnostic::error("openlabel.system.missing", message).in_file(file)
}

pub(super) fn system(file: &str, name: &str, boxes: usize) -> Diagnostic {
    let message = Bilingual::new(
        format!("坐标系 '{name}' 无法换算到世界（或自车）；丢弃 {boxes} 个框"),
        format!(
            "coordinate system '{name}' does not lead to the world's (or the ego's); {boxes} boxes dropped"
        ),
    );
    Diagnostic::warning("openlabel.system.unknown", message)
        .with_hint(Bilingual::new(
            "写出 pose_wrt_parent，或在每帧的 transforms 中写出变换",
            "state its pose_wrt_parent, or a transform in every frame",
        ))
        .in_file(file)
}

pub(super) fn invalid(file: &str, boxes: usize) -> Diagnostic {
    let message = Bilingual::new(
        format!("丢弃 {boxes} 个框：应为 9 或 10 个数"),
        format!("{boxes} boxes dropped: a cuboid has 9 or 10 numbers and a rotation"),
    );
    Diagnostic::warning("openlabel.box.invalid", message).in_file(file)
}

pub(super) fn class(file: &str, names: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("未知类别，记为 unknown：{names}"),
        format!("unknown types, kept as class unknown: {names}"),
    );
    Diagnostic::warning("openlabel.class", message).in_file(file)
}
