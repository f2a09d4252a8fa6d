//! Drafts of labels by a model, in two calls that mirror the stages of LABELING.md 6: critical components from the
//! history alone, then decision, causes and trace with the 6 s after the keyframe. Findings of the label checks are
//! sent back once per call. A draft is not a label: its provenance is the model, and a person checks it.

mod answers;
mod findings;

use crate::scene::{Images, Scene};
use crate::{ChatError, Client, Message, Part, Request, Role};
use answers::{FutureAnswer, HistoryAnswer};
use serde_json::json;
use whyroad_framework::{Framework, PromptName};
use whyroad_label::check::{Checker, Recorded};
use whyroad_model::messages::{
    Causes, CocLabel, CriticalComponent, DrivingDecision, EpisodeRecord, Provenance, ProvenanceSource,
};
use whyroad_model::time::frame_at;
use whyroad_model::{Bilingual, Diagnostic, Drive, Lang, Location, Severity};

/// Codes of this module; each has a page in `docs/diagnostics/`.
pub const DRAFT_CODES: &[&str] = &["draft.drive", "draft.findings", "draft.language", "draft.unsafe"];

/// Inputs for making drafts.
pub struct Drafter<'a> {
    /// The model.
    pub client: &'a Client,
    /// Classes, decisions, prompts.
    pub framework: &'a Framework,
    /// The label checks, with the recordings.
    pub checker: &'a Checker<'a>,
    /// Camera images.
    pub images: &'a dyn Images,
    /// Language of the texts.
    pub lang: Lang,
}

/// A draft, and the remaining findings of the label checks.
#[derive(Clone, Debug)]
pub struct ModelDraft {
    /// In the format of a finished label.
    pub label: CocLabel,
    /// Warnings for the person who checks it.
    pub findings: Vec<Diagnostic>,
}

/// Why an episode has no draft.
#[derive(Clone, Debug)]
pub enum NoDraft {
    /// The model gave no usable answer.
    Chat(ChatError),
    /// The recording or the answer does not permit one.
    Found(Vec<Diagnostic>),
}

impl From<ChatError> for NoDraft {
    fn from(e: ChatError) -> Self {
        Self::Chat(e)
    }
}

impl NoDraft {
    /// For people.
    pub fn diagnostics(self) -> Vec<Diagnostic> {
        match self {
            Self::Chat(e) => vec![e.diagnostic()],
            Self::Found(found) => found,
        }
    }
}

