//! Tasks by state: one definition for the dashboard, the cards of projects, `tasks list` and the metrics. A label of
//! which an adjudication chose another one is in no state: nobody works on it any more.

use crate::domain::project::WaitingLabels;
use crate::problem::Answer;
use crate::service::disagreement::{STANDS, TO_CHOOSE};
use crate::store::Tx;
use crate::values;
use std::collections::BTreeMap;

/// The tasks of a project.
pub fn of(tx: &mut dyn Tx, project: &str) -> Answer<BTreeMap<String, i64>> {
    let mut count = |of: &str| -> Answer<Vec<(String, i64)>> {
        let sql = format!("SELECT state, count(*) AS n FROM tasks WHERE project_id = $1 {of} GROUP BY state");
        tx.rows(&sql, values![project])?.iter().map(|r| Ok((r.text("state")?, r.int("n")?))).collect()
    };
    let mut all: BTreeMap<String, i64> = count("")?.into_iter().collect();
    // Read by the index of overlap groups; the others are counted without reading a task.
    for (state, superseded) in count("AND overlap_count > 1 AND adjudication = 'superseded'")? {
        if let Some(n) = all.get_mut(&state) {
            *n -= superseded;
        }
    }
    all.retain(|_, n| *n > 0);
    Ok(all)
}

/// The tasks of all projects together.
pub fn of_all(tx: &mut dyn Tx) -> Answer<BTreeMap<String, i64>> {
    let mut all = BTreeMap::new();
    for row in tx.rows("SELECT id FROM projects", &[])? {
        for (state, n) in of(tx, &row.text("id")?)? {
            *all.entry(state).or_default() += n;
        }
    }
    Ok(all)
}

/// SQL for what a submitted label waits for, a column of [`WaitingLabels`]; `tasks` is the table.
pub(super) fn waits_for() -> String {
    format!("CASE WHEN {STANDS} THEN 'check' WHEN {TO_CHOOSE} THEN 'choice' ELSE 'other_labels' END")
}

/// What the tasks in the state `submitted` wait for: their sum is the number of that state.
pub fn submitted(tx: &mut dyn Tx, project: &str) -> Answer<WaitingLabels> {
    // Few tasks are in this state, and the index of the queue finds them.
    let sql = format!(
        "SELECT {} AS waits, count(*) AS n FROM tasks WHERE project_id = $1 AND state = 'submitted'
           AND (adjudication IS NULL OR adjudication <> 'superseded') GROUP BY 1",
        waits_for()
    );
    let mut out = WaitingLabels::default();
    for row in tx.rows(&sql, values![project])? {
        out.add(&row.text("waits")?, row.int("n")?);
    }
    Ok(out)
}
