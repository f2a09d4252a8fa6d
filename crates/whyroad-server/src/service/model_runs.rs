//! Runs of a language model in the store: starting and stopping them, their tasks, their cost. A service works on a run
//! while it holds a lease on it ([`claim`], [`keep`]), so that several services on one store do not ask the same
//! questions, and a run continues after a restart.

use crate::app::App;
use crate::domain::model::{ModelRun, ModelRunFailure, ModelRunKind, ModelRunState, ModelWork, NewModelRun};
use crate::domain::people::User;
use crate::domain::workflow::Role;
use crate::problem::{Answer, Problem};
use crate::secret;
use crate::service::judgements::HANDED_IN;
use crate::service::projects::{json, parse};
use crate::service::veil;
use crate::store::{Row, Tx};
use crate::values;
use whyroad_model::{Bilingual, ModelSpent};

pub mod waiting;

/// Time after which a run whose lease was not renewed is taken over, ms.
const LEASE_MS: i64 = 20_000;
/// Maximum number of tasks in one request.
const MOST_TASKS: usize = 500;
/// During a run, waiting tasks of the other kind are counted at most once in this time, ms.
const COUNT_MS: i64 = 10_000;
/// Number of runs and failures that are shown.
const SHOWN_RUNS: i64 = 10;
const SHOWN_FAILURES: i64 = 20;

/// Tasks that nobody has started: neither now nor before they were reopened.
pub const UNBEGUN: &str =
    "state = 'open' AND author IS NULL AND holder IS NULL AND NOT EXISTS (SELECT 1 FROM history h
    WHERE h.task_id = tasks.id AND h.action = 'take')";
/// Of these, the ones that no model has drafted.
const UNDRAFTED: &str =
    "NOT EXISTS (SELECT 1 FROM history h WHERE h.task_id = tasks.id AND h.action = 'model_draft')";
/// Labels that no model has judged in their current form.
const UNJUDGED: &str = "NOT EXISTS (SELECT 1 FROM judgements j WHERE j.task_id = tasks.id AND j.judge = ''
    AND j.version = tasks.version)";

/// Conditions for tasks of a run of `kind`, and for those that wait for it.
fn conditions(kind: ModelRunKind) -> (String, &'static str) {
    match kind {
        ModelRunKind::Draft => (UNBEGUN.to_owned(), UNDRAFTED),
        ModelRunKind::Judge => {
            let states = HANDED_IN.map(|state| format!("'{}'", state.word())).join(", ");
            (format!("state IN ({states})"), UNJUDGED)
        }
    }
}

/// Number of tasks of `project` that wait for a run: reads every task.
fn count_waiting(tx: &mut dyn Tx, project: &str, kind: ModelRunKind) -> Answer<i64> {
    let (takes, waits) = conditions(kind);
    let sql = format!("SELECT count(*) AS n FROM tasks WHERE project_id = $1 AND {takes} AND {waits}");
    tx.row(&sql, values![project])?.map_or(Ok(0), |r| r.int("n"))
}

/// Number of tasks of a run that were not tried yet.
fn in_run(tx: &mut dyn Tx, run: &str) -> Answer<i64> {
    let sql = "SELECT count(*) AS n FROM model_run_tasks WHERE run_id = $1 AND state = 'waiting'";
    tx.row(sql, values![run])?.map_or(Ok(0), |r| r.int("n"))
}

/// The model and its work in `project`, for a user with `roles` there.
pub fn work(app: &App, tx: &mut dyn Tx, project: &str, roles: &[Role]) -> Answer<ModelWork> {
    let open =
        tx.rows("SELECT id, kind FROM model_runs WHERE project_id = $1 AND ended IS NULL", values![project])?;
    let mut waiting = |kind: ModelRunKind| {
        for row in &open {
            if row.text("kind")? == kind.word() {
                return in_run(tx, &row.text("id")?);
            }
        }
        // The page requests this every two seconds during a run.
        let last = app.waiting_for_model.get(project, kind).filter(|_| !open.is_empty());
        let now = app.now();
        match last.filter(|(at, _)| (*at..at + COUNT_MS).contains(&now)) {
            Some((_, n)) => Ok(n),
            None => {
                let n = count_waiting(tx, project, kind)?;
                app.waiting_for_model.put(project, kind, (now, n));
                Ok(n)
            }
        }
    };
    let (to_draft, to_judge) = (waiting(ModelRunKind::Draft)?, waiting(ModelRunKind::Judge)?);
    let sql =
        format!("SELECT {COLUMNS} FROM model_runs WHERE project_id = $1 ORDER BY started DESC, id LIMIT $2");
    let rows = tx.rows(&sql, values![project, SHOWN_RUNS])?;
    let runs = rows.iter().map(|row| shown(tx, row, roles)).collect::<Answer<_>>()?;
    Ok(ModelWork { model: app.model.as_ref().map(|m| m.name().to_owned()), to_draft, to_judge, runs })
}

