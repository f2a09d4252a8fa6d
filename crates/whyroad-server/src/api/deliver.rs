//! HTTP responses: headers, ETags, compression, problems as problem+json.

use super::pages::Keep;
use super::reply::Reply;
use super::stream::Stream;
use crate::domain::people::ProblemBody;
use crate::problem::Problem;
use crate::url::encoded;
use axum::body::Body;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Response, StatusCode, header};
use flate2::{Compression, write::GzEncoder};
use std::io::Write;

/// Bodies smaller than this are not compressed.
const SMALL: usize = 1400;
/// Content security policy of the page.
const PAGE_POLICY: &str = "media-src 'self' blob:; \
    style-src 'self' 'unsafe-inline'; object-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'";
/// Content security policy of an API response, in case a browser displays it.
const API_POLICY: &str = "default-src 'none'; frame-ancestors 'none'; sandbox";

/// What the request accepts as a response.
#[derive(Clone, Debug, Default)]
pub(super) struct Accepted {
    /// `if-none-match`.
    known: Option<String>,
    /// Accepts gzip.
    gzip: bool,
    /// Requests no body.
    head: bool,
}

impl Accepted {
    pub(super) fn of(headers: &HeaderMap, head: bool) -> Self {
        let text = |name: HeaderName| headers.get(name).and_then(|v| v.to_str().ok()).map(str::to_owned);
        let encodings = text(header::ACCEPT_ENCODING).unwrap_or_default();
        let gzip = encodings
            .split(',')
            .map(str::trim)
            .any(|e| e == "gzip" || (e.starts_with("gzip;") && !e.ends_with("q=0")));
        Self { known: text(header::IF_NONE_MATCH), gzip, head }
    }
}

/// How a response may be cached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ReplyKind {
    /// A read call of the API: has an ETag.
    Read,
    /// Any other call of the API.
    Done,
    /// A file of the page.
    Page(Keep),
}

/// Header by which the browser stores a response as the file `name`: with its characters (RFC 8187), and in ASCII for
/// clients that do not read these. Characters that file systems reject are replaced.
fn attachment(name: &str) -> String {
    let name = name.replace(|c: char| c.is_control() || "/\\:*?\"<>|".contains(c), "_");
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-._+ ".contains(c);
    let plain = name.replace(|c: char| !is_plain(c), "_");
    format!("attachment; filename=\"{plain}\"; filename*=UTF-8''{}", encoded(&name))
}

