//! Content of a request's head: cookie, token, query, and the client's address.

use super::call::Request;
use super::handlers::session::COOKIE;
use crate::app::Origin;
use axum::extract::Query;
use axum::http::{HeaderMap, Uri, header};
use std::collections::BTreeMap;
use std::net::IpAddr;

/// The request without its body.
pub(super) fn request_of(
    headers: &HeaderMap,
    uri: &Uri,
    params: BTreeMap<String, String>,
    address: String,
) -> Request {
    let text = |name: &str| headers.get(name).and_then(|v| v.to_str().ok());
    let cookies = headers.get_all(header::COOKIE).iter().filter_map(|v| v.to_str().ok());
    let cookie = cookies
        .flat_map(|c| c.split(';'))
        .filter_map(|c| c.trim().split_once('='))
        .find(|(name, value)| *name == COOKIE && !value.is_empty())
        .map(|(_, value)| value.to_owned());
    let token = text("authorization").and_then(|v| v.split_once(' '));
    let token =
        token.filter(|(kind, _)| kind.eq_ignore_ascii_case("bearer")).map(|(_, t)| t.trim().to_owned());
    Request {
        params,
        query: Query::try_from_uri(uri).map(|Query(q)| q).unwrap_or_default(),
        body: vec![],
        cookie,
        token,
        csrf: text("x-csrf-token").map(str::to_owned),
        address,
        host: text("host").unwrap_or_default().to_owned(),
    }
}

/// The client address according to a trusted proxy in front of the service.
pub(super) fn forwarded(headers: &HeaderMap, origin: Origin) -> Option<String> {
    if origin == Origin::Connection {
        return None;
    }
    // All but the last were sent by the client, which can forge them.
    let header = headers.get_all("x-forwarded-for").iter().next_back()?.to_str().ok()?;
    let last = header.rsplit(',').next()?.trim().parse::<IpAddr>().ok()?;
    Some(last.to_canonical().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    #[test]
    fn only_a_proxy_that_was_announced_is_believed_and_only_its_own_word() {
        let of = |values: &[&'static str], origin| {
            let mut headers = HeaderMap::new();
            for line in values {
                headers.append("x-forwarded-for", HeaderValue::from_static(line));
            }
            forwarded(&headers, origin)
        };
        assert_eq!(of(&["9.9.9.9"], Origin::Connection), None);
        let proxy = |values: &[&'static str]| of(values, Origin::Proxy);
        assert_eq!(proxy(&["9.9.9.9"]).as_deref(), Some("9.9.9.9"));
        // Forged values precede the one that the proxy adds.
        assert_eq!(proxy(&["1.1.1.1, 2.2.2.2 ,9.9.9.9"]).as_deref(), Some("9.9.9.9"));
        assert_eq!(proxy(&["1.1.1.1", "::ffff:9.9.9.9"]).as_deref(), Some("9.9.9.9"));
        assert_eq!(proxy(&["9.9.9.9, unknown"]), None);
        assert_eq!(proxy(&[]), None);
    }
}
