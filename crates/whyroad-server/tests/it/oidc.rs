//! Signing in at an identity provider: the whole flow with real redirects and real keys, and attempts that must fail.

use crate::provider::{CLIENT, Fault, Provider, SECRET, form};
use crate::signer::Key;
use crate::world::{NOON, PASSWORD, Person, Reply, World};
use serde_json::{Value, json};
use whyroad_server::oidc::settings::{Secret, Settings, Written};

/// A provider, and a service on the store of `world` that accepts its users.
pub fn town(world: &World, key: Key, more: impl FnOnce(&mut Written)) -> (Provider, World) {
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
        app.oidc = Some(whyroad_server::oidc::provider::Provider::new(settings, None).unwrap());
        // With its own limits: two of these services on one store see more failures than an address may have.
        app.limits = whyroad_server::limits::Limits::default();
    });
    (provider, service)
}

/// A configuration from JSON.
pub fn written(more: Value) -> Written {
    serde_json::from_value(more).unwrap()
}

/// Goes to the provider and back; returns the query of the redirect.
pub fn there_and_back(person: &Person, provider: &Provider, purpose: &str) -> Value {
    let begun = person.post("/oidc/begin", &json!({ "purpose": purpose })).fine();
    let url = begun["url"].as_str().unwrap();
    let path = url.strip_prefix(&provider.issuer()).unwrap();
    let mut browser = person.clone();
    (browser.address, browser.cookie, browser.csrf) = (provider.address, None, None);
    let answer = browser.raw("GET", path, None, &[]);
    assert_eq!(answer.status, 303, "{}", answer.text());
    let back = answer.header("location").unwrap().strip_prefix("http://127.0.0.1:1").unwrap();
    // The browser opens the page there, which passes the query on.
    assert_eq!(person.raw("GET", back, None, &[]).header("content-type"), Some("text/html; charset=utf-8"));
    let (path, query) = back.split_once('?').unwrap();
    assert_eq!(path, "/oidc/callback");
    json!(form(query))
}

pub fn finish(person: &Person, returned: &Value) -> Reply {
    person.post("/oidc/finish", returned)
}

/// A new browser that signs in; and the service's response.
pub fn enter(service: &World, provider: &Provider) -> (Person, Reply) {
    let mut person = service.unauthenticated();
    person.hello();
    let returned = there_and_back(&person, provider, "sign_in");
    let answer = finish(&person, &returned);
    if answer.status == 200 {
        person.keep(&answer);
    }
    (person, answer)
}

