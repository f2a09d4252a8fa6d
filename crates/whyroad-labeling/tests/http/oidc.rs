//! Signing in at an identity provider: the whole way with real redirects and real keys, and what must not go through.

use crate::provider::{CLIENT, Fault, Provider, SECRET, ann, form};
use crate::signer::Key;
use crate::world::{NOON, PASSWORD, Person, Reply, World};
use serde_json::{Value, json};
use whyroad_labeling::oidc::settings::{Accounts, Secret, Settings, Written};
use whyroad_labeling::values;

/// A provider, and a service beside `world` on its store that lets people in from there.
fn town(world: &World, key: Key, more: impl FnOnce(&mut Written)) -> (Provider, World) {
    let provider = Provider::start(key, world.clock.clone());
    let mut written = Written {
        issuer: Some(provider.issuer()),
        client_id: Some(CLIENT.into()),
        client_secret: Some(Secret(SECRET.into())),
        name: Some("Town".into()),
        public_url: Some("http://127.0.0.1:1".into()),
        ..Written::default()
    };
    more(&mut written);
    let settings = Settings::resolve(written).unwrap().unwrap();
    provider.redirects_to(&settings.redirect_uri());
    let service = world.beside(|app| {
        app.oidc = Some(whyroad_labeling::oidc::provider::Provider::new(settings, None).unwrap());
    });
    (provider, service)
}

/// A conditions file in short.
fn written(more: Value) -> Written {
    serde_json::from_value(more).unwrap()
}

/// Goes to the provider and comes back; the query with which it does.
fn there_and_back(person: &Person, provider: &Provider, purpose: &str) -> Value {
    let begun = person.post("/oidc/begin", &json!({ "purpose": purpose })).fine();
    let url = begun["url"].as_str().unwrap();
    let path = url.strip_prefix(&provider.issuer()).unwrap();
    let mut browser = person.clone();
    (browser.address, browser.cookie, browser.csrf) = (provider.address, None, None);
    let answer = browser.raw("GET", path, None, &[]);
    assert_eq!(answer.status, 303, "{}", answer.text());
    let back = answer.header("location").unwrap().strip_prefix("http://127.0.0.1:1").unwrap();
    // What the browser opens there is the page, which hands the query on.
    assert_eq!(person.raw("GET", back, None, &[]).header("content-type"), Some("text/html; charset=utf-8"));
    let (path, query) = back.split_once('?').unwrap();
    assert_eq!(path, "/oidc/callback");
    json!(form(query))
}

fn finish(person: &Person, returned: &Value) -> Reply {
    person.post("/oidc/finish", returned)
}

/// A new browser that signs in; and the service's answer.
fn enter(service: &World, provider: &Provider) -> (Person, Reply) {
    let mut person = service.stranger();
    person.hello();
    let returned = there_and_back(&person, provider, "sign_in");
    let answer = finish(&person, &returned);
    if answer.status == 200 {
        person.keep(&answer);
    }
    (person, answer)
}

fn user_with(admin: &Person, name: &str, email: &str) -> String {
    let made = admin.post("/users", &json!({ "name": name, "email": email, "password": PASSWORD }));
    made.fine()["id"].as_str().unwrap().to_owned()
}

