//! Required claims of an ID token (OpenID Connect Core 3.1.3.7), and the person that they identify.

use super::Reason;
use super::algorithm::Algorithm;
use serde_json::Value;

/// Maximum difference between the provider's clock and ours, s.
const SKEW_S: i64 = 120;
/// Maximum length of a subject (OpenID Connect Core section 2).
const SUBJECT: usize = 255;

/// Expected values of a token.
#[derive(Clone, Copy, Debug)]
pub struct Expected<'a> {
    /// Issuer.
    pub issuer: &'a str,
    /// Client id.
    pub client_id: &'a str,
    /// The nonce of this sign-in.
    pub nonce: &'a str,
    /// When this sign-in began, ms since 1970.
    pub began: i64,
    /// Now, ms since 1970.
    pub now: i64,
    /// The access token that came with it.
    pub access_token: Option<&'a str>,
    /// The algorithm of its signature.
    pub algorithm: Algorithm,
}

/// Checks all claims of a signed token.
pub fn check(claims: &Value, e: &Expected<'_>) -> Result<(), Reason> {
    let text = |name: &str| claims.get(name).and_then(Value::as_str);
    if text("iss") != Some(e.issuer) {
        return Err("iss");
    }
    let audience: Vec<&str> = match claims.get("aud") {
        Some(Value::String(one)) => vec![one],
        Some(Value::Array(many)) => many.iter().filter_map(Value::as_str).collect(),
        _ => vec![],
    };
    if !audience.contains(&e.client_id) {
        return Err("aud");
    }
    let party = claims.get("azp");
    if party.map_or(audience.len() > 1, |p| p != e.client_id) {
        return Err("azp");
    }
    let now = e.now / 1000;
    let time = |name: &'static str| claims.get(name).and_then(seconds).ok_or(name);
    if time("exp")? <= now - SKEW_S {
        return Err("exp");
    }
    // It was issued for this sign-in: not before it, and not in the future.
    if !(e.began / 1000 - SKEW_S..=now + SKEW_S).contains(&time("iat")?) {
        return Err("iat");
    }
    if claims.get("nbf").is_some() && time("nbf")? > now + SKEW_S {
        return Err("nbf");
    }
    if !text("nonce").is_some_and(|n| crate::secret::same(n, e.nonce)) {
        return Err("nonce");
    }
    if let (Some(stated), Some(token)) = (claims.get("at_hash"), e.access_token)
        && *stated != e.algorithm.half_hash(token)
    {
        return Err("at_hash");
    }
    if !text("sub").is_some_and(|s| !s.is_empty() && s.len() <= SUBJECT) {
        return Err("sub");
    }
    Ok(())
}

/// Whole seconds of a number; providers may write fractions.
fn seconds(value: &Value) -> Option<i64> {
    value.as_i64().or_else(|| value.as_f64().filter(|f| f.abs() < 1e12).map(|f| f as i64))
}

/// The e-mail address, in lower case, if the provider states that it is verified. Addresses with letters outside of
/// ASCII are ignored: two that look the same can differ.
pub fn verified_email(claims: &Value) -> Option<String> {
    let email = claims.get("email")?.as_str()?;
    let (name, domain) = email.rsplit_once('@')?;
    let plain = email.len() <= 254 && email.bytes().all(|b| b.is_ascii_graphic());
    let verified = claims.get("email_verified") == Some(&Value::Bool(true));
    (verified && plain && !name.is_empty() && domain.contains('.')).then(|| email.to_ascii_lowercase())
}

#[cfg(test)]
mod tests;
