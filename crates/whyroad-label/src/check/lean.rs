//! The fast path: one typed pass over a label's bytes, nothing copied, that takes a document only when it is
//! beyond doubt at the basic level. What it refuses is not yet wrong; the slow path decides and explains.

mod linked;

use super::view::{KeyframeView, View};
use linked::{LeanCauses, LeanComponents, LeanLinked, LeanProvenance};
use serde::de::{DeserializeSeed, Error, MapAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;
use whyroad_framework::check::Slot;
use whyroad_framework::check::scenario::ScenarioView;
use whyroad_model::Nanos;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::{KeyframeType, ProvenanceSource, Uncertainty};

/// A label whose texts still lie in the document. Same fields as `whyroad_model::messages::CocLabel`, but no
/// others allowed, because an unknown field is a finding.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Lean<'t> {
    #[serde(borrow, default)]
    version: Option<Text<'t>>,
    #[serde(borrow)]
    clip_id: Text<'t>,
    #[serde(borrow)]
    scenario: LeanScenario<'t>,
    time_range: LeanRange,
    keyframe: LeanKeyframe,
    driving_decision: LeanDecision,
    #[serde(borrow)]
    critical_components: LeanComponents<'t>,
    #[serde(borrow)]
    coc_trace: Text<'t>,
    #[serde(borrow, default)]
    records: Option<LeanRecords<'t>>,
    #[serde(borrow, default)]
    causes: Option<LeanCauses<'t>>,
    #[serde(default)]
    second_keyframe: Option<LeanKeyframe>,
    #[serde(borrow, default)]
    secondary_scenarios: Option<Vec<Text<'t>>>,
    #[serde(borrow, default)]
    provenance: Option<LeanProvenance<'t>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LeanScenario<'t> {
    #[serde(borrow)]
    l1: Text<'t>,
    #[serde(borrow)]
    l2: Text<'t>,
    #[serde(borrow, default)]
    l3: Option<Text<'t>>,
    #[serde(borrow, default)]
    full_id: Option<Text<'t>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LeanRange {
    start_timestamp: Nanos,
    end_timestamp: Nanos,
    #[serde(default)]
    start_frame_idx: Option<u32>,
    #[serde(default)]
    end_frame_idx: Option<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LeanKeyframe {
    timestamp: Nanos,
    frame_idx: u32,
    #[serde(rename = "type")]
    kind: Id<KeyframeType>,
    #[serde(default)]
    range_start: Option<Nanos>,
    #[serde(default)]
    range_end: Option<Nanos>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LeanDecision {
    #[serde(deserialize_with = "present")]
    longitudinal: Option<Id<Longitudinal>>,
    #[serde(deserialize_with = "present")]
    lateral: Option<Id<Lateral>>,
    #[serde(default)]
    lateral_direction: Option<Id<LateralDirection>>,
}

fn present<'de, D: Deserializer<'de>, T: Deserialize<'de>>(d: D) -> Result<Option<T>, D::Error> {
    Option::<T>::deserialize(d)
}

impl<'t> Lean<'t> {
    /// The label in `text`, or nothing where there is any doubt about it.
    pub fn read(text: &'t str) -> Option<Self> {
        let label: Self = serde_json::from_str(text).ok()?;
        let s = &label.scenario;
        let optional = [&label.version, &s.l3, &s.full_id];
        let filled = [&label.clip_id, &s.l1, &s.l2]
            .into_iter()
            .chain(optional.into_iter().flatten())
            .chain(label.secondary_scenarios.iter().flatten())
            .chain(label.causes.iter().flat_map(LeanCauses::texts))
            .chain(label.provenance.iter().flat_map(LeanProvenance::texts))
            .all(|t| !t.is_blank());
        filled.then_some(label)
    }

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
                Some(r) => Slot::Is(r.0.iter().map(|k| &**k).collect()),
                None => Slot::Absent,
            },
            linked: self.critical_components.linked.iter().map(LeanLinked::view).collect(),
            causes: self.causes.as_ref().map(LeanCauses::view).into(),
            second: self.second_keyframe.as_ref().map(LeanKeyframe::view).into(),
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

/// A text that is borrowed where it has no escapes.
struct Text<'t>(Cow<'t, str>);

impl Text<'_> {
    fn is_blank(&self) -> bool {
        self.0.trim().is_empty()
    }
}

impl<'de: 't, 't> Deserialize<'de> for Text<'t> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = Text<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("text")
            }
            fn visit_borrowed_str<E: Error>(self, s: &'de str) -> Result<Self::Value, E> {
                Ok(Text(Cow::Borrowed(s)))
            }
            fn visit_str<E: Error>(self, s: &str) -> Result<Self::Value, E> {
                Ok(Text(Cow::Owned(s.to_owned())))
            }
        }
        d.deserialize_str(V)
    }
}

/// A member of a closed set, written as text and nothing else: serde's own enums also take `{"id": null}`.
struct Id<T>(T);

/// The closed sets of a label.
trait Closed: Sized {
    fn of(id: &str) -> Option<Self>;
}

macro_rules! closed {
    ($($t:ty),+) => { $(impl Closed for $t { fn of(id: &str) -> Option<Self> { Self::from_id(id) } })+ };
}
closed!(KeyframeType, ProvenanceSource, Uncertainty, Longitudinal, Lateral, LateralDirection);

impl<'de, T: Closed> Deserialize<'de> for Id<T> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V<T>(PhantomData<T>);
        impl<T: Closed> Visitor<'_> for V<T> {
            type Value = Id<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an identifier of a closed set")
            }
            fn visit_str<E: Error>(self, s: &str) -> Result<Self::Value, E> {
                T::of(s).map(Id).ok_or_else(|| E::invalid_value(Unexpected::Str(s), &self))
            }
        }
        d.deserialize_str(V(PhantomData))
    }
}

/// Ids of the records that hold something. Nested values are left to the slow path.
struct LeanRecords<'t>(Vec<Cow<'t, str>>);

impl<'de: 't, 't> Deserialize<'de> for LeanRecords<'t> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = LeanRecords<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("records")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut seen: Vec<(Cow<'de, str>, bool)> = Vec::new();
                while let Some(key) = map.next_key::<Text<'de>>()? {
                    let filled = map.next_value_seed(Filled)?;
                    if seen.iter().any(|(k, _)| *k == key.0) {
                        return Err(A::Error::custom("duplicate record"));
                    }
                    seen.push((key.0, filled));
                }
                Ok(LeanRecords(seen.into_iter().filter(|(_, filled)| *filled).map(|(k, _)| k).collect()))
            }
        }
        d.deserialize_map(V)
    }
}

/// Whether a value holds something: not null, not blank.
struct Filled;

impl<'de> DeserializeSeed<'de> for Filled {
    type Value = bool;
    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<bool, D::Error> {
        d.deserialize_any(self)
    }
}

impl Visitor<'_> for Filled {
    type Value = bool;
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a plain value")
    }
    fn visit_unit<E: Error>(self) -> Result<bool, E> {
        Ok(false)
    }
    fn visit_bool<E: Error>(self, _: bool) -> Result<bool, E> {
        Ok(true)
    }
    fn visit_i64<E: Error>(self, _: i64) -> Result<bool, E> {
        Ok(true)
    }
    fn visit_u64<E: Error>(self, _: u64) -> Result<bool, E> {
        Ok(true)
    }
    fn visit_f64<E: Error>(self, _: f64) -> Result<bool, E> {
        Ok(true)
    }
    fn visit_str<E: Error>(self, s: &str) -> Result<bool, E> {
        Ok(!s.trim().is_empty())
    }
}
