//! The examples of RFC 7515 (appendices A.2 and A.3), RFC 8037 (A.4) and OpenID Connect Core (A.3), and invalid tokens.

use super::*;
use crate::oidc::keys;
use serde_json::json;

const PAYLOAD: &str =
    "eyJpc3MiOiJqb2UiLA0KICJleHAiOjEzMDA4MTkzODAsDQogImh0dHA6Ly9leGFtcGxlLmNvbS9pc19yb290Ijp0cnVlfQ";
const RS256: &str = "cC4hiUPoj9Eetdgtv3hF80EGrhuB__dzERat0XF9g2VtQgr9PJbu3XOiZj5RZmh7AAuHIm4Bh-0Qc_lF5YKt_O8W2Fp5jujGbds9uJdbF9CUAr7t1dnZcAcQjbKBYNX4BAynRFdiuB--f_nZLgrnbyTyWzO75vRK5h6xBArLIARNPvkSjtQBMHlb1L07Qe7K0GarZRmB_eSN9383LcOLn6_dO--xi12jzDwusC-eOkHWEsqtFZESc6BfI7noOPqvhJ1phCnvWh6IeYI2w9QOYEUipUTI8np6LbgGY9Fs98rqVt5AXLIhWkWywlVmtVrBp0igcN_IoypGlUPQGe77Rw";
const ES256: &str = "DtEhU3ljbEg8L38VWAfUAqOyKAM6-Xx-F4GawxaepmXFCgfTjDxw5djxLa8ISlSApmWQxfKTUJqPP3-Kg6NU1Q";
const EDDSA: &str = "eyJhbGciOiJFZERTQSJ9.RXhhbXBsZSBvZiBFZDI1NTE5IHNpZ25pbmc.hgyY0il_MGCjP0JzlnLWG1PPOt7-09PGcvMg3AIbQR6dWbhijcNR4ki4iylGjg5BhVsPt9g7sVvpAr_MuM0KAg";
const N: &str = "ofgWCuLjybRlzo0tZWJjNiuSfb4p4fAkd_wWJcyQoTbji9k0l8W26mPddxHmfHQp-Vaw-4qPCJrcS2mJPMEzP1Pt0Bm4d4QlL-yRT-SFd2lZS-pCgNMsD1W_YpRPEwOWvG6b32690r2jZ47soMZo9wGzjb_7OMg0LOL-bSf63kpaSHSXndS5z5rexMdbBYUsLA9e-KXBdQOS-UTo7WTBEMa2R2CapHg665xsmtdVMTBQY4uDZlxvb3qCo5ZwKh9kG4LT6_I5IhlJH7aGhyxXFvUK-DWNmoudF8NAco9_h9iaGNj8q2ethFkMLs91kzk2PAcDTW9gb54h4FRWyuXpoQ";

fn published() -> Vec<Jwk> {
    keys::read(&json!({ "keys": [
        { "kty": "RSA", "n": N, "e": "AQAB" },
        { "kty": "EC", "crv": "P-256", "x": "f83OJ3D2xF1Bg8vub9tLe1gHMzV76e8Tus9uPHvRVEU", "y": "x_FEzRu9m36HLN_tue659LNpXW6pCyStikYjKIWI5a0" },
        { "kty": "OKP", "crv": "Ed25519", "x": "11qYAYKxCrfVS_7TyWQHOg7hcvPapiMlrwIaaPcHURo" },
    ]}))
}

fn verified(token: &str, keys: &[Jwk]) -> Result<Value, Reason> {
    Token::read(token)?.verify(keys)
}

#[test]
fn published_examples_verify_and_no_change_of_them_does() {
    let keys = published();
    let claims = json!({ "iss": "joe", "exp": 1300819380, "http://example.com/is_root": true });
    let rs = format!("eyJhbGciOiJSUzI1NiJ9.{PAYLOAD}.{RS256}");
    let es = format!("eyJhbGciOiJFUzI1NiJ9.{PAYLOAD}.{ES256}");
    for token in [&rs, &es] {
        assert_eq!(verified(token, &keys), Ok(claims.clone()));
        let altered = token.replace(PAYLOAD, &PAYLOAD.replacen("eyJpc3MiOiJqb2Ui", "eyJpc3MiOiJib2Ii", 1));
        assert_eq!(verified(&altered, &keys), Err("signature"));
        assert!(verified(&token[..token.len() - 4], &keys).is_err());
        assert_eq!(verified(token, &[]), Err("key"));
    }
    // The signature is valid, but the payload of that example is not JSON.
    let token = Token::read(EDDSA).unwrap();
    assert!(token.is_signed_by(&keys[2]));
    assert_eq!(token.verify(&keys), Err("form"));
    // The signature of one algorithm under the name of the other.
    assert_eq!(verified(&format!("eyJhbGciOiJFUzI1NiJ9.{PAYLOAD}.{RS256}"), &keys), Err("signature"));
}

