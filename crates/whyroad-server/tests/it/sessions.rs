//! Sessions, CSRF, passwords, rate limit, tokens, accounts.

use crate::world::{PASSWORD, World};
use serde_json::json;
use whyroad_server::values;

pub fn the_first_run_makes_one_admin_and_no_second(world: &World) {
    let mut unauthenticated = world.unauthenticated();
    let first = unauthenticated.hello();
    assert_eq!(first.json()["first_run"], true);
    assert!(first.json()["user"].is_null());
    let short = json!({ "name": "eve", "display": "Eve", "password": "short" });
    assert_eq!(unauthenticated.post("/setup", &short).refusal(), (422, "password.length".into()));
    // Another site whose host name was made to resolve to this machine.
    let body = json!({ "name": "eve", "display": "Eve", "password": PASSWORD }).to_string();
    for host in ["evil.example", "evil.example:8080", "localhost.evil.example", "[evil]", ""] {
        let answer = unauthenticated.call("POST", "/setup", Some(body.as_bytes()), &[("host", host)]);
        assert_eq!(answer.refusal(), (403, "setup.host".into()), "{host}");
    }
    world.admin();
    let late = json!({ "name": "eve", "display": "Eve", "password": PASSWORD });
    assert_eq!(unauthenticated.post("/setup", &late).refusal(), (409, "setup.done".into()));
    assert_eq!(unauthenticated.hello().json()["first_run"], false);
}

pub fn cookies_and_headers_are_safe(world: &World) {
    let mut unauthenticated = world.unauthenticated();
    let answer = unauthenticated.hello();
    let cookie = answer.header("set-cookie").unwrap();
    for word in ["HttpOnly", "SameSite=Lax", "Path=/"] {
        assert!(cookie.contains(word), "{cookie}");
    }
    assert_eq!(answer.header("x-content-type-options"), Some("nosniff"));
    assert_eq!(answer.header("content-type"), Some("application/json"));
    assert!(answer.header("content-security-policy").unwrap().contains("default-src 'none'"));
    let page = unauthenticated.raw("GET", "/projects/x/tasks", None, &[]);
    assert_eq!((page.status, page.header("content-type")), (200, Some("text/html; charset=utf-8")));
    let policy = page.header("content-security-policy").unwrap();
    assert!(policy.contains("default-src 'self'") && !policy.contains("script-src 'unsafe"), "{policy}");
    assert_eq!(unauthenticated.raw("GET", "/assets/none.js", None, &[]).status, 404);
    assert_eq!(unauthenticated.raw("GET", "/api/v2/session", None, &[]).refusal(), (404, "not_found".into()));
    assert_eq!(
        unauthenticated.raw("GET", "/../../etc/passwd", None, &[]).header("content-type"),
        page.header("content-type")
    );

    // The cookie changes at sign-in: a planted one is useless.
    let planted = unauthenticated.cookie.clone();
    let admin = world.admin();
    assert_ne!(admin.cookie, planted);
    let mut second = world.unauthenticated();
    second.hello();
    let before = second.cookie.clone();
    let signed = second.post("/session", &json!({ "name": "admin", "password": PASSWORD }));
    second.keep(&signed);
    assert_ne!(second.cookie, before);
    second.cookie = before;
    assert!(second.get("/session").json()["user"].is_null());
}

pub fn writing_needs_the_csrf_value_of_the_session(world: &World) {
    let admin = world.admin();
    let body = json!({ "name": "p" });
    for csrf in
        [None, Some(String::new()), Some("0".repeat(64)), admin.csrf.as_ref().map(|c| c[1..].to_owned())]
    {
        let mut forged = admin.clone();
        forged.csrf = csrf;
        assert_eq!(forged.post("/projects", &body).refusal(), (403, "session.csrf".into()));
    }
    let mut other = world.unauthenticated();
    other.hello();
    let mut crossed = admin.clone();
    crossed.csrf.clone_from(&other.csrf);
    assert_eq!(
        crossed.post("/projects", &body).refusal(),
        (403, "session.csrf".into()),
        "another session's value"
    );
    // Signing in, too: otherwise a user could be signed in as another one.
    other.csrf = None;
    let sign_in = json!({ "name": "admin", "password": PASSWORD });
    assert_eq!(other.post("/session", &sign_in).refusal(), (403, "session.csrf".into()));
    admin.post("/projects", &body).fine();
}

