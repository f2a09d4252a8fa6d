//! Updates tasks and labels of a store when classes are renamed, merged or split. Originals stay in the history: each
//! changed task has an entry with its draft before and one with its draft after. A label that does not determine its
//! new class is returned to its author for rework, with the possible classes as the reason.

use crate::domain::workflow::{Position, State};
use crate::problem::Answer;
use crate::service::projects::json as stored;
use crate::service::tasks::{self, Entry, TaskRow};
use crate::service::{history, projects};
use crate::store::{Store, Tx};
use crate::values;
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_framework::mapping::{ClassChange, ClassMapping};
use whyroad_label::carry::{Carried, carry, class_of};
use whyroad_model::ScenarioId;

/// Tasks changed in one transaction.
const AT_ONCE: usize = 50;
/// Number of tasks read together.
const PAGE: i64 = 500;
/// The action's name in the history.
const ACTION: &str = "migrate";

/// Whether anything is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MigrationRun {
    /// Only reports the changes.
    Dry,
    /// Writes them.
    Write,
}

/// Changes of a store, made or planned.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MigratedStore {
    /// Number of tasks whose class has a new id, by class before and after.
    pub moved: BTreeMap<(String, String), u64>,
    /// Number of tasks of which only secondary classes changed.
    pub secondary: u64,
    /// Tasks whose label a person must decide.
    pub undecided: Vec<UndecidedTask>,
    /// Project settings that refer to a split class and were not changed: project, setting, class.
    pub left: Vec<(String, &'static str, String)>,
    /// Number of project settings that were updated.
    pub settings: u64,
}

/// A task that a person must decide.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UndecidedTask {
    /// Task.
    pub task: String,
    /// Project.
    pub project: String,
    /// Clip.
    pub clip: String,
    /// Class before.
    pub from: String,
    /// Classes to choose from.
    pub parts: Vec<String>,
    /// It was submitted, and is returned to its author.
    pub rework: bool,
}

/// Number of tasks of the store by class.
pub fn classes(store: &Store) -> Answer<BTreeMap<String, u64>> {
    let rows =
        store.read(|tx| tx.rows("SELECT scenario_id, count(*) AS n FROM tasks GROUP BY scenario_id", &[]))?;
    rows.iter().map(|r| Ok((r.text("scenario_id")?, r.int("n")?.unsigned_abs()))).collect()
}

/// Updates all projects of the store. Repeating it changes nothing.
pub fn migrate(store: &Store, mapping: &ClassMapping, run: MigrationRun, now: i64) -> Answer<MigratedStore> {
    let mut out = MigratedStore::default();
    for project in store.read(projects::all)? {
        settings(store, &project.id, mapping, run, &mut out)?;
        let mut after = String::new();
        loop {
            let ids = store.read(|tx| {
                let sql = "SELECT id FROM tasks WHERE project_id = $1 AND id > $2 ORDER BY id LIMIT $3";
                let rows = tx.rows(sql, values![&project.id, &after, PAGE])?;
                rows.iter().map(|r| r.text("id")).collect::<Answer<Vec<_>>>()
            })?;
            let Some(last) = ids.last().cloned() else { break };
            for part in ids.chunks(AT_ONCE) {
                let done = match run {
                    MigrationRun::Dry => store.read(|tx| some(tx, part, mapping, run, now))?,
                    MigrationRun::Write => {
                        let (part, mapping) = (part.to_vec(), mapping.clone());
                        store.write(move |tx| some(tx, &part, &mapping, run, now))?
                    }
                };
                for (classes, n) in done.moved {
                    *out.moved.entry(classes).or_default() += n;
                }
                out.undecided.extend(done.undecided);
            }
            after = last;
        }
    }
    Ok(out)
}

fn some(
    tx: &mut dyn Tx,
    ids: &[String],
    mapping: &ClassMapping,
    run: MigrationRun,
    now: i64,
) -> Answer<MigratedStore> {
    let mut out = MigratedStore::default();
    for id in ids {
        let t = match run {
            MigrationRun::Dry => tasks::get(tx, id)?,
            MigrationRun::Write => tasks::get_for_change(tx, id)?,
        };
        one(tx, t, mapping, run, now, &mut out)?;
    }
    Ok(out)
}

