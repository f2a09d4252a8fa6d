//! Moments that no class explains (`other`): grouped by similarity, each group with the nearest classes. It shows the
//! framework's owner which rule to review, or which class is missing. Nothing here finds moments or compares them: both
//! are passed in.

mod page;
mod text;

pub use page::page;
pub use text::{ego as render_ego, moment as render_moment, render};

use serde::Serialize;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::{Bilingual, ClipId, DriveId, Lang, Nanos, ScenarioId, TrackId};

/// Maximum number of classes listed for a group.
pub const LISTED_CLASSES: usize = 3;

/// A moment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnexplainedMoment {
    /// Id of its episode of `other`.
    pub episode_id: String,
    /// Drive.
    pub drive_id: DriveId,
    /// Clip that its keyframe is in.
    pub clip_id: ClipId,
    /// The keyframe.
    pub keyframe: Nanos,
    /// Seconds from the start of the drive to it.
    pub keyframe_s: f64,
    /// Seconds from the start of the clip to it, as `explain` counts.
    pub clip_s: f64,
    /// Speed of the ego there, m/s; absent where unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ego_speed_mps: Option<f64>,
    /// The ego's action from there on, by the signals `ego.meta_longitudinal` and `ego.meta_lateral`; empty where
    /// unknown.
    pub ego_actions: Vec<String>,
    /// Displayed names of these.
    pub ego_action_names: Vec<Bilingual>,
    /// Nearest classes, the nearest first.
    pub nearest: Vec<NearestClass>,
    /// Classes that the drive cannot show and that nothing known speaks against, the likeliest first.
    pub undecided: Vec<UndecidedClass>,
}

/// A class that would be possible if the drive had all signals of its rule.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UndecidedClass {
    /// The class.
    pub scenario_id: ScenarioId,
    /// Conditions that are known to hold together.
    pub held: usize,
    /// Conditions that must hold together.
    pub conditions: usize,
    /// The target for which they hold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_id: Option<TrackId>,
    /// Signals that its rule needs and the drive lacks.
    pub missing_signals: Vec<String>,
    /// Displayed names of these.
    pub missing_names: Vec<Bilingual>,
}

/// A class whose conditions a moment nearly meets.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NearestClass {
    /// The class.
    pub scenario_id: ScenarioId,
    /// Conditions that hold together.
    pub held: usize,
    /// Conditions that do not hold, or are unknown.
    pub failed: usize,
    /// All conditions of its rule. Those that are neither held nor failed are checked only after a match.
    pub conditions: usize,
    /// The target for which they hold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_id: Option<TrackId>,
    /// Seconds from the moment's keyframe to the frame at which the conditions were counted and measured.
    pub offset_s: f64,
    /// Those that do not hold.
    pub unmet: Vec<UnmetPart>,
}

/// A condition that does not hold.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnmetPart {
    /// As written.
    pub condition: String,
    /// In words.
    pub description: Bilingual,
    /// The measured value, in `unit`; null where it is unknown.
    pub actual_value: Value,
    /// The same as text, with its unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actual_words: Option<Bilingual>,
    /// Symbol of the unit.
    pub unit: String,
    /// It is unknown whether it holds.
    pub is_unknown: bool,
}

/// Moments that resemble one another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnexplainedGroup {
    /// The moment that resembles most of them.
    pub example: UnexplainedMoment,
    /// Number of moments.
    pub moments: usize,
    /// Number of drives.
    pub drives: usize,
    /// Classes that are among the nearest of most of its moments, with that number; at most [`LISTED_CLASSES`].
    pub nearest: Vec<(ScenarioId, usize)>,
    /// Ids of the episodes.
    pub episode_ids: Vec<String>,
}

/// All of them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Unexplained {
    /// Number of moments.
    pub moments: usize,
    /// Number of drives with such a moment.
    pub drives: usize,
    /// The largest first, then by example.
    pub groups: Vec<UnexplainedGroup>,
    /// Displayed names of the classes.
    pub names: BTreeMap<ScenarioId, Bilingual>,
}

impl Unexplained {
    /// Moments by groups: the index of each group's example, and those of its members; `name` says what a class is
    /// called.
    pub fn new(
        moments: &[UnexplainedMoment],
        groups: &[(usize, Vec<usize>)],
        name: impl Fn(&ScenarioId) -> Bilingual,
    ) -> Self {
        let drives = |of: &[usize]| of.iter().map(|&m| &moments[m].drive_id).collect::<BTreeSet<_>>().len();
        let mut out = Self {
            moments: moments.len(),
            drives: drives(&(0..moments.len()).collect::<Vec<_>>()),
            groups: Vec::with_capacity(groups.len()),
            names: BTreeMap::new(),
        };
        let near = moments.iter().flat_map(|m| &m.nearest).map(|near| &near.scenario_id);
        let open = moments.iter().flat_map(|m| &m.undecided).map(|open| &open.scenario_id);
        out.names.extend(near.chain(open).map(|id| (id.clone(), name(id))));
        for (example, members) in groups {
            out.groups.push(UnexplainedGroup {
                example: moments[*example].clone(),
                moments: members.len(),
                drives: drives(members),
                nearest: most_often_near(members.iter().map(|&m| &moments[m])),
                episode_ids: members.iter().map(|&m| moments[m].episode_id.clone()).collect(),
            });
        }
        out.groups.sort_by(|a, b| {
            let by_size = b.moments.cmp(&a.moments).then(b.drives.cmp(&a.drives));
            by_size.then_with(|| a.example.episode_id.cmp(&b.example.episode_id))
        });
        out
    }
}