pub fn who_has_a_verified_address_signs_in_to_the_account_that_has_it(world: &World) {
    let admin = world.admin();
    let ann_id = user_with(&admin, "ann", "ANN@example.com");
    for key in [Key::ec("one"), Key::rsa("one", 0)] {
        let (provider, service) = town(world, key, |_| {});
        let offered = service.stranger().hello().json();
        assert_eq!(offered["provider"], "Town");
        let (mut person, answer) = enter(&service, &provider);
        assert_eq!(answer.fine()["user"]["id"], ann_id);
        let cookie = answer.header("set-cookie").unwrap();
        assert!(cookie.contains("HttpOnly") && cookie.contains("SameSite=Lax"), "{cookie}");
        assert_eq!(person.get("/session").fine()["user"]["name"], "ann");
        // The session is like any other: writing needs its CSRF value, and it ends.
        let right = person.csrf.replace("wrong".into());
        assert_eq!(person.post("/tokens", &json!({ "name": "x" })).refusal().1, "session.csrf");
        person.csrf = right;
        person.post("/tokens", &json!({ "name": "x" })).fine();
        let out = person.call("DELETE", "/session", None, &[]).fine();
        let at_provider = out["provider_sign_out"].as_str().unwrap();
        assert!(at_provider.starts_with(&format!("{}/end?client_id=whyroad%20client", provider.issuer())));
        assert!(person.get("/session").fine()["user"].is_null());
    }
    // Signing in by password goes on as before, and then the provider has nothing to do with signing out.
    let ann = world.sign_in("ann");
    assert!(ann.call("DELETE", "/session", None, &[]).fine()["provider_sign_out"].is_null());
    assert!(
        world.stranger().hello().json()["provider"].is_null(),
        "a service without a provider offers none"
    );
    assert_eq!(world.stranger().hello().status, 200);
    let mut nobody = world.stranger();
    nobody.hello();
    assert_eq!(
        nobody.post("/oidc/begin", &json!({ "purpose": "sign_in" })).refusal(),
        (404, "oidc.off".into())
    );
}

pub fn a_token_that_is_wrong_anywhere_lets_nobody_in(world: &World) {
    let admin = world.admin();
    user_with(&admin, "ann", "ann@example.com");
    for key in [Key::ec("one"), Key::rsa("one", 0)] {
        let (provider, service) = town(world, key, |_| {});
        let now = NOON / 1000;
        let claim = Fault::Claim;
        let faults = [
            (claim("nonce", json!("0123")), "nonce"),
            (claim("nonce", Value::Null), "nonce"),
            (claim("aud", json!("another")), "aud"),
            (claim("aud", Value::Null), "aud"),
            (claim("aud", json!([CLIENT, "another"])), "azp"),
            (claim("azp", json!("another")), "azp"),
            (claim("iss", json!("http://127.0.0.1:9")), "iss"),
            (claim("iss", Value::Null), "iss"),
            // Beyond the two minutes by which clocks may differ.
            (claim("exp", json!(now - 121)), "exp"),
            (claim("exp", Value::Null), "exp"),
            (claim("exp", json!("never")), "exp"),
            (claim("iat", json!(now + 125)), "iat"),
            (claim("iat", json!(now - 125)), "iat"),
            (claim("iat", Value::Null), "iat"),
            (claim("nbf", json!(now + 125)), "nbf"),
            (claim("at_hash", json!("AAAAAAAAAAAAAAAAAAAAAA")), "at_hash"),
            (claim("sub", json!("")), "sub"),
            (claim("sub", json!(7)), "sub"),
            (Fault::Header("kid", json!("unknown")), "key"),
            (Fault::Header("alg", json!("RS384")), "alg"),
            (Fault::Header("alg", json!("XX")), "alg"),
            (Fault::Header("crit", json!(["b64"])), "header"),
            (Fault::Header("typ", json!("at+jwt")), "header"),
            (Fault::WrongKey, "signature"),
            (Fault::AlgNone, "alg"),
            (Fault::Hmac, "alg"),
            (Fault::Tampered, "signature"),
            (Fault::Unsigned, "signature"),
            (Fault::Names(json!("http://127.0.0.1:9")), "issuer"),
            (Fault::Names(Value::Null), "issuer"),
        ];
        for (fault, reason) in &faults {
            provider.goes_wrong(fault.clone());
            let (person, answer) = enter(&service, &provider);
            assert_eq!(answer.refusal(), (403, "oidc.token".into()), "{fault:?}");
            assert_eq!(answer.json()["more"]["reason"], *reason, "{fault:?}");
            assert!(person.get("/session").fine()["user"].is_null(), "{fault:?}");
        }
        provider.goes_wrong(Fault::None);
        assert_eq!(enter(&service, &provider).1.status, 200, "the same without a fault");
        // Within what clocks may differ by, and with our id among several: fine.
        for fine in
            [claim("exp", json!(now - 110)), claim("iat", json!(now + 110)), claim("nbf", json!(now + 110))]
        {
            provider.goes_wrong(fine.clone());
            assert_eq!(enter(&service, &provider).1.status, 200, "{fine:?}");
        }
    }
}

