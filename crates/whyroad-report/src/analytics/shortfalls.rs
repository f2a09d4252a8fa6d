//! Shortfalls, the next action, and the query that mines them.

use super::Unseen;
use super::input::AnalyticsInputs;
use super::outlook::hours_for;
use super::stages::StageRow;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_label::facts::unfinished_episodes;
use whyroad_model::messages::{CoverageState, MiningQueryMessage};
use whyroad_model::{Bilingual, ScenarioId};

/// Next action for a shortfall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ShortfallStep {
    /// Mine more drives.
    MineMore,
    /// Make tasks from episodes that are already mined.
    MakeTasks,
    /// Finish the existing tasks.
    Label,
    /// No drive can show it: ingest drives with the signals that its rule needs.
    OtherDrives,
    /// Write a rule.
    WriteRule,
    /// Labels are missing; without a mined folder it is unknown whether episodes are missing too.
    Unknown,
}

impl ShortfallStep {
    /// Its id.
    pub fn id(self) -> &'static str {
        match self {
            Self::OtherDrives => "other_drives",
            Self::WriteRule => "write_rule",
            Self::MineMore => "mine_more",
            Self::MakeTasks => "make_tasks",
            Self::Label => "label",
            Self::Unknown => "unknown",
        }
    }

    /// Displayed name of the action.
    pub fn text(self) -> Bilingual {
        let (zh, en) = match self {
            Self::OtherDrives => ("导入具备所需信号的行程", "ingest drives with the missing signals"),
            Self::WriteRule => ("编写规则", "write a rule"),
            Self::MineMore => ("挖掘更多行程", "mine more drives"),
            Self::MakeTasks => ("用已挖掘的事件建任务", "make tasks from mined episodes"),
            Self::Label => ("完成已有任务", "finish the tasks"),
            Self::Unknown => ("未提供挖掘结果", "no mined folder given"),
        };
        Bilingual::new(zh, en)
    }
}

/// A leaf with a shortfall.
#[derive(Clone, Debug, Serialize)]
pub struct Shortfall {
    /// The leaf.
    pub scenario_id: ScenarioId,
    /// Its name.
    pub name: Bilingual,
    /// Required accepted labels; `None` where no target is set and nothing of the leaf was ever found.
    pub wanted: Option<u64>,
    /// Accepted labels.
    pub accepted: Option<u64>,
    /// Episodes with a task on the way to a label.
    pub in_progress: Option<u64>,
    /// Mined episodes without a task.
    pub untasked: Option<u64>,
    /// Episodes that still have to be mined.
    pub missing: Option<u64>,
    /// Expected hours of driving for that number, from the rate so far; `None` without a find.
    pub hours: Option<f64>,
    /// Next action.
    pub step: ShortfallStep,
    /// The query that finds more; `None` where no rule finds the class.
    pub query: Option<MiningQueryMessage>,
}

/// Requested episodes of a leaf that was never found and has no target.
const FIRST: u64 = 10;

pub(super) fn of(
    stages: &[StageRow],
    unseen: Option<&Unseen>,
    inputs: &AnalyticsInputs<'_>,
) -> Vec<Shortfall> {
    let mut in_progress: BTreeMap<&ScenarioId, BTreeSet<&str>> = BTreeMap::new();
    let tasks = inputs.tasks.unwrap_or_default();
    let unfinished = unfinished_episodes(tasks);
    for t in tasks {
        if t.is_unfinished() && unfinished.contains(t.episode.as_str()) {
            let class = t.label.as_ref().and_then(|l| l.scenario.as_ref()).unwrap_or(&t.scenario);
            in_progress.entry(class).or_default().insert(&t.episode);
        }
    }
    let leaves = stages.iter().filter(|s| s.scenario_id.is_leaf() && s.in_taxonomy);
    let mut out: Vec<Shortfall> = leaves
        .filter_map(|row| {
            let on_the_way =
                inputs.tasks.map(|_| in_progress.get(&row.scenario_id).map_or(0, |e| e.len() as u64));
            one(row, on_the_way, unseen, inputs)
        })
        .collect();
    // Actions that are possible now first, then by the size of the shortfall, then in tree order.
    out.sort_by_key(|s| (s.step, std::cmp::Reverse(s.missing.or(s.wanted))));
    out
}

/// Whether there is anything of the leaf: an episode, primary or secondary, a label, or a task on the way to one.
fn was_found(row: &StageRow, in_progress: Option<u64>) -> bool {
    let counts = &row.counts;
    let any = [counts.mined, row.secondary, counts.labelled, counts.accepted, counts.released, in_progress];
    any.into_iter().flatten().any(|n| n > 0)
}

fn one(
    row: &StageRow,
    in_progress: Option<u64>,
    unseen: Option<&Unseen>,
    inputs: &AnalyticsInputs<'_>,
) -> Option<Shortfall> {
    let have = row.counts.accepted.or(row.counts.released);
    let short = match (row.wanted, have) {
        (Some(wanted), Some(have)) => Some(wanted.saturating_sub(have)).filter(|n| *n > 0)?,
        (Some(wanted), None) => wanted,
        // Without a target, a leaf without a find is still a shortfall.
        (None, _) if row.state.is_some() && !was_found(row, in_progress) => FIRST,
        (None, _) => return None,
    };
    let untasked = row.counts.mined.map(|n| n.saturating_sub(row.counts.tasked.unwrap_or(0)));
    let left = short.saturating_sub(in_progress.unwrap_or(0));
    let missing = untasked.map(|n| left.saturating_sub(n));
    let step = match row.state {
        _ if left == 0 => ShortfallStep::Label,
        Some(CoverageState::NotObservable) if row.counts.mined.is_none() => ShortfallStep::OtherDrives,
        Some(CoverageState::NoRule) if row.counts.mined.is_none() => ShortfallStep::WriteRule,
        None => ShortfallStep::Unknown,
        _ if missing == Some(0) => ShortfallStep::MakeTasks,
        _ => ShortfallStep::MineMore,
    };
    let missing = missing.or((left > 0).then_some(left));
    let seen = unseen.and_then(|u| u.leaves.iter().find(|l| l.scenario_id == row.scenario_id));
    let asked = matches!(step, ShortfallStep::MineMore | ShortfallStep::OtherDrives | ShortfallStep::Unknown);
    let count = usize::try_from(missing.unwrap_or(left)).unwrap_or(usize::MAX);
    Some(Shortfall {
        scenario_id: row.scenario_id.clone(),
        name: row.name.clone(),
        wanted: row.wanted,
        accepted: row.counts.accepted,
        in_progress,
        untasked,
        missing: Some(missing.unwrap_or(0)).filter(|_| row.wanted.is_some()),
        hours: seen
            .filter(|_| asked && row.wanted.is_some())
            .and_then(|s| hours_for(missing?, s.episodes, s.hours)),
        step,
        query: if asked && count > 0 { (inputs.query)(&row.scenario_id, count) } else { None },
    })
}