impl Drafter<'_> {
    /// The draft of one episode. `measured` is the drive as the lake holds it: the input of the first call is estimated
    /// from the part up to the keyframe, never from `recorded`, whose motion is based on the whole drive.
    pub fn draft(
        &self,
        measured: &Drive,
        recorded: &Recorded,
        episode: &EpisodeRecord,
    ) -> Result<ModelDraft, NoDraft> {
        let at = episode.keyframe.timestamp;
        let times = &measured.times;
        let inside = times.first().is_some_and(|t| *t <= at) && times.last().is_some_and(|t| *t >= at);
        let scene = inside.then(|| Scene::before(&measured.until(at), self.images, self.lang)).flatten();
        let Some(scene) = scene else { return Err(NoDraft::Found(vec![no_pose(episode)])) };
        let drive = &recorded.drive;
        let mut label =
            whyroad_label::draft::draft(self.framework, drive, &recorded.signals, episode, self.lang).label;
        self.history(&scene, &mut label)?;
        let keyframe = frame_at(&drive.times, at).min(drive.times.len().saturating_sub(1));
        let after = Scene::after(drive, &recorded.signals, keyframe, self.images);
        let findings = self.future(&after, &mut label)?;
        Ok(ModelDraft { label, findings })
    }

    /// First call: components.
    fn history(&self, scene: &Scene, label: &mut CocLabel) -> Result<(), NoDraft> {
        let prompt = self.framework.prompts.get(PromptName::DraftHistory);
        let ids: Vec<&str> = scene.objects.iter().map(|(id, _)| id.as_str()).collect();
        let mut parts = vec![Part::Text(prompt.user(self.lang, &[("scene", &scene.json.to_string())]))];
        parts.extend(scene.images.iter().cloned());
        let request = Request {
            messages: vec![
                Message::text(Role::System, prompt.system(self.lang, &[])),
                Message { role: Role::User, parts },
            ],
            form: answers::history_form(&ids),
        };
        let read = |text: &str| HistoryAnswer::read(text, &ids);
        let put = |answer: HistoryAnswer, label: &mut CocLabel| {
            label.critical_components = components(answer, scene, label);
        };
        let first = self.client.ask(&request, read)?;
        put(first.value, label);
        let found = findings::of_history(self.checker, label, self.lang);
        if found.is_empty() {
            return Ok(());
        }
        let again = request.reply(&first.text, prompt.again(self.lang, &findings::list(&found, self.lang)));
        put(self.client.ask(&again, read)?.value, label);
        let errors = findings::errors(findings::of_history(self.checker, label, self.lang));
        if errors.is_empty() { Ok(()) } else { Err(NoDraft::Found(still_there(label, errors))) }
    }

    /// Second call: decision, causes, trace. Returns the warnings that remain.
    fn future(&self, after: &Scene, label: &mut CocLabel) -> Result<Vec<Diagnostic>, NoDraft> {
        let prompt = self.framework.prompts.get(PromptName::DraftFuture);
        let ids: Vec<String> = label.critical_components.iter().filter_map(|c| c.id.clone()).collect();
        let given: Vec<_> = label
            .critical_components
            .iter()
            .map(|c| json!({ "id": c.id, "description": c.description, "uncertainty": c.uncertainty }))
            .collect();
        let values = [
            ("class", &*class_in_words(self.framework, label, self.lang)),
            ("decisions", &*decisions_in_words(self.framework, self.lang)),
            ("components", &*json!(given).to_string()),
            ("motion", &*after.json.to_string()),
        ];
        let mut parts = vec![Part::Text(prompt.user(self.lang, &values))];
        parts.extend(after.images.iter().cloned());
        let request = Request {
            messages: vec![
                Message::text(Role::System, prompt.system(self.lang, &[])),
                Message { role: Role::User, parts },
            ],
            form: answers::future_form(&ids),
        };
        let read = |text: &str| FutureAnswer::read(text, &ids);
        let first = self.client.ask(&request, read)?;
        self.put(first.value, label)?;
        let mut found = findings::of_future(self.checker, label, self.lang);
        if !found.is_empty() {
            let again =
                request.reply(&first.text, prompt.again(self.lang, &findings::list(&found, self.lang)));
            let second = self.client.ask(&again, read)?;
            self.put(second.value, label)?;
            found = findings::of_future(self.checker, label, self.lang);
        }
        let (errors, warnings): (Vec<_>, Vec<_>) =
            found.into_iter().partition(|d| d.severity == Severity::Error);
        if errors.is_empty() { Ok(warnings) } else { Err(NoDraft::Found(still_there(label, errors))) }
    }

    /// Writes an answer into the label; an error where the model calls the driving unsafe.
    fn put(&self, answer: FutureAnswer, label: &mut CocLabel) -> Result<(), NoDraft> {
        if !answer.safe {
            return Err(NoDraft::Found(vec![unsafe_driving(label, &answer.safety_reason)]));
        }
        label.driving_decision = DrivingDecision {
            longitudinal: answer.longitudinal,
            lateral: answer.lateral,
            lateral_direction: answer.lateral_direction,
        };
        label.causes = Some(Causes {
            longitudinal: answer.longitudinal.and_then(|_| answer.causes.longitudinal.into_cause()),
            lateral: answer.lateral.and_then(|_| answer.causes.lateral.into_cause()),
        });
        label.coc_trace = answer.trace.trim().to_owned();
        let version =
            |name: PromptName| (format!("prompt.{}", name.id()), self.framework.prompts.get(name).version);
        // Those that found the episode: the draft by rule states them.
        let rules = label.provenance.take().and_then(|mut by_rule| by_rule.versions.remove_entry("rules"));
        label.provenance = Some(Provenance {
            source: ProvenanceSource::Model,
            by: Some(self.client.model().to_owned()),
            at: None,
            tool: Some(format!("whyroad {}", env!("CARGO_PKG_VERSION"))),
            versions: [
                ("taxonomy".to_owned(), self.framework.taxonomy.version.clone()),
                version(PromptName::DraftHistory),
                version(PromptName::DraftFuture),
            ]
            .into_iter()
            .chain(rules)
            .collect(),
        });
        Ok(())
    }
}