pub fn an_answer_serves_once_and_in_one_browser(world: &World) {
    let admin = world.admin();
    user_with(&admin, "ann", "ann@example.com");
    let (provider, service) = town(world, Key::ec("one"), |_| {});
    let stale = |answer: Reply| assert_eq!(answer.refusal(), (403, "oidc.state".into()));
    let browser = |service: &World| {
        let mut person = service.stranger();
        person.hello();
        person
    };
    let (victim, attacker) = (browser(&service), browser(&service));
    // What the attacker began does not end in the victim's browser: nobody is signed in as somebody else unawares.
    let planted = there_and_back(&attacker, &provider, "sign_in");
    stale(finish(&victim, &planted));
    // A page elsewhere cannot end it either: it has no CSRF value.
    let mut forged = attacker.clone();
    forged.csrf = None;
    assert_eq!(finish(&forged, &planted).refusal().1, "session.csrf");
    // Ended once, it is used up: state and code.
    assert_eq!(finish(&attacker, &planted).status, 200);
    stale(finish(&attacker, &planted));
    // A state that never was, one that was altered, one for another purpose.
    let fresh = there_and_back(&attacker, &provider, "sign_in");
    let state = fresh["state"].as_str().unwrap();
    let altered = [
        state.replace(".s.", ".l."),
        format!("1{state}"),
        format!("{state}0"),
        state[..state.len() - 1].to_owned(),
        String::new(),
        "...".to_owned(),
    ];
    for state in altered {
        stale(finish(&attacker, &json!({ "state": state, "code": fresh["code"], "iss": fresh["iss"] })));
    }
    // A used code with a fresh state: the provider says no.
    let again = there_and_back(&attacker, &provider, "sign_in");
    let mixed = json!({ "state": fresh["state"], "code": planted["code"], "iss": fresh["iss"] });
    assert_eq!(finish(&attacker, &mixed).refusal(), (403, "oidc.declined".into()));
    // Another's code does not fit our verifier: PKCE.
    let theirs = there_and_back(&victim, &provider, "sign_in");
    let injected = json!({ "state": again["state"], "code": theirs["code"], "iss": again["iss"] });
    assert_eq!(finish(&attacker, &injected).refusal(), (403, "oidc.declined".into()));
    // Ten minutes are over.
    let late = there_and_back(&attacker, &provider, "sign_in");
    world.wait(601);
    stale(finish(&attacker, &late));
    // The person there says no; a word that is none is not repeated.
    let no = there_and_back(&victim, &provider, "sign_in");
    let told = finish(&victim, &json!({ "state": no["state"], "iss": no["iss"], "error": "access_denied" }));
    assert_eq!(told.refusal(), (403, "oidc.declined".into()));
    assert!(told.text().contains("access_denied"));
    let no = there_and_back(&victim, &provider, "sign_in");
    let told =
        finish(&victim, &json!({ "state": no["state"], "iss": no["iss"], "error": "<b>call 555</b>" }));
    assert!(!told.text().contains("555"));
    // Scripts sign in by tokens of their own.
    let mut script = service.stranger();
    script.token = world.sign_in("ann").post("/tokens", &json!({ "name": "s" })).fine()["token"]
        .as_str()
        .map(Into::into);
    assert_eq!(script.post("/oidc/begin", &json!({ "purpose": "link" })).refusal().0, 400);
    let (_, answer) = enter(&service, &provider);
    assert_eq!(answer.status, 200);
    // Neither the secret nor a verifier is anywhere in the store.
    let kept = world.app.store.read(|tx| tx.rows("SELECT state, expires FROM oidc_used", &[])).unwrap();
    assert!(!format!("{kept:?}").contains(state.rsplit('.').next().unwrap()));
}

