//! The store alone, the same tests on a SQLite file and on a real PostgreSQL: transactions, migration, backup.

use crate::postgres_server::Server;
use std::io::{BufReader, Cursor};
use std::path::Path;
use whyroad_server::problem::Problem;
use whyroad_server::store::{Store, StoreLocation, backup, restore};
use whyroad_server::values;

fn put(store: &Store, name: &'static str) {
    store
        .write(move |tx| tx.run("INSERT INTO settings (name, value) VALUES ($1, 'x')", values![name]))
        .unwrap();
}

fn names(store: &Store) -> Vec<String> {
    let names = store.read(|tx| tx.rows("SELECT name FROM settings ORDER BY name", &[])).unwrap();
    names.iter().map(|r| r.text("name").unwrap()).collect()
}

/// Properties of both.
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

    // Many at once, some of them refused: each is complete or absent, and none fails because of another.
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

    // One counter, many writers: no step is lost.
    store.write(|tx| tx.run("INSERT INTO settings (name, value) VALUES ('counter', '0')", &[])).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..20 {
            scope.spawn(|| {
                store
                    .write(|tx| {
                        let sql = format!("SELECT value FROM settings WHERE name = 'counter'{}", tx.lock());
                        let n: i64 = tx.row(&sql, &[])?.unwrap().text("value")?.parse().unwrap();
                        let next = (n + 1).to_string();
                        tx.run("UPDATE settings SET value = $1 WHERE name = 'counter'", values![&next])
                    })
                    .unwrap();
            });
        }
    });
    let counter = store.read(|tx| tx.row("SELECT value FROM settings WHERE name = 'counter'", &[])).unwrap();
    assert_eq!(counter.unwrap().text("value").unwrap(), "20");
}

#[test]
fn transactions_on_sqlite() {
    let dir = tempfile::tempdir().unwrap();
    transactions(&Store::open(&dir.path().join("s")).unwrap());
}

#[test]
fn transactions_on_postgresql() {
    let Some(server) = Server::start() else { return };
    let url = server.database();
    let dir = tempfile::tempdir().unwrap();
    transactions(&Store::open_keeping(&StoreLocation::parse(&url), dir.path()).unwrap());
    // Two services that start at once on an empty database create its tables once.
    let url = server.database();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| Store::open_keeping(&StoreLocation::parse(&url), dir.path()).unwrap());
        }
    });
}

const FIRST: &str = include_str!("../../migrations/0001_tables.sql");

/// A project with a task in the tables of version 1.
const OF_VERSION_1: &str = "
    CREATE TABLE schema_version (version BIGINT NOT NULL); INSERT INTO schema_version VALUES (1);
    INSERT INTO projects (id, name, guide, quota, settings, created) VALUES ('p', 'town', '', '{}', '{}', 0);
    INSERT INTO tasks (id, project_id, episode_id, overlap_index, overlap_count, drive_id, clip_id, scenario_id,
      keyframe_ns, from_ns, to_ns, episode, initial, draft, version, priority, state, authors, checked, audited,
      fence, seq, created, updated)
    VALUES ('t', 'p', 'e', 0, 1, 'd', 'c', 's', 0, 0, 0, '{}', '{}', '{}', 1, 0, 'open', '[]', 0, 0, 0, 0, 0, 0);
    INSERT INTO history VALUES ('t', 1, 86400000, 'u', 'submit', 'stage2', 'submitted', NULL, NULL, NULL, 1);
    INSERT INTO history VALUES ('t', 2, 86400001, 'u', 'submit', 'rework', 'submitted', NULL, NULL, NULL, 2);";

/// The task of [`OF_VERSION_1`], with the column that version 2 added.
fn task(store: &Store) -> (String, String) {
    let row = store.read(|tx| tx.row("SELECT id, lang FROM tasks", &[])).unwrap().unwrap();
    (row.text("id").unwrap(), row.text("lang").unwrap())
}

