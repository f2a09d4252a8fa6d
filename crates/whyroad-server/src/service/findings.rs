//! Findings of the checker in a draft. In Stage I it sees only the fields that the annotator sees: the others are
//! replaced by values that are the same for every task, so that no finding depends on hidden fields.

use crate::app::App;
use crate::domain::task::Finding;
use crate::domain::workflow::{Stage, State};
use crate::service::tasks::{LabelView, TaskRow};
use crate::service::visible;
use serde_json::{Value, json};
use whyroad_label::check::UNRECORDED;
use whyroad_model::label_fields::{name, pointer};
use whyroad_model::{Diagnostic, Nanos, Severity};

/// The findings in `draft`, a label of `task`, as far as the stage of `view` shows it, sorted by location.
pub fn of(app: &App, task: &TaskRow, draft: &Value, view: LabelView) -> Vec<Finding> {
    match view.stage {
        Stage::Stage1 => {
            let probe = probe(draft, view);
            let mut found = in_stage1(app, task, &probe);
            found.retain(|f| {
                // That nothing was compared does not depend on hidden fields.
                f.code == UNRECORDED
                    || f.pointer.starts_with(pointer::CRITICAL_COMPONENTS)
                    || f.pointer.starts_with(pointer::KEYFRAME_TIMESTAMP)
            });
            found
        }
        Stage::Stage2 => {
            let text = as_submitted(draft).to_string();
            let checker = if is_within(task, draft) { &app.stage2_checker } else { &app.checker };
            let found = checker.check_text_since(&text, drafted_trace(&task.initial));
            let mut found: Vec<Finding> = found.iter().map(finding).collect();
            if matches!(task.at.state, State::Stage1Locked | State::Stage2) {
                found.iter_mut().for_each(|f| replace_frozen_hint(f, task.veiled));
            }
            found
        }
    }
}

/// In Stage II components are locked until the label is returned: a hint that asks to change them states what can be
/// done instead. With `veiled` their uncertainty can still be changed.
fn replace_frozen_hint(f: &mut Finding, veiled: bool) {
    if veiled && f.code == "label.uncertainty.missing" {
        return;
    }
    let (zh, en) = match (f.code.as_str(), f.pointer.as_str()) {
        ("label.trace.unnamed_object", _) => {
            ("从因果描述中删去，或改说已列出的要素", "remove it from the trace, or name a listed component")
        }
        ("label.cause.kind" | "label.cause.no_effect", _) => {
            ("关联另一个要素，或改决策", "link another component, or change the decision")
        }
        ("label.text.class", _) => {
            ("改写因果描述；场景不符时问负责人", "rewrite the trace; ask the lead if the class does not fit")
        }
        ("label.cause.proximate", pointer::DRIVING_DECISION_LONGITUDINAL) => (
            "停在前车之后是“跟车”；自车是头车时，不要关联前车",
            "stopping behind a lead is lead following; where the ego is the first, do not link the lead",
        ),
        (_, at) if at.starts_with(pointer::CRITICAL_COMPONENTS) => {
            ("改决策、关联的原因或因果描述", "change the decision, the linked causes or the trace")
        }
        _ => return,
    };
    let (then_zh, then_en) = if f.severity == "error" {
        (
            "必须改要素时，问负责人，或跳过并写明原因",
            "to change one, ask the lead, or skip the task and state the reason",
        )
    } else {
        (
            "需要改要素时，写意见并提交，退回后可以改",
            "to change one, comment and submit; it can be changed once the label is returned",
        )
    };
    f.hint_zh = Some(format!("{zh}。要素已随阶段一锁定：{then_zh}"));
    f.hint_en = Some(format!("{en}. Components are locked with Stage I: {then_en}"));
}

/// The trace that a rule drafted for the task; a person who has read a model's text may accept it.
fn drafted_trace(initial: &Value) -> Option<&str> {
    let by = initial.get(name::PROVENANCE)?.get(name::SOURCE)?.as_str()?;
    let trace = initial.get(name::COC_TRACE)?.as_str()?;
    (by == "rule" && !trace.is_empty()).then_some(trace)
}

