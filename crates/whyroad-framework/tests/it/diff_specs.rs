//! `diff_frameworks`: which changes of labeling specs and mining rules call for which step. The steps are those of
//! docs/how-to/edit-the-framework.md "Which version", after DATA_FORMAT.md 1.3 of the specification: what makes an
//! old label invalid is major, what only adds is minor.

use whyroad_framework::Framework;
use whyroad_framework::diff::{ChangeKind, TaxonomyDiff, VersionCheck, diff_frameworks};

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
    assert!(found.is_empty(), "{found:?}");
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