fn one(
    tx: &mut dyn Tx,
    mut t: TaskRow,
    mapping: &ClassMapping,
    run: MigrationRun,
    now: i64,
    out: &mut MigratedStore,
) -> Answer<()> {
    if was_done(tx, &t.id, mapping)? {
        return Ok(());
    }
    let before = t.clone();
    let draft = match carry(mapping, &mut t.draft) {
        // A task whose draft does not exist yet is updated by its class alone.
        Carried::Same if class_of(&t.draft).is_none() => {
            let ScenarioId { l1, l2, l3 } = &t.episode.scenario_id;
            carry(mapping, &mut json!({ "scenario": { "l1": l1, "l2": l2, "l3": l3 } }))
        }
        carried => carried,
    };
    let initial = carry(mapping, &mut t.initial);
    let of_task = mapping.change(&t.episode.scenario_id);
    let from = t.scenario_id.clone();
    // The mined class follows the class of the label if there is one.
    let class = match (&of_task, &draft) {
        (None, _) => t.episode.scenario_id.clone(),
        (Some(ClassChange::To(to)), _) => to.clone(),
        (
            Some(ClassChange::Split(_)),
            Carried::Moved { to, .. } | Carried::Undecided { to, .. } | Carried::Secondary { class: to },
        ) => to.clone(),
        (Some(ClassChange::Split(_)), Carried::Same) => t.episode.scenario_id.clone(),
    };
    if draft == Carried::Same && initial == Carried::Same && class == t.episode.scenario_id {
        return Ok(());
    }
    let handed_in = matches!(
        t.at.state,
        State::Submitted | State::InCheck | State::Rework | State::Checked | State::InAudit | State::Accepted
    );
    let (from, to) = match &draft {
        Carried::Moved { from, to } | Carried::Undecided { from, to, .. } => {
            (from.to_string(), to.to_string())
        }
        Carried::Secondary { class } => (class.to_string(), class.to_string()),
        Carried::Same => (from, class.to_string()),
    };
    let mut note = format!("{from} -> {to}; {} -> {} [{}]", mapping.from, mapping.to, mapping.mark);
    // A record that the new class requires is requested before a label is submitted.
    let undecided = match &draft {
        Carried::Undecided { to, parts, .. } if !handed_in && parts == std::slice::from_ref(to) => None,
        Carried::Undecided { from, parts, .. } => Some((from, parts)),
        Carried::Same | Carried::Moved { .. } | Carried::Secondary { .. } => None,
    };
    if let Some((from, parts)) = undecided {
        let parts: Vec<String> = parts.iter().map(ToString::to_string).collect();
        note = format!("{note}: {}", parts.join(" | "));
        out.undecided.push(UndecidedTask {
            task: t.id.clone(),
            project: t.project.clone(),
            clip: t.clip_id.clone(),
            from: from.to_string(),
            parts,
            rework: handed_in,
        });
        if handed_in && t.at.state != State::Rework {
            t.at = Position {
                state: State::Rework,
                holder: None,
                checker: None,
                auditor: None,
                checked: false,
                authors: t.at.authors.clone(),
            };
            t.lease_until = None;
            t.audited = false;
        }
    } else if from == to {
        out.secondary += 1;
    } else {
        *out.moved.entry((from, to)).or_default() += 1;
    }
    if run == MigrationRun::Dry {
        return Ok(());
    }
    t.version += 1;
    keep_original(tx, &mut t, &before, now)?;
    let after = t.draft.clone();
    let entry = Entry {
        action: ACTION,
        from: Some(before.at.state),
        snapshot: Some(&after),
        note: Some(&note),
        ..Entry::default()
    };
    history::record(tx, &mut t, &entry, now)?;
    tasks::update(tx, &t)?;
    put_class(tx, &t, &class)
}

/// Stores the complete suggestion and draft before the change in the history, so that all earlier data is kept.
fn keep_original(tx: &mut dyn Tx, t: &mut TaskRow, before: &TaskRow, now: i64) -> Answer<()> {
    let of = format!("{}; {}", before.scenario_id, before.episode.episode_id);
    for (snapshot, note) in [(&before.initial, format!("suggestion; {of}")), (&before.draft, of.clone())] {
        t.seq += 1;
        let state = before.at.state.word();
        tx.run(
            "INSERT INTO history (task_id, seq, at, actor, action, from_state, to_state, snapshot, note, version)
             VALUES ($1, $2, $3, NULL, 'before_migration', $4, $5, $6, $7, $8)",
            values![&t.id, t.seq, now, state, state, stored(snapshot)?, &note, before.version],
        )?;
    }
    Ok(())
}

