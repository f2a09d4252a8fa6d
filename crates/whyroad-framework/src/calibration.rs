//! Accuracy of mined episodes (`schema/calibration.yaml`): by class and margin score, the share of judged episodes that
//! was right. Mining makes its scores from it; `whyroad calibrate` writes it. How shares are estimated from judged
//! episodes is `whyroad_report::calibration`.

use crate::yaml_text;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use whyroad_model::yaml::{self, Node};
use whyroad_model::{Bilingual, Diagnostic, Location, ScenarioId};

/// Name of the file in a framework.
pub const CALIBRATION_FILE: &str = "schema/calibration.yaml";

/// Codes of errors in the file.
pub const CODES: &[&str] = &["calibration.file"];

/// A class with fewer judged episodes is not calibrated: the table keeps its counts, mining does not use them.
pub const LEAST_JUDGED: usize = 5;

/// The table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Version of the file.
    pub version: String,
    /// The judged episodes.
    pub sources: Vec<CalibrationSource>,
    /// In the order of their ids.
    pub classes: Vec<ClassCalibration>,
}

/// Judged episodes of one kind.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibrationSource {
    /// For people.
    pub name: String,
    /// Who judged.
    pub kind: SourceKind,
    /// Drives with a judged episode.
    pub drives: usize,
    /// Episodes.
    pub judged: usize,
    /// Of these, with the right class.
    pub right: usize,
}

/// Source of the judgments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SourceKind {
    /// A truth file.
    Truth,
    /// Verdicts of people.
    Verdicts,
    /// An earlier table, which counts as a few episodes per class.
    Table,
}

/// One class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassCalibration {
    /// Leaf, or L2 where its own rule was judged.
    pub id: ScenarioId,
    /// Judged episodes.
    pub judged: usize,
    /// Of these, with the right class.
    pub right: usize,
    /// 95 % interval of the share that is right (Wilson 1927).
    pub interval: [f64; 2],
    /// Estimated share by margin score, least score first; never falls with the score.
    pub steps: Vec<CalibrationStep>,
}

/// From this margin score up to that of the next step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibrationStep {
    /// Least margin score.
    pub from: f64,
    /// Estimated share that is right.
    pub share: f64,
    /// Judged episodes of the step.
    pub judged: usize,
    /// Of these, right.
    pub right: usize,
}

impl ClassCalibration {
    /// True where enough was judged for mining to use it.
    pub fn is_usable(&self) -> bool {
        self.judged >= LEAST_JUDGED && !self.steps.is_empty()
    }

    /// Share at a margin score, for any number of judged episodes; that of the first step below it.
    pub fn share_at(&self, margin_score: f64) -> Option<f64> {
        // Both evaluators agree on four decimals of a margin score.
        let score = (margin_score * 1e4).round() / 1e4;
        let step = self.steps.iter().rev().find(|s| s.from <= score).or(self.steps.first());
        step.map(|s| s.share)
    }
}

impl Calibration {
    /// From the text of the file; `file` is named in diagnostics. A table with an error is not used at all: scores from
    /// a part of it would not be comparable.
    pub fn parse(file: &str, text: &str) -> (Calibration, Vec<Diagnostic>) {
        let what = Bilingual::new("校准表", "the calibration table");
        let (mut table, root): (Calibration, Node) =
            match yaml_text::read("calibration.file", file, text, what) {
                Ok(read) => read,
                Err(finding) => return (Calibration::default(), vec![*finding]),
            };
        let fault = |nth: usize, message: Bilingual, (zh, en): (&str, &str)| {
            let node = root.get("classes").and_then(|all| all.items().get(nth));
            let at = node.map(|n| yaml_text::location(file, text, n.get("id").unwrap_or(n).mark));
            let hint = Bilingual::new(zh, en);
            let d = Diagnostic::error("calibration.file", message).in_file(file).with_hint(hint);
            (Calibration::default(), vec![at.into_iter().fold(d, Diagnostic::at)])
        };
        for (nth, class) in table.classes.iter().enumerate() {
            let id = &class.id;
            if let Some((zh, en)) = class.fault() {
                let message = Bilingual::new(format!("类别 '{id}'：{zh}"), format!("class '{id}': {en}"));
                let hint = (
                    "从此文件的较早版本中取回该条目，或删除它（该类别即不校准）",
                    "take this entry from an earlier version of the file, or delete it: the class is then not calibrated",
                );
                return fault(nth, message, hint);
            }
            if table.classes[..nth].iter().any(|c| c.id == *id) {
                let message = Bilingual::new(
                    format!("类别 '{id}' 出现了两次"),
                    format!("class '{id}' is listed twice"),
                );
                return fault(nth, message, ("删除两个条目之一", "delete one of the two entries"));
            }
        }
        // A class that was renamed by hand is where its old name was.
        table.classes.sort_by(|a, b| a.id.cmp(&b.id));
        (table, Vec::new())
    }

    /// Position of the entry of a class in the text of the file.
    pub fn place(file: &str, text: &str, class: &ScenarioId) -> Option<Location> {
        let (root, class) = (yaml::parse(text).ok()?, class.to_string());
        let mut ids = root.get("classes")?.items().iter().filter_map(|entry| entry.get("id"));
        let id = ids.find(|id| id.text() == Some(class.as_str()))?;
        Some(yaml_text::location(file, text, id.mark))
    }

    /// The table as the text of its file.
    ///
    /// # Errors
    /// Never for numbers that are finite.
    pub fn to_yaml(&self) -> serde_json::Result<String> {
        Ok(format!(
            "# Share of mined episodes that is right, by class and margin score (docs/reference/calibration.md).\n\
             # Written by `whyroad calibrate`.\n{}",
            yaml::to_string(self)?
        ))
    }

