//! Leases: who has a task in hands, for minutes, with a fencing token that makes an older hold void. A lease that ran out
//! still lets its holder write until somebody else takes the task: then the newer token stands in the way.

use crate::api::wire::project::{Project, Settings};
use crate::api::wire::task::{Kind, Lease};
use crate::problem::{Answer, Problem};
use crate::service::tasks::{self, Entry, TaskRow};
use crate::store::{Tx, Value as Cell};
use crate::workflow::{self, Action, Actor, Draw, Role, State};
use crate::{service::projects, values};
use serde_json::json;

/// Candidates of the queue that are looked at in one go.
const PAGE: usize = 100;

/// The lease of `t` for whom it concerns.
pub fn lease(t: &TaskRow) -> Lease {
    Lease { fence: t.fence, lease_until: t.lease_until, state: t.at.state }
}

/// Takes `t`: refused while another has a live lease. Whoever begins Stage I anew begins with the suggestion, not with
/// somebody else's words.
pub fn take(tx: &mut dyn Tx, t: &mut TaskRow, actor: &Actor, settings: &Settings, now: i64) -> Answer<()> {
    let live = t.lease_until.is_some_and(|until| until > now);
    if live && t.at.holder.as_deref().is_some_and(|h| h != actor.id) {
        return Err(Problem::new(
            409,
            "lease.held",
            "该任务正由他人处理",
            "somebody else has this task in hands",
        )
        .with(json!({ "lease_until": t.lease_until })));
    }
    if t.adjudication.as_deref() == Some("superseded") {
        return Err(Problem::new(409, "task.superseded", "已选用另一份标注", "another label was chosen"));
    }
    if t.at.state == State::Open && t.assigned.as_deref().is_some_and(|a| a != actor.id) {
        return Err(Problem::new(
            403,
            "task.assigned",
            "该任务已指派给他人",
            "this task was given to somebody else",
        ));
    }
    let next = workflow::step(&t.at, actor, Action::Take, Draw::Pass)?;
    if matches!(t.at.state, State::Open | State::Stage1) {
        only_one_of_a_group(tx, t, &actor.id)?;
    }
    let others = matches!(t.at.state, State::Open | State::Stage1)
        && t.at.author().is_some_and(|a| a != actor.id)
        && t.draft != t.initial;
    let from = t.at.state;
    t.at = next;
    t.fence += 1;
    renew(t, settings, now);
    if t.at.state.shows_future() {
        tasks::show_future(tx, t, &actor.id)?;
    }
    if others {
        t.draft = t.initial.clone();
        t.version += 1;
    }
    let snapshot = others.then(|| t.draft.clone());
    let entry = Entry {
        action: "take",
        actor: Some(&actor.id),
        from: Some(from),
        snapshot: snapshot.as_ref(),
        ..Entry::default()
    };
    tasks::record(tx, t, &entry, now)?;
    tasks::update(tx, t)
}

/// Blind overlap: nobody labels the same episode twice.
fn only_one_of_a_group(tx: &mut dyn Tx, t: &TaskRow, user: &str) -> Answer<()> {
    if t.overlap_count < 2 {
        return Ok(());
    }
    let other = tx.row(
        "SELECT 1 FROM tasks WHERE project_id = $1 AND episode_id = $2 AND id <> $3 AND authors LIKE $4 LIMIT 1",
        values![&t.project, &t.episode.episode_id, &t.id, format!("%\"{user}\"%")],
    )?;
    if other.is_some() {
        return Err(Problem::new(
            403,
            "task.overlap_twice",
            "您已标注过同一片段的另一份",
            "you label another copy of this episode: each is for a different person",
        ));
    }
    Ok(())
}

fn renew(t: &mut TaskRow, settings: &Settings, now: i64) {
    t.lease_until = Some(now + i64::from(settings.lease_s) * 1000);
}

/// Lets only the holder with the newest token through.
pub fn held(t: &TaskRow, user: &str, fence: Option<i64>) -> Answer<()> {
    let Some(fence) = fence else { return Err(Problem::request("fence is missing")) };
    if t.at.holder.as_deref() == Some(user) && t.fence == fence { Ok(()) } else { Err(Problem::lease_lost()) }
}

/// Keeps the lease. It is written only when a fifth of it is gone: heartbeats are many.
pub fn keep(tx: &mut dyn Tx, t: &mut TaskRow, settings: &Settings, now: i64) -> Answer<()> {
    let fresh = i64::from(settings.lease_s) * 800;
    if t.lease_until.is_some_and(|until| until - now > fresh && until - now <= fresh * 5 / 4) {
        return Ok(());
    }
    renew(t, settings, now);
    tasks::update(tx, t)
}

/// Makes the lease last from now, without writing it.
pub fn extend(t: &mut TaskRow, settings: &Settings, now: i64) -> i64 {
    renew(t, settings, now);
    t.lease_until.unwrap_or(now)
}

