//! Truth files: JSON Lines. The first line may state for which classes and drives the truth is complete,
//! `{"complete": [class ids], "drives": [drive ids]}`; every other line is one entry,
//! `{"scenario_id", "drive_id", "target_id"?, "start_ns", "keyframe_ns", "end_ns", "optional"?, "reason"?}`, with times
//! in nanoseconds since the Unix epoch (the drive's own clock) and a half-open range.

use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeSet;
use whyroad_framework::json_text;
use whyroad_model::{Bilingual, Diagnostic, DriveId, Location, Nanos, ScenarioId, TrackId};

/// An event.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TruthEntry {
    /// Leaf, or L2 where the variant is not known.
    pub scenario_id: ScenarioId,
    /// Drive.
    pub drive_id: DriveId,
    /// Target; absent without one, or where any matches.
    #[serde(default)]
    pub target_id: Option<TrackId>,
    /// Start of the time range.
    #[serde(deserialize_with = "nanos")]
    pub start_ns: Nanos,
    /// The keyframe.
    #[serde(deserialize_with = "nanos")]
    pub keyframe_ns: Nanos,
    /// End of the time range, not included.
    #[serde(deserialize_with = "nanos")]
    pub end_ns: Nanos,
    /// The definition does not decide it (a threshold is just met or just missed): it does not count, whether found or
    /// not.
    #[serde(default)]
    pub optional: bool,
    /// Reason for the entry, for readers.
    #[serde(default)]
    pub reason: Option<String>,
}

/// For these classes, any episode found on these drives beyond the truth is false.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Complete {
    /// Leaves, or L2 or L1 for all below.
    pub classes: BTreeSet<ScenarioId>,
    /// Drives.
    pub drives: BTreeSet<DriveId>,
}

/// Contents of one or more truth files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TruthSet {
    /// One per file that declares it.
    pub complete: Vec<Complete>,
    /// In the order of the files.
    pub entries: Vec<TruthEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    complete: Vec<ScenarioId>,
    drives: Vec<DriveId>,
}

fn nanos<'de, D: serde::Deserializer<'de>>(d: D) -> Result<Nanos, D::Error> {
    i64::deserialize(d).map(Nanos)
}

impl TruthSet {
    /// True where the truth of a class is declared complete on a drive.
    pub fn is_complete(&self, class: &ScenarioId, drive: &DriveId) -> bool {
        let holds = |c: &Complete| c.drives.contains(drive) && c.classes.iter().any(|k| class.is_within(k));
        self.complete.iter().any(holds)
    }

    /// Adds the entries of `text`; a line that cannot be read is an error with its location and does not stop the rest.
    /// Class ids that `is_class` does not know are errors too: a typo must not become a class that is never found.
    pub fn read(
        &mut self,
        text: &str,
        file: &str,
        is_class: &dyn Fn(&ScenarioId) -> bool,
    ) -> Vec<Diagnostic> {
        let mut problems = Vec::new();
        let mut first = true;
        for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
            let place = Location { line: Some(i + 1), ..Location::default() };
            let mut refuse = |why: Bilingual, column: Option<usize>| {
                problems.push(
                    Diagnostic::error("evaluate.truth.line", why)
                        .with_hint(Bilingual::new(
                            r#"每行一条：{"scenario_id", "drive_id", "target_id"?, "start_ns", "keyframe_ns", "end_ns", "optional"?}"#,
                            r#"one entry per line: {"scenario_id", "drive_id", "target_id"?, "start_ns", "keyframe_ns", "end_ns", "optional"?}"#,
                        ))
                        .at(Location { column, ..place.clone() })
                        .in_file(file),
                );
            };
            if std::mem::take(&mut first)
                && let Ok(header) = serde_json::from_str::<Header>(line)
            {
                for class in header.complete.iter().filter(|c| !is_class(c)) {
                    refuse(unknown(class), None);
                }
                self.complete.push(Complete {
                    classes: header.complete.into_iter().filter(is_class).collect(),
                    drives: header.drives.into_iter().collect(),
                });
                continue;
            }
            match serde_json::from_str::<TruthEntry>(line) {
                Err(_) if is_sequence(line) => problems.push(
                    Diagnostic::error(
                        "evaluate.truth.line",
                        Bilingual::new(
                            "该行是场景挖掘挑战赛的序列，不是真值记录，已跳过",
                            "this line is a sequence of the scenario-mining challenge, not an entry of a truth file, and \
                             is skipped",
                        ),
                    )
                    .with_hint(Bilingual::new(
                        "序列文件只能与序列比较：用 --predictions 指定预测的序列，代替 --episodes",
                        "a file of sequences is compared with sequences: name those of the predictions with \
                         --predictions, instead of --episodes",
                    ))
                    .at(Location { column: Some(1), ..place.clone() })
                    .in_file(file),
                ),
                Err(e) => refuse(
                    Bilingual::new(
                        format!("该行不是真值记录，已跳过：{}", json_text::message(line, &e).zh),
                        format!(
                            "this line is not an entry of a truth file and is skipped: {}",
                            json_text::message(line, &e).en
                        ),
                    ),
                    Some(e.column().max(1)),
                ),
                Ok(e) if !is_class(&e.scenario_id) => refuse(unknown(&e.scenario_id), None),
                Ok(e) if !(e.start_ns <= e.keyframe_ns && e.keyframe_ns <= e.end_ns) => refuse(
                    Bilingual::new(
                        "关键帧不在起止时间之内，已跳过",
                        "the keyframe is not between start and end; the entry is left out",
                    ),
                    None,
                ),
                Ok(e) => self.entries.push(e),
            }
        }
        problems
    }
}

/// The keys of a [`super::scenario_mining::sequence::Sequence`].
fn is_sequence(line: &str) -> bool {
    #[derive(Deserialize)]
    struct Keys {
        #[serde(rename = "log_id")]
        _log_id: IgnoredAny,
        #[serde(rename = "prompt")]
        _prompt: IgnoredAny,
        #[serde(rename = "frames")]
        _frames: IgnoredAny,
    }
    serde_json::from_str::<Keys>(line).is_ok()
}

fn unknown(class: &ScenarioId) -> Bilingual {
    Bilingual::new(
        format!("分类体系中没有 '{class}'，已跳过"),
        format!("class '{class}' not found in the taxonomy; the entry is left out"),
    )
}