    /// The entry of a class, even where it has too few episodes to be used.
    pub fn class(&self, id: &ScenarioId) -> Option<&ClassCalibration> {
        self.classes.binary_search_by(|c| c.id.cmp(id)).ok().map(|i| &self.classes[i])
    }

    /// Share of the episodes of a class with this margin score that is right; `None` where the class is not calibrated.
    pub fn share(&self, class: &ScenarioId, margin_score: f64) -> Option<f64> {
        self.class(class).filter(|c| c.is_usable())?.share_at(margin_score)
    }

    /// Judged episodes and right ones, over all classes.
    pub fn totals(&self) -> (usize, usize) {
        self.classes.iter().fold((0, 0), |(n, right), c| (n + c.judged, right + c.right))
    }

    /// The usable classes by id.
    pub fn usable(&self) -> BTreeMap<&ScenarioId, &ClassCalibration> {
        self.classes.iter().filter(|c| c.is_usable()).map(|c| (&c.id, c)).collect()
    }
}

impl ClassCalibration {
    /// Description of an impossible value, in Chinese and English.
    fn fault(&self) -> Option<(&'static str, &'static str)> {
        let share = |x: f64| (0.0..=1.0).contains(&x);
        let [low, high] = self.interval;
        if self.right > self.judged || self.steps.iter().any(|s| s.right > s.judged) {
            return Some(("正确数多于判定数", "more right episodes than judged ones"));
        }
        if self.steps.iter().map(|s| s.judged).sum::<usize>() != self.judged
            || self.steps.iter().map(|s| s.right).sum::<usize>() != self.right
        {
            return Some(("各级计数之和与总数不符", "the counts of the steps do not add up"));
        }
        if !share(low) || !share(high) || low > high || self.steps.iter().any(|s| !share(s.share)) {
            return Some(("比例须在 0 与 1 之间", "a share is not between 0 and 1"));
        }
        let rises = |two: &[CalibrationStep]| two[0].from < two[1].from && two[0].share <= two[1].share;
        if !self.steps.windows(2).all(rises) {
            return Some((
                "各级的得分须递增，比例不得下降",
                "scores of steps must rise, and shares must not fall",
            ));
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Calibration {
        let step = |from, share, judged, right| CalibrationStep { from, share, judged, right };
        let class = |id: &str, judged, right, steps| ClassCalibration {
            id: id.parse().unwrap(),
            judged,
            right,
            interval: [0.25, 0.75],
            steps,
        };
        Calibration {
            version: "1".into(),
            sources: vec![],
            classes: vec![
                class("a.b.c", 20, 12, vec![step(0.5, 0.5, 10, 5), step(0.8, 0.7, 10, 7)]),
                class("a.b.d", 4, 4, vec![step(0.5, 0.9, 4, 4)]),
            ],
        }
    }

    #[test]
    fn a_score_has_the_share_of_its_step() {
        let (table, id) = (table(), |s: &str| s.parse::<ScenarioId>().unwrap());
        let share = |score| table.share(&id("a.b.c"), score);
        assert_eq!(
            (share(0.5), share(0.79994), share(0.79996), share(0.98)),
            (Some(0.5), Some(0.5), Some(0.7), Some(0.7))
        );
        // Four judged episodes are too few, no episodes as well.
        assert_eq!((table.share(&id("a.b.d"), 0.9), table.share(&id("a.b.e"), 0.9)), (None, None));
        assert_eq!(table.totals(), (24, 16));
    }

    #[test]
    fn what_is_written_is_read_back() {
        let text = table().to_yaml().unwrap();
        assert_eq!(Calibration::parse("f", &text), (table(), vec![]));
    }

    #[test]
    fn a_class_that_was_renamed_by_hand_may_stay_where_it_is() {
        let mut swapped = table();
        swapped.classes.swap(0, 1);
        assert_eq!(Calibration::parse("f", &swapped.to_yaml().unwrap()), (table(), vec![]));
    }

    #[test]
    fn a_faulty_class_is_named_with_its_line() {
        let mut table = table();
        table.classes[1].id = table.classes[0].id.clone();
        let text = table.to_yaml().unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let second = lines.iter().rposition(|l| *l == format!("- id: {}", table.classes[0].id)).unwrap();
        let d = &Calibration::parse("f", &text).1[0];
        assert_eq!((d.location.line, d.location.column), (Some(second + 1), Some(7)));
        assert!(d.hint.as_ref().unwrap().en.contains("delete one of the two"));
        let place = Calibration::place("f", &text, &table.classes[0].id).unwrap();
        let first = lines.iter().position(|l| *l == format!("- id: {}", table.classes[0].id)).unwrap();
        assert_eq!(place.line, Some(first + 1));
    }

    #[test]
    fn a_table_that_cannot_be_is_refused() {
        let broken = |change: fn(&mut Calibration)| {
            let mut table = table();
            change(&mut table);
            let (read, found) = Calibration::parse("f", &table.to_yaml().unwrap());
            assert_eq!((read, found[0].code), (Calibration::default(), "calibration.file"));
        };
        broken(|t| t.classes[0].right = 21);
        broken(|t| t.classes[0].steps[1].share = 0.4);
        broken(|t| t.classes[0].steps[1].judged = 11);
        broken(|t| t.classes[0].interval = [0.9, 1.1]);
        broken(|t| t.classes[1].id = t.classes[0].id.clone());
        assert_eq!(Calibration::parse("f", "classes: 3").1[0].code, "calibration.file");
    }
}