/// The draft in the form of its submission: by a person, and with empty causes if it has none. An imported label may
/// have no causes, as in format 2.0; a label from this service states a cause of each decision, or UNOBSERVED with a
/// reason (LABELING.md 6).
fn as_submitted(draft: &Value) -> Value {
    let mut whole = draft.clone();
    if whole.get(name::CAUSES).is_none_or(Value::is_null) {
        whole[name::CAUSES] = json!({});
    }
    whole[name::PROVENANCE] = json!({ (name::SOURCE): "person" });
    whole
}

/// True when one of them is an error.
pub fn has_error(findings: &[Finding]) -> bool {
    findings.iter().any(|f| f.severity == "error")
}

/// Findings of the checker in any label that may be seen in Stage I of `task`: from the recording only what lies at or
/// before the keyframe.
pub fn in_stage1(app: &App, task: &TaskRow, label: &Value) -> Vec<Finding> {
    let checker = if is_of(task, label) { &app.stage1_checker } else { &app.checker };
    checker.check_text(&label.to_string()).iter().map(finding).collect()
}

/// True for a label of the clip of `task` with a keyframe that is not later than the task's: up to it the recording may
/// be shown.
fn is_of(task: &TaskRow, label: &Value) -> bool {
    keyframe_in(task, label).is_some_and(|k| k <= task.keyframe_ns)
}

/// True for a label of the clip of `task` at a moment that the task shows in Stage II: the recording of another clip or
/// moment may be one whose Stage I the user does.
fn is_within(task: &TaskRow, label: &Value) -> bool {
    keyframe_in(task, label).is_some_and(|k| task.from_ns <= k && k <= task.to_ns)
}

/// The keyframe of `label`, if it is of the clip of `task`.
fn keyframe_in(task: &TaskRow, label: &Value) -> Option<i64> {
    let text = |at: &str| label.pointer(at).and_then(Value::as_str);
    let keyframe = text(pointer::KEYFRAME_TIMESTAMP).and_then(|k| Nanos::parse_iso(k).ok());
    keyframe.filter(|_| text(pointer::CLIP_ID) == Some(task.clip_id.as_str())).map(|k| k.0)
}

/// The visible part of a draft, with neutral values for the hidden fields.
fn probe(draft: &Value, view: LabelView) -> Value {
    let mut label = visible::label(draft, view);
    let moment = |at: &str| label.pointer(at).and_then(Value::as_str).map(str::to_owned);
    let keyframe = moment(pointer::KEYFRAME_TIMESTAMP).unwrap_or_default();
    let at = Nanos::parse_iso(&keyframe).ok();
    // The range is set in Stage II: one that begins after the keyframe is no error yet, and could not be fixed.
    let start = moment(pointer::TIME_RANGE_START_TIMESTAMP)
        .filter(|start| Nanos::parse_iso(start).ok() <= at)
        .unwrap_or_else(|| keyframe.clone());
    let end = at.map(|k| k.plus_secs(1.0).to_string()).unwrap_or_default();
    label[name::TIME_RANGE] = json!({ (name::START_TIMESTAMP): start, (name::END_TIMESTAMP): end });
    label[name::DRIVING_DECISION] = json!({ (name::LONGITUDINAL): null, (name::LATERAL): null });
    label[name::COC_TRACE] = json!("");
    label
}

