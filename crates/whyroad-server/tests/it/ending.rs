//! The end of the service: requests in progress are finished, no new ones are accepted.

use crate::postgres_server::Server;
use crate::recorded::{Future, Recorded, Watched};
use crate::world::{Person, World};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::{Duration, Instant};
use whyroad_framework::Framework;
use whyroad_server::App;
use whyroad_server::store::{Store, StoreLocation};

#[test]
fn what_was_begun_is_finished_when_the_service_ends() {
    let dir = tempfile::tempdir().unwrap();
    let store = Store::open(&dir.path().join("s")).unwrap();
    let recordings = Recorded { future: Future::Brakes, pictures: dir.path().to_path_buf() };
    let app = Arc::new(App::new(store, Framework::bundled(), Arc::new(recordings)).unwrap());
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
    let listener = runtime.block_on(tokio::net::TcpListener::bind("127.0.0.1:0")).unwrap();
    let address = listener.local_addr().unwrap();
    let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
    let served = runtime.spawn(whyroad_server::serve(app, listener, async move {
        let _ = stopped.await;
    }));

    // An incomplete request.
    let mut half = TcpStream::connect(address).unwrap();
    half.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    half.write_all(
        b"POST /api/v1/session HTTP/1.1\r\nhost: t\r\ncontent-length: 2\r\nconnection: close\r\n\r\n{",
    )
    .unwrap();
    // An idle connection.
    let _idle = TcpStream::connect(address).unwrap();
    std::thread::sleep(Duration::from_millis(300));
    stop.send(()).unwrap();
    let start = Instant::now();
    // From now on no new connection is accepted.
    let refuses = || match TcpStream::connect_timeout(&address, Duration::from_secs(1)) {
        Err(_) => true,
        Ok(mut late) => {
            late.set_read_timeout(Some(Duration::from_millis(500))).unwrap();
            let _ = late.write_all(b"GET /api/v1/healthz HTTP/1.1\r\nhost: t\r\n\r\n");
            late.read(&mut [0; 16]).map_or(true, |n| n == 0)
        }
    };
    while !refuses() {
        assert!(start.elapsed() < Duration::from_secs(30), "still takes new requests");
    }
    half.write_all(b"}").unwrap();
    let mut answer = String::new();
    half.read_to_string(&mut answer).unwrap();
    // No CSRF value was sent: the response is a refusal, but a complete one.
    assert!(answer.starts_with("HTTP/1.1 403") && answer.contains("session.csrf"), "{answer}");
    drop(half);
    let ended = runtime.block_on(async { tokio::time::timeout(Duration::from_secs(60), served).await });
    assert!(ended.unwrap().unwrap().is_ok(), "and then it ends, whoever is still connected");
}

/// The last owner of the service may be a task of the runtime: closing PostgreSQL's connections there must not panic.
#[test]
fn a_service_on_postgresql_ends_without_a_panic() {
    let Some(server) = Server::start() else { return };
    let dir = tempfile::tempdir().unwrap();
    let store = Store::open_keeping(&StoreLocation::parse(&server.database()), dir.path()).unwrap();
    let recordings = Recorded { future: Future::Brakes, pictures: dir.path().to_path_buf() };
    let app = Arc::new(App::new(store, Framework::bundled(), Arc::new(recordings)).unwrap());
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
    let ended = runtime.block_on(async {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        tokio::spawn(async move {
            let served = whyroad_server::serve(Arc::clone(&app), listener, async {}).await;
            // The thread of the webhooks releases it within a second.
            while Arc::strong_count(&app) > 1 {
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
            drop(app);
            served
        })
        .await
    });
    assert!(ended.expect("no panic").is_ok());
}

/// A derivation that never ends.
fn endless() {
    loop {
        std::thread::sleep(Duration::from_secs(1));
    }
}

/// A derivation that hangs, in a request and in the background, does not keep the service from stopping: within the 15
/// s for requests, and the 2 s that the binary waits for the rest (`cmd/serve.rs`).
#[test]
fn the_service_ends_within_twenty_seconds_while_derivations_hang() {
    let world = World::on_sqlite(Future::Brakes);
    let admin = world.admin();
    let project = world.project(&admin, "town", &serde_json::json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let task = world.tasks(&admin, &project, &["drive1"], 1)[0].clone();
    ann.post(&format!("/tasks/{task}/lease"), &serde_json::json!({ "action": "take" })).fine();
    let app = world.second(|app| {
        let drives = Recorded { future: Future::Brakes, pictures: std::env::temp_dir() };
        app.recordings = Arc::new(Watched { drives, before_signals: endless, clips: Arc::default() });
    });
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
    let listener = runtime.block_on(tokio::net::TcpListener::bind("127.0.0.1:0")).unwrap();
    let address = listener.local_addr().unwrap();
    let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
    let served = runtime.spawn(whyroad_server::serve(app, listener, async move {
        let _ = stopped.await;
    }));
    // Tasks whose drafts are never finished, and a scene that is never finished.
    world.tasks(&Person { address, ..admin }, &project, &["drive2", "drive3"], 1);
    let mut hangs = TcpStream::connect(address).unwrap();
    let cookie = ann.cookie.unwrap();
    let request = format!("GET /api/v1/tasks/{task}/scene HTTP/1.1\r\nhost: t\r\ncookie: {cookie}\r\n\r\n");
    hangs.write_all(request.as_bytes()).unwrap();
    std::thread::sleep(Duration::from_millis(700));
    let start = Instant::now();
    stop.send(()).unwrap();
    let ended = runtime.block_on(async { tokio::time::timeout(Duration::from_secs(30), served).await });
    assert!(ended.unwrap().unwrap().is_ok());
    runtime.shutdown_timeout(Duration::from_secs(2));
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
}
