//! Whether another road user, or the light, explains why the ego slows, and the subject of the class does not: the ego
//! would not slow for the subject alone, and slows less without the other ([`crate::counterfactual`]). Causes that the
//! model does not have, such as a bend or a limit, are not estimated.

use super::doubt::Doubt;
use super::motion::LongitudinalMotion;
use crate::counterfactual::{Effect, Removed, alone, counterfactual};
use crate::driven::Driven;
use crate::driven::along::{Course, Trend};
use crate::driven::other::{Moves, Other};
use whyroad_model::messages::DrivingDecision;
use whyroad_model::{ScenarioId, TrackId};

/// What the ego does, and what its draft says of the cause.
pub(super) struct Said<'a> {
    pub class: &'a ScenarioId,
    pub decision: &'a DrivingDecision,
    pub motion: LongitudinalMotion,
    pub course: Option<&'a Course>,
    /// The subject of the class.
    pub subject: Option<&'a TrackId>,
    /// The lead, where the text says that it is the cause.
    pub lead: Option<&'a TrackId>,
}

impl Said<'_> {
    /// The ego decides to slow down.
    fn decides_to_slow(&self) -> bool {
        self.decision.longitudinal.is_some()
            && matches!(self.motion, LongitudinalMotion::Slows | LongitudinalMotion::Stops)
    }

    /// It only goes on slowing.
    fn goes_on_slowing(&self) -> bool {
        let undecided = self.decision.longitudinal.is_none() && self.decision.lateral.is_none();
        undecided && self.course.is_some_and(|c| c.trend == Trend::Falls)
    }

    /// Road users that the draft names.
    fn named(&self) -> impl Iterator<Item = Removed> {
        self.subject.into_iter().chain(self.lead).cloned().map(Removed::Object)
    }
}

/// Something that the draft does not name explains why the ego slows, and what it names does not.
pub(super) fn doubt(said: &Said<'_>, w: &Driven<'_>) -> Option<Doubt> {
    let of_others = said.class.l1 == "reactive_agent" && said.subject.is_some();
    let of_road = matches!(said.class.l1.as_str(), "reactive_road" | "proactive") && said.subject.is_none();
    if !((of_others && said.goes_on_slowing()) || ((of_others || of_road) && said.decides_to_slow())) {
        return None;
    }
    // Alone, each of two who cross may hold the ego: the class is about either of them.
    let holds = |thing| alone(w.drive, w.signals, w.keyframe, &thing).is_some_and(|e| !e.is_none());
    if said.named().any(holds) {
        return None;
    }
    let scene = counterfactual(w.drive, w.signals, w.keyframe)?;
    let strongest = scene.effects.iter().find(|e| e.is_plain())?;
    match &strongest.removed {
        Removed::Light => of_others.then_some(Doubt::RedLight),
        Removed::Object(id) => (of_others || is_in_the_way(strongest, id, w)).then_some(Doubt::OtherCause),
    }
}

/// A road user who crosses, or who is no vehicle, makes the ego slow much: a lead is a cause of its own
/// ([`super::lead`]).
fn is_in_the_way(effect: &Effect, id: &TrackId, w: &Driven<'_>) -> bool {
    let is_vru = w.drive.track(id).is_some_and(|t| t.class.is_vru());
    let crosses = Other::of(w, id).is_some_and(|o| o.moves(w.keyframe) == Some(Moves::Across));
    (is_vru || crosses) && effect.distance_m > 4.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counterfactual::tests::{EGO, START, scene, track};
    use whyroad_model::ObjectClass;
    use whyroad_model::decision::Longitudinal;
    use whyroad_model::scene::Track;

    const NOTHING: DrivingDecision =
        DrivingDecision { longitudinal: None, lateral: None, lateral_direction: None };

    /// The doubt about a class with this subject and this named lead, where the ego slows from 12 m/s for `decision`.
    fn found(
        class: &str,
        tracks: &[Track],
        decision: Longitudinal,
        (subject, lead): (Option<&str>, Option<&str>),
    ) -> Option<Doubt> {
        let (drive, signals) = scene(tracks.to_vec(), 1.0, None);
        let decision = DrivingDecision { longitudinal: Some(decision), ..NOTHING };
        let (subject, lead) = (subject.map(TrackId::from), lead.map(TrackId::from));
        let said = Said {
            class: &class.parse().unwrap(),
            decision: &decision,
            motion: LongitudinalMotion::Slows,
            course: None,
            subject: subject.as_ref(),
            lead: lead.as_ref(),
        };
        doubt(&said, &Driven::after(&drive, &signals, START, None))
    }

    #[test]
    fn an_ego_behind_a_slow_lead_does_not_slow_for_who_comes_the_other_way() {
        let lead = track("lead", ObjectClass::Car, (4.5, 1.8), |s| (EGO + 25.0 + 5.0 * (s - 10.0), 0.0));
        let comes = track("comes", ObjectClass::Car, (4.5, 1.8), |s| (EGO + 80.0 - 10.0 * (s - 10.0), 3.5));
        let of = |names| {
            let both = [lead.clone(), comes.clone()];
            found("reactive_agent.passing.general", &both, Longitudinal::YieldToAgent, names)
        };
        assert_eq!(of((Some("comes"), None)), Some(Doubt::OtherCause));
        assert_eq!(of((Some("comes"), Some("lead"))), None);
        assert_eq!(of((Some("lead"), None)), None);
        // Nobody else is there.
        let alone = [comes.clone()];
        let names = (Some("comes"), None);
        assert_eq!(found("reactive_agent.passing.general", &alone, Longitudinal::YieldToAgent, names), None);
    }

    #[test]
    fn an_ego_that_lets_a_pedestrian_cross_does_not_slow_for_the_road() {
        let person = |from: f64| {
            track("p", ObjectClass::Pedestrian, (0.6, 0.6), move |s| (EGO + 36.0, from + 1.5 * (s - 10.0)))
        };
        let of = |class, from| found(class, &[person(from)], Longitudinal::RoadSpeedAdaptation, (None, None));
        assert_eq!(of("proactive.turn.right_normal", -6.0), Some(Doubt::OtherCause));
        // Has crossed already.
        assert_eq!(of("proactive.turn.right_normal", 4.0), None);
        // A rule is a cause of its own.
        assert_eq!(of("reactive_rule.speed_limit.crosswalk_limit", -6.0), None);
    }
}
