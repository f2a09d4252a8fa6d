//! Verdicts that people gave on mined episodes (the export of the labeling service, docs/reference/verdicts.md): as
//! moments that judge a comparison, and as the share of episodes that is right by class and score.

use crate::comparison::AcceptedMoment;
use crate::shares::{Block, pooled, wilson};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use whyroad_model::messages::VerdictKind;
use whyroad_model::{Bilingual, Diagnostic, DriveId, Lang, Location, Nanos, ScenarioId};

/// One line of the export, limited to the fields used here; further fields are for readers.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct VerdictLine {
    /// The verdict.
    pub verdict: VerdictKind,
    /// Id of the episode.
    pub episode_id: String,
    /// Drive.
    pub drive_id: DriveId,
    /// Class that mining gave.
    pub scenario_id: ScenarioId,
    /// Keyframe as mined, ns.
    pub keyframe_ns: i64,
    /// Score, 0 to 1.
    pub score: f64,
    /// The right class, of `wrong_leaf`, where it is known.
    #[serde(default)]
    pub right_scenario_id: Option<ScenarioId>,
    /// The right keyframe, of `keyframe_moved`, ns.
    #[serde(default)]
    pub right_keyframe_ns: Option<i64>,
}

impl VerdictLine {
    /// True where the class is right.
    pub fn is_right(&self) -> bool {
        matches!(self.verdict, VerdictKind::Right | VerdictKind::KeyframeMoved)
    }

    /// The class that is there by this verdict; `None` for no episode, and for another class that is not named.
    pub fn moment(&self) -> Option<AcceptedMoment> {
        let scenario = match self.verdict {
            VerdictKind::Right | VerdictKind::KeyframeMoved => self.scenario_id.clone(),
            VerdictKind::WrongLeaf => self.right_scenario_id.clone()?,
            VerdictKind::Nothing => return None,
        };
        let keyframe = Nanos(self.right_keyframe_ns.unwrap_or(self.keyframe_ns));
        Some(AcceptedMoment { drive: self.drive_id.clone(), scenario, keyframe })
    }
}

/// True where a file of JSON lines is an export of verdicts: its first line is a verdict.
pub fn is_export(text: &str) -> bool {
    let first = text.lines().find(|l| !l.trim().is_empty()).unwrap_or_default();
    serde_json::from_str::<serde_json::Value>(first).is_ok_and(|v| v.get("verdict").is_some())
}

/// Reads an export. A line that cannot be read is an error with its location and does not stop the rest.
pub fn read(text: &str, file: &str) -> (Vec<VerdictLine>, Vec<Diagnostic>) {
    let (mut out, mut problems) = (Vec::new(), Vec::new());
    for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        match serde_json::from_str(line) {
            Ok(verdict) => out.push(verdict),
            Err(e) => problems.push(
                Diagnostic::error(
                    "evaluate.verdicts.line",
                    Bilingual::new(
                        format!("该行不是判定记录，已跳过：{e}"),
                        format!("this line is not a verdict and is skipped: {e}"),
                    ),
                )
                .at(Location { line: Some(i + 1), column: Some(e.column().max(1)), ..Location::default() })
                .in_file(file),
            ),
        }
    }
    (out, problems)
}

/// How often episodes of a class are right.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ClassCalibration {
    /// Verdicts.
    pub judged: usize,
    /// Of these, with the right class.
    pub right: usize,
    /// Of the right ones, with a keyframe that was moved.
    pub keyframe_moved: usize,
    /// Share that is right.
    pub share: f64,
    /// Its 95 % interval (Wilson).
    pub interval: [f64; 2],
    /// Share that is right from a score on, never falling with the score (pool adjacent violators).
    pub steps: Vec<CalibrationStep>,
}

/// From this score up to that of the next step the share is this.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CalibrationStep {
    /// Least score.
    pub from_score: f64,
    /// Share that is right.
    pub share: f64,
    /// Verdicts in the step.
    pub judged: usize,
}

/// Calibration by class. Several verdicts on one episode all count: disagreement makes the share uncertain.
pub fn calibrate(verdicts: &[VerdictLine]) -> BTreeMap<ScenarioId, ClassCalibration> {
    let classes: BTreeSet<&ScenarioId> = verdicts.iter().map(|v| &v.scenario_id).collect();
    let one = |class: &ScenarioId| {
        let of: Vec<&VerdictLine> = verdicts.iter().filter(|v| v.scenario_id == *class).collect();
        let right = of.iter().filter(|v| v.is_right()).count();
        let pairs: Vec<(f64, bool)> = of.iter().map(|v| (v.score, v.is_right())).collect();
        ClassCalibration {
            judged: of.len(),
            right,
            keyframe_moved: of.iter().filter(|v| v.verdict == VerdictKind::KeyframeMoved).count(),
            share: right as f64 / of.len() as f64,
            interval: wilson(right, of.len()),
            steps: steps(pairs),
        }
    };
    classes.into_iter().map(|class| (class.clone(), one(class))).collect()
}

