//! Changes of labeling specs, inheritance applied, as steps: **major** where an old label may now be wrong or lack a
//! required field (keyframe type, another rule, a new record, `uncertainty: high`, a mandated lateral decision, a
//! second keyframe), **minor** where something optional is added or a requirement is removed, **patch** for wording.

use super::difference::Difference;
use super::wording::{Wording, compare_text};
use super::{Change, ChangeKind, Moves, tables};
use crate::spec::{BoundSpec, KeyframeSpec, MomentSpec, RecordSpec};
use crate::version::Step;
use crate::{Framework, ResolvedSpec};
use std::collections::BTreeMap;
use whyroad_model::{Bilingual, ScenarioId};

/// All changes, leaf by leaf in tree order; changes common to all leaves of an L2 or L1 are reported once for that
/// class.
pub(super) fn changes(a: &Framework, b: &Framework, moves: &Moves) -> Vec<Change> {
    let mut found: BTreeMap<ScenarioId, Vec<Difference>> = BTreeMap::new();
    for (leaf, after) in &b.specs {
        let old = moves.before(leaf);
        if let Some(before) = a.specs.get(old) {
            let mut all = differences(before, after);
            for record in after.records.iter().filter(|r| before.records.iter().any(|o| o.id == r.id)) {
                tables::record(&record.id, &a.record_types, &b.record_types, &mut all);
            }
            let [x, y] = [a.decision_table().leaves.get(old), b.decision_table().leaves.get(leaf)];
            tables::decisions(x, y, &mut all);
            found.insert(leaf.clone(), all);
        }
    }
    let mut out = Vec::new();
    for id in b.taxonomy.ids() {
        let below: Vec<&ScenarioId> = found.keys().filter(|leaf| leaf.is_within(&id)).collect();
        let Some(first) = below.first() else { continue };
        // For a leaf, its changes; for a class above, the common changes of all leaves below it.
        let shared: Vec<Difference> = found[*first]
            .iter()
            .filter(|d| {
                id.is_leaf() || (below.len() > 1 && below.iter().all(|leaf| found[*leaf].contains(d)))
            })
            .cloned()
            .collect();
        for differences in found.iter_mut().filter(|(leaf, _)| leaf.is_within(&id)).map(|(_, d)| d) {
            differences.retain(|d| !shared.contains(d));
        }
        out.extend(shared.into_iter().map(|d| {
            Change::of(ChangeKind::Labelling, id.clone(), d.step).texts(d.field, d.before, d.after)
        }));
    }
    out
}

fn differences(x: &ResolvedSpec, y: &ResolvedSpec) -> Vec<Difference> {
    let mut out = Vec::new();
    keyframe(&x.keyframe, &y.keyframe, &KEYFRAME, &mut out);
    match (&x.second_keyframe, &y.second_keyframe) {
        (Some(x), Some(y)) => keyframe(x, y, &SECOND, &mut out),
        (x, y) => {
            let words = |k: &Option<KeyframeSpec>| k.as_ref().map_or_else(none, |k| k.rule.clone());
            demand("second_keyframe", x.is_some(), y.is_some(), words(x), words(y), &mut out);
        }
    }
    for (x, y, names) in [(&x.start, &y.start, &START), (&x.end, &y.end, &END)] {
        bound(x, y, names, &mut out);
    }
    if (x.pack.before_s, x.pack.after_s) != (y.pack.before_s, y.pack.after_s) {
        let text = |s: &ResolvedSpec| {
            let (before, after) = (s.pack.before_s, s.pack.after_s);
            Bilingual::new(
                format!("前 {before} s，后 {after} s"),
                format!("{before} s before, {after} s after"),
            )
        };
        out.push(Difference { field: "pack", before: text(x), after: text(y), step: Step::Minor });
    }
    if x.pack.after_until != y.pack.after_until {
        let (before, after) = (moment(x.pack.after_until.as_ref()), moment(y.pack.after_until.as_ref()));
        out.push(Difference { field: "pack.after_until", before, after, step: Step::Minor });
    }
    records(&x.records, &y.records, &mut out);
    let high = |s: &ResolvedSpec| if s.uncertainty_high { Bilingual::same("high") } else { none() };
    demand("uncertainty", x.uncertainty_high, y.uncertainty_high, high(x), high(y), &mut out);
    if x.lateral != y.lateral {
        let text = |s: &ResolvedSpec| s.lateral.map_or_else(none, |l| Bilingual::same(l.id()));
        let step = if y.lateral.is_some() { Step::Major } else { Step::Minor };
        out.push(Difference { field: "lateral", before: text(x), after: text(y), step });
    }
    out
}

/// Names of a moment's fields in the file.
struct Names {
    kind: &'static str,
    rule: &'static str,
    expr: &'static str,
    fallback: &'static str,
}