/// Gives the task back.
pub fn release(tx: &mut dyn Tx, t: &mut TaskRow, actor: &Actor, now: i64) -> Answer<()> {
    let from = t.at.state;
    t.at = workflow::step(&t.at, actor, Action::Release, Draw::Pass)?;
    t.lease_until = None;
    let entry = Entry { action: "release", actor: Some(&actor.id), from: Some(from), ..Entry::default() };
    tasks::record(tx, t, &entry, now)?;
    tasks::update(tx, t)
}

/// Takes the next task of the queue for `user`: their own unfinished ones first, then what was given to them, then what
/// is free, by priority, age and time in the drive.
pub fn next(
    tx: &mut dyn Tx,
    project: &Project,
    user: &crate::api::wire::people::User,
    roles: &[Role],
    kind: Kind,
    now: i64,
) -> Answer<Option<TaskRow>> {
    let skills = projects::skills(tx, &project.id, &user.id)?;
    for condition in queue(kind) {
        let mut from = 0;
        loop {
            let found = candidates(tx, condition, &project.id, user, now, from)?;
            for (id, scenario) in &found {
                let own = condition.contains("holder = $2") || condition.contains("assigned = $2");
                if !own && !fits(scenario, &skills) {
                    continue;
                }
                let mut t = tasks::get_for_change(tx, id)?;
                let actor = tasks::actor(tx, &t, &user.id, roles, project.settings.history)?;
                match take(tx, &mut t, &actor, &project.settings, now) {
                    Ok(()) => return Ok(Some(t)),
                    Err(e) if e.status < 500 => {}
                    Err(e) => return Err(e),
                }
            }
            if found.len() < PAGE {
                break;
            }
            from += PAGE;
        }
    }
    Ok(None)
}

/// What each kind of work looks through, in this order; free tasks by one state at a time, so that the index gives them in
/// order. `$2` is the user, `$3` now, `$4` the user's language; all are in each, as PostgreSQL wants it.
fn queue(kind: Kind) -> &'static [&'static str] {
    match kind {
        Kind::Label => &[
            "holder = $2 AND state IN ('stage1', 'stage2', 'rework') AND CAST($3 AS BIGINT) >= 0 AND $4 <> ''",
            "author = $2 AND state IN ('rework', 'stage1_locked', 'stage2') AND CAST($3 AS BIGINT) >= 0 AND $4 <> ''",
            "assigned = $2 AND state = 'open' AND CAST($3 AS BIGINT) >= 0 AND $4 <> ''",
            "state = 'open' AND assigned IS NULL AND (lang = '' OR lang = $4) AND $2 <> '' AND CAST($3 AS BIGINT) >= 0",
            "state = 'stage1' AND lease_until < $3 AND assigned IS NULL AND (lang = '' OR lang = $4) AND $2 <> ''",
        ],
        Kind::Check => &[
            "holder = $2 AND state = 'in_check' AND CAST($3 AS BIGINT) >= 0 AND $4 <> ''",
            "state = 'submitted' AND author <> $2 AND (adjudication IS NULL OR adjudication = 'chosen')
             AND (lang = '' OR lang = $4) AND CAST($3 AS BIGINT) >= 0",
            "state = 'in_check' AND lease_until < $3 AND author <> $2 AND (adjudication IS NULL OR adjudication = 'chosen')
             AND (lang = '' OR lang = $4)",
        ],
        Kind::Audit => &[
            "holder = $2 AND state = 'in_audit' AND CAST($3 AS BIGINT) >= 0 AND $4 <> ''",
            "state = 'checked' AND author <> $2 AND checker <> $2 AND (lang = '' OR lang = $4)
             AND CAST($3 AS BIGINT) >= 0",
            "state = 'in_audit' AND lease_until < $3 AND author <> $2 AND checker <> $2 AND (lang = '' OR lang = $4)",
        ],
    }
}

fn candidates(
    tx: &mut dyn Tx,
    condition: &str,
    project: &str,
    user: &crate::api::wire::people::User,
    now: i64,
    from: usize,
) -> Answer<Vec<(String, String)>> {
    let sql = format!(
        "SELECT id, scenario_id FROM tasks WHERE project_id = $1 AND {condition}
         ORDER BY priority DESC, created, overlap_index, keyframe_ns, id LIMIT {PAGE} OFFSET {from}"
    );
    let values: [Cell; 4] = [project.into(), (&user.id).into(), now.into(), (&user.lang).into()];
    tx.rows(&sql, &values)?.iter().map(|r| Ok((r.text(0)?, r.text(1)?))).collect()
}

/// True when a class is among the skills, which are full ids or their first parts; no skills are all.
fn fits(scenario: &str, skills: &[String]) -> bool {
    let within = |skill: &String| scenario == skill || scenario.starts_with(&format!("{skill}."));
    skills.is_empty() || skills.iter().any(within)
}
