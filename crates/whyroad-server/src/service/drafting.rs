//! Drafts in the background. Deriving a draft takes up to a second, and a lead creates hundreds of tasks at once: these
//! are stored immediately as pending, without reading their drives, and their drafts and thumbnails are created drive
//! by drive in the background. When somebody opens a pending task earlier, its draft is created then.

use crate::app::App;
use crate::problem::{Answer, Problem};
use crate::service::create::{self, LastDrive, Start};
use crate::service::projects;
use crate::service::tasks::{self, TaskRow};
use crate::service::thumbnail;
use crate::sync::lock;
use crate::{secret, values};
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, Weak};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two queries for pending tasks when there were none.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// Interval at which a worker stores its results: drafts that are created quickly share a transaction.
const STORE_EVERY: Duration = Duration::from_millis(200);
/// Number of pending tasks that a worker reads, and number that is enough for one batch.
const LOOK_AHEAD: usize = 64;
const FEW: usize = 16;

/// `pending` of a task without its draft, and of one whose draft failed: it is tried again when the task is opened.
pub(super) const PENDING: i64 = 1;
const FAILED: i64 = 2;

/// The first pending tasks. Their index is partial: a store uses it only if the query repeats its condition, and
/// otherwise reads the whole table, twice a second.
pub(super) const NEXT: &str = "SELECT id, drive_id FROM tasks WHERE pending = $1 AND pending <> 0
    ORDER BY pending, priority DESC, drive_id, keyframe_ns, id LIMIT $2";
/// Number of pending tasks of a project.
pub(super) const COUNT: &str =
    "SELECT count(*) AS n FROM tasks WHERE project_id = $1 AND pending = $2 AND pending <> 0";

/// `t` with its draft, which is created now if it is pending.
pub fn ready(app: &App, t: TaskRow) -> Answer<TaskRow> {
    if !t.pending {
        return Ok(t);
    }
    let id = t.id.clone();
    let start = start_of(app, &t, &mut LastDrive::default())?;
    put(app, vec![(id.clone(), start)])?;
    app.store.read(|tx| tasks::get(tx, &id))
}

fn put(app: &App, made: Vec<(String, Start)>) -> Answer<()> {
    if made.is_empty() {
        return Ok(());
    }
    app.store.write(move |tx| {
        for (id, start) in &made {
            // Another thread may have been faster.
            let sql = "UPDATE tasks SET initial = $1, draft = $2, pending = 0 WHERE id = $3 AND pending <> 0";
            let text = projects::json(&start.draft)?;
            if tx.run(sql, values![&text, &text, id])? > 0 {
                thumbnail::put(tx, id, &start.thumbnail)?;
            }
        }
        Ok(())
    })
}

/// Initial content of `t`.
fn start_of(app: &App, t: &TaskRow, last: &mut LastDrive) -> Answer<Start> {
    let project = app.store.read(|tx| projects::get(tx, &t.project))?;
    create::start_of(app, &project, &t.episode, &t.lang, last)
}

/// Creates drafts until the service ends: on all cores, at the lowest priority; on all cores but one where the system
/// has no priorities per thread. The threads are not joined: a derivation that hangs does not keep the service from
/// stopping, and pending drafts are created after the next start.
pub fn spawn(app: &Arc<App>) -> Vec<JoinHandle<()>> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let workers = if cfg!(target_os = "linux") { cores } else { (cores - 1).max(1) };
    let turns = Arc::new(Turns::default());
    let worker = |_| {
        let (service, turns) = (Arc::downgrade(app), Arc::clone(&turns));
        std::thread::spawn(move || {
            stand_back();
            work(&service, &turns);
        })
    };
    (0..workers).map(worker).collect()
}

/// Gives this thread the lowest priority. Linux has a priority per thread (`setpriority(2)`).
fn stand_back() {
    #[cfg(target_os = "linux")]
    {
        let lowest = 19;
        // If this is not permitted, drafts are created with the priority of the service.
        let _ = rustix::process::setpriority_process(Some(rustix::thread::gettid()), lowest);
    }
}

fn work(service: &Weak<App>, turns: &Turns) {
    while let Some(app) = service.upgrade() {
        let batch = turns.next(&app);
        drop(app);
        match batch.and_then(|batch| batch.map(|b| make(service, &b)).transpose()) {
            Ok(Some(())) => {}
            Ok(None) => std::thread::sleep(LOOK_EVERY),
            // The store is unavailable: it comes back, or the service ends.
            Err(_) => std::thread::sleep(LOOK_EVERY * 4),
        }
    }
}

