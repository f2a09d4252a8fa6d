//! The checker of labels (DATA_FORMAT.md 4.3): takes documents and returns findings, each with a code, a location and a
//! hint.
//!
//! A label takes the fast path first: one typed pass over its bytes ([`form::lean`]), and the rules ([`rulebook`]) with
//! a sink that only records whether there was a finding. If there was one, or the pass is not certain, the document is
//! parsed again with spans (`whyroad_framework::check`), read tolerantly ([`form::tolerant`]), and the same rules write
//! their messages. Other messages are checked by whyroad-framework. Nothing here opens a file: `Splitter` takes bytes
//! and returns documents.

mod business;
pub(crate) mod cause;
mod clips;
mod codes;
mod consistency;
mod excerpt;
mod form;
mod motion;
mod overlap;
mod quality;
mod reading;
mod recording;
mod rulebook;
mod silence;
mod spans;
mod subject;
mod texts;
mod view;

pub use clips::{ClipFacts, ClipIndex};
pub(crate) use form::kept::bare;

pub use codes::{CODES, QUALITY_CODES};
pub use quality::{Quality, QualityKind};
pub use recording::{COMPONENT_SIGNALS, Recorded, Recordings};

use form::{lean, tolerant};
use rulebook::Rulebook;
use silence::Silence;
use std::sync::Arc;
use view::View;
use whyroad_framework::Framework;
use whyroad_framework::check::{
    ClassIndex, Document, Finding, MessageKind, Origin, Sink, Verdict, Words, check_document, not_utf8,
};
use whyroad_model::Diagnostic;
use whyroad_model::label_fields::pointer;

/// Code of the report that a label was not compared, because its drive is not available.
pub const UNRECORDED: &str = "label.clip.unrecorded";

/// Checks documents against one framework and, where given, one list of clips.
#[derive(Debug)]
pub struct Checker<'f> {
    framework: &'f Framework,
    classes: ClassIndex,
    clips: Option<ClipIndex>,
    recordings: Option<Arc<dyn Recordings>>,
    /// Only what Stage I shows may be compared: the components with the history.
    stage_one: bool,
    /// A label whose drive is not available is reported.
    misses_drives: bool,
}

impl<'f> Checker<'f> {
    /// A checker without a list of clips.
    pub fn new(framework: &'f Framework) -> Self {
        Self {
            framework,
            classes: ClassIndex::new(framework),
            clips: None,
            recordings: None,
            stage_one: false,
            misses_drives: false,
        }
    }

    /// The same, checking labels against these clips.
    #[must_use]
    pub fn with_clips(mut self, clips: ClipIndex) -> Self {
        self.clips = Some(clips);
        self
    }

    /// The same, checking labels against the drives that are available.
    #[must_use]
    pub fn with_recordings(mut self, recordings: Arc<dyn Recordings>) -> Self {
        self.recordings = Some(recordings);
        self
    }

    /// The same, reporting labels that cannot be compared because their drive is not available.
    #[must_use]
    pub fn reporting_missing_drives(mut self) -> Self {
        self.misses_drives = true;
        self
    }

    /// The same, comparing only components, and only with the drives up to the keyframe ([`Recordings::until`]): no
    /// finding depends on what comes later.
    #[must_use]
    pub fn with_histories(mut self, recordings: Arc<dyn Recordings>) -> Self {
        self.stage_one = true;
        self.with_recordings(recordings)
    }

    /// Applies every rule, including those that compare with the recording, or with the draft, if there is one.
    fn rules(&self, label: &View<'_>, drafted: Option<&str>, sink: &mut dyn Sink) {
        let of_clip = self.recordings.as_deref().zip(label.clip_id.get());
        let until_keyframe = || {
            let (recordings, id) = of_clip?;
            recordings.until(id, label.keyframe.timestamp.get()?)
        };
        let recorded = of_clip.filter(|_| !self.stage_one).and_then(|(r, id)| r.of_clip(id));
        let rulebook = Rulebook {
            classes: &self.classes,
            framework: self.framework,
            clips: self.clips.as_ref(),
            recorded: recorded.as_deref(),
            drafted,
        };
        rulebook.check(label, sink);
        let history = || if self.stage_one { until_keyframe() } else { None };
        // In Stage I a drive is cut at the keyframe: without one there is nothing to compare.
        let comparable = !self.stage_one || label.keyframe.timestamp.get().is_some();
        if let Some(recorded) = &recorded {
            motion::check(label, recorded, &until_keyframe, self.framework, &self.classes, sink);
        } else if let Some(history) = history() {
            motion::components(label, &history, None, self.framework, sink);
        } else if let (true, Some((_, id))) = (self.misses_drives && comparable, of_clip) {
            unrecorded(id, sink);
        }
    }

    /// Checks one document and adds the findings, sorted by location, to `out`. Locations have no file name.
    pub fn check(&self, document: &Document<'_>, out: &mut Vec<Diagnostic>) -> Verdict {
        self.check_since(document, None, out)
    }

    fn check_since(
        &self,
        document: &Document<'_>,
        drafted: Option<&str>,
        out: &mut Vec<Diagnostic>,
    ) -> Verdict {
        match std::str::from_utf8(document.bytes) {
            Ok(text) if self.is_clean(text, drafted) => {
                Verdict { kind: Some(MessageKind::CocLabel), valid: true, foreign: false }
            }
            Ok(text) => self.explain(text, drafted, &document.origin, out),
            Err(e) => {
                out.push(not_utf8(document, e.valid_up_to()));
                Verdict { kind: None, valid: false, foreign: false }
            }
        }
    }

    /// Checks a single document.
    pub fn check_text(&self, text: &str) -> Vec<Diagnostic> {
        self.check_text_since(text, None)
    }

    /// The same for a label that began with the trace `drafted`, which a program wrote: a draft that was changed is
    /// recognized, too.
    pub fn check_text_since(&self, text: &str, drafted: Option<&str>) -> Vec<Diagnostic> {
        let mut out = Vec::new();
        self.check_since(&Document { origin: Origin::start(), bytes: text.as_bytes() }, drafted, &mut out);
        out
    }

    /// The fast path: true when `text` is a label without any finding. False means only that the slow path must decide.
    pub fn is_clean_label(&self, text: &str) -> bool {
        self.is_clean(text, None)
    }

    fn is_clean(&self, text: &str, drafted: Option<&str>) -> bool {
        lean::LeanCocLabel::read(text).is_some_and(|label| {
            let mut sink = Silence::default();
            self.rules(&label.view(), drafted, &mut sink);
            !sink.broken
        })
    }

    /// The slow path: reports every finding in `text`, independent of the fast path.
    fn explain(
        &self,
        text: &str,
        drafted: Option<&str>,
        origin: &Origin,
        out: &mut Vec<Diagnostic>,
    ) -> Verdict {
        check_document(text, origin, &self.classes, out, |walk| {
            let view = tolerant::read(walk, &self.framework.decisions);
            self.rules(&view, drafted, walk);
        })
    }
}

fn unrecorded(clip: &str, sink: &mut dyn Sink) {
    sink.report(Finding::warning(UNRECORDED, pointer::CLIP_ID), &|| {
        Words::new(
            format!("数据湖中没有片段 '{clip}' 的行程：未与录制核对"),
            format!("the lake has no drive of clip '{clip}': the label was not compared with a recording"),
        )
    });
}

#[cfg(test)]
mod tests;
