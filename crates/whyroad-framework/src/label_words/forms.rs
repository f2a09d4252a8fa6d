//! Words for statements that are recognized by their place in a text rather than as phrases (`forms` of
//! `schema/label_words.yaml`): what the ego does in the last sentence of a trace, a component that only describes the
//! road, a place where nothing is.

use super::Words;
use super::compile::expanded;
use crate::phrases::Phrases;
use serde::Deserialize;
use whyroad_model::Bilingual;

/// All lists, in lower case.
#[derive(Clone, Debug, Default)]
pub struct Forms {
    /// Of the road and the weather as they mostly are.
    pub ordinary: Phrases,
    /// Parts of the course of the ego, and words for what stays the same.
    pub course: Phrases,
    /// See `course`.
    pub same: Phrases,
    /// Nothing is there.
    pub free: Phrases,
    /// A reason follows.
    pub because: Phrases,
    /// What was named is not the reason.
    pub not_reason: Phrases,
    /// Who was named makes no difference to the ego.
    pub no_bearing: Phrases,
    /// Before one of these two: it is only supposed.
    pub supposed: Phrases,
    /// Before the name of a road user that only locates something else.
    pub between: Phrases,
    /// Not on the ego's lane, but on both sides of it, or on another one.
    pub both_sides: Phrases,
    /// Movements of the ego out of its lane.
    pub sideways: Phrases,
    /// A clause about the ego begins with one.
    pub begins: Phrases,
    /// Before a movement: somebody else moves, or may.
    pub others: Phrases,
    /// Hold one of `others` and mean nobody else.
    pub not_others: Phrases,
    /// Negations, conditions and plans.
    pub denied: Phrases,
    /// Before what the ego does not do, in a component.
    pub instead: Phrases,
    /// Behind a movement: room for it.
    pub room: Phrases,
    /// Speed and what sets it, and words with which a clause does not state that it is kept.
    pub pace: Phrases,
    /// See `pace`.
    pub kept: Phrases,
    /// See `pace`.
    pub changed: Phrases,
    /// Before a side: a movement to it.
    pub towards: Phrases,
    /// Finite verbs for how something is.
    pub is: Phrases,
    /// With one of these a sentence may be about the ego.
    pub controls: Phrases,
}

/// The lists as written.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawForms {
    ordinary: Words,
    course: Words,
    same: Words,
    free: Words,
    because: Words,
    not_reason: Words,
    no_bearing: Words,
    supposed: Words,
    between: Words,
    both_sides: Words,
    sideways: Words,
    begins: Words,
    others: Words,
    not_others: Words,
    denied: Words,
    instead: Words,
    room: Words,
    pace: Words,
    kept: Words,
    changed: Words,
    towards: Words,
    is: Words,
    controls: Words,
}

impl RawForms {
    pub(super) fn compile(&self, problems: &mut Vec<Bilingual>) -> Forms {
        let mut all = |w: &Words| Phrases::new(w.all().flat_map(|p| expanded(p, problems)).collect());
        Forms {
            ordinary: all(&self.ordinary),
            course: all(&self.course),
            same: all(&self.same),
            free: all(&self.free),
            because: all(&self.because),
            not_reason: all(&self.not_reason),
            no_bearing: all(&self.no_bearing),
            supposed: all(&self.supposed),
            between: all(&self.between),
            both_sides: all(&self.both_sides),
            sideways: all(&self.sideways),
            begins: all(&self.begins),
            others: all(&self.others),
            not_others: all(&self.not_others),
            denied: all(&self.denied),
            instead: all(&self.instead),
            room: all(&self.room),
            pace: all(&self.pace),
            kept: all(&self.kept),
            changed: all(&self.changed),
            towards: all(&self.towards),
            is: all(&self.is),
            controls: all(&self.controls),
        }
    }
}
