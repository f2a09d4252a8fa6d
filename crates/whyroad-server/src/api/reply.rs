//! The response of a handler.

use super::stream::Stream;
use crate::problem::{Answer, Problem};
use serde::Serialize;

/// A response before it is sent.
#[derive(Clone, Debug, Default)]
pub struct Reply {
    /// HTTP status.
    pub status: u16,
    /// Media type.
    pub media: String,
    /// Bytes.
    pub body: Vec<u8>,
    /// Instead of `body`: writes the body while it is sent.
    pub stream: Option<Stream>,
    /// `set-cookie` headers.
    pub cookies: Vec<String>,
    /// Address to which the browser is redirected, with status 307; not cached.
    pub location: Option<String>,
    /// Origins from which a page may load images, besides its own.
    pub image_origins: Vec<String>,
    /// Further headers.
    pub headers: Vec<(&'static str, String)>,
    /// File name under which the browser stores it.
    pub file_name: Option<String>,
}

impl Reply {
    /// JSON, 200.
    pub fn json<T: Serialize>(value: &T) -> Answer<Self> {
        let body = serde_json::to_vec(value)
            .map_err(|e| Problem::new(500, "internal", "内部错误", e.to_string()))?;
        Ok(Self { status: 200, media: "application/json".to_owned(), body, ..Self::default() })
    }

    /// Nothing, 204.
    pub fn nothing() -> Self {
        Self { status: 204, ..Self::default() }
    }

    /// Bytes with a media type, 200.
    pub fn bytes(media: impl Into<String>, body: Vec<u8>) -> Self {
        Self { status: 200, media: media.into(), body, ..Self::default() }
    }
}
