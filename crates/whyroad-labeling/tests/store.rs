//! The store by itself, the same tests on a SQLite file and on a real PostgreSQL: transactions, migration, backup.

#![allow(clippy::unwrap_used, reason = "a test says what went wrong by failing")]

#[path = "support/postgres.rs"]
#[allow(dead_code)]
mod postgres;

use std::path::Path;
use whyroad_labeling::problem::Problem;
use whyroad_labeling::store::{Place, Store, backup, restore};
use whyroad_labeling::values;

fn file(dir: &Path, name: &str) -> Place {
    Place::File(dir.join(name))
}

fn put(store: &Store, name: &'static str) {
    store
        .write(move |tx| tx.run("INSERT INTO settings (name, value) VALUES ($1, 'x')", values![name]))
        .unwrap();
}

fn names(store: &Store) -> Vec<String> {
    let names = store.read(|tx| tx.rows("SELECT name FROM settings ORDER BY name", &[])).unwrap();
    names.iter().map(|r| r.text(0).unwrap()).collect()
}

/// What must hold on both.
fn transactions(store: &Store) {
    put(store, "a");
    let refused = store.write(|tx| {
        tx.run("INSERT INTO settings (name, value) VALUES ('b', 'x')", &[])?;
        Err::<(), _>(Problem::forbidden())
    });
    assert_eq!(refused.unwrap_err().code, "access.denied");
    let broken = store.write(|tx| {
        tx.run("INSERT INTO settings (name, value) VALUES ('c', 'x')", &[])?;
        tx.run("INSERT INTO settings (name, value) VALUES ('a', 'x')", &[])
    });
    assert_eq!(broken.unwrap_err().status, 503, "a second 'a' breaks the whole");
    assert_eq!(names(store), ["a"]);

    // Many at once, some of them refused: each whole or not at all, none for another's fault.
    std::thread::scope(|scope| {
        for i in 0..40 {
            scope.spawn(move || {
                let outcome = store.write(move |tx| {
                    let n = format!("many{i:02}");
                    tx.run("INSERT INTO settings (name, value) VALUES ($1, 'x')", values![&n])?;
                    if i % 4 == 0 { Err(Problem::forbidden()) } else { Ok(i) }
                });
                assert_eq!(outcome.is_ok(), i % 4 != 0);
            });
        }
    });
    assert_eq!(names(store).iter().filter(|n| n.starts_with("many")).count(), 30);

    // One counter, many hands: no step is lost.
    store.write(|tx| tx.run("INSERT INTO settings (name, value) VALUES ('counter', '0')", &[])).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..20 {
            scope.spawn(|| {
                store
                    .write(|tx| {
                        let sql = format!("SELECT value FROM settings WHERE name = 'counter'{}", tx.lock());
                        let n: i64 = tx.row(&sql, &[])?.unwrap().text(0)?.parse().unwrap();
                        let next = (n + 1).to_string();
                        tx.run("UPDATE settings SET value = $1 WHERE name = 'counter'", values![&next])
                    })
                    .unwrap();
            });
        }
    });
    let counter = store.read(|tx| tx.row("SELECT value FROM settings WHERE name = 'counter'", &[])).unwrap();
    assert_eq!(counter.unwrap().text(0).unwrap(), "20");
}

#[test]
fn transactions_on_sqlite() {
    let dir = tempfile::tempdir().unwrap();
    transactions(&Store::open(&file(dir.path(), "s")).unwrap());
}

#[test]
fn transactions_on_postgresql() {
    let Some(server) = postgres::Server::start() else { return };
    let url = server.database();
    transactions(&Store::open(&Place::parse(&url)).unwrap());
    // Two services that start at once on an empty database make its tables once.
    let url = server.database();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| Store::open(&Place::parse(&url)).unwrap());
        }
    });
}

const FIRST: &str = include_str!("../migrations/0001_tables.sql");

