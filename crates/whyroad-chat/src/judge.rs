//! True/false questions about labels, answered by a model (LABELING.md 6): decision, presence of causal factors,
//! validity of the links between cause and effect, and omission, for which the counterfactual ranking names the
//! candidates. Nothing here measures the quality of the model: people check a share of the labels, and agreement with
//! them is computed.

mod questions;

pub use whyroad_label::judged::{
    JudgedLabel, PeopleAgreement, Question, QuestionAgreement, QuestionKind, agreement_with_people,
    agreement_with_tasks,
};

use crate::draft::class_in_words;
use crate::scene::{Images, Scene};
use crate::{AnswerForm, ChatError, Client, Message, Part, Request, Role};
use serde::Deserialize;
use serde_json::json;
use std::collections::BTreeMap;
use whyroad_framework::{Framework, PromptName};
use whyroad_label::check::Recorded;
use whyroad_model::messages::CocLabel;
use whyroad_model::time::frame_at;
use whyroad_model::{Drive, Lang};

/// Codes of this module; each has a page in `docs/diagnostics/`.
pub const JUDGE_CODES: &[&str] = &["judge.label"];

/// Inputs for judging labels.
pub struct Judge<'a> {
    /// The model.
    pub client: &'a Client,
    /// Classes, decisions, prompts.
    pub framework: &'a Framework,
    /// Camera images.
    pub images: &'a dyn Images,
    /// Language of questions and reasons.
    pub lang: Lang,
}

/// Answers by id, as in the model's output.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Answers {
    answers: Vec<Said>,
}

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Said {
    id: String,
    answer: bool,
    reason: String,
}

impl Judge<'_> {
    /// Judges one label. `measured` is the drive as the lake holds it. `Ok(None)` where the drive has no pose of the
    /// ego at the keyframe.
    pub fn judge(
        &self,
        measured: &Drive,
        recorded: &Recorded,
        label: &CocLabel,
        for_people: bool,
    ) -> Result<Option<JudgedLabel>, ChatError> {
        let at = label.keyframe.timestamp;
        let times = &measured.times;
        if !(times.first().is_some_and(|t| *t <= at) && times.last().is_some_and(|t| *t >= at)) {
            return Ok(None);
        }
        let Some(scene) = Scene::before(&measured.until(at), self.images, self.lang) else { return Ok(None) };
        let drive = &recorded.drive;
        let keyframe = frame_at(&drive.times, at).min(drive.times.len().saturating_sub(1));
        let after = Scene::after(drive, &recorded.signals, keyframe, self.images);
        let omitted = questions::omission_candidates(drive, &recorded.signals, keyframe, label, &scene);
        let mut questions = questions::about(self.framework, label, &omitted, self.lang);
        let said = self
            .client
            .ask(&self.request(label, &scene, &after, &questions), |text| read(text, &questions))?;
        for question in &mut questions {
            let answer = said.value.get(&question.id);
            question.answer = answer.map(|a| a.answer);
            question.reason = answer.map(|a| a.reason.clone());
        }
        let s = &label.scenario;
        let mut judged = JudgedLabel {
            clip_id: label.clip_id.clone(),
            keyframe: at,
            scenario: [Some(&s.l1), Some(&s.l2), s.l3.as_ref()]
                .into_iter()
                .flatten()
                .cloned()
                .collect::<Vec<_>>()
                .join("."),
            judge: self.client.model().to_owned(),
            for_people,
            passed: None,
            questions,
        };
        judged.decide();
        Ok(Some(judged))
    }

    fn request(&self, label: &CocLabel, scene: &Scene, after: &Scene, questions: &[Question]) -> Request {
        let prompt = self.framework.prompts.get(PromptName::Judge);
        let components: Vec<_> = label
            .critical_components
            .iter()
            .map(|c| json!({ "id": c.id, "description": c.description, "uncertainty": c.uncertainty }))
            .collect();
        let shown = json!({
            "class": class_in_words(self.framework, label, self.lang),
            "longitudinal": label.driving_decision.longitudinal,
            "lateral": label.driving_decision.lateral,
            "lateral_direction": label.driving_decision.lateral_direction,
            "components": components,
            "trace": label.coc_trace,
        });
        let statements: Vec<_> =
            questions.iter().map(|q| json!({ "id": q.id, "statement": q.text })).collect();
        let values = [
            ("label", &*shown.to_string()),
            ("scene", &*scene.json.to_string()),
            ("motion", &*after.json.to_string()),
            ("questions", &*json!(statements).to_string()),
        ];
        let mut parts = vec![Part::Text(prompt.user(self.lang, &values))];
        // The keyframe's image is the last of the first and the first of the second.
        parts.extend(scene.images.iter().cloned().chain(after.images.iter().skip(1).cloned()));
        let ids: Vec<&str> = questions.iter().map(|q| q.id.as_str()).collect();
        let answer = json!({
            "type": "object", "additionalProperties": false, "required": ["id", "answer", "reason"],
            "properties": {
                "id": { "type": "string", "enum": ids }, "answer": { "type": "boolean" }, "reason": { "type": "string" },
            },
        });
        let schema = json!({
            "type": "object", "additionalProperties": false, "required": ["answers"],
            "properties": { "answers": { "type": "array", "items": answer } },
        });
        Request {
            messages: vec![
                Message::text(Role::System, prompt.system(self.lang, &[])),
                Message { role: Role::User, parts },
            ],
            form: AnswerForm { name: "judge", schema },
        }
    }
}

/// One answer to each question.
fn read(text: &str, questions: &[Question]) -> Result<BTreeMap<String, Said>, String> {
    let answers: Answers = serde_json::from_str(text).map_err(|e| e.to_string())?;
    let mut out = BTreeMap::new();
    for said in answers.answers {
        if !questions.iter().any(|q| q.id == said.id) {
            return Err("it answers a question that was not asked".to_owned());
        }
        if out.insert(said.id.clone(), said).is_some() {
            return Err("it answers a question twice".to_owned());
        }
    }
    match questions.iter().find(|q| !out.contains_key(&q.id)) {
        Some(q) => Err(format!("it does not answer {}", q.id)),
        None => Ok(out),
    }
}

/// Whether a label is checked by people: `share` of all, chosen by seed and label, so that the choice does not depend
/// on what else is judged.
pub fn is_for_people(label: &CocLabel, share: f64, seed: u64) -> bool {
    let mut hash = blake3::Hasher::new();
    hash.update(&seed.to_le_bytes());
    hash.update(label.clip_id.as_bytes());
    hash.update(&label.keyframe.timestamp.0.to_le_bytes());
    let mut first = [0; 8];
    first.copy_from_slice(&hash.finalize().as_bytes()[..8]);
    (u64::from_le_bytes(first) as f64) < share * u64::MAX as f64
}
