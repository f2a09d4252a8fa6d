//! What a handler answers with.

use super::stream::Stream;
use crate::problem::{Answer, Problem};
use serde::Serialize;

/// An answer before it is put on the wire.
#[derive(Clone, Debug, Default)]
pub struct Reply {
    /// HTTP status.
    pub status: u16,
    /// Media type.
    pub media: String,
    /// Bytes.
    pub body: Vec<u8>,
    /// In place of `body`: what makes it while it is sent.
    pub stream: Option<Stream>,
    /// `set-cookie` headers.
    pub cookies: Vec<String>,
    /// Where the browser finds it instead, with status 307; not to be kept.
    pub location: Option<String>,
    /// Origins from which a page may load images, besides its own.
    pub image_origins: Vec<String>,
    /// File name, where the browser is to store it.
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

    /// Bytes of some kind, 200.
    pub fn bytes(media: impl Into<String>, body: Vec<u8>) -> Self {
        Self { status: 200, media: media.into(), body, ..Self::default() }
    }
}
