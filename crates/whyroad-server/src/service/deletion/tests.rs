use super::*;
use crate::service::fixtures::{self, on_postgresql};

on_postgresql!(no_table_that_names_a_task_or_a_drive_is_forgotten, one_drive_goes_and_the_others_stay);

/// Every table with a task column is emptied; the listed tables show that columns are found.
#[test]
fn no_table_that_names_a_task_or_a_drive_is_forgotten() {
    let (app, _dir) = fixtures::app();
    let found =
        app.store.read(|tx| Ok(places(tx)?.into_iter().map(|(t, c)| (t, c.len())).collect::<Vec<_>>()));
    let found = found.unwrap();
    let conditions = |table: &str| found.iter().find(|(t, _)| *t == table).map(|(_, n)| *n);
    for (table, named) in [("history", 1), ("comments", 1), ("thumbnails", 1), ("seen", 2)] {
        assert_eq!(conditions(table), Some(named), "{table}");
    }
    for table in ["tasks", "users", "projects", "activity"] {
        assert_eq!(conditions(table), None, "{table}");
    }
}

/// A task of `drive` with one row in every table that references it.
fn put(store: &Store, task: &'static str, drive: &'static str) {
    let made = store.write(move |tx| {
        tx.run(
            "INSERT INTO tasks (id, project_id, episode_id, overlap_index, overlap_count, drive_id, clip_id,
               scenario_id, keyframe_ns, from_ns, to_ns, episode, initial, draft, version, priority, state, authors,
               checked, audited, fence, seq, created, updated)
             VALUES ($1, 'p', $1, 0, 1, $2, $2,
               'a.b.c', 0, 0, 0, '{}', '{}', '{}', 1, 0, 'open', '[]',
               0, 0, 0, 1, 0, 0)",
            values![task, drive],
        )?;
        let rows = [
            "INSERT INTO history (task_id, seq, at, action, version) VALUES ($1, 1, 0, 'create', 1)",
            "INSERT INTO comments (id, task_id, path, author, body, at, resolved) VALUES ($1, $1, '', 'u', '', 0, 0)",
            "INSERT INTO thumbnails (task_id, svg) VALUES ($1, '<svg/>')",
        ];
        for sql in rows {
            tx.run(sql, values![task])?;
        }
        tx.run(
            "INSERT INTO seen (user_id, task_id, drive_id, from_ns, to_ns) VALUES ('u', $1, $2, 0, 1)",
            values![task, drive],
        )?;
        let body = serde_json::json!({"task": task, "clip_id": drive}).to_string();
        tx.run(
            "INSERT INTO outbox (id, webhook_id, body, tries, due, created) VALUES ($1, 'w', $2, 0, 0, 0)",
            values![task, body],
        )
    });
    made.unwrap();
}

#[test]
fn one_drive_goes_and_the_others_stay() {
    let (app, _dir) = fixtures::app();
    let hook = "INSERT INTO webhooks (id, project_id, url, events, secret, created) VALUES ('w', 'p', '', '[]', '', 0)";
    app.store.write(move |tx| tx.run(hook, &[])).unwrap();
    put(&app.store, "t1", "d1");
    put(&app.store, "t2", "d1");
    put(&app.store, "t10", "d10");
    let rows = |drive: &str| held(&app.store, &drive.into()).unwrap();
    assert_eq!(rows("d1"), DriveRows { tasks: 2, other: 10 });
    assert_eq!(delete_drive(&app.store, &"d1".into()).unwrap(), DriveRows { tasks: 2, other: 10 });
    assert_eq!(rows("d1"), DriveRows::default());
    assert_eq!(rows("d10"), DriveRows { tasks: 1, other: 5 });
    // Repeated, as after the process was killed.
    assert_eq!(delete_drive(&app.store, &"d1".into()).unwrap(), DriveRows::default());
}
