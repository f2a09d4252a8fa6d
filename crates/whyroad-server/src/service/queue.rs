//! The queue: the next task for a user, and the reasons if there is none.

use crate::domain::people::User;
use crate::domain::project::Project;
use crate::domain::task::{QueueReason, WorkKind};
use crate::domain::workflow::{Role, State};
use crate::problem::Answer;
use crate::service::recognized::Hidden;
use crate::service::tasks::TaskRow;
use crate::service::{disagreement, leases, projects, seen, tasks};
use crate::store::{Tx, Value as Cell};
use crate::values;
use std::collections::BTreeSet;

/// A gold task is given only to its annotator.
const FOR_ME: &str = "NOT EXISTS (SELECT 1 FROM gold g WHERE g.task_id = tasks.id AND g.user_id <> $2)";

/// Number of candidates that are read together.
const PAGE: usize = 100;
/// Maximum number of waiting tasks that are examined for reasons.
const MOST_ASKED: i64 = 1000;

/// The user of the queue.
struct Worker<'a> {
    user: &'a User,
    roles: &'a [Role],
    /// Classes; empty for all.
    skills: Vec<String>,
    /// At least one.
    languages: Vec<String>,
}

impl<'a> Worker<'a> {
    fn of(tx: &mut dyn Tx, project: &Project, user: &'a User, roles: &'a [Role]) -> Answer<Self> {
        let skills = projects::skills(tx, &project.id, &user.id)?;
        let mut languages = projects::languages(tx, &project.id, &user.id)?;
        if languages.is_empty() {
            languages.push(user.lang.clone());
        }
        Ok(Self { user, roles, skills, languages })
    }

    /// True when a class is among the skills, which are full ids or prefixes of them.
    fn labels(&self, scenario: &str) -> bool {
        let within = |skill: &String| scenario == skill || scenario.starts_with(&format!("{skill}."));
        self.skills.is_empty() || self.skills.iter().any(within)
    }

    /// The parameters of the searches of [`queue`].
    fn values(&self, project: &Project, now: i64) -> [Cell; 4] {
        [(&project.id).into(), (&self.user.id).into(), now.into(), self.languages.join(",").into()]
    }

    fn writes(&self, lang: &str) -> bool {
        lang.is_empty() || self.languages.iter().any(|l| l == lang)
    }
}

