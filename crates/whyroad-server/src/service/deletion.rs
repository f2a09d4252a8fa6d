//! Removes all data of a drive on request: tasks with labels, histories, comments and images, who saw it, verdicts on
//! its episodes, and events about it that wait for delivery. The tables that reference a drive or a task are read from
//! the store, so that a table that is added later is included. Counts by day and person (`activity`) reference no drive
//! and are kept.

use crate::problem::Answer;
use crate::store::{Store, TABLES, Tx};
use crate::values;
use whyroad_model::DriveId;

/// Columns with a task id. `source_task`: the accepted label of which a gold task is a copy.
const TASK_COLUMNS: &[&str] = &["task_id", "source_task"];
/// The column with a drive id.
const DRIVE_COLUMN: &str = "drive_id";

/// Rows about a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriveRows {
    /// Tasks.
    pub tasks: u64,
    /// Rows of all other tables.
    pub other: u64,
}

/// The number of rows about the drive.
pub fn held(store: &Store, drive: &DriveId) -> Answer<DriveRows> {
    store.read(|tx| {
        let tasks = tasks(tx, drive)?;
        let (mut other, places) = (0, places(tx)?);
        for (table, conditions) in &places {
            // A row that matches in two columns is one row.
            let any = conditions.join(" OR ");
            let sql = format!("SELECT count(*) AS n FROM {table} WHERE {any}");
            let row = tx.row(&sql, values![drive.as_str()])?;
            other += row.map_or(Ok(0), |r| r.int("n"))?.unsigned_abs();
        }
        for task in &tasks {
            let row = tx.row("SELECT count(*) AS n FROM outbox WHERE body LIKE $1", values![about(task)])?;
            other += row.map_or(Ok(0), |r| r.int("n"))?.unsigned_abs();
        }
        Ok(DriveRows { tasks: tasks.len() as u64, other })
    })
}

/// Removes them in one transaction, and returns the numbers of removed rows.
pub fn delete_drive(store: &Store, drive: &DriveId) -> Answer<DriveRows> {
    let drive = drive.clone();
    store.write(move |tx| {
        tx.overwrite_deleted()?;
        let (tasks, mut other) = (tasks(tx, &drive)?, 0);
        for (table, conditions) in places(tx)? {
            let sql = format!("DELETE FROM {table} WHERE {}", conditions.join(" OR "));
            other += tx.run(&sql, values![drive.as_str()])?;
        }
        for task in &tasks {
            other += tx.run("DELETE FROM outbox WHERE body LIKE $1", values![about(task)])?;
        }
        tx.run("DELETE FROM tasks WHERE drive_id = $1", values![drive.as_str()])?;
        Ok(DriveRows { tasks: tasks.len() as u64, other })
    })
}

fn tasks(tx: &mut dyn Tx, drive: &DriveId) -> Answer<Vec<String>> {
    let sql = "SELECT id FROM tasks WHERE drive_id = $1 ORDER BY id";
    tx.rows(sql, values![drive.as_str()])?.iter().map(|r| r.text("id")).collect()
}

/// Tables other than `tasks` that reference a drive or a task, with the conditions of rows about the drive `$1`.
fn places(tx: &mut dyn Tx) -> Answer<Vec<(&'static str, Vec<String>)>> {
    let mut out = Vec::new();
    for table in TABLES.iter().filter(|t| **t != "tasks") {
        let condition = |column: &String| -> Option<String> {
            let column = column.as_str();
            if column == DRIVE_COLUMN {
                return Some(format!("{column} = $1"));
            }
            let of_tasks = format!("{column} IN (SELECT id FROM tasks WHERE drive_id = $1)");
            TASK_COLUMNS.contains(&column).then_some(of_tasks)
        };
        let conditions: Vec<String> = tx.columns(table)?.iter().filter_map(condition).collect();
        if !conditions.is_empty() {
            out.push((*table, conditions));
        }
    }
    Ok(out)
}

/// Tables with rows that are parts of a task: they are deleted with it.
pub(super) fn parts_of_tasks(tx: &mut dyn Tx) -> Answer<Vec<&'static str>> {
    let mut out = Vec::new();
    // The record of who has seen which part of a drive is kept longer than the task in which they saw it.
    for table in TABLES.iter().filter(|t| **t != "seen") {
        if tx.columns(table)?.iter().any(|column| column == "task_id") {
            out.push(*table);
        }
    }
    Ok(out)
}

/// Bodies of deliveries contain the task id; task ids consist of letters and digits.
fn about(task: &str) -> String {
    format!("%\"task\":\"{task}\"%")
}

#[cfg(test)]
mod tests;
