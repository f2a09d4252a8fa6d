//! Tasks of another class than the one that mining gave their episode: where an annotator says that the class does not
//! fit, and where no class explains the episode. They begin without the rule's text: no rule found them.

use crate::app::App;
use crate::domain::project::Project;
use crate::domain::task::Created;
use crate::domain::workflow::{self, Action, Actor, Draw, State};
use crate::problem::{Answer, Problem};
use crate::secret;
use crate::service::tasks::{self, Entry, TaskRow};
use crate::service::{copies, create, disagreement, history};
use crate::store::Tx;
use crate::values;
use whyroad_framework::Framework;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Bilingual, ScenarioId};

/// SQL condition for tasks whose class does not fit, as their annotators say, and that nothing replaces.
pub const WAITING: &str =
    "right_class IS NOT NULL AND replaced_by IS NULL AND state IN ('skipped', 'rejected')";

/// A class of the taxonomy.
pub fn class(framework: &Framework, id: &str) -> Answer<ScenarioId> {
    let found = id.parse::<ScenarioId>().ok().filter(|c| framework.taxonomy.contains(c));
    found.ok_or_else(|| {
        Problem::request(format!("'{id}' 不是场景分类"), format!("'{id}' is not a class of the taxonomy"))
    })
}

/// `episode` as one of the class `id`: an L3, or an L2 whose variant is not known. What the rule of another class found
/// in it is left out.
pub fn episode_as(framework: &Framework, episode: &EpisodeRecord, id: &str) -> Answer<EpisodeRecord> {
    let scenario_id = class(framework, id)?;
    let Some(spec) = create::spec_of(framework, &scenario_id) else {
        return Err(Problem::request(
            format!("'{id}' 不是可标注的 L2 或 L3 场景"),
            format!("'{id}' is not an L2 or L3 class that can be labeled"),
        ));
    };
    let mut keyframe = episode.keyframe.clone();
    keyframe.kind = spec.keyframe.kind;
    (keyframe.range_start, keyframe.range_end) = (None, None);
    Ok(EpisodeRecord {
        episode_id: copies::as_class(&episode.episode_id, id),
        scenario_id,
        keyframe,
        keyframe_rule: Bilingual::new(
            format!("由人改为此场景；原为 {}", episode.scenario_id),
            format!("of this class as a person says; mined as {}", episode.scenario_id),
        ),
        second_keyframe: None,
        roles: Default::default(),
        conditions_matched: vec![],
        is_primary: true,
        primary_episode_id: None,
        ego_response: None,
        margin_score: None,
        calibrated: None,
        rule_version: None,
        ..episode.clone()
    })
}

/// Stores `row`, a new task for an episode, `copies` times; the answer is empty if its episode has tasks already.
pub fn store(tx: &mut dyn Tx, row: &TaskRow, copies: i64, actor: &str, now: i64) -> Answer<Created> {
    let mut made = Created::default();
    for index in 0..copies {
        let t = TaskRow { id: secret::id()?, overlap_index: index, overlap_count: copies, ..row.clone() };
        let id = t.id.clone();
        if create::store(tx, t, Some(actor), now)? {
            made.tasks.push(id);
        }
    }
    made.known = u32::from(made.tasks.is_empty());
    Ok(made)
}

/// A task in place of `t`, of another class, that is not stored yet.
pub fn prepare(app: &App, project: &Project, t: &TaskRow, id: &str) -> Answer<TaskRow> {
    if t.scenario_id == id {
        return Err(Problem::new(422, "class.same", "该任务已是此场景", "the task is of this class already"));
    }
    let episode = episode_as(app.framework, &t.episode, id)?;
    let row = create::undrafted(app, project, &episode, &t.lang)?;
    Ok(TaskRow { priority: t.priority, replaces: Some(t.id.clone()), ..row })
}

/// Stores `row` for each annotator of the episode of the task `id`, and closes the tasks that it replaces.
pub fn replace(tx: &mut dyn Tx, id: &str, row: &TaskRow, actor: &Actor, now: i64) -> Answer<Created> {
    let t = tasks::get_for_change(tx, id)?;
    if t.replaced_by.is_some() {
        return Err(Problem::new(
            409,
            "task.replaced",
            "该任务已由另一场景的任务取代",
            "a task of another class replaces this one already",
        ));
    }
    let made = store(tx, row, t.overlap_count, &actor.id, now)?;
    if made.tasks.is_empty() {
        return Err(Problem::new(
            409,
            "task.exists",
            "该事件已有此场景的任务",
            "the episode has a task of this class already",
        ));
    }
    for (other, new) in tasks::group(tx, &t.project, &t.episode.episode_id)?.iter().zip(&made.tasks) {
        let mut old = tasks::get_for_change(tx, &other.id)?;
        let from = old.at.state;
        if !matches!(from, State::Skipped | State::Rejected) {
            old.at = workflow::step(&old.at, actor, Action::Skip, Draw::Pass)?;
            old.lease_until = None;
        }
        // The class is not told to those who may label the new task: its name may reveal the outcome.
        old.replaced_by = Some(new.clone());
        let entry = Entry { action: "replace", actor: Some(&actor.id), from: Some(from), ..Entry::default() };
        history::record(tx, &mut old, &entry, now)?;
        tasks::update(tx, &old)?;
        // The question of the annotator is answered.
        tx.run("UPDATE comments SET resolved = 1 WHERE task_id = $1 AND to_lead = 1", values![&old.id])?;
    }
    if t.overlap_count > 1 {
        disagreement::note(tx, &t.project, &t.episode.episode_id)?;
    }
    Ok(made)
}
