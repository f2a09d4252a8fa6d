//! Reads `scenarios/decisions.yaml` and compares it with the taxonomy.

use super::{Causes, ClassDecisions, DecisionTable, Fit, LateralEntry};
use crate::Taxonomy;
use crate::label_words::{GroupSet, LabelWords};
use crate::taxonomy::did_you_mean;
use serde::Deserialize;
use std::collections::BTreeMap;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::{Bilingual, Diagnostic, ScenarioId, yaml};

/// The identifier for "no change of decision".
const NONE: &str = "none";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[allow(dead_code)] // read by people
    version: String,
    #[serde(default)]
    impossible_pairs: Vec<(String, String)>,
    causes: BTreeMap<String, Vec<String>>,
    classes: BTreeMap<String, RawClass>,
}

#[derive(Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawClass {
    longitudinal: Option<RawChannel>,
    lateral: Option<RawChannel>,
    decides: Option<bool>,
    about: Option<Vec<String>>,
    reveals: Option<bool>,
}

#[derive(Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawChannel {
    #[serde(default)]
    usual: Vec<String>,
    #[serde(default)]
    possible: Vec<String>,
}

/// The table in `text`, and its errors. `file` is named in diagnostics.
pub fn parse(
    file: &str,
    text: &str,
    taxonomy: &Taxonomy,
    words: &LabelWords,
) -> (DecisionTable, Vec<Diagnostic>) {
    let raw: File = match yaml::from_str(text) {
        Ok(raw) => raw,
        Err(e) => {
            let what = Bilingual::new("决策组合表", "the decision table");
            return (DecisionTable::default(), vec![e.diagnostic("spec.decisions", file, what)]);
        }
    };
    let mut reader = Reader { file, words, out: Vec::new() };
    let mut table = DecisionTable::default();
    let (causes, problems) = Causes::read(&raw.causes, words);
    table.causes = causes;
    for problem in problems {
        reader.problem(problem.zh, problem.en);
    }
    for (along, across) in &raw.impossible_pairs {
        let pair =
            reader.longitudinal(along, "impossible_pairs").zip(reader.lateral(across, "impossible_pairs"));
        if let Some((Some(along), LateralEntry { lateral: Some(across), .. })) = pair {
            table.impossible_pairs.push((along, across));
        }
    }
    let known: Vec<String> = taxonomy.ids().iter().map(ToString::to_string).collect();
    for class in raw.classes.keys().filter(|c| !known.contains(c)) {
        let near = did_you_mean(class, known.iter().map(String::as_str));
        let also = near
            .map(|n| (format!("，是否想写 '{n}'？"), format!("; did you mean '{n}'?")))
            .unwrap_or_default();
        reader
            .problem(format!("'{class}' 不是类别{}", also.0), format!("'{class}' is not a class{}", also.1));
    }
    for (l1, l2, l3) in taxonomy.leaves() {
        let id = ScenarioId::leaf(&l1.id, &l2.id, &l3.id);
        let above = raw.classes.get(&format!("{}.{}", l1.id, l2.id)).cloned().unwrap_or_default();
        let own = raw.classes.get(&id.to_string()).cloned().unwrap_or_default();
        let whole = RawClass {
            longitudinal: own.longitudinal.or(above.longitudinal),
            lateral: own.lateral.or(above.lateral),
            decides: own.decides.or(above.decides),
            about: own.about.or(above.about),
            reveals: own.reveals.or(above.reveals),
        };
        let class = reader.class(&id.to_string(), &whole);
        for d in l3
            .typical_decisions
            .longitudinal
            .iter()
            .filter(|d| class.longitudinal_fit(Some(**d)) == Fit::Impossible)
        {
            reader.typical(&id, d.id());
        }
        for d in
            l3.typical_decisions.lateral.iter().filter(|d| class.lateral_fit(Some(**d)) == Fit::Impossible)
        {
            reader.typical(&id, d.id());
        }
        table.leaves.insert(id, class);
    }
    (table, reader.out)
}

struct Reader<'r> {
    file: &'r str,
    words: &'r LabelWords,
    out: Vec<Diagnostic>,
}

