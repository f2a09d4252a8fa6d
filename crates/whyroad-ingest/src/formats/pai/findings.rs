//! What the PhysicalAI-AV adapter reports, one function per code. Texts only.

use super::obstacles::Obstacles;
use crate::phrases::zh;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of this adapter; each has a page in `docs/diagnostics/`.
pub(crate) const CODES: &[&str] = &[
    "pai.tree.unreadable",
    "pai.clip.invalid",
    "pai.egomotion.missing",
    "pai.egomotion.unreadable",
    "pai.egomotion.invalid",
    "pai.egomotion.velocity",
    "pai.dimensions.missing",
    "pai.obstacles.missing",
    "pai.obstacles.unreadable",
    "pai.obstacles.invalid",
    "pai.obstacles.class",
    "pai.obstacles.partial",
    "pai.camera.unreadable",
];

fn again() -> Bilingual {
    Bilingual::new("重新下载该文件，然后再次导入", "download the file again, then ingest again")
}

pub(super) fn tree(file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "pai.tree.unreadable",
        Bilingual::new(
            format!("表无法读取：{reason_zh}", reason_zh = zh(reason)),
            format!("the table cannot be read: {reason}"),
        ),
    )
    .with_hint(again())
    .in_file(file)
}

pub(super) fn clip_invalid(clip: &str) -> Diagnostic {
    Diagnostic::warning(
        "pai.clip.invalid",
        Bilingual::new(
            "clip_index 将该片段标为无效（clip_is_valid = false）；未导入",
            "clip_index marks the clip as not valid (clip_is_valid = false); it is left out",
        ),
    )
    .in_file(clip)
}

pub(super) fn egomotion_missing(clip: &str) -> Diagnostic {
    Diagnostic::error(
        "pai.egomotion.missing",
        Bilingual::new(
            "没有可用的自车运动（egomotion）；没有它就没有时间与位置，因此不建立行程",
            "no usable egomotion, hence neither time nor position; no drive was made",
        ),
    )
    .with_hint(Bilingual::new(
        "下载该分块的 labels/egomotion，然后再次导入",
        "download labels/egomotion of this chunk, then ingest again",
    ))
    .in_file(clip)
}

pub(super) fn egomotion_unreadable(clip: &str, file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "pai.egomotion.unreadable",
        Bilingual::new(
            format!("{file} 无法读取：{reason_zh}", reason_zh = zh(reason)),
            format!("{file} cannot be read: {reason}"),
        ),
    )
    .with_hint(again())
    .in_file(clip)
}

pub(super) fn egomotion_invalid(clip: &str, rows: usize) -> Diagnostic {
    Diagnostic::warning(
        "pai.egomotion.invalid",
        Bilingual::new(
            format!("丢弃 {rows} 行无效或同一时刻重复的位姿"),
            format!("{rows} pose rows dropped: invalid, or a second one at the same time"),
        ),
    )
    .in_file(clip)
}

pub(super) fn velocity(clip: &str) -> Diagnostic {
    Diagnostic::warning(
        "pai.egomotion.velocity",
        Bilingual::new(
            "egomotion 的速度与其位置相差超过 1 m/s（中位数）；改由位置推导速度",
            "the velocities of egomotion differ from its positions by more than 1 m/s (median); velocity is derived \
             from the positions",
        ),
    )
    .in_file(clip)
}

pub(super) fn dimensions(clip: &str, reason: Option<&str>) -> Diagnostic {
    let (zh, en) = match reason {
        Some(reason) => (
            format!("车辆尺寸无法读取（{reason_zh}）", reason_zh = zh(reason)),
            format!("vehicle dimensions cannot be read ({reason})"),
        ),
        None => ("没有车辆尺寸".to_owned(), "vehicle dimensions are missing".to_owned()),
    };
    Diagnostic::warning(
        "pai.dimensions.missing",
        Bilingual::new(
            format!("{zh}：自车尺寸未知，自车位置为后轴而非车身中心"),
            format!(
                "{en}: the size of the ego is unknown, and its position is the rear axle, not the box center"
            ),
        ),
    )
    .with_hint(Bilingual::new(
        "下载该分块的 calibration/vehicle_dimensions，然后再次导入",
        "download calibration/vehicle_dimensions of this chunk, then ingest again",
    ))
    .in_file(clip)
}

pub(super) fn obstacles_missing(clip: &str) -> Diagnostic {
    Diagnostic::note(
        "pai.obstacles.missing",
        Bilingual::new(
            "该片段没有 obstacle.offline 的行：周围目标未知，并非没有目标",
            "no rows of obstacle.offline for this clip: objects are unknown, which does not mean that there \
             are none",
        ),
    )
    .in_file(clip)
}

pub(super) fn obstacles_unreadable(clip: &str, file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "pai.obstacles.unreadable",
        Bilingual::new(
            format!("{file} 无法读取，行程不带目标保留：{reason_zh}", reason_zh = zh(reason)),
            format!("{file} cannot be read; the drive is kept without objects: {reason}"),
        ),
    )
    .with_hint(again())
    .in_file(clip)
}

pub(super) fn partial(clip: &str, seconds: f64) -> Diagnostic {
    Diagnostic::note(
        "pai.obstacles.partial",
        Bilingual::new(
            format!("obstacle.offline 的行未覆盖行程首尾共 {seconds:.1} 秒：这段时间内的目标未知"),
            format!(
                "rows of obstacle.offline do not cover {seconds:.1} s at the ends of the drive: objects are unknown there"
            ),
        ),
    )
    .in_file(clip)
}

pub(super) fn of_obstacles(clip: &str, o: &Obstacles) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    let lost = o.count.dropped_total();
    if lost > 0 {
        let example = o.invalid_example.as_deref().unwrap_or("-");
        out.push(Diagnostic::warning(
            "pai.obstacles.invalid",
            Bilingual::new(
                format!("丢弃 {lost} 行目标：数值无效、同一时刻重复、坐标系不是 rig，或该时刻没有位姿；第一个无效行：{example_zh}", example_zh = zh(example)),
                format!(
                    "{lost} obstacle rows dropped: invalid, a second one at the same time, a frame other than rig, or no \
                     pose at that time; first that is not valid: {example}"
                ),
            ),
        ));
    }
    if let Some((word, _)) = o.unknown_classes.first_key_value() {
        let rows: usize = o.unknown_classes.values().sum();
        out.push(Diagnostic::warning(
            "pai.obstacles.class",
            Bilingual::new(
                format!("{rows} 行的类别不在该格式的定义中；类别记为未知；例如 '{word}'"),
                format!("{rows} rows have a class that the format does not define; it is unknown; for example '{word}'"),
            ),
        ));
    }
    out.into_iter().map(|d| d.in_file(clip)).collect()
}

pub(super) fn camera(clip: &str, file: &str, reason: &str) -> Diagnostic {
    Diagnostic::warning(
        "pai.camera.unreadable",
        Bilingual::new(
            format!("{file} 的帧时间无法使用，行程不带该相机保留：{reason_zh}", reason_zh = zh(reason)),
            format!("frame times of {file} cannot be used; the drive is kept without this camera: {reason}"),
        ),
    )
    .with_hint(again())
    .in_file(clip)
}