#[test]
fn an_older_store_comes_forward_and_is_copied_aside_before() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("s");
    let old = rusqlite::Connection::open(&path).unwrap();
    old.execute_batch(FIRST).unwrap();
    old.execute_batch(
        "CREATE TABLE schema_version (version BIGINT NOT NULL); INSERT INTO schema_version VALUES (1);
         INSERT INTO projects VALUES ('p', 'town', '', '{}', '{}', 0);
         INSERT INTO tasks (id, project_id, episode_id, overlap_index, overlap_count, drive_id, clip_id, scenario_id,
           keyframe_ns, from_ns, to_ns, episode, initial, draft, version, priority, state, authors, checked, audited,
           fence, seq, created, updated)
         VALUES ('t', 'p', 'e', 0, 1, 'd', 'c', 's', 0, 0, 0, '{}', '{}', '{}', 1, 0, 'open', '[]', 0, 0, 0, 0, 0, 0);",
    )
    .unwrap();
    drop(old);
    let store = Store::open(&Place::File(path.clone())).unwrap();
    let row = store.read(|tx| tx.row("SELECT id, lang FROM tasks", &[])).unwrap().unwrap();
    assert_eq!((row.text(0).unwrap(), row.text(1).unwrap()), ("t".into(), String::new()));
    let aside = rusqlite::Connection::open(dir.path().join("s.before-2")).unwrap();
    let version: i64 = aside.query_row("SELECT max(version) FROM schema_version", [], |r| r.get(0)).unwrap();
    let tasks: i64 = aside.query_row("SELECT count(*) FROM tasks", [], |r| r.get(0)).unwrap();
    assert_eq!((version, tasks), (1, 1), "the copy is the store as it was");

    // A store of a newer program is not touched.
    store.write(|tx| tx.run("INSERT INTO schema_version (version) VALUES (99)", &[])).unwrap();
    drop(store);
    assert_eq!(Store::open(&Place::File(path)).unwrap_err().code, "store.newer");
}

/// All that a backup of `store` holds.
fn dump(store: &Store) -> Vec<u8> {
    let mut out = Vec::new();
    backup(store, &mut out).unwrap();
    out
}

fn fill(store: &Store) {
    put(store, "csrf_key");
    store
        .write(|tx| {
            tx.run("INSERT INTO users VALUES ('u', 'ann', '安<b>', 0, 'zh', 'h', 0, 5)", &[])?;
            tx.run("INSERT INTO projects VALUES ('p', 'town', 'a\nb', '{}', '{}', 7)", &[])?;
            tx.run("INSERT INTO members VALUES ('p', 'u', '[\"lead\"]', '[]')", &[])
        })
        .unwrap();
}

#[test]
fn a_backup_restores_into_either_store_and_back() {
    let dir = tempfile::tempdir().unwrap();
    let first = Store::open(&file(dir.path(), "first")).unwrap();
    fill(&first);
    let bytes = dump(&first);
    let second = Store::open(&file(dir.path(), "second")).unwrap();
    put(&second, "made on its first start");
    restore(&second, &mut &bytes[..]).unwrap();
    assert_eq!(String::from_utf8(dump(&second)).unwrap(), String::from_utf8(bytes.clone()).unwrap());

    assert_eq!(restore(&second, &mut &bytes[..]).unwrap_err().code, "restore.not_empty");
    let third = Store::open(&file(dir.path(), "third")).unwrap();
    let cut = bytes.iter().rposition(|b| *b == b'{').unwrap();
    assert_eq!(restore(&third, &mut &bytes[..cut]).unwrap_err().code, "restore.broken");
    assert_eq!(restore(&third, &mut &b"{}\n{}"[..]).unwrap_err().code, "restore.broken");
    assert_eq!(names(&third), Vec::<String>::new(), "nothing of a broken backup is kept");

    let Some(server) = postgres::Server::start() else { return };
    let far = Store::open(&Place::parse(&server.database())).unwrap();
    restore(&far, &mut &bytes[..]).unwrap();
    assert_eq!(dump(&far), bytes);
}
