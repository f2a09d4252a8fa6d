//! From word lists to one search: leftmost, longest match, so that a longer word always hides the shorter ones
//! inside it.

use super::expand::{Plain, expand};
use super::trie::Trie;
use super::units::Units;
use super::{File, Lexicon, Says};
use crate::phrases::Phrases;
use std::collections::BTreeMap;
use std::ops::Range;
use whyroad_model::Bilingual;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};

/// Role of a word in a sentence. The lexicon file explains each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Ends a sentence.
    SentenceEnd,
    /// Ends a clause.
    ClauseEnd,
    /// Introduces the decision, such as "therefore".
    DecisionMarker,
    /// States that an action is required, such as "must".
    Duty,
    /// Introduces a reason, such as "because".
    Reason,
    /// Introduces a condition, such as "if".
    Hypothesis,
    /// States an intention.
    Intention,
    /// Introduces a later event, such as "then".
    Sequel,
    /// Negates a phrase near it.
    Negation,
    /// Negates only what directly follows it.
    NegationAdjacent,
    /// Ends the reach of a negation.
    NegationEnd,
    /// Names the ego.
    Ego,
    /// Names another road user.
    Agent,
    /// Makes the next noun an object.
    ObjectOf,
    /// Assigns the following action to another road user, such as "allows".
    Permits,
    /// Hides the words inside it.
    Neutral,
    /// The identifier of a decision, which does not belong in a trace.
    DecisionId,
    /// Names a decision: index into the lexicon's phrases.
    Phrase(usize),
}

/// A word with its role, and its side where it has one.
#[derive(Clone, Copy, Debug)]
pub struct Pattern {
    /// Its role.
    pub role: Role,
    /// Its side, where it has one.
    pub side: Option<LateralDirection>,
}

/// A word found in a text.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Its role.
    pub role: Role,
    /// Its side, where it has one.
    pub side: Option<LateralDirection>,
    /// First byte in the text.
    pub start: usize,
    /// One past its last byte.
    pub end: usize,
}

impl Lexicon {
    /// Passes the words of a part of a text to `take` in order, never overlapping. The part begins and ends between
    /// units.
    pub fn hits(&self, units: &Units, bytes: Range<usize>, mut take: impl FnMut(Hit)) {
        self.trie.find_in(units, bytes, |f| {
            let p = &self.patterns[f.word];
            take(Hit { role: p.role, side: p.side, start: f.start, end: f.end });
        });
    }
}

/// The lexicon, and the errors in the file's patterns.
pub fn compile(raw: &File, road_users: &[String]) -> (Lexicon, Vec<Bilingual>) {
    let mut builder = Builder { raw, texts: BTreeMap::new(), problems: Vec::new() };
    let w = &raw.words;
    for (role, words) in [
        (Role::SentenceEnd, &w.sentence_end),
        (Role::ClauseEnd, &w.clause_end),
        (Role::DecisionMarker, &w.decision_marker),
        (Role::Duty, &w.duty),
        (Role::Reason, &w.reason),
        (Role::Hypothesis, &w.hypothesis),
        (Role::Intention, &w.intention),
        (Role::Sequel, &w.sequel),
        (Role::Negation, &w.negation),
        (Role::NegationAdjacent, &w.negation_adjacent),
        (Role::NegationEnd, &w.negation_end),
        (Role::Ego, &w.ego),
        (Role::Agent, &w.agent),
        (Role::ObjectOf, &w.object_of),
        (Role::Permits, &w.permits),
        (Role::Neutral, &w.neutral),
    ] {
        for pattern in words.all() {
            builder.add(pattern, role, None);
        }
    }
    let mut phrases = Vec::new();
    for (i, p) in raw.phrases.iter().enumerate() {
        phrases.push(Says {
            supports_only: p.supports_only,
            change: p.change,
            denies: p.denies.clone(),
            speed: p.speed,
            ..p.says.clone()
        });
        for pattern in p.zh.iter().chain(&p.en) {
            builder.add(pattern, Role::Phrase(i), p.side);
        }
    }
    // Ids of one word (`turn`, `resume`) are plain English and not evidence of a copied id.
    let ids = Longitudinal::ALL.iter().map(|d| d.id()).chain(Lateral::ALL.iter().map(|d| d.id()));
    for id in ids.filter(|id| id.contains('_')) {
        builder.add(id, Role::DecisionId, None);
    }

    for word in road_users {
        builder.texts.entry(word.clone()).or_insert((Role::Agent, None));
    }

    let Builder { texts, mut problems, .. } = builder;
    // A map's keys are sorted and different, as the trie requires.
    let trie = Trie::new(texts.keys().map(String::as_str)).unwrap_or_else(|| {
        problems.push(Bilingual::new(
            "词表过大，或含有基本多文种平面之外的字",
            "the lexicon is too large, or has characters outside the basic plane",
        ));
        Trie::default()
    });
    let patterns: Vec<Pattern> =
        texts.values().map(|(role, side)| Pattern { role: *role, side: *side }).collect();
    let list = |words: &super::Words| words.all().map(str::to_owned).collect();
    let lexicon = Lexicon {
        limits: raw.limits,
        null_allows: raw.null_allows.clone(),
        phrases,
        stems: super::Stems::new(&raw.stems, &raw.effects, &raw.stem_denied),
        behind_decision: list(&raw.behind_decision),
        joined: list(&w.joined),
        pronouns: list(&w.pronoun),
        gives_way: list(&w.gives_way),
        given_way: list(&w.given_way),
        refuses: list(&w.refuses),
        consequence: list(&w.consequence),
        then: list(&w.then),
        beside_driving: Phrases::new(
            w.beside_driving
                .all()
                .filter_map(super::expand::choices)
                .flatten()
                .map(|t| t.to_lowercase())
                .collect(),
        ),
        towards_ego: list(&w.towards_ego),
        of_ego: list(&w.of_ego),
        meant: list(&w.meant),
        can: list(&w.can),
        trie,
        patterns,
    };
    (lexicon, problems)
}

struct Builder<'f> {
    raw: &'f File,
    texts: BTreeMap<String, (Role, Option<LateralDirection>)>,
    problems: Vec<Bilingual>,
}

impl Builder<'_> {
    fn add(&mut self, pattern: &str, role: Role, side: Option<LateralDirection>) {
        let Some(plains) = expand(pattern, &self.raw.sides) else {
            self.problems.push(Bilingual::new(
                format!("模式 '{pattern}' 的括号不成对"),
                format!("pattern '{pattern}' has a bracket that is not closed"),
            ));
            return;
        };
        for Plain { text, side: own } in plains {
            let meaning = (role, side.or(own));
            let text = text.to_lowercase();
            match self.texts.get(&text) {
                Some(other) if *other != meaning => self.problems.push(Bilingual::new(
                    format!("'{text}' 在词表中有两种含义"),
                    format!("'{text}' has two meanings in the lexicon"),
                )),
                _ => {
                    self.texts.insert(text, meaning);
                }
            }
        }
    }
}
