//! Answers of a judge to true/false questions about labels (LABELING.md 6): a model's or a person's. Which questions
//! are put to a model, and how, is not known here.

mod people;

pub use people::{PeopleAgreement, QuestionAgreement, agreement_with_people, agreement_with_tasks};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use whyroad_model::Nanos;

/// What a statement is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum QuestionKind {
    /// The decision is what the ego does first.
    Decision,
    /// A component could be observed at or before the keyframe.
    Presence,
    /// A component causes the decision.
    CauseEffect,
    /// Nothing nearer causes it.
    ProximateCause,
    /// The trace says what the components and decisions say.
    Consistency,
    /// The trace rests on nothing that came later.
    Hindsight,
    /// Legal and safe driving.
    Safety,
    /// Something that is not named causes the decision, too.
    Omission,
}

impl QuestionKind {
    /// All, in the order of the report.
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

    /// As messages have it.
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
    /// What it is about.
    pub kind: QuestionKind,
    /// The statement.
    pub text: String,
    /// Track that it is about, where it names one that the label does not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// Answer that a correct label has.
    pub expected: bool,
    /// The judge's; `None` while it is missing.
    pub answer: Option<bool>,
    /// In words.
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
    /// Who answers: the model's name, or `person`.
    pub judge: String,
    /// Whether the label was chosen for people.
    pub for_people: bool,
    /// True when every answer is the one that a correct label has; `None` while answers are missing.
    pub passed: Option<bool>,
    /// In the order in which they were put.
    pub questions: Vec<Question>,
}

impl JudgedLabel {
    /// Sets `passed` from the answers.
    pub fn decide(&mut self) {
        let answers: Option<Vec<bool>> = self.questions.iter().map(Question::passed).collect();
        self.passed = answers.map(|all| all.iter().all(|p| *p));
    }

    /// The same for a person to fill in: without the model's answers, which would not be independent then.
    #[must_use]
    pub fn blank(&self) -> Self {
        let questions = self.questions.iter().map(|q| Question { answer: None, reason: None, ..q.clone() });
        Self { judge: "person".to_owned(), passed: None, questions: questions.collect(), ..self.clone() }
    }
}
