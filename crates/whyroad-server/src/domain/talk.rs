//! The history of a task and comments on its fields.

use crate::domain::workflow::State;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use whyroad_label::merge::FieldChange;

/// The history of a task.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct History {
    /// Oldest first. In Stage I only the caller's own.
    pub items: Vec<HistoryEntry>,
    /// Value for `cursor`, where there are more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next: Option<String>,
}

/// One entry of the history.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct HistoryEntry {
    /// From 1.
    pub seq: i64,
    /// When.
    pub at: i64,
    /// Display name of the user who did it.
    pub actor: String,
    /// `create`, `take`, `edit`, `submit`, ...
    pub action: String,
    /// State before.
    pub from_state: Option<State>,
    /// State after.
    pub to_state: Option<State>,
    /// The changed fields of an edit.
    pub changes: Vec<FieldChange>,
    /// The previous values of these fields, in the same order; null where there was none.
    pub before: Vec<Value>,
    /// Reason given.
    pub comment: Option<String>,
    /// The draft's version after it.
    pub version: i64,
}

/// An earlier version of the draft.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct DraftAt {
    /// Entry of the history.
    pub seq: i64,
    /// The draft after it.
    pub draft: Value,
}

/// A comment.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Comment {
    /// Id.
    pub id: String,
    /// JSON pointer of the field; empty for the whole label.
    pub path: String,
    /// Display name of the author.
    pub author: String,
    /// Plain text.
    pub text: String,
    /// When.
    pub at: i64,
    /// Resolved.
    pub resolved: bool,
    /// It asks the lead.
    pub to_lead: bool,
}

/// Body of `POST /tasks/{t}/comments`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewComment {
    /// JSON pointer of the field; empty for the whole label.
    pub path: String,
    /// Plain text.
    pub text: String,
    /// Asks the lead: the task is marked in lists until the comment is resolved.
    #[serde(default)]
    pub to_lead: bool,
}
