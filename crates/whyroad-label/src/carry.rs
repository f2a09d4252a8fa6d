//! Updates a label when classes are renamed, merged or split ([`ClassMapping`]). What the label itself does not
//! determine is left to a person, and never guessed.

use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use whyroad_framework::mapping::{ClassChange, ClassMapping, SplitPart};
use whyroad_model::ScenarioId;
use whyroad_model::label_fields::{name, pointer};

/// How the class of a label changes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Carried {
    /// None of its classes changes, or the mapping was applied to it before.
    Same,
    /// Its class stays; secondary classes have new ids, or are left out because they are listed already.
    Secondary {
        /// Its class.
        class: ScenarioId,
    },
    /// Its class has a new id.
    Moved {
        /// Class before.
        from: ScenarioId,
        /// Class after.
        to: ScenarioId,
    },
    /// The class is split, and the label meets the conditions of none or several of the parts; or the new class
    /// requires a record that the label does not have, and is then the only part.
    Undecided {
        /// Class before.
        from: ScenarioId,
        /// Class after: the common L2 of the parts, else the class before.
        to: ScenarioId,
        /// The parts to choose from.
        parts: Vec<ScenarioId>,
    },
}

/// Name of the mapping's mark in the versions of a label's provenance.
const MARK: &str = "class_mapping";

/// Applies the mapping to the label, in place: class, secondary classes, versions in its provenance.
pub fn carry(mapping: &ClassMapping, label: &mut Value) -> Carried {
    let versions = format!("{}/versions", pointer::PROVENANCE);
    if label.pointer(&versions).and_then(|v| v[MARK].as_str()) == Some(&mapping.mark) {
        return Carried::Same;
    }
    let Some(from) = class_of(label) else { return Carried::Same };
    let mut undecided = None;
    let to = match mapping.change(&from) {
        None => from.clone(),
        Some(ClassChange::To(to)) => to,
        Some(ClassChange::Split(parts)) => match decide(&parts, label) {
            Some(to) => to,
            None => {
                let parts: Vec<ScenarioId> = parts.into_iter().map(|p| p.to).collect();
                let common = common(&parts).unwrap_or_else(|| from.clone());
                undecided = Some(parts);
                common
            }
        },
    };
    if to != from && undecided.is_none() && lacks_records(mapping, label, &to) {
        undecided = Some(vec![to.clone()]);
    }
    let secondary = secondary(mapping, label, &mut undecided);
    if secondary || to != from {
        listed_once(label, &to);
    }
    if to == from && !secondary && undecided.is_none() {
        return Carried::Same;
    }
    put_class(label, &to);
    if let Some(stated) = label.pointer_mut(pointer::PROVENANCE).and_then(Value::as_object_mut) {
        let stated = stated.entry("versions").or_insert_with(|| json!({}));
        stated["taxonomy"] = json!(mapping.to);
        stated[MARK] = json!(mapping.mark);
    }
    match undecided {
        Some(parts) => Carried::Undecided { from, to, parts },
        None if from == to => Carried::Secondary { class: to },
        None => Carried::Moved { from, to },
    }
}

/// True when a label that states a decision lacks a record that `class` requires.
fn lacks_records(mapping: &ClassMapping, label: &Value, class: &ScenarioId) -> bool {
    let filled = label.pointer(pointer::RECORDS);
    label.pointer(pointer::DRIVING_DECISION).is_some()
        && mapping
            .records
            .get(class)
            .is_some_and(|ids| ids.iter().any(|id| filled.is_none_or(|f| f[id].is_null())))
}

/// The class of a label, if it is a valid id.
pub fn class_of(label: &Value) -> Option<ScenarioId> {
    let part = |p: &str| label.pointer(&format!("{}/{p}", pointer::SCENARIO)).and_then(Value::as_str);
    Some(ScenarioId {
        l1: part("l1")?.to_owned(),
        l2: Some(part("l2")?.to_owned()),
        l3: part("l3").map(str::to_owned),
    })
}

