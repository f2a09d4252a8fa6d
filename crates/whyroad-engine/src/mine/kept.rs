//! Results of each rule on a drive, kept beside it in the lake: a rule that has not changed is not run again. A rule is
//! identified by a hash of all its parts, so no change of a text, a parameter or an inherited part is missed.

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;
use std::collections::BTreeMap;
use whyroad_mining::episode::{Episode, Found, Rank};
use whyroad_mining::rule::Rule;
use whyroad_model::messages::{EgoResponse, KeyframeType, MatchedCondition};
use whyroad_model::{Bilingual, FrameRange, ScenarioId, TrackId};

/// Name of the file beside the drive.
pub const FILE: &str = "found.json";

/// Rules of former runs that are kept beside those of the present one (single questions vary).
const FORMER: usize = 1000;

/// Kept results of a drive.
#[derive(Debug, Default)]
pub struct Kept {
    /// Hash of the drive's content, its signals and the evaluation code.
    of: String,
    /// By the hash of the rule.
    rules: BTreeMap<String, KeptFound>,
}

/// The file. In a short drive nearly all rules find nothing, many for lack of the same signals: they are listed
/// together.
#[derive(Debug, Default, Serialize, Deserialize)]
struct File {
    of: String,
    /// Rules that found something; of files of earlier versions, all.
    rules: BTreeMap<String, KeptFound>,
    /// Rules that found nothing, by the signals for lack of which they could not be decided.
    #[serde(default)]
    nothing: Vec<(Vec<String>, Vec<String>)>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct KeptFound {
    episodes: Vec<KeptEpisode>,
    missing: Vec<String>,
}

/// A kept episode; numbers by their bits, so that reading returns exactly what was written.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct KeptEpisode {
    scenario: ScenarioId,
    target: Option<TrackId>,
    roles: BTreeMap<String, TrackId>,
    matched: (usize, usize),
    kind: KeyframeType,
    keyframe: usize,
    second_keyframe: Option<usize>,
    range: (usize, usize),
    context: (usize, usize),
    keyframe_rule: Bilingual,
    response: EgoResponse,
    score: u64,
    conditions: Vec<(String, KeptValue)>,
    signals: Vec<String>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
enum KeptValue {
    Number(u64),
    Other(Json),
}

/// The hash of a rule.
pub fn key(rule: &Rule) -> String {
    blake3::hash(&rule.content()).to_hex()[..32].to_owned()
}

/// Dependencies of results besides the rule.
pub fn state(content_hash: &str) -> String {
    format!("{content_hash} {} {}", whyroad_signals::VERSION, whyroad_mining::VERSION)
}

impl Kept {
    /// Reads the kept results; nothing where they are outdated or unreadable.
    pub fn parse(content: Option<Vec<u8>>, state: &str) -> Self {
        let file = content.and_then(|c| serde_json::from_slice::<File>(&c).ok());
        let Some(file) = file.filter(|f| f.of == state) else {
            return Self { of: state.to_owned(), ..Self::default() };
        };
        let mut rules = file.rules;
        for (missing, keys) in file.nothing {
            let found = KeptFound { episodes: vec![], missing };
            rules.extend(keys.into_iter().map(|key| (key, found.clone())));
        }
        Self { of: file.of, rules }
    }

    /// Results of the rule with this key; `None` where it has not been run.
    pub fn get(&self, key: &str, rule: &Rule) -> Option<Found> {
        let kept = self.rules.get(key)?;
        let episodes = kept.episodes.iter().map(|e| e.read(rule)).collect();
        Some(Found { episodes, missing: kept.missing.iter().cloned().collect() })
    }

    /// Keeps the results of a rule.
    pub fn put(&mut self, key: String, found: &Found) {
        let episodes = found.episodes.iter().map(KeptEpisode::of).collect();
        self.rules.insert(key, KeptFound { episodes, missing: found.missing.iter().cloned().collect() });
    }

    /// The file's content. Excess former rules are dropped.
    pub fn content(mut self, present: &[String]) -> Vec<u8> {
        if self.rules.len() > present.len() + FORMER {
            self.rules.retain(|key, _| present.contains(key));
        }
        let mut file = File { of: self.of, ..File::default() };
        let mut nothing = BTreeMap::<Vec<String>, Vec<String>>::new();
        for (key, found) in self.rules {
            if found.episodes.is_empty() {
                nothing.entry(found.missing).or_default().push(key);
            } else {
                file.rules.insert(key, found);
            }
        }
        file.nothing = nothing.into_iter().collect();
        // Strings, numbers and lists of them always become JSON.
        serde_json::to_vec(&file).unwrap_or_default()
    }
}

fn pair(range: FrameRange) -> (usize, usize) {
    (range.start, range.end)
}

impl KeptEpisode {
    fn of(e: &Episode) -> Self {
        let value = |v: &Json| match v.as_f64() {
            Some(x) if v.is_f64() => KeptValue::Number(x.to_bits()),
            _ => KeptValue::Other(v.clone()),
        };
        Self {
            scenario: e.scenario.clone(),
            target: e.target.clone(),
            roles: e.roles.clone(),
            matched: pair(e.matched),
            kind: e.kind,
            keyframe: e.keyframe,
            second_keyframe: e.second_keyframe,
            range: pair(e.range),
            context: pair(e.context),
            keyframe_rule: e.keyframe_rule.clone(),
            response: e.response,
            score: e.score.to_bits(),
            conditions: e.conditions.iter().map(|c| (c.condition.clone(), value(&c.actual_value))).collect(),
            signals: e.signals.clone(),
        }
    }

    fn read(&self, rule: &Rule) -> Episode {
        let range = |(start, end): (usize, usize)| FrameRange::new(start, end);
        let value = |v: &KeptValue| match v {
            KeptValue::Number(bits) => Json::from(f64::from_bits(*bits)),
            KeptValue::Other(v) => v.clone(),
        };
        let condition = |(text, v): &(String, KeptValue)| match rule.atoms.iter().find(|a| a.text == *text) {
            Some(atom) => atom.matched(value(v)),
            None => MatchedCondition {
                condition: text.clone(),
                actual_value: value(v),
                description: None,
                actual_words: None,
            },
        };
        Episode {
            scenario: self.scenario.clone(),
            target: self.target.clone(),
            roles: self.roles.clone(),
            matched: range(self.matched),
            kind: self.kind,
            keyframe: self.keyframe,
            second_keyframe: self.second_keyframe,
            range: range(self.range),
            context: range(self.context),
            keyframe_rule: self.keyframe_rule.clone(),
            response: self.response,
            score: f64::from_bits(self.score),
            share: None,
            conditions: self.conditions.iter().map(condition).collect(),
            signals: self.signals.clone(),
            rank: Rank::Primary,
        }
    }
}
