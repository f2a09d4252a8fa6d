//! Tasks, leases, drafts, actions, and what pickers offer.

pub use super::{making::*, talk::*};

use super::model::Judgement;
use super::workflow::{Action, Stage, State};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use whyroad_framework::ResolvedSpec;
use whyroad_label::merge::{FieldChange, FieldConflict};
use whyroad_model::Bilingual;
use whyroad_model::messages::{Keyframe, MatchedCondition};

/// A task in a list. Says nothing of what comes after its keyframe.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct TaskSummary {
    /// Id.
    pub id: String,
    /// Project.
    pub project: String,
    /// Clip.
    pub clip_id: String,
    /// Drive.
    pub drive_id: String,
    /// Class.
    pub scenario_id: String,
    /// State.
    pub state: State,
    /// How much may be seen.
    pub stage: Stage,
    /// Greater is sooner.
    pub priority: i64,
    /// Display name of who holds or is to have it.
    pub assigned_to: Option<String>,
    /// Display name of its author.
    pub author: Option<String>,
    /// Display name of its checker.
    pub checker: Option<String>,
    /// End of the lease, where one holds it.
    pub lease_until: Option<i64>,
    /// Several people label the same episode independently.
    pub overlap: bool,
    /// Outcome of adjudication: `chosen` or `superseded`.
    pub adjudication: Option<String>,
    /// When it last moved.
    pub updated: i64,
    /// Somebody asks the lead about it, and the lead has not answered.
    pub asks_lead: bool,
    /// The labels of its overlap group disagree about the decision, and none was chosen yet; said to leads.
    pub disagrees: bool,
    /// Address of a small picture of its keyframe, where the caller may see one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thumbnail: Option<String>,
}

/// A page of tasks.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Tasks {
    /// By priority, then age, or as `sort` says.
    pub items: Vec<TaskSummary>,
    /// Number of tasks that the filter lets through; on the first page only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub total: Option<i64>,
    /// Value for `cursor`, where there are more.
    pub next: Option<String>,
}

/// One task with all that may be seen of it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Task {
    /// In short.
    pub task: TaskSummary,
    /// The label in the making (`CocLabel`); in Stage I only the fields of Stage I.
    pub draft: Value,
    /// Raised by each change of the draft: `base_version` of the next one.
    pub version: i64,
    /// How much may be seen.
    pub stage: Stage,
    /// The caller's fencing token, where the caller holds the lease.
    pub fence: Option<i64>,
    /// End of the caller's lease.
    pub lease_until: Option<i64>,
    /// What is to be done for this class; null for a class without a spec.
    #[schemars(with = "Option<Value>")]
    #[serde(skip_deserializing)]
    pub spec: Option<ResolvedSpec>,
    /// What the rule proposes.
    pub suggestion: Suggestion,
    /// Name of the model that drafted the label; null where a rule or a person did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drafted_by: Option<String>,
    /// What a model says of the label that was handed in; for checkers, auditors and leads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judgement: Option<Judgement>,
    /// Comments; other people's only after Stage I.
    pub comments: Vec<Comment>,
    /// Entries of the history that the caller may see.
    pub history_count: i64,
    /// What the checker finds in the draft as it may be seen.
    pub findings: Vec<Finding>,
    /// Why the caller cannot take the task now; null for who holds it, for who can take it, and where it is finished.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub take_refused: Option<Bilingual>,
    /// What the caller may do now: actions, `edit`, `comment`, `assign`, `adjudicate`.
    pub permissions: Vec<String>,
    /// In rework and check: fields that differ from what was first suggested.
    pub changed_from_suggestion: Vec<String>,
}

/// Keyframe and range by the rule.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Suggestion {
    /// The keyframe; in Stage I without the end of its range.
    pub keyframe: Keyframe,
    /// The second keyframe, of classes that have two; withheld in Stage I.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_keyframe: Option<Keyframe>,
    /// Start of the range.
    pub range_start: String,
    /// End of the range; withheld in Stage I.
    pub range_end: Option<String>,
    /// The target of the rule.
    pub target_id: Option<String>,
    /// Conditions with their values; withheld in Stage I (signals may look ahead).
    pub conditions: Vec<MatchedCondition>,
    /// Signals that the rule reads.
    pub signals: Vec<String>,
}

