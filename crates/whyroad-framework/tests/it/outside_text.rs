//! Texts from outside: whatever is done to a file, reading it ends in a value and findings, never in a panic.

use proptest::prelude::*;
use std::collections::BTreeMap;
use whyroad_framework::Framework;
use whyroad_framework::diff::diff;
use whyroad_framework::docs::taxonomy_page;
use whyroad_framework::markdown::lint_markdown;
use whyroad_framework::taxonomy::read_taxonomy;
use whyroad_framework::version::Step;

/// `text` after edits: at a place given as a share of its length, some characters go and some come.
fn edited(text: &str, edits: &[(f64, usize, String)]) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    for (share, gone, come) in edits {
        let at = ((chars.len() as f64) * share) as usize;
        let end = (at + gone).min(chars.len());
        chars.splice(at..end, come.chars());
    }
    chars.into_iter().collect()
}

fn edits() -> impl Strategy<Value = Vec<(f64, usize, String)>> {
    let piece = prop_oneof![
        Just("|".to_owned()),
        Just("## L1: (".to_owned()),
        Just(") (".to_owned()),
        Just("个L2".to_owned()),
        Just("][".to_owned()),
        Just("\n".to_owned()),
        Just("：".to_owned()),
        Just(" - ".to_owned()),
        Just("{".to_owned()),
        ".{0,4}"
    ];
    prop::collection::vec((0.0..1.0f64, 0usize..6, piece), 1..8)
}

/// The first classes of our own page with its head and tree: the form of a TAXONOMY.md, short enough to vary often.
fn page() -> String {
    let whole = taxonomy_page(Framework::bundled());
    let head: String = whole.lines().take(60).collect::<Vec<_>>().join("\n");
    let tree = &whole[whole.rfind("## 场景树状图").unwrap_or(0)..];
    format!("{head}\n{tree}")
}

const SPEC: &str = "scenarios/reactive_agent/cutin.yaml";

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_page_in_any_state_is_linted(edits in edits()) {
        let text = edited(&page(), &edits);
        for d in lint_markdown("page.md", &text, Some(&Framework::bundled().taxonomy)) {
            prop_assert!(d.location.line.is_none_or(|l| l >= 1 && l <= text.lines().count().max(1)));
        }
    }

    #[test]
    fn a_taxonomy_in_any_state_is_read(edits in edits()) {
        let whole = &Framework::bundled_files()["schema/scenario_taxonomy.yaml"];
        let text = edited(&whole.chars().take(6000).collect::<String>(), &edits);
        let (taxonomy, _) = read_taxonomy("t.yaml", &text);
        if let Some(t) = taxonomy {
            // A thing does not differ from itself.
            let same = diff(&t, &t);
            prop_assert!(same.changes.is_empty() && same.step == Step::None);
        }
    }

    #[test]
    fn a_spec_in_any_state_is_read(edits in edits()) {
        let mut files: BTreeMap<String, String> = Framework::bundled_files();
        files.retain(|path, _| path == "schema/scenario_taxonomy.yaml" || path == SPEC);
        let text = edited(&files[SPEC], &edits);
        files.insert(SPEC.to_owned(), text);
        let (framework, _) = Framework::from_files(&files);
        prop_assert!(framework.is_some());
    }
}
