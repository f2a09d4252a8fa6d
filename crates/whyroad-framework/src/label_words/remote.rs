//! Things far from the moment of a decision, in time or on the road (`remote` of `schema/label_words.yaml`): a date, a
//! span of days or years, kilometers, the junction after the next. Recognized by form, not by a list of phrases.

use super::{CharSet, Words};
use serde::Deserialize;
use std::collections::HashSet;

/// Words for far times and distances.
#[derive(Clone, Debug, Default)]
pub struct Remote {
    /// By themselves.
    dates: HashSet<String>,
    dates_chinese: Vec<String>,
    /// After one of `which`.
    spans: HashSet<String>,
    which: HashSet<String>,
    /// After a span.
    ago: HashSet<String>,
    ago_chinese: Vec<String>,
    spans_chinese: Vec<String>,
    /// Long units, and words that turn one into a speed.
    lengths: HashSet<String>,
    lengths_chinese: Vec<String>,
    per: HashSet<String>,
    /// Counted on the way to something.
    stages: HashSet<String>,
    stages_chinese: Vec<String>,
    /// After the counted thing.
    on: HashSet<String>,
    on_chinese: Vec<String>,
    /// Before the counted thing, in Chinese.
    onward: Vec<String>,
    /// Before a length, the same.
    ahead: Vec<String>,
    /// After a length, in Chinese: the thing at that distance.
    of_chinese: Vec<String>,
    digits: CharSet,
    number: HashSet<String>,
}

impl Remote {
    /// Bytes of the first time or distance of `text` that is far.
    pub fn find(&self, text: &str) -> Option<(usize, usize)> {
        if text.is_ascii() { self.find_latin(text) } else { self.find_chinese(text) }
    }

    fn find_latin(&self, text: &str) -> Option<(usize, usize)> {
        let lower = text.to_ascii_lowercase();
        let mut all: Vec<(usize, &str)> = Vec::new();
        let mut from = 0;
        for word in lower.split(|c: char| !c.is_ascii_alphanumeric() && c != '.') {
            let bare = word.trim_matches('.');
            if !bare.is_empty() {
                all.push((from, bare));
            }
            from += word.len() + 1;
        }
        let word = |i: usize| all.get(i).map_or("", |w| w.1);
        let is_number =
            |i: usize| word(i).starts_with(|c: char| c.is_ascii_digit()) || self.number.contains(word(i));
        // "A" counts only the following thing.
        let counted =
            |i: usize| (i.saturating_sub(4)..i).any(|k| is_number(k) && (word(k) != "a" || k + 1 == i));
        // "The next three kilometers": the length of something.
        let extends = |i: usize| (i.saturating_sub(4)..i).any(|k| ["next", "over", "for"].contains(&word(k)));
        // "The junction on the right" is near.
        let placed = |i: usize| word(i + 1) == "on" && ["the", "our", "ego"].contains(&word(i + 2));
        let is_year = |i: usize| {
            let w = word(i);
            w.len() == 4
                && (w.starts_with("19") || w.starts_with("20"))
                && w.bytes().all(|b| b.is_ascii_digit())
        };
        let i = (0..all.len()).find(|&i| {
            let (before, w, next) = (if i > 0 { word(i - 1) } else { "" }, word(i), word(i + 1));
            self.dates.contains(w)
                || is_year(i) && ["in", "since", "of"].contains(&before)
                || self.spans.contains(w) && (self.which.contains(before) || self.ago.contains(next))
                || self.lengths.contains(w) && counted(i) && !self.per.contains(next) && !extends(i)
                || self.stages.contains(w) && counted(i) && self.on.contains(next) && !placed(i)
                || self.stages.contains(w) && next == "after" && word(i + 2) == "next"
                || ["further", "farther"].contains(&w) && ["on", "up"].contains(&next) && counted(i)
        })?;
        Some((all[i].0, all[i].0 + all[i].1.len()))
    }

    fn find_chinese(&self, text: &str) -> Option<(usize, usize)> {
        let is_number = |c: char| c.is_ascii_digit() || self.digits.contains(c);
        let counted = |at: usize| text[..at].trim_end().ends_with(is_number);
        let begins = |at: usize, all: &[String]| all.iter().any(|w| text[at..].starts_with(w.as_str()));
        let find = |all: &[String], holds: &dyn Fn(usize, usize) -> bool| {
            let hits = all.iter().flat_map(|w| text.match_indices(w.as_str()));
            hits.map(|(at, w)| (at, at + w.len())).filter(|(at, end)| holds(*at, *end)).min()
        };
        let date = find(&self.dates_chinese, &|_, _| true);
        let span = || find(&self.spans_chinese, &|at, end| counted(at) && begins(end, &self.ago_chinese));
        let behind = |all: &[String], from: usize, at: usize| {
            let before = text[from..at].trim_end().trim_end_matches(is_number);
            all.iter().any(|w| before.ends_with(w.as_str()))
        };
        // Most kilometers belong to a speed.
        let away = |at: usize, end: usize| {
            let from = text[..at].rfind(['，', '。', '；']).unwrap_or(0);
            begins(end, &self.on_chinese)
                || text[from..at].contains("还有")
                || begins(end, &self.of_chinese)
                    && (behind(&self.ahead, from, at) || behind(&self.onward, from, at))
        };
        let length = || find(&self.lengths_chinese, &|at, end| counted(at) && away(at, end));
        // "两个路口外", "再往前两个路口", "隔着三个街口".
        let stage = || {
            find(&self.stages_chinese, &|at, end| {
                let is_far = begins(end, &self.on_chinese) || behind(&self.onward, 0, at);
                counted(at) && is_far && !text[..at].ends_with('一')
            })
        };
        date.or_else(span).or_else(length).or_else(stage)
    }
}

/// The lists as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRemote {
    dates: Words,
    which: Words,
    spans: Words,
    ago: Words,
    lengths: Words,
    per: Words,
    stages: Words,
    far: Words,
    onward: Words,
    ahead: Words,
    of: Words,
    number: Words,
}

impl RawRemote {
    pub(super) fn compile(&self) -> Remote {
        let set = |w: &Words| w.en.iter().cloned().collect();
        Remote {
            dates: set(&self.dates),
            dates_chinese: self.dates.zh.clone(),
            spans: set(&self.spans),
            spans_chinese: self.spans.zh.clone(),
            which: set(&self.which),
            ago: set(&self.ago),
            ago_chinese: self.ago.zh.clone(),
            lengths: set(&self.lengths),
            lengths_chinese: self.lengths.zh.clone(),
            per: set(&self.per),
            stages: set(&self.stages),
            stages_chinese: self.stages.zh.clone(),
            on: set(&self.far),
            on_chinese: self.far.zh.clone(),
            onward: self.onward.zh.clone(),
            ahead: self.ahead.zh.clone(),
            of_chinese: self.of.zh.clone(),
            digits: CharSet::of(self.number.zh.iter().map(String::as_str)),
            number: set(&self.number),
        }
    }
}