pub fn no_account_is_taken_over(world: &World) {
    let admin = world.admin();
    let ann_id = user_with(&admin, "ann", "ann@example.com");
    let bob_id = user_with(&admin, "bob@example.com", "bob@example.org");
    let (provider, service) = town(world, Key::ec("one"), |_| {});
    let refused = |claims: Value, code: &str| {
        provider.is(claims.clone());
        let (_, answer) = enter(&service, &provider);
        assert_eq!(answer.refusal().1, code, "{claims}");
    };
    // An address that is not verified, or not said to be so in so many words, links to nothing.
    refused(json!({ "sub": "m1", "email": "ann@example.com", "email_verified": false }), "oidc.no_account");
    refused(json!({ "sub": "m1", "email": "ann@example.com" }), "oidc.no_account");
    refused(json!({ "sub": "m1", "email": "ann@example.com", "email_verified": "true" }), "oidc.no_account");
    // Names are nobody's proof, even where they look like an address; nor are letters that only look alike.
    refused(json!({ "sub": "m2", "preferred_username": "ann", "name": "ann" }), "oidc.no_account");
    refused(json!({ "sub": "m2", "email": "bob@example.com", "email_verified": true }), "oidc.no_account");
    refused(
        json!({ "sub": "m2", "email": "ann@example.\u{212a}om", "email_verified": true }),
        "oidc.no_account",
    );
    // Half of it from one place and half from another: who is verified is not who is named.
    provider.tells_aside(&["email"]);
    provider.goes_wrong(Fault::Claim("email_verified", json!(true)));
    refused(json!({ "sub": "m3", "email": "ann@example.com", "email_verified": false }), "oidc.no_account");
    provider.goes_wrong(Fault::None);
    provider.tells_aside(&[]);
    // The first who has it verified is linked; another with the same address is not, for the account has its person.
    provider.is(ann());
    assert_eq!(enter(&service, &provider).1.fine()["user"]["id"], ann_id);
    refused(json!({ "sub": "m4", "email": "ann@example.com", "email_verified": true }), "oidc.address_taken");
    // From now on the subject counts: the address may change, and a changed one leads to no other account.
    provider.is(json!({ "sub": "248289761001", "email": "bob@example.org", "email_verified": true }));
    assert_eq!(enter(&service, &provider).1.fine()["user"]["id"], ann_id);
    // Users do not write their own address: else they would wait there for its owner.
    let bob = world.sign_in("bob@example.com");
    let change = json!({ "email": "carl@example.com" });
    assert_eq!(bob.patch(&format!("/users/{bob_id}"), &change).refusal().0, 403);
    assert_eq!(
        admin.patch(&format!("/users/{bob_id}"), &json!({ "email": "Ann@Example.com" })).refusal().1,
        "user.email_taken"
    );
    assert_eq!(
        admin.patch(&format!("/users/{bob_id}"), &json!({ "email": "no address" })).refusal().1,
        "user.email"
    );
    assert_eq!(admin.patch(&format!("/users/{bob_id}"), &json!({ "email": "" })).fine().get("email"), None);
    // Addresses are between their owner and administrators.
    let seen = bob.get("/users").fine().to_string();
    assert!(!seen.contains("\"email\""), "{seen}");
    assert!(admin.get("/users").fine().to_string().contains("ann@example.com"));
    // Who may no longer sign in may not here either.
    admin.patch(&format!("/users/{ann_id}"), &json!({ "disabled": true })).fine();
    refused(ann(), "oidc.disabled");
}