const COLUMNS: &str = "id, project_id, kind, state, model, actor, started, ended, spent, note,
    (SELECT u.display FROM users u WHERE u.id = model_runs.actor) AS display";

fn shown(tx: &mut dyn Tx, row: &Row, roles: &[Role]) -> Answer<ModelRun> {
    let (id, project) = (row.text("id")?, row.text("project_id")?);
    let counted = tx.rows(
        "SELECT state, count(*) AS n FROM model_run_tasks WHERE run_id = $1 GROUP BY state",
        values![&id],
    )?;
    let (mut total, mut done, mut failed, mut left_out) = (0, 0, 0, 0);
    for r in counted {
        let n = r.int("n")?;
        total += n;
        match r.text("state")?.as_str() {
            "done" => done = n,
            "failed" => failed = n,
            "left_out" => left_out = n,
            _ => {}
        }
    }
    let (kind, state) = (row.text("kind")?, row.text("state")?);
    Ok(ModelRun {
        kind: ModelRunKind::from_word(&kind).ok_or_else(|| Problem::store(format!("run '{kind}'")))?,
        state: ModelRunState::from_word(&state).ok_or_else(|| Problem::store(format!("run '{state}'")))?,
        model: row.text("model")?,
        by: row.maybe_text("display")?.unwrap_or(row.text("actor")?),
        started: row.int("started")?,
        ended: row.maybe_int("ended")?,
        total,
        done,
        failed,
        left_out,
        spent: parse(&row.text("spent")?)?,
        note: row.maybe_text("note")?.map(|n| parse(&n)).transpose()?,
        failures: if failed > 0 { failures(tx, &id, &project, roles)? } else { vec![] },
        id,
    })
}

/// Failed tasks and reasons. A reason may reveal the future of a task, so it is withheld from users who may still do
/// Stage I.
fn failures(tx: &mut dyn Tx, run: &str, project: &str, roles: &[Role]) -> Answer<Vec<ModelRunFailure>> {
    let class = veil::shown_class_sql(&veil::of(tx, project)?);
    let sql = format!(
        "SELECT id, {class} AS shown_class, state, f.note AS note FROM tasks
         JOIN (SELECT m.task_id, m.note FROM model_run_tasks m WHERE m.run_id = $1 AND m.state = 'failed') f
           ON f.task_id = tasks.id ORDER BY id LIMIT $2"
    );
    let rows = tx.rows(&sql, values![run, SHOWN_FAILURES])?;
    let labels = roles.contains(&Role::Annotator);
    let one = |r: &Row| {
        let hidden =
            labels && matches!(r.text("state")?.as_str(), "open" | "stage1" | "skipped" | "rejected");
        let text = match r.maybe_text("note")? {
            _ if hidden => Bilingual::new("阶段一锁定后显示", "shown once Stage I is locked"),
            Some(note) => parse(&note)?,
            None => Bilingual::default(),
        };
        Ok(ModelRunFailure { task: r.text("id")?, scenario_id: r.text("shown_class")?, text })
    };
    rows.iter().map(one).collect()
}

