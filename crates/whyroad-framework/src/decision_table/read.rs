//! Reads `scenarios/decisions.yaml` and compares it with the taxonomy.

use super::{Causes, ClassDecisions, DecisionTable, Fit, LateralEntry};
use crate::Taxonomy;
use crate::label_words::{GroupSet, LabelWords};
use crate::taxonomy::did_you_mean;
use crate::yaml_text;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::yaml::{Mark, Node};
use whyroad_model::{Bilingual, Diagnostic, ScenarioId};

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

impl RawChannel {
    /// The lists, with their fit and key.
    fn lists(&self) -> [(&Vec<String>, Fit, &'static str); 2] {
        [(&self.usual, Fit::Usual, "usual"), (&self.possible, Fit::Possible, "possible")]
    }
}

/// The table in `text`, and its errors. `file` is named in diagnostics.
pub fn parse(
    file: &str,
    text: &str,
    taxonomy: &Taxonomy,
    words: &LabelWords,
) -> (DecisionTable, Vec<Diagnostic>) {
    let what = Bilingual::new("决策组合表", "the decision table");
    let (raw, root): (File, Node) = match yaml_text::read("spec.decisions", file, text, what) {
        Ok(read) => read,
        Err(finding) => return (DecisionTable::default(), vec![*finding]),
    };
    let mut reader = Reader { file, text, root: &root, words, out: Vec::new() };
    let mut table = DecisionTable::default();
    let (causes, problems) = Causes::read(&raw.causes, words);
    table.causes = causes;
    for problem in problems {
        let at = root.entries().iter().find(|e| e.key == "causes").map(|e| e.mark);
        reader.problem(at, problem.zh, problem.en);
    }
    for (i, (along, across)) in raw.impossible_pairs.iter().enumerate() {
        let written =
            root.get("impossible_pairs").and_then(|n| n.items().get(i)).map_or(&[][..], Node::items);
        let at = |side: usize| written.get(side).map(|n| n.mark);
        let of = "impossible_pairs";
        let pair = reader.longitudinal(along, of, at(0)).zip(reader.lateral(across, of, at(1)));
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
        reader.problem(
            reader.class_mark(class),
            format!("'{class}' 不是类别{}", also.0),
            format!("'{class}' is not a class{}", also.1),
        );
    }
    let mut absent: BTreeSet<String> = BTreeSet::new();
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
        let levels = [id.to_string(), format!("{}.{}", l1.id, l2.id)];
        // Said once for the L2: without any entry there is nothing to compare the rest with.
        if whole.longitudinal.is_none() && whole.lateral.is_none() {
            if absent.insert(levels[1].clone()) {
                reader.absent(&levels[1]);
            }
            table.leaves.insert(id, ClassDecisions::default());
            continue;
        }
        let class = reader.class(&levels, &whole);
        for d in
            l3.typical_decisions.longitudinal.iter().filter(|d| {
                whole.longitudinal.is_some() && class.longitudinal_fit(Some(**d)) == Fit::Impossible
            })
        {
            reader.typical(&id, reader.part(&levels, "longitudinal").map(|n| n.mark), d.id());
        }
        for d in l3
            .typical_decisions
            .lateral
            .iter()
            .filter(|d| whole.lateral.is_some() && class.lateral_fit(Some(**d)) == Fit::Impossible)
        {
            reader.typical(&id, reader.part(&levels, "lateral").map(|n| n.mark), d.id());
        }
        table.leaves.insert(id, class);
    }
    (table, reader.out)
}

struct Reader<'r> {
    file: &'r str,
    text: &'r str,
    /// The file as written.
    root: &'r Node,
    words: &'r LabelWords,
    out: Vec<Diagnostic>,
}

impl<'r> Reader<'r> {
    fn problem(&mut self, at: Option<Mark>, zh: String, en: String) {
        let problem = Diagnostic::error("spec.decisions", Bilingual::new(zh, en));
        self.out.push(match at {
            Some(mark) => problem.at(yaml_text::location(self.file, self.text, mark)),
            None => problem.in_file(self.file),
        });
    }

    /// Position of the key of a class.
    fn class_mark(&self, class: &str) -> Option<Mark> {
        self.root.get("classes")?.entries().iter().find(|e| e.key == class).map(|e| e.mark)
    }

