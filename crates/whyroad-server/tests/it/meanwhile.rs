//! Changes of accounts while a request that was permitted before still hashes a password.

use crate::world::{PASSWORD, Reply, World};
use serde_json::json;
use whyroad_server::service::people;

/// Runs `meanwhile` while `request` waits for the turn to hash a password.
fn while_it_hashes(world: &World, request: impl FnOnce() -> Reply + Send, meanwhile: impl FnOnce()) -> Reply {
    let (free, is_free) = std::sync::mpsc::channel::<()>();
    let (busy, is_busy) = std::sync::mpsc::channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            world.app.limits.one_at_a_time(|| {
                busy.send(()).unwrap();
                is_free.recv().unwrap();
            });
        });
        is_busy.recv().unwrap();
        let answer = scope.spawn(request);
        // Beside the one above: it has passed the access check and read the account by then.
        while world.app.limits.hashes() < 2 {
            assert!(!answer.is_finished(), "answered without a password hash");
            std::thread::yield_now();
        }
        meanwhile();
        free.send(()).unwrap();
        answer.join().unwrap()
    })
}

pub fn who_is_disabled_while_a_password_is_hashed_stays_so(world: &World) {
    let admin = world.admin();
    let body = json!({ "name": "ada", "password": PASSWORD, "admin": true });
    let ada = admin.post("/users", &body).fine()["id"].as_str().unwrap().to_owned();
    let (own, signed_in) = (format!("/users/{ada}"), world.sign_in("ada"));
    let change = json!({ "password": "another horse", "present_password": PASSWORD });
    let end = || drop(admin.patch(&own, &json!({ "disabled": true, "admin": false })).fine());
    let answer = while_it_hashes(world, || signed_in.patch(&own, &change), end);
    assert_eq!(answer.refusal(), (401, "session.required".into()));
    let users = admin.get("/users").fine();
    let now = users["items"].as_array().unwrap().iter().find(|u| u["name"] == "ada").unwrap();
    assert_eq!((&now["disabled"], &now["admin"]), (&json!(true), &json!(false)));

    // Nor do they create an account.
    admin.patch(&own, &json!({ "disabled": false, "admin": true })).fine();
    let signed_in = world.sign_in("ada");
    let body = json!({ "name": "eva", "password": "another horse", "admin": true });
    let end = || drop(admin.patch(&own, &json!({ "admin": false })).fine());
    let answer = while_it_hashes(world, || signed_in.post("/users", &body), end);
    assert_eq!(answer.refusal(), (403, "access.denied".into()));
}

pub fn an_old_password_opens_nothing_once_it_was_replaced(world: &World) {
    let admin = world.admin();
    let ann = world.person(&admin, "", "ann", &[]);
    let mut old = world.unauthenticated();
    old.hello();
    // Replaced in the store, as the command line does it.
    let replace = |hash: &str| {
        let (id, hash) = (ann.id.clone(), hash.to_owned());
        world.app.store.write(move |tx| people::set_password(tx, &id, &hash)).unwrap();
    };
    let hash = whyroad_server::secret::hash_password("third horse").unwrap();
    let body = json!({ "name": "ann", "password": PASSWORD });
    let answer = while_it_hashes(world, || old.post("/session", &body), || replace(&hash));
    assert_eq!(answer.refusal(), (401, "session.wrong".into()));
}