/// True when the history states that this mapping was applied to the task.
fn was_done(tx: &mut dyn Tx, id: &str, mapping: &ClassMapping) -> Answer<bool> {
    let sql = "SELECT 1 FROM history WHERE task_id = $1 AND action = $2 AND note LIKE $3 LIMIT 1";
    Ok(tx.row(sql, values![id, ACTION, format!("%[{}]%", mapping.mark)])?.is_some())
}

/// Updates the class of the task and of its episode. The episode's id contains its class, so that the same episode is
/// recognized when it is mined again; if another episode already has that id, the old one is kept.
fn put_class(tx: &mut dyn Tx, t: &TaskRow, class: &ScenarioId) -> Answer<()> {
    let mut episode = t.episode.clone();
    let (old, new) = (format!("_{}_", episode.scenario_id), format!("_{class}_"));
    let id = episode.episode_id.replacen(&old, &new, 1);
    let taken = tx.row(
        "SELECT 1 FROM tasks WHERE project_id = $1 AND episode_id = $2 AND overlap_index = $3 AND id <> $4 LIMIT 1",
        values![&t.project, &id, t.overlap_index, &t.id],
    )?;
    if taken.is_none() {
        episode.episode_id = id;
    }
    episode.scenario_id = class.clone();
    tx.run(
        "UPDATE tasks SET scenario_id = $1, episode = $2, episode_id = $3, initial = $4 WHERE id = $5",
        values![class.to_string(), stored(&episode)?, &episode.episode_id, stored(&t.initial)?, &t.id],
    )?;
    Ok(())
}

/// Quotas and skills: those of merged classes are added up; the quota of a split class is kept, because it cannot be
/// divided automatically, and its skill covers all parts.
fn settings(
    store: &Store,
    project: &str,
    mapping: &ClassMapping,
    run: MigrationRun,
    out: &mut MigratedStore,
) -> Answer<()> {
    let (mut p, members) =
        store.read(|tx| Ok((projects::get(tx, project)?, projects::members(tx, project)?)))?;
    let mut quota: BTreeMap<String, u32> = BTreeMap::new();
    for (leaf, n) in &p.quota {
        let to = match leaf.parse().ok().and_then(|id: ScenarioId| mapping.change(&id)) {
            Some(ClassChange::To(to)) => {
                out.settings += 1;
                to.to_string()
            }
            Some(ClassChange::Split(parts)) if !parts.iter().any(|p| p.to.to_string() == *leaf) => {
                out.left.push((p.name.clone(), "quota", leaf.clone()));
                leaf.clone()
            }
            _ => leaf.clone(),
        };
        let sum = quota.entry(to).or_default();
        *sum = sum.saturating_add(*n);
    }
    let mut skills: Vec<(String, Vec<String>)> = Vec::new();
    for member in &members {
        let carried: BTreeSet<String> = member.skills.iter().flat_map(|s| skill(s, mapping)).collect();
        let own: BTreeSet<String> = member.skills.iter().cloned().collect();
        if carried != own {
            out.settings += 1;
            skills.push((member.user.id.clone(), carried.into_iter().collect()));
        }
    }
    if run == MigrationRun::Dry || (quota == p.quota && skills.is_empty()) {
        return Ok(());
    }
    p.quota = quota;
    let project = project.to_owned();
    store.write(move |tx| {
        projects::update(tx, &p)?;
        for (user, skills) in &skills {
            let sql = "UPDATE members SET skills = $1 WHERE project_id = $2 AND user_id = $3";
            tx.run(sql, values![stored(skills)?, &project, user])?;
        }
        Ok(())
    })
}

fn skill(skill: &str, mapping: &ClassMapping) -> Vec<String> {
    match skill.parse().ok().and_then(|id: ScenarioId| mapping.change(&id)) {
        Some(ClassChange::To(to)) => vec![to.to_string()],
        Some(ClassChange::Split(parts)) => parts.iter().map(|p| p.to.to_string()).collect(),
        None => vec![skill.to_owned()],
    }
}
