//! Words for events after the decision (`aftermath` of `schema/label_words.yaml`).

use super::compile::{expanded, trie};
use super::{CharSet, Words, has_word};
use crate::lexicon::trie::Trie;
use crate::lexicon::units::Units;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use whyroad_model::Bilingual;

/// What a word indicates about its clause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TellWord {
    /// A reason, a purpose, a condition or a plan, not an event.
    Exempt,
    /// Past tense.
    Past,
    /// Past tense where a subject precedes it.
    PastOfSubject,
    /// Ends like a past tense but is not one.
    NotPast,
    /// An outcome, also of the decision itself.
    Outcome,
    /// An event, where the clause states no decision.
    Event,
}

/// Words by which a clause has a new subject before a past tense (`new_subject` of the file), in lower case.
#[derive(Clone, Debug, Default)]
pub struct NewSubject {
    /// It begins with one of these.
    pub begins: Vec<String>,
    /// None of these is in it.
    pub breaks: Vec<String>,
    /// Its last word is not one of these.
    pub own: Vec<String>,
    /// One of these follows the verb, unless the clause ends.
    pub behind: Vec<String>,
}

/// The words of traces, as one search; those of components are found with all others (`WordRole::AfterResponse`).
#[derive(Clone, Debug, Default)]
pub struct Aftermath {
    trace: Trie,
    tells: Vec<TellWord>,
    /// Words after which a verb of Latin letters has a subject.
    pub subjects: Vec<String>,
    /// In a component, with a past tense: what came later; in lower case.
    pub later: Vec<String>,
    /// Past tenses.
    pub told: Vec<String>,
    /// After these, a word with a past-tense ending is a participle.
    pub participle: Vec<String>,
    /// Words that may stand between a subject and its verb.
    pub between: Vec<String>,
    /// Beginnings of a clause about another road user.
    pub new_subject: NewSubject,
    /// Irregular past tenses of decisions.
    pub decided: Vec<String>,
    /// Events that the ego itself may plan: "then".
    pub sequel: Vec<String>,
    /// The moment of the decision: events stated before it were observed, too.
    now: Words,
    /// Characters that stand with what is completed.
    pub completed: CharSet,
}

impl Aftermath {
    /// Passes the words of a clause of a trace, `bytes`, to `take`: meaning, first byte, one past the last byte.
    pub fn trace_hits(
        &self,
        units: &Units,
        bytes: Range<usize>,
        mut take: impl FnMut(TellWord, usize, usize),
    ) {
        self.trace.find_in(units, bytes, |f| take(self.tells[f.word], f.start, f.end));
    }

    /// The text mentions the moment of the decision.
    pub fn is_now(&self, text: &str) -> bool {
        self.now.zh.iter().any(|w| text.contains(w.as_str()))
            || has_word(text, |word| self.now.en.iter().any(|w| word.eq_ignore_ascii_case(w)))
    }
}

/// As written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawNewSubject {
    begins: Words,
    breaks: Words,
    own: Words,
    behind: Words,
}

/// The lists as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawAftermath {
    subjects: Words,
    later: Words,
    participle: Words,
    between: Words,
    new_subject: RawNewSubject,
    decided: Words,
    exempt: Words,
    past: Words,
    past_of_subject: Words,
    not_past: Words,
    outcome: Words,
    event: Words,
    sequel: Words,
    now: Words,
    completed: Words,
    pub(super) component: Words,
}

impl RawAftermath {
    pub(super) fn compile(&self, problems: &mut Vec<Bilingual>) -> Aftermath {
        let mut tells = BTreeMap::new();
        let lists = [
            (&self.event, TellWord::Event),
            (&self.outcome, TellWord::Outcome),
            (&self.past_of_subject, TellWord::PastOfSubject),
            (&self.past, TellWord::Past),
            (&self.not_past, TellWord::NotPast),
            (&self.exempt, TellWord::Exempt),
        ];
        for (words, tell) in lists {
            for text in words.all().flat_map(|p| expanded(p, problems)) {
                tells.insert(text, tell);
            }
        }
        let list = |words: &Words| words.all().map(str::to_owned).collect();
        Aftermath {
            trace: trie(tells.keys().map(String::as_str), problems),
            tells: tells.into_values().collect(),
            subjects: list(&self.subjects),
            later: self.later.all().map(str::to_owned).collect(),
            participle: self.participle.en.clone(),
            told: self.past.en.iter().chain(&self.past_of_subject.en).cloned().collect(),
            between: list(&self.between),
            new_subject: NewSubject {
                begins: list(&self.new_subject.begins),
                breaks: list(&self.new_subject.breaks),
                own: list(&self.new_subject.own),
                behind: list(&self.new_subject.behind),
            },
            decided: list(&self.decided),
            sequel: list(&self.sequel),
            now: self.now.clone(),
            completed: CharSet::of(self.completed.zh.iter().map(String::as_str)),
        }
    }
}
