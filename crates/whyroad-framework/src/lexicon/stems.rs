//! Stems of the ego's actions (`stems` and `effects` of `schema/decision_lexicon.yaml`), for words outside all phrases.
//! Where the trace names no decision in a phrase, a stem supports one, an effect contradicts one.

use super::{Says, Words};
use serde::Deserialize;
use whyroad_model::decision::{Lateral, Longitudinal};

/// The stems of one set of decisions.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StemWords {
    says: Says,
    #[serde(default)]
    zh: Vec<String>,
    #[serde(default)]
    en: Vec<String>,
}

/// Words of one effect on the ego's motion.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EffectWords {
    #[allow(dead_code)] // read by people
    id: String,
    against: Says,
    #[serde(default)]
    goes_with: Says,
    #[serde(default)]
    zh: Vec<String>,
    #[serde(default)]
    en: Vec<String>,
}

/// An effect on the ego's motion.
#[derive(Clone, Debug)]
struct Effect {
    /// Decisions that have the opposite effect.
    against: Says,
    /// A label with one of these has the effect, regardless of its other decision.
    goes_with: Says,
    words: Vec<String>,
}

/// All stems and effects, and words that negate them.
#[derive(Clone, Debug, Default)]
pub struct Stems {
    stems: Vec<(Says, Vec<String>)>,
    effects: Vec<Effect>,
    denied: Vec<String>,
}

/// Reach of a negation: bytes of Latin letters, and of Chinese characters (3 each).
const REACH_LATIN: usize = 30;
const REACH_CHINESE: usize = 9;

impl Stems {
    pub(super) fn new(raw: &[StemWords], effects: &[EffectWords], denied: &Words) -> Self {
        let words = |w: &StemWords| w.zh.iter().chain(&w.en).cloned().collect();
        Self {
            stems: raw.iter().map(|w| (w.says.clone(), words(w))).collect(),
            effects: effects
                .iter()
                .map(|e| Effect {
                    against: e.against.clone(),
                    goes_with: e.goes_with.clone(),
                    words: e.zh.iter().chain(&e.en).cloned().collect(),
                })
                .collect(),
            denied: denied.all().map(str::to_owned).collect(),
        }
    }

    /// Bytes of a stem of one of the decisions in `clause` where every such stem is denied: "did not stop".
    pub fn denied(
        &self,
        clause: &str,
        along: Option<Longitudinal>,
        across: Option<Lateral>,
    ) -> Option<(usize, usize)> {
        let clause = clause.to_ascii_lowercase();
        let mut first: Option<(usize, usize)> = None;
        for stem in self.own(along, across) {
            for at in word_starts(&clause, stem) {
                let from = self.denial_before(&clause, at)?;
                let found = (from, at + stem.len());
                first = Some(first.map_or(found, |f| f.min(found)));
            }
        }
        first
    }

    /// Bytes of a word in `clause` whose effect contradicts one of the decisions, and fits neither.
    pub fn against(
        &self,
        clause: &str,
        along: Option<Longitudinal>,
        across: Option<Lateral>,
    ) -> Option<(usize, usize)> {
        self.against_by(clause, (along, across), &|_| true)
    }

    fn against_by(
        &self,
        clause: &str,
        (along, across): (Option<Longitudinal>, Option<Lateral>),
        holds: &dyn Fn(&&Effect) -> bool,
    ) -> Option<(usize, usize)> {
        let clause = clause.to_ascii_lowercase();
        let contradicts = |e: &&Effect| e.against.has(along, across) && !e.goes_with.has(along, across);
        let all = self.effects.iter().filter(contradicts).filter(holds);
        let found =
            all.flat_map(|e| &e.words).flat_map(|w| word_starts(&clause, w).map(|at| (at, at + w.len())));
        found.filter(|(at, _)| self.denial_before(&clause, *at).is_none()).min()
    }

    /// The same of words by which the ego speeds up.
    pub fn speeds(
        &self,
        clause: &str,
        along: Option<Longitudinal>,
        across: Option<Lateral>,
    ) -> Option<(usize, usize)> {
        let slows = |e: &&Effect| {
            e.against.has(Some(Longitudinal::YieldToAgent), None)
                && e.against.has(Some(Longitudinal::RoadSpeedAdaptation), None)
                && !e.against.has(Some(Longitudinal::Resume), None)
                && e.goes_with.has(Some(Longitudinal::AccelerationForPassing), None)
                && !e.goes_with.has(Some(Longitudinal::SetSpeedTracking), None)
        };
        self.against_by(clause, (along, across), &slows)
    }

    /// Stems of one of the decisions.
    fn own(&self, along: Option<Longitudinal>, across: Option<Lateral>) -> impl Iterator<Item = &String> {
        self.stems.iter().filter(move |(s, _)| s.has(along, across)).flat_map(|(_, words)| words)
    }

    /// Byte of a word of denial right before `at`.
    fn denial_before(&self, clause: &str, at: usize) -> Option<usize> {
        let near = |(from, word): (usize, &String)| {
            let end = from + word.len();
            let reach = if word.is_ascii() { REACH_LATIN } else { REACH_CHINESE };
            (end <= at && at - end <= reach).then_some(from)
        };
        let all = self.denied.iter().flat_map(|w| word_starts(clause, w).map(move |from| (from, w)));
        all.filter_map(near).max()
    }

    /// Byte at which `clause` has an undenied stem of one of the decisions.
    pub fn find(&self, clause: &str, along: Option<Longitudinal>, across: Option<Lateral>) -> Option<usize> {
        let clause = clause.to_ascii_lowercase();
        let own = || self.own(along, across);
        let first = own().filter_map(|w| word_starts(&clause, w).next()).min()?;
        let last = own().filter_map(|w| word_starts(&clause, w).last()).max().unwrap_or(first);
        let denied = self.denied.iter().any(|w| word_starts(&clause[..last], w).next().is_some());
        (!denied).then_some(first)
    }
}

/// Where `stem` begins in `text`: anywhere in Chinese, at the start of a word in Latin letters.
fn word_starts<'t>(text: &'t str, stem: &'t str) -> impl Iterator<Item = usize> + 't {
    let begins = |at: &usize| !stem.is_ascii() || !text[..*at].ends_with(|c: char| c.is_ascii_alphanumeric());
    text.match_indices(stem).map(|(at, _)| at).filter(begins)
}
