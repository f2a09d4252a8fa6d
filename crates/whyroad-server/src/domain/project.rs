//! Projects, members, dashboard, webhooks.

use super::people::User;
use super::safety::SafetyCounts;
pub use super::settings::{HistoryRule, Settings, SettingsChange, Stage1Class};
use crate::domain::workflow::Role;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use whyroad_model::Bilingual;

/// A project.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Project {
    /// Id.
    pub id: String,
    /// Name.
    pub name: String,
    /// Label guide, plain text.
    pub guide: String,
    /// Target number of labels, by L3 class.
    pub quota: BTreeMap<String, u32>,
    /// Settings.
    pub settings: Settings,
    /// The caller's roles in it.
    pub roles: Vec<Role>,
}

/// Pending work in a project.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Work {
    /// Tasks by state, without labels of which the lead chose another one; empty for users who are not staff.
    pub by_state: BTreeMap<String, i64>,
    /// The sum of these; 0 for users who are not staff.
    pub total: i64,
    /// Tasks that the queue has for the caller to check; 0 for users who do not check.
    pub to_check: i64,
    /// Tasks that the queue has for the caller to audit; 0 for users who do not audit.
    pub to_audit: i64,
    /// Tasks with an open question to the lead; 0 for users who are not staff.
    pub asked: i64,
    /// Tasks of overlap groups that are still to be adjudicated; 0 for users who are not leads.
    pub disagreeing: i64,
    /// Tasks whose class does not fit, as their annotators say, and that no other task replaces; 0 for users who are
    /// not leads.
    pub wrong_class: i64,
    /// Tasks of overlap groups that are handed in and of which no label was chosen; 0 for users who are not leads.
    pub to_choose: i64,
    /// Tasks whose drafts are still being created in the background; 0 for users who are not staff.
    pub pending: i64,
    /// The caller's own tasks.
    pub mine: MyWork,
}

/// The tasks of one annotator in a project.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MyWork {
    /// Returned for rework.
    pub returned: i64,
    /// Started and not submitted.
    pub begun: i64,
    /// Assigned and not started.
    pub assigned: i64,
    /// Submitted, not accepted yet.
    pub waiting: i64,
    /// Accepted.
    pub accepted: i64,
    /// Submissions of today, by the project's clock.
    pub submitted_today: i64,
}

/// List of projects.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Projects {
    /// By name.
    pub items: Vec<Project>,
}

/// Body of `POST /projects`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewProject {
    /// Name.
    pub name: String,
    /// Label guide.
    #[serde(default)]
    pub guide: String,
    /// Target number of labels, by L3 class.
    #[serde(default)]
    pub quota: BTreeMap<String, u32>,
    /// Settings.
    #[serde(default)]
    pub settings: Settings,
}

/// Body of `PATCH /projects/{p}`: changes the fields that are given.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProjectChange {
    /// Name.
    #[serde(default)]
    pub name: Option<String>,
    /// Label guide.
    #[serde(default)]
    pub guide: Option<String>,
    /// Target number of labels, by L3 class: all of them, classes that are not in it have no target any more.
    #[serde(default)]
    pub quota: Option<BTreeMap<String, u32>>,
    /// Settings: only those that are given are changed.
    #[serde(default)]
    pub settings: Option<SettingsChange>,
}

/// A member of a project.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Member {
    /// User.
    pub user: User,
    /// Roles.
    pub roles: Vec<Role>,
    /// Classes (full ids or prefixes of them) that the queue gives to this member; empty for all.
    pub skills: Vec<String>,
    /// Languages of the tasks that the queue gives to this member, `zh`, `en`; empty for the language of their page.
    pub languages: Vec<String>,
}

/// Members.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Members {
    /// By name.
    pub items: Vec<Member>,
}

/// Body of `POST /projects/{p}/members`: adds a member or changes one; without roles the member is removed.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MemberChange {
    /// Name or id of the user.
    pub user: String,
    /// Roles.
    pub roles: Vec<Role>,
    /// Classes that the queue gives to this member; empty for all.
    #[serde(default)]
    pub skills: Vec<String>,
    /// Languages of the tasks that the queue gives to this member, empty for the language of their page; unchanged if
    /// absent.
    #[serde(default)]
    pub languages: Option<Vec<String>>,
}

/// Progress of a project.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Dashboard {
    /// Tasks by state.
    pub by_state: BTreeMap<String, i64>,
    /// What those in the state `submitted` wait for.
    pub submitted: WaitingLabels,
    /// Minutes by which the project's clock, which separates the days, is ahead of UTC.
    pub utc_offset_min: i32,
    /// Submissions and checks by day and person.
    pub throughput: Vec<Throughput>,
    /// Unfinished tasks with the oldest last change, at most 20.
    pub ageing: Vec<Ageing>,
    /// Agreement on overlaps.
    pub agreement: Agreement,
    /// Episodes whose labels are all handed in and of which a lead has chosen none: they are not checked or exported.
    pub to_choose: i64,
    /// Labels by L3 class against the quota; only classes with a quota or a task.
    pub coverage: Vec<Coverage>,
    /// Audit outcome by author.
    pub audit: Vec<AuditRecord>,
    /// Answers of the safety filter.
    pub safety: SafetyCounts,
}

