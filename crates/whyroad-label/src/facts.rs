//! Facts about the work on one label: its class, what people changed of the draft, when its state changed, how long
//! they worked. Computed from a task and its history; the label itself is left out, so that a hundred thousand of them
//! fit into memory. This module does not access a store.

mod revision;

pub use revision::{Revision, revision};

use crate::episode_of::is_made;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::label_fields::pointer;
use whyroad_model::{DriveId, Nanos, ScenarioId};

/// Progress of a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LabelStage {
    /// Not submitted yet.
    Waiting,
    /// Submitted: with a checker or auditor, or returned to its author for rework.
    Labelled,
    /// Accepted.
    Accepted,
    /// Skipped or rejected: there will be no label.
    LeftOut,
}

/// The judgement of a person about an episode; `None` is "no change of decision".
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Judgement {
    /// Class.
    pub scenario: Option<ScenarioId>,
    /// Longitudinal decision.
    pub longitudinal: Option<Longitudinal>,
    /// Lateral decision.
    pub lateral: Option<Lateral>,
    /// Its side, where the lateral decision has one.
    pub lateral_direction: Option<LateralDirection>,
    /// Keyframe, nanoseconds since 1970.
    pub keyframe: Option<Nanos>,
}

impl Judgement {
    /// The judgement in a label that was submitted, and so was checked.
    pub fn of(label: &Value) -> Self {
        let word = |at: &str| label.pointer(at).and_then(Value::as_str);
        let part = |name: &str| word(&format!("{}/{name}", pointer::SCENARIO)).map(str::to_owned);
        let scenario = part("l1").zip(part("l2"));
        Self {
            scenario: scenario.map(|(l1, l2)| ScenarioId { l1, l2: Some(l2), l3: part("l3") }),
            longitudinal: word(pointer::DRIVING_DECISION_LONGITUDINAL).and_then(Longitudinal::from_id),
            lateral: word(pointer::DRIVING_DECISION_LATERAL).and_then(Lateral::from_id),
            lateral_direction: word(pointer::DRIVING_DECISION_LATERAL_DIRECTION)
                .and_then(LateralDirection::from_id),
            keyframe: word(pointer::KEYFRAME_TIMESTAMP).and_then(|t| Nanos::parse_iso(t).ok()),
        }
    }
}

/// Summary of one task of the labeling service.
#[derive(Clone, Debug, PartialEq)]
pub struct TaskFacts {
    /// Id of the task.
    pub task: String,
    /// Id of its episode.
    pub episode: String,
    /// Drive.
    pub drive: DriveId,
    /// Class that mining gave.
    pub scenario: ScenarioId,
    /// Keyframe that mining gave.
    pub keyframe: Nanos,
    /// Progress of the label.
    pub stage: LabelStage,
    /// Another label of its overlap group was chosen.
    pub superseded: bool,
    /// Display name of the author.
    pub author: Option<String>,
    /// The current label; set once it is submitted.
    pub label: Option<Judgement>,
    /// The label as first submitted, for tasks that several people label.
    pub first: Option<Judgement>,
    /// Changes from the draft to the accepted label; only of accepted ones.
    pub revision: Option<Revision>,
    /// When it was created.
    pub created: Nanos,
    /// When it was first submitted.
    pub submitted: Option<Nanos>,
    /// When it was last accepted, of accepted ones.
    pub accepted: Option<Nanos>,
    /// How often a checker or auditor returned it.
    pub returned: u32,
    /// Time that people worked on it, s ([`worked_s()`]).
    pub worked_s: f64,
}

impl TaskFacts {
    /// Whether somebody still has to do something with this task before its label is accepted or left out. A label of
    /// which the lead chose another one is in no state that anybody waits for: the tasks counted by state in the
    /// service are these, the accepted ones and those left out.
    pub fn is_unfinished(&self) -> bool {
        !self.superseded && matches!(self.stage, LabelStage::Waiting | LabelStage::Labelled)
    }

    /// Whether its label was accepted and is the one that stands for its episode.
    pub fn is_accepted(&self) -> bool {
        !self.superseded && self.stage == LabelStage::Accepted
    }
}

/// The tasks with one episode for each moment and class: a task of a label that was imported without its episode is of
/// the known episode of its moment, a mined one, else the first of those made from a label.
pub fn with_known_episodes(tasks: &[TaskFacts]) -> Vec<TaskFacts> {
    let mut known: BTreeMap<(&DriveId, &ScenarioId, Nanos), &str> = BTreeMap::new();
    for t in tasks {
        let held = known.entry((&t.drive, &t.scenario, t.keyframe)).or_insert(&t.episode);
        if (is_made(&t.episode), t.episode.as_str()) < (is_made(held), *held) {
            *held = &t.episode;
        }
    }
    let episode = |t: &TaskFacts| match known.get(&(&t.drive, &t.scenario, t.keyframe)) {
        Some(known) if is_made(&t.episode) => (*known).to_owned(),
        _ => t.episode.clone(),
    };
    tasks.iter().map(|t| TaskFacts { episode: episode(t), ..t.clone() }).collect()
}

