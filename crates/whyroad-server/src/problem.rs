//! Errors of the service: one type from the store to the HTTP response, rendered as problem+json (RFC 9457).

use crate::domain::workflow::Refusal;
use serde_json::Value;
use whyroad_label::merge::DraftError;
use whyroad_model::Bilingual;

/// An error with an HTTP status, a stable code and a message in both languages.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{code}: {}", text.en)]
pub struct Problem {
    /// HTTP status.
    pub status: u16,
    /// Stable code.
    pub code: &'static str,
    /// Message.
    pub text: Bilingual,
    /// Additional data: findings, conflicts, seconds to wait.
    pub more: Option<Box<Value>>,
}

/// Result type of most functions of the service.
pub type Answer<T> = Result<T, Problem>;

impl Problem {
    /// A problem.
    pub fn new(status: u16, code: &'static str, zh: impl Into<String>, en: impl Into<String>) -> Self {
        Self { status, code, text: Bilingual::new(zh, en), more: None }
    }

    /// The same with additional data.
    #[must_use]
    pub fn with(mut self, more: Value) -> Self {
        self.more = Some(Box::new(more));
        self
    }

    /// The request is invalid.
    pub fn request(zh: impl std::fmt::Display, en: impl std::fmt::Display) -> Self {
        Self::new(400, "request.invalid", format!("请求无效：{zh}"), format!("the request is invalid: {en}"))
    }

    /// The body of the request is not the JSON that the route requires.
    pub fn unreadable(e: &serde_json::Error) -> Self {
        let at = format!("第 {} 行第 {} 列", e.line(), e.column());
        let zh = if e.is_data() { "字段缺失、未知或类型不符" } else { "不是完整的 JSON" };
        Self::request(format!("{zh}（{at}）"), e).with(serde_json::json!({ "detail": e.to_string() }))
    }

    /// The results of mining cannot be read.
    pub fn mined_unreadable(why: Bilingual) -> Self {
        let (zh, en) = (why.zh, why.en);
        Self::new(
            422,
            "mined.unreadable",
            format!("挖掘结果无法读取：{zh}"),
            format!("the mined folder cannot be read: {en}"),
        )
    }

    /// The caller is not signed in.
    pub fn sign_in() -> Self {
        Self::new(401, "session.required", "请先登录", "sign in first")
    }

    /// The caller has no permission.
    pub fn forbidden() -> Self {
        Self::new(403, "access.denied", "没有权限", "permission denied")
    }

    /// Not found, or hidden from the caller.
    pub fn missing() -> Self {
        Self::new(404, "not_found", "没有找到", "not found")
    }

    /// The lease belongs to another user, or a newer one exists.
    pub fn lease_lost() -> Self {
        Self::new(
            409,
            "lease.lost",
            "领取已失效：任务已重新分配或在另一处打开",
            "the lease is no longer valid: the task was reassigned or opened elsewhere",
        )
    }

    /// The store failed.
    pub fn store(why: impl std::fmt::Display) -> Self {
        Self::new(
            503,
            "store.unavailable",
            format!("存储暂不可用，未保存：{why}"),
            format!("the store is unavailable, nothing was saved: {why}"),
        )
    }

    /// The same without details that only concern the operator: names of hosts and tables, messages of a database.
    #[must_use]
    pub fn without_internals(self) -> Self {
        if self.code != "store.unavailable" {
            return self;
        }
        Self {
            text: Bilingual::new("存储暂不可用，未保存", "the store is unavailable, nothing was saved"),
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
