//! The part of the fast path that format 2.1 added: components with names and evidence, causes, provenance.

use super::{Id, Text, slot};
use crate::check::view::{CauseView, CausesView, Components, LinkedComponent};
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::borrow::Cow;
use std::fmt;
use whyroad_framework::check::Slot;
use whyroad_model::Nanos;
use whyroad_model::messages::{ProvenanceSource, Uncertainty};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LeanProvenance<'t> {
    #[allow(dead_code)] // must be of the set; no rule asks which
    source: Id<ProvenanceSource>,
    #[serde(borrow, default)]
    by: Option<Text<'t>>,
    #[serde(default)]
    #[allow(dead_code)] // must be a time; no rule asks which
    at: Option<Nanos>,
    #[serde(borrow, default)]
    tool: Option<Text<'t>>,
    #[serde(borrow, default)]
    versions: Option<LeanTexts<'t>>,
}

impl<'t> LeanProvenance<'t> {
    pub fn texts(&self) -> impl Iterator<Item = &Text<'t>> {
        self.by.iter().chain(&self.tool).chain(self.versions.iter().flat_map(|v| v.0.iter().map(|(_, t)| t)))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LeanCauses<'t> {
    #[serde(borrow, default)]
    longitudinal: Option<LeanCause<'t>>,
    #[serde(borrow, default)]
    lateral: Option<LeanCause<'t>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LeanCause<'t> {
    #[serde(borrow, default)]
    components: Option<Vec<Text<'t>>>,
    #[serde(borrow, default)]
    unobserved: Option<Text<'t>>,
}

impl<'t> LeanCauses<'t> {
    pub fn texts(&self) -> impl Iterator<Item = &Text<'t>> {
        let channels = [&self.longitudinal, &self.lateral].into_iter().flatten();
        channels.flat_map(|c| c.components.iter().flatten().chain(&c.unobserved))
    }

    pub fn view(&self) -> CausesView<'_> {
        CausesView {
            longitudinal: self.longitudinal.as_ref().map(LeanCause::view).into(),
            lateral: self.lateral.as_ref().map(LeanCause::view).into(),
        }
    }
}

impl LeanCause<'_> {
    pub fn view(&self) -> CauseView<'_> {
        let components = self.components.iter().flatten().map(|t| Slot::Is(&*t.0)).collect();
        CauseView { components, unobserved: slot(&self.unobserved) }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LeanComponent<'t> {
    #[serde(borrow, default)]
    #[allow(dead_code)] // must be text; which text is free
    category: Option<Text<'t>>,
    #[serde(borrow)]
    description: Text<'t>,
    #[serde(default)]
    uncertainty: Option<Id<Uncertainty>>,
    #[serde(borrow, default)]
    id: Option<Text<'t>>,
    #[serde(default)]
    evidence_times: Option<Vec<Nanos>>,
    #[serde(borrow, default)]
    linked_objects: Option<Vec<Text<'t>>>,
}

/// The components, folded into what rules ask; only those that say more than words are kept one by one.
pub(super) struct LeanComponents<'t> {
    pub folded: Components,
    pub linked: Vec<LeanLinked<'t>>,
}

pub(super) struct LeanLinked<'t> {
    index: usize,
    id: Option<Text<'t>>,
    evidence: Vec<Nanos>,
}

impl LeanLinked<'_> {
    pub fn view(&self) -> LinkedComponent<'_> {
        let evidence = self.evidence.iter().map(|t| Slot::Is(*t)).collect();
        LinkedComponent { index: self.index, id: slot(&self.id), evidence }
    }
}

impl<'de: 't, 't> Deserialize<'de> for LeanComponents<'t> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = LeanComponents<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of components")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut out = LeanComponents { folded: Components::default(), linked: Vec::new() };
                while let Some(c) = seq.next_element::<LeanComponent<'de>>()? {
                    let texts = c.id.iter().chain(c.linked_objects.iter().flatten());
                    if c.description.is_blank() || texts.into_iter().any(Text::is_blank) {
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

/// Texts by name, no name twice.
struct LeanTexts<'t>(Vec<(Cow<'t, str>, Text<'t>)>);

impl<'de: 't, 't> Deserialize<'de> for LeanTexts<'t> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = LeanTexts<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("texts by name")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut out: Vec<(Cow<'de, str>, Text<'de>)> = Vec::new();
                while let Some((key, text)) = map.next_entry::<Text<'de>, Text<'de>>()? {
                    if out.iter().any(|(k, _)| *k == key.0) {
                        return Err(A::Error::custom("duplicate name"));
                    }
                    out.push((key.0, text));
                }
                Ok(LeanTexts(out))
            }
        }
        d.deserialize_map(V)
    }
}
