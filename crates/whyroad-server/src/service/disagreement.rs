//! Overlap groups of which a lead chooses one label, and those whose labels disagree about the decision. Stored with
//! each task of the group, so that lists filter and count without reading labels; computed when a label is submitted or
//! skipped.

use crate::domain::workflow::State;
use crate::problem::Answer;
use crate::service::copies::NOT_GOLD;
use crate::service::tasks::TaskRow;
use crate::service::{compared, tasks};
use crate::store::{Store, Tx, Value as Cell};
use crate::values;

/// SQL condition for tasks to adjudicate; `tasks` is the table.
pub(super) const TO_ADJUDICATE: &str =
    "tasks.disagrees = 1 AND tasks.adjudication IS NULL AND tasks.state NOT IN ('skipped', 'rejected')";
/// SQL condition for tasks of groups that wait for a choice; `tasks` is the table.
pub(super) const TO_CHOOSE: &str =
    "tasks.complete = 1 AND tasks.adjudication IS NULL AND tasks.state NOT IN ('skipped', 'rejected')";
/// SQL condition for labels that may be checked and exported: of an overlap group only the chosen one.
pub(super) const STANDS: &str = "(overlap_count = 1 OR adjudication = 'chosen')";
/// SQL condition for labels of which the lead has not chosen another one.
pub(super) const NOT_SUPERSEDED: &str = "(adjudication IS NULL OR adjudication <> 'superseded')";

/// Number of groups compared in one transaction.
const AT_ONCE: i64 = 100;

/// Every label of the group was submitted, skipped or rejected.
pub fn is_ready(group: &[TaskRow]) -> bool {
    let left_out = |s: State| matches!(s, State::Skipped | State::Rejected);
    group.iter().all(|o| o.at.state.is_handed_in() || left_out(o.at.state))
}

/// Compares the labels of the overlap group of an episode. A group that still waits for a label does not disagree, and
/// skipped or rejected labels do not count.
pub(super) fn note(tx: &mut dyn Tx, project: &str, episode: &str) -> Answer<()> {
    let group = tasks::group(tx, project, episode)?;
    let labels: Vec<_> = group.iter().filter(|t| t.at.state.is_handed_in()).map(|t| &t.draft).collect();
    let differ =
        || labels.iter().enumerate().any(|(n, a)| labels[n + 1..].iter().any(|b| compared::disagree(a, b)));
    // A copy that was added after a choice does not open it again.
    let complete = is_ready(&group) && !group.iter().any(TaskRow::is_chosen);
    let disagrees = complete && differ();
    tx.run(
        "UPDATE tasks SET disagrees = $1, complete = $2 WHERE project_id = $3 AND episode_id = $4",
        values![i64::from(disagrees), i64::from(complete), project, episode],
    )
    .map(drop)
}

/// Opens the choice of the group of `t` again.
pub(super) fn reopen(tx: &mut dyn Tx, t: &mut TaskRow) -> Answer<()> {
    t.adjudication = None;
    tx.run(
        "UPDATE tasks SET adjudication = NULL WHERE project_id = $1 AND episode_id = $2",
        values![&t.project, &t.episode.episode_id],
    )
    .map(drop)
}

/// SQL for some groups that were submitted before this was stored.
pub(super) fn not_compared() -> String {
    let handed_in: Vec<String> =
        State::ALL.iter().filter(|s| s.is_handed_in()).map(|s| format!("'{}'", s.word())).collect();
    format!(
        "SELECT DISTINCT project_id, episode_id FROM tasks
         WHERE overlap_count > 1 AND disagrees IS NULL AND state IN ({}) LIMIT {AT_ONCE}",
        handed_in.join(", ")
    )
}

/// Compares the groups that were submitted before this was stored.
pub fn note_all(store: &Store) -> Answer<()> {
    let sql = not_compared();
    loop {
        let sql = sql.clone();
        let compared = store.write(move |tx| {
            let groups = tx.rows(&sql, &[])?;
            for row in &groups {
                note(tx, &row.text("project_id")?, &row.text("episode_id")?)?;
            }
            Ok(groups.len())
        })?;
        if compared == 0 {
            return Ok(());
        }
    }
}

/// Number of tasks of a project that match one of the conditions above.
pub(super) fn count(tx: &mut dyn Tx, project: &str, condition: &str) -> Answer<i64> {
    let sql = format!("SELECT count(*) AS n FROM tasks WHERE project_id = $1 AND {condition}");
    let values: [Cell; 1] = [project.into()];
    tx.row(&sql, &values)?.map_or(Ok(0), |r| r.int("n"))
}

/// Number of episodes of a project that wait for a choice, without gold tasks.
pub fn episodes_to_choose(tx: &mut dyn Tx, project: &str) -> Answer<i64> {
    let sql = format!(
        "SELECT count(DISTINCT episode_id) AS n FROM tasks WHERE project_id = $1 AND {TO_CHOOSE} AND {NOT_GOLD}"
    );
    tx.row(&sql, values![project])?.map_or(Ok(0), |r| r.int("n"))
}