/// A finding of the checker.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Finding {
    /// Stable code; `docs/diagnostics/<code>.md`.
    pub code: String,
    /// `error`, `warning` or `note`.
    pub severity: String,
    /// In Chinese.
    pub message_zh: String,
    /// In English.
    pub message_en: String,
    /// JSON pointer into the label.
    pub pointer: String,
    /// How to fix it, in Chinese.
    pub hint_zh: Option<String>,
    /// How to fix it, in English.
    pub hint_en: Option<String>,
}

/// Body of `POST /projects/{p}/tasks:next`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NextTask {
    /// `label` (own unfinished and returned ones first), `check` or `audit`.
    pub kind: WorkKind,
}

/// Kind of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "Kind")]
pub enum WorkKind {
    /// Stage I, II or rework.
    Label,
    /// Check.
    Check,
    /// Audit.
    Audit,
}

/// Why `tasks:next` has nothing for the caller.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct QueueState {
    /// Each reason that holds for some waiting task; none when there is something to take after all.
    pub reasons: Vec<QueueReason>,
}

/// A reason why a task that waits is not for somebody, or why none waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum QueueReason {
    /// The caller does not have the role for this kind of work.
    Role,
    /// The project has no task at all.
    NoTasks,
    /// No task waits for this kind of work.
    Finished,
    /// Somebody else holds it now.
    Held,
    /// It is assigned to somebody else.
    Assigned,
    /// Its draft is in another language.
    Language,
    /// It is of a class that the caller does not label.
    Classes,
    /// The caller was shown what comes after its keyframe.
    FutureSeen,
    /// The caller labels another copy of the same episode.
    OverlapTwice,
    /// The caller wrote it.
    OwnWork,
    /// The caller checked it.
    OwnCheck,
    /// It would show the future of a task whose Stage I the caller is doing.
    #[serde(rename = "stage1_first")]
    Stage1First,
    /// Something else.
    Other,
}

/// Body of `POST /tasks/{t}/lease`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeaseRequest {
    /// What about it.
    pub action: LeaseAction,
    /// For heartbeat and release.
    #[serde(default)]
    pub fence: Option<i64>,
    /// For release: why it is given back; the history keeps it.
    #[serde(default)]
    pub reason: Option<String>,
}

/// What about a lease.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum LeaseAction {
    /// Have it.
    Take,
    /// Keep it.
    Heartbeat,
    /// Give it back.
    Release,
}

/// A lease.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Lease {
    /// Goes with every write; a newer lease makes older ones void.
    pub fence: i64,
    /// When it ends; null when given back.
    pub lease_until: Option<i64>,
    /// State of the task now.
    pub state: State,
}

/// Body of `POST /tasks/{t}/assign`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Assign {
    /// Name or id of the user; null for the queue.
    pub user: Option<String>,
}

/// Body of `POST /projects/{p}/tasks:change`: what is given is changed in each task.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BulkChange {
    /// Ids; at most 500.
    pub tasks: Vec<String>,
    /// To whom they are assigned.
    #[serde(default)]
    pub assign: Option<Assign>,
    /// Their priority; greater is sooner.
    #[serde(default)]
    pub priority: Option<i64>,
}

/// Result of `POST /projects/{p}/tasks:change`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct BulkChanged {
    /// Tasks that were changed.
    pub changed: u32,
    /// Tasks that were not, and why.
    pub refused: Vec<BulkRefused>,
}

/// A task that was not changed.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct BulkRefused {
    /// Its id.
    pub task: String,
    /// Why.
    pub text: Bilingual,
}

/// Body of `PATCH /tasks/{t}/draft`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DraftChange {
    /// Fencing token of the lease.
    pub fence: i64,
    /// Version of the draft that the changes were made on.
    pub base_version: i64,
    /// In order; at most 100.
    pub changes: Vec<FieldChange>,
}

/// Answer of `PATCH /tasks/{t}/draft`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct DraftSaved {
    /// The draft's version now.
    pub version: i64,
    /// What the checker finds now.
    pub findings: Vec<Finding>,
    /// The whole draft, where others' changes came between.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub merged: Option<Value>,
    /// End of the lease, renewed.
    pub lease_until: i64,
}

