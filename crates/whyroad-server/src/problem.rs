//! Why the service refuses: one type from the store to the wire, rendered as problem+json (RFC 9457).

use crate::domain::workflow::Refusal;
use serde_json::Value;
use whyroad_label::merge::DraftError;
use whyroad_model::Bilingual;

/// A refusal with an HTTP status, a stable code and words in both languages.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{code}: {}", text.en)]
pub struct Problem {
    /// HTTP status.
    pub status: u16,
    /// Stable code.
    pub code: &'static str,
    /// In words.
    pub text: Bilingual,
    /// What belongs to it: findings, conflicts, seconds to wait.
    pub more: Option<Box<Value>>,
}

/// What most of the service returns.
pub type Answer<T> = Result<T, Problem>;

impl Problem {
    /// A problem.
    pub fn new(status: u16, code: &'static str, zh: impl Into<String>, en: impl Into<String>) -> Self {
        Self { status, code, text: Bilingual::new(zh, en), more: None }
    }

    /// The same with more to it.
    #[must_use]
    pub fn with(mut self, more: Value) -> Self {
        self.more = Some(Box::new(more));
        self
    }

    /// The request cannot be understood.
    pub fn request(why: impl std::fmt::Display) -> Self {
        Self::new(
            400,
            "request.invalid",
            format!("请求无效：{why}"),
            format!("the request is invalid: {why}"),
        )
    }

    /// Nobody is signed in.
    pub fn sign_in() -> Self {
        Self::new(401, "session.required", "请先登录", "sign in first")
    }

    /// Not for this person.
    pub fn forbidden() -> Self {
        Self::new(403, "access.denied", "没有权限", "this is not for you")
    }

    /// Not there, or not for this person to know of.
    pub fn missing() -> Self {
        Self::new(404, "not_found", "没有找到", "there is no such thing")
    }

    /// The lease is another's or a newer one.
    pub fn lease_lost() -> Self {
        Self::new(
            409,
            "lease.lost",
            "租约已失效：任务已被收回或在另一处打开",
            "the lease is void: the task was given on, or was opened elsewhere",
        )
    }

    /// The store failed.
    pub fn store(why: impl std::fmt::Display) -> Self {
        Self::new(
            503,
            "store.unavailable",
            format!("存储暂不可用，未保存：{why}"),
            format!("the store is not available, nothing was saved: {why}"),
        )
    }

    /// The same without what only concerns whoever runs the service: names of hosts and tables, messages of a database.
    #[must_use]
    pub fn for_strangers(self) -> Self {
        if self.code != "store.unavailable" {
            return self;
        }
        Self {
            text: Bilingual::new("存储暂不可用，未保存", "the store is not available, nothing was saved"),
            ..self
        }
    }

    /// The disk is full.
    pub fn disk_full() -> Self {
        Self::new(507, "store.full", "磁盘已满，未保存", "the disk is full, nothing was saved")
    }
}

impl From<DraftError> for Problem {
    fn from(e: DraftError) -> Self {
        let status = if e == DraftError::TooLarge { 413 } else { 422 };
        Self { status, code: e.code(), text: e.text(), more: None }
    }
}

impl From<Refusal> for Problem {
    fn from(r: Refusal) -> Self {
        let status = if r.code == "task.wrong_state" { 409 } else { 403 };
        Self { status, code: r.code, text: r.text, more: None }
    }
}
