//! Removes data after the retention period of a project: finished tasks with their labels, histories, comments and
//! thumbnails. The record of who has seen which part of a drive is kept, so that nobody does Stage I of a part that
//! they have seen.

use crate::app::App;
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
                let rows = tx.rows(
                    "SELECT id, episode_id FROM tasks WHERE project_id = $1 AND updated < $2
                       AND state IN ('accepted', 'skipped', 'rejected') ORDER BY updated, id LIMIT $3",
                    values![&id, before, AT_ONCE],
                )?;
                let parts = deletion::parts_of_tasks(tx)?;
                for row in &rows {
                    let task = row.text("id")?;
                    seen::outlast(tx, &task, &row.text("episode_id")?)?;
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