pub fn who_is_signed_in_links_themselves_and_unlinks(world: &World) {
    let admin = world.admin();
    user_with(&admin, "ann", "");
    user_with(&admin, "bob", "");
    let (provider, service) = town(world, Key::ec("one"), |_| {});
    let at = |name: &str| {
        let mut person = world.sign_in(name);
        person.address = service.address;
        person
    };
    let (ann, bob) = (at("ann"), at("bob"));
    let mut nobody = service.stranger();
    nobody.hello();
    assert_eq!(nobody.post("/oidc/begin", &json!({ "purpose": "link" })).refusal().0, 401);
    let link = |person: &Person| {
        let returned = there_and_back(person, &provider, "link");
        finish(person, &returned)
    };
    // Providers that verify no address: the person shows both at once.
    provider.is(json!({ "sub": "entra-1" }));
    link(&ann).fine();
    link(&ann).fine();
    assert_eq!(link(&bob).refusal(), (409, "oidc.linked_elsewhere".into()));
    let (person, answer) = enter(&service, &provider);
    assert_eq!(answer.fine()["user"]["name"], "ann");
    provider.is(json!({ "sub": "entra-2" }));
    assert_eq!(link(&ann).refusal(), (409, "oidc.has_identity".into()));
    // What Ann began is not ended by Bob at the same machine.
    let begun = there_and_back(&ann, &provider, "link");
    assert_eq!(finish(&bob, &begun).refusal().1, "oidc.state");
    let mine = ann.get("/identities").fine();
    assert_eq!(mine["items"].as_array().unwrap().len(), 1);
    assert_eq!(mine["items"][0]["issuer"], provider.issuer());
    let id = mine["items"][0]["id"].as_str().unwrap();
    let ann_id = ann.get("/session").fine()["user"]["id"].as_str().unwrap().to_owned();
    assert_eq!(bob.get(&format!("/identities?user={ann_id}")).refusal().0, 403);
    assert_eq!(bob.call("DELETE", &format!("/identities/{id}"), None, &[]).refusal().0, 404);
    assert_eq!(admin.get(&format!("/identities?user={ann_id}")).fine()["items"][0]["id"], id);
    ann.call("DELETE", &format!("/identities/{id}"), None, &[]).fine();
    assert!(person.get("/session").fine()["user"].is_null(), "the session that began there is over");
    assert!(!ann.get("/session").fine()["user"].is_null(), "the one by password is not");
    provider.is(json!({ "sub": "entra-1" }));
    assert_eq!(enter(&service, &provider).1.refusal().1, "oidc.no_account");
}

