//! Tasks, leases, drafts, actions, and data for pickers.

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

/// A task in a list. It contains nothing from after its keyframe.
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
    /// The object that the rule bound, unless the class is hidden; tells tasks of one class and keyframe apart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target_id: Option<String>,
    /// State.
    pub state: State,
    /// How much may be shown.
    pub stage: Stage,
    /// Higher values come first.
    pub priority: i64,
    /// Display name of the user who holds it or is assigned to it.
    pub assigned_to: Option<String>,
    /// Display name of its author.
    pub author: Option<String>,
    /// Display name of its checker.
    pub checker: Option<String>,
    /// End of the lease, if there is one.
    pub lease_until: Option<i64>,
    /// Several people label the same episode independently.
    pub overlap: bool,
    /// Outcome of adjudication: `chosen` or `superseded`.
    pub adjudication: Option<String>,
    /// When it last changed.
    pub updated: i64,
    /// Seconds from the start of the drive to the keyframe; in lists, where the lake has the drive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keyframe_s: Option<f64>,
    /// Where the window of a sample around the keyframe reaches beyond the drive; in Stage I only its history, but all
    /// of it in lists of leads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub short_window: Option<ShortWindow>,
    /// The class that fits instead, as its annotator says; empty for one that they do not know.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right_class: Option<String>,
    /// The task of another class that replaces it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub replaced_by: Option<String>,
    /// The task of another class that it replaces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub replaces: Option<String>,
    /// Codes of the findings with which it was submitted.
    #[serde(default)]
    pub findings: Vec<String>,
    /// It has a question to the lead that is not answered.
    pub asks_lead: bool,
    /// The labels of its overlap group disagree about the decision, and none was chosen yet; set for leads only.
    pub disagrees: bool,
    /// All labels of its overlap group are handed in, and none was chosen yet; set for leads only.
    pub to_choose: bool,
    /// Address of a thumbnail of its keyframe, if the caller may see one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thumbnail: Option<String>,
}

/// What a drive has of the window of a training sample, where that is too little for the default spec of a data set
/// (2 s before the keyframe, 6 s after it).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ShortWindow {
    /// Seconds before the keyframe, if they are too few.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub before_s: Option<f64>,
    /// Seconds after it, if they are too few.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after_s: Option<f64>,
}

/// A page of tasks.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Tasks {
    /// By priority, then age, or by `sort`.
    pub items: Vec<TaskSummary>,
    /// Number of tasks that match the filter; on the first page only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub total: Option<i64>,
    /// Value for `cursor`, if there are more.
    pub next: Option<String>,
}

/// One task with everything that may be shown of it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Task {
    /// Summary.
    pub task: TaskSummary,
    /// The draft of the label (`CocLabel`); in Stage I only the fields of Stage I.
    pub draft: Value,
    /// Increased by each change of the draft: `base_version` of the next one.
    pub version: i64,
    /// How much may be shown.
    pub stage: Stage,
    /// The caller's fencing token, if the caller holds the lease.
    pub fence: Option<i64>,
    /// End of the caller's lease.
    pub lease_until: Option<i64>,
    /// Labeling spec of its class; null for a class without a spec.
    #[schemars(with = "Option<Value>")]
    #[serde(skip_deserializing)]
    pub spec: Option<ResolvedSpec>,
    /// The rule's proposal.
    pub suggestion: Suggestion,
    /// Name of the model that drafted the label; null if a rule or a person did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drafted_by: Option<String>,
    /// Components and causes of an imported draft (`critical_components`, `causes`), which Stage I does not show.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub imported: Option<Value>,
    /// A model's judgment of the submitted label; for checkers, auditors and leads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judgement: Option<Judgement>,
    /// Comments; other people's only after Stage I.
    pub comments: Vec<Comment>,
    /// Entries of the history that the caller may see.
    pub history_count: i64,
    /// Findings of the checker in the draft as far as it may be shown.
    pub findings: Vec<Finding>,
    /// Why the caller cannot take the task now; null for the holder, for users who can take it, and if it is finished.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub take_refused: Option<Bilingual>,
    /// Actions that the caller may do now: workflow actions, `edit`, `comment`, `assign`, `adjudicate`.
    pub permissions: Vec<String>,
    /// In rework and check: fields that differ from the first suggestion.
    pub changed_from_suggestion: Vec<String>,
}

/// Keyframe and range from the rule.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Suggestion {
    /// The keyframe; in Stage I without the end of its range.
    pub keyframe: Keyframe,
    /// The second keyframe, for classes with two; withheld in Stage I.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_keyframe: Option<Keyframe>,
    /// Start of the range.
    pub range_start: String,
    /// End of the range; withheld in Stage I.
    pub range_end: Option<String>,
    /// The target of the rule.
    pub target_id: Option<String>,
    /// Conditions with their values; withheld in Stage I (signals may use later frames).
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
    /// Each reason that applies to some waiting task; empty if a task has become available in the meantime.
    pub reasons: Vec<QueueReason>,
}

/// A reason why a waiting task is not available to a user, or why none waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum QueueReason {
    /// The caller does not have the role for this kind of work.
    Role,
    /// The project has no tasks.
    NoTasks,
    /// No task waits for this kind of work.
    Finished,
    /// Another user holds it now.
    Held,
    /// It is assigned to another user.
    Assigned,
    /// Its draft is in another language.
    Language,
    /// It is of a class that the caller does not label.
    Classes,
    /// The caller has seen what comes after its keyframe.
    FutureSeen,
    /// The caller labels another copy of the same episode.
    OverlapTwice,
    /// The caller wrote it.
    OwnWork,
    /// The caller checked it.
    OwnCheck,
    /// It is one of several labels of its episode, of which a lead has chosen none yet.
    NotChosen,
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
    /// The action.
    pub action: LeaseAction,
    /// For heartbeat and release.
    #[serde(default)]
    pub fence: Option<i64>,
    /// For release: why it is returned to the queue; kept in the history.
    #[serde(default)]
    pub reason: Option<String>,
}

