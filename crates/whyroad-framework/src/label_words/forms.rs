//! Words for statements that are recognized by their place in a text rather than as phrases (`forms` of
//! `schema/label_words.yaml`): what the ego does in the last sentence of a trace, a component that only describes the
//! road, a place where nothing is.

use super::Words;
use super::compile::expanded;
use serde::Deserialize;
use whyroad_model::Bilingual;

/// All lists, in lower case.
#[derive(Clone, Debug, Default)]
pub struct Forms {
    /// Of the road and the weather as they mostly are.
    pub ordinary: Vec<String>,
    /// Parts of the course of the ego, and words for what stays the same.
    pub course: Vec<String>,
    /// See `course`.
    pub same: Vec<String>,
    /// Nothing is there.
    pub free: Vec<String>,
    /// A reason follows.
    pub because: Vec<String>,
    /// What was named is not the reason.
    pub not_reason: Vec<String>,
    /// Who was named makes no difference to the ego.
    pub no_bearing: Vec<String>,
    /// Before one of these two: it is only supposed.
    pub supposed: Vec<String>,
    /// Before the name of a road user that only locates something else.
    pub between: Vec<String>,
    /// Not on the ego's lane, but on both sides of it, or on another one.
    pub both_sides: Vec<String>,
    /// Movements of the ego out of its lane.
    pub sideways: Vec<String>,
    /// A clause about the ego begins with one.
    pub begins: Vec<String>,
    /// Before a movement: somebody else moves, or may.
    pub others: Vec<String>,
    /// Hold one of `others` and mean nobody else.
    pub not_others: Vec<String>,
    /// Negations, conditions and plans.
    pub denied: Vec<String>,
    /// Before what the ego does not do, in a component.
    pub instead: Vec<String>,
    /// Behind a movement: room for it.
    pub room: Vec<String>,
    /// Speed and what sets it, and words with which a clause does not state that it is kept.
    pub pace: Vec<String>,
    /// See `pace`.
    pub kept: Vec<String>,
    /// See `pace`.
    pub changed: Vec<String>,
    /// Before a side: a movement to it.
    pub towards: Vec<String>,
    /// Finite verbs for how something is.
    pub is: Vec<String>,
    /// With one of these a sentence may be about the ego.
    pub controls: Vec<String>,
}

impl Forms {
    /// Bytes of the first of `list` in `lower`; Latin words as whole words.
    pub fn find(list: &[String], lower: &str) -> Option<(usize, usize)> {
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '\'';
        let whole = |at: usize, w: &str| {
            !w.is_ascii() || !lower[..at].ends_with(letter) && !lower[at + w.len()..].starts_with(letter)
        };
        let all = list.iter().filter(|w| w.is_ascii() || !lower.is_ascii());
        let hits = all.filter_map(|w| {
            let at = lower.match_indices(w.as_str()).map(|(at, _)| at).find(|at| whole(*at, w))?;
            Some((at, at + w.len()))
        });
        hits.min()
    }
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
        let mut all = |w: &Words| -> Vec<String> { w.all().flat_map(|p| expanded(p, problems)).collect() };
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
