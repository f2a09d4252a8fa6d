//! `diff_frameworks`: which changes of labeling specs and mining rules call for which step. The steps are those of
//! docs/how-to/edit-the-framework.md "Which version", after DATA_FORMAT.md 1.3 of the specification: what makes an
//! old label invalid is major, what only adds is minor.

use whyroad_framework::Framework;
use whyroad_framework::diff::{ChangeKind, TaxonomyDiff, VersionCheck, diff_frameworks};
use whyroad_model::ScenarioId;

const CUTIN: &str = "scenarios/reactive_agent/cutin.yaml";
const RULE: &str = "scenarios/reactive_rule.yaml";

fn with(changes: &[(&str, &str, &str)]) -> Framework {
    let mut files = Framework::bundled_files();
    for (file, from, to) in changes {
        let text = files.get_mut(*file).unwrap();
        assert!(text.contains(from), "{file} has no {from}");
        *text = text.replacen(from, to, 1);
    }
    let (framework, found) = Framework::from_files(&files);
    // A record may be added without its type in scenarios/records.yaml.
    assert!(found.iter().all(|d| d.code == "spec.record.type"), "{found:?}");
    framework.unwrap()
}

/// Id, field and step of each change.
fn short(d: &TaxonomyDiff) -> Vec<String> {
    d.changes.iter().map(|c| format!("{} {} {}", c.id, c.field.unwrap_or("-"), c.step)).collect()
}

#[test]
fn each_change_has_its_step_and_place() {
    let record = "records:\n        - { id: gap_taken, name: { zh: 间距, en: gap taken }, unit: m }\n";
    let urgent = "  urgent:\n    labeling:\n";
    let [owes_record, is_uncertain, is_lateral] = [record, "uncertainty: high\n", "lateral: lane_keeping\n"]
        .map(|line| format!("{urgent}      {line}"));
    // Changes, and what is said of them.
    type Case<'c> = (Vec<(&'c str, &'c str, &'c str)>, &'c [&'c str]);
    let cases: Vec<Case<'_>> = vec![
        (vec![], &[]),
        // What a label must now have.
        (vec![(CUTIN, urgent, &owes_record)], &["reactive_agent.cutin.urgent records major"]),
        (vec![(CUTIN, urgent, &is_uncertain)], &["reactive_agent.cutin.urgent uncertainty major"]),
        (vec![(CUTIN, urgent, &is_lateral)], &["reactive_agent.cutin.urgent lateral major"]),
        // Another rule, said of one leaf; a whole L1's default, said once. The expression goes with it.
        (
            vec![
                (
                    CUTIN,
                    "          zh: 关键帧前 2 s\n          en: 2 s before",
                    "          zh: 关键帧前 3 s\n          en: 3 s before",
                ),
                (CUTIN, "expr: \"keyframe - 2 s\"\n    mining:", "expr: \"keyframe - 3 s\"\n    mining:"),
            ],
            &["reactive_agent.cutin.urgent start.rule major", "reactive_agent.cutin.urgent start.expr patch"],
        ),
        (
            vec![(RULE, "en: 2 s before the keyframe", "en: 2 s before that keyframe")],
            &["reactive_rule start.rule patch"],
        ),
        (vec![(RULE, "    before_s: 3\n", "    before_s: 4\n")], &["reactive_rule pack minor"]),
        (vec![("scenarios/safety.yaml", "    after_s: 3\n", "    after_s: 2\n")], &["safety pack minor"]),
        // A mining rule: changed, gone.
        (
            vec![(CUTIN, "urgent_ttc: { value: 3 s", "urgent_ttc: { value: 4 s")],
            &["reactive_agent.cutin.urgent mining.parameters patch"],
        ),
    ];
    for (changes, expected) in cases {
        assert_eq!(short(&diff_frameworks(Framework::bundled(), &with(&changes))), expected, "{changes:?}");
    }
}

/// docs/reference/framework-files.md, *Versions*: major where an old label may now be invalid.
#[test]
fn the_tables_by_which_labels_are_checked_are_compared() {
    const DECISIONS: &str = "scenarios/decisions.yaml";
    const RECORDS: &str = "scenarios/records.yaml";
    const NAMES: &str = "schema/driving_decisions.yaml";
    let diff = |file: &'static str, from: &str, to: &str| {
        let other = with(&[(file, from, to)]);
        let there = diff_frameworks(Framework::bundled(), &other);
        (short(&there), short(&diff_frameworks(&other, Framework::bundled())), there)
    };
    // Lead following is no longer allowed in a cut-in: said of each leaf that inherits it; one states its own
    // decisions.
    let text = &Framework::bundled_files()[DECISIONS];
    let at = text.find("  reactive_agent.cutin:").unwrap();
    let entry = &text[at..at + text[at..].find("lateral:").unwrap()];
    let (narrower, wider, found) = diff(DECISIONS, entry, &entry.replace("lead_following, ", ""));
    let of_each = |said: &[String], step: &str| {
        let is = |c: &String| {
            c.starts_with("reactive_agent.cutin.") && c.ends_with(&format!("longitudinal {step}"))
        };
        said.len() == 6 && said.iter().all(is)
    };
    assert!(of_each(&narrower, "major"), "{narrower:?}");
    assert!(of_each(&wider, "minor"), "{wider:?}");
    assert_eq!(found.version_check, VersionCheck::TooSmall);
    assert!(found.files.iter().any(|f| f.file == DECISIONS && f.version_check == VersionCheck::TooSmall));
    let (narrower, wider, _) = diff(
        RECORDS,
        "remaining_distance: { type: number, min: 0, max: 5000 }",
        "remaining_distance: { type: number, min: 0, max: 50 }",
    );
    assert!(
        !narrower.is_empty() && narrower.iter().all(|c| c.ends_with("records.type major")),
        "{narrower:?}"
    );
    assert!(!wider.is_empty() && wider.iter().all(|c| c.ends_with("records.type minor")), "{wider:?}");
    let (causes, _, _) = diff(DECISIONS, "lead_following: [vehicle, ", "lead_following: [");
    assert_eq!(causes, ["lead_following causes major"]);
    let (meaning, _, _) = diff(
        NAMES,
        "meaning_en: \"Nothing ahead constrains the ego",
        "meaning_en: \"Not only nothing ahead constrains the ego",
    );
    assert_eq!(meaning, ["set_speed_tracking meaning major"]);
}

