//! The account of a person of the identity provider, and its permissions.

use crate::oidc::{enter, finish, there_and_back, town, user_with, written};
use crate::provider::{Fault, ann};
use crate::signer::Key;
use crate::world::{Person, World};
use serde_json::{Value, json};
use whyroad_server::oidc::settings::Accounts;
use whyroad_server::values;

pub fn who_has_a_verified_address_signs_in_to_the_account_that_has_it(world: &World) {
    let admin = world.admin();
    let ann_id = user_with(&admin, "ann", "ANN@example.com");
    for key in [Key::ec("one"), Key::rsa("one", 0)] {
        let (provider, service) = town(world, key, |_| {});
        let offered = service.unauthenticated().hello().json();
        assert_eq!(offered["provider"], "Town");
        let (mut person, answer) = enter(&service, &provider);
        assert_eq!(answer.fine()["user"]["id"], ann_id);
        let cookie = answer.header("set-cookie").unwrap();
        assert!(cookie.contains("HttpOnly") && cookie.contains("SameSite=Lax"), "{cookie}");
        assert_eq!(person.get("/session").fine()["user"]["name"], "ann");
        // The session is an ordinary one: writing needs its CSRF value, and it can be ended.
        let right = person.csrf.replace("wrong".into());
        assert_eq!(person.post("/tokens", &json!({ "name": "x" })).refusal().1, "session.csrf");
        person.csrf = right;
        person.post("/tokens", &json!({ "name": "x" })).fine();
        let out = person.call("DELETE", "/session", None, &[]).fine();
        let at_provider = out["provider_sign_out"].as_str().unwrap();
        assert!(at_provider.starts_with(&format!("{}/end?client_id=whyroad%20client", provider.issuer())));
        assert!(person.get("/session").fine()["user"].is_null());
    }
    // Signing in by password still works, and then the provider is not involved in signing out.
    let ann = world.sign_in("ann");
    assert!(ann.call("DELETE", "/session", None, &[]).fine()["provider_sign_out"].is_null());
    assert!(
        world.unauthenticated().hello().json()["provider"].is_null(),
        "a service without a provider offers none"
    );
    assert_eq!(world.unauthenticated().hello().status, 200);
    let mut nobody = world.unauthenticated();
    nobody.hello();
    assert_eq!(
        nobody.post("/oidc/begin", &json!({ "purpose": "sign_in" })).refusal(),
        (404, "oidc.off".into())
    );
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
    // An address that is not verified, or not explicitly stated to be verified, links to nothing.
    refused(json!({ "sub": "m1", "email": "ann@example.com", "email_verified": false }), "oidc.no_account");
    refused(json!({ "sub": "m1", "email": "ann@example.com" }), "oidc.no_account");
    refused(json!({ "sub": "m1", "email": "ann@example.com", "email_verified": "true" }), "oidc.no_account");
    // Names are no proof of identity, even if they look like an address; nor are letters that only look similar.
    refused(json!({ "sub": "m2", "preferred_username": "ann", "name": "ann" }), "oidc.no_account");
    refused(json!({ "sub": "m2", "email": "bob@example.com", "email_verified": true }), "oidc.no_account");
    refused(
        json!({ "sub": "m2", "email": "ann@example.\u{212a}om", "email_verified": true }),
        "oidc.no_account",
    );
    // Claims from two sources: the verification of one person does not apply to the address of another.
    provider.tells_aside(&["email"]);
    provider.goes_wrong(Fault::Claim("email_verified", json!(true)));
    refused(json!({ "sub": "m3", "email": "ann@example.com", "email_verified": false }), "oidc.no_account");
    provider.goes_wrong(Fault::None);
    provider.tells_aside(&[]);
    // The first person with the verified address is linked; another with the same address is not, because the account
    // is already linked.
    provider.is(ann());
    assert_eq!(enter(&service, &provider).1.fine()["user"]["id"], ann_id);
    refused(json!({ "sub": "m4", "email": "ann@example.com", "email_verified": true }), "oidc.address_taken");
    // From now on the subject counts: the address may change, and a changed one gives no access to another account.
    provider.is(json!({ "sub": "248289761001", "email": "bob@example.org", "email_verified": true }));
    assert_eq!(enter(&service, &provider).1.fine()["user"]["id"], ann_id);
    // Users cannot enter their own address: otherwise they could enter another person's and wait for its owner.
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
    // Addresses are visible only to their owner and administrators.
    let seen = bob.get("/users").fine().to_string();
    assert!(!seen.contains("\"email\""), "{seen}");
    assert!(admin.get("/users").fine().to_string().contains("ann@example.com"));
    // A disabled user cannot sign in this way either.
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
    let mut nobody = service.unauthenticated();
    nobody.hello();
    assert_eq!(nobody.post("/oidc/begin", &json!({ "purpose": "link" })).refusal().0, 401);
    let link = |person: &Person| {
        let returned = there_and_back(person, &provider, "link");
        finish(person, &returned)
    };
    // For providers that verify no address, a signed-in user links the account.
    provider.is(json!({ "sub": "entra-1" }));
    link(&ann).fine();
    link(&ann).fine();
    assert_eq!(link(&bob).refusal(), (409, "oidc.linked_elsewhere".into()));
    let (person, answer) = enter(&service, &provider);
    assert_eq!(answer.fine()["user"]["name"], "ann");
    provider.is(json!({ "sub": "entra-2" }));
    assert_eq!(link(&ann).refusal(), (409, "oidc.has_identity".into()));
    // A sign-in that Ann began cannot be completed by Bob in the same browser.
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
    // A person who meets no condition cannot sign in, verified or not.
    for claims in [
        json!({ "sub": "s0", "email": "a@example.com.evil.org", "email_verified": true }),
        json!({ "sub": "s0", "email": "a@sub.example.com", "email_verified": true }),
        json!({ "sub": "s0", "email": "a@example.com", "email_verified": false }),
        json!({ "sub": "s0", "realm_access": { "roles": "guests" } }),
    ] {
        provider.is(claims);
        assert_eq!(enter(&service, &provider).1.refusal(), (403, "oidc.not_allowed".into()));
    }
    // A new account: its name is free, it has no password and only the permissions from grants.
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
    let mut guess = world.unauthenticated();
    guess.hello();
    assert_eq!(
        guess.post("/session", &json!({ "name": "ann-2", "password": "" })).refusal().1,
        "session.wrong"
    );
    // Its only sign-in method cannot be removed.
    let id = ann.get("/identities").fine()["items"][0]["id"].as_str().unwrap().to_owned();
    assert_eq!(ann.call("DELETE", &format!("/identities/{id}"), None, &[]).refusal().1, "oidc.only_way");
    // Permissions that the provider no longer states are removed, and the same person is the same user.
    provider.is(person(&["chief"]));
    let (_, answer) = enter(&service, &provider);
    assert_eq!((&answer.fine()["user"]["id"], &answer.json()["user"]["admin"]), (&user["id"], &json!(true)));
    assert_eq!(roles(), None);
    provider.is(person(&["guest"]));
    assert_eq!(enter(&service, &provider).1.fine()["user"]["admin"], false);
    // The last administrator keeps this permission.
    admin.patch(&format!("/users/{}", user["id"].as_str().unwrap()), &json!({ "admin": true })).fine();
    let own = admin.id.clone();
    world
        .app
        .store
        .write(move |tx| tx.run("UPDATE users SET admin = 0 WHERE id = $1", values![&own]))
        .unwrap();
    assert_eq!(enter(&service, &provider).1.fine()["user"]["admin"], true);
}
