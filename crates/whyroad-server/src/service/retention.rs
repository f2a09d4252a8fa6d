//! Removes data after the retention period of a project: finished tasks with their labels, histories, comments and
//! thumbnails. The record of who has seen which part of a drive is kept, so that nobody does Stage I of a part that
//! they have seen; so are the ids of the episodes, so that they get no second task.

use crate::app::App;
use crate::domain::workflow::State;
use crate::problem::Answer;
use crate::service::projects::{self, DAY_MS};
use crate::service::{deletion, seen};
use crate::values;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two sweeps, and between two checks whether the service has ended.
const SWEEP_EVERY: Duration = Duration::from_secs(3600);
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Number of tasks removed in one transaction.
const AT_ONCE: i64 = 200;

/// SQL for finished tasks that were not changed since `$2`: nobody works on them any more. A label of which another one
/// was chosen is finished with that one, because the choice is open again if that one is skipped or rejected.
const FINISHED: &str = "updated < $2 AND (state IN ('accepted', 'skipped', 'rejected')
    OR (adjudication = 'superseded' AND NOT EXISTS (SELECT 1 FROM tasks o
      WHERE o.project_id = tasks.project_id AND o.episode_id = tasks.episode_id AND o.adjudication = 'chosen'
        AND (o.updated >= $2 OR o.state NOT IN ('accepted', 'skipped', 'rejected')))))";

/// Removes tasks after the retention period of their project; returns their number.
pub fn sweep(app: &App) -> Answer<u64> {
    let now = app.now();
    let mut removed = 0;
    for project in app.store.read(projects::all)? {
        let days = i64::from(project.settings.retention_days);
        if days == 0 {
            continue;
        }
        loop {
            let (id, before) = (project.id.clone(), now - days * DAY_MS);
            let n = app.store.write(move |tx| {
                let sql = format!(
                    "SELECT id, episode_id, drive_id, state FROM tasks WHERE project_id = $1 AND {FINISHED}
                     ORDER BY updated, id LIMIT $3"
                );
                let rows = tx.rows(&sql, values![&id, before, AT_ONCE])?;
                let parts = deletion::parts_of_tasks(tx)?;
                for row in &rows {
                    let (task, episode) = (row.text("id")?, row.text("episode_id")?);
                    seen::outlast(tx, &task, &episode)?;
                    // Nobody has labeled or refused what was skipped: it may be asked again.
                    if row.text("state")? != State::Skipped.word() {
                        tx.run(
                            "INSERT INTO finished_episodes (project_id, episode_id, drive_id) VALUES ($1, $2, $3)
                             ON CONFLICT DO NOTHING",
                            values![&id, &episode, row.text("drive_id")?],
                        )?;
                    }
                    for table in &parts {
                        tx.run(&format!("DELETE FROM {table} WHERE task_id = $1"), values![&task])?;
                    }
                    tx.run("DELETE FROM tasks WHERE id = $1", values![&task])?;
                }
                Ok(rows.len() as u64)
            })?;
            removed += n;
            if n < AT_ONCE as u64 {
                break;
            }
        }
    }
    if removed > 0 {
        (app.log)(&format!("retention: {removed} finished tasks removed"));
    }
    Ok(removed)
}

/// Sweeps every hour until the service ends.
pub fn spawn(app: &Arc<App>) -> JoinHandle<()> {
    let service = Arc::downgrade(app);
    std::thread::spawn(move || {
        let mut last: Option<Instant> = None;
        while let Some(app) = service.upgrade() {
            if last.is_none_or(|at| at.elapsed() >= SWEEP_EVERY) {
                // If the store is unavailable, it is swept the next time.
                let _ = sweep(&app);
                last = Some(Instant::now());
            }
            drop(app);
            std::thread::sleep(LOOK_EVERY);
        }
    })
}
