//! Writes the append-only history of a task; events are announced to webhooks in the same transaction.

use crate::domain::workflow::State;
use crate::problem::Answer;
use crate::service::projects::{self, json};
use crate::service::tasks::{Entry, TaskRow};
use crate::service::webhooks;
use crate::store::Tx;
use crate::values;

/// Appends to the history of `t` and counts it there; the caller writes `t` after it.
pub fn record(tx: &mut dyn Tx, t: &mut TaskRow, entry: &Entry<'_>, now: i64) -> Answer<()> {
    t.seq += 1;
    t.updated = now;
    let changes = if entry.changes.is_empty() { None } else { Some(json(&entry.changes)?) };
    tx.run(
        "INSERT INTO history (task_id, seq, at, actor, action, from_state, to_state, changes, snapshot, note, version)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11)",
        values![
            &t.id, t.seq, now, entry.actor, entry.action, entry.from.map(State::word), t.at.state.word(), changes,
            entry.snapshot.map(json).transpose()?, entry.note, t.version,
        ],
    )?;
    count(tx, &t.project, (entry.actor, entry.action), now)?;
    webhooks::announce(tx, t, entry, now)
}

/// Actions that dashboards count.
const COUNTED: [&str; 3] = ["submit", "accept", "send_back"];

/// Counts what dashboards show by day of the project's clock, person and action.
pub(super) fn count(
    tx: &mut dyn Tx,
    project: &str,
    (actor, action): (Option<&str>, &str),
    now: i64,
) -> Answer<()> {
    if !COUNTED.contains(&action) {
        return Ok(());
    }
    let day = projects::day(&projects::get(tx, project)?.settings, now);
    tx.run(
        "INSERT INTO activity (project_id, day, actor, action, n) VALUES ($1, $2, $3, $4, 1)
         ON CONFLICT (project_id, day, actor, action) DO UPDATE SET n = activity.n + 1",
        values![project, day, actor.unwrap_or_default(), action],
    )?;
    Ok(())
}