/// Creates the drafts of a batch. Drafts that the store does not accept stay pending.
fn make(service: &Weak<App>, batch: &Batch<'_>) -> Answer<()> {
    let (mut last, mut made, mut since) = (LastDrive::default(), Vec::new(), Instant::now());
    for id in &batch.tasks {
        let Some(app) = service.upgrade() else { return Ok(()) };
        match one(&app, id, &mut last) {
            Ok(start) => made.extend(start.map(|start| (id.clone(), start))),
            Err(why) => {
                last = LastDrive::default();
                failed(&app, id, &why)?;
            }
        }
        if since.elapsed() >= STORE_EVERY {
            put(&app, std::mem::take(&mut made))?;
            since = Instant::now();
        }
    }
    service.upgrade().map_or(Ok(()), |app| put(&app, made))
}

/// The draft of a task; `None` if it already exists.
fn one(app: &App, id: &str, last: &mut LastDrive) -> Answer<Option<Start>> {
    let t = app.store.read(|tx| tasks::get(tx, id))?;
    if !t.pending {
        return Ok(None);
    }
    catch_unwind(AssertUnwindSafe(|| start_of(app, &t, last)))
        .unwrap_or_else(|_| Err(Problem::new(500, "internal", "内部错误", "the derivation failed")))
        .map(Some)
}

fn failed(app: &App, id: &str, why: &Problem) -> Answer<()> {
    (app.log)(&format!("draft of task {id}: {}", why.text.en));
    let id = id.to_owned();
    app.store.write(move |tx| {
        tx.run("UPDATE tasks SET pending = $1 WHERE id = $2 AND pending <> 0", values![FAILED, &id]).map(drop)
    })
}

/// The tasks of each worker's current batch.
#[derive(Default)]
struct Turns(Mutex<BTreeSet<String>>);

/// The tasks of one worker's batch, sorted by drive and time.
struct Batch<'a> {
    turns: &'a Turns,
    tasks: Vec<String>,
}

impl Turns {
    /// The next tasks for a worker; `None` if all are in a batch.
    fn next(&self, app: &App) -> Answer<Option<Batch<'_>>> {
        let mut in_hand = lock(&self.0);
        let limit = (in_hand.len() + LOOK_AHEAD) as i64;
        let rows = app.store.read(|tx| tx.rows(NEXT, values![PENDING, limit]))?;
        let mut free: Vec<(String, String)> = Vec::new();
        for row in rows {
            let (id, drive) = (row.text("id")?, row.text("drive_id")?);
            if !in_hand.contains(&id) {
                free.push((id, drive));
            }
        }
        let tasks = some_of(&free, chance()?);
        in_hand.extend(tasks.iter().cloned());
        // Created only if there are some: the end of a batch takes the lock.
        Ok((!tasks.is_empty()).then(|| Batch { turns: self, tasks }))
    }
}

impl Drop for Batch<'_> {
    fn drop(&mut self) {
        let mut in_hand = lock(&self.turns.0);
        self.tasks.iter().for_each(|id| {
            in_hand.remove(id);
        });
    }
}

/// From tasks with their drives, those of one drive, and of the next ones while there are few. Any drive may be the
/// first, so that several services on one database take different ones.
fn some_of(free: &[(String, String)], chance: usize) -> Vec<String> {
    let drives: Vec<&[(String, String)]> = free.chunk_by(|(_, a), (_, b)| a == b).collect();
    let first = chance % drives.len().max(1);
    let mut tasks = Vec::new();
    for drive in &drives[first..] {
        if tasks.len() >= FEW {
            break;
        }
        tasks.extend(drive.iter().map(|(id, _)| id.clone()));
    }
    tasks
}

fn chance() -> Answer<usize> {
    usize::from_str_radix(&secret::random(2)?, 16).map_err(Problem::store)
}

/// Number of tasks of `project` whose drafts are still to be created.
pub fn pending(tx: &mut dyn crate::store::Tx, project: &str) -> Answer<i64> {
    tx.row(COUNT, values![project, PENDING])?.map_or(Ok(0), |r| r.int("n"))
}

#[cfg(test)]
mod tests;