#[test]
fn an_older_store_comes_forward_and_is_copied_aside_before() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("s");
    let old = rusqlite::Connection::open(&path).unwrap();
    old.execute_batch(FIRST).unwrap();
    old.execute_batch(OF_VERSION_1).unwrap();
    drop(old);
    let store = Store::open(&path).unwrap();
    let counted = store.read(|tx| tx.row("SELECT day, n FROM activity", &[])).unwrap().unwrap();
    assert_eq!((counted.int("day").unwrap(), counted.int("n").unwrap()), (1, 2), "counts of what was before");
    assert_eq!(task(&store), ("t".into(), String::new()));
    let aside = rusqlite::Connection::open(store.kept.as_ref().unwrap()).unwrap();
    let version: i64 = aside.query_row("SELECT max(version) FROM schema_version", [], |r| r.get(0)).unwrap();
    let tasks: i64 = aside.query_row("SELECT count(*) FROM tasks", [], |r| r.get(0)).unwrap();
    assert_eq!((version, tasks), (1, 1), "the copy is the store as it was");
    assert_eq!(Store::open(&path).unwrap().kept, None, "nothing to bring forward");

    // A store of a newer program is not changed.
    store.write(|tx| tx.run("INSERT INTO schema_version (version) VALUES (99)", &[])).unwrap();
    drop(store);
    assert_eq!(Store::open(&path).unwrap_err().code, "store.newer");
}

/// The content of a backup of `store`.
fn dump(store: &Store) -> Vec<u8> {
    let mut out = Vec::new();
    backup(store, &mut out).unwrap();
    out
}

fn fill(store: &Store) {
    put(store, "some_key");
    store
        .write(|tx| {
            tx.run(
                "INSERT INTO users (id, name, display, admin, lang, password_hash, disabled, created)
                 VALUES ('u', 'ann', '安<b>', 0, 'zh', 'h', 0, 5)",
                &[],
            )?;
            tx.run("INSERT INTO projects (id, name, guide, quota, settings, created) VALUES ('p', 'town', 'a\nb', '{}', '{}', 7)", &[])?;
            tx.run(
                "INSERT INTO members (project_id, user_id, roles, skills) VALUES ('p', 'u', '[\"lead\"]', '[]')",
                &[],
            )
        })
        .unwrap();
}

#[test]
fn a_backup_restores_into_either_store_and_back() {
    let dir = tempfile::tempdir().unwrap();
    let first = Store::open(&dir.path().join("first")).unwrap();
    fill(&first);
    let bytes = dump(&first);
    let second = Store::open(&dir.path().join("second")).unwrap();
    put(&second, "made on its first start");
    let of = |part: &[u8]| {
        let part = part.to_vec();
        move || Ok(Cursor::new(part.clone()))
    };
    restore(&second, of(&bytes)).unwrap();
    assert_eq!(String::from_utf8(dump(&second)).unwrap(), String::from_utf8(bytes.clone()).unwrap());

    assert_eq!(restore(&second, of(&bytes)).unwrap_err().code, "restore.not_empty");
    let third = Store::open(&dir.path().join("third")).unwrap();
    let cut = bytes.iter().rposition(|b| *b == b'{').unwrap();
    assert_eq!(restore(&third, of(&bytes[..cut])).unwrap_err().code, "restore.broken");
    assert_eq!(restore(&third, of(b"{}\n{}")).unwrap_err().code, "restore.broken");
    // One changed letter of a name.
    let at = bytes.windows(6).position(|w| w == b"\"town\"").unwrap();
    let mut edited = bytes.clone();
    edited[at + 1] = b'T';
    let told = restore(&third, of(&edited)).unwrap_err();
    assert!(told.code == "restore.broken" && told.text.en.contains("was changed"), "{told}");
    assert_eq!(names(&third), Vec::<String>::new(), "nothing of a broken backup is kept");
    // A backup of an earlier program states no hash.
    let text = String::from_utf8(bytes.clone()).unwrap();
    let (lines, _) = text.split_once(",\"sha256\"").unwrap();
    restore(&third, of(format!("{lines}}}\n").as_bytes())).unwrap();
    assert_eq!(names(&third), names(&first));

    let Some(server) = Server::start() else { return };
    let far = Store::open_keeping(&StoreLocation::parse(&server.database()), dir.path()).unwrap();
    restore(&far, of(&bytes)).unwrap();
    assert_eq!(dump(&far), bytes);
}

