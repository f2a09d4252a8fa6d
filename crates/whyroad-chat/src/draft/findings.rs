//! Findings of the label checks on an answer that the call which gave it can fix.

use crate::language;
use std::fmt::Write as _;
use whyroad_label::check::Checker;
use whyroad_model::messages::{CocLabel, DrivingDecision};
use whyroad_model::{Diagnostic, Lang, Severity};

const COMPONENTS: &str = "/critical_components";
/// Findings of the first call: of the texts alone. Others reveal the class or later events, which the first call must
/// not learn.
const HISTORY_CODES: [&str; 3] =
    ["label.text.hindsight", "label.text.placeholder", "label.component.duplicate"];
/// Findings that the second call cannot fix: they concern mining results, or fields for a person to fill in.
const NOT_OF_THE_MODEL: [&str; 10] = [
    "label.record.",
    "label.keyframe.",
    "label.second_keyframe.",
    "label.time_range.",
    "label.frame.",
    "label.clip.",
    "label.class.",
    "label.secondary.",
    "label.version",
    "label.uncertainty.missing",
];

/// Of the components. The rest of the label and the recording are not used.
pub(super) fn of_history(checker: &Checker<'_>, label: &CocLabel, lang: Lang) -> Vec<Diagnostic> {
    let mut bare = label.clone();
    bare.driving_decision = DrivingDecision { longitudinal: None, lateral: None, lateral_direction: None };
    bare.causes = None;
    let mut found = check(checker, &bare);
    found.retain(|d| HISTORY_CODES.contains(&d.code) && is_of_components(d));
    let texts = label.critical_components.iter().enumerate();
    found.extend(language::findings(
        texts.map(|(i, c)| (format!("{COMPONENTS}/{i}/description"), c.description.as_str())),
        lang,
    ));
    found
}

/// Of decision, causes and trace, against the recording too.
pub(super) fn of_future(checker: &Checker<'_>, label: &CocLabel, lang: Lang) -> Vec<Diagnostic> {
    let mut found = check(checker, label);
    found.retain(|d| {
        d.severity != Severity::Note
            && !is_of_components(d)
            && !NOT_OF_THE_MODEL.iter().any(|code| d.code.starts_with(code))
    });
    found.extend(language::findings([("/coc_trace".to_owned(), label.coc_trace.as_str())].into_iter(), lang));
    found
}

fn check(checker: &Checker<'_>, label: &CocLabel) -> Vec<Diagnostic> {
    serde_json::to_string(label).map(|text| checker.check_text(&text)).unwrap_or_default()
}

fn is_of_components(d: &Diagnostic) -> bool {
    d.location.pointer.as_deref().is_some_and(|p| p.starts_with(COMPONENTS))
}

pub(super) fn errors(found: Vec<Diagnostic>) -> Vec<Diagnostic> {
    found.into_iter().filter(|d| d.severity == Severity::Error).collect()
}

/// One line per finding, for the model.
pub(super) fn list(found: &[Diagnostic], lang: Lang) -> String {
    let mut out = String::new();
    for d in found {
        let at = d.location.pointer.as_deref().unwrap_or_default();
        let hint = d.hint.as_ref().map(|h| format!(" {}", h.get(lang))).unwrap_or_default();
        let _ = writeln!(out, "- {at}: {}{hint}", d.message(lang));
    }
    out
}
