//! The business and consistency rules of DATA_FORMAT.md 4.3 over a [`View`]. Each rule is next to its
//! wording; the wording is only made when it is read, so that the fast path pays for the
//! question alone.

mod causal;
mod class;
mod decision;
mod moment;
mod text;

use super::clips::{ClipFacts, ClipIndex};
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
        text::version(label, sink);
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
        causal::ids(label, sink);
        causal::evidence(label, sink);
        causal::causes(label, sink);
        causal::second_keyframe(label, prescribed, sink);
        causal::secondary(label, self.classes, sink);
        text::trace(label, self.lexicon, sink);
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
