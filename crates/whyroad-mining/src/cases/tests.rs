use super::*;
use crate::fast;
use whyroad_framework::Framework;

/// Cases are run by the evaluator that mines; the reference defines the meaning of a rule. The other equality tests use
/// drives, these use the hand-written edge cases of each rule.
#[test]
fn both_evaluators_find_the_same_in_every_case() {
    let all = RuleSet::of_framework(Framework::bundled(), Catalog::bundled()).0;
    let files = Framework::bundled_files();
    let mut compared = 0;
    for (path, text) in files.iter().filter(|(path, _)| path.ends_with(CASES_EXTENSION)) {
        let parsed: CaseFile<CaseText> = yaml::from_node(&yaml::parse(text).unwrap()).unwrap();
        let l1 = parsed.l1.unwrap_or_else(|| OTHER.to_owned());
        let rules = all.restricted_to(&[ScenarioId { l1, l2: parsed.l2, l3: None }]);
        for case in &parsed.cases {
            let table = table(case, &parsed.base, Catalog::bundled()).unwrap();
            let (ours, reference) =
                (fast::mine_drive(&rules, &table), crate::drive::mine_drive(&rules, &table));
            assert_eq!(ours.missing, reference.missing, "{path}: {}", case.name);
            assert_eq!(ours.episodes.len(), reference.episodes.len(), "{path}: {}", case.name);
            for (a, b) in ours.episodes.iter().zip(reference.episodes) {
                assert!((a.score - b.score).abs() <= 1e-9, "{path}: {}", case.name);
                assert_eq!(a, &Episode { score: a.score, ..b }, "{path}: {}", case.name);
            }
            compared += 1;
        }
    }
    assert!(compared >= 4 * all.rules.len(), "{compared} cases");
}
