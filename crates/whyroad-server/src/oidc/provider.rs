//! The provider: its discovery document and its keys, fetched when needed and cached.

use super::algorithm::Algorithm;
use super::jws::Token;
use super::keys::{self, Jwk};
use super::provider_fails;
use super::settings::{Settings, is_safe};
use super::web::Web;
use crate::problem::{Answer, Problem};
use serde::Deserialize;
use serde_json::Value;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

/// Lifetime of a cached document, ms.
const FRESH_MS: i64 = 3_600_000;
/// Minimum time between two requests after a failure, or for an unknown key, ms.
const PAUSE_MS: i64 = 5_000;
/// Maximum number of sign-ins that call the provider at once; a provider that hangs must not block all threads of the
/// service.
const AT_ONCE: usize = 16;

/// The discovery document (OpenID Connect Discovery 1.0 section 3, RFC 8414, RFC 9207).
#[derive(Clone, Debug, Deserialize)]
pub struct Metadata {
    issuer: String,
    /// Where people sign in.
    pub authorization_endpoint: String,
    /// Endpoint that exchanges a code for tokens.
    pub token_endpoint: String,
    jwks_uri: String,
    /// Userinfo endpoint.
    #[serde(default)]
    pub userinfo_endpoint: Option<String>,
    /// Where people sign out.
    #[serde(default)]
    pub end_session_endpoint: Option<String>,
    #[serde(default)]
    token_endpoint_auth_methods_supported: Option<Vec<String>>,
    #[serde(default)]
    id_token_signing_alg_values_supported: Option<Vec<String>>,
    #[serde(default)]
    code_challenge_methods_supported: Option<Vec<String>>,
    /// The provider states its issuer in its answers.
    #[serde(default)]
    pub authorization_response_iss_parameter_supported: bool,
}

impl Metadata {
    fn check(self, settings: &Settings) -> Answer<Self> {
        if self.issuer != settings.issuer {
            return Err(provider_fails(format!("issuer '{}' instead of '{}'", self.issuer, settings.issuer)));
        }
        let addresses = [&self.authorization_endpoint, &self.token_endpoint, &self.jwks_uri];
        let more = self.userinfo_endpoint.iter().chain(&self.end_session_endpoint);
        let secure = settings.issuer.starts_with("https:");
        for url in addresses.into_iter().chain(more) {
            if !is_safe(url) || (secure && !url.starts_with("https:")) {
                return Err(provider_fails(format!("unsafe address '{url}'")));
            }
        }
        // A provider that does not mention PKCE may support it; one that lists methods without S256 does not.
        let pkce = self.code_challenge_methods_supported.as_ref();
        if pkce.is_some_and(|methods| !methods.iter().any(|m| m == "S256")) {
            return Err(provider_fails("no PKCE with S256"));
        }
        Ok(self)
    }

    /// True if the client's secret is sent in the form, because the provider does not accept it in the header.
    pub fn wants_secret_in_form(&self) -> bool {
        let methods = self.token_endpoint_auth_methods_supported.as_deref().unwrap_or_default();
        let takes = |name: &str| methods.iter().any(|m| m == name);
        takes("client_secret_post") && !takes("client_secret_basic")
    }

    /// True for an algorithm that the provider lists.
    fn uses(&self, algorithm: Algorithm) -> bool {
        let stated = self.id_token_signing_alg_values_supported.as_ref();
        stated.is_none_or(|names| names.iter().any(|n| n == algorithm.name()))
    }
}

/// The last fetched value and its time.
struct Kept<T> {
    value: Option<Arc<T>>,
    at: i64,
    /// When fetching was last tried, and its error.
    tried: i64,
    failure: Option<Problem>,
}

impl<T> Default for Kept<T> {
    fn default() -> Self {
        Self { value: None, at: 0, tried: i64::MIN / 2, failure: None }
    }
}

impl<T> Kept<T> {
    /// The cached value if it is fresh; else the result of `fetch`. If that fails, the error is cached for a while.
    fn get(&mut self, now: i64, fetch: impl FnOnce() -> Answer<T>) -> Answer<Arc<T>> {
        // A clock that was set back does not extend the lifetime.
        if let Some(value) = self.value.as_ref().filter(|_| (0..FRESH_MS).contains(&(now - self.at))) {
            return Ok(Arc::clone(value));
        }
        if let Some(failure) = self.failure.as_ref().filter(|_| (0..PAUSE_MS).contains(&(now - self.tried))) {
            return Err(failure.clone());
        }
        self.renew(now, fetch)
    }

    fn renew(&mut self, now: i64, fetch: impl FnOnce() -> Answer<T>) -> Answer<Arc<T>> {
        self.tried = now;
        match fetch() {
            Ok(value) => {
                let value = Arc::new(value);
                (self.value, self.at, self.failure) = (Some(Arc::clone(&value)), now, None);
                Ok(value)
            }
            Err(e) => {
                self.failure = Some(e.clone());
                Err(e)
            }
        }
    }
}

/// A provider at which people can sign in.
pub struct Provider {
    /// Its configuration.
    pub settings: Settings,
    /// HTTP client.
    pub web: Web,
    metadata: Mutex<Kept<Metadata>>,
    keys: Mutex<Kept<Vec<Jwk>>>,
    talking: AtomicUsize,
}

/// Permission for one sign-in to call the provider.
pub struct Turn<'p>(&'p AtomicUsize);

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Provider {
    /// A provider; nothing is requested yet. `extra`: certificates (PEM) to trust in addition to the system's.
    pub fn new(settings: Settings, extra: Option<&[u8]>) -> Answer<Self> {
        Ok(Self {
            settings,
            web: Web::new(extra)?,
            metadata: Mutex::default(),
            keys: Mutex::default(),
            talking: AtomicUsize::new(0),
        })
    }

    /// Permits one more sign-in to call the provider.
    pub fn turn(&self) -> Answer<Turn<'_>> {
        let before = self.talking.fetch_add(1, Ordering::SeqCst);
        let turn = Turn(&self.talking);
        if before < AT_ONCE {
            return Ok(turn);
        }
        Err(Problem::new(
            503,
            "oidc.busy",
            "同时登录的人太多，请稍后再试",
            "too many people are signing in: try again later",
        ))
    }

    /// The discovery document.
    pub fn metadata(&self, now: i64) -> Answer<Arc<Metadata>> {
        self.metadata.lock().map_err(Problem::store)?.get(now, || {
            let issuer = self.settings.issuer.trim_end_matches('/');
            let document = self.web.get(&format!("{issuer}/.well-known/openid-configuration"), None)?;
            let read: Metadata = serde_json::from_value(document).map_err(provider_fails)?;
            read.check(&self.settings)
        })
    }

    /// The claims of a token signed by the provider. For an unknown key, the keys are fetched again, because keys
    /// change.
    pub fn verify(&self, token: &Token<'_>, now: i64) -> Answer<Value> {
        let metadata = self.metadata(now)?;
        if !metadata.uses(token.algorithm) {
            return Err(super::refused_token("alg"));
        }
        let fetch = || Ok(keys::read(&self.web.get(&metadata.jwks_uri, None)?));
        let mut kept = self.keys.lock().map_err(Problem::store)?;
        let known = kept.get(now, fetch)?;
        let mut result = token.verify(&known);
        if result == Err("key") && !(0..PAUSE_MS).contains(&(now - kept.tried)) {
            result = token.verify(&kept.renew(now, fetch)?);
        }
        result.map_err(super::refused_token)
    }
}
