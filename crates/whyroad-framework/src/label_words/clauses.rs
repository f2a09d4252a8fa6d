//! How texts are divided into clauses, and words that show whether a clause gives a reason (`clauses` of
//! `schema/label_words.yaml`).

use super::Words;
use crate::lexicon::units::{Mark, Unit, Units};
use serde::Deserialize;
use std::ops::Range;

/// The unit that a punctuation mark ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Divider {
    /// A sentence.
    Sentence,
    /// A clause.
    Clause,
    /// An item of a list.
    Item,
    /// The text before an aside or an addition.
    Aside,
}

/// Dividers, and words at which a clause begins.
#[derive(Clone, Debug, Default)]
pub struct Clauses {
    dividers: Vec<(char, Divider)>,
    /// Keys of the units of each, a space before and behind.
    joints: Vec<Vec<u64>>,
    /// The same as written, in lower case.
    pub joint: Vec<String>,
    /// Words that are followed by a reason, wherever they are, in lower case.
    pub because: Vec<String>,
    /// Words that join a part unrelated to the preceding reason, in lower case.
    pub beside: Vec<String>,
    /// Words of [`Clauses::because`] after which the reason goes on to the end of its sentence.
    pub reason: Vec<String>,
    /// Beginnings of a part that states what the ego must or wants to do.
    pub own_duty: Vec<String>,
    /// Words after which an announced reason is given, in lower case.
    pub again: Vec<String>,
    /// The following text contrasts with the preceding one.
    pub contrast: Vec<String>,
    /// Beginnings of a clause that adds to the assumption of the one before.
    pub alternative: Vec<String>,
}

impl Clauses {
    /// The unit that a mark ends.
    pub fn divides(&self, mark: Mark) -> Option<Divider> {
        self.dividers.iter().find(|(sign, _)| *sign == mark.sign).map(|d| d.1)
    }

    /// Ends of the parts of a text between marks of these kinds, after the mark; the last part ends with the text.
    pub fn ends<'u>(
        &'u self,
        units: &'u Units,
        kinds: &'u [Divider],
        text_end: usize,
    ) -> impl Iterator<Item = usize> + 'u {
        let marks = units.marks().iter().filter(|m| self.divides(**m).is_some_and(|d| kinds.contains(&d)));
        marks.map(|m| m.end()).chain([text_end])
    }

    /// Byte at which the clause ends that holds `from`: its mark, the word that joins the next, or the end of the text.
    pub fn clause_end(&self, units: &Units, from: usize, text_end: usize) -> usize {
        let ends = |m: &&Mark| {
            matches!(self.divides(**m), Some(Divider::Sentence | Divider::Clause | Divider::Aside))
        };
        let after = units.marks().partition_point(|m| m.start < from);
        let mark = units.marks()[after..].iter().find(ends).map_or(text_end, |m| m.start);
        let clause = units.part(from..mark);
        let joint = (0..clause.len()).find(|i| self.is_joint(&clause[*i..]));
        joint.map_or(mark, |i| clause[i].start)
    }

    /// First byte of the part that holds `inside`, and the byte at which it ends: between marks for which `divides` is
    /// true. The inside may contain such marks itself.
    pub fn around(
        &self,
        units: &Units,
        inside: Range<usize>,
        text_end: usize,
        divides: &dyn Fn(Divider) -> bool,
    ) -> (usize, usize) {
        let divides = |m: &&Mark| self.divides(**m).is_some_and(divides);
        let marks = units.marks();
        let first = |at: usize| marks.partition_point(|m| m.start < at);
        let from = marks[..first(inside.start)].iter().rev().find(divides);
        let to = marks[first(inside.end)..].iter().find(divides);
        (from.map_or(0, |m| m.end()), to.map_or(text_end, |m| m.start))
    }

    /// The units begin with a joint. The last unit is the one after the clause.
    fn is_joint(&self, units: &[Unit]) -> bool {
        units[0].key == u64::from(b' ')
            && self.joints.iter().any(|joint| {
                joint.len() < units.len() && units.iter().zip(joint).all(|(unit, key)| unit.key == *key)
            })
    }
}

/// The lists as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawClauses {
    sentence: String,
    clause: String,
    item: String,
    aside: String,
    joint: Words,
    because: Words,
    beside: Words,
    reason: Words,
    own_duty: Words,
    alternative: Words,
    again: Words,
    contrast: Words,
}

impl RawClauses {
    pub(super) fn compile(&self) -> Clauses {
        let kinds = [
            (&self.sentence, Divider::Sentence),
            (&self.clause, Divider::Clause),
            (&self.item, Divider::Item),
            (&self.aside, Divider::Aside),
        ];
        let list = |w: &Words| w.all().map(str::to_lowercase).collect::<Vec<_>>();
        Clauses {
            dividers: kinds.iter().flat_map(|(signs, d)| signs.chars().map(|c| (c, *d))).collect(),
            joints: (self.joint.all())
                .map(|j| Units::of(&format!(" {j} ")).all().iter().map(|u| u.key).collect())
                .collect(),
            joint: list(&self.joint),
            because: list(&self.because),
            beside: list(&self.beside),
            reason: list(&self.reason),
            own_duty: list(&self.own_duty),
            alternative: list(&self.alternative),
            again: list(&self.again),
            contrast: list(&self.contrast),
        }
    }
}
