//! Valid and invalid configurations; lookup of claims.

use super::*;
use serde_json::json;

fn written(more: Value) -> Written {
    let mut all = json!({ "issuer": "https://id.example.com", "client_id": "c", "public_url": "https://w.example.com" });
    all.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    serde_json::from_value(all).unwrap()
}

#[test]
fn secrets_go_only_where_nobody_listens() {
    for fine in [
        "https://a",
        "https://a:1/x",
        "http://localhost:8",
        "http://127.0.0.1",
        "http://[::1]:3/r",
        "http://127.9.9.9/",
    ] {
        assert!(is_safe(fine), "{fine}");
    }
    for not in [
        "http://a",
        "http://localhost.evil.org",
        "http://10.0.0.1",
        "http://127.0.0.1.evil.org",
        "ftp://a",
        "//a",
        "",
        "https://",
    ] {
        assert!(!is_safe(not), "{not}");
    }
    for (field, value) in [
        ("issuer", "http://id.example.com"),
        ("issuer", "https://id.example.com?x"),
        ("issuer", "https://u@id.example.com"),
        ("public_url", "http://w.example.com"),
        ("public_url", ""),
        ("client_id", ""),
    ] {
        let refused = Settings::resolve(written(json!({ field: value }))).unwrap_err();
        assert_eq!(refused.code, "oidc.settings", "{field} {value}");
        assert!(refused.text.en.contains(field) && refused.text.zh.contains(field));
    }
}

#[test]
fn accounts_are_made_only_for_those_whom_a_condition_names() {
    let made = |more: Value| Settings::resolve(written(more)).map(|s| s.unwrap().accounts);
    assert_eq!(made(json!({})).unwrap(), Accounts::Existing, "nobody gets an account unless it is said");
    assert!(made(json!({ "accounts": "made" })).is_err());
    assert_eq!(made(json!({ "accounts": "made", "allow": [{ "domain": "a.b" }] })).unwrap(), Accounts::Made);
    for grant in [
        json!({}),
        json!({ "project": "p" }),
        json!({ "roles": ["lead"] }),
        json!({ "admin": true, "roles": ["lead"] }),
    ] {
        let mut grant = grant;
        grant["claim"] = json!("g");
        grant["value"] = json!("v");
        assert!(made(json!({ "grants": [grant] })).is_err());
    }
    let none: Written = serde_json::from_value(json!({})).unwrap();
    assert!(Settings::resolve(none).unwrap().is_none());
    let half: Written = serde_json::from_value(json!({ "client_id": "c" })).unwrap();
    assert!(Settings::resolve(half).is_err());
    assert!(serde_json::from_value::<Written>(json!({ "isuer": "x" })).is_err());
    assert!(serde_json::from_value::<Allow>(json!({ "domain": "a.b", "value": "x" })).is_err());
}

#[test]
fn claims_are_found_by_name_and_by_way() {
    let claims = json!({ "groups": ["a", "b"], "realm_access": { "roles": ["x"] }, "https://t.example/roles": ["r"], "staff": true, "o": {} });
    for (claim, value) in
        [("groups", "b"), ("realm_access.roles", "x"), ("https://t.example/roles", "r"), ("staff", "true")]
    {
        assert!(has(&claims, claim, value), "{claim}");
    }
    for (claim, value) in [
        ("groups", "ab"),
        ("groups", ""),
        ("realm_access", "x"),
        ("o", "{}"),
        ("none", "null"),
        ("groups.0", "a"),
    ] {
        assert!(!has(&claims, claim, value), "{claim} {value}");
    }
}
