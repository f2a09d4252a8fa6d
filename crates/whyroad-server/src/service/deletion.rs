//! Everything that a store holds of a drive, removed on request: tasks with labels, histories, comments and images, who
//! saw it, what was said of its episodes, and events about it that wait to be delivered. Which tables name a drive or a
//! task is asked of the store, so none that is added later is forgotten. Counts by day and person (`activity`) name no
//! drive and stay.

use crate::problem::Answer;
use crate::store::{Store, TABLES, Tx};
use crate::values;
use whyroad_model::DriveId;

/// Columns that name a task. `source_task`: of which accepted label a gold task is a copy.
const TASK_COLUMNS: &[&str] = &["task_id", "source_task"];
/// The column that names a drive.
const DRIVE_COLUMN: &str = "drive_id";

/// Rows about a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriveRows {
    /// Tasks.
    pub tasks: u64,
    /// Rows of all other tables.
    pub other: u64,
}

/// What the store holds of the drive.
pub fn held(store: &Store, drive: &DriveId) -> Answer<DriveRows> {
    store.read(|tx| {
        let tasks = tasks(tx, drive)?;
        let (mut other, places) = (0, places(tx)?);
        for (table, conditions) in &places {
            // A row that two columns name is one row.
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

/// Removes it in one transaction, and says what was removed.
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

/// Tables beside `tasks` that name a drive or a task, with the conditions of rows about the drive `$1`.
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

/// Tables with rows that are a part of a task: they go with it.
pub(super) fn parts_of_tasks(tx: &mut dyn Tx) -> Answer<Vec<&'static str>> {
    let mut out = Vec::new();
    // Who has seen which part of a drive outlives the task in which they saw it.
    for table in TABLES.iter().filter(|t| **t != "seen") {
        if tx.columns(table)?.iter().any(|column| column == "task_id") {
            out.push(*table);
        }
    }
    Ok(out)
}

/// Bodies of deliveries name the task; ids of tasks are letters and digits.
fn about(task: &str) -> String {
    format!("%\"task\":\"{task}\"%")
}

#[cfg(test)]
mod tests;