pub fn accounts_are_made_and_roles_given_where_the_set_up_says_so(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "cutins", &json!({}));
    user_with(&admin, "ann", "");
    let rules = written(json!({
        "accounts": "made",
        "allow": [{ "domain": "example.com" }, { "claim": "realm_access.roles", "value": "guest" }],
        "grants": [
            { "claim": "realm_access.roles", "value": "chief", "admin": true },
            { "claim": "realm_access.roles", "value": "labeller", "project": "cutins", "roles": ["annotator"] },
            { "claim": "realm_access.roles", "value": "judge", "project": "cutins", "roles": ["checker", "auditor"] },
            { "claim": "realm_access.roles", "value": "judge", "project": "no such project", "roles": ["lead"] },
        ],
    }));
    let (provider, service) = town(world, Key::ec("one"), |w| {
        (w.accounts, w.allow, w.grants) = (rules.accounts, rules.allow.clone(), rules.grants.clone());
    });
    assert_eq!(rules.accounts, Accounts::Made);
    let person = |roles: &[&str]| {
        json!({ "sub": "s1", "preferred_username": "ann", "name": "Ann <b>", "locale": "en-GB", "email": "a@example.com",
            "email_verified": true, "realm_access": { "roles": roles } })
    };
    // Who meets no condition stays out, verified or not.
    for claims in [
        json!({ "sub": "s0", "email": "a@example.com.evil.org", "email_verified": true }),
        json!({ "sub": "s0", "email": "a@sub.example.com", "email_verified": true }),
        json!({ "sub": "s0", "email": "a@example.com", "email_verified": false }),
        json!({ "sub": "s0", "realm_access": { "roles": "guests" } }),
    ] {
        provider.is(claims);
        assert_eq!(enter(&service, &provider).1.refusal(), (403, "oidc.not_allowed".into()));
    }
    // A new account: its name is nobody else's, it has no password and no right that no grant gives.
    provider.is(person(&["labeller", "judge"]));
    let (ann, answer) = enter(&service, &provider);
    let user = answer.fine()["user"].clone();
    assert_eq!(
        (&user["name"], &user["display"], &user["lang"]),
        (&json!("ann-2"), &json!("Ann <b>"), &json!("en"))
    );
    assert_eq!(user["admin"], false);
    let roles = || {
        let members = admin.get(&format!("/projects/{project}/members")).fine();
        let items = members["items"].as_array().unwrap();
        items.iter().find(|m| m["user"]["id"] == user["id"]).map(|m| m["roles"].clone())
    };
    assert_eq!(roles(), Some(json!(["annotator", "checker", "auditor"])));
    let mut guess = world.stranger();
    guess.hello();
    assert_eq!(
        guess.post("/session", &json!({ "name": "ann-2", "password": "" })).refusal().1,
        "session.wrong"
    );
    // Its only way in is not thrown away.
    let id = ann.get("/identities").fine()["items"][0]["id"].as_str().unwrap().to_owned();
    assert_eq!(ann.call("DELETE", &format!("/identities/{id}"), None, &[]).refusal().1, "oidc.only_way");
    // What the provider no longer says is no longer so, and the same person is the same user.
    provider.is(person(&["chief"]));
    let (_, answer) = enter(&service, &provider);
    assert_eq!((&answer.fine()["user"]["id"], &answer.json()["user"]["admin"]), (&user["id"], &json!(true)));
    assert_eq!(roles(), None);
    provider.is(person(&["guest"]));
    assert_eq!(enter(&service, &provider).1.fine()["user"]["admin"], false);
    // The last administrator stays one.
    admin.patch(&format!("/users/{}", user["id"].as_str().unwrap()), &json!({ "admin": true })).fine();
    let own = admin.id.clone();
    world
        .app
        .store
        .write(move |tx| tx.run("UPDATE users SET admin = 0 WHERE id = $1", values![&own]))
        .unwrap();
    assert_eq!(enter(&service, &provider).1.fine()["user"]["admin"], true);
}

pub fn what_only_userinfo_tells_is_asked_for_and_is_of_the_same_person(world: &World) {
    let admin = world.admin();
    let id = user_with(&admin, "ann", "ann@example.com");
    let (provider, service) = town(world, Key::ec("one"), |_| {});
    provider.tells_aside(&["email", "email_verified", "name"]);
    provider.goes_wrong(Fault::OtherPerson);
    let (_, answer) = enter(&service, &provider);
    assert_eq!(
        (answer.refusal().1, answer.json()["more"]["reason"].clone()),
        ("oidc.token".into(), json!("userinfo"))
    );
    provider.goes_wrong(Fault::None);
    assert_eq!(enter(&service, &provider).1.fine()["user"]["id"], id);
    let asked = provider.calls("/userinfo");
    provider.tells_aside(&[]);
    enter(&service, &provider).1.fine();
    assert_eq!(provider.calls("/userinfo"), asked, "a token that says all is enough");
}