/// Action on a lease.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum LeaseAction {
    /// Start it.
    Take,
    /// Renew it.
    Heartbeat,
    /// End it.
    Release,
}

/// A lease.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Lease {
    /// Required in every write; a newer lease invalidates older ones.
    pub fence: i64,
    /// When it ends; null when released.
    pub lease_until: Option<i64>,
    /// State of the task now.
    pub state: State,
}

/// Body of `POST /tasks/{t}/assign`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Assign {
    /// Name or id of the user; null for returning it to the queue.
    pub user: Option<String>,
}

/// Body of `POST /projects/{p}/tasks:change`: changes the fields that are given in each task.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BulkChange {
    /// Ids; at most 500.
    pub tasks: Vec<String>,
    /// User to whom they are assigned.
    #[serde(default)]
    pub assign: Option<Assign>,
    /// Their priority; higher values come first.
    #[serde(default)]
    pub priority: Option<i64>,
}

/// Result of `POST /projects/{p}/tasks:change`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct BulkChanged {
    /// Tasks that were changed.
    pub changed: u32,
    /// Tasks that were not changed, and why.
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

/// Body of `POST /tasks/{t}/reclass`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OtherClass {
    /// The L3 class that fits.
    pub scenario: String,
}

/// Body of `PATCH /tasks/{t}/draft`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DraftChange {
    /// Fencing token of the lease.
    pub fence: i64,
    /// Version of the draft on which the changes are based.
    pub base_version: i64,
    /// In order; at most 100.
    pub changes: Vec<FieldChange>,
}

/// Answer of `PATCH /tasks/{t}/draft`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct DraftSaved {
    /// The draft's version now.
    pub version: i64,
    /// Current findings of the checker.
    pub findings: Vec<Finding>,
    /// The whole draft, if others have changed it in the meantime.
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
    /// The action.
    pub action: ActionName,
    /// Reason; required for skip, reject, send_back and reopen.
    #[serde(default)]
    pub reason: Option<String>,
    /// Comments on fields.
    #[serde(default)]
    pub comments: Vec<NewComment>,
    /// For restore: entry of the history whose draft is restored.
    #[serde(default)]
    pub seq: Option<i64>,
    /// For skip, if the class of the task does not fit: the class that fits (L2 or L3), or an empty text.
    #[serde(default)]
    pub right_class: Option<String>,
    /// For adjudicate: a label merged from those of the group, instead of the task's own. It is checked again.
    #[serde(default)]
    pub label: Option<Value>,
}

/// Actions of `POST /tasks/{t}/actions`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ActionName {
    /// Ends Stage I.
    LockStage1,
    /// Submits.
    Submit,
    /// Skips.
    Skip,
    /// States that it cannot be labeled.
    Reject,
    /// Accepts the label.
    Accept,
    /// Returns it for rework.
    SendBack,
    /// Starts the task again.
    Reopen,
    /// Chooses this label for an overlap group.
    Adjudicate,
    /// Restores an earlier draft.
    Restore,
}

impl ActionName {
    /// The corresponding action of the workflow, if there is one.
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

/// Findings of the checker.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Findings {
    /// By location.
    pub findings: Vec<Finding>,
}

/// Classes, decisions and reference words for pickers.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FrameworkView {
    /// `{l1: [{id, name, definition, l2: [..]}]}` in tree order.
    pub taxonomy: Value,
    /// `{longitudinal: [{id, name, meaning, not}], lateral: [{.., directions}], null: {..}}`.
    pub decisions: Value,
    /// Decisions of each L3 class, the usual ones first: options of a picker (`scenarios/decisions.yaml`). A decision
    /// that is not listed contradicts the class.
    pub choices: BTreeMap<String, ClassChoices>,
    /// Longitudinal and lateral decisions that cannot be combined in any class.
    pub impossible_pairs: Vec<[String; 2]>,
    /// Reasons of the safety filter: `{id, name}`.
    pub safety_reasons: Vec<Value>,
    /// Reference categories of components (LABELING.md 3).
    pub categories: Vec<Value>,
    /// Records that specs require, by id.
    pub records: BTreeMap<String, Value>,
    /// Versions of taxonomy and format.
    pub versions: BTreeMap<String, String>,
}

/// The decisions of an L3 class.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ClassChoices {
    /// Longitudinal.
    pub longitudinal: Vec<DecisionChoice>,
    /// Lateral.
    pub lateral: Vec<DecisionChoice>,
    /// At least one channel has a decision.
    pub decides: bool,
    /// The name of the L3 class reveals what happened after the keyframe.
    pub reveals: bool,
}

/// A decision that an L3 class allows.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct DecisionChoice {
    /// The decision; null is no change.
    pub id: Option<String>,
    /// The only possible direction; null for every direction.
    pub direction: Option<String>,
    /// Usual for the class; else only allowed.
    pub usual: bool,
}

/// The labels of one overlap group; only when all of them are submitted.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Overlap {
    /// In the order of creation.
    pub items: Vec<OverlapItem>,
}

/// One label of an overlap group.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct OverlapItem {
    /// The task.
    pub task: TaskSummary,
    /// Its label.
    pub label: Value,
    /// Findings of the checker in it.
    pub findings: Vec<Finding>,
}
