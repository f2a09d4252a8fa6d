//! The words in which a trace names decisions, in both languages (`schema/decision_lexicon.yaml`, which documents each
//! list), compiled to one search. The meaning of a trace is judged in [`super::trace`].

mod compile;
pub(crate) mod expand;
mod stems;
pub(crate) mod trie;
pub mod units;

pub use compile::{Hit, Role};
pub use stems::Stems;

use crate::phrases::Phrases;
use crate::yaml_text;
use serde::Deserialize;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::{Bilingual, Diagnostic};

/// Words for decisions, for negation, and for subjects and actions.
#[derive(Clone, Debug, Default)]
pub struct Lexicon {
    /// Bounds of length, numbers and reach.
    pub limits: Limits,
    /// Decisions that a trace may name although the label's channel is null.
    pub null_allows: Says,
    /// Meaning of each phrase, by its index.
    pub phrases: Vec<Says>,
    /// Beginnings of words that support a decision which no phrase states.
    pub stems: Stems,
    /// Words after a decision that mark it as finished, in Chinese.
    pub behind_decision: Vec<String>,
    /// Words between two phrases that are both negated.
    pub joined: Vec<String>,
    /// Words for the ego after a decision marker.
    pub pronouns: Vec<String>,
    /// Words before the road user that is given way.
    pub gives_way: Vec<String>,
    /// Before a name of the ego: something moves there.
    pub towards_ego: Vec<String>,
    /// After a name of the ego: its lane, or a place near it.
    pub of_ego: Vec<String>,
    /// Directly after a phrase in Chinese: a possibility, not a fact.
    pub can: Vec<String>,
    /// After a name of the ego: the topic of the text.
    pub meant: Vec<String>,
    /// Beginnings of the name of the road user that is given way.
    pub given_way: Vec<String>,
    /// After a phrase in Chinese: a possible consequence.
    pub consequence: Vec<String>,
    /// Actions of the ego besides driving, in lower case.
    pub beside_driving: Phrases,
    /// Those of the words for later events that introduce another action of the ego.
    then: Vec<String>,
    /// Words that negate what the ego does, rather than what it can or must do; in lower case.
    refuses: Vec<String>,
    trie: trie::Trie,
    /// By word number of the trie. Empty in an empty lexicon, which finds nothing.
    pub patterns: Vec<compile::Pattern>,
}

/// Bounds of a trace's form (LABELING.md 7) and of a negation's reach.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Length of a word of Latin letters, in Chinese characters.
    pub latin_word_counts_as: usize,
    /// A shorter trace is an error, in characters as defined by [`Self::latin_word`].
    pub too_short_below: usize,
    /// A longer trace is a warning; 0 switches it off.
    pub too_long_above: usize,
    /// More numbers than this are a warning.
    pub numbers_above: usize,
    /// Bytes.
    pub negation_reach: usize,
    /// Bytes.
    pub adjacent_reach: usize,
    /// Bytes of Chinese, back to the phrase before.
    pub behind_reach: usize,
}

/// The decisions that fit a phrase, by channel.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Says {
    /// Longitudinal decisions that it can mean.
    #[serde(default)]
    pub longitudinal: Vec<Longitudinal>,
    /// Lateral decisions that it can mean.
    #[serde(default)]
    pub lateral: Vec<Lateral>,
    /// Too vague to contradict a label.
    #[serde(skip)]
    pub supports_only: bool,
    /// A change of motion: contradicts a null decision of its channel.
    #[serde(skip)]
    pub change: bool,
    /// Decisions that are ruled out when this is negated.
    #[serde(skip)]
    pub denies: Vec<Longitudinal>,
    /// Its effect on the ego's speed, for any decision.
    #[serde(skip)]
    pub speed: Option<SaidSpeed>,
}

impl Says {
    /// True when it names one of the two.
    pub fn has(&self, along: Option<Longitudinal>, across: Option<Lateral>) -> bool {
        along.is_some_and(|d| self.longitudinal.contains(&d))
            || across.is_some_and(|d| self.lateral.contains(&d))
    }
}

/// Effect of a phrase on the ego's speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SaidSpeed {
    /// It becomes higher.
    Faster,
    /// It becomes lower.
    Slower,
    /// The ego comes to stand.
    Stops,
}

/// One list of patterns in both languages.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Words {
    #[serde(default)]
    zh: Vec<String>,
    #[serde(default)]
    en: Vec<String>,
}

impl Words {
    fn all(&self) -> impl Iterator<Item = &str> {
        self.zh.iter().chain(&self.en).map(String::as_str)
    }
}

