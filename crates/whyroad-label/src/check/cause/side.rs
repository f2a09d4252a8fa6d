//! A maneuver to a side that no component mentions: a lane change or a turn in addition to a response to a road user or
//! the road has a cause of its own (a free lane, a gap or the route), which is on the side to which the ego goes.

use crate::check::texts::TextScope;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::label_words::GroupSet;
use whyroad_framework::{Framework, LabelWords};
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::label_fields::pointer;
use whyroad_model::messages::DrivingDecision;

/// The side to which the ego goes, as texts name it.
#[derive(Clone, Copy)]
pub(crate) struct Side {
    zh: &'static str,
    en: &'static str,
}

impl Side {
    /// The side of a direction; none of a U-turn.
    pub(crate) fn of(direction: LateralDirection) -> Option<Self> {
        match direction {
            LateralDirection::Left => Some(Self { zh: "左", en: "left" }),
            LateralDirection::Right => Some(Self { zh: "右", en: "right" }),
            LateralDirection::Uturn => None,
        }
    }

    /// The text names the side, or a lane.
    pub(crate) fn is_named(self, text: &str, words: &LabelWords) -> bool {
        let lower = text.to_ascii_lowercase();
        lower.contains(self.zh)
            || lower.split(|c: char| !c.is_ascii_alphabetic()).any(|w| w == self.en)
            || words.subjects.lanes.iter().any(|w| lower.contains(w.as_str()))
    }
}

/// The side that a component has to mention: that of a lane change or a turn, if there is another decision besides it.
/// `about` is what the class is about.
pub(crate) fn to_mention(decision: &DrivingDecision, about: GroupSet, words: &LabelWords) -> Option<Side> {
    let lateral = decision.lateral.filter(|l| matches!(l, Lateral::LaneChange | Lateral::Turn))?;
    // Passing somebody or matching a gap implies a lane change.
    let by_itself = [Longitudinal::AccelerationForPassing, Longitudinal::GapMatching];
    if decision.longitudinal.is_none_or(|d| by_itself.contains(&d)) || words.is_empty() {
        return None;
    }
    // Onto a roundabout and off it there is one side only.
    let facility = words.kinds.get("facility").copied().unwrap_or_default();
    if lateral == Lateral::Turn && about.meets(facility) {
        return None;
    }
    Side::of(decision.lateral_direction?)
}

/// Some component mentions the side of the lane change or turn, if there is another decision besides it. Not asked of a
/// document of 2.0, which cannot say that the cause was not observed.
pub(in crate::check) fn of_maneuver(scope: &TextScope<'_>, framework: &Framework, sink: &mut dyn Sink) {
    let TextScope { label, words, .. } = *scope;
    let Some(lateral) = label.lateral.get() else { return };
    if label.states_2_0() && matches!(label.causes, Slot::Absent) {
        return;
    }
    let decision = DrivingDecision {
        longitudinal: label.longitudinal.get(),
        lateral: Some(lateral),
        lateral_direction: label.direction.get(),
    };
    let Some(side) = to_mention(&decision, scope.about, words) else { return };
    let names_it = |text: &str| side.is_named(text, words);
    // A route to that side is a cause that was not observed (LABELING.md 6).
    if let Slot::Is(causes) = &label.causes
        && let Slot::Is(cause) = &causes.lateral
        && cause.unobserved.get().is_some_and(|t| names_it(t) || words.gives_reason(t))
    {
        return;
    }
    let mut parts = label.parts.iter().map(|c| c.description.get());
    if label.parts.is_empty() || parts.any(|t| t.is_none_or(names_it)) {
        return;
    }
    sink.report(Finding::warning("label.cause.kind", pointer::CAUSES_LATERAL), &|| {
        let name = framework.decisions.name(lateral.id());
        Words::new(
            format!("没有关键要素说明为什么向{}{}", side.zh, name.zh),
            format!("no component states the reason for '{}' to the {}", name.en, side.en),
        )
        .hint(
            "补上那一侧的要素（空当、车道），或写原因未观测到（路线），或把横向决策改为“无决策变化”",
            "add what is on that side (a gap, a lane), say that the cause was not observed (the route), or remove the \
             lateral decision",
        )
    });
}