/// Starts a run, which is processed in the background.
pub fn start(
    app: &App,
    tx: &mut dyn Tx,
    project: &str,
    (user, roles): (&User, &[Role]),
    wanted: &NewModelRun,
) -> Answer<ModelRun> {
    let model = app.model.as_ref().ok_or_else(|| {
        Problem::new(
            409,
            "model.none",
            "服务未配置语言模型；管理员用 whyroad serve --model 启动后可用",
            "no language model is configured: an administrator starts the service with whyroad serve --model",
        )
    })?;
    let busy = tx.row(
        "SELECT 1 FROM model_runs WHERE project_id = $1 AND kind = $2 AND ended IS NULL",
        values![project, wanted.kind.word()],
    )?;
    if busy.is_some() {
        return Err(Problem::new(
            409,
            "model.running",
            "本项目已有同类的运行；请等它结束，或先停止它",
            "a run of this kind is in progress in this project: wait for it to end, or stop it first",
        ));
    }
    let (id, now) = (secret::id()?, app.now());
    tx.run(
        "INSERT INTO model_runs (id, project_id, kind, state, model, actor, started, spent, alive)
         VALUES ($1, $2, $3, 'waiting', $4, $5, $6, '{}', 0)",
        values![&id, project, wanted.kind.word(), model.name(), &user.id, now],
    )?;
    let (takes, waits) = conditions(wanted.kind);
    let insert = "INSERT INTO model_run_tasks (run_id, task_id, state) SELECT $1, id, 'waiting' FROM tasks";
    let found = match &wanted.tasks {
        None => {
            let sql = format!("{insert} WHERE project_id = $2 AND {takes} AND {waits}");
            tx.run(&sql, values![&id, project])?
        }
        Some(tasks) if tasks.is_empty() || tasks.len() > MOST_TASKS => {
            return Err(Problem::request(
                format!("一次须有 1 至 {MOST_TASKS} 个任务"),
                format!("a request must have 1 to {MOST_TASKS} tasks"),
            ));
        }
        Some(tasks) => {
            let sql =
                format!("{insert} WHERE project_id = $2 AND id = $3 AND {takes} ON CONFLICT DO NOTHING");
            let mut found = 0;
            for task in tasks {
                found += tx.run(&sql, values![&id, project, task])?;
            }
            found
        }
    };
    if found == 0 {
        return Err(match wanted.kind {
            ModelRunKind::Draft => Problem::new(
                422,
                "model.nothing",
                "没有可起草的任务：只为无人开始的任务起草",
                "no task to draft: only tasks that nobody has started are drafted",
            ),
            ModelRunKind::Judge => Problem::new(
                422,
                "model.nothing",
                "没有可判定的标注：只判定已提交的标注",
                "no label to judge: only submitted labels are judged",
            ),
        });
    }
    get(tx, project, &id, roles)
}

fn get(tx: &mut dyn Tx, project: &str, run: &str, roles: &[Role]) -> Answer<ModelRun> {
    let sql = format!("SELECT {COLUMNS} FROM model_runs WHERE id = $1 AND project_id = $2");
    let row = tx.row(&sql, values![run, project])?.ok_or_else(Problem::missing)?;
    shown(tx, &row, roles)
}

/// Stops a run of `project`: no further question is asked; answers that are in progress are kept.
pub fn stop(tx: &mut dyn Tx, project: &str, run: &str, roles: &[Role], now: i64) -> Answer<ModelRun> {
    tx.run(
        "UPDATE model_runs SET state = 'stopped', ended = $1, worker = NULL
         WHERE id = $2 AND project_id = $3 AND ended IS NULL",
        values![now, run, project],
    )?;
    get(tx, project, run, roles)
}

/// A run that a service processes.
#[derive(Clone, Debug)]
pub struct Claimed {
    /// Id.
    pub id: String,
    /// Its project.
    pub project: String,
    /// What it does.
    pub kind: ModelRunKind,
    /// User who started it.
    pub actor: String,
    /// Its earlier cost.
    pub spent: ModelSpent,
}