/// The file as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[allow(dead_code)] // read by people and by the framework's version check
    version: String,
    limits: Limits,
    null_allows: Says,
    sides: Sides,
    words: RoleWords,
    phrases: Vec<PhraseWords>,
    #[serde(default)]
    stems: Vec<stems::StemWords>,
    #[serde(default)]
    effects: Vec<stems::EffectWords>,
    #[serde(default)]
    behind_decision: Words,
    #[serde(default)]
    stem_denied: Words,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sides {
    left: Words,
    right: Words,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RoleWords {
    sentence_end: Words,
    clause_end: Words,
    permits: Words,
    decision_marker: Words,
    duty: Words,
    reason: Words,
    hypothesis: Words,
    intention: Words,
    sequel: Words,
    negation: Words,
    negation_adjacent: Words,
    negation_end: Words,
    refuses: Words,
    consequence: Words,
    #[serde(default)]
    then: Words,
    #[serde(default)]
    beside_driving: Words,
    towards_ego: Words,
    of_ego: Words,
    meant: Words,
    can: Words,
    joined: Words,
    pronoun: Words,
    given_way: Words,
    gives_way: Words,
    ego: Words,
    agent: Words,
    object_of: Words,
    neutral: Words,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PhraseWords {
    says: Says,
    #[serde(default)]
    side: Option<LateralDirection>,
    #[serde(default)]
    supports_only: bool,
    #[serde(default)]
    change: bool,
    #[serde(default)]
    denies: Vec<Longitudinal>,
    #[serde(default)]
    speed: Option<SaidSpeed>,
    #[serde(default)]
    zh: Vec<String>,
    #[serde(default)]
    en: Vec<String>,
}

impl Lexicon {
    /// The name of the ego at `start..end` of `text` describes the position or motion of something else: "towards our
    /// lane".
    pub fn is_place_of_ego(&self, text: &str, start: usize, end: usize) -> bool {
        let (before, behind) = (text[..start].trim_end(), &text[end..]);
        self.towards_ego.iter().any(|w| before.ends_with(w.as_str()))
            && self.of_ego.iter().any(|w| behind.starts_with(w.as_str()))
    }

    /// `word`, which marks something as later, introduces another action of the ego.
    pub fn introduces_another(&self, word: &str) -> bool {
        self.then.iter().any(|w| w.eq_ignore_ascii_case(word))
    }

    /// A negation, in upper or lower case, negates what the ego does, not what it can or must do.
    pub fn refuses(&self, word: &str) -> bool {
        self.refuses.iter().any(|w| w.eq_ignore_ascii_case(word))
    }

    /// The words after a name of the ego state the topic.
    pub fn is_meant(&self, follows: &str) -> bool {
        self.meant.iter().any(|w| follows.starts_with(w.as_str()))
    }

    /// From the text of `schema/decision_lexicon.yaml`; `file` is named in diagnostics. `road_users`: words for road
    /// users, who act where the lexicon gives the word no other role. An unreadable file gives an empty lexicon, with
    /// which traces are checked for form only.
    pub fn parse(file: &str, text: &str, road_users: &[String]) -> (Lexicon, Vec<Diagnostic>) {
        let what = Bilingual::new("词表", "the lexicon");
        let raw: File = match yaml_text::read("lexicon.syntax", file, text, what) {
            Ok((raw, _)) => raw,
            Err(finding) => return (Lexicon::default(), vec![*finding]),
        };
        let (lexicon, problems) = compile::compile(&raw, road_users);
        let diagnostics = problems
            .into_iter()
            .map(|message| Diagnostic::error("lexicon.pattern", message).in_file(file))
            .collect();
        (lexicon, diagnostics)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lexicon_of_this_repository_has_no_problems() {
        let text = include_str!("../../../schema/decision_lexicon.yaml");
        let (lexicon, diagnostics) = Lexicon::parse("schema/decision_lexicon.yaml", text, &[]);
        assert!(diagnostics.is_empty(), "{diagnostics:#?}");
        for d in Longitudinal::ALL {
            assert!(lexicon.phrases.iter().any(|p| !p.supports_only && p.longitudinal.contains(d)), "{d}");
        }
        for d in Lateral::ALL {
            assert!(lexicon.phrases.iter().any(|p| !p.supports_only && p.lateral.contains(d)), "{d}");
        }
    }

    #[test]
    fn a_broken_lexicon_is_reported() {
        let text = include_str!("../../../schema/decision_lexicon.yaml");
        let (empty, d) = Lexicon::parse("x.yaml", &text.replace("negation_end:", "negation_stop:"), &[]);
        assert!(empty.patterns.is_empty());
        assert_eq!(
            (d.len(), d[0].code, d[0].location.file.as_deref()),
            (1, "lexicon.syntax", Some("x.yaml"))
        );
        // The same word for two decisions, and a choice that is never closed.
        let (_, d) = Lexicon::parse("x.yaml", &text.replace("汇入主路, 汇入主线", "汇入主路, 变道"), &[]);
        assert!(d.len() == 1 && d[0].code == "lexicon.pattern" && d[0].message.en.contains("变道"), "{d:?}");
        let (_, d) = Lexicon::parse("x.yaml", &text.replace("汇入主路, 汇入主线", "\"(a|b\""), &[]);
        assert!(d.len() == 1 && d[0].message.en.contains("(a|b"), "{d:?}");
    }
}
