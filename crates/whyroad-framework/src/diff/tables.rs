//! Changes of the tables by which labels are checked: decisions of each class and causes (`scenarios/decisions.yaml`),
//! types of records (`scenarios/records.yaml`), and the decisions themselves (`schema/driving_decisions.yaml`).
//! **Major** where something that was allowed no longer is or means something else, **minor** where more is allowed,
//! **patch** for wording.

use super::difference::Difference;
use super::wording::{Wording, compare_text};
use super::{Change, ChangeKind};
use crate::Framework;
use crate::decision_table::{ClassDecisions, DecisionTable, Fit};
use crate::decisions::{DecisionSets, DecisionText};
use crate::record_types::{RecordType, RecordTypes};
use crate::version::Step;
use std::collections::BTreeSet;
use whyroad_model::decision::LateralDirection;
use whyroad_model::{Bilingual, ScenarioId};

/// Fields of the decisions of a class.
pub(super) const LONGITUDINAL: &str = "decisions.longitudinal";
pub(super) const LATERAL: &str = "decisions.lateral";
pub(super) const DECIDES: &str = "decisions.decides";
pub(super) const ABOUT: &str = "decisions.about";
/// Field of the type of a record.
pub(super) const RECORD_TYPE: &str = "records.type";
/// Fields of a decision that `scenarios/decisions.yaml` states.
pub(super) const CAUSES: &str = "causes";
pub(super) const PAIRS: &str = "impossible_pairs";

/// Identifier for "no change of decision".
const NONE: &str = "none";

/// The decisions of one class, in the two tables.
pub(super) fn decisions(x: Option<&ClassDecisions>, y: Option<&ClassDecisions>, out: &mut Vec<Difference>) {
    let (Some(x), Some(y)) = (x, y) else { return };
    let along = |c: &ClassDecisions| -> Vec<(String, Fit)> {
        c.longitudinal.iter().map(|(d, fit)| (d.map_or(NONE, |d| d.id()).to_owned(), *fit)).collect()
    };
    let across = |c: &ClassDecisions| -> Vec<(String, Fit)> {
        let name = |lateral: Option<&str>, direction: Option<LateralDirection>| {
            let lateral = lateral.unwrap_or(NONE);
            direction.map_or_else(|| lateral.to_owned(), |d| format!("{lateral}/{}", d.id()))
        };
        c.lateral.iter().map(|(e, fit)| (name(e.lateral.map(|l| l.id()), e.direction), *fit)).collect()
    };
    channel(LONGITUDINAL, &along(x), &along(y), out);
    channel(LATERAL, &across(x), &across(y), out);
    if x.decides != y.decides {
        let step = if y.decides { Step::Major } else { Step::Minor };
        let [before, after] = [x, y].map(|c| Bilingual::same(c.decides.to_string()));
        out.push(Difference { field: DECIDES, before, after, step });
    }
    let about = |c: &ClassDecisions| c.about_names.iter().cloned().collect::<BTreeSet<String>>();
    if about(x) != about(y) {
        // Of several things one is enough; of none, nothing is required.
        let is_wider = about(y).is_empty() || (!about(x).is_empty() && about(x).is_subset(&about(y)));
        let step = if is_wider { Step::Minor } else { Step::Major };
        let [before, after] = [x, y].map(|c| listed(c.about_names.iter().map(String::as_str)));
        out.push(Difference { field: ABOUT, before, after, step });
    }
}

fn channel(field: &'static str, x: &[(String, Fit)], y: &[(String, Fit)], out: &mut Vec<Difference>) {
    let sorted = |all: &[(String, Fit)]| all.iter().cloned().collect::<BTreeSet<_>>();
    if sorted(x) == sorted(y) {
        return;
    }
    // `turn` allows `turn/left`.
    let allows = |all: &[(String, Fit)], id: &str| {
        all.iter().any(|(d, _)| d == id || id.split_once('/').is_some_and(|(of, _)| d == of))
    };
    let is_narrower = x.iter().any(|(id, _)| !allows(y, id));
    let step = if is_narrower { Step::Major } else { Step::Minor };
    let text = |all: &[(String, Fit)]| {
        let of = |fit| {
            let ids: Vec<&str> = all.iter().filter(|(_, f)| *f == fit).map(|(id, _)| id.as_str()).collect();
            if ids.is_empty() { "-".to_owned() } else { ids.join(", ") }
        };
        let (usual, possible) = (of(Fit::Usual), of(Fit::Possible));
        Bilingual::new(
            format!("通常 {usual}；可能 {possible}"),
            format!("usual {usual}; possible {possible}"),
        )
    };
    out.push(Difference { field, before: text(x), after: text(y), step });
}

