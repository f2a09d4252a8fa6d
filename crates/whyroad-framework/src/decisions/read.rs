//! `schema/driving_decisions.yaml` to [`DecisionSets`], checked against the closed sets that messages use.

use super::{DecisionSets, DecisionText, LateralText, LongitudinalText};
use crate::taxonomy::{FAMILY, another_id, optional_bilingual, read_bilingual, read_version, suggestion};
use crate::yaml_text;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::yaml::{Fields, FileReport, Node};
use whyroad_model::{Bilingual, Diagnostic};

/// Reads the decisions. Unreadable entries are left out and reported.
pub fn read_decisions(file: &str, text: &str) -> (DecisionSets, Vec<Diagnostic>) {
    let mut report = FileReport::new(file, text, &FAMILY);
    let sets =
        yaml_text::parse(&mut report, text).and_then(|root| document(&root, &mut report)).unwrap_or_default();
    (sets, report.diagnostics)
}

fn document(root: &Node, r: &mut FileReport) -> Option<DecisionSets> {
    let mut f = Fields::open(root, r)?;
    let version = read_version(&mut f, "taxonomy.version", r);
    let null_decision = f.need("null_decision", r).and_then(|n| {
        let mut g = Fields::open(n, r)?;
        let text = read_text(&mut g, r);
        g.close(r);
        text
    });
    let longitudinal_node = f.need("longitudinal", r);
    let lateral_node = f.need("lateral", r);
    f.close(r);

    let mut sets =
        DecisionSets { version, null_decision: null_decision.unwrap_or_default(), ..DecisionSets::default() };
    for node in longitudinal_node.map_or(&[][..], |n| r.items(n)) {
        let Some(mut g) = Fields::open(node, r) else { continue };
        let id = member(&mut g, Longitudinal::from_id, Longitudinal::ALL.iter().map(|d| d.id()), r);
        let text = read_text(&mut g, r);
        g.close(r);
        let (Some(id), Some(text)) = (id, text) else { continue };
        if sets.longitudinal(id).is_some() {
            twice(node, id.id(), r);
        } else {
            sets.longitudinal.push(LongitudinalText { id, text });
        }
    }
    for node in lateral_node.map_or(&[][..], |n| r.items(n)) {
        let Some(mut g) = Fields::open(node, r) else { continue };
        let id = member(&mut g, Lateral::from_id, Lateral::ALL.iter().map(|d| d.id()), r);
        let text = read_text(&mut g, r);
        let directions = directions(&mut g, r);
        g.close(r);
        let (Some(id), Some(text)) = (id, text) else { continue };
        if directions != id.directions() {
            differs(
                node,
                format!("'{id}' 的方向与 LABELING.md 2 不一致"),
                format!("the directions of '{id}' are not those of LABELING.md 2"),
                r,
            );
        }
        if sets.lateral(id).is_some() {
            twice(node, id.id(), r);
        } else {
            sets.lateral.push(LateralText { id, text, directions });
        }
    }
    let missing_longitudinal =
        Longitudinal::ALL.iter().filter(|d| sets.longitudinal(**d).is_none()).map(|d| d.id());
    let missing_lateral = Lateral::ALL.iter().filter(|d| sets.lateral(**d).is_none()).map(|d| d.id());
    for id in missing_longitudinal.chain(missing_lateral) {
        differs(root, format!("缺少决策 '{id}'"), format!("decision '{id}' is missing"), r);
    }
    Some(sets)
}

fn read_text(f: &mut Fields, r: &mut FileReport) -> Option<DecisionText> {
    let name = read_bilingual(f, "name_zh", "name_en", r);
    let meaning = read_bilingual(f, "meaning_zh", "meaning_en", r);
    let not = optional_bilingual(f, "not_zh", "not_en", r);
    let ar1 = f.text_opt("ar1", r);
    Some(DecisionText { name: name?, meaning: meaning?, not, ar1 })
}

fn directions(f: &mut Fields, r: &mut FileReport) -> Vec<LateralDirection> {
    let mut out = Vec::new();
    for node in f.need("directions", r).map_or(&[][..], |n| r.items(n)) {
        let Some(text) = r.text(node) else { continue };
        match LateralDirection::from_id(&text) {
            Some(d) => out.push(d),
            None => {
                differs(node, format!("方向 '{text}' 不存在"), format!("direction '{text}' not found"), r)
            }
        }
    }
    out
}

fn member<T>(
    f: &mut Fields,
    from_id: fn(&str) -> Option<T>,
    all: impl Iterator<Item = &'static str>,
    r: &mut FileReport,
) -> Option<T> {
    let node = f.need("id", r)?;
    let text = r.text(node)?;
    let found = from_id(&text);
    if found.is_none() {
        let message = Bilingual::new(
            format!("'{text}' 不在驾驶决策闭集中"),
            format!("'{text}' is not a member of the closed set of decisions"),
        );
        let mut d = Diagnostic::error("taxonomy.decisions.set", message);
        if let Some(near) = crate::taxonomy::did_you_mean(&text, all) {
            d = d.with_hint(suggestion(near));
        }
        r.push(d, node.mark, &node.pointer);
    }
    found
}

fn twice(node: &Node, id: &str, r: &mut FileReport) {
    let message = Bilingual::new(format!("id '{id}' 重复"), format!("id '{id}' is used twice"));
    r.error_with_hint("taxonomy.id.duplicate", node, message, another_id());
}

fn differs(node: &Node, zh: String, en: String, r: &mut FileReport) {
    r.error("taxonomy.decisions.set", node, zh, en);
}