/// The analytics of a project.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct AnalyticsPage {
    /// An HTML fragment in both languages, with its own style and without scripts; `html[lang]` selects the language.
    pub html: String,
}

/// Number of actions of one user on one day.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Throughput {
    /// `2026-11-21`.
    pub day: String,
    /// Display name.
    pub user: String,
    /// `submit`, `accept` or `send_back`.
    pub action: String,
    /// Number of actions.
    pub count: i64,
}

/// Submitted labels by what they wait for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct WaitingLabels {
    /// A check.
    pub check: i64,
    /// The choice of a lead among the labels of an episode: nobody can check them.
    pub choice: i64,
    /// Other labels of their episode, which are not handed in, or not chosen among: nobody can check them.
    pub other_labels: i64,
}

impl WaitingLabels {
    /// Adds `n` labels that wait for `what`.
    pub(crate) fn add(&mut self, what: &str, n: i64) {
        match what {
            "check" => self.check += n,
            "choice" => self.choice += n,
            _ => self.other_labels += n,
        }
    }
}

/// A task without a recent change that somebody can act on.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Ageing {
    /// Task.
    pub task: String,
    /// Class.
    pub scenario_id: String,
    /// State.
    pub state: String,
    /// The labels of its episode are handed in, and a lead has to choose one: the others of them have no row.
    pub to_choose: bool,
    /// Display name of the user who has it; null where a lead has to choose.
    pub user: Option<String>,
    /// Hours since its last change.
    pub hours: f64,
}

/// Agreement on tasks that several people labeled, as first submitted. Kappas are null if there is too little data, or
/// if chance alone would explain all agreement.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct Agreement {
    /// Pairs of labels compared.
    pub pairs: u32,
    /// Cohen's kappa of the longitudinal decision over all pairs.
    pub longitudinal_kappa: Option<f64>,
    /// The same of the lateral decision with its direction.
    pub lateral_kappa: Option<f64>,
    /// Episodes with two or more labels.
    pub groups: u32,
    /// Fleiss' kappa of the longitudinal decision over these episodes.
    pub longitudinal_fleiss: Option<f64>,
    /// The same of the lateral decision with its direction.
    pub lateral_fleiss: Option<f64>,
    /// Median distance of the keyframes of a pair, s.
    pub keyframe_median_s: Option<f64>,
    /// Maximum distance, s.
    pub keyframe_worst_s: Option<f64>,
    /// By pair of people.
    pub by_pair: Vec<PairAgreement>,
}

/// Agreement of two people.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct PairAgreement {
    /// Display names.
    pub users: [String; 2],
    /// Episodes that both labeled.
    pub labels: u32,
    /// Cohen's kappa of the longitudinal decision.
    pub longitudinal_kappa: Option<f64>,
    /// The same of the lateral decision with its direction.
    pub lateral_kappa: Option<f64>,
}

/// An L3 class against its quota.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Coverage {
    /// L3 class.
    pub leaf: String,
    /// Episodes with an accepted label.
    pub have: i64,
    /// Target number.
    pub quota: i64,
    /// Its episodes in this project, without skipped and rejected ones.
    pub mined: i64,
    /// Target number minus these episodes.
    pub shortfall: i64,
}

/// Audits of one author's labels.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct AuditRecord {
    /// Display name.
    pub author: String,
    /// Labels audited.
    pub audited: i64,
    /// Of these, returned.
    pub failed: i64,
    /// Current audit rate of this author's labels, in percent.
    pub share_percent: f64,
}

/// A webhook.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Webhook {
    /// Id.
    pub id: String,
    /// Project id.
    pub project: String,
    /// Display name of the user who added it; absent if it was added before this was recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub owner: Option<String>,
    /// The account of its owner is disabled: nothing is sent until it is enabled, or the webhook removed.
    pub paused: bool,
    /// Target URL.
    pub url: String,
    /// Actions to announce (`submit`, `accept`, ...); empty for all.
    pub events: Vec<String>,
    /// Messages that are not delivered yet.
    pub pending: i64,
    /// Number of failed attempts for the message with the most attempts.
    pub failures: i64,
    /// When a message was last delivered, ms since 1970; absent if none was, 0 if it was before this was recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_delivery: Option<i64>,
    /// When the next message is due, ms since 1970.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_try: Option<i64>,
    /// The last error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_error: Option<Bilingual>,
    /// Key of the signature; shown once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub secret: Option<String>,
}

/// Webhooks.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Webhooks {
    /// By URL.
    pub items: Vec<Webhook>,
}

/// Body of `POST /projects/{p}/webhooks`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewWebhook {
    /// `http://` or `https://` address.
    pub url: String,
    /// Actions to announce; empty for all.
    #[serde(default)]
    pub events: Vec<String>,
}
