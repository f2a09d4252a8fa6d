//! The statements about one label. A correct label makes each of them true, except those of omission, which it makes
//! false.

use crate::scene::Scene;
use whyroad_framework::Framework;
use whyroad_label::counterfactual::{Removed, counterfactual};
use whyroad_label::judged::{Question, QuestionKind};
use whyroad_model::messages::{Cause, CocLabel};
use whyroad_model::names::class_name;
use whyroad_model::{Bilingual, ComponentCategory, Drive, Lang, SignalTable};

/// Maximum number of unnamed objects in questions, largest effect first.
const MOST_OMISSIONS: usize = 3;

/// Something that no component names: its description and track.
pub(super) struct Omitted {
    words: Bilingual,
    track: Option<String>,
}

/// The statements about a label; `omitted` are candidates.
pub(super) fn about(
    framework: &Framework,
    label: &CocLabel,
    omitted: &[Omitted],
    lang: Lang,
) -> Vec<Question> {
    let mut all: Vec<(QuestionKind, Bilingual)> = Vec::new();
    let decision = &label.driving_decision;
    let sets = &framework.decisions;
    let along = decision.longitudinal.and_then(|d| sets.longitudinal(d));
    let across = decision.lateral.and_then(|d| sets.lateral(d));
    all.push((
        QuestionKind::Decision,
        match along {
            Some(d) => Bilingual::new(
                format!("关键帧之后自车的第一个纵向决策是“{}”（{}）。", d.name.zh, d.meaning.zh),
                format!(
                    "The ego's first longitudinal decision after the keyframe is '{}' ({}).",
                    d.name.en, d.meaning.en
                ),
            ),
            None => Bilingual::new(
                "关键帧之后自车的纵向行驶没有新的决策，延续原来的状态。",
                "After the keyframe the ego makes no new longitudinal decision and continues as before.",
            ),
        },
    ));
    let side = decision.lateral_direction.map(|s| match s.id() {
        "left" => Bilingual::new("，方向为左", ", to the left"),
        "right" => Bilingual::new("，方向为右", ", to the right"),
        other => Bilingual::new(format!("，方向为 {other}"), format!(", direction {other}")),
    });
    let side = side.unwrap_or_default();
    all.push((
        QuestionKind::Decision,
        match across {
            Some(d) => Bilingual::new(
                format!("关键帧之后自车的第一个横向决策是“{}”（{}）{}。", d.name.zh, d.meaning.zh, side.zh),
                format!(
                    "The ego's first lateral decision after the keyframe is '{}' ({}){}.",
                    d.name.en, d.meaning.en, side.en
                ),
            ),
            None => Bilingual::new(
                "关键帧之后自车没有新的横向决策，延续原来的横向状态。",
                "After the keyframe the ego makes no new lateral decision and continues as before.",
            ),
        },
    ));
    for c in &label.critical_components {
        let words = bare(&c.description);
        all.push((
            QuestionKind::Presence,
            Bilingual::new(
                format!("在关键帧或之前可以观察到：“{words}”。"),
                format!("At or before the keyframe it can be observed that: '{words}'."),
            ),
        ));
    }
    let causes = label.causes.clone().unwrap_or_default();
    let links = [(along.map(|d| &d.name), causes.longitudinal), (across.map(|d| &d.name), causes.lateral)];
    for (name, cause) in links {
        let (Some(name), Some(cause)) = (name, cause) else { continue };
        for words in named(label, &cause) {
            all.push((
                QuestionKind::CauseEffect,
                Bilingual::new(
                    format!("“{words}”是自车决策“{}”的原因。", name.zh),
                    format!("'{words}' is a cause of the ego's decision '{}'.", name.en),
                ),
            ));
        }
    }
    all.push((QuestionKind::ProximateCause, Bilingual::new(
        "标注中的原因是最近的原因：没有更近的目标或规则本身就足以要求这个决策。",
        "The causes in the label are the nearest ones: nothing nearer would by itself call for the decision.",
    )));
    all.push((
        QuestionKind::Consistency,
        Bilingual::new(
            "因果描述与标注的要素、决策一致，没有互相矛盾或多出来的动作和目标。",
            "The trace agrees with the components and decisions of the label and adds no action or object.",
        ),
    ));
    all.push((
        QuestionKind::Hindsight,
        Bilingual::new(
            "因果描述没有使用关键帧之后才知道的情况作为理由。",
            "The trace gives no reason that was only known after the keyframe.",
        ),
    ));
    all.push((
        QuestionKind::Safety,
        Bilingual::new(
            "自车在关键帧之后的驾驶合法且安全。",
            "The ego drives legally and safely after the keyframe.",
        ),
    ));
    for Omitted { words: what, .. } in omitted {
        all.push((
            QuestionKind::Omission,
            Bilingual::new(
                format!("标注没有提到的{}也是这个决策的原因。", what.zh),
                format!(
                    "{}, which the label does not name, is a cause of the decision, too.",
                    capital(&what.en)
                ),
            ),
        ));
    }
    let first_omitted = all.len() - omitted.len();
    let track = |i: usize| omitted.get(i.checked_sub(first_omitted)?)?.track.clone();
    let question = |(i, (kind, text)): (usize, (QuestionKind, Bilingual))| Question {
        object: track(i),
        id: format!("q{}", i + 1),
        kind,
        text: text.get(lang).to_owned(),
        expected: kind != QuestionKind::Omission,
        answer: None,
        reason: None,
    };
    all.into_iter().enumerate().map(question).collect()
}

/// Descriptions of the components of a cause.
fn named<'l>(label: &'l CocLabel, cause: &Cause) -> Vec<&'l str> {
    let of = |id: &String| {
        let c = label.critical_components.iter().find(|c| c.id.as_ref() == Some(id))?;
        Some(bare(&c.description))
    };
    cause.components.iter().filter_map(of).collect()
}

fn bare(text: &str) -> &str {
    text.trim().trim_end_matches(['。', '.'])
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |c| c.to_uppercase().chain(chars).collect())
}

/// Things that no component names and whose removal would clearly change the drive.
pub(super) fn omission_candidates(
    drive: &Drive,
    signals: &SignalTable,
    keyframe: usize,
    label: &CocLabel,
    scene: &Scene,
) -> Vec<Omitted> {
    let Some(ranking) = counterfactual(drive, signals, keyframe) else { return Vec::new() };
    let linked =
        |id: &str| label.critical_components.iter().any(|c| c.linked_objects.iter().any(|o| o == id));
    let names_light = label.critical_components.iter().any(|c| {
        c.category.as_deref() == Some(ComponentCategory::TrafficLights.id())
            || c.description.contains('灯')
            || c.description.to_lowercase().contains("light")
    });
    let plain = ranking.effects.iter().filter(|e| e.is_plain());
    plain
        .filter_map(|effect| match &effect.removed {
            Removed::Light => (!names_light)
                .then(|| Omitted { words: Bilingual::new("信号灯", "the traffic light"), track: None }),
            Removed::Object(id) if linked(id.as_str()) => None,
            Removed::Object(id) => {
                // Named as in the scene record; things that the record does not list cannot be in a question.
                let (alias, track) = scene.objects.iter().find(|(_, track)| track == id)?;
                let class = class_name(drive.track(id)?.class);
                let words = Bilingual::new(
                    format!("目标 {alias}（{}）", class.zh),
                    format!("object {alias} ({})", class.en),
                );
                Some(Omitted { words, track: Some(track.to_string()) })
            }
        })
        .take(MOST_OMISSIONS)
        .collect()
}
