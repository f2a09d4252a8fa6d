//! One POST to the endpoint over HTTP or TLS, within limits. No redirect is followed, since the key is meant only for
//! the given address.

use super::key::Key;
use crate::ChatError;
use std::sync::Arc;
use std::time::{Duration, SystemTime};
use ureq::Agent;
use ureq::tls::{Certificate, RootCerts, TlsConfig};
use whyroad_model::Bilingual;

/// Largest answer, bytes.
const LARGEST: u64 = 8 * 1024 * 1024;
/// Longest text of an endpoint that is shown, characters.
const SHOWN: usize = 200;

/// The result of a request.
pub(super) enum Outcome {
    /// Status 200, with its body.
    Body(String),
    /// It may work later.
    Again { why: String, pause: Option<Duration> },
    /// It will not.
    Rejected { status: u16, why: String },
}

/// The endpoint.
#[derive(Debug)]
pub(super) struct Wire {
    agent: Agent,
    url: String,
    key: Option<Key>,
}

impl Wire {
    pub fn new(url: &str, key: Option<Key>, timeout: Duration) -> Result<Self, ChatError> {
        let url = address(url)?;
        let native = rustls_native_certs::load_native_certs().certs;
        let roots: Vec<Certificate<'static>> =
            native.iter().map(|c| Certificate::from_der(c.as_ref()).to_owned()).collect();
        let tls = TlsConfig::builder()
            .root_certs(RootCerts::Specific(Arc::new(roots)))
            .unversioned_rustls_crypto_provider(Arc::new(rustls::crypto::ring::default_provider()))
            .build();
        let config = Agent::config_builder();
        // A proxy from the environment applies only to other machines.
        let config = if is_here(&url) { config.proxy(None) } else { config };
        let config = config
            .tls_config(tls)
            .timeout_global(Some(timeout))
            .max_redirects(0)
            .max_redirects_will_error(false)
            .http_status_as_error(false)
            .user_agent("whyroad")
            .build();
        Ok(Self { agent: config.new_agent(), url, key })
    }

    /// The address that is posted to.
    pub fn url(&self) -> &str {
        &self.url
    }

    pub fn post(&self, body: &str) -> Outcome {
        let mut request = self.agent.post(&self.url).header("content-type", "application/json");
        if let Some(key) = &self.key {
            request = request.header("authorization", key.header());
        }
        let mut response = match request.send(body) {
            Ok(response) => response,
            Err(e) => return Outcome::Again { why: self.shown(&e.to_string()), pause: None },
        };
        let status = response.status().as_u16();
        let pause = response
            .headers()
            .get("retry-after")
            .and_then(|v| pause_of(v.to_str().ok()?.trim(), SystemTime::now()));
        let text = match response.body_mut().with_config().limit(LARGEST).read_to_string() {
            Ok(text) => text,
            Err(e) if status == 200 => return Outcome::Again { why: self.shown(&e.to_string()), pause },
            Err(_) => String::new(),
        };
        match status {
            200 if self.key.as_ref().is_some_and(|k| k.is_in(&text)) => {
                Outcome::Rejected { status, why: "the answer repeats the key".to_owned() }
            }
            200 => Outcome::Body(text),
            408 | 409 | 429 | 500..=599 => {
                Outcome::Again { why: format!("status {status}: {}", self.said(status, &text)), pause }
            }
            _ => Outcome::Rejected { status, why: self.said(status, &text) },
        }
    }

    /// The endpoint's own message. Text about a key may repeat parts of it, and is left out.
    fn said(&self, status: u16, body: &str) -> String {
        if matches!(status, 401 | 403) {
            return "the key is missing, wrong or not allowed to do this".to_owned();
        }
        let json: Option<serde_json::Value> = serde_json::from_str(body).ok();
        let message = json.as_ref().and_then(|j| j.pointer("/error/message").or(j.get("message"))?.as_str());
        self.shown(message.unwrap_or(body))
    }

    /// One line, short, without the key.
    fn shown(&self, text: &str) -> String {
        let text = self.key.as_ref().map_or_else(|| text.to_owned(), |k| k.hidden(text));
        let line: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
        line.chars().filter(|c| !c.is_control()).take(SHOWN).collect()
    }
}

/// The pause of a `Retry-After`: seconds, or a date (RFC 9110, 10.2.3).
fn pause_of(value: &str, now: SystemTime) -> Option<Duration> {
    if let Ok(seconds) = value.parse::<f64>() {
        return Duration::try_from_secs_f64(seconds).ok();
    }
    let at = httpdate::parse_http_date(value).ok()?;
    Some(at.duration_since(now).unwrap_or_default())
}

/// True for an address of this machine.
fn is_here(url: &str) -> bool {
    let host = url.split_once("://").map_or("", |(_, rest)| rest);
    ["localhost", "127.", "[::1]"].iter().any(|here| host.starts_with(here))
}

/// `https://host/v1` to `https://host/v1/chat/completions`.
fn address(url: &str) -> Result<String, ChatError> {
    let wrong = |zh: &str, en: &str| {
        Err(ChatError::Settings(Bilingual::new(
            format!("模型服务地址：{zh}"),
            format!("address of the model: {en}"),
        )))
    };
    let Some(rest) = url.strip_prefix("https://").or_else(|| url.strip_prefix("http://")) else {
        return wrong("须以 http:// 或 https:// 开头", "it must start with http:// or https://");
    };
    let host = rest.split(['/', '?', '#']).next().unwrap_or_default();
    if host.is_empty() || url.chars().any(|c| c.is_whitespace() || c.is_control()) {
        return wrong("缺少主机名", "it has no host");
    }
    if host.contains('@') || rest.contains(['?', '#']) {
        return wrong(
            "不能含有用户名、查询参数或片段；密钥请用 --key-env",
            "it must not have a user name, a query or a fragment; use --key-env for the key",
        );
    }
    let base = url.trim_end_matches('/');
    Ok(if base.ends_with("/chat/completions") { base.to_owned() } else { format!("{base}/chat/completions") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_are_seconds_or_dates() {
        // Of RFC 9110, 5.6.7: 784111777 s after 1970.
        let now = SystemTime::UNIX_EPOCH + Duration::from_secs(784_111_700);
        let seconds = |value: &str| pause_of(value, now).map(|d| d.as_secs_f64());
        assert_eq!((seconds("2"), seconds("1.5")), (Some(2.0), Some(1.5)));
        assert_eq!(seconds("Sun, 06 Nov 1994 08:49:37 GMT"), Some(77.0));
        assert_eq!(seconds("Sun, 06 Nov 1994 08:00:00 GMT"), Some(0.0), "has passed");
        assert_eq!((seconds("soon"), seconds("-1")), (None, None));
    }

    #[test]
    fn addresses_are_completed_and_secrets_in_them_refused() {
        assert_eq!(address("http://a:1/v1/").unwrap(), "http://a:1/v1/chat/completions");
        assert_eq!(address("https://a/chat/completions").unwrap(), "https://a/chat/completions");
        for bad in ["a/v1", "ftp://a", "https://", "https://u:p@a/v1", "https://a/v1?key=1", "https://a b"] {
            assert!(matches!(address(bad), Err(ChatError::Settings(_))), "{bad}");
        }
    }
}