fn put_class(label: &mut Value, id: &ScenarioId) {
    let Some(scenario) = label.pointer_mut(pointer::SCENARIO).and_then(Value::as_object_mut) else { return };
    scenario.insert("l1".into(), json!(id.l1));
    scenario.insert("l2".into(), json!(id.l2));
    if id.l3.is_some() || scenario.contains_key("l3") {
        scenario.insert("l3".into(), json!(id.l3));
    }
    if scenario.contains_key("full_id") {
        // The full id is that of an L3 class.
        match &id.l3 {
            Some(_) => drop(scenario.insert("full_id".into(), json!(id.to_string()))),
            None => drop(scenario.remove("full_id")),
        }
    }
}

/// Renames secondary classes; true when one changed. A person decides about one that is split.
fn secondary(mapping: &ClassMapping, label: &mut Value, undecided: &mut Option<Vec<ScenarioId>>) -> bool {
    let list = label.get_mut(name::SECONDARY_SCENARIOS).and_then(Value::as_array_mut);
    let mut changed = false;
    for item in list.into_iter().flatten() {
        let Some(id) = item.as_str().and_then(|t| t.parse::<ScenarioId>().ok()) else { continue };
        match mapping.change(&id) {
            Some(ClassChange::To(to)) => {
                *item = json!(to.to_string());
                changed = true;
            }
            Some(ClassChange::Split(parts)) if !parts.iter().any(|p| p.to == id) => {
                undecided.get_or_insert_default().extend(parts.into_iter().map(|p| p.to));
            }
            _ => {}
        }
    }
    changed
}

/// Leaves out the secondary classes that a merge has made one with `class`, that of the label, or with each other.
fn listed_once(label: &mut Value, class: &ScenarioId) {
    let list = label.get_mut(name::SECONDARY_SCENARIOS).and_then(Value::as_array_mut);
    let mut seen = BTreeSet::from([class.to_string()]);
    if let Some(list) = list {
        list.retain(|item| item.as_str().is_none_or(|text| seen.insert(text.to_owned())));
    }
}

/// The only part whose conditions the label meets; a part without conditions is never chosen.
fn decide(parts: &[SplitPart], label: &Value) -> Option<ScenarioId> {
    let fits = |p: &&SplitPart| !p.when.is_empty() && holds(&p.when, label);
    let mut fitting = parts.iter().filter(fits);
    let first = fitting.next()?;
    fitting.next().is_none().then(|| first.to.clone())
}

fn holds(when: &BTreeMap<String, Vec<Option<String>>>, label: &Value) -> bool {
    when.iter().all(|(pointer, values)| {
        let found = match label.pointer(pointer) {
            None | Some(Value::Null) => None,
            Some(Value::String(text)) => Some(text.clone()),
            Some(other) => Some(other.to_string()),
        };
        values.contains(&found)
    })
}

