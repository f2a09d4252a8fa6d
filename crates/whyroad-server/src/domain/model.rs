//! Work of a language model in a project: runs of drafts and judgments, their cost, and the agreement of the judge with
//! people.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use whyroad_label::judged::Question;
use whyroad_model::{Bilingual, ModelSpent};

/// What a run does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ModelRunKind {
    /// Drafts of tasks that nobody has started.
    Draft,
    /// Judgments of submitted labels.
    Judge,
}

impl ModelRunKind {
    /// Its value in the store.
    pub fn word(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Judge => "judge",
        }
    }

    /// The kind with this value.
    pub fn from_word(word: &str) -> Option<Self> {
        [Self::Draft, Self::Judge].into_iter().find(|k| k.word() == word)
    }
}

/// State of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ModelRunState {
    /// It waits for earlier runs.
    Waiting,
    /// It is in progress, also while the service is restarted.
    Running,
    /// Every task was tried.
    Done,
    /// A user stopped it.
    Stopped,
    /// It could not continue; `note` gives the reason.
    Failed,
}

impl ModelRunState {
    const ALL: [Self; 5] = [Self::Waiting, Self::Running, Self::Done, Self::Stopped, Self::Failed];

    /// Its value in the store.
    pub fn word(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Running => "running",
            Self::Done => "done",
            Self::Stopped => "stopped",
            Self::Failed => "failed",
        }
    }

    /// The state with this value.
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.word() == word)
    }
}

/// A run.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ModelRun {
    /// Id.
    pub id: String,
    /// What it does.
    pub kind: ModelRunKind,
    /// Its state.
    pub state: ModelRunState,
    /// Name of the model.
    pub model: String,
    /// Display name of the user who started it.
    pub by: String,
    /// When it was started.
    pub started: i64,
    /// When it ended.
    pub ended: Option<i64>,
    /// Tasks in it.
    pub total: i64,
    /// Tasks with a draft or a judgment.
    pub done: i64,
    /// Tasks for which the model returned nothing usable.
    pub failed: i64,
    /// Tasks that were left out: somebody had started them, or had changed the label.
    pub left_out: i64,
    /// Its cost so far.
    pub spent: ModelSpent,
    /// Why it ended early.
    pub note: Option<Bilingual>,
    /// Tasks that failed, with the reason: the first twenty.
    pub failures: Vec<ModelRunFailure>,
}

/// A task for which the model returned nothing usable.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ModelRunFailure {
    /// Its id.
    pub task: String,
    /// Its class, as far as it may be shown now.
    pub scenario_id: String,
    /// Why.
    pub text: Bilingual,
}

/// The model and its work in a project.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ModelWork {
    /// Name of the model; null where the service was started without one.
    pub model: Option<String>,
    /// Tasks that nobody has started and no model has drafted. During a run of drafts: its tasks that were not tried
    /// yet; during a run of judgments: a count that is at most 10 s old.
    pub to_draft: i64,
    /// Submitted labels that no model has judged in their current form; during a run as for `to_draft`.
    pub to_judge: i64,
    /// Runs, newest first, at most ten.
    pub runs: Vec<ModelRun>,
}

/// Body of `POST /projects/{p}/model-runs`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewModelRun {
    /// What it does.
    pub kind: ModelRunKind,
    /// Only these tasks (ids, at most 500), including those that a model has drafted or judged before; default: all
    /// that wait.
    #[serde(default)]
    pub tasks: Option<Vec<String>>,
}

/// Body of `POST /projects/{p}/model-runs:stop`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StopModelRun {
    /// Id of the run.
    pub run: String,
}

/// Judgment of a task's label by a model, as far as a checker may see it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Judgement {
    /// Name of the model.
    pub model: String,
    /// When.
    pub at: i64,
    /// The label was changed after the judgment.
    pub outdated: bool,
    /// The label was drawn for people, who answer the same questions.
    pub for_people: bool,
    /// The caller may answer now. Before that the questions have no answers of the model.
    pub asks: bool,
    /// The model's answers are withheld from users who may still have to answer.
    pub withheld: bool,
    /// The questions with the model's answers.
    pub questions: Vec<Question>,
    /// The caller's own answers, by question.
    pub own: BTreeMap<String, bool>,
}

/// Body of `POST /tasks/{t}/judgement`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JudgementAnswers {
    /// Fencing token of the lease.
    pub fence: i64,
    /// Answers by question; a question that is left out stays open.
    pub answers: BTreeMap<String, bool>,
}

/// The judge's results for a project's labels, and its agreement with people.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct JudgeReport {
    /// Labels that were judged.
    pub judged: i64,
    /// Of these, without an error.
    pub passed: i64,
    /// Of these, drawn for people.
    pub for_people: i64,
    /// Of these, answered by people.
    pub answered: i64,
    /// Agreement by kind of question, then `all`; empty without answers of people.
    pub kinds: Vec<JudgeAgreement>,
}

/// Agreement of the judge with people on the questions of one kind.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct JudgeAgreement {
    /// `decision`, `presence`, ..., `all`.
    pub kind: String,
    /// Pairs of answers.
    pub answers: i64,
    /// Share of equal answers, 0 to 1.
    pub same: Option<f64>,
    /// Its 95 % interval.
    pub same_interval: Option<[f64; 2]>,
    /// Cohen's kappa; null where chance alone would explain all agreement.
    pub kappa: Option<f64>,
    /// Only the judge finds an error.
    pub only_judge: i64,
    /// Only people find an error.
    pub only_people: i64,
}