/// Isotonic regression of right on score.
fn steps(mut pairs: Vec<(f64, bool)>) -> Vec<CalibrationStep> {
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut blocks: Vec<Block> = Vec::new();
    for (from, is_right) in pairs {
        let right = usize::from(is_right);
        let sum = right as f64;
        match blocks.last_mut().filter(|b| b.from == from) {
            Some(same) => {
                (same.sum, same.weight) = (same.sum + sum, same.weight + 1.0);
                (same.right, same.judged) = (same.right + right, same.judged + 1);
            }
            None => blocks.push(Block { from, sum, weight: 1.0, right, judged: 1 }),
        }
    }
    let step = |b: Block| CalibrationStep { from_score: b.from, share: b.sum / b.weight, judged: b.judged };
    pooled(blocks).into_iter().map(step).collect()
}

/// The calibration as a table.
pub fn render(classes: &BTreeMap<ScenarioId, ClassCalibration>, lang: Lang) -> String {
    let zh = lang == Lang::Zh;
    let mut out = String::new();
    let head = if zh {
        ["场景", "判定", "正确", "95 % 区间", "关键帧移动", "按得分"]
    } else {
        ["class", "judged", "right", "95 % interval", "keyframe moved", "by score"]
    };
    let width = classes.keys().map(|id| id.to_string().len()).max().unwrap_or(0).max(head[0].len());
    let _ = writeln!(
        out,
        "{:<width$}  {:>6}  {:>6}  {:>14}  {:>14}  {}",
        head[0], head[1], head[2], head[3], head[4], head[5]
    );
    for (id, c) in classes {
        let steps: Vec<String> = c
            .steps
            .iter()
            .map(|s| format!("{:.2}: {:.0} % ({})", s.from_score, s.share * 100.0, s.judged))
            .collect();
        let _ = writeln!(
            out,
            "{:<width$}  {:>6}  {:>4.0} %  {:>5.0} to {:>3.0} %  {:>14}  {}",
            id.to_string(),
            c.judged,
            c.share * 100.0,
            c.interval[0] * 100.0,
            c.interval[1] * 100.0,
            c.keyframe_moved,
            steps.join(", ")
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(verdict: &str, score: f64, more: &str) -> String {
        format!(
            r#"{{"verdict": "{verdict}", "episode_id": "e", "drive_id": "d", "scenario_id": "a.b.c", "keyframe_ns": 5, "score": {score}, "by": "lea"{more}}}"#
        )
    }

    #[test]
    fn each_verdict_says_what_is_there() {
        let text = [
            line("right", 0.9, ""),
            line("wrong_leaf", 0.8, r#", "right_scenario_id": "a.b.d""#),
            line("wrong_leaf", 0.8, ""),
            line("nothing", 0.7, ""),
            line("keyframe_moved", 0.6, r#", "right_keyframe_ns": 9"#),
            "{\"verdict\": 3}".to_owned(),
        ]
        .join("\n");
        assert!(is_export(&text) && !is_export("{\"clip_id\": \"x\"}"));
        let (read, problems) = read(&text, "v.jsonl");
        assert_eq!((read.len(), problems.len()), (5, 1));
        assert_eq!(problems[0].location.line, Some(6));
        let there: Vec<Option<(String, i64)>> =
            read.iter().map(|v| v.moment().map(|m| (m.scenario.to_string(), m.keyframe.0))).collect();
        let moment = |class: &str, at: i64| Some((class.to_owned(), at));
        assert_eq!(there, [moment("a.b.c", 5), moment("a.b.d", 5), None, None, moment("a.b.c", 9)]);
        let c = &calibrate(&read)[&"a.b.c".parse().unwrap()];
        assert_eq!((c.judged, c.right, c.keyframe_moved), (5, 2, 1));
    }

    #[test]
    fn the_share_never_falls_with_the_score() {
        // By hand: 0.2 wrong; 0.4 right and 0.5 wrong pool to a half; 0.9 right twice.
        let of = steps(vec![(0.9, true), (0.2, false), (0.4, true), (0.5, false), (0.9, true)]);
        let told: Vec<(f64, f64, usize)> = of.iter().map(|s| (s.from_score, s.share, s.judged)).collect();
        assert_eq!(told, [(0.2, 0.0, 1), (0.4, 0.5, 2), (0.9, 1.0, 2)]);
        assert!(steps(vec![]).is_empty());
    }
}
