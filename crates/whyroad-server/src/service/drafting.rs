//! Drafts in the background. Deriving a draft takes a second or so, and a lead makes hundreds of tasks at once: these
//! are stored at once, pending, without reading their drives, and their drafts and small pictures are made one after
//! the other beside the service's work. Whoever opens a pending task before its turn has its draft made then.

use crate::app::App;
use crate::problem::{Answer, Problem};
use crate::service::create::{self, LastDrive, Start};
use crate::service::projects;
use crate::service::tasks::{self, TaskRow};
use crate::service::thumbnail;
use crate::values;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

/// Between two looks for pending tasks when there were none.
const LOOK_EVERY: Duration = Duration::from_millis(500);

/// `pending` of a task without its draft, and of one whose draft failed: that one is tried again when it is opened.
pub(super) const PENDING: i64 = 1;
const FAILED: i64 = 2;

/// `t` with its draft, which is made now where it is pending.
pub fn ready(app: &App, t: TaskRow) -> Answer<TaskRow> {
    if !t.pending {
        return Ok(t);
    }
    let id = t.id.clone();
    make(app, &t, &mut LastDrive::default())?;
    app.store.read(|tx| tasks::get(tx, &id))
}

/// Makes the draft of a pending task and stores it.
fn make(app: &App, t: &TaskRow, last: &mut LastDrive) -> Answer<()> {
    let project = app.store.read(|tx| projects::get(tx, &t.project))?;
    let start = create::start_of(app, &project, &t.episode, &t.lang, last)?;
    put(app, t.id.clone(), start)
}

fn put(app: &App, id: String, start: Start) -> Answer<()> {
    app.store.write(move |tx| {
        // Another thread may have been faster.
        let sql = "UPDATE tasks SET initial = $1, draft = $2, pending = 0 WHERE id = $3 AND pending <> 0";
        let text = projects::json(&start.draft)?;
        if tx.run(sql, values![&text, &text, &id])? > 0 {
            thumbnail::put(tx, &id, &start.thumbnail)?;
        }
        Ok(())
    })
}

/// Makes drafts until the service ends. Not waited for: a derivation that hangs does not keep the service from
/// stopping, and what is still pending is made after the next start.
pub fn spawn(app: &Arc<App>) -> JoinHandle<()> {
    let service = Arc::downgrade(app);
    std::thread::spawn(move || {
        let mut last = LastDrive::default();
        while let Some(app) = service.upgrade() {
            let worked = next(&app, &mut last);
            drop(app);
            match worked {
                Ok(true) => {}
                Ok(false) => {
                    last = LastDrive::default();
                    std::thread::sleep(LOOK_EVERY);
                }
                // The store is away: it comes back, or the service ends.
                Err(_) => std::thread::sleep(LOOK_EVERY * 4),
            }
        }
    })
}

/// Makes the draft of one pending task; false where there is none.
fn next(app: &App, last: &mut LastDrive) -> Answer<bool> {
    // Drive by drive: each is read once.
    let sql = "SELECT id FROM tasks WHERE pending = $1 ORDER BY pending, priority DESC, drive_id, keyframe_ns, id LIMIT 1";
    let Some(row) = app.store.read(|tx| tx.row(sql, values![PENDING]))? else { return Ok(false) };
    let id = row.text("id")?;
    let t = app.store.read(|tx| tasks::get(tx, &id))?;
    let made = catch_unwind(AssertUnwindSafe(|| make(app, &t, last)))
        .unwrap_or_else(|_| Err(Problem::new(500, "internal", "内部错误", "the derivation failed")));
    if let Err(why) = made {
        *last = LastDrive::default();
        (app.log)(&format!("draft of task {id}: {}", why.text.en));
        app.store.write(move |tx| {
            tx.run("UPDATE tasks SET pending = $1 WHERE id = $2 AND pending <> 0", values![FAILED, &id])
                .map(drop)
        })?;
    }
    Ok(true)
}

/// Tasks of `project` whose drafts are still to be made.
pub fn pending(tx: &mut dyn crate::store::Tx, project: &str) -> Answer<i64> {
    let sql = "SELECT count(*) AS n FROM tasks WHERE project_id = $1 AND pending = $2";
    tx.row(sql, values![project, PENDING])?.map_or(Ok(0), |r| r.int("n"))
}
