//! The fields of a label for the fast reader. The build script generates the structs from `schema/label_fields.yaml`;
//! only the fold of the critical components is written by hand.

use super::values::{Id, Records, Text, Texts, present};
use crate::check::view::{ComponentView, Components};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use whyroad_framework::check::Slot;
use whyroad_model::Nanos;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::{KeyframeType, ProvenanceSource, SafetyAnswer, Uncertainty};

include!(concat!(env!("OUT_DIR"), "/lean_label.rs"));

/// The components, with the values that rules need from all of them.
pub(in crate::check) struct FoldedCriticalComponents<'t> {
    pub folded: Components,
    pub items: Vec<LeanCriticalComponent<'t>>,
}

impl LeanCriticalComponent<'_> {
    pub fn view(&self, index: usize) -> ComponentView<'_> {
        let evidence: Vec<_> = self.evidence_times.iter().flatten().map(|t| Slot::Is(*t)).collect();
        ComponentView {
            index,
            description: Slot::Is(&self.description.0),
            id: self.id.as_ref().map(|t| &*t.0).into(),
            evidence: evidence.into(),
            objects: self.linked_objects.iter().flatten().map(|t| &*t.0).collect(),
        }
    }
}

impl<'de: 't, 't> Deserialize<'de> for FoldedCriticalComponents<'t> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = FoldedCriticalComponents<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of components")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut out = FoldedCriticalComponents { folded: Components::default(), items: Vec::new() };
                while let Some(c) = seq.next_element::<LeanCriticalComponent<'de>>()? {
                    if c.has_blank() {
                        return Err(A::Error::custom("blank text"));
                    }
                    out.folded.count += 1;
                    out.folded.any_high |= c.uncertainty.as_ref().is_some_and(|u| u.0 == Uncertainty::High);
                    out.items.push(c);
                }
                Ok(out)
            }
        }
        d.deserialize_seq(V)
    }
}