const KEYFRAME: Names = Names {
    kind: "keyframe.type",
    rule: "keyframe.rule",
    expr: "keyframe.expr",
    fallback: "keyframe.fallback",
};
const SECOND: Names = Names {
    kind: "second_keyframe.type",
    rule: "second_keyframe.rule",
    expr: "second_keyframe.expr",
    fallback: "second_keyframe.fallback",
};
const START: Names =
    Names { kind: "start", rule: "start.rule", expr: "start.expr", fallback: "start.fallback" };
const END: Names = Names { kind: "end", rule: "end.rule", expr: "end.expr", fallback: "end.fallback" };

fn keyframe(x: &KeyframeSpec, y: &KeyframeSpec, names: &Names, out: &mut Vec<Difference>) {
    if x.kind != y.kind {
        let (before, after) = (Bilingual::same(x.kind.id()), Bilingual::same(y.kind.id()));
        out.push(Difference { field: names.kind, before, after, step: Step::Major });
    }
    let bounds = |k: &KeyframeSpec| BoundSpec {
        rule: k.rule.clone(),
        expr: k.expr.clone(),
        fallback: k.fallback.clone(),
    };
    bound(&bounds(x), &bounds(y), names, out);
}

fn bound(x: &BoundSpec, y: &BoundSpec, names: &Names, out: &mut Vec<Difference>) {
    words(names.rule, &x.rule, &y.rule, out);
    if x.expr != y.expr {
        // An expression formalizes the rule: a changed one makes mining propose other moments, but labels stay valid.
        let step = if x.expr.is_none() { Step::Minor } else { Step::Patch };
        let text = |e: &Option<String>| e.as_ref().map_or_else(none, |e| Bilingual::same(e.as_str()));
        out.push(Difference { field: names.expr, before: text(&x.expr), after: text(&y.expr), step });
    }
    match (&x.fallback, &y.fallback) {
        (Some(a), Some(b)) if compare_text(&a.rule, &b.rule) != Wording::Same => {
            words(names.fallback, &a.rule, &b.rule, out);
        }
        (a, b) if a != b => {
            let step = match (a, b) {
                (None, _) => Step::Minor,
                // Labels were placed according to it.
                (Some(_), None) => Step::Major,
                (Some(_), Some(_)) => Step::Patch,
            };
            let (before, after) = (moment(a.as_ref()), moment(b.as_ref()));
            out.push(Difference { field: names.fallback, before, after, step });
        }
        _ => {}
    }
}

fn words(field: &'static str, x: &Bilingual, y: &Bilingual, out: &mut Vec<Difference>) {
    let step = match compare_text(x, y) {
        Wording::Same => return,
        Wording::Reworded => Step::Patch,
        Wording::Meaning => Step::Major,
    };
    out.push(Difference { field, before: x.clone(), after: y.clone(), step });
}

/// A field that a label must have, or is no longer required.
fn demand(
    field: &'static str,
    was: bool,
    is: bool,
    before: Bilingual,
    after: Bilingual,
    out: &mut Vec<Difference>,
) {
    if was != is {
        out.push(Difference { field, before, after, step: if is { Step::Major } else { Step::Minor } });
    }
}

fn records(x: &[RecordSpec], y: &[RecordSpec], out: &mut Vec<Difference>) {
    let find = |all: &[RecordSpec], id: &str| all.iter().find(|r| r.id == id).cloned();
    for r in y {
        let Some(old) = find(x, &r.id) else {
            out.push(Difference { field: "records", before: none(), after: record(r), step: Step::Major });
            continue;
        };
        // A changed unit changes the meaning of recorded numbers.
        let step = match compare_text(&old.name, &r.name) {
            _ if old.unit != r.unit || choice_ids(&old) != choice_ids(r) => Step::Major,
            Wording::Same => continue,
            Wording::Reworded => Step::Patch,
            Wording::Meaning => Step::Major,
        };
        out.push(Difference { field: "records", before: record(&old), after: record(r), step });
    }
    for r in x.iter().filter(|r| find(y, &r.id).is_none()) {
        out.push(Difference { field: "records", before: record(r), after: none(), step: Step::Minor });
    }
}

fn choice_ids(r: &RecordSpec) -> Vec<&str> {
    r.choices.iter().map(|c| c.id.as_str()).collect()
}

fn record(r: &RecordSpec) -> Bilingual {
    let unit = r.unit.as_ref().map(|u| format!(" ({u})")).unwrap_or_default();
    Bilingual::new(format!("{}：{}{unit}", r.id, r.name.zh), format!("{}: {}{unit}", r.id, r.name.en))
}

fn moment(m: Option<&MomentSpec>) -> Bilingual {
    let Some(m) = m else { return none() };
    let expr = m.expr.as_ref().map(|e| format!(" [{e}]")).unwrap_or_default();
    Bilingual::new(format!("{}{expr}", m.rule.zh), format!("{}{expr}", m.rule.en))
}

fn none() -> Bilingual {
    Bilingual::new("无", "none")
}