#[test]
fn a_moved_class_keeps_its_texts_and_is_missed_where_it_loses_its_rule() {
    let before = Framework::bundled();
    let mut after = before.clone();
    // turn gets another id. The definition of traffic_light names turn.straight and stays as it is.
    let of = |id: &ScenarioId| id.l2.as_deref() == Some("turn");
    for l1 in &mut after.taxonomy.l1 {
        for l2 in &mut l1.l2 {
            if l2.id == "turn" {
                l2.id = "junction_turn".to_owned();
            }
            let leaves = l2.l3.iter_mut().flat_map(|l3| &mut l3.decides);
            for d in l2.decides.iter_mut().chain(leaves).filter(|d| of(&d.against)) {
                d.against.l2 = Some("junction_turn".to_owned());
            }
        }
    }
    after.rules.retain(|rule| !of(&rule.leaf));
    let said = short(&diff_frameworks(before, &after));
    assert!(said.iter().all(|c| c.ends_with("- major") || c.ends_with("mining minor")), "{said:?}");
    assert!(said.contains(&"proactive.junction_turn - major".to_owned()), "{said:?}");
    let rules = before.rules.iter().filter(|rule| of(&rule.leaf)).count();
    assert!(rules > 0);
    assert_eq!(said.iter().filter(|c| c.ends_with("mining minor")).count(), rules, "{said:?}");
}

#[test]
fn a_demand_taken_back_is_minor() {
    let urgent = "  urgent:\n    labeling:\n";
    let demanding =
        with(&[(CUTIN, urgent, &format!("{urgent}      uncertainty: high\n      lateral: lane_keeping\n"))]);
    assert_eq!(
        short(&diff_frameworks(&demanding, Framework::bundled())),
        ["reactive_agent.cutin.urgent uncertainty minor", "reactive_agent.cutin.urgent lateral minor"]
    );
}

#[test]
fn the_version_that_counts_is_that_of_the_file() {
    let urgent = "  urgent:\n    labeling:\n";
    let record = format!(
        "{urgent}      records: [{{ id: gap_taken, name: {{ zh: 间距, en: gap taken }}, unit: m }}]\n"
    );
    let demand = (CUTIN, urgent, record.as_str());
    let raised = (CUTIN, "version: \"2.0.0\"", "version: \"3.0.0\"");
    let too_low = (CUTIN, "version: \"2.0.0\"", "version: \"2.1.0\"");
    for (changes, expected) in [
        (vec![demand], VersionCheck::TooSmall),
        (vec![demand, too_low], VersionCheck::TooSmall),
        (vec![demand, raised], VersionCheck::Consistent),
    ] {
        let d = diff_frameworks(Framework::bundled(), &with(&changes));
        assert_eq!(d.version_check, expected, "{changes:?}");
        let files: Vec<_> = d.files.iter().map(|f| (f.file.as_str(), f.step.to_string())).collect();
        assert_eq!(
            files,
            [("schema/scenario_taxonomy.yaml", "none".to_owned()), (CUTIN, "major".to_owned())],
            "the classes did not change"
        );
        assert_eq!(d.changes[0].kind, ChangeKind::Labelling);
        assert_eq!(d.step.to_string(), "major");
    }
    // A default of an L1 is written in the L1's file, which answers for it.
    let before = (RULE, "    before_s: 3\n", "    before_s: 4\n");
    let raised = (RULE, "version: \"2.0.0\"", "version: \"2.1.0\"");
    for (changes, expected) in
        [(vec![before], VersionCheck::TooSmall), (vec![before, raised], VersionCheck::Consistent)]
    {
        let d = diff_frameworks(Framework::bundled(), &with(&changes));
        assert_eq!((d.version_check, d.files[1].file.as_str()), (expected, RULE));
    }
}

/// A leaf with another id in every file: that is the one change; what refers to it has not changed.
#[test]
fn what_refers_to_a_class_with_another_id_has_not_changed() {
    let mut files = Framework::bundled_files();
    for text in files.values_mut() {
        *text = text.replace("from_stationary", "pulls_out");
    }
    // Entries of the calibration are in the order of ids.
    files.remove("schema/calibration.yaml");
    let (framework, _) = Framework::from_files(&files);
    let d = diff_frameworks(Framework::bundled(), &framework.unwrap());
    assert_eq!(short(&d), ["reactive_agent.cutin.pulls_out - major"], "{:?}", d.changes);
    let from = d.changes[0].from_id.as_ref().map(ToString::to_string);
    assert_eq!(from.as_deref(), Some("reactive_agent.cutin.from_stationary"));
}
