//! A sign-in from its start to the claims of the person.

use super::claims::{self, Expected};
use super::jws::Token;
use super::provider::{Metadata, Provider};
use super::provider_fails;
use super::refused_token;
use super::settings::Secret;
use crate::app::App;
use crate::problem::{Answer, Problem};
use crate::url::encoded;
use crate::{secret, values};
use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest as _, Sha256};

/// Maximum time of a sign-in at the provider, ms.
const LONGEST_MS: i64 = 10 * 60_000;
/// Claims that are requested from the userinfo endpoint if the token does not have them.
const WANTED: &[&str] = &["email", "email_verified", "name", "preferred_username"];

/// Purpose of a sign-in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Purpose {
    /// To sign in.
    SignIn,
    /// To let a signed-in user sign in this way, too.
    Link,
}

/// The browser of a sign-in.
#[derive(Clone, Copy, Debug)]
pub struct Browser<'a> {
    /// Value of its session cookie.
    pub cookie: &'a str,
    /// The signed-in user, if that matters: for [`Purpose::Link`].
    pub user: Option<&'a str>,
}

/// Parameters with which the provider redirected the browser back.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Returned {
    /// `state`.
    pub state: String,
    /// `code`.
    #[serde(default)]
    pub code: Option<String>,
    /// `iss`.
    #[serde(default)]
    pub iss: Option<String>,
    /// `error`.
    #[serde(default)]
    pub error: Option<String>,
}

fn stale() -> Problem {
    Problem::new(
        403,
        "oidc.state",
        "本次登录已过期、已使用，或始于另一个浏览器，请重新登录",
        "this sign-in has expired, was already used, or was started in another browser: start again",
    )
}

/// The secrets of one sign-in, derived from the service's key, the browser and the state.
struct Derived<'a> {
    key: String,
    browser: Browser<'a>,
}

impl<'a> Derived<'a> {
    fn new(app: &App, browser: Browser<'a>) -> Self {
        // The line break separates this key from CSRF values: no cookie contains one.
        Self { key: secret::sign(&app.csrf_key, b"\noidc"), browser }
    }

    fn of(&self, what: &str, state: &str) -> String {
        let Browser { cookie, user } = self.browser;
        secret::sign(&self.key, format!("{what}\n{state}\n{}\n{cookie}", user.unwrap_or_default()).as_bytes())
    }
}

/// The address at the provider to which the browser goes. Calls the provider only to find it.
pub fn begin(app: &App, provider: &Provider, browser: Browser<'_>, purpose: Purpose) -> Answer<String> {
    let _turn = provider.turn()?;
    let metadata = provider.metadata(app.now())?;
    let derived = Derived::new(app, browser);
    let word = if purpose == Purpose::Link { "l" } else { "s" };
    let begun = format!("{}.{}.{word}", app.now(), secret::random(16)?);
    let state = format!("{begun}.{}", derived.of("state", &begun));
    let settings = &provider.settings;
    let query = [
        ("response_type", "code"),
        ("client_id", &settings.client_id),
        ("redirect_uri", &settings.redirect_uri()),
        ("scope", &settings.scopes.join(" ")),
        ("state", &state),
        ("nonce", &derived.of("nonce", &state)),
        ("code_challenge", &challenge(&derived.of("verifier", &state))),
        ("code_challenge_method", "S256"),
    ]
    .map(|(k, v)| format!("{k}={}", encoded(v)));
    let at = &metadata.authorization_endpoint;
    Ok(format!("{at}{}{}", if at.contains('?') { '&' } else { '?' }, query.join("&")))
}

/// The challenge that is sent to the provider first (S256, RFC 7636 4.2).
fn challenge(verifier: &str) -> String {
    URL_SAFE_NO_PAD.encode(Sha256::digest(verifier))
}

/// The verified claims of the person who signed in, and the purpose. A state is valid once, whatever the provider
/// answers.
pub fn finish(
    app: &App,
    provider: &Provider,
    browser: Browser<'_>,
    returned: &Returned,
) -> Answer<(Value, Purpose)> {
    let now = app.now();
    let (begun, mac) = returned.state.rsplit_once('.').ok_or_else(stale)?;
    let mut parts = begun.split('.');
    let began = parts.next().and_then(|t| t.parse::<i64>().ok()).ok_or_else(stale)?;
    let purpose = if parts.nth(1) == Some("l") { Purpose::Link } else { Purpose::SignIn };
    // The browser may already be signed in as any user; only linking depends on that user.
    let browser = Browser { user: browser.user.filter(|_| purpose == Purpose::Link), ..browser };
    let derived = Derived::new(app, browser);
    let in_time = (-1000..LONGEST_MS).contains(&(now - began));
    if !secret::same(mac, &derived.of("state", begun)) || !in_time {
        return Err(stale());
    }
    // If the provider is unavailable, the state remains valid.
    let _turn = provider.turn()?;
    let metadata = provider.metadata(now)?;
    if !use_up(app, mac, now)? {
        return Err(stale());
    }
    // First check: is this the answer of the provider to which the browser was sent (RFC 9207)?
    let named = returned.iss.as_deref();
    if named
        .map_or(metadata.authorization_response_iss_parameter_supported, |i| i != provider.settings.issuer)
    {
        return Err(refused_token("issuer"));
    }
    let code = match (&returned.code, &returned.error) {
        (Some(code), None) => code,
        (_, error) => return Err(declined(error.as_deref().unwrap_or_default())),
    };
    let tokens = exchange(provider, &metadata, code, &derived.of("verifier", &returned.state))?;
    let id_token = tokens["id_token"].as_str().ok_or_else(|| refused_token("missing"))?;
    let token = Token::read(id_token).map_err(refused_token)?;
    let mut who = provider.verify(&token, now)?;
    let access_token = tokens["access_token"].as_str();
    let expected = Expected {
        issuer: &provider.settings.issuer,
        client_id: &provider.settings.client_id,
        nonce: &derived.of("nonce", &returned.state),
        began,
        now: app.now(),
        access_token,
        algorithm: token.algorithm,
    };
    claims::check(&who, &expected).map_err(refused_token)?;
    complete(provider, &metadata, access_token, &mut who)?;
    Ok((who, purpose))
}