pub fn user_with(admin: &Person, name: &str, email: &str) -> String {
    let made = admin.post("/users", &json!({ "name": name, "email": email, "password": PASSWORD }));
    made.fine()["id"].as_str().unwrap().to_owned()
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
            // Beyond the maximum clock difference of two minutes.
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
        // Within the maximum clock difference, and with our id among several: accepted.
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
        let mut person = service.unauthenticated();
        person.hello();
        person
    };
    let (victim, attacker) = (browser(&service), browser(&service));
    // A sign-in begun by the attacker does not end in the victim's browser: nobody is signed in as another user without
    // noticing.
    let planted = there_and_back(&attacker, &provider, "sign_in");
    stale(finish(&victim, &planted));
    // Another site cannot complete it either: it has no CSRF value.
    let mut forged = attacker.clone();
    forged.csrf = None;
    assert_eq!(finish(&forged, &planted).refusal().1, "session.csrf");
    // After completion the state and the code are used up.
    assert_eq!(finish(&attacker, &planted).status, 200);
    stale(finish(&attacker, &planted));
    // An unknown state, an altered one, one for another purpose.
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
    // A used code with a fresh state: the provider refuses it.
    let again = there_and_back(&attacker, &provider, "sign_in");
    let mixed = json!({ "state": fresh["state"], "code": planted["code"], "iss": fresh["iss"] });
    assert_eq!(finish(&attacker, &mixed).refusal(), (403, "oidc.declined".into()));
    // Another person's code does not match our verifier: PKCE.
    let theirs = there_and_back(&victim, &provider, "sign_in");
    let injected = json!({ "state": again["state"], "code": theirs["code"], "iss": again["iss"] });
    assert_eq!(finish(&attacker, &injected).refusal(), (403, "oidc.declined".into()));
    // After ten minutes.
    let late = there_and_back(&attacker, &provider, "sign_in");
    world.wait(601);
    stale(finish(&attacker, &late));
    // The person declines; an error that is not a plain identifier is not repeated.
    let no = there_and_back(&victim, &provider, "sign_in");
    let told = finish(&victim, &json!({ "state": no["state"], "iss": no["iss"], "error": "access_denied" }));
    assert_eq!(told.refusal(), (403, "oidc.declined".into()));
    assert!(told.text().contains("access_denied"));
    let no = there_and_back(&victim, &provider, "sign_in");
    let told =
        finish(&victim, &json!({ "state": no["state"], "iss": no["iss"], "error": "<b>call 555</b>" }));
    assert!(!told.text().contains("555"));
    // Scripts sign in with tokens.
    let mut script = service.unauthenticated();
    script.token = world.sign_in("ann").post("/tokens", &json!({ "name": "s" })).fine()["token"]
        .as_str()
        .map(Into::into);
    assert_eq!(script.post("/oidc/begin", &json!({ "purpose": "link" })).refusal().0, 400);
    let (_, answer) = enter(&service, &provider);
    assert_eq!(answer.status, 200);
    // Neither the secret nor a verifier is in the store.
    let kept = world.app.store.read(|tx| tx.rows("SELECT state, expires FROM oidc_used", &[])).unwrap();
    assert!(!format!("{kept:?}").contains(state.rsplit('.').next().unwrap()));
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
    // An unknown key does not cause repeated requests.
    provider.goes_wrong(Fault::Header("kid", json!("nobody's")));
    for _ in 0..3 {
        assert_eq!(enter(&service, &provider).1.json()["more"]["reason"], "key");
    }
    assert!(provider.calls("/jwks") <= 3);
    provider.goes_wrong(Fault::None);
    // The old key is removed from the set, and so from the cache.
    let key = provider.clone();
    provider.rotates(old);
    key.publishes_only(Key::rsa("new", 0));
    assert_eq!(enter(&service, &provider).1.json()["more"]["reason"], "key");
    // After an hour everything is requested again.
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
        let mut person = service.unauthenticated();
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
    // A wrong secret is an error of the service; it is not repeated in messages.
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
    let mut guess = service.unauthenticated();
    guess.hello();
    // Fifty failures of one address are free, as for passwords.
    for _ in 0..50 {
        assert_eq!(finish(&guess, &json!({ "state": "1.2.s.3", "code": "x" })).refusal().1, "oidc.state");
    }
    let waits = finish(&guess, &json!({ "state": "1.2.s.3", "code": "x" }));
    assert_eq!(waits.refusal(), (429, "session.wait".into()));
    assert_eq!(guess.post("/oidc/begin", &json!({ "purpose": "sign_in" })).refusal().0, 429);
}

pub fn every_way_of_being_a_client_will_do(world: &World) {
    let admin = world.admin();
    user_with(&admin, "ann", "ann@example.com");
    let methods = |names: Value| Fault::Discovery("token_endpoint_auth_methods_supported", names);
    for (names, secret) in [
        (json!(["client_secret_post"]), Some(SECRET)),
        (json!(["client_secret_basic", "client_secret_post"]), Some(SECRET)),
        (json!(["none"]), None),
    ] {
        let secret = secret.map(|s| Secret(s.into()));
        let (provider, service) = town(world, Key::ec("one"), |w| w.client_secret = secret);
        provider.goes_wrong(methods(names.clone()));
        assert_eq!(enter(&service, &provider).1.status, 200, "{names}");
    }
}

pub fn services_on_one_store_share_the_work(world: &World) {
    let admin = world.admin();
    user_with(&admin, "ann", "ann@example.com");
    let (provider, first) = town(world, Key::ec("one"), |_| {});
    let settings = first.app.oidc.as_ref().unwrap().settings.clone();
    let second = world.beside(|app| {
        app.oidc = Some(whyroad_server::oidc::provider::Provider::new(settings, None).unwrap());
    });
    let mut person = first.unauthenticated();
    person.hello();
    let returned = there_and_back(&person, &provider, "sign_in");
    // A load balancer sends the browser to the other one.
    let there = Person { address: second.address, ..person.clone() };
    assert_eq!(finish(&there, &returned).status, 200);
    assert_eq!(finish(&person, &returned).refusal(), (403, "oidc.state".into()), "used up for both");
}