/// Assigns the oldest run that no service processes to `worker`.
pub fn claim(tx: &mut dyn Tx, worker: &str, now: i64) -> Answer<Option<Claimed>> {
    let sql = format!(
        "SELECT id, project_id, kind, actor, spent FROM model_runs
         WHERE ended IS NULL AND (worker IS NULL OR worker = $1 OR alive < $2 OR alive > $3)
         ORDER BY started, id LIMIT 1{}",
        tx.lock()
    );
    // A clock that was set back must not keep a run waiting.
    let Some(row) = tx.row(&sql, values![worker, now - LEASE_MS, now + LEASE_MS])? else { return Ok(None) };
    let (id, kind) = (row.text("id")?, row.text("kind")?);
    tx.run(
        "UPDATE model_runs SET state = 'running', worker = $1, alive = $2 WHERE id = $3",
        values![worker, now, &id],
    )?;
    Ok(Some(Claimed {
        id,
        project: row.text("project_id")?,
        kind: ModelRunKind::from_word(&kind).ok_or_else(|| Problem::store(format!("run '{kind}'")))?,
        actor: row.text("actor")?,
        spent: parse(&row.text("spent")?)?,
    }))
}

/// Renews the lease and writes the cost; false if the run was stopped or another service has it.
pub fn keep(tx: &mut dyn Tx, run: &str, worker: &str, spent: &ModelSpent, now: i64) -> Answer<bool> {
    let spent = json(spent)?;
    let kept = tx.run(
        "UPDATE model_runs SET alive = $1, spent = $2 WHERE id = $3 AND worker = $4 AND ended IS NULL",
        values![now, &spent, run, worker],
    )?;
    if kept == 0 {
        // Answers that come after it was stopped have a cost, too.
        tx.run("UPDATE model_runs SET spent = $1 WHERE id = $2 AND state = 'stopped'", values![&spent, run])?;
    }
    Ok(kept > 0)
}

/// True while `worker` has the run and nobody has stopped it.
pub fn is_of(tx: &mut dyn Tx, run: &str, worker: &str) -> Answer<bool> {
    let sql = "SELECT 1 FROM model_runs WHERE id = $1 AND worker = $2 AND ended IS NULL";
    Ok(tx.row(sql, values![run, worker])?.is_some())
}

/// Releases an unfinished run: the service ends.
pub fn give_back(tx: &mut dyn Tx, run: &str, worker: &str) -> Answer<()> {
    tx.run("UPDATE model_runs SET worker = NULL WHERE id = $1 AND worker = $2", values![run, worker])
        .map(drop)
}

/// Ends a run: done, or failed with the reason.
pub fn end(tx: &mut dyn Tx, run: &str, why: Option<&Bilingual>, now: i64) -> Answer<()> {
    let state = if why.is_some() { ModelRunState::Failed } else { ModelRunState::Done };
    tx.run(
        "UPDATE model_runs SET state = $1, ended = $2, note = $3, worker = NULL WHERE id = $4 AND ended IS NULL",
        values![state.word(), now, why.map(json).transpose()?, run],
    )
    .map(drop)
}

/// Waiting tasks of a run, sorted by drive; copies of one episode are adjacent, so that their answers come from the
/// cache.
pub fn waiting(tx: &mut dyn Tx, run: &str) -> Answer<Vec<String>> {
    let sql = "SELECT t.id AS id FROM model_run_tasks m JOIN tasks t ON t.id = m.task_id
        WHERE m.run_id = $1 AND m.state = 'waiting' ORDER BY t.overlap_index, t.drive_id, t.keyframe_ns, t.id";
    tx.rows(sql, values![run])?.iter().map(|r| r.text("id")).collect()
}

/// Result for a task of a run.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// It has a draft or a judgment.
    Done,
    /// The model returned nothing usable.
    Failed(Bilingual),
    /// It does not belong to the run any more.
    LeftOut,
}

/// Writes the result for a task.
pub fn settle(tx: &mut dyn Tx, run: &str, task: &str, outcome: &Outcome) -> Answer<()> {
    let (state, note) = match outcome {
        Outcome::Done => ("done", None),
        Outcome::Failed(why) => ("failed", Some(json(why)?)),
        Outcome::LeftOut => ("left_out", None),
    };
    tx.run(
        "UPDATE model_run_tasks SET state = $1, note = $2 WHERE run_id = $3 AND task_id = $4",
        values![state, note, run, task],
    )
    .map(drop)
}

/// True if nobody has started the task.
pub fn is_unbegun(tx: &mut dyn Tx, task: &str) -> Answer<bool> {
    Ok(tx.row(&format!("SELECT 1 FROM tasks WHERE id = $1 AND {UNBEGUN}"), values![task])?.is_some())
}
