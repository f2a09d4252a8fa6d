//! Addresses; the checks of a token are tested over HTTP against a provider that violates them one by one.

use super::*;
use serde_json::json;

#[test]
fn only_plain_addresses_that_are_said_to_be_verified_count() {
    let of = |email: &str| verified_email(&json!({ "email": email, "email_verified": true }));
    assert_eq!(of("Ann.B+c@Example.COM").as_deref(), Some("ann.b+c@example.com"));
    // U+212A, the kelvin sign, becomes a plain k in lower case.
    for odd in [
        "",
        "ann",
        "@example.com",
        "ann@",
        "ann@local",
        "a b@example.com",
        "ann@example.\u{212a}",
        "é@example.com",
    ] {
        assert_eq!(of(odd), None, "{odd}");
    }
    for not in [json!(false), json!("true"), json!(1), json!(null)] {
        assert_eq!(verified_email(&json!({ "email": "ann@example.com", "email_verified": not })), None);
    }
    assert_eq!(verified_email(&json!({ "email_verified": true })), None);
}
