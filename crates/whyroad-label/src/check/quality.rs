//! Quality of causal texts that other tools wrote: the stated action of the ego against its recorded one (motion,
//! route), facts that could not be known (late evidence), a cause that is missing in the text (omission), and
//! statements about objects.
//!
//! Such texts have no decisions of the closed sets (`import`). The text is read with the lexicon of traces, and
//! compared as if it were the label's decision; a phrase that may mean several decisions contradicts the motion only if
//! each of them does.

use super::consistency::trace::{Force, read};
use super::motion::said_speed;
use super::view::View;
use super::{Checker, Recorded};
use crate::counterfactual::{Removed, counterfactual};
use serde::Serialize;
use whyroad_framework::check::{Document, Slot};
use whyroad_framework::lexicon::units::Units;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::label_fields::pointer;
use whyroad_model::messages::{CocLabel, CriticalComponent, DrivingDecision};
use whyroad_model::names::class_name;
use whyroad_model::time::frame_at;
use whyroad_model::{Bilingual, Diagnostic, Location};

/// Kind of a problem in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum QualityKind {
    /// It states an action of the ego that the recording contradicts.
    Motion,
    /// It states another turn or exit than the ego's route.
    Route,
    /// It uses facts that were not known, or not visible, at the keyframe.
    LateEvidence,
    /// It does not name the cause that held the ego.
    Omission,
    /// Its statements about objects or lights contradict the recording.
    Scene,
    /// Its form: empty, too short or long, circular, without a decision.
    Text,
}

impl QualityKind {
    /// All kinds, in the order of the report.
    pub const ALL: [Self; 6] =
        [Self::Motion, Self::Route, Self::LateEvidence, Self::Omission, Self::Scene, Self::Text];

    /// Its id in messages.
    pub fn id(self) -> &'static str {
        match self {
            Self::Motion => "motion",
            Self::Route => "route",
            Self::LateEvidence => "late_evidence",
            Self::Omission => "omission",
            Self::Scene => "scene",
            Self::Text => "text",
        }
    }

    /// Its name for people.
    pub fn name(self) -> Bilingual {
        match self {
            Self::Motion => Bilingual::new("与自车运动矛盾", "contradicts the motion"),
            Self::Route => Bilingual::new("与路线矛盾", "contradicts the route"),
            Self::LateEvidence => Bilingual::new("依据晚于关键帧", "late evidence"),
            Self::Omission => Bilingual::new("遗漏原因", "omits a cause"),
            Self::Scene => Bilingual::new("与场景不符", "wrong about the scene"),
            Self::Text => Bilingual::new("文字问题", "form of the text"),
        }
    }

    /// The kind of a finding; `None` for findings that are not about the text.
    fn of(code: &str, turn: bool) -> Option<Self> {
        let starts = |p: &[&str]| p.iter().any(|p| code.starts_with(p));
        match code {
            "label.motion.contradicts" | "label.motion.side" if turn => Some(Self::Route),
            "label.motion.contradicts" | "label.motion.no_change" | "label.motion.side" => Some(Self::Motion),
            "label.text.hindsight" | "label.evidence.after_keyframe" | "label.object.unseen" => {
                Some(Self::LateEvidence)
            }
            "label.cause.no_effect" => Some(Self::Omission),
            _ if starts(&["label.object."]) => Some(Self::Scene),
            "label.trace.empty"
            | "label.trace.too_short"
            | "label.trace.too_long"
            | "label.cause.circular"
            | "label.text.unrelated"
            | "label.component.too_short" => Some(Self::Text),
            "label.text.placeholder" | "label.trace.decision_id" | "label.trace.numbers" => Some(Self::Text),
            _ => None,
        }
    }
}

/// Findings about one text.
#[derive(Clone, Debug, Default)]
pub struct Quality {
    /// The text states an action of the ego that could be compared.
    pub states_action: bool,
    /// The recording was available.
    pub compared: bool,
    /// By kind.
    pub findings: Vec<(QualityKind, Diagnostic)>,
}

impl Quality {
    fn is(&self, kind: QualityKind) -> bool {
        self.findings.iter().any(|(k, _)| *k == kind)
    }
}

/// A decision that a text may mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Said {
    Along(Longitudinal),
    Across(Lateral, Option<LateralDirection>),
}

