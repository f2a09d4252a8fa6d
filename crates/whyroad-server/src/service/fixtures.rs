//! For unit tests: a service on an empty store with the project `p` and no drives, and a task of it. The store is a
//! SQLite file, or a database of a real PostgreSQL while [`again_on_postgresql`] repeats the tests.

use crate::domain::scene::SignalAbout;
#[path = "../../tests/it/postgres_server.rs"]
#[allow(dead_code, reason = "restarts are for other tests")]
mod postgres;

use self::postgres::Server;
use crate::app::App;
use crate::domain::workflow::{Position, State};
use crate::recordings::Recordings;
use crate::service::tasks::TaskRow;
use crate::store::{Store, StoreLocation};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use whyroad_framework::Framework;
use whyroad_label::check::Recorded as CheckedDrive;
use whyroad_model::messages::{
    CocLabel, CriticalComponent, EpisodeCursor, EpisodeFilter, EpisodePage, EpisodeRecord,
};
use whyroad_model::scene::{Ego, MediaFrame, Motion};
use whyroad_model::{Bilingual, Drive, DriveId, Lang, Nanos, SignalTable};

/// No drives, or all drives except `absent`, each with two frames around the fixtures' keyframes; counts how often they
/// are read and derived.
#[derive(Default)]
pub struct Counted {
    pub some: bool,
    /// Labels are compared with recordings, which are there or not.
    pub compares: bool,
    pub recorded: AtomicBool,
    pub read: AtomicUsize,
    pub derived: AtomicUsize,
}

impl Recordings for Counted {
    fn drive(&self, id: &DriveId) -> Result<Arc<Drive>, Bilingual> {
        self.read.fetch_add(1, Ordering::SeqCst);
        let (first, last) = self.span(id)?;
        let motion = Motion { x: vec![0.0; 2], y: vec![0.0; 2], heading: vec![0.0; 2], ..Motion::default() };
        let ego = Some(Ego { motion, ..Ego::default() });
        let mut drive = Drive { times: vec![first, last], ego, ..Drive::default() };
        drive.meta.drive_id = id.clone();
        Ok(Arc::new(drive))
    }
    fn span(&self, id: &DriveId) -> Result<(Nanos, Nanos), Bilingual> {
        if !self.some {
            return Err(Bilingual::same(format!("no drive {id}")));
        }
        if id.as_str() == "absent" {
            return Err(Bilingual::same("no such drive"));
        }
        let time = |text: &str| Nanos::parse_iso(text).unwrap();
        Ok((time("2026-01-01T00:00:00Z"), time("2026-01-01T00:00:09Z")))
    }
    fn signals(&self, _: &Drive) -> SignalTable {
        assert!(self.some, "no drive was given");
        self.derived.fetch_add(1, Ordering::SeqCst);
        SignalTable::default()
    }
    fn about(&self, _: &str) -> Option<SignalAbout> {
        None
    }
    fn draft(
        &self,
        _: &Drive,
        _: &SignalTable,
        _: &EpisodeRecord,
        _: Lang,
        _: Option<&[CriticalComponent]>,
    ) -> CocLabel {
        assert!(self.some, "no drive was given");
        let draft = json!({
            "version": "2.1.0", "clip_id": "d_000",
            "scenario": {"l1": "reactive_agent", "l2": "cutin", "l3": "normal"},
            "time_range": {"start_timestamp": "2026-01-01T00:00:01.000Z", "end_timestamp": "2026-01-01T00:00:05.000Z"},
            "keyframe": {"timestamp": "2026-01-01T00:00:02.000Z", "frame_idx": 10, "type": "reactive"},
            "driving_decision": {"longitudinal": null, "lateral": null},
            "critical_components": [], "coc_trace": "drafted",
        });
        serde_json::from_value(draft).unwrap()
    }
    fn compares(&self) -> bool {
        self.compares
    }
    fn recorded(&self, _: &str) -> Option<Arc<CheckedDrive>> {
        self.recorded.load(Ordering::SeqCst).then(Arc::default)
    }
    fn recorded_until(&self, clip: &str, _: Nanos) -> Option<Arc<CheckedDrive>> {
        self.recorded(clip)
    }
    fn mined(&self) -> Vec<String> {
        vec![]
    }
    fn episode_count(&self, _: &str, _: &EpisodeFilter) -> Option<Result<u64, Bilingual>> {
        None
    }
    fn episodes(
        &self,
        _: &str,
        _: &EpisodeFilter,
        _: Option<EpisodeCursor>,
        _: usize,
    ) -> Option<Result<EpisodePage, Bilingual>> {
        None
    }
    fn media(&self, _: &DriveId, _: &MediaFrame) -> Option<PathBuf> {
        None
    }
}

