//! The fast path: one typed pass over a label's bytes, without copies, that accepts only a document that is certainly
//! valid at the basic level. A rejected document may still be valid; the slow path decides and reports.

mod fields;
mod values;

pub(in crate::check) use fields::LeanCocLabel;

use crate::check::view::{CauseView, CausesView, KeyframeView, View};
use fields::{LeanCause, LeanCauses, LeanKeyframe};
use values::Text;
use whyroad_framework::check::Slot;
use whyroad_framework::check::scenario::ScenarioView;

impl<'t> LeanCocLabel<'t> {
    /// The label in `text`, or `None` where it is not certainly valid.
    pub fn read(text: &'t str) -> Option<Self> {
        let label: Self = serde_json::from_str(text).ok()?;
        (!label.has_blank()).then_some(label)
    }

    /// The label as the rules see it.
    pub fn view(&self) -> View<'_> {
        View {
            version: slot(&self.version),
            clip_id: Slot::Is(&self.clip_id.0),
            scenario: ScenarioView {
                l1: Slot::Is(&self.scenario.l1.0),
                l2: Slot::Is(&self.scenario.l2.0),
                l3: slot(&self.scenario.l3),
                full_id: slot(&self.scenario.full_id),
            },
            start: Slot::Is(self.time_range.start_timestamp),
            end: Slot::Is(self.time_range.end_timestamp),
            start_frame: self.time_range.start_frame_idx.into(),
            end_frame: self.time_range.end_frame_idx.into(),
            keyframe: self.keyframe.view(),
            longitudinal: self.driving_decision.longitudinal.as_ref().map(|d| d.0).into(),
            lateral: self.driving_decision.lateral.as_ref().map(|d| d.0).into(),
            direction: self.driving_decision.lateral_direction.as_ref().map(|d| d.0).into(),
            components: Slot::Is(self.critical_components.folded),
            trace: Slot::Is(&self.coc_trace.0),
            records: match &self.records {
                Some(r) => Slot::Is(r.0.iter().filter_map(|(k, v)| Some((&**k, v.view()?))).collect()),
                None => Slot::Absent,
            },
            parts: self.critical_components.items.iter().enumerate().map(|(i, c)| c.view(i)).collect(),
            causes: self.causes.as_ref().map(LeanCauses::view).into(),
            second: self.second_keyframe.as_ref().map(LeanKeyframe::view).into(),
            source: self.provenance.as_ref().map(|p| p.source.0).into(),
            secondary: self.secondary_scenarios.iter().flatten().map(|t| Slot::Is(&*t.0)).collect(),
        }
    }
}

impl LeanKeyframe {
    fn view(&self) -> KeyframeView {
        KeyframeView {
            timestamp: Slot::Is(self.timestamp),
            frame: Slot::Is(self.frame_idx),
            kind: Slot::Is(self.kind.0),
            range_start: self.range_start.into(),
            range_end: self.range_end.into(),
        }
    }
}

fn slot<'s>(t: &'s Option<Text<'_>>) -> Slot<&'s str> {
    t.as_ref().map(|t| &*t.0).into()
}

impl LeanCauses<'_> {
    fn view(&self) -> CausesView<'_> {
        CausesView {
            longitudinal: self.longitudinal.as_ref().map(LeanCause::view).into(),
            lateral: self.lateral.as_ref().map(LeanCause::view).into(),
        }
    }
}

impl LeanCause<'_> {
    fn view(&self) -> CauseView<'_> {
        let components = self.components.iter().flatten().map(|t| Slot::Is(&*t.0)).collect();
        CauseView { components, unobserved: slot(&self.unobserved) }
    }
}
