//! The rules of DATA_FORMAT.md 4.3 and LABELING.md 6 over a [`View`], in order. Each rule contains its message; the
//! message is only built when it is read, so that the fast path pays only for the condition.

use super::business::{class, combination, decision, records};
use super::cause::{circular, far_reason, links, nobody, ordinary, remote, side, text as cause_text, unused};
use super::clips::{ClipFacts, ClipIndex};
use super::consistency::trace_rules::Said;
use super::consistency::{
    duplicates, moment, objects, parts, plausible, records as told, text, trace, trace_rules,
};
use super::form::{placeholder, version};
use super::motion;
use super::recording::Recorded;
use super::texts::{TextScope, Texts};
use super::view::View;
use whyroad_framework::Framework;
use whyroad_framework::check::class_index::{ClassIndex, Found, Prescribed};
use whyroad_framework::check::{Finding, Sink, Words, scenario};
use whyroad_model::label_fields::pointer;

/// Data that the rules need besides the label.
pub(super) struct Rulebook<'f> {
    pub classes: &'f ClassIndex,
    pub framework: &'f Framework,
    pub clips: Option<&'f ClipIndex>,
    /// The label's whole drive, where it is available.
    pub recorded: Option<&'f Recorded>,
    /// The trace that a program drafted for the label, where it is known.
    pub drafted: Option<&'f str>,
}

impl Rulebook<'_> {
    /// Applies every rule.
    pub fn check(&self, label: &View<'_>, sink: &mut dyn Sink) {
        version::version(label, sink);
        let prescribed = match scenario::check(&label.scenario, self.classes, pointer::SCENARIO, sink) {
            Some(Found::Class(p)) => Some(p),
            _ => None,
        };
        if let Some(p) = prescribed {
            class::prescribed(label, p, &self.framework.decisions, sink);
        }
        let f = self.framework;
        let mut impossible = false;
        if let Some(p) = prescribed {
            records::missing(label, p, sink);
            if let Some(decisions) = &p.decisions {
                let shown = || self.recorded.map(|r| motion::shown(label, r)).unwrap_or_default();
                let (table, names) = (f.decision_table(), &f.decisions);
                impossible = combination::decisions(label, p, decisions, table, names, &shown, sink);
            }
        }
        records::types(label, prescribed, &f.record_types, sink);
        let clip = self.clip(label, sink);
        moment::time_range(label, clip, sink);
        moment::keyframe(label, clip, sink);
        plausible::length(label, sink);
        plausible::range_inside(label, sink);
        plausible::evidence(label, prescribed, sink);
        if let Some(p) = prescribed {
            plausible::start(label, p, clip, sink);
        }
        decision::direction(label, &f.decisions, sink);
        decision::components(label, sink);
        links::ids(label, sink);
        links::evidence(label, sink);
        links::causes(label, &f.decisions, sink);
        links::second_keyframe(label, prescribed, sink);
        links::secondary(label, self.classes, sink);
        self.texts(label, prescribed, impossible, sink);
    }

    /// Rules about the texts: one finding per error, so the general rules come first and end the check.
    /// `impossible`: the decision contradicts the class, so what the texts say about it is the same fault.
    fn texts(&self, label: &View<'_>, class: Option<&Prescribed>, impossible: bool, sink: &mut dyn Sink) {
        let (words, lexicon) = (self.framework.label_words(), self.framework.lexicon());
        let background = self.framework.decision_table().causes.background;
        let decisions = class.and_then(|c| c.decisions.as_ref());
        let about = decisions.map(|d| d.about).unwrap_or_default();
        let texts = Texts::of(label, words);
        let scope = &TextScope { label, texts: &texts, words, lexicon, background, about };
        placeholder::components(scope, sink);
        told::against_texts(scope, class, sink);
        duplicates::duplicates(scope, sink);
        let mut reading = label.trace.get().map(|t| trace::read(t, &texts.units, lexicon));
        let after = label
            .trace
            .get()
            .zip(reading.as_mut())
            .and_then(|(text, r)| trace_rules::aftermath(text, scope, r));
        if let Some((text, reading)) = label.trace.get().zip(reading.as_mut()) {
            trace_rules::leave_out_own_vehicle(text, scope, reading);
        }
        cause_text::hindsight(scope, reading.as_ref(), after, sink);
        cause_text::unobserved(label, words, sink);
        parts::against_decision(scope, sink);
        let another_class = class.is_some_and(|c| text::class(scope, c, sink));
        cause_text::proximate(scope, sink);
        let far = remote::remote(scope, reading.as_ref(), sink)
            || cause_text::distant(scope, sink)
            || far_reason::far_reason(scope, sink)
            || nobody::nobody(scope, sink);
        let ordinary = ordinary::ordinary(scope, sink);
        if !far && !ordinary {
            unused::unused(scope, sink);
        }
        if !another_class
            && !impossible
            && !ordinary
            && !cause_text::kind(label, decisions, &texts, self.framework, sink)
        {
            side::of_maneuver(scope, self.framework, sink);
        }
        if placeholder::trace(scope, sink) || placeholder::draft(label, self.framework, self.drafted, sink) {
            return;
        }
        if cause_text::unobserved_in_trace(scope, sink)
            || reading.as_ref().is_some_and(|r| cause_text::denied(scope, r, sink))
        {
            return;
        }
        text::unchanged(scope, sink);
        if !another_class && text::unrelated(scope, &text::TraceParts::of(reading.as_ref()), sink) {
            return;
        }
        if impossible {
            return;
        }
        let Some(reading) = reading else { return };
        let said = trace_rules::trace(scope, decisions, &self.framework.decisions, &reading, sink);
        // A trace that is too short, or has no decision, cannot give a reason for one.
        let circular = said != Said::TooLittle && circular::circular(scope, &reading, said, sink);
        let decides_at = if reading.marked { reading.decision_from } else { 0 };
        if said != Said::TooLittle
            && !circular
            && !another_class
            && !cause_text::around(scope, decides_at, sink)
        {
            objects::unnamed(scope, reading.end, said, sink);
        }
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
