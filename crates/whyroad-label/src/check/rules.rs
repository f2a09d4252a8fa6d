//! The business and consistency rules of DATA_FORMAT.md 4.3 over a [`View`]. Each rule stands next to its
//! wording; the wording is only made when somebody wants to read it, so that the fast path pays for the
//! question alone.

mod causal;
mod class;
mod decision;
mod moment;
mod text;

use super::ClipIndex;
use super::class_index::{ClassIndex, Found};
use super::clips::ClipFacts;
use super::view::View;
use std::borrow::Cow;
use whyroad_framework::lexicon::Lexicon;
use whyroad_model::{Bilingual, Severity};

pub(super) use class::scenario;

/// What a rule has to say, in words.
#[derive(Clone, Debug)]
pub(super) struct Words {
    pub message: Bilingual,
    pub hint: Option<Bilingual>,
}

impl Words {
    pub fn new(zh: impl Into<String>, en: impl Into<String>) -> Self {
        Self { message: Bilingual::new(zh, en), hint: None }
    }

    pub fn hint(mut self, zh: impl Into<String>, en: impl Into<String>) -> Self {
        self.hint = Some(Bilingual::new(zh, en));
        self
    }

    /// With the word that was probably meant.
    pub fn meant(self, word: &str) -> Self {
        self.hint(format!("是否想写 '{word}'？"), format!("did you mean '{word}'?"))
    }

    /// With the words that there are, as each language lists them.
    pub fn one_of(self, zh: &str, en: &str) -> Self {
        self.hint(format!("可选：{zh}"), format!("choose one of: {en}"))
    }
}

/// What was found, and where.
#[derive(Clone, Debug)]
pub(super) struct Finding {
    pub code: &'static str,
    pub severity: Severity,
    /// JSON pointer; need not exist in the document.
    pub pointer: Cow<'static, str>,
    /// Bytes of the text there, when only a part is meant.
    pub part: Option<(usize, usize)>,
}

impl Finding {
    pub fn error(code: &'static str, pointer: impl Into<Cow<'static, str>>) -> Self {
        Self { code, severity: Severity::Error, pointer: pointer.into(), part: None }
    }

    pub fn warning(code: &'static str, pointer: impl Into<Cow<'static, str>>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, pointer) }
    }

    pub fn part(mut self, start: usize, end: usize) -> Self {
        self.part = Some((start, end));
        self
    }
}

/// Takes findings. The fast path only notes that there was one.
pub(super) trait Sink {
    fn report(&mut self, finding: Finding, words: &dyn Fn() -> Words);
}

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
        let prescribed = match scenario(&label.scenario, self.classes, "/scenario", sink) {
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
            sink.report(Finding::error("label.clip.unknown", "/clip_id"), &|| {
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