/// Takes the next task of the queue for `user`: their own unfinished ones first, then assigned ones, then free ones, by
/// priority, age and time in the drive.
pub fn next(
    tx: &mut dyn Tx,
    project: &Project,
    user: &User,
    roles: &[Role],
    kind: WorkKind,
    now: i64,
) -> Answer<Option<TaskRow>> {
    let worker = Worker::of(tx, project, user, roles)?;
    let hidden = Hidden::of(tx, &project.id, &user.id, roles)?.ids;
    for condition in conditions(kind, project) {
        let mut from = 0;
        loop {
            let found = candidates(tx, &condition, project, &worker, now, from)?;
            for (id, scenario) in &found {
                if (!is_own(&condition) && !worker.labels(scenario)) || hidden.contains(id) {
                    continue;
                }
                let mut t = tasks::get_for_change(tx, id)?;
                let actor = seen::actor(tx, &t, &user.id, roles, project.settings.history)?;
                match leases::take(tx, &mut t, &actor, &project.settings, now) {
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

/// Number of tasks of this kind that [`next`] has for `user`, of the first thousand.
pub fn takeable(
    tx: &mut dyn Tx,
    project: &Project,
    user: &User,
    roles: &[Role],
    kind: WorkKind,
    now: i64,
) -> Answer<i64> {
    let worker = Worker::of(tx, project, user, roles)?;
    let hidden = Hidden::of(tx, &project.id, &user.id, roles)?.ids;
    let mut n = 0;
    for condition in conditions(kind, project) {
        // Only what the decision needs is read: drafts are long.
        let sql = format!(
            "SELECT id, scenario_id, authors FROM tasks WHERE project_id = $1 AND {condition} AND {} LIMIT {MOST_ASKED}",
            seen::hidden_in_stage1(project.settings.history).replace('$', "$2")
        );
        let is_own = is_own(&condition);
        for row in tx.rows(&sql, &worker.values(project, now))? {
            let wrote = row.text("authors")?.contains(&format!("\"{}\"", user.id));
            let fits = is_own || (worker.labels(&row.text("scenario_id")?) && !wrote);
            n += i64::from(fits && !hidden.contains(&row.text("id")?));
        }
    }
    Ok(n)
}

/// Why the queue has nothing for `user`: each reason that applies to some task, without numbers of tasks, which might
/// reveal how many episodes a drive has. Empty if there is a task after all.
pub fn why_nothing(
    tx: &mut dyn Tx,
    project: &Project,
    user: &User,
    roles: &[Role],
    kind: WorkKind,
    now: i64,
) -> Answer<BTreeSet<QueueReason>> {
    let (role, states) = match kind {
        WorkKind::Label => (Role::Annotator, "'open', 'stage1'"),
        WorkKind::Check => (Role::Checker, "'submitted', 'in_check'"),
        WorkKind::Audit => (Role::Auditor, "'checked', 'in_audit'"),
    };
    if !roles.contains(&role) {
        return Ok([QueueReason::Role].into());
    }
    let worker = Worker::of(tx, project, user, roles)?;
    let sql = format!(
        "project_id = $1 AND state IN ({states}) AND ({FOR_ME} OR state IN ('submitted', 'in_check', 'checked', 'in_audit'))
         AND (adjudication IS NULL OR adjudication = 'chosen')
         ORDER BY id LIMIT {MOST_ASKED}"
    );
    let mut waiting = tasks::select(tx, &sql, values![&project.id, &user.id])?;
    let hidden = Hidden::of(tx, &project.id, &user.id, roles)?.ids;
    waiting.retain(|t| !hidden.contains(&t.id));
    if waiting.is_empty() {
        let any = tx.row("SELECT 1 FROM tasks WHERE project_id = $1 LIMIT 1", values![&project.id])?;
        return Ok([if any.is_some() { QueueReason::Finished } else { QueueReason::NoTasks }].into());
    }
    let mut reasons = BTreeSet::new();
    for t in waiting {
        match why_not(tx, &t, project, &worker, now)? {
            Some(reason) => drop(reasons.insert(reason)),
            None => return Ok(BTreeSet::new()),
        }
    }
    Ok(reasons)
}

/// Why the queue does not give `t` to `user`; `None` if it would. The first reason that applies, permanent ones first.
fn why_not(
    tx: &mut dyn Tx,
    t: &TaskRow,
    project: &Project,
    worker: &Worker<'_>,
    now: i64,
) -> Answer<Option<QueueReason>> {
    let Worker { user, roles, .. } = worker;
    let mine =
        t.assigned.as_deref() == Some(user.id.as_str()) || t.at.holder.as_deref() == Some(user.id.as_str());
    let beginning = matches!(t.at.state, State::Open | State::Stage1);
    if beginning && t.assigned.as_deref().is_some_and(|a| a != user.id) {
        return Ok(Some(QueueReason::Assigned));
    }
    if !mine && !worker.writes(&t.lang) {
        return Ok(Some(QueueReason::Language));
    }
    if !mine && !worker.labels(&t.episode.scenario_id.to_string()) {
        return Ok(Some(QueueReason::Classes));
    }
    let actor = seen::actor(tx, t, &user.id, roles, project.settings.history)?;
    match leases::may_take(tx, t, &actor, &project.settings, now) {
        Ok(_) => Ok(None),
        Err(p) if p.status >= 500 => Err(p),
        Err(p) => Ok(Some(match p.code {
            "lease.held" => QueueReason::Held,
            "task.future_seen" => QueueReason::FutureSeen,
            "task.overlap_twice" => QueueReason::OverlapTwice,
            "task.own_work" => QueueReason::OwnWork,
            "task.own_check" => QueueReason::OwnCheck,
            leases::NOT_CHOSEN => QueueReason::NotChosen,
            "task.stage1_first" => QueueReason::Stage1First,
            _ => QueueReason::Other,
        })),
    }
}

/// The searches of each kind of work, in this order; free tasks by one state at a time, so that the index gives them in
/// order. `EXPIRED` stands for an expired lease, `STANDS` for a label that may be checked, `$2` is the user, `$3` now,
/// `$4` the worker's languages (`zh,en`), which must contain a task's language if it has one, and `FOR_ME` excludes
/// copies for other annotators; each search contains all parameters, as PostgreSQL requires.
fn queue(kind: WorkKind) -> &'static [&'static str] {
    match kind {
        WorkKind::Label => &[
            "holder = $2 AND state IN ('stage1', 'stage2', 'rework') AND CAST($3 AS BIGINT) >= 0 AND $4 <> ''",
            "author = $2 AND state IN ('rework', 'stage1_locked', 'stage2') AND CAST($3 AS BIGINT) >= 0 AND $4 <> ''",
            "assigned = $2 AND state = 'open' AND CAST($3 AS BIGINT) >= 0 AND $4 <> ''",
            "state = 'open' AND assigned IS NULL AND $4 LIKE '%' || lang || '%' AND FOR_ME AND CAST($3 AS BIGINT) >= 0",
            "state = 'stage1' AND EXPIRED AND assigned IS NULL AND $4 LIKE '%' || lang || '%' AND FOR_ME",
        ],
        WorkKind::Check => &[
            "holder = $2 AND state = 'in_check' AND CAST($3 AS BIGINT) >= 0 AND $4 <> ''",
            "state = 'submitted' AND author <> $2 AND STANDS AND $4 LIKE '%' || lang || '%' AND CAST($3 AS BIGINT) >= 0",
            "state = 'in_check' AND EXPIRED AND author <> $2 AND STANDS AND $4 LIKE '%' || lang || '%'",
        ],
        WorkKind::Audit => &[
            "holder = $2 AND state = 'in_audit' AND CAST($3 AS BIGINT) >= 0 AND $4 <> ''",
            "state = 'checked' AND author <> $2 AND checker <> $2 AND STANDS AND $4 LIKE '%' || lang || '%'
             AND CAST($3 AS BIGINT) >= 0",
            "state = 'in_audit' AND EXPIRED AND author <> $2 AND checker <> $2 AND STANDS AND $4 LIKE '%' || lang || '%'",
        ],
    }
}

/// The searches of [`queue`] as SQL.
fn conditions(kind: WorkKind, project: &Project) -> Vec<String> {
    // A remaining time longer than any lease is from before a clock was set back.
    let lease = leases::longest_ms(&project.settings);
    let expired = format!("(lease_until < $3 OR lease_until - $3 > {lease})");
    let condition = |c: &&str| {
        c.replace("EXPIRED", &expired).replace("FOR_ME", FOR_ME).replace("STANDS", disagreement::STANDS)
    };
    queue(kind).iter().map(condition).collect()
}

/// A search for tasks that the worker holds or was assigned: of any class.
fn is_own(condition: &str) -> bool {
    condition.contains("holder = $2") || condition.contains("assigned = $2")
}

fn candidates(
    tx: &mut dyn Tx,
    condition: &str,
    project: &Project,
    worker: &Worker<'_>,
    now: i64,
    from: usize,
) -> Answer<Vec<(String, String)>> {
    let sql = format!(
        "SELECT id, scenario_id FROM tasks WHERE project_id = $1 AND {condition}
         ORDER BY priority DESC, created, overlap_index, keyframe_ns, id LIMIT {PAGE} OFFSET {from}"
    );
    tx.rows(&sql, &worker.values(project, now))?
        .iter()
        .map(|r| Ok((r.text("id")?, r.text("scenario_id")?)))
        .collect()
}