pub fn sessions_end(world: &World) {
    let admin = world.admin();
    let again = world.sign_in("admin");
    assert_eq!(again.call("DELETE", "/session", None, &[]).status, 200);
    assert_eq!(again.get("/users").refusal(), (401, "session.required".into()));
    admin.get("/users").fine();
    world.wait(15 * 24 * 3600);
    assert_eq!(admin.get("/users").refusal(), (401, "session.required".into()));
}

pub fn guessing_passwords_is_slowed(world: &World) {
    let admin = world.admin();
    world.person(&admin, "", "ann", &[]);
    let mut unauthenticated = world.unauthenticated();
    unauthenticated.hello();
    let wrong =
        |name: &str| unauthenticated.post("/session", &json!({ "name": name, "password": "wrong horse" }));
    for _ in 0..5 {
        assert_eq!(wrong("ann").refusal(), (401, "session.wrong".into()));
    }
    let waits = wrong("ann");
    assert_eq!(waits.refusal(), (429, "session.wait".into()));
    assert_eq!(waits.json()["more"]["retry_after_s"], 1);
    let right = json!({ "name": "ann", "password": PASSWORD });
    assert_eq!(unauthenticated.post("/session", &right).refusal().0, 429, "even the right one waits");
    assert_eq!(wrong("admin").refusal().0, 401, "others do not");
    world.wait(2);
    unauthenticated.post("/session", &right).fine();
    assert_eq!(wrong("ann").refusal().0, 401, "and the count starts again");
    // An unknown user cannot be distinguished from a known one.
    assert_eq!(wrong("nobody").json()["detail_en"], wrong("ann").json()["detail_en"]);
}

pub fn passwords_and_tokens_are_kept_as_hashes(world: &World) {
    let admin = world.admin();
    let made = admin.post("/tokens", &json!({ "name": "script" })).fine();
    let token = made["token"].as_str().unwrap().to_owned();
    let stored = world
        .app
        .store
        .read(|tx| {
            let password = tx.row("SELECT password_hash FROM users", &[])?.unwrap().text("password_hash")?;
            let token = tx.row("SELECT hash FROM api_tokens", &[])?.unwrap().text("hash")?;
            let session = tx.row("SELECT hash FROM sessions", values![])?.unwrap().text("hash")?;
            Ok((password, token, session))
        })
        .unwrap();
    assert!(stored.0.starts_with("$argon2id$v=19$m=19456,t=2,p=1$"), "OWASP's least: {}", stored.0);
    assert_ne!(stored.1, token);
    assert!(!admin.cookie.as_ref().unwrap().contains(&stored.2));

    // A token needs no cookie and no CSRF value; it is shown once.
    let mut script = world.unauthenticated();
    script.token = Some(token);
    script.post("/projects", &json!({ "name": "by script" })).fine();
    let listed = script.get("/tokens").fine();
    assert!(listed["items"][0].get("token").is_none());
    let id = made["id"].as_str().unwrap();
    let other = world.person(&admin, "", "ann", &[]);
    assert_eq!(
        other.call("DELETE", &format!("/tokens/{id}"), None, &[]).status,
        404,
        "only the caller's own"
    );
    assert_eq!(admin.call("DELETE", &format!("/tokens/{id}"), None, &[]).status, 200);
    assert_eq!(script.get("/tokens").refusal(), (401, "session.required".into()));
    // A valid cookie does not replace a wrong token.
    let mut both = admin.clone();
    both.token = Some("wr_0".into());
    assert_eq!(both.get("/users").refusal().0, 401);
}

