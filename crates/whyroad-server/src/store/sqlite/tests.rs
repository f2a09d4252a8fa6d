//! The log of changes with readers that never pause.

use super::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

#[test]
fn the_log_of_changes_stays_short_though_somebody_always_reads() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("store.sqlite");
    let long = 1 << 20;
    let (store, _) = Sqlite::open_with_log(&path, long).unwrap();
    let log = || std::fs::metadata(dir.path().join("store.sqlite-wal")).map_or(0, |about| about.len());
    let value = |purpose: Purpose| {
        let mut last = String::new();
        let sql = "SELECT value FROM settings WHERE name = 'x'";
        let mut job = |tx: &mut dyn Tx| {
            last = tx.row(sql, &[])?.map_or(Ok(String::new()), |row| row.text("value"))?;
            // Reads overlap: when one ends, others are still running.
            std::thread::sleep(Duration::from_millis(3));
            Ok(())
        };
        store.read(purpose, &mut job).unwrap();
        last
    };
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for purpose in [Purpose::Work, Purpose::Work, Purpose::Work, Purpose::Report, Purpose::Report] {
            let (stop, value) = (&stop, &value);
            scope.spawn(move || {
                while !stop.load(Ordering::SeqCst) {
                    value(purpose);
                }
            });
        }
        // About ten times the length at which the log is emptied.
        for n in 0..100 {
            let text = format!("{n}").repeat(1 << 16);
            let sql = "INSERT INTO settings VALUES ('x', $1) ON CONFLICT (name) DO UPDATE SET value = $1";
            store.write(Box::new(move |tx| tx.run(sql, crate::values![&text]).map(drop))).unwrap();
        }
        // It is emptied as soon as the current readers have ended, however many begin after them.
        let given_up = Instant::now() + Duration::from_secs(120);
        while log() >= long && Instant::now() < given_up {
            std::thread::sleep(Duration::from_millis(10));
        }
        stop.store(true, Ordering::SeqCst);
    });
    assert!(log() < long, "{}", log());
    assert!(value(Purpose::Work).starts_with("9999"), "nothing is lost");
}