    /// A part of a class as written: of a leaf, or else of its L2.
    fn part(&self, levels: &[String; 2], key: &str) -> Option<&'r Node> {
        let classes = self.root.get("classes")?;
        levels.iter().find_map(|class| classes.get(class)?.get(key))
    }

    /// An L2 whose leaves have no decisions at all.
    fn absent(&mut self, l2: &str) {
        let message = Bilingual::new(
            format!("决策组合表中没有 {l2}"),
            format!("the decision table has no entry for {l2}"),
        );
        let hint = Bilingual::new(
            format!(
                "在 classes 中添加：{l2}: {{ longitudinal: {{ usual: […], possible: […] }}, lateral: {{ usual: […], possible: […] }}, about: […] }}"
            ),
            format!(
                "add to classes: {l2}: {{ longitudinal: {{ usual: [...], possible: [...] }}, lateral: {{ usual: [...], \
                 possible: [...] }}, about: [...] }}"
            ),
        );
        let problem = Diagnostic::error("spec.decisions", message).with_hint(hint);
        let at = self.root.entries().iter().find(|e| e.key == "classes").map(|e| e.mark);
        self.out.push(match at {
            Some(mark) => problem.at(yaml_text::location(self.file, self.text, mark)),
            None => problem.in_file(self.file),
        });
    }

    fn typical(&mut self, id: &ScenarioId, at: Option<Mark>, decision: &str) {
        self.problem(
            at,
            format!("{id} 的典型决策 {decision} 在决策组合表中不可能"),
            format!("{decision} is typical of {id} in the taxonomy, but impossible in the decision table"),
        );
    }

    /// `levels` are the ids of the leaf and of its L2.
    fn class(&mut self, levels: &[String; 2], raw: &RawClass) -> ClassDecisions {
        let id = levels[0].as_str();
        // Position of an item of a list; channels have two lists.
        let list = |reader: &Self, part: &str, fit: Option<&str>| -> Vec<Mark> {
            let part = reader.part(levels, part);
            let list = fit.map_or(part, |fit| part?.get(fit));
            list.map_or(&[][..], Node::items).iter().map(|n| n.mark).collect()
        };
        let mut out = ClassDecisions {
            decides: raw.decides.unwrap_or(false),
            reveals: raw.reveals.unwrap_or(false),
            about_names: raw.about.clone().unwrap_or_default(),
            ..ClassDecisions::default()
        };
        if raw.longitudinal.is_none() || raw.lateral.is_none() {
            let at = levels.iter().find_map(|class| self.class_mark(class));
            self.problem(
                at,
                format!("{id} 缺少 longitudinal 或 lateral"),
                format!("{id} has no longitudinal or no lateral decisions"),
            );
        }
        for (names, fit, key) in raw.longitudinal.iter().flat_map(RawChannel::lists) {
            let marks = list(self, "longitudinal", Some(key));
            for (i, name) in names.iter().enumerate() {
                out.longitudinal.extend(self.longitudinal(name, id, marks.get(i).copied()).map(|d| (d, fit)));
            }
        }
        for (names, fit, key) in raw.lateral.iter().flat_map(RawChannel::lists) {
            let marks = list(self, "lateral", Some(key));
            for (i, name) in names.iter().enumerate() {
                out.lateral.extend(self.lateral(name, id, marks.get(i).copied()).map(|d| (d, fit)));
            }
        }
        let marks = list(self, "about", None);
        for (i, name) in out.about_names.iter().enumerate() {
            match self.words.kinds.get(name) {
                Some(set) => out.about = out.about.with(*set),
                // Without words nothing can be compared; their absence has already been reported.
                None if self.words.is_empty() => out.about = GroupSet::default(),
                None => self.problem(
                    marks.get(i).copied(),
                    format!("{id}：schema/label_words.yaml 中没有 '{name}'"),
                    format!("{id}: schema/label_words.yaml has no '{name}'"),
                ),
            }
        }
        out
    }

    fn longitudinal(&mut self, name: &str, id: &str, at: Option<Mark>) -> Option<Option<Longitudinal>> {
        if name == NONE {
            return Some(None);
        }
        let found = Longitudinal::from_id(name);
        if found.is_none() {
            self.problem(
                at,
                format!("{id}：'{name}' 不是纵向决策"),
                format!("{id}: '{name}' is not a longitudinal decision"),
            );
        }
        found.map(Some)
    }

    fn lateral(&mut self, name: &str, id: &str, at: Option<Mark>) -> Option<LateralEntry> {
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
                at,
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
        // Lines are counted in the text, not taken from the reader.
        for (from, to) in [
            ("reactive_agent.cutin.ramp:", "reactive_agent.cutin.rump:"),
            ("usual: [turn/left]", "usual: [turn/up]"),
            ("about: [vru]", "about: [vrus]"),
        ] {
            let at = files[FILE].find(from).unwrap();
            let line = files[FILE][..at].matches('\n').count() + 1;
            let found = table(from, to);
            assert!(found.iter().any(|d| d.location.line == Some(line)), "{to}: {found:?}");
        }
        assert!(
            said("  turn: [route", "  tern: [route")
                .iter()
                .any(|m| m.contains("no row for the decision 'turn'"))
        );
        assert!(said("vehicle@standing", "vehicle@sitting").iter().any(|m| m.contains("unknown state")));
        assert!(said("about: [vru]", "about: [vrus]").iter().any(|m| m.contains("has no 'vrus'")));
        assert!(said("usual: [turn/left]", "usual: [turn/up]").iter().any(|m| m.contains("turn/up")));
        // An L2 without an entry is one finding, with the entry to add.
        let text = &files[FILE];
        let at = text.find("  reactive_agent.animal:").unwrap();
        let end = at + text[at..].find("\n\n").unwrap() + 1;
        let without = format!("{}{}", &text[..at], &text[end..]);
        let found = parse(FILE, &without, &f.taxonomy, f.label_words()).1;
        let of_animal: Vec<_> =
            found.iter().filter(|d| d.message.en.contains("reactive_agent.animal")).collect();
        assert_eq!(of_animal.len(), 1, "{of_animal:?}");
        assert!(of_animal[0].hint.as_ref().is_some_and(|h| h.en.contains("reactive_agent.animal: {")));
        let typical = said(
            "longitudinal: { usual: [resume], possible: [] }",
            "longitudinal: { usual: [none], possible: [] }",
        );
        assert!(typical.iter().any(|m| m.contains("typical of")), "{typical:?}");
    }
}