#[test]
fn an_older_postgresql_store_is_backed_up_before_and_the_backup_restores_into_either() {
    let dir = tempfile::tempdir().unwrap();
    let Some(server) = Server::start() else { return };
    let url = server.database();
    let mut client = postgres::Client::connect(&url, postgres::NoTls).unwrap();
    client.batch_execute(FIRST).unwrap();
    client.batch_execute(OF_VERSION_1).unwrap();
    let store = Store::open_keeping(&StoreLocation::parse(&url), dir.path()).unwrap();
    assert_eq!(task(&store), ("t".into(), String::new()));
    let kept = store.kept.clone().unwrap();
    assert_eq!(kept.parent(), Some(dir.path()));
    let text = std::fs::read_to_string(&kept).unwrap();
    assert!(text.starts_with(r#"{"schema_version":1,"whyroad_backup":1}"#), "{text}");
    // A backup of an older program is restored into a store of this one, of either kind.
    for place in [StoreLocation::File(dir.path().join("fresh")), StoreLocation::parse(&server.database())] {
        let fresh = Store::open_keeping(&place, dir.path()).unwrap();
        let from = kept.clone();
        let rows = restore(&fresh, move || Ok(BufReader::new(std::fs::File::open(&from)?))).unwrap();
        assert_eq!((rows, task(&fresh)), (4, ("t".into(), String::new())));
        assert_eq!(dump(&fresh), dump(&store));
        // Existing data is not mixed with restored data: even a project without users counts.
        let from = kept.clone();
        let again = restore(&fresh, move || Ok(BufReader::new(std::fs::File::open(&from)?)));
        assert_eq!(again.unwrap_err().code, "restore.not_empty");
    }
}

#[test]
fn a_large_store_comes_out_in_pages_and_a_backup_of_a_newer_program_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let store = Store::open(&dir.path().join("s")).unwrap();
    store
        .write(|tx| {
            // More than two pages, with keys that differ only in the second column.
            tx.run("INSERT INTO projects (id, name, guide, quota, settings, created) VALUES ('p', 'town', '', '{}', '{}', 7)", &[])?;
            for i in 0..2500_i64 {
                let user = format!("u{i:04}");
                tx.run(
                    "INSERT INTO users (id, name, display, admin, lang, password_hash, disabled, created)
                     VALUES ($1, $2, 'd', 0, 'zh', 'h', 0, 5)",
                    values![&user, &user],
                )?;
                let member =
                    "INSERT INTO members (project_id, user_id, roles, skills) VALUES ('p', $1, '[]', '[]')";
                tx.run(member, values![&user])?;
            }
            Ok(())
        })
        .unwrap();
    let bytes = dump(&store);
    let other = Store::open(&dir.path().join("other")).unwrap();
    let copy = bytes.clone();
    assert_eq!(restore(&other, move || Ok(Cursor::new(copy.clone()))).unwrap(), 5001);
    assert_eq!(dump(&other), bytes);

    let empty = Store::open(&dir.path().join("empty")).unwrap();
    for (head, why) in
        [(r#"{"whyroad_backup":1,"schema_version":99}"#, "supports up to"), ("", "empty"), ("[", "EOF")]
    {
        let told = restore(&empty, move || Ok(Cursor::new(head))).unwrap_err();
        assert!(told.code == "restore.broken" && told.text.en.contains(why), "{told}");
    }
    // An endless line does not fill the memory.
    let endless = || Ok(BufReader::new(std::io::repeat(b'x')));
    assert!(restore(&empty, endless).unwrap_err().text.en.contains("longer than"));
}

#[test]
fn a_text_that_only_one_of_the_databases_could_hold_is_refused_by_both() {
    let dir = tempfile::tempdir().unwrap();
    let check = |store: &Store| {
        let odd =
            store.write(|tx| tx.run("INSERT INTO settings (name, value) VALUES ($1, 'x')", values!["a\0b"]));
        assert_eq!(odd.unwrap_err().code, "text.nul");
        let odd = store.read(|tx| tx.rows("SELECT 1 FROM settings WHERE name = $1", values!["\0"]));
        assert_eq!(odd.unwrap_err().code, "text.nul");
    };
    check(&Store::open(&dir.path().join("s")).unwrap());
    let Some(server) = Server::start() else { return };
    check(&Store::open_keeping(&StoreLocation::parse(&server.database()), dir.path()).unwrap());
}

#[cfg(unix)]
#[test]
fn what_the_store_keeps_is_for_its_owner_alone() {
    use std::os::unix::fs::PermissionsExt as _;
    let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("whyroad-data");
    let store = Store::open(&folder.join("labels.db")).unwrap();
    put(&store, "a");
    assert_eq!(mode(&folder), 0o700);
    for name in ["labels.db", "labels.db-wal", "labels.db-shm"] {
        assert_eq!(mode(&folder.join(name)), 0o600, "{name}");
    }
    drop(store);
    // Access of other users to a file of an older version is removed when it is opened.
    std::fs::set_permissions(folder.join("labels.db"), std::fs::Permissions::from_mode(0o644)).unwrap();
    let _again = Store::open(&folder.join("labels.db")).unwrap();
    assert_eq!(mode(&folder.join("labels.db")), 0o600);
}

/// A webhook's signing key and the CSRF key as stored in the tables.
fn stored_secrets(store: &Store) -> Vec<String> {
    let sql =
        "SELECT secret AS value FROM webhooks UNION ALL SELECT value FROM settings WHERE name = 'csrf_key'";
    store.read(|tx| tx.rows(sql, &[])).unwrap().iter().map(|r| r.text("value").unwrap()).collect()
}

fn with_secrets(store: &Store) {
    store
        .write(|tx| {
            tx.run("INSERT INTO projects (id, name, guide, quota, settings, created) VALUES ('p', 'p', '', '{}', '{}', 0)", &[])?;
            tx.run(
                "INSERT INTO webhooks (id, project_id, url, events, secret, created)
                 VALUES ('w', 'p', 'http://a', '[]', 'plain-secret', 0)",
                &[],
            )?;
            tx.run("INSERT INTO settings (name, value) VALUES ('csrf_key', 'plain-csrf')", &[])
        })
        .unwrap();
}

#[test]
fn secrets_of_an_older_program_are_sealed_and_go_on_working_under_a_new_key() {
    let dir = tempfile::tempdir().unwrap();
    let place = dir.path().join("s");
    with_secrets(&Store::open(&place).unwrap());
    let store = Store::open(&place).unwrap();
    let secrets = stored_secrets(&store);
    assert!(secrets.iter().all(|s| s.starts_with("sealed:v1:")), "{secrets:?}");
    let opened = |store: &Store| {
        let secrets = stored_secrets(store);
        ["webhook:w", "setting:csrf_key"]
            .iter()
            .zip(secrets)
            .map(|(p, s)| store.vault.open_text(p, &s).unwrap())
            .collect::<Vec<_>>()
    };
    assert_eq!(opened(&store), ["plain-secret", "plain-csrf"]);
    let before = std::fs::read_to_string(store.vault.path()).unwrap();
    assert_eq!(store.rotate_key().unwrap(), 2);
    assert_ne!(std::fs::read_to_string(store.vault.path()).unwrap(), before);
    assert_ne!(stored_secrets(&store), secrets);
    assert_eq!(opened(&Store::open(&place).unwrap()), ["plain-secret", "plain-csrf"], "after a restart");
}

#[test]
fn a_backup_needs_its_key() {
    let dir = tempfile::tempdir().unwrap();
    let place = dir.path().join("first");
    with_secrets(&Store::open(&place).unwrap());
    let first = Store::open(&place).unwrap();
    let bytes = dump(&first);
    assert!(!String::from_utf8_lossy(&bytes).contains("plain-"), "a backup holds no secret in plain text");
    let taken = bytes.clone();
    let other = Store::open(&dir.path().join("other")).unwrap();
    let refused = restore(&other, move || Ok(Cursor::new(taken.clone()))).unwrap_err();
    assert_eq!(refused.code, "store.key");
    let second = dir.path().join("second");
    std::fs::copy(first.vault.path(), dir.path().join("second.key")).unwrap();
    let second = Store::open(&second).unwrap();
    restore(&second, move || Ok(Cursor::new(bytes.clone()))).unwrap();
    assert_eq!(stored_secrets(&second), stored_secrets(&first));
    // A store whose key file was lost does not start with a new one.
    drop(first);
    std::fs::remove_file(dir.path().join("first.key")).unwrap();
    let refused = Store::open(&place).unwrap_err();
    assert!(refused.code == "store.key" && refused.text.en.contains("WHYROAD_KEY_FILE"), "{refused}");
    assert!(!dir.path().join("first.key").exists(), "no key is made that opens nothing");
}
