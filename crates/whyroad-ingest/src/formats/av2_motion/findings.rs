//! What can be wrong with a motion forecasting scenario. Texts only; the map's findings are those of the sensor logs.

use super::scenario::{EGO, Scenario};
use crate::phrases::zh;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of this adapter.
pub(crate) const CODES: &[&str] = &[
    "av2.motion.unreadable",
    "av2.motion.invalid",
    "av2.motion.type",
    "av2.motion.empty",
    "av2.motion.no_ego",
];

pub(super) fn unreadable(file: &str, reason: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("场景无法读取：{reason_zh}", reason_zh = zh(reason)),
        format!("the scenario cannot be read: {reason}"),
    );
    let hint = Bilingual::new("重新下载该场景文件夹", "download the scenario's folder again");
    Diagnostic::error("av2.motion.unreadable", message).in_file(file).with_hint(hint)
}

pub(super) fn no_ego(file: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("没有轨迹 '{EGO}'：自车位姿未知，凡涉及自车的信号都将是未知"),
        format!(
            "track '{EGO}' is missing: the ego's pose is unknown, and with it every signal about the ego"
        ),
    );
    Diagnostic::warning("av2.motion.no_ego", message).in_file(file)
}

pub(super) fn of_rows(file: &str, s: &Scenario) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    let lost = s.count.dropped_total();
    if lost > 0 {
        let example = s.invalid_example.as_deref().unwrap_or("-");
        out.push(Diagnostic::warning(
            "av2.motion.invalid",
            Bilingual::new(
                format!("丢弃 {lost} 行：编号、时间步、位置或航向无效，或同一时间步重复；第一个无效行：{example_zh}", example_zh = zh(example)),
                format!("{lost} rows dropped: id, time step, position or heading is not valid, or a time step occurs twice; first that is not valid: {example}"),
            ),
        ));
    }
    if let Some((kind, _)) = s.unknown_types.first_key_value() {
        let rows: usize = s.unknown_types.values().sum();
        out.push(Diagnostic::warning(
            "av2.motion.type",
            Bilingual::new(
                format!("{rows} 行的物体类型 AV2 没有定义；类别记为未知；例如 '{kind}'"),
                format!("{rows} rows have an object type that AV2 does not define; their class is unknown; for example '{kind}'"),
            ),
        ));
    }
    if s.tracks.is_empty() {
        let message =
            Bilingual::new("场景中没有一行可用", "the scenario has no usable row; no drive was made");
        out.push(Diagnostic::error("av2.motion.empty", message));
    }
    out.into_iter().map(|d| d.in_file(file)).collect()
}
