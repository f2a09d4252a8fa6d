//! The fields of a label for the fast reader. The structs are generated from `schema/label_fields.yaml` by the build
//! script; written by hand is only what is kept of the critical components.

use super::values::{Id, Records, Text, Texts, present};
use crate::check::view::{Components, LinkedComponent};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use whyroad_framework::check::Slot;
use whyroad_model::Nanos;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::{KeyframeType, ProvenanceSource, Uncertainty};

include!(concat!(env!("OUT_DIR"), "/lean_label.rs"));

/// The components, folded into what rules ask; only those with an id or evidence are kept one by one.
pub(in crate::check) struct FoldedCriticalComponents<'t> {
    pub folded: Components,
    pub linked: Vec<LeanLinked<'t>>,
}

pub(in crate::check) struct LeanLinked<'t> {
    index: usize,
    id: Option<Text<'t>>,
    evidence: Vec<Nanos>,
}

impl LeanLinked<'_> {
    pub fn view(&self) -> LinkedComponent<'_> {
        let evidence = self.evidence.iter().map(|t| Slot::Is(*t)).collect();
        let id = self.id.as_ref().map(|t| &*t.0).into();
        LinkedComponent { index: self.index, id, evidence }
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
                let mut out = FoldedCriticalComponents { folded: Components::default(), linked: Vec::new() };
                while let Some(c) = seq.next_element::<LeanCriticalComponent<'de>>()? {
                    if c.has_blank() {
                        return Err(A::Error::custom("blank text"));
                    }
                    let evidence = c.evidence_times.unwrap_or_default();
                    if c.id.is_some() || !evidence.is_empty() {
                        out.linked.push(LeanLinked { index: out.folded.count, id: c.id, evidence });
                    }
                    out.folded.count += 1;
                    out.folded.any_high |= c.uncertainty.is_some_and(|u| u.0 == Uncertainty::High);
                }
                Ok(out)
            }
        }
        d.deserialize_seq(V)
    }
}