impl Checker<'_> {
    /// The quality of the text of one label.
    pub fn quality(&self, label: &CocLabel) -> Quality {
        let recorded = self.recordings.as_ref().and_then(|r| r.of_clip(&label.clip_id));
        let mut out = Quality { compared: recorded.is_some(), ..Quality::default() };
        let bare = self.bare(label);
        for d in self.found(&bare) {
            if let Some(kind) = QualityKind::of(d.code, false) {
                out.findings.push((kind, d));
            }
        }
        for phrase in self.said(label) {
            out.states_action = true;
            out.findings.extend(self.contradiction(&bare, &phrase));
            if let Some(recorded) = &recorded {
                out.findings.extend(against_command(label, recorded, &phrase));
            }
        }
        // Even if the possible decisions do not contradict the motion, the statements about the speed may.
        if let Some(recorded) = recorded.as_ref().filter(|_| !out.is(QualityKind::Motion)) {
            out.findings.extend(self.against_speed(&bare, recorded));
        }
        if let Some(recorded) = &recorded {
            out.findings.extend(self.omission(&bare, recorded));
        }
        out.findings.sort_by(|a, b| (a.0, a.1.code).cmp(&(b.0, b.1.code)));
        // One error in a text is one finding, however many words repeat it.
        out.findings.dedup_by(|a, b| a.0 == b.0 && a.1.code == b.1.code && a.1.message == b.1.message);
        out
    }

    /// The label without decisions; a text without components becomes its own component, so that its statements about
    /// objects are compared.
    fn bare(&self, label: &CocLabel) -> CocLabel {
        let mut bare = label.clone();
        bare.driving_decision =
            DrivingDecision { longitudinal: None, lateral: None, lateral_direction: None };
        bare.causes = None;
        if bare.critical_components.is_empty() {
            bare.critical_components.push(CriticalComponent {
                category: None,
                description: label.coc_trace.clone(),
                uncertainty: None,
                id: Some("c1".to_owned()),
                evidence_times: vec![label.keyframe.timestamp],
                linked_objects: Vec::new(),
            });
        }
        bare
    }

    fn found(&self, label: &CocLabel) -> Vec<Diagnostic> {
        let Ok(text) = serde_json::to_string(label) else { return Vec::new() };
        let mut found = Vec::new();
        let origin = whyroad_framework::check::Origin::start();
        self.check(&Document { origin, bytes: text.as_bytes() }, &mut found);
        found
    }

    /// For each phrase about an action of the ego, the decisions that it may mean.
    fn said(&self, label: &CocLabel) -> Vec<Vec<Said>> {
        let lexicon = self.framework.lexicon();
        let reading = read(&label.coc_trace, &Units::of(&label.coc_trace), lexicon);
        let asserted = reading.mentions.iter().filter(|m| m.force == Force::Asserted && !m.by_other);
        let mut out: Vec<Vec<Said>> = asserted
            .filter(|m| m.start >= reading.decision_from && !lexicon.phrases[m.phrase].supports_only)
            .map(|m| {
                let says = &lexicon.phrases[m.phrase];
                let along = says.longitudinal.iter().map(|d| Said::Along(*d));
                let across = says.lateral.iter().map(|d| Said::Across(*d, m.side));
                along.chain(across).collect()
            })
            .collect();
        // If a label has decisions, as our own labels do, these are used.
        let own = &label.driving_decision;
        out.extend(own.longitudinal.map(|d| vec![Said::Along(d)]));
        out.extend(own.lateral.map(|d| vec![Said::Across(d, own.lateral_direction)]));
        out.dedup();
        out
    }

    /// A finding if every meaning of a phrase contradicts the recording.
    fn contradiction(&self, bare: &CocLabel, phrase: &[Said]) -> Option<(QualityKind, Diagnostic)> {
        let mut first = None;
        for said in phrase {
            let mut label = bare.clone();
            let (at, turn) = match said {
                Said::Along(d) => {
                    label.driving_decision.longitudinal = Some(*d);
                    (pointer::DRIVING_DECISION_LONGITUDINAL, false)
                }
                Said::Across(d, side) => {
                    label.driving_decision.lateral = Some(*d);
                    label.driving_decision.lateral_direction = side.filter(|s| d.directions().contains(s));
                    (pointer::DRIVING_DECISION_LATERAL, *d == Lateral::Turn)
                }
            };
            let against = self.found(&label).into_iter().find_map(|d| {
                let is_here = d.location.pointer.as_deref().is_some_and(|p| p.starts_with(at));
                let kind = QualityKind::of(d.code, turn)
                    .filter(|k| matches!(k, QualityKind::Motion | QualityKind::Route))?;
                is_here.then_some((kind, d))
            });
            first = first.or(Some(against?));
        }
        first
    }

    /// The ego's speed as stated in the text ("accelerates", "comes to a stop") against the recorded one.
    fn against_speed(&self, label: &CocLabel, recorded: &Recorded) -> Option<(QualityKind, Diagnostic)> {
        let lexicon = self.framework.lexicon();
        let text = &label.coc_trace;
        let reading = read(text, &Units::of(text), lexicon);
        let times = &recorded.drive.times;
        let keyframe = frame_at(times, label.keyframe.timestamp).min(times.len().checked_sub(1)?);
        let mut own = reading
            .mentions
            .iter()
            .filter(|m| m.force == Force::Asserted && !m.by_other && m.start >= reading.decision_from);
        let view = View { end: Slot::Is(label.time_range.end_timestamp), ..View::default() };
        let (m, shown) = own.find_map(|m| {
            let said = lexicon.phrases[m.phrase].speed?;
            Some((m, said_speed(said, &view, recorded, keyframe)?))
        })?;
        let phrase = &text[m.start..m.end];
        let message = Bilingual::new(
            format!("文字说“{phrase}”，但记录显示：{}", shown.zh),
            format!("the text says '{phrase}', but the recording shows: {}", shown.en),
        );
        let location = Location { pointer: Some(pointer::COC_TRACE.to_owned()), ..Location::default() };
        Some((QualityKind::Motion, Diagnostic::warning("label.quality.motion", message).at(location)))
    }

    /// The thing whose removal has the largest effect, if no word of the text is of its kind.
    fn omission(&self, label: &CocLabel, recorded: &Recorded) -> Option<(QualityKind, Diagnostic)> {
        let times = &recorded.drive.times;
        let keyframe = frame_at(times, label.keyframe.timestamp).min(times.len().checked_sub(1)?);
        let ranking = counterfactual(&recorded.drive, &recorded.signals, keyframe)?;
        let most = ranking.effects.first().filter(|e| e.is_plain())?;
        let words = self.framework.label_words();
        let kind = |name: &str| words.kinds.get(name).copied().unwrap_or_default();
        let (sought, zh, en) = match &most.removed {
            Removed::Light => {
                (kind("light"), "本车道的信号灯".to_owned(), "the light of the ego's lane".to_owned())
            }
            Removed::Object(id) => {
                if label.critical_components.iter().any(|c| c.linked_objects.iter().any(|o| o == id.as_str()))
                {
                    return None;
                }
                let class = recorded.drive.track(id)?.class;
                let name = class_name(class);
                let sought = if class.is_vru() { kind("vru") } else { kind("vehicle") };
                (sought, format!("{}（{id}）", name.zh), format!("the {} {id}", name.en))
            }
        };
        let text = label.critical_components.iter().map(|c| c.description.as_str());
        let all = text.chain([label.coc_trace.as_str()]);
        if all.map(|t| super::reading::read(t, &Units::of(t), words).groups).any(|g| g.meets(sought)) {
            return None;
        }
        let m = most.distance_m;
        let message = Bilingual::new(
            format!("文字没有提到{zh}，而没有它自车在 8 s 内会多行驶 {m:.0} m"),
            format!("the text does not name {en}, without which the ego would drive {m:.0} m farther in 8 s"),
        );
        let location = Location { pointer: Some(pointer::COC_TRACE.to_owned()), ..Location::default() };
        Some((QualityKind::Omission, Diagnostic::warning("label.quality.omission", message).at(location)))
    }
}

/// A turn in the text against the command of the navigation.
fn against_command(
    label: &CocLabel,
    recorded: &Recorded,
    phrase: &[Said],
) -> Option<(QualityKind, Diagnostic)> {
    let [Said::Across(Lateral::Turn, Some(said))] = phrase else { return None };
    let times = &recorded.drive.times;
    let keyframe = frame_at(times, label.keyframe.timestamp).min(times.len().checked_sub(1)?);
    let command = recorded.signals.frame_columns.get("route.command")?.category(keyframe)?;
    let route = LateralDirection::from_id(command)?;
    if route == *said {
        return None;
    }
    let name = |d: LateralDirection| match d {
        LateralDirection::Left => "左",
        LateralDirection::Right => "右",
        LateralDirection::Uturn => "掉头",
    };
    let message = Bilingual::new(
        format!("文字说“{}转”，而关键帧时的导航指令是“{}转”", name(*said), name(route)),
        format!("the text says that the ego turns {said}, but the route command at the keyframe is {route}"),
    );
    let location = Location { pointer: Some(pointer::COC_TRACE.to_owned()), ..Location::default() };
    Some((QualityKind::Route, Diagnostic::warning("label.quality.route", message).at(location)))
}
