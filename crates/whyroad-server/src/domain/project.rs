//! Projects, members, dashboard, webhooks.

use super::people::User;
use super::safety::SafetyCounts;
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
    /// Labels wanted, by leaf.
    pub quota: BTreeMap<String, u32>,
    /// How it runs.
    pub settings: Settings,
    /// The caller's roles in it.
    pub roles: Vec<Role>,
}

/// How a project runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Length of a lease, s.
    pub lease_s: u32,
    /// Minimum audit rate of checked labels, in percent.
    pub audit_min_percent: u32,
    /// Maximum audit rate, for an author with a poor record, in percent.
    pub audit_max_percent: u32,
    /// Language of drafts: `zh` or `en`.
    pub lang: String,
    /// What bars somebody from the Stage I of a task.
    pub history: HistoryRule,
    /// How exactly Stage I names the class of a task.
    pub stage1_class: Stage1Class,
    /// Precision of places, m: scenes are given relative to the corner of a square of this size, and not where that is.
    /// 0 for positions as recorded.
    pub place_precision_m: u32,
    /// Gold labels that an annotator hands in before being judged; 0 where no qualification is asked for.
    pub gold_labels: u32,
    /// Mean agreement with gold answers that qualifies, in percent. Who is not qualified is audited at the maximum
    /// rate.
    pub gold_percent: u32,
    /// Days after which finished tasks are removed with their labels; 0 to keep them.
    pub retention_days: u32,
    /// Cost of an hour of work, for the cost per accepted label; null is unknown.
    pub hourly_rate: Option<f64>,
    /// Currency of the rate, as it is to be shown.
    pub currency: String,
}

/// What somebody may have seen of a drive and still do the Stage I of a task of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum HistoryRule {
    /// Nothing after the task's keyframe, in whichever task.
    #[default]
    Drive,
    /// Nothing after the keyframe in a task of the same episode. For small teams and short drives, where the same few
    /// people see all of a drive sooner or later.
    Episode,
}

/// How exactly Stage I names the class of a task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Stage1Class {
    /// By its leaf.
    #[default]
    Leaf,
    /// By its L2, where a leaf of that L2 has a name that reveals the outcome. What depends on the leaf (specification,
    /// signals, target, range, drafted components) is then withheld until Stage I is locked.
    L2,
}

impl Default for Settings {
    /// LABELING.md 6: audit of 10 to 20 %. Leases of five minutes, renewed by a heartbeat.
    fn default() -> Self {
        Self {
            lease_s: 300,
            audit_min_percent: 10,
            audit_max_percent: 20,
            lang: "zh".to_owned(),
            history: HistoryRule::Drive,
            stage1_class: Stage1Class::Leaf,
            place_precision_m: 0,
            gold_labels: 0,
            gold_percent: 80,
            retention_days: 0,
            hourly_rate: None,
            currency: "CNY".to_owned(),
        }
    }
}

/// What there is to do in a project.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Work {
    /// Tasks by state; empty for those who are not staff.
    pub by_state: BTreeMap<String, i64>,
    /// All tasks; 0 for those who are not staff.
    pub total: i64,
    /// Tasks with an open question to the lead; 0 for those who are not staff.
    pub asked: i64,
    /// Tasks of overlap groups that are still to be adjudicated; 0 for those who do not lead.
    pub disagreeing: i64,
    /// Tasks whose drafts are still being made in the background; 0 for those who are not staff.
    pub pending: i64,
    /// The caller's own.
    pub mine: MyWork,
}

/// The tasks of one annotator in a project.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MyWork {
    /// Sent back, to be changed.
    pub returned: i64,
    /// Begun and not submitted.
    pub begun: i64,
    /// Assigned and not begun.
    pub assigned: i64,
    /// Submitted, not accepted yet.
    pub waiting: i64,
    /// Accepted.
    pub accepted: i64,
    /// Submissions of today (UTC).
    pub submitted_today: i64,
}

/// Many projects.
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
    /// Labels wanted, by leaf.
    #[serde(default)]
    pub quota: BTreeMap<String, u32>,
    /// How it runs.
    #[serde(default)]
    pub settings: Settings,
}

/// Body of `PATCH /projects/{p}`: what is given is changed.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProjectChange {
    /// Name.
    #[serde(default)]
    pub name: Option<String>,
    /// Label guide.
    #[serde(default)]
    pub guide: Option<String>,
    /// Labels wanted, by leaf.
    #[serde(default)]
    pub quota: Option<BTreeMap<String, u32>>,
    /// How it runs.
    #[serde(default)]
    pub settings: Option<Settings>,
}

