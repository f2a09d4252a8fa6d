//! Everything that a store holds of a drive, removed on request: tasks with labels, histories, comments and images, who
//! saw it, and events about it that wait to be delivered. Counts by day and person (`activity`) name no drive and stay.

use crate::problem::Answer;
use crate::store::{Store, Tx};
use crate::values;
use whyroad_model::DriveId;

/// Tables with a `task_id`, besides `seen`, which also names the drive.
const OF_TASK: &[&str] = &["history", "comments", "thumbnails"];

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
        let mut other = count(tx, "SELECT count(*) AS n FROM seen WHERE drive_id = $1", drive.as_str())?;
        for task in &tasks {
            for table in OF_TASK {
                other += count(tx, &format!("SELECT count(*) AS n FROM {table} WHERE task_id = $1"), task)?;
            }
            other += count(tx, "SELECT count(*) AS n FROM outbox WHERE body LIKE $1", &about(task))?;
        }
        Ok(DriveRows { tasks: tasks.len() as u64, other })
    })
}

/// Removes it in one transaction, and says what was removed.
pub fn delete_drive(store: &Store, drive: &DriveId) -> Answer<DriveRows> {
    let drive = drive.clone();
    store.write(move |tx| {
        tx.overwrite_deleted()?;
        let tasks = tasks(tx, &drive)?;
        let mut other = tx.run("DELETE FROM seen WHERE drive_id = $1", values![drive.as_str()])?;
        for task in &tasks {
            for table in OF_TASK {
                other += tx.run(&format!("DELETE FROM {table} WHERE task_id = $1"), values![task])?;
            }
            other += tx.run("DELETE FROM outbox WHERE body LIKE $1", values![about(task)])?;
            tx.run("DELETE FROM tasks WHERE id = $1", values![task])?;
        }
        Ok(DriveRows { tasks: tasks.len() as u64, other })
    })
}

fn tasks(tx: &mut dyn Tx, drive: &DriveId) -> Answer<Vec<String>> {
    let sql = format!("SELECT id FROM tasks WHERE drive_id = $1 ORDER BY id{}", tx.lock());
    tx.rows(&sql, values![drive.as_str()])?.iter().map(|r| r.text("id")).collect()
}

fn count(tx: &mut dyn Tx, sql: &str, value: &str) -> Answer<u64> {
    let row = tx.row(sql, values![value])?;
    Ok(row.map_or(Ok(0), |r| r.int("n"))?.unsigned_abs())
}

/// Bodies of deliveries name the task; ids of tasks are letters and digits.
fn about(task: &str) -> String {
    format!("%\"task\":\"{task}\"%")
}

#[cfg(test)]
mod tests;
