//! A label as seen by the rules, from the fast path (typed, complete) or from the slow one (tolerant, with gaps where
//! something was already reported).

use std::borrow::Cow;
use whyroad_framework::check::Slot;
use whyroad_framework::check::scenario::ScenarioView;
use whyroad_framework::record_types::RecordValue;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::{KeyframeType, ProvenanceSource};
use whyroad_model::{Nanos, ScenarioId};

/// One label.
#[derive(Clone, Debug, Default)]
pub(super) struct View<'a> {
    pub version: Slot<&'a str>,
    pub clip_id: Slot<&'a str>,
    pub scenario: ScenarioView<'a>,
    pub start: Slot<Nanos>,
    pub end: Slot<Nanos>,
    pub start_frame: Slot<u32>,
    pub end_frame: Slot<u32>,
    pub keyframe: KeyframeView,
    /// Absent means null.
    pub longitudinal: Slot<Longitudinal>,
    /// Absent means null.
    pub lateral: Slot<Lateral>,
    pub direction: Slot<LateralDirection>,
    pub components: Slot<Components>,
    pub trace: Slot<&'a str>,
    /// The records that have a value.
    pub records: Slot<Vec<(&'a str, RecordValue<'a>)>>,
    /// The components one by one.
    pub parts: Vec<ComponentView<'a>>,
    pub causes: Slot<CausesView<'a>>,
    pub second: Slot<KeyframeView>,
    pub secondary: Vec<Slot<&'a str>>,
    pub source: Slot<ProvenanceSource>,
}

impl View<'_> {
    /// States format 2.0, which has no place for records, causes and what else later versions added.
    pub fn states_2_0(&self) -> bool {
        self.version.get().is_some_and(|v| v == "2.0" || v.starts_with("2.0."))
    }

    /// The class, if it can be read.
    pub fn class_id(&self) -> Option<ScenarioId> {
        let s = &self.scenario;
        let l3 = s.l3.get().filter(|l3| *l3 != whyroad_framework::check::class_index::OTHER);
        Some(ScenarioId {
            l1: s.l1.get()?.to_owned(),
            l2: s.l2.get().map(str::to_owned),
            l3: l3.map(str::to_owned),
        })
    }
}

/// One critical component.
#[derive(Clone, Debug, Default)]
pub(super) struct ComponentView<'a> {
    /// Position in the list.
    pub index: usize,
    pub description: Slot<&'a str>,
    pub id: Slot<&'a str>,
    pub evidence: Cow<'a, [Slot<Nanos>]>,
    /// Track ids of the objects that it links.
    pub objects: Vec<&'a str>,
}

/// Causes of the two channels.
#[derive(Clone, Debug, Default)]
pub(super) struct CausesView<'a> {
    pub longitudinal: Slot<CauseView<'a>>,
    pub lateral: Slot<CauseView<'a>>,
}

/// Causes of one channel.
#[derive(Clone, Debug, Default)]
pub(super) struct CauseView<'a> {
    pub components: Vec<Slot<&'a str>>,
    pub unobserved: Slot<&'a str>,
}

/// The decision moment of a label.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct KeyframeView {
    pub timestamp: Slot<Nanos>,
    pub frame: Slot<u32>,
    pub kind: Slot<KeyframeType>,
    pub range_start: Slot<Nanos>,
    pub range_end: Slot<Nanos>,
}

/// The properties of the critical components that rules use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Components {
    pub count: usize,
    /// At least one has `uncertainty: high`, or an unreadable value there.
    pub any_high: bool,
}
