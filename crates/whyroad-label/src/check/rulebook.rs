//! The rules of DATA_FORMAT.md 4.3 and LABELING.md 6 over a [`View`], in order. Each rule is next to its
//! wording; the wording is only made when it is read, so that the fast path pays for the
//! question alone.

use super::business::{class, decision};
use super::cause::links;
use super::clips::{ClipFacts, ClipIndex};
use super::consistency::{moment, trace_rules};
use super::form::version;
use super::view::View;
use whyroad_framework::check::class_index::{ClassIndex, Found};
use whyroad_framework::check::{Finding, Sink, Words, scenario};
use whyroad_framework::lexicon::Lexicon;
use whyroad_model::label_fields::pointer;

/// What the rules know besides the label.
pub(super) struct Rulebook<'f> {
    pub classes: &'f ClassIndex,
    pub lexicon: &'f Lexicon,
    pub clips: Option<&'f ClipIndex>,
}

impl Rulebook<'_> {
    /// Runs every rule.
    pub fn check(&self, label: &View<'_>, sink: &mut dyn Sink) {
        version::version(label, sink);
        let prescribed = match scenario::check(&label.scenario, self.classes, pointer::SCENARIO, sink) {
            Some(Found::Class(p)) => Some(p),
            _ => None,
        };
        if let Some(p) = prescribed {
            class::prescribed(label, p, sink);
        }
        let clip = self.clip(label, sink);
        moment::time_range(label, clip, sink);
        moment::keyframe(label, clip, sink);
        decision::direction(label, sink);
        decision::components(label, sink);
        links::ids(label, sink);
        links::evidence(label, sink);
        links::causes(label, sink);
        links::second_keyframe(label, prescribed, sink);
        links::secondary(label, self.classes, sink);
        trace_rules::trace(label, self.lexicon, sink);
    }

    fn clip(&self, label: &View<'_>, sink: &mut dyn Sink) -> Option<&ClipFacts> {
        let (clips, id) = (self.clips?, label.clip_id.get()?);
        let found = clips.get(id);
        if found.is_none() {
            sink.report(Finding::error("label.clip.unknown", pointer::CLIP_ID), &|| {
                let words = Words::new(
                    format!("片段清单中没有 '{id}'"),
                    format!("clip '{id}' is not in the clip list"),
                );
                match clips.nearest(id) {
                    Some(near) => words.meant(near),
                    None => words,
                }
            });
        }
        found
    }
}