/// Episodes on the way to an accepted label: with an unfinished task, and without an accepted label. Several people may
/// label an episode; it needs one accepted label.
pub fn unfinished_episodes(tasks: &[TaskFacts]) -> BTreeSet<&str> {
    let accepted: BTreeSet<&str> =
        tasks.iter().filter(|t| t.is_accepted()).map(|t| t.episode.as_str()).collect();
    let unfinished = tasks.iter().filter(|t| t.is_unfinished()).map(|t| t.episode.as_str());
    unfinished.filter(|e| !accepted.contains(e)).collect()
}

/// Summary of one entry of a task's history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// When, ms since 1970.
    pub at_ms: i64,
    /// Who; `None` for the command line.
    pub actor: Option<String>,
    /// `take`, `edit`, `submit`, ...
    pub action: String,
}

/// Maximum time counted for a pause between two entries, s: reading without saving is work, up to this.
pub const LONGEST_PAUSE_S: f64 = 300.0;

/// Actions by which the task leaves the hands of whoever has it; every other entry is one of work in progress.
const PASSING_ON: [&str; 7] = ["release", "submit", "accept", "send_back", "skip", "reject", "reopen"];

/// Time that people worked on a task, s: between consecutive entries of its history by one person, from taking the task
/// to passing it on, where each pause counts [`LONGEST_PAUSE_S`] at most.
pub fn worked_s(steps: &[Step]) -> f64 {
    let (mut holder, mut last, mut total): (Option<&str>, Option<&Step>, f64) = (None, None, 0.0);
    for step in steps {
        let actor = step.actor.as_deref();
        if let Some(before) =
            last.filter(|b| actor.is_some() && actor == holder && actor == b.actor.as_deref())
        {
            let pause = (step.at_ms - before.at_ms).max(0) as f64 / 1000.0;
            total += pause.min(LONGEST_PAUSE_S);
        }
        match step.action.as_str() {
            "take" => holder = actor,
            action if PASSING_ON.contains(&action) => holder = None,
            _ => {}
        }
        last = Some(step);
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(seconds: i64, actor: &str, action: &str) -> Step {
        Step { at_ms: seconds * 1000, actor: Some(actor.into()), action: action.into() }
    }

    #[test]
    fn work_is_between_taking_and_handing_on() {
        // Computed by hand: 40 s + 20 s of Ada; the hour until Ben takes it counts for nobody; 30 s of Ben.
        let steps = [
            step(0, "ada", "take"),
            step(40, "ada", "edit"),
            step(60, "ada", "submit"),
            step(3660, "ben", "take"),
            step(3690, "ben", "accept"),
        ];
        assert!((worked_s(&steps) - 90.0).abs() < 1e-9);
    }

    /// docs/reference/analytics.md: from taking it to passing it on. By hand: 2 s to the lock, 3 s to the answer of the
    /// safety filter, 40 s of watching Stage II; the entry of another person in between belongs to nobody's pause.
    #[test]
    fn time_after_the_answer_of_the_safety_filter_is_work() {
        let steps = [
            step(0, "kit", "take"),
            step(2, "kit", "lock_stage1"),
            step(5, "kit", "safety"),
            step(45, "kit", "submit"),
            step(50, "lea", "assign"),
            step(60, "lea", "assign"),
            step(70, "cai", "take"),
            step(80, "cai", "judge"),
            step(100, "cai", "send_back"),
            step(110, "cai", "judge"),
        ];
        assert!((worked_s(&steps) - (45.0 + 30.0)).abs() < 1e-9, "{}", worked_s(&steps));
    }

    #[test]
    fn a_long_pause_counts_five_minutes_and_a_release_ends_the_work() {
        let pause = [step(0, "ada", "take"), step(4000, "ada", "submit")];
        assert!((worked_s(&pause) - LONGEST_PAUSE_S).abs() < 1e-9);
        let released = [step(0, "ada", "take"), step(10, "ada", "release"), step(60, "ada", "take")];
        assert!((worked_s(&released) - 10.0).abs() < 1e-9);
        // A clock that was set back does not reduce the time.
        assert!(worked_s(&[step(60, "ada", "take"), step(0, "ada", "edit")]).abs() < 1e-9);
        assert!(worked_s(&[]).abs() < 1e-9);
    }
}