#[test]
fn what_is_no_signed_token_is_refused() {
    let encoded = |text: &str| URL_SAFE_NO_PAD.encode(text);
    let of = |header: &str| verified(&format!("{}.{PAYLOAD}.{ES256}", encoded(header)), &published());
    assert_eq!(of(r#"{"alg":"none"}"#), Err("alg"));
    assert_eq!(of(r#"{"alg":"None"}"#), Err("alg"));
    assert_eq!(of(r#"{"alg":"HS256"}"#), Err("alg"));
    assert_eq!(of(r#"{"alg":"ES256","crit":["exp"]}"#), Err("header"));
    assert_eq!(of(r#"{"alg":"ES256","typ":"logout+jwt"}"#), Err("header"));
    assert_eq!(of(r#"{"alg":["ES256"]}"#), Err("form"));
    assert_eq!(of(r#"{"typ":"JWT"}"#), Err("form"));
    assert_eq!(of(r#"{"alg":"ES256","kid":"other"}"#), Err("key"));
    for text in
        ["", ".", "..", "a.b", "a.b.c.d.e", "eyJhbGciOiJFUzI1NiJ9.e30=.AA", "eyJhbGciOiJFUzI1NiJ9.e30.A"]
    {
        assert_eq!(verified(text, &published()), Err("form"), "{text}");
    }
}

#[test]
fn keys_for_other_uses_are_passed_over() {
    let key = |more: Value| {
        let mut key = json!({ "kty": "RSA", "n": N, "e": "AQAB" });
        key.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        keys::read(&json!({ "keys": [key] }))
    };
    let token = format!("eyJhbGciOiJSUzI1NiJ9.{PAYLOAD}.{RS256}");
    for fine in [
        json!({}),
        json!({"use": "sig"}),
        json!({"alg": "RS256"}),
        json!({"key_ops": ["verify"]}),
        json!({"kid": "x"}),
    ] {
        assert!(verified(&token, &key(fine.clone())).is_ok(), "{fine}");
    }
    for other in [
        json!({"use": "enc"}),
        json!({"alg": "RS512"}),
        json!({"alg": "RSA-OAEP"}),
        json!({"key_ops": ["encrypt"]}),
    ] {
        assert_eq!(verified(&token, &key(other.clone())), Err("key"), "{other}");
    }
    // Half of a point, and a set that is not one.
    assert!(
        keys::read(&json!({ "keys": [{ "kty": "EC", "crv": "P-256", "x": "AQ", "y": "AQ" }, 7, null] }))
            .is_empty()
    );
    assert!(keys::read(&json!([])).is_empty());
}

#[test]
fn the_half_hash_is_that_of_the_standard() {
    // OpenID Connect Core 1.0, appendix A.3.
    let half = Algorithm::Rs256.half_hash("jHkWEdUXMU1BwAsC4vtUsZwnNvTIxEl0z9K3vx5KF0Y");
    assert_eq!(half, "77QmUPtjPfzWtF2AnpK9RQ");
}

proptest::proptest! {
    /// Any text from a provider or an attacker is read without a panic, and none is accepted.
    #[test]
    fn no_text_breaks_the_reading(header in "\\PC{0,40}", payload in "\\PC{0,40}", tail in "[A-Za-z0-9_.=-]{0,100}", raw in "\\PC{0,80}") {
        let alg = format!("{{\"alg\":\"ES256\",\"x\":{header:?}}}");
        for text in [
            format!("{}.{}.{tail}", URL_SAFE_NO_PAD.encode(&header), URL_SAFE_NO_PAD.encode(&payload)),
            format!("{}.{}.{tail}", URL_SAFE_NO_PAD.encode(&alg), URL_SAFE_NO_PAD.encode(&payload)),
            format!("{tail}.{tail}.{tail}"),
            raw,
        ] {
            proptest::prop_assert!(verified(&text, &published()).is_err());
        }
    }
}