impl Reader<'_> {
    fn problem(&mut self, zh: String, en: String) {
        self.out.push(Diagnostic::error("spec.decisions", Bilingual::new(zh, en)).in_file(self.file));
    }

    fn typical(&mut self, id: &ScenarioId, decision: &str) {
        self.problem(
            format!("{id} 的典型决策 {decision} 在决策组合表中不可能"),
            format!("{decision} is typical of {id} in the taxonomy, but impossible in the decision table"),
        );
    }

    fn class(&mut self, id: &str, raw: &RawClass) -> ClassDecisions {
        let mut out = ClassDecisions {
            decides: raw.decides.unwrap_or(false),
            reveals: raw.reveals.unwrap_or(false),
            about_names: raw.about.clone().unwrap_or_default(),
            ..ClassDecisions::default()
        };
        if raw.longitudinal.is_none() || raw.lateral.is_none() {
            self.problem(
                format!("{id} 缺少 longitudinal 或 lateral"),
                format!("{id} has no longitudinal or no lateral decisions"),
            );
        }
        for (names, fit) in
            raw.longitudinal.iter().flat_map(|c| [(&c.usual, Fit::Usual), (&c.possible, Fit::Possible)])
        {
            out.longitudinal.extend(names.iter().filter_map(|n| Some((self.longitudinal(n, id)?, fit))));
        }
        for (names, fit) in
            raw.lateral.iter().flat_map(|c| [(&c.usual, Fit::Usual), (&c.possible, Fit::Possible)])
        {
            out.lateral.extend(names.iter().filter_map(|n| Some((self.lateral(n, id)?, fit))));
        }
        for name in &out.about_names {
            match self.words.kinds.get(name) {
                Some(set) => out.about = out.about.with(*set),
                // Without words nothing can be compared; their absence has already been reported.
                None if self.words.is_empty() => out.about = GroupSet::default(),
                None => self.out.push(
                    Diagnostic::error(
                        "spec.decisions",
                        Bilingual::new(
                            format!("{id}：schema/label_words.yaml 中没有 '{name}'"),
                            format!("{id}: schema/label_words.yaml has no '{name}'"),
                        ),
                    )
                    .in_file(self.file),
                ),
            }
        }
        out
    }

    fn longitudinal(&mut self, name: &str, id: &str) -> Option<Option<Longitudinal>> {
        if name == NONE {
            return Some(None);
        }
        let found = Longitudinal::from_id(name);
        if found.is_none() {
            self.problem(
                format!("{id}：'{name}' 不是纵向决策"),
                format!("{id}: '{name}' is not a longitudinal decision"),
            );
        }
        found.map(Some)
    }

    fn lateral(&mut self, name: &str, id: &str) -> Option<LateralEntry> {
        if name == NONE {
            return Some(LateralEntry { lateral: None, direction: None });
        }
        let (decision, direction) = name.split_once('/').map_or((name, None), |(d, side)| (d, Some(side)));
        let lateral = Lateral::from_id(decision);
        let side = direction.map(LateralDirection::from_id);
        let wrong_side = match (lateral, side) {
            (Some(l), Some(Some(side))) => !l.directions().contains(&side),
            (_, side) => side.is_some(),
        };
        if lateral.is_none() || wrong_side {
            self.problem(
                format!("{id}：'{name}' 不是横向决策或方向"),
                format!("{id}: '{name}' is not a lateral decision with a direction"),
            );
            return None;
        }
        Some(LateralEntry { lateral, direction: side.flatten() })
    }
}

#[cfg(test)]
mod tests {
    use crate::Framework;
    use crate::decision_table::{Fit, parse};
    use whyroad_model::ScenarioId;
    use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};

    const FILE: &str = "scenarios/decisions.yaml";

    #[test]
    fn every_leaf_has_its_decisions() {
        let f = Framework::bundled();
        assert_eq!(f.decision_table().leaves.len(), f.taxonomy.counts().2);
        for (id, class) in &f.decision_table().leaves {
            assert!(class.longitudinal.iter().any(|(_, fit)| *fit == Fit::Usual), "{id}");
            assert!(!class.about.is_empty(), "{id}");
        }
        // Combinations that wrongly passed before.
        let leaf = |l1: &str, l2: &str, l3: &str| &f.decision_table().leaves[&ScenarioId::leaf(l1, l2, l3)];
        let red = leaf("reactive_rule", "traffic_light", "red_stop");
        assert_eq!(red.longitudinal_fit(Some(Longitudinal::Resume)), Fit::Impossible);
        let left = leaf("proactive", "turn", "left_normal");
        assert_eq!(left.direction_fit(Lateral::Turn, Some(LateralDirection::Right)), Fit::Impossible);
        assert_eq!(left.direction_fit(Lateral::Turn, Some(LateralDirection::Left)), Fit::Usual);
        let abort = leaf("proactive", "lane_change", "abort");
        assert_eq!(abort.lateral_fit(Some(Lateral::LaneChange)), Fit::Impossible);
        let aeb = leaf("safety", "aeb", "vru");
        assert_eq!(aeb.longitudinal_fit(Some(Longitudinal::SetSpeedTracking)), Fit::Impossible);
    }

    #[test]
    fn faults_of_the_table_are_reported() {
        let files = Framework::bundled_files();
        let f = Framework::bundled();
        let table = |from: &str, to: &str| {
            let text = files[FILE].replacen(from, to, 1);
            assert_ne!(text, files[FILE], "{from}");
            parse(FILE, &text, &f.taxonomy, f.label_words()).1
        };
        let said =
            |from: &str, to: &str| table(from, to).iter().map(|d| d.message.en.clone()).collect::<Vec<_>>();
        assert!(said("classes:", "klasses:").iter().any(|m| m.contains("cannot be read")));
        assert!(said("reactive_agent.cutin.ramp:", "reactive_agent.cutin.rump:")[0].contains("did you mean"));
        assert!(
            said("  turn: [route", "  tern: [route")
                .iter()
                .any(|m| m.contains("no row for the decision 'turn'"))
        );
        assert!(said("vehicle@standing", "vehicle@sitting").iter().any(|m| m.contains("unknown state")));
        assert!(said("about: [vru]", "about: [vrus]").iter().any(|m| m.contains("has no 'vrus'")));
        assert!(said("usual: [turn/left]", "usual: [turn/up]").iter().any(|m| m.contains("turn/up")));
        let typical = said(
            "longitudinal: { usual: [resume], possible: [] }",
            "longitudinal: { usual: [none], possible: [] }",
        );
        assert!(typical.iter().any(|m| m.contains("typical of")), "{typical:?}");
    }
}