fn finding(d: &Diagnostic) -> Finding {
    let severity = match d.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Note => "note",
    };
    Finding {
        code: d.code.to_owned(),
        severity: severity.to_owned(),
        message_zh: d.message.zh.clone(),
        message_en: d.message.en.clone(),
        pointer: d.location.pointer.clone().unwrap_or_default(),
        hint_zh: d.hint.as_ref().map(|h| h.zh.clone()),
        hint_en: d.hint.as_ref().map(|h| h.en.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recordings::Recordings;
    use crate::service::fixtures::{self, Counted};
    use crate::store::Store;
    use std::sync::Arc;
    use std::sync::atomic::Ordering;
    use whyroad_framework::Framework;

    fn found(code: &str, severity: &str, pointer: &str) -> Finding {
        Finding {
            code: code.to_owned(),
            severity: severity.to_owned(),
            message_zh: String::new(),
            message_en: String::new(),
            pointer: pointer.to_owned(),
            hint_zh: Some("补上该要素".to_owned()),
            hint_en: Some("add it as a component".to_owned()),
        }
    }

    #[test]
    fn no_hint_of_stage_two_asks_for_a_component_that_cannot_be_added() {
        let hint = |code: &str, severity: &str, pointer: &str, veiled: bool| {
            let mut f = found(code, severity, pointer);
            replace_frozen_hint(&mut f, veiled);
            (f.hint_zh.unwrap(), f.hint_en.unwrap())
        };
        let (zh, en) = hint("label.trace.unnamed_object", "warning", "/coc_trace", false);
        assert!(zh.starts_with("从因果描述中删去") && zh.contains("退回后可以改"), "{zh}");
        assert!(
            en.starts_with("remove it from the trace") && en.contains("once the label is returned"),
            "{en}"
        );
        let (zh, en) = hint("label.object.class", "error", "/critical_components/0/description", false);
        assert!(
            zh.contains("问负责人") && en.contains("ask the lead, or skip"),
            "an error cannot be submitted: {en}"
        );
        // Fields that Stage II can change keep the hint of the rule.
        let kept = ("补上该要素".to_owned(), "add it as a component".to_owned());
        assert_eq!(hint("label.trace.empty", "error", "/coc_trace", false), kept);
        assert_eq!(hint("label.uncertainty.missing", "error", "/critical_components", true), kept);
        assert_ne!(hint("label.uncertainty.missing", "error", "/critical_components", false), kept);
    }

    /// docs/diagnostics/label.clip.unrecorded.md: a label without its drive was not compared, which is not the same as
    /// a label without findings.
    #[test]
    fn a_label_that_could_not_be_compared_says_so_in_both_stages() {
        let recordings = Arc::new(Counted { compares: true, ..Counted::default() });
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(&dir.path().join("s.db")).unwrap();
        let app =
            App::new(store, Framework::bundled(), Arc::clone(&recordings) as Arc<dyn Recordings>).unwrap();
        let label: Value =
            serde_json::from_str(include_str!("../../../../examples/cutin_urgent_example.json")).unwrap();
        let keyframe = label["keyframe"]["timestamp"].as_str().unwrap();
        let keyframe_ns = Nanos::parse_iso(keyframe).unwrap().0;
        let task = TaskRow {
            clip_id: label["clip_id"].as_str().unwrap().to_owned(),
            keyframe_ns,
            from_ns: keyframe_ns - 2_000_000_000,
            to_ns: keyframe_ns + 6_000_000_000,
            ..fixtures::task()
        };
        let missing = |stage| {
            let view = LabelView { stage, hides_leaf: false, hides_drafted: false, in_hand: true };
            let found = of(&app, &task, &label, view);
            let of_code: Vec<_> = found.iter().filter(|f| f.code == UNRECORDED).collect();
            assert!(of_code.iter().all(|f| f.severity == "warning"), "the label can still be saved");
            of_code.len()
        };
        assert_eq!((missing(Stage::Stage1), missing(Stage::Stage2)), (1, 1));
        recordings.recorded.store(true, Ordering::SeqCst);
        assert_eq!((missing(Stage::Stage1), missing(Stage::Stage2)), (0, 0));
    }

    #[test]
    fn only_what_a_rule_wrote_is_drafted() {
        let initial =
            |source: &str| json!({ "coc_trace": "[DRAFT] a; b, so c.", "provenance": { "source": source } });
        assert_eq!(drafted_trace(&initial("rule")), Some("[DRAFT] a; b, so c."));
        for source in ["model", "person"] {
            assert_eq!(drafted_trace(&initial(source)), None, "{source}");
        }
        assert_eq!(drafted_trace(&json!({ "coc_trace": "a; b, so c." })), None, "a label from elsewhere");
    }
}
