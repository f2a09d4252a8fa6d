//! Answers of a judge (a model or a person) to true/false questions about labels (LABELING.md 6). Which questions are
//! sent to a model, and how, is not defined here.

mod people;

pub use people::{PeopleAgreement, QuestionAgreement, agreement_with_people, agreement_with_tasks};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use whyroad_model::Nanos;

/// Subject of a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum QuestionKind {
    /// The decision is the first action of the ego.
    Decision,
    /// A component could be observed at or before the keyframe.
    Presence,
    /// A component causes the decision.
    CauseEffect,
    /// There is no nearer cause.
    ProximateCause,
    /// The trace agrees with the components and decisions.
    Consistency,
    /// The trace uses nothing that happened later.
    Hindsight,
    /// The driving is legal and safe.
    Safety,
    /// Something that is not named also causes the decision.
    Omission,
}

impl QuestionKind {
    /// All kinds, in the order of the report.
    pub const ALL: [Self; 8] = [
        Self::Decision,
        Self::Presence,
        Self::CauseEffect,
        Self::ProximateCause,
        Self::Consistency,
        Self::Hindsight,
        Self::Safety,
        Self::Omission,
    ];

    /// Its id in messages.
    pub fn id(self) -> &'static str {
        match self {
            Self::Decision => "decision",
            Self::Presence => "presence",
            Self::CauseEffect => "cause_effect",
            Self::ProximateCause => "proximate_cause",
            Self::Consistency => "consistency",
            Self::Hindsight => "hindsight",
            Self::Safety => "safety",
            Self::Omission => "omission",
        }
    }
}

/// One statement with its answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Question {
    /// Unique within the label: `q1`, `q2`, ...
    pub id: String,
    /// Its subject.
    pub kind: QuestionKind,
    /// The statement.
    pub text: String,
    /// Track that the statement is about, if it is a track that the label does not name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// Answer for a correct label.
    pub expected: bool,
    /// The judge's answer; `None` while it is missing.
    pub answer: Option<bool>,
    /// The judge's explanation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl Question {
    /// Whether the answer is the expected one.
    pub fn passed(&self) -> Option<bool> {
        self.answer.map(|a| a == self.expected)
    }
}

/// A label with the answers of one judge: a model or a person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JudgedLabel {
    /// Clip.
    pub clip_id: String,
    /// Keyframe of the label.
    pub keyframe: Nanos,
    /// Class.
    pub scenario: String,
    /// The judge: the model's name, or `person`.
    pub judge: String,
    /// Whether the label was selected for people.
    pub for_people: bool,
    /// True when every answer is the expected one; `None` while answers are missing.
    pub passed: Option<bool>,
    /// In the order in which they were asked.
    pub questions: Vec<Question>,
}

impl JudgedLabel {
    /// Sets `passed` from the answers.
    pub fn decide(&mut self) {
        let answers: Option<Vec<bool>> = self.questions.iter().map(Question::passed).collect();
        self.passed = answers.map(|all| all.iter().all(|p| *p));
    }

    /// A copy for a person to fill in: without the model's answers, so that the person's answers are independent.
    #[must_use]
    pub fn blank(&self) -> Self {
        let questions = self.questions.iter().map(|q| Question { answer: None, reason: None, ..q.clone() });
        Self { judge: "person".to_owned(), passed: None, questions: questions.collect(), ..self.clone() }
    }
}
