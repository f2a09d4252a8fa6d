//! HTTP client for the provider: GET and POST with JSON responses, over TLS, with limits. No redirect is followed,
//! because the content is meant only for the address to which it is sent.

use super::provider_fails;
use super::settings::Secret;
use crate::problem::{Answer, Problem};
use crate::url::encoded;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use std::sync::Arc;
use std::time::Duration;
use ureq::Agent;
use ureq::tls::{Certificate, PemItem, RootCerts, TlsConfig, parse_pem};

/// Time for one call as a whole.
const TIMEOUT: Duration = Duration::from_secs(10);
/// Maximum size of a response, bytes.
const LARGEST: u64 = 1024 * 1024;

/// The HTTP client.
pub struct Web {
    agent: Agent,
}

impl Web {
    /// With the system's certificates and those of `extra` (PEM).
    pub fn new(extra: Option<&[u8]>) -> Answer<Self> {
        let native = rustls_native_certs::load_native_certs().certs;
        let mut roots: Vec<Certificate<'static>> =
            native.iter().map(|c| Certificate::from_der(c.as_ref()).to_owned()).collect();
        for item in parse_pem(extra.unwrap_or_default()) {
            match item {
                Ok(PemItem::Certificate(certificate)) => roots.push(certificate),
                Ok(_) => {}
                Err(e) => {
                    return Err(Problem::new(
                        500,
                        "oidc.settings",
                        format!("证书文件无法读取：{e}"),
                        format!("the certificate file cannot be read: {e}"),
                    ));
                }
            }
        }
        let tls = TlsConfig::builder()
            .root_certs(RootCerts::Specific(Arc::new(roots)))
            .unversioned_rustls_crypto_provider(Arc::new(rustls::crypto::ring::default_provider()))
            .build();
        let config = Agent::config_builder()
            .tls_config(tls)
            .timeout_global(Some(TIMEOUT))
            .max_redirects(0)
            .max_redirects_will_error(false)
            .http_status_as_error(false)
            .user_agent("whyroad")
            .build();
        Ok(Self { agent: config.new_agent() })
    }

    /// Reads `url`, with a bearer token if one is given.
    pub fn get(&self, url: &str, bearer: Option<&str>) -> Answer<Value> {
        let mut request = self.agent.get(url).header("accept", "application/json");
        if let Some(token) = bearer {
            request = request.header("authorization", format!("Bearer {token}"));
        }
        let (status, body) = answer(url, request.call())?;
        if status == 200 { Ok(body) } else { Err(provider_fails(format!("{url}: status {status}"))) }
    }

    /// Sends a form to `url`; returns the status and body of the response.
    pub fn post(
        &self,
        url: &str,
        basic: Option<(&str, &Secret)>,
        form: &[(&str, &str)],
    ) -> Answer<(u16, Value)> {
        let mut request = self.agent.post(url).header("accept", "application/json");
        if let Some((id, secret)) = basic {
            // Both are form-encoded before they are joined (RFC 6749 2.3.1).
            let joined = format!("{}:{}", encoded(id), encoded(&secret.0));
            request = request.header("authorization", format!("Basic {}", STANDARD.encode(joined)));
        }
        let form: Vec<String> = form.iter().map(|(k, v)| format!("{k}={}", encoded(v))).collect();
        let request = request.header("content-type", "application/x-www-form-urlencoded");
        answer(url, request.send(form.join("&")))
    }
}

fn answer(url: &str, got: Result<ureq::http::Response<ureq::Body>, ureq::Error>) -> Answer<(u16, Value)> {
    // An address of the provider is no secret; the content that was sent to it is not in this message.
    let fails = |why: ureq::Error| provider_fails(format!("{url}: {why}"));
    let mut response = got.map_err(fails)?;
    let body = response.body_mut().with_config().limit(LARGEST).read_to_vec().map_err(fails)?;
    let status = response.status().as_u16();
    match serde_json::from_slice(&body) {
        Ok(json) => Ok((status, json)),
        // For a refusal the status is sufficient.
        Err(_) if status != 200 => Ok((status, Value::Null)),
        Err(_) => Err(provider_fails(format!("{url}: not JSON"))),
    }
}

#[cfg(test)]
mod tests;