/// The components of an answer, seen at the keyframe.
fn components(answer: HistoryAnswer, scene: &Scene, label: &CocLabel) -> Vec<CriticalComponent> {
    let track = |id: &String| scene.objects.iter().find(|(alias, _)| alias == id).map(|(_, t)| t.to_string());
    let one = |(i, said): (usize, answers::SaidComponent)| CriticalComponent {
        category: Some(said.category),
        description: said.description.trim().to_owned(),
        uncertainty: Some(said.uncertainty),
        id: Some(format!("c{}", i + 1)),
        evidence_times: vec![label.keyframe.timestamp],
        linked_objects: said.objects.iter().filter_map(track).collect(),
    };
    answer.components.into_iter().enumerate().map(one).collect()
}

/// Name and definition of the class.
pub(crate) fn class_in_words(framework: &Framework, label: &CocLabel, lang: Lang) -> String {
    let s = &label.scenario;
    let id = whyroad_model::ScenarioId { l1: s.l1.clone(), l2: Some(s.l2.clone()), l3: s.l3.clone() };
    let l2 = framework.taxonomy.l2(&s.l1, &s.l2).map(|(_, l2)| (&l2.name, &l2.definition));
    let l3 = framework.taxonomy.leaf(&id).map(|(_, _, l3)| (&l3.name, &l3.definition));
    let words = [l2, l3].into_iter().flatten().map(|(name, what)| {
        let (name, what) = (name.get(lang), what.get(lang));
        if lang == Lang::Zh { format!("{name}（{what}）") } else { format!("{name} ({what})") }
    });
    words.collect::<Vec<_>>().join(" / ")
}

/// One line per decision: id, name, meaning.
fn decisions_in_words(framework: &Framework, lang: Lang) -> String {
    let sets = &framework.decisions;
    let along = sets.longitudinal.iter().map(|d| ("longitudinal", d.id.id(), &d.text));
    let across = sets.lateral.iter().map(|d| ("lateral", d.id.id(), &d.text));
    let lines = along.chain(across).map(|(channel, id, text)| {
        format!("{channel} {id}: {}: {}", text.name.get(lang), text.meaning.get(lang))
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Where in the label's clip a finding is.
fn of_label(label: &CocLabel) -> Location {
    Location {
        file: Some(format!("{} @ {}", label.clip_id, label.keyframe.timestamp)),
        ..Location::default()
    }
}

fn no_pose(episode: &EpisodeRecord) -> Diagnostic {
    let id = &episode.episode_id;
    let message = Bilingual::new(
        format!("事件 {id}：行程中没有关键帧时刻的自车位姿"),
        format!("episode {id}: the drive has no pose of the ego at the keyframe"),
    );
    Diagnostic::error("draft.drive", message)
}

fn unsafe_driving(label: &CocLabel, why: &str) -> Diagnostic {
    let why: String = why.chars().take(200).collect();
    let message = Bilingual::new(
        format!("模型认为自车的驾驶不合法或不安全，不作为样本：{why}"),
        format!("the model calls the ego's driving illegal or unsafe, so it is not a sample: {why}"),
    );
    Diagnostic::error("draft.unsafe", message).at(of_label(label))
}

/// Errors that the second answer still has.
fn still_there(label: &CocLabel, errors: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let codes: Vec<&str> = errors.iter().map(|d| d.code).collect();
    let codes = codes.join(", ");
    let message = Bilingual::new(
        format!("重新询问后仍有错误，草稿未写出：{codes}"),
        format!("the second answer still has errors, so no draft is written: {codes}"),
    );
    let place = of_label(label);
    let file = place.file.clone().unwrap_or_default();
    let mut out = vec![Diagnostic::error("draft.findings", message).at(place)];
    out.extend(errors.into_iter().map(|d| d.in_file(file.clone())));
    out
}