/// The L2 class that contains all parts.
fn common(parts: &[ScenarioId]) -> Option<ScenarioId> {
    let first = ScenarioId { l3: None, ..parts.first()?.clone() };
    parts.iter().all(|p| p.is_within(&first)).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id(text: &str) -> ScenarioId {
        text.parse().unwrap()
    }

    fn mapping() -> ClassMapping {
        let part = |to: &str, values: &[&str]| SplitPart {
            to: id(to),
            when: match values {
                [] => BTreeMap::new(),
                _ => [(
                    "/driving_decision/longitudinal".to_owned(),
                    values.iter().map(|v| Some((*v).to_owned())).collect(),
                )]
                .into(),
            },
        };
        ClassMapping {
            from: "1.0.0".into(),
            to: "2.0.0".into(),
            changes: [
                (id("a.b.c"), ClassChange::To(id("a.b.x"))),
                (
                    id("a.b.d"),
                    ClassChange::Split(vec![
                        part("a.b.d1", &["yield_to_agent"]),
                        part("a.b.d2", &["resume"]),
                        part("a.b.d3", &[]),
                    ]),
                ),
            ]
            .into(),
            mark: "0123456789abcdef".into(),
            records: [(id("a.b.x"), vec!["grade".to_owned()])].into(),
        }
    }

    fn label(l3: &str, longitudinal: &str) -> Value {
        json!({
            "scenario": {"l1": "a", "l2": "b", "l3": l3, "full_id": format!("a.b.{l3}")},
            "records": {"grade": 4.0},
            "driving_decision": {"longitudinal": longitudinal, "lateral": null},
            "secondary_scenarios": ["a.b.c", "a.z.z"],
            "provenance": {"source": "person", "versions": {"taxonomy": "1.0.0"}},
        })
    }

    #[test]
    fn a_renamed_class_is_carried_along_once() {
        let mut one = label("c", "resume");
        assert_eq!(carry(&mapping(), &mut one), Carried::Moved { from: id("a.b.c"), to: id("a.b.x") });
        assert_eq!(one["scenario"], json!({"l1": "a", "l2": "b", "l3": "x", "full_id": "a.b.x"}));
        // The other one is the primary now.
        assert_eq!(one["secondary_scenarios"], json!(["a.z.z"]));
        assert_eq!(one["provenance"]["versions"]["taxonomy"], "2.0.0");
        let before = one.clone();
        assert_eq!(carry(&mapping(), &mut one), Carried::Same);
        assert_eq!(one, before, "doing it again changes nothing");
    }

    #[test]
    fn what_a_merge_makes_one_is_listed_once() {
        let merged = || ClassMapping {
            changes: ["a.b.c", "a.b.d"].map(|of| (id(of), ClassChange::To(id("a.b")))).into(),
            records: BTreeMap::new(),
            ..mapping()
        };
        let with = |l3: &str, secondary: &[&str]| {
            let mut one = label(l3, "resume");
            one["secondary_scenarios"] = json!(secondary);
            one
        };
        // Two secondary classes become one; the class itself does not change.
        let mut other = with("q", &["a.b.c", "a.z.z", "a.b.d"]);
        assert_eq!(carry(&merged(), &mut other), Carried::Secondary { class: id("a.b.q") });
        assert_eq!(other["secondary_scenarios"], json!(["a.b", "a.z.z"]));
        // The class and a secondary one become one: it is not secondary to itself, changed or not.
        for secondary in ["a.b.d", "a.b"] {
            let mut one = with("c", &[secondary, "a.z.z"]);
            assert_eq!(carry(&merged(), &mut one), Carried::Moved { from: id("a.b.c"), to: id("a.b") });
            assert_eq!(one["secondary_scenarios"], json!(["a.z.z"]), "{secondary}");
        }
    }

    #[test]
    fn a_split_is_decided_by_the_label_or_by_a_person() {
        let mut decided = label("d", "resume");
        assert_eq!(carry(&mapping(), &mut decided), Carried::Moved { from: id("a.b.d"), to: id("a.b.d2") });
        let mut open = label("d", "lead_following");
        let Carried::Undecided { to, parts, .. } = carry(&mapping(), &mut open) else { panic!() };
        assert_eq!((to, parts.len()), (id("a.b"), 3));
        // The L2 is known, the variant is not: neither the first nor the last part may be chosen.
        assert_eq!(open["scenario"], json!({"l1": "a", "l2": "b", "l3": null}));
    }

    #[test]
    fn a_record_that_the_class_after_requires_is_for_a_person() {
        let mut lacking = label("c", "resume");
        lacking["records"] = json!({});
        let Carried::Undecided { to, parts, .. } = carry(&mapping(), &mut lacking) else { panic!() };
        assert_eq!((&to, parts), (&id("a.b.x"), vec![id("a.b.x")]));
        assert_eq!(lacking["scenario"]["l3"], "x");
    }

    #[test]
    fn other_labels_stay_as_they_are() {
        let mut other = label("q", "resume");
        other["secondary_scenarios"] = json!(["a.z.z"]);
        let before = other.clone();
        assert_eq!(carry(&mapping(), &mut other), Carried::Same);
        assert_eq!(other, before);
        assert_eq!(carry(&mapping(), &mut json!({"scenario": 3})), Carried::Same);
    }
}