/// The types of a record that both specs require.
pub(super) fn record(id: &str, x: &RecordTypes, y: &RecordTypes, out: &mut Vec<Difference>) {
    let (Some(x), Some(y)) = (x.records.get(id), y.records.get(id)) else { return };
    if x == y {
        return;
    }
    let step = match (x, y) {
        (RecordType::Number { min, max }, RecordType::Number { min: low, max: high }) => {
            if low <= min && high >= max { Step::Minor } else { Step::Major }
        }
        (RecordType::Flag { .. }, RecordType::Flag { .. }) => Step::Patch,
        (
            RecordType::Choice { values, or_text, text_words },
            RecordType::Choice { values: after, or_text: after_text, text_words: least },
        ) => {
            let ids = |all: &[crate::record_types::ChoiceValue]| {
                all.iter().map(|v| v.id.clone()).collect::<BTreeSet<_>>()
            };
            let takes_text = !or_text || (*after_text && least <= text_words);
            match (ids(values), ids(after)) {
                (x, y) if x == y && or_text == after_text && text_words == least => Step::Patch,
                (x, y) if x.is_subset(&y) && takes_text => Step::Minor,
                _ => Step::Major,
            }
        }
        _ => Step::Major,
    };
    let text = |kind: &RecordType| {
        let kind = match kind {
            RecordType::Number { min, max } => format!("number {min}..{max}"),
            RecordType::Flag { .. } => "flag".to_owned(),
            RecordType::Choice { values, or_text, .. } => {
                let ids: Vec<&str> = values.iter().map(|v| v.id.as_str()).collect();
                format!("choice {}{}", ids.join(", "), if *or_text { ", text" } else { "" })
            }
            RecordType::Text => "text".to_owned(),
        };
        Bilingual::same(format!("{id}: {kind}"))
    };
    out.push(Difference { field: RECORD_TYPE, before: text(x), after: text(y), step });
}

/// Decisions whose texts, directions, causes or combinations changed. The id of such a change is that of the decision.
pub(super) fn changes(a: &Framework, b: &Framework) -> Vec<Change> {
    let mut out = Vec::new();
    texts(&a.decisions, &b.decisions, &mut out);
    table(a.decision_table(), b.decision_table(), &mut out);
    out
}

fn change(decision: &str, field: &'static str, before: Bilingual, after: Bilingual, step: Step) -> Change {
    let id = ScenarioId { l1: decision.to_owned(), l2: None, l3: None };
    Change::of(ChangeKind::Decision, id, step).texts(field, before, after)
}

fn texts(x: &DecisionSets, y: &DecisionSets, out: &mut Vec<Change>) {
    text(NONE, &x.null_decision, &y.null_decision, out);
    for d in &y.longitudinal {
        if let Some(old) = x.longitudinal(d.id) {
            text(d.id.id(), old, &d.text, out);
        }
    }
    for d in &y.lateral {
        let Some(old) = x.lateral.iter().find(|o| o.id == d.id) else { continue };
        text(d.id.id(), &old.text, &d.text, out);
        if old.directions != d.directions {
            let is_narrower = old.directions.iter().any(|side| !d.directions.contains(side));
            // A decision without directions must have none.
            let step = if is_narrower || old.directions.is_empty() { Step::Major } else { Step::Minor };
            let [before, after] = [old, d].map(|d| listed(d.directions.iter().map(|side| side.id())));
            out.push(change(d.id.id(), "directions", before, after, step));
        }
    }
}

fn text(id: &str, x: &DecisionText, y: &DecisionText, out: &mut Vec<Change>) {
    let nothing = Bilingual::default();
    let parts = [
        ("name", &x.name, &y.name, Step::Patch),
        ("meaning", &x.meaning, &y.meaning, Step::Major),
        ("not", x.not.as_ref().unwrap_or(&nothing), y.not.as_ref().unwrap_or(&nothing), Step::Major),
    ];
    for (field, before, after, most) in parts {
        let step = match compare_text(before, after) {
            _ if before == after => continue,
            // A text that one side lacks is not compared: what tells decisions apart was added or taken away.
            Wording::Same if before.en.is_empty() || after.en.is_empty() => Step::Minor,
            Wording::Same => continue,
            Wording::Reworded => Step::Patch,
            Wording::Meaning => most,
        };
        out.push(change(id, field, before.clone(), after.clone(), step));
    }
}

fn table(x: &DecisionTable, y: &DecisionTable, out: &mut Vec<Change>) {
    let (before, after) = (x.causes.written(), y.causes.written());
    for (decision, kinds) in after {
        let Some(old) = before.get(decision) else { continue };
        let set = |all: &[String]| all.iter().cloned().collect::<BTreeSet<_>>();
        if set(old) != set(kinds) {
            let is_wider = set(old).is_subset(&set(kinds)) || kinds.iter().any(|k| k == "anything");
            let step = if is_wider { Step::Minor } else { Step::Major };
            let [old, new] = [old, kinds].map(|all| listed(all.iter().map(String::as_str)));
            out.push(change(decision, CAUSES, old, new, step));
        }
    }
    for (pair, old, new, step) in x
        .impossible_pairs
        .iter()
        .filter(|p| !y.impossible_pairs.contains(p))
        .map(|p| (p, impossible(), possible(), Step::Minor))
        .chain(
            y.impossible_pairs
                .iter()
                .filter(|p| !x.impossible_pairs.contains(p))
                .map(|p| (p, possible(), impossible(), Step::Major)),
        )
    {
        let with = |text: Bilingual| {
            let other = pair.1.id();
            Bilingual::new(format!("与 {other}：{}", text.zh), format!("with {other}: {}", text.en))
        };
        out.push(change(pair.0.id(), PAIRS, with(old), with(new), step));
    }
}

fn possible() -> Bilingual {
    Bilingual::new("可以组合", "may be combined")
}

fn impossible() -> Bilingual {
    Bilingual::new("不能组合", "cannot be combined")
}

fn listed<'a>(ids: impl Iterator<Item = &'a str>) -> Bilingual {
    let ids: Vec<&str> = ids.collect();
    if ids.is_empty() { Bilingual::new("无", "none") } else { Bilingual::same(ids.join(", ")) }
}
