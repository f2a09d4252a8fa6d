//! What the ScenarioNet adapter reports, one function per code. Texts only.

use super::tracks::Tracks;
use crate::encodings::pickle::PickleError;
use crate::phrases::zh;
use crate::report::RowCount;
use whyroad_model::diagnostic::Location;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of the ScenarioNet adapter; each has a page in `docs/diagnostics/`.
pub(crate) const CODES: &[&str] = &[
    "scenarionet.pickle.forbidden",
    "scenarionet.pickle.unreadable",
    "scenarionet.schema",
    "scenarionet.tracks.invalid",
    "scenarionet.tracks.type",
    "scenarionet.ego.missing",
    "scenarionet.map.invalid",
    "scenarionet.key_frames",
];

pub(super) fn io(file: &str, e: &std::io::Error) -> Diagnostic {
    unreadable(file, &e.to_string())
}

pub(super) fn pickle(file: &str, e: &PickleError) -> Diagnostic {
    let PickleError::Forbidden(name) = e else { return unreadable(file, &e.to_string()) };
    Diagnostic::error(
        "scenarionet.pickle.forbidden",
        Bilingual::new(
            format!("pickle 要求加载 {name}，这不是普通数据；已拒绝，未执行任何内容"),
            format!("the pickle asks for {name}, which is not plain data; it was refused and nothing was run"),
        ),
    )
    .with_hint(Bilingual::new(
        "只使用可信来源的文件；若该对象是自定义类型，请先用 ScenarioDescription.to_dict() 转成普通字典再保存",
        "use only files from sources that you trust; if it is your own class, save plain dicts (ScenarioDescription.to_dict())",
    ))
    .in_file(file)
}

fn unreadable(file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "scenarionet.pickle.unreadable",
        Bilingual::new(
            format!("无法读取该 pickle：{reason_zh}", reason_zh = zh(reason)),
            format!("the pickle cannot be read: {reason}"),
        ),
    )
    .with_hint(Bilingual::new("重新下载或重新导出该文件", "download or export the file again"))
    .in_file(file)
}

pub(super) fn schema(file: &str, pointer: &str, what: &str) -> Diagnostic {
    let place =
        Location { file: Some(file.to_owned()), pointer: Some(pointer.to_owned()), ..Location::default() };
    let key = if pointer.is_empty() { "the file" } else { pointer };
    Diagnostic::error(
        "scenarionet.schema",
        Bilingual::new(
            format!("不是 ScenarioNet 场景：{key} {what_zh}", what_zh = zh(what)),
            format!("not a ScenarioNet scenario: {key} {what}"),
        ),
    )
    .with_hint(Bilingual::new(
        "用 MetaDrive 的 ScenarioDescription.sanity_check 检查该文件",
        "check the file with MetaDrive's ScenarioDescription.sanity_check",
    ))
    .at(place)
}

pub(super) fn key_frames(file: &str, step_s: f64) -> Diagnostic {
    Diagnostic::note(
        "scenarionet.key_frames",
        Bilingual::new(
            format!("目标只在每 {step_s:.1} 秒的关键帧上标注，其间为直线插值；只采用关键帧"),
            format!("objects were annotated at key frames every {step_s:.1} s and interpolated between; only the key frames are used"),
        ),
    )
    .in_file(file)
}

/// Everything about the objects.
pub(super) fn of_tracks(file: &str, t: &Tracks) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    if let Some(example) = &t.invalid_example {
        let n = t.count.dropped_total();
        out.push(Diagnostic::warning(
            "scenarionet.tracks.invalid",
            Bilingual::new(
                format!("丢弃 {n} 行；例如 {example_zh}", example_zh = zh(example)),
                format!("{n} rows dropped; for example {example}"),
            ),
        ));
    }
    if !t.unknown_types.is_empty() {
        let list = t.unknown_types.iter().cloned().collect::<Vec<_>>().join(", ");
        out.push(Diagnostic::warning(
            "scenarionet.tracks.type",
            Bilingual::new(
                format!("未知类型，记为 unknown：{list}"),
                format!("types that MetaDrive does not define, kept as class unknown: {list}"),
            ),
        ));
    }
    if let Some(id) = &t.ego_missing {
        out.push(Diagnostic::warning(
            "scenarionet.ego.missing",
            Bilingual::new(
                format!("metadata.sdc_id（'{id}'）不在轨迹中：行程没有自车"),
                format!("metadata.sdc_id ('{id}') is not among the tracks: the drive has no ego"),
            ),
        ));
    }
    out.into_iter().map(|d| d.in_file(file)).collect()
}

pub(super) fn map(file: &str, count: &RowCount, example: &str) -> Diagnostic {
    let n = count.dropped_total();
    Diagnostic::warning(
        "scenarionet.map.invalid",
        Bilingual::new(
            format!("丢弃 {n} 个无效的地图要素；例如 {example_zh}", example_zh = zh(example)),
            format!("{n} map features dropped; for example {example}"),
        ),
    )
    .in_file(file)
}