/// A member of a project.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Member {
    /// Who.
    pub user: User,
    /// May do what.
    pub roles: Vec<Role>,
    /// Classes (full ids or prefixes of them) that the queue gives this member; empty for all.
    pub skills: Vec<String>,
    /// Languages of the tasks that the queue gives this member, `zh`, `en`; empty for that of their page.
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
    /// May do what.
    pub roles: Vec<Role>,
    /// Classes that the queue gives this member; empty for all.
    #[serde(default)]
    pub skills: Vec<String>,
    /// Languages of the tasks that the queue gives this member, empty for that of their page; as they are when not
    /// given.
    #[serde(default)]
    pub languages: Option<Vec<String>>,
}

/// How a project goes.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Dashboard {
    /// Tasks by state.
    pub by_state: BTreeMap<String, i64>,
    /// Submissions and checks by day (UTC) and person.
    pub throughput: Vec<Throughput>,
    /// Unfinished tasks that have not moved for longest, at most 20.
    pub ageing: Vec<Ageing>,
    /// How far people agree on overlaps.
    pub agreement: Agreement,
    /// Labels by leaf against the quota; leaves that are wanted or have a task.
    pub coverage: Vec<Coverage>,
    /// Audit outcome by author.
    pub audit: Vec<AuditRecord>,
    /// Answers of the safety filter.
    pub safety: SafetyCounts,
}

/// The analytics of a project.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct AnalyticsPage {
    /// A piece of a page in both languages, with its own style and without script; `html[lang]` decides what is seen.
    pub html: String,
}

/// What somebody did on a day.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Throughput {
    /// `2026-11-21`.
    pub day: String,
    /// Display name.
    pub user: String,
    /// `submit`, `accept` or `send_back`.
    pub action: String,
    /// How many.
    pub count: i64,
}

/// A task that has not moved for long.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Ageing {
    /// Task.
    pub task: String,
    /// Class.
    pub scenario_id: String,
    /// State.
    pub state: String,
    /// Whose it is.
    pub user: Option<String>,
    /// Hours since it last moved.
    pub hours: f64,
}

/// Agreement on tasks that several people labeled, as first submitted. Kappas are null where there is too little to
/// compare, or where chance alone would explain all agreement.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct Agreement {
    /// Pairs of labels compared.
    pub pairs: u32,
    /// Cohen's kappa of the longitudinal decision over all pairs.
    pub longitudinal_kappa: Option<f64>,
    /// The same of the lateral decision with its direction.
    pub lateral_kappa: Option<f64>,
    /// Episodes with two labels or more.
    pub groups: u32,
    /// Fleiss' kappa of the longitudinal decision over these episodes.
    pub longitudinal_fleiss: Option<f64>,
    /// The same of the lateral decision with its direction.
    pub lateral_fleiss: Option<f64>,
    /// Median distance of the keyframes of a pair, s.
    pub keyframe_median_s: Option<f64>,
    /// Greatest distance, s.
    pub keyframe_worst_s: Option<f64>,
    /// By two people.
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

/// A leaf against its quota.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Coverage {
    /// Leaf.
    pub leaf: String,
    /// Episodes with an accepted label.
    pub have: i64,
    /// Wanted.
    pub quota: i64,
    /// Episodes of it in this project, whatever their state: what mining gave.
    pub mined: i64,
    /// Wanted and not even mined.
    pub shortfall: i64,
}

/// Audits of one author's labels.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct AuditRecord {
    /// Display name.
    pub author: String,
    /// Labels audited.
    pub audited: i64,
    /// Of these sent back.
    pub failed: i64,
    /// Share of this author's labels that is audited now, in percent.
    pub share_percent: f64,
}

/// A webhook.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Webhook {
    /// Id.
    pub id: String,
    /// Where to.
    pub url: String,
    /// Actions to announce (`submit`, `accept`, ...); empty for all.
    pub events: Vec<String>,
    /// Messages that were not delivered yet.
    pub pending: i64,
    /// How often the message that was tried most was not taken.
    pub failures: i64,
    /// When a message was last delivered, ms since 1970; absent when none was, 0 when this was not kept yet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_delivery: Option<i64>,
    /// When the next message is due, ms since 1970.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_try: Option<i64>,
    /// What went wrong last.
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