pub fn no_two_people_have_one_display_name(world: &World) {
    let admin = world.admin();
    let make = |name: &str, display: &str| {
        admin.post("/users", &json!({ "name": name, "display": display, "password": PASSWORD }))
    };
    let ann = make("ann", "Ann Li").fine();
    let taken = (409, "user.display_taken".to_owned());
    // Another case, full-width letters, a no-break space, a zero-width space.
    for display in ["ann li", "\u{ff21}nn Li", "Ann\u{a0}Li", "A\u{200b}nn Li "] {
        let refused = make("bob", display);
        assert_eq!(refused.refusal(), taken, "{display:?}");
        assert!(refused.json()["detail_en"].as_str().unwrap().contains("choose another one"));
    }
    assert_eq!(make("bob", "\u{3164}").refusal(), (422, "user.display".into()));
    assert_eq!(make("ANN LI", "x").refusal(), (422, "user.name".into()));
    let bob = make("bob", "Bob").fine();
    // A name that is given by default is a display name, too.
    assert_eq!(admin.post("/users", &json!({ "name": "BOB", "password": PASSWORD })).refusal(), taken);
    let rename = |user: &serde_json::Value, to: &str| {
        admin.patch(&format!("/users/{}", user["id"].as_str().unwrap()), &json!({ "display": to }))
    };
    assert_eq!(rename(&bob, "ANN LI").refusal(), taken);
    assert_eq!(rename(&bob, "BOB").fine()["display"], "BOB", "one's own name in another case");
    // Equal names from before stay until they are changed.
    let id = bob["id"].as_str().unwrap().to_owned();
    world
        .app
        .store
        .write(move |tx| {
            tx.run("UPDATE users SET display = 'Ann Li' WHERE id = $1", whyroad_server::values![&id])
        })
        .unwrap();
    let off = format!("/users/{}", bob["id"].as_str().unwrap());
    assert_eq!(admin.patch(&off, &json!({ "lang": "en" })).fine()["display"], "Ann Li");
    assert_eq!(rename(&ann, "Ann LI").refusal(), taken);
    assert_eq!(rename(&ann, "Ann Li (2)").status, 200);
    // Of many at once one gets a name.
    let statuses: Vec<u16> = std::thread::scope(|scope| {
        let make = &make;
        let asked: Vec<_> =
            (0..4).map(|n| scope.spawn(move || make(&format!("c{n}"), "Chen").status)).collect();
        asked.into_iter().map(|a| a.join().unwrap()).collect()
    });
    assert_eq!(statuses.iter().filter(|s| **s == 200).count(), 1, "{statuses:?}");
}

pub fn people_change_themselves_and_admins_everybody(world: &World) {
    let admin = world.admin();
    let ann = world.person(&admin, "", "ann", &[]);
    let path = format!("/users/{}", ann.id);
    assert_eq!(ann.patch(&path, &json!({ "lang": "en", "display": "安" })).fine()["lang"], "en");
    assert_eq!(ann.patch(&path, &json!({ "admin": true })).refusal(), (403, "access.denied".into()));
    assert_eq!(ann.patch(&path, &json!({ "disabled": false })).refusal().0, 403);
    assert_eq!(ann.patch(&format!("/users/{}", admin.id), &json!({ "display": "x" })).refusal().0, 403);
    assert_eq!(
        ann.patch("/users/nobody", &json!({ "display": "x" })).refusal().0,
        403,
        "who is there is not told"
    );
    let change = json!({ "password": "another horse", "present_password": "wrong" });
    assert_eq!(ann.patch(&path, &change).refusal(), (403, "password.present".into()));
    let change = json!({ "password": "another horse", "present_password": PASSWORD });
    ann.patch(&path, &change).fine();
    assert_eq!(ann.get("/users").refusal().0, 401, "a new password ends all sessions");

    let own = format!("/users/{}", admin.id);
    assert_eq!(admin.patch(&own, &json!({ "admin": false })).refusal(), (409, "user.last_admin".into()));
    assert_eq!(admin.patch(&own, &json!({ "disabled": true })).refusal(), (409, "user.last_admin".into()));
    let bob = world.person(&admin, "", "bob", &[]);
    admin.patch(&format!("/users/{}", bob.id), &json!({ "disabled": true })).fine();
    assert_eq!(bob.get("/users").refusal().0, 401);
    let mut back = world.unauthenticated();
    back.hello();
    assert_eq!(back.post("/session", &json!({ "name": "bob", "password": PASSWORD })).refusal().0, 401);
}