/// The response with all its headers.
pub(super) fn deliver(reply: Reply, kind: ReplyKind, accepted: &Accepted) -> Response<Body> {
    let mut headers = HeaderMap::new();
    let mut put = |name: HeaderName, value: &str| {
        if let Ok(value) = HeaderValue::from_str(value) {
            headers.append(name, value);
        }
    };
    put(header::X_CONTENT_TYPE_OPTIONS, "nosniff");
    put(header::REFERRER_POLICY, "same-origin");
    put(header::X_FRAME_OPTIONS, "DENY");
    put(HeaderName::from_static("cross-origin-opener-policy"), "same-origin");
    put(HeaderName::from_static("cross-origin-resource-policy"), "same-origin");
    let page = matches!(kind, ReplyKind::Page(_));
    if page {
        let mut images = "default-src 'self'; img-src 'self' blob: data:".to_owned();
        for origin in &reply.image_origins {
            images = images + " " + origin;
        }
        put(header::CONTENT_SECURITY_POLICY, &format!("{images}; {PAGE_POLICY}"));
    } else {
        put(header::CONTENT_SECURITY_POLICY, API_POLICY);
    }
    if let Some(location) = &reply.location {
        put(header::LOCATION, location);
    }
    for (name, value) in &reply.headers {
        put(HeaderName::from_static(name), value);
    }
    put(
        header::CACHE_CONTROL,
        match kind {
            ReplyKind::Page(Keep::Forever) => "public, max-age=31536000, immutable",
            ReplyKind::Page(Keep::Ask) => "no-cache",
            // A link expires, and must not be cached.
            _ if reply.location.is_some() => "no-store",
            ReplyKind::Read => "private, no-cache",
            ReplyKind::Done => "no-store",
        },
    );
    if !page {
        put(header::VARY, "cookie, authorization");
    }
    for cookie in &reply.cookies {
        put(header::SET_COOKIE, cookie);
    }
    if let Some(name) = &reply.file_name {
        put(header::CONTENT_DISPOSITION, &attachment(name));
    }
    let mut status = StatusCode::from_u16(reply.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
    let mut body = reply.body;
    if status == StatusCode::OK && kind != ReplyKind::Done {
        let tag = format!("\"{}\"", crate::secret::hash_bytes(&body).get(..32).unwrap_or_default());
        put(header::ETAG, &tag);
        if accepted.known.as_deref().is_some_and(|known| matches(known, &tag)) {
            status = StatusCode::NOT_MODIFIED;
            body.clear();
        }
    }
    if !body.is_empty() {
        put(header::CONTENT_TYPE, &reply.media);
        let smaller =
            if accepted.gzip && body.len() >= SMALL && compresses(&reply.media) { gzip(&body) } else { None };
        if let Some(smaller) = smaller {
            put(header::CONTENT_ENCODING, "gzip");
            put(header::VARY, "accept-encoding");
            body = smaller;
        }
    }
    if accepted.head {
        put(header::CONTENT_LENGTH, &body.len().to_string());
        body.clear();
    }
    let mut response = Response::new(Body::from(body));
    *response.status_mut() = status;
    *response.headers_mut() = headers;
    response
}

/// The response that `stream` writes, with the headers of `reply`.
pub(super) fn deliver_stream(
    reply: &Reply,
    stream: &Stream,
    accepted: &Accepted,
    failed: impl FnOnce(&Problem) + Send + 'static,
) -> Response<Body> {
    let head = Reply { stream: None, body: vec![], ..reply.clone() };
    let mut response = deliver(head, ReplyKind::Done, accepted);
    let gzip = accepted.gzip && compresses(&reply.media);
    let headers = response.headers_mut();
    if let Ok(media) = HeaderValue::from_str(&reply.media) {
        headers.insert(header::CONTENT_TYPE, media);
    }
    if gzip {
        headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
        headers.append(header::VARY, HeaderValue::from_static("accept-encoding"));
    }
    if !accepted.head {
        *response.body_mut() = stream.body(gzip, failed);
    }
    response
}

/// True when one of the tags in `if-none-match` is equal to this one. Weak tags are sufficient for reading.
fn matches(known: &str, tag: &str) -> bool {
    known.split(',').map(|k| k.trim().trim_start_matches("W/")).any(|k| k == tag || k == "*")
}

fn compresses(media: &str) -> bool {
    media.starts_with("text/") || media.contains("json") || media.contains("svg")
}

fn gzip(body: &[u8]) -> Option<Vec<u8>> {
    let mut out = GzEncoder::new(Vec::with_capacity(body.len() / 4), Compression::fast());
    out.write_all(body).ok()?;
    out.finish().ok()
}

/// Member of a problem's `more`, and header of the response, with the methods of a path (RFC 9110, 15.5.6).
pub(super) const ALLOW: &str = "allow";

/// A refusal as problem+json (RFC 9457).
pub(super) fn problem(p: &Problem) -> Reply {
    let title = p.text.en.split([':', '；']).next().unwrap_or_default().to_owned();
    let body = ProblemBody {
        kind: format!("/problems/{}", p.code),
        title,
        status: p.status,
        code: p.code.to_owned(),
        detail_zh: p.text.zh.clone(),
        detail_en: p.text.en.clone(),
        more: p.more.as_deref().cloned(),
    };
    let allow = body.more.as_ref().and_then(|more| more[ALLOW].as_str()).map(str::to_owned);
    Reply {
        status: p.status,
        media: "application/problem+json".to_owned(),
        body: serde_json::to_vec(&body).unwrap_or_default(),
        headers: allow.map(|methods| (ALLOW, methods)).into_iter().collect(),
        ..Reply::default()
    }
}

#[cfg(test)]
mod tests {
    use super::attachment;

    #[test]
    fn a_file_has_the_name_of_its_project() {
        // RFC 6266, example in section 5: a plain name, and the same one percent-encoded in UTF-8.
        assert_eq!(
            attachment("试用 1-tasks.jsonl"),
            "attachment; filename=\"__ 1-tasks.jsonl\"; filename*=UTF-8''%E8%AF%95%E7%94%A8%201-tasks.jsonl"
        );
        // No name reaches another folder or ends the header's value.
        let odd = attachment("../a\"b\r\n-tasks.jsonl");
        assert_eq!(
            odd,
            "attachment; filename=\".._a_b__-tasks.jsonl\"; filename*=UTF-8''.._a_b__-tasks.jsonl"
        );
    }
}
