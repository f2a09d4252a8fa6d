//! Output of alpamayo-coc-autolabeler: one `<clip>/cot_<us>.yaml` per key frame, and meta actions as `<clip>.txt`.

use super::{FRAME_US, Reading, Reasoning, findings, text, whole};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// Pointer to the causal text in `final_content`.
const TEXT: &str = "/ego_behavior_schema/effect_on_ego_behavior";
/// Known fields of `results`; `prompt` and `model_usage` describe how the text was made, not its content.
const RESULTS: [&str; 4] =
    ["event_start_frame", "event_start_timestamp", "coc_prompt_version", "final_content"];

/// Reads one `cot_<us>.yaml`; `stem` is its name without the extension, `clip` the name of its folder.
pub fn read_text(file: &str, clip: &str, stem: &str, yaml: &str) -> Reading {
    let mut out = Reading::default();
    let root: Value = match whyroad_model::yaml::from_str(yaml) {
        Ok(value) => value,
        Err(e) => {
            let at = e.mark.map(|m| format!("line {}, column {}: ", m.line, m.column)).unwrap_or_default();
            out.diagnostics.push(findings::unreadable(file, &format!("{at}{}", e.message)));
            return out;
        }
    };
    let Some(results) = root.get("results").and_then(Value::as_object) else {
        out.diagnostics.push(findings::unreadable(file, "it has no mapping `results`"));
        return out;
    };
    out.leave_out_others("", root.as_object().unwrap_or(&Map::new()), &["results"]);
    out.leave_out_others("results.", results, &RESULTS);
    if let Some(content) = results.get("final_content") {
        others_of_content(&mut out, content);
    }
    // The file's name states the time too, if the content does not.
    let named = stem.strip_prefix("cot_").and_then(|us| us.parse().ok());
    let frame = whole(results.get("event_start_frame")).and_then(|f| f.checked_mul(FRAME_US));
    let Some(at_us) = whole(results.get("event_start_timestamp")).or(named).or(frame) else {
        out.diagnostics.push(findings::no_time(file));
        return out;
    };
    let words = results.get("final_content").and_then(|c| text(c.pointer(TEXT)));
    let Some(words) = words else {
        out.diagnostics.push(findings::no_text(file));
        return out;
    };
    let version = results.get("coc_prompt_version").filter(|v| !v.is_null());
    let version = version.map(|v| v.as_str().map_or_else(|| v.to_string(), str::to_owned));
    out.found.push(Reasoning {
        origin: file.to_owned(),
        clip: clip.to_owned(),
        at_us,
        until_us: None,
        text: words,
        components: Vec::new(),
        versions: version
            .map(|v| ("coc_prompt_version".to_owned(), v))
            .into_iter()
            .collect::<BTreeMap<_, _>>(),
    });
    out
}

fn others_of_content(out: &mut Reading, content: &Value) {
    if let Some(fields) = content.as_object() {
        out.leave_out_others("results.final_content.", fields, &["ego_behavior_schema"]);
    }
    if let Some(schema) = content.get("ego_behavior_schema").and_then(Value::as_object) {
        out.leave_out_others(
            "results.final_content.ego_behavior_schema.",
            schema,
            &["effect_on_ego_behavior"],
        );
    }
}

/// Counts the meta actions of a clip: the motion of the car, for which a label has no field. A line that is not a meta
/// action is reported.
pub fn read_meta_actions(file: &str, lines: &str) -> Reading {
    let mut out = Reading::default();
    for (i, line) in lines.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        match line.split_once(" - ") {
            Some((action, rest)) if rest.contains("Start:") && rest.contains("End:") => {
                out.leave_out(format!("meta_action.{}", action.trim()));
            }
            _ => {
                let origin = format!("{file}#{}", i + 1);
                out.diagnostics.push(findings::invalid(
                    &origin,
                    "该行不是元动作",
                    "the line is not a meta action",
                ));
            }
        }
    }
    out
}