/// In `more` of a 409 `draft.conflict`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Conflicts {
    /// The draft's version now.
    pub version: i64,
    /// The draft now.
    pub draft: Value,
    /// Fields that both changed.
    pub conflicts: Vec<FieldConflict>,
}

/// Body of `POST /tasks/{t}/actions`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TaskAction {
    /// Fencing token; not needed by a lead who reopens, skips, rejects or adjudicates.
    #[serde(default)]
    pub fence: Option<i64>,
    /// What to do.
    pub action: ActionName,
    /// Why; skip, reject, send_back and reopen need it.
    #[serde(default)]
    pub reason: Option<String>,
    /// Comments on fields.
    #[serde(default)]
    pub comments: Vec<NewComment>,
    /// For restore: entry of the history whose draft is to come back.
    #[serde(default)]
    pub seq: Option<i64>,
    /// For adjudicate: a label put together from those of the group, in place of the task's own. It is checked again.
    #[serde(default)]
    pub label: Option<Value>,
}

/// Actions of `POST /tasks/{t}/actions`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ActionName {
    /// Ends Stage I.
    LockStage1,
    /// Hands in.
    Submit,
    /// Leaves out.
    Skip,
    /// Says that it cannot be labeled.
    Reject,
    /// Finds it good.
    Accept,
    /// Returns it for rework.
    SendBack,
    /// Starts again.
    Reopen,
    /// Of an overlap group, takes this label.
    Adjudicate,
    /// Brings an earlier draft back.
    Restore,
}

impl ActionName {
    /// The workflow's action, where it is one.
    pub fn in_workflow(self) -> Option<Action> {
        Some(match self {
            Self::LockStage1 => Action::LockStage1,
            Self::Submit => Action::Submit,
            Self::Skip => Action::Skip,
            Self::Reject => Action::Reject,
            Self::Accept => Action::Accept,
            Self::SendBack => Action::SendBack,
            Self::Reopen => Action::Reopen,
            Self::Adjudicate | Self::Restore => return None,
        })
    }
}

/// Body of `POST /tasks/{t}/validate`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Validate {
    /// A label.
    pub label: Value,
}

/// What the checker finds.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Findings {
    /// By place.
    pub findings: Vec<Finding>,
}

/// Classes, decisions and reference words for pickers.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FrameworkView {
    /// `{l1: [{id, name, definition, l2: [..]}]}` in tree order.
    pub taxonomy: Value,
    /// `{longitudinal: [{id, name, meaning, not}], lateral: [{.., directions}], null: {..}}`.
    pub decisions: Value,
    /// Decisions of each leaf, the usual ones first: what a picker offers (`scenarios/decisions.yaml`). A decision that
    /// is not listed contradicts the class.
    pub choices: BTreeMap<String, ClassChoices>,
    /// Longitudinal and lateral decisions that do not go together in any class.
    pub impossible_pairs: Vec<[String; 2]>,
    /// Reasons of the safety filter: `{id, name}`.
    pub safety_reasons: Vec<Value>,
    /// Reference categories of components (LABELING.md 3).
    pub categories: Vec<Value>,
    /// Records that specs ask for, by id.
    pub records: BTreeMap<String, Value>,
    /// Versions of taxonomy and format.
    pub versions: BTreeMap<String, String>,
}

/// The decisions of a leaf.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ClassChoices {
    /// Along the path.
    pub longitudinal: Vec<DecisionChoice>,
    /// Across the path.
    pub lateral: Vec<DecisionChoice>,
    /// At least one channel has a decision.
    pub decides: bool,
    /// The leaf's name reveals what happened after the keyframe.
    pub reveals: bool,
}

/// A decision that goes with a leaf.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct DecisionChoice {
    /// The decision; null is no change.
    pub id: Option<String>,
    /// The only direction that is meant; null for every direction.
    pub direction: Option<String>,
    /// Seen most of the time; else seen and allowed.
    pub usual: bool,
}

/// The labels of one overlap group, side by side; only when all of them are submitted.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Overlap {
    /// In the order of making.
    pub items: Vec<OverlapItem>,
}

/// One label of an overlap group.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct OverlapItem {
    /// The task.
    pub task: TaskSummary,
    /// Its label.
    pub label: Value,
    /// What the checker finds in it.
    pub findings: Vec<Finding>,
}
