//! How to distinguish a clause of a trace that states or explains something from one that may decide (`undecided` of
//! `schema/label_words.yaml`).

use super::Words;
use serde::Deserialize;
use std::collections::HashSet;

/// Words of clauses without a decision, and of those that may have one.
#[derive(Clone, Debug, Default)]
pub struct Undecided {
    /// Begin a clause in Latin letters whose subject follows.
    begins: HashSet<String>,
    /// May stand before a subject of Latin letters.
    opens: HashSet<String>,
    /// Begin a clause in Latin letters that starts with a place or time.
    where_from: HashSet<String>,
    /// Verbs that state a fact.
    is: HashSet<String>,
    /// After the ego: what it is or could do, not what it does.
    could: HashSet<String>,
    /// Means by which the ego acts: as a subject, it makes the decision.
    controls: HashSet<String>,
    /// Chinese: the same.
    controls_chinese: Vec<String>,
    /// Chinese: an unnamed subject acts, which is the ego.
    acts: Vec<String>,
    /// Chinese: words that only look like one of those.
    not_acts: Vec<String>,
    /// Before the ego, where it does not act.
    behind: HashSet<String>,
    /// After "is": a property.
    degrees: HashSet<String>,
    /// Chinese: a possible consequence.
    would: Vec<String>,
    /// Chinese: begin a clause with its own subject, or state that something exists.
    there: Vec<String>,
}

/// Whether a clause may decide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClauseMood {
    /// It states a fact about something other than the ego; or a hypothetical.
    State,
    /// It continues the preceding text, or may decide.
    Open,
    /// The ego acts, or an unnamed subject.
    Acts,
}

impl Undecided {
    /// Kind of a clause. `names`: first bytes, in it, of the things it names, which act or are there.
    pub fn mood(&self, clause: &str, names: &[usize]) -> ClauseMood {
        if clause.is_ascii() { self.mood_latin(clause, names) } else { self.mood_chinese(clause, names) }
    }

    fn mood_latin(&self, clause: &str, names: &[usize]) -> ClauseMood {
        /// Maximum number of words of a subject.
        const LONGEST: usize = 9;
        let lower = clause.to_ascii_lowercase();
        let all: Vec<&str> = lower
            .split(|c: char| !c.is_ascii_alphanumeric() && c != '\'')
            .filter(|w| !w.is_empty())
            .skip_while(|w| self.opens.contains(*w))
            .collect();
        let Some(first) = all.first() else { return ClauseMood::State };
        let ego = |w: &str| ["we", "i", "ego"].contains(&w.split('\'').next().unwrap_or_default());
        let (own, _) = first.split_once('\'').unwrap_or((first, ""));
        // "Slower than ego": the object of a comparison.
        let acts = |at: usize| ego(all[at]) && (at == 0 || !self.behind.contains(all[at - 1]));
        if let Some(at) = (0..all.len()).find(|at| acts(*at)) {
            let next = match all[at].split_once('\'') {
                Some((_, "re")) => all.get(at + 1).copied().unwrap_or_default(),
                Some((_, rest)) => rest,
                None => all.get(at + 1).copied().unwrap_or_default(),
            };
            let next = if next == "are" || next == "is" {
                all.get(at + 2).copied().unwrap_or_default()
            } else {
                next
            };
            // "Come down to a speed that we could stop from": the action comes first.
            let subject = at == 0
                || !names.is_empty()
                || all[..at].iter().any(|w| self.begins.contains(*w)) && self.begins.contains(*first);
            return match self.could.contains(next) {
                true if subject || self.where_from.contains(*first) => ClauseMood::State,
                true => ClauseMood::Open,
                false => ClauseMood::Acts,
            };
        }
        // "18 m out", "which is just big enough".
        let which = || {
            let mut words = lower.split_whitespace();
            words.next() == Some("which") && words.next().is_some_and(|w| self.is.contains(w))
        };
        if first.starts_with(|c: char| c.is_ascii_digit()) || which() {
            return ClauseMood::State;
        }
        let controls = |part: &[&str]| part.iter().any(|w| self.controls.contains(*w));
        let named = names.first().is_some_and(|at| *at < lower.len() / 2);
        let is_verb = |w: &&str| self.is.contains(*w) || w.contains("'s") || w.contains("'re");
        let Some(verb) = all.iter().take(LONGEST).position(is_verb) else {
            // "The road disappears over the crest": the subject is not the ego.
            let thing = ["the", "a", "an"].contains(first) && !controls(&all[..all.len().min(LONGEST)]);
            return if thing { ClauseMood::State } else { ClauseMood::Open };
        };
        // "The speed is too high".
        if all.get(verb + 1).is_some_and(|w| self.degrees.contains(*w)) {
            return ClauseMood::State;
        }
        // "That's us away", "it's the brakes".
        let points = ["it", "that"].contains(&own) && verb == 0;
        if points || controls(&all[..=verb]) && !self.where_from.contains(own) {
            return ClauseMood::Acts;
        }
        let begins = self.begins.contains(own) || self.where_from.contains(own) || named;
        if begins { ClauseMood::State } else { ClauseMood::Open }
    }

    fn mood_chinese(&self, clause: &str, names: &[usize]) -> ClauseMood {
        /// Bytes of words that may precede the subject.
        const NEAR: usize = 18;
        let clause = clause.trim_start();
        let mut bare = clause.to_owned();
        for word in &self.not_acts {
            bare = bare.replace(word.as_str(), "□");
        }
        if self.acts.iter().any(|w| bare.contains(w.as_str())) {
            return ClauseMood::Acts;
        }
        if self.would.iter().any(|w| clause.contains(w.as_str())) {
            return ClauseMood::State;
        }
        if self.controls_chinese.iter().any(|w| clause.contains(w.as_str())) {
            return ClauseMood::Acts;
        }
        let begins = self.there.iter().any(|w| clause.starts_with(w.as_str()));
        if begins || names.first().is_some_and(|at| *at <= NEAR) {
            ClauseMood::State
        } else {
            ClauseMood::Open
        }
    }
}

/// The lists as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawUndecided {
    begins: Words,
    opens: Words,
    where_from: Words,
    is: Words,
    could: Words,
    controls: Words,
    acts: Words,
    not_acts: Words,
    behind: Words,
    degrees: Words,
    would: Words,
    there: Words,
}

impl RawUndecided {
    pub(super) fn compile(&self) -> Undecided {
        let set = |w: &Words| w.en.iter().cloned().collect();
        Undecided {
            begins: set(&self.begins),
            opens: set(&self.opens),
            where_from: set(&self.where_from),
            is: set(&self.is),
            could: set(&self.could),
            controls: set(&self.controls),
            controls_chinese: self.controls.zh.clone(),
            acts: self.acts.zh.clone(),
            not_acts: self.not_acts.zh.clone(),
            behind: set(&self.behind),
            degrees: set(&self.degrees),
            would: self.would.zh.clone(),
            there: self.there.zh.clone(),
        }
    }
}
