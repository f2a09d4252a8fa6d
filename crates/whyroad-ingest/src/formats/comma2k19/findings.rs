//! What can be wrong with a comma2k19 recording.

use crate::phrases::zh;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of this adapter.
pub(crate) const CODES: &[&str] = &[
    "comma2k19.pose.missing",
    "comma2k19.array.unreadable",
    "comma2k19.array.shape",
    "comma2k19.dbc.missing",
    "comma2k19.dbc.unreadable",
    "comma2k19.dbc.foreign",
];

pub(super) fn no_pose(source: &str) -> Diagnostic {
    let message = Bilingual::new("没有可用的位姿，无法建立行程", "no usable pose; no drive was made");
    let hint = Bilingual::new(
        "检查 global_pose/frame_times、frame_positions、frame_velocities、frame_orientations 是否齐全",
        "see that global_pose/frame_times, frame_positions, frame_velocities and frame_orientations are all there",
    );
    Diagnostic::error("comma2k19.pose.missing", message).in_file(source).with_hint(hint)
}

pub(super) fn unreadable(file: &str, reason: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("数组无法读取：{reason_zh}", reason_zh = zh(reason)),
        format!("the array cannot be read: {reason}"),
    );
    let hint = Bilingual::new(
        "文件可能被截断；重新下载，其余部分照常处理",
        "the file may be cut short; fetch it again. The rest was processed",
    );
    Diagnostic::error("comma2k19.array.unreadable", message).in_file(file).with_hint(hint)
}

pub(super) fn shape(file: &str) -> Diagnostic {
    let message = Bilingual::new(
        "各数组的行数或列数不一致",
        "arrays that belong together differ in rows or have the wrong number of columns",
    );
    let hint =
        Bilingual::new("重新下载该片段；这一部分已略过", "fetch the segment again; this part was left out");
    Diagnostic::error("comma2k19.array.shape", message).in_file(file).with_hint(hint)
}

pub(super) fn dbc(file: &str, reason: &str) -> Diagnostic {
    let first = reason.lines().next().unwrap_or(reason);
    let message = Bilingual::new(
        format!("不是可用的 DBC 文件：{first_zh}", first_zh = zh(first)),
        format!("not a usable DBC file: {first}"),
    );
    let hint = Bilingual::new(
        "使用该车型的 DBC（例如 opendbc 中的文件）",
        "give the DBC of the car, as opendbc has them",
    );
    Diagnostic::error("comma2k19.dbc.unreadable", message).in_file(file).with_hint(hint)
}

pub(super) fn foreign_dbc(file: &str) -> Diagnostic {
    let names = super::state_sources::looked_for();
    let message = Bilingual::new(
        format!("按此 DBC 在日志的总线 0 上解不出任何状态（查找：{names}）；刹车、巡航、档位、转向灯未知"),
        format!(
            "by this DBC no state could be decoded from bus 0 of the log (looked for {names}); brake, cruise, gear and turn signal are unknown"
        ),
    );
    let hint = Bilingual::new(
        "给出与该车型对应的 DBC；目前支持丰田 2017",
        "give the DBC of this very car; Toyota's of 2017 is supported so far",
    );
    Diagnostic::error("comma2k19.dbc.foreign", message).in_file(file).with_hint(hint)
}

pub(super) fn no_dbc(source: &str) -> Diagnostic {
    let message = Bilingual::new(
        "日志有原始 CAN，但没有给出 DBC：刹车、巡航、档位、转向灯未知",
        "the log has raw CAN, but no DBC was given: brake, cruise, gear and turn signal are unknown",
    );
    let hint = Bilingual::new("加上 --dbc 文件", "add --dbc FILE");
    Diagnostic::note("comma2k19.dbc.missing", message).in_file(source).with_hint(hint)
}