/// The service with such drives, and a folder for its store.
pub fn counted() -> (App, Arc<Counted>, tempfile::TempDir) {
    let (mut app, dir) = app();
    let recordings = Arc::new(Counted { some: true, ..Counted::default() });
    app.recordings = Arc::clone(&recordings) as Arc<dyn Recordings>;
    (app, recordings, dir)
}

thread_local! {
    /// The server for the stores of this thread's tests; `None` for files.
    static SERVER: RefCell<Option<Server>> = const { RefCell::new(None) };
}

/// Repeats the tests of a file, each on its own database; `source` is the file, so that none is omitted.
pub fn again_on_postgresql(source: &str, tests: &[fn()]) {
    let there = source.lines().filter(|l| l.trim() == "#[test]").count();
    assert_eq!(there, tests.len(), "each test of the file is named in on_postgresql!");
    let Some(server) = Server::start() else { return };
    SERVER.set(Some(server));
    tests.iter().for_each(|test| test());
    // Here, not at the end of the thread: the server must stop before the test ends.
    SERVER.take();
}

/// Lists the tests of `tests.rs` that also run on PostgreSQL.
macro_rules! on_postgresql {
    ($($name:ident),+ $(,)?) => {
        #[test]
        fn the_same_on_postgresql() {
            crate::service::fixtures::again_on_postgresql(include_str!("tests.rs"), &[$($name),+]);
        }
    };
}
pub(crate) use on_postgresql;

/// The service, and a folder for its store.
pub fn app() -> (App, tempfile::TempDir) {
    let dir = tempfile::tempdir().unwrap();
    let server = SERVER.with_borrow(|s| s.as_ref().map(|s| StoreLocation::parse(&s.database())));
    let place = server.unwrap_or_else(|| StoreLocation::File(dir.path().join("s.db")));
    let store = Store::open_keeping(&place, dir.path()).unwrap();
    let app = App::new(store, Framework::bundled(), Arc::new(Counted::default())).unwrap();
    let insert = "INSERT INTO projects (id, name, guide, quota, settings, created) VALUES ('p', 'p', '', '{}', '{}', 0)";
    app.store.write(move |tx| tx.run(insert, &[])).unwrap();
    (app, dir)
}

/// An episode as mining writes it.
pub fn episode(id: &str) -> Value {
    json!({
        "episode_id": id, "scenario_id": "a.b.c", "drive_id": "d", "clip_id": "d_000",
        "time_range": {"start_timestamp": "2026-01-01T00:00:00Z", "end_timestamp": "2026-01-01T00:00:09Z"},
        "keyframe": {"timestamp": "2026-01-01T00:00:05Z", "frame_idx": 50, "type": "reactive"}, "score": 1.0,
        "is_primary": true, "keyframe_rule": {"zh": "", "en": ""}, "conditions_matched": [], "signals": [],
    })
}

/// A submitted task of the project `p`.
pub fn task() -> TaskRow {
    TaskRow {
        id: "t".into(),
        project: "p".into(),
        overlap_index: 0,
        overlap_count: 1,
        drive_id: "d".into(),
        clip_id: "d_000".into(),
        scenario_id: "a.b.c".into(),
        keyframe_ns: 0,
        from_ns: 0,
        to_ns: 0,
        episode: serde_json::from_value(episode("e")).unwrap(),
        initial: json!({}),
        draft: json!({ "coc_trace": "nobody else's business" }),
        version: 3,
        priority: 0,
        at: Position { state: State::Submitted, ..Position::open() },
        audited: false,
        adjudication: None,
        assigned: None,
        fence: 0,
        lease_until: None,
        seq: 1,
        created: 0,
        updated: 0,
        lang: String::new(),
        asks_lead: false,
        disagrees: false,
        to_choose: false,
        pictured: false,
        imported: false,
        pending: false,
        veiled: false,
        right_class: None,
        replaced_by: None,
        replaces: None,
        findings: Default::default(),
        thumbnail: String::new(),
    }
}