impl Unexplained {
    /// Displayed name of a class; its id where it has no name.
    fn name(&self, id: &ScenarioId, lang: Lang) -> String {
        self.names.get(id).map_or_else(|| id.to_string(), |name| name.get(lang).to_owned())
    }
}

/// The classes that are near most of these moments; of equals, those that are nearer.
fn most_often_near<'a>(moments: impl Iterator<Item = &'a UnexplainedMoment>) -> Vec<(ScenarioId, usize)> {
    let mut counts: BTreeMap<&ScenarioId, (usize, usize)> = BTreeMap::new();
    for moment in moments {
        for (place, class) in moment.nearest.iter().take(LISTED_CLASSES).enumerate() {
            let known = counts.entry(&class.scenario_id).or_default();
            *known = (known.0 + 1, known.1 + place);
        }
    }
    let mut all: Vec<_> = counts.into_iter().collect();
    all.sort_by(|(a, (n, place)), (b, (m, other))| m.cmp(n).then(place.cmp(other)).then(a.cmp(b)));
    all.into_iter().take(LISTED_CLASSES).map(|(id, (n, _))| (id.clone(), n)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(drive: &str, at: f64, nearest: &[&str]) -> UnexplainedMoment {
        let near = |id: &&str| NearestClass {
            offset_s: 0.0,
            scenario_id: id.parse().unwrap(),
            held: 4,
            failed: 1,
            conditions: 6,
            target_id: None,
            unmet: vec![UnmetPart {
                condition: "target.ttc < 5 s".into(),
                description: Bilingual::new("与目标的碰撞时间 < 5 s", "Time to collision < 5 s"),
                actual_value: serde_json::json!(6.25),
                actual_words: Some(Bilingual::same("6.25 s")),
                unit: "s".into(),
                is_unknown: false,
            }],
        };
        UnexplainedMoment {
            episode_id: format!("{drive}_000_other_ego_{at:03}"),
            drive_id: drive.into(),
            clip_id: ClipId(format!("{drive}_000")),
            keyframe: Nanos::from_secs_f64(at),
            keyframe_s: at,
            clip_s: at,
            ego_speed_mps: Some(8.0),
            ego_actions: vec!["gentle_decelerate".into()],
            ego_action_names: vec![Bilingual::new("轻减速", "gentle deceleration")],
            nearest: nearest.iter().map(near).collect(),
            undecided: vec![UndecidedClass {
                scenario_id: "r.light.red".parse().unwrap(),
                held: 2,
                conditions: 3,
                target_id: None,
                missing_signals: vec!["light.state".into()],
                missing_names: vec![Bilingual::new("信号灯状态", "state of the light")],
            }],
        }
    }

    #[test]
    fn groups_are_listed_by_size_with_the_classes_near_most_of_them() {
        let moments = [
            moment("a", 1.0, &["r.x.p"]),
            moment("a", 9.0, &["r.x.q", "r.x.p"]),
            moment("b", 3.0, &["r.y.z"]),
        ];
        let found = Unexplained::new(&moments, &[(2, vec![2]), (1, vec![0, 1])], |id| {
            let l3 = id.l3.clone().unwrap_or_default();
            Bilingual::new(format!("类别 {l3}"), format!("Class {l3}"))
        });
        assert_eq!((found.moments, found.drives), (3, 2));
        let first = &found.groups[0];
        assert_eq!((first.moments, first.drives, first.example.keyframe_s), (2, 1, 9.0));
        let names: Vec<(String, usize)> = first.nearest.iter().map(|(id, n)| (id.to_string(), *n)).collect();
        assert_eq!(names, [("r.x.p".to_owned(), 2), ("r.x.q".to_owned(), 1)]);
        let text = render(&found, Lang::En);
        // On a terminal the ids are input for the next command; on a page they are not needed.
        let of_p = "Class p (r.x.p): 4 of 6 conditions hold, 1 does not, 1 is checked after a match";
        assert!(text.contains(of_p) && text.contains("< 5 s (is 6.25 s)"), "{text}");
        let open = "cannot be ruled out: Class red (r.light.red): 2 of 3 conditions hold, the rest is unknown; \
                    missing: state of the light";
        assert!(text.contains(open), "{text}");
        let html = page(&found, &[], Lang::Zh);
        assert!(html.contains("类别 z：") && html.contains("碰撞时间 &lt; 5 s（实际 6.25 s）"), "{html}");
        assert!(html.contains("信号灯状态"), "{html}");
        for id in ["gentle_decelerate", "target.ttc", "light.state"] {
            assert!(!html.contains(id) && !text.contains(id), "{id}: {html}{text}");
        }
        assert!(render(&Unexplained::default(), Lang::En).contains("every decision moment is explained"));
    }
}
