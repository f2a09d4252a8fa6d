//! Diagnostics for a text that names no class, or several.

use whyroad_model::{Bilingual, Diagnostic, ScenarioId};

/// `text` names no class; `near` are the ids to suggest, best first.
pub fn class_not_found(text: &str, near: &[String]) -> Diagnostic {
    let message = Bilingual::new(format!("没有类别 '{text}'"), format!("class '{text}' not found"));
    let d = Diagnostic::error("taxonomy.class.unknown", message);
    match near {
        [] => d.with_hint(Bilingual::new(
            "用 `whyroad taxonomy list` 查看全部类别",
            "`whyroad taxonomy list` shows all classes",
        )),
        near => {
            let ids = near.iter().map(|id| format!("'{id}'")).collect::<Vec<_>>().join(", ");
            d.with_hint(Bilingual::new(format!("是否想写 {ids}？"), format!("did you mean {ids}?")))
        }
    }
}

/// `text` is the short id of several classes.
pub fn class_ambiguous(text: &str, ids: &[ScenarioId]) -> Diagnostic {
    let list = ids.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    let message = Bilingual::new(
        format!("'{text}' 是 {} 个类别的短 id", ids.len()),
        format!("'{text}' is the short id of {} classes", ids.len()),
    );
    Diagnostic::error("taxonomy.class.ambiguous", message)
        .with_hint(Bilingual::new(format!("请写全：{list}"), format!("write one of: {list}")))
}
