//! Why a question has no answer. No error holds the key: messages of an endpoint are shown without it.

use crate::client::Limit;
use std::path::PathBuf;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of this crate; each has a page in `docs/diagnostics/`.
pub const CODES: &[&str] = &[
    "chat.settings",
    "chat.unavailable",
    "chat.rejected",
    "chat.refused",
    "chat.answer",
    "chat.budget",
    "chat.cache",
];

/// Why a question has no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ChatError {
    /// The address, the key's variable or another setting is not usable.
    #[error("{0}")]
    Settings(Bilingual),
    /// Time-outs, no connection, 429 and 5xx, after all retries.
    #[error("no answer after {attempts} attempts: {why}")]
    Unavailable {
        /// Requests that were sent.
        attempts: u32,
        /// The error of the last one.
        why: String,
    },
    /// A status that a retry does not change: 400, 401, 404.
    #[error("the endpoint answers with status {status}: {why}")]
    Rejected {
        /// HTTP status.
        status: u16,
        /// The endpoint's message, shortened.
        why: String,
    },
    /// The model declined, or a content filter did.
    #[error("the model refused: {0}")]
    Refused(String),
    /// The answer is cut off, is not JSON, or does not have the required form, also when asked again.
    #[error("the answer cannot be used: {0}")]
    Answer(String),
    /// The budget is used up.
    #[error("the budget is used up: {0:?}")]
    Budget(Limit),
    /// The cache cannot be written.
    #[error("cannot write {path}: {why}")]
    Cache {
        /// File or folder.
        path: PathBuf,
        /// Why.
        why: String,
    },
}

impl ChatError {
    /// True when no further question of this run can be answered.
    pub fn ends_the_run(&self) -> bool {
        matches!(self, Self::Settings(_) | Self::Budget(_) | Self::Cache { .. })
            || matches!(self, Self::Rejected { status: 401 | 403 | 404, .. })
    }

    /// The error as a diagnostic.
    pub fn diagnostic(&self) -> Diagnostic {
        let (code, message) = match self {
            Self::Settings(text) => ("chat.settings", text.clone()),
            Self::Unavailable { attempts, why } => (
                "chat.unavailable",
                Bilingual::new(
                    format!("发送 {attempts} 次请求后仍无回答：{why}"),
                    format!(
                        "no answer after {attempts} {}: {why}",
                        if *attempts == 1 { "request" } else { "requests" }
                    ),
                ),
            ),
            Self::Rejected { status, why } => (
                "chat.rejected",
                Bilingual::new(
                    format!("模型服务以状态 {status} 拒绝了请求：{why}"),
                    format!("the endpoint rejects the request with status {status}: {why}"),
                ),
            ),
            Self::Refused(why) => (
                "chat.refused",
                Bilingual::new(format!("模型拒绝回答：{why}"), format!("the model refused to answer: {why}")),
            ),
            Self::Answer(why) => (
                "chat.answer",
                Bilingual::new(format!("回答无法使用：{why}"), format!("the answer cannot be used: {why}")),
            ),
            Self::Budget(Limit::Requests(n)) => (
                "chat.budget",
                Bilingual::new(
                    format!("已发送 {n} 次请求，达到上限"),
                    format!("{n} requests were sent, the maximum"),
                ),
            ),
            Self::Budget(Limit::Tokens(n)) => (
                "chat.budget",
                Bilingual::new(
                    format!("令牌数达到上限 {n}"),
                    format!("the maximum of {n} tokens is used up"),
                ),
            ),
            Self::Budget(Limit::Uncounted(n)) => (
                "chat.budget",
                Bilingual::new(
                    format!("模型服务没有给出令牌数，无法遵守上限 {n}；请改用 --max-requests"),
                    format!(
                        "the endpoint states no number of tokens, so the maximum of {n} cannot be kept; use --max-requests"
                    ),
                ),
            ),
            Self::Cache { path, why } => (
                "chat.cache",
                Bilingual::new(
                    format!("无法写入 {}：{why}", path.display()),
                    format!("cannot write {}: {why}", path.display()),
                ),
            ),
        };
        Diagnostic::error(code, message)
    }
}