/// Records that a state was used; false if it was used before.
fn use_up(app: &App, mac: &str, now: i64) -> Answer<bool> {
    let state = secret::hash(mac);
    app.store.write(move |tx| {
        tx.run("DELETE FROM oidc_used WHERE expires < $1", values![now])?;
        let sql = "INSERT INTO oidc_used (state, expires) VALUES ($1, $2) ON CONFLICT (state) DO NOTHING";
        // Kept for twice its lifetime: another service on this store may have a different clock.
        Ok(tx.run(sql, values![&state, now + 2 * LONGEST_MS])? == 1)
    })
}

/// An error's name, if it is a plain identifier; other text from outside is not repeated.
fn plain_word(error: &str) -> &str {
    let plain = (1..=40).contains(&error.len()) && error.bytes().all(|b| b.is_ascii_lowercase() || b == b'_');
    if plain { error } else { "?" }
}

/// The provider, or the person, declined.
fn declined(error: &str) -> Problem {
    let word = plain_word(error);
    Problem::new(
        403,
        "oidc.declined",
        format!("身份提供方未同意登录（{word}）"),
        format!("the identity provider did not let you sign in ({word})"),
    )
}

/// Tokens for the code.
fn exchange(provider: &Provider, metadata: &Metadata, code: &str, verifier: &str) -> Answer<Value> {
    let settings = &provider.settings;
    let redirect = settings.redirect_uri();
    let mut form = vec![
        ("grant_type", "authorization_code"),
        ("code", code),
        ("redirect_uri", &redirect),
        ("code_verifier", verifier),
    ];
    let in_form = metadata.wants_secret_in_form();
    let basic: Option<(&str, &Secret)> =
        settings.client_secret.as_ref().filter(|_| !in_form).map(|s| (settings.client_id.as_str(), s));
    if basic.is_none() {
        form.push(("client_id", &settings.client_id));
        form.extend(settings.client_secret.as_ref().map(|s| ("client_secret", s.0.as_str())));
    }
    let (status, body) = provider.web.post(&metadata.token_endpoint, basic, &form)?;
    if status == 200 {
        return Ok(body);
    }
    match body["error"].as_str() {
        // The code is invalid: used, too old, or for another client.
        Some("invalid_grant") => Err(declined("invalid_grant")),
        error => {
            let word = error.map_or("", plain_word);
            Err(provider_fails(format!("token endpoint: status {status} {word}")))
        }
    }
}

/// Adds claims that only the userinfo endpoint has. Its subject must be the person who signed in (OpenID Connect Core
/// 5.3.2).
fn complete(provider: &Provider, metadata: &Metadata, token: Option<&str>, who: &mut Value) -> Answer<()> {
    let settings = &provider.settings;
    let by_rules = settings.allow.iter().filter_map(|a| match a {
        super::settings::Allow::Claim { claim, .. } => Some(claim.as_str()),
        super::settings::Allow::Domain { .. } => None,
    });
    let by_grants = settings.grants.iter().map(|g| g.claim.as_str());
    let first = |name: &str| name.split('.').next().unwrap_or_default().to_owned();
    let mut wanted = by_rules
        .chain(by_grants)
        .map(|name| (name.to_owned(), first(name)))
        .chain(WANTED.iter().map(|w| ((*w).to_owned(), (*w).to_owned())));
    let complete = wanted.all(|(whole, first)| who.get(&whole).or_else(|| who.get(&first)).is_some());
    let (Some(url), Some(token), false) = (&metadata.userinfo_endpoint, token, complete) else {
        return Ok(());
    };
    let more = provider.web.get(url, Some(token))?;
    if more.get("sub").is_none() || more.get("sub") != who.get("sub") {
        return Err(refused_token("userinfo"));
    }
    if let (Some(known), Value::Object(more)) = (who.as_object_mut(), more) {
        // An address and its verification belong together: both come from one source.
        let has_email = known.contains_key("email");
        if !has_email {
            known.remove("email_verified");
        }
        for (name, value) in more {
            if !(has_email && name == "email_verified") {
                known.entry(name).or_insert(value);
            }
        }
    }
    Ok(())
}

/// Address at which people sign out at the provider, and from which they are redirected back.
pub fn sign_out_address(app: &App, provider: &Provider) -> Option<String> {
    let _turn = provider.turn().ok()?;
    let metadata = provider.metadata(app.now()).ok()?;
    let at = metadata.end_session_endpoint.as_deref()?;
    let settings = &provider.settings;
    let back = format!("{}/", settings.public_url);
    let query =
        format!("client_id={}&post_logout_redirect_uri={}", encoded(&settings.client_id), encoded(&back));
    Some(format!("{at}{}{query}", if at.contains('?') { '&' } else { '?' }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_challenge_is_that_of_rfc_7636() {
        // RFC 7636, appendix B.
        let made = challenge("dBjftJeZ4CVP-mB92K27uhbUJU1p1r_wW1gFWFOEjXk");
        assert_eq!(made, "E9Melhoa2OwvFrEMTJguCHaoeK1t8URWbuGJSstw-cM");
    }
}