pub fn keys_change_and_old_ones_are_forgotten(world: &World) {
    let admin = world.admin();
    user_with(&admin, "ann", "ann@example.com");
    let old = Key::ec("old");
    let (provider, service) = town(world, old.clone(), |_| {});
    enter(&service, &provider).1.fine();
    enter(&service, &provider).1.fine();
    assert_eq!(
        (provider.calls("/jwks"), provider.calls("/.well-known/openid-configuration")),
        (1, 1),
        "kept"
    );
    world.wait(10);
    provider.rotates(Key::rsa("new", 0));
    enter(&service, &provider).1.fine();
    assert_eq!(provider.calls("/jwks"), 2, "a key that is not known is asked for");
    // A name that nobody knows does not make us ask again and again.
    provider.goes_wrong(Fault::Header("kid", json!("nobody's")));
    for _ in 0..3 {
        assert_eq!(enter(&service, &provider).1.json()["more"]["reason"], "key");
    }
    assert!(provider.calls("/jwks") <= 3);
    provider.goes_wrong(Fault::None);
    // The old key is gone from the set, and so from here.
    let key = provider.clone();
    provider.rotates(old);
    key.publishes_only(Key::rsa("new", 0));
    assert_eq!(enter(&service, &provider).1.json()["more"]["reason"], "key");
    // After an hour all is asked for anew.
    world.wait(3700);
    key.publishes_all();
    enter(&service, &provider).1.fine();
    assert_eq!(provider.calls("/.well-known/openid-configuration"), 2);
}

pub fn a_provider_that_fails_or_lies_about_itself_is_said_to(world: &World) {
    let admin = world.admin();
    user_with(&admin, "ann", "ann@example.com");
    let elsewhere = |field| Fault::Discovery(field, json!("http://id.example.com/x"));
    for fault in [
        Fault::Discovery("issuer", json!("http://127.0.0.1:9")),
        Fault::Discovery("code_challenge_methods_supported", json!(["plain"])),
        Fault::Discovery("token_endpoint", Value::Null),
        elsewhere("authorization_endpoint"),
        elsewhere("token_endpoint"),
        elsewhere("jwks_uri"),
        elsewhere("userinfo_endpoint"),
    ] {
        let (provider, service) = town(world, Key::ec("one"), |_| {});
        provider.goes_wrong(fault.clone());
        let mut person = service.stranger();
        person.hello();
        let begin = || person.post("/oidc/begin", &json!({ "purpose": "sign_in" }));
        assert_eq!(begin().refusal(), (502, "oidc.provider".into()), "{fault:?}");
        begin();
        assert_eq!(provider.calls("/.well-known/openid-configuration"), 1, "it is left alone for a while");
        provider.goes_wrong(Fault::None);
        world.wait(6);
        assert_eq!(begin().status, 200);
    }
    let (provider, service) = town(world, Key::ec("one"), |_| {});
    for status in [500, 401, 302] {
        provider.goes_wrong(Fault::Away(status));
        let (_, answer) = enter(&service, &provider);
        assert_eq!(answer.refusal(), (502, "oidc.provider".into()), "{status}");
        assert!(!answer.text().contains("s3cr"));
    }
    // A wrong secret is the service's fault; it is not repeated.
    let (provider, service) = town(world, Key::ec("one"), |w| w.client_secret = Some(Secret("hush".into())));
    let (_, answer) = enter(&service, &provider);
    assert_eq!(answer.refusal(), (502, "oidc.provider".into()));
    assert!(answer.text().contains("invalid_client") && !answer.text().contains("hush"), "{}", answer.text());
}

pub fn attempts_are_counted_and_the_first_account_is_made_here(world: &World) {
    let (provider, service) = town(world, Key::ec("one"), |_| {});
    let (_, answer) = enter(&service, &provider);
    assert_eq!(answer.refusal(), (409, "oidc.first_run".into()));
    world.admin();
    let mut guess = service.stranger();
    guess.hello();
    // Fifty failures of one address are free, as with passwords.
    for _ in 0..50 {
        assert_eq!(finish(&guess, &json!({ "state": "1.2.s.3", "code": "x" })).refusal().1, "oidc.state");
    }
    let waits = finish(&guess, &json!({ "state": "1.2.s.3", "code": "x" }));
    assert_eq!(waits.refusal(), (429, "session.wait".into()));
    assert_eq!(guess.post("/oidc/begin", &json!({ "purpose": "sign_in" })).refusal().0, 429);
}
