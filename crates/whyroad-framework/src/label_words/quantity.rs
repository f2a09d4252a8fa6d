//! Numbers with a unit in a text (`quantities` of `schema/label_words.yaml`), in digits or in words: "四百米", "400 m",
//! "forty meters".

use super::{CharSet, Words};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Words of numbers and units.
#[derive(Clone, Debug, Default)]
pub struct Quantities {
    /// Unit of a record, word, and factor from the word to the unit.
    units: Vec<(String, String, f64)>,
    numbers: BTreeMap<String, f64>,
    /// After a distance to something.
    away: Vec<String>,
    /// Record id and the words next to which a text states it.
    pub beside: BTreeMap<String, Vec<String>>,
}

/// A number with a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// In the requested unit.
    pub value: f64,
    /// First byte in the text.
    pub start: usize,
    /// One past the last byte of its unit.
    pub end: usize,
    /// Stated as approximate.
    pub is_rough: bool,
}

impl Quantity {
    /// The two count as equal: people round.
    pub fn is_about(&self, other: &Quantity) -> bool {
        let part = if self.is_rough || other.is_rough { 0.3 } else { 0.12 };
        (self.value - other.value).abs() <= part * self.value.max(other.value) + 0.6
    }
}

impl Quantities {
    /// The quantities of `text` in `unit`, except distances to something.
    pub fn find(&self, text: &str, unit: &str) -> Vec<Quantity> {
        self.of_unit(text, unit, false)
    }

    /// The lengths and distances of `text`, in meters.
    pub fn lengths(&self, text: &str) -> Vec<Quantity> {
        self.of_unit(text, "m", true)
    }

    /// Every number of `text` from two on, with or without a unit. A single Chinese numeral needs a unit or one of
    /// `counters` behind it.
    pub fn all(&self, text: &str, counters: &CharSet) -> Vec<Quantity> {
        const LEAST: f64 = 2.0;
        let lower = text.to_ascii_lowercase();
        let mut out = Vec::new();
        let mut at = 0;
        while let Some(c) = lower[at..].chars().next() {
            let start = at;
            let is_numeral =
                |c: char| !c.is_ascii() && self.numbers.contains_key(c.encode_utf8(&mut [0; 4]) as &str);
            let run = |holds: &dyn Fn(char) -> bool| {
                lower[start..].find(|c: char| !holds(c)).map_or(lower.len(), |n| start + n)
            };
            let mut add = |value: Option<f64>, start: usize, end: usize| {
                let is_rough = lower[end..].starts_with(['多', '来', '余', '几']);
                out.extend(value.filter(|v| *v >= LEAST).map(|value| Quantity {
                    value,
                    start,
                    end,
                    is_rough,
                }));
            };
            if c.is_ascii_alphanumeric() {
                at = run(&|c| c.is_ascii_alphanumeric() || c == '-' || c == '.');
                let word = lower[start..at].trim_end_matches(['.', '-']);
                let digits = word.trim_end_matches(|c: char| c.is_ascii_alphabetic() || c == '-');
                let is_number = |w: &str| self.numbers.contains_key(w);
                if !digits.is_empty() {
                    add(digits.parse().ok(), start, start + digits.len());
                } else if word.rsplit('-').next().is_some_and(is_number) {
                    // "Two hundred" ends with its last word.
                    let next = lower[at..].trim_start().split(|c: char| !c.is_ascii_alphabetic()).next();
                    let end = start + word.len();
                    if let (Some((value, from)), false) =
                        (self.number_before(&lower, end), next.is_some_and(is_number))
                    {
                        add(Some(value), from, end);
                    }
                }
            } else if is_numeral(c) {
                at = run(&is_numeral);
                let behind = &lower[at..];
                let counts = self.units.iter().any(|(_, word, _)| behind.starts_with(word.as_str()));
                let single = lower[start..at].chars().count() == 1;
                if !single || counts || behind.starts_with(|c| counters.contains(c)) {
                    add(self.chinese(&lower[start..at]), start, at);
                }
            } else {
                at += c.len_utf8();
            }
        }
        out
    }

    /// `away`: also distances to something.
    fn of_unit(&self, text: &str, unit: &str, away: bool) -> Vec<Quantity> {
        let lower = text.to_ascii_lowercase();
        let mut out: Vec<(Quantity, usize)> = Vec::new();
        let own = self.units.iter().filter(|(of, ..)| of == unit);
        for (_, word, factor) in own {
            for (at, _) in lower.match_indices(word.as_str()) {
                let end = at + word.len();
                let letter = |c: char| c.is_ascii_alphabetic() || c == '/' || c == '²';
                // "m" of "mph", "公里" of "公里/小时".
                if lower[end..].starts_with(letter) || lower[end..].starts_with("每小时") {
                    continue;
                }
                // "20 m ahead": where something is.
                if !away && self.away.iter().any(|w| lower[end..].trim_start().starts_with(w.as_str())) {
                    continue;
                }
                if let Some((value, start)) = self.number_before(&lower, at) {
                    // "三米六".
                    let tenths = lower[end..].chars().next().filter(|c| !c.is_ascii());
                    let tenths = tenths.and_then(|c| self.numbers.get(c.encode_utf8(&mut [0; 4]) as &str));
                    let value = value + tenths.filter(|n| **n < 10.0).map_or(0.0, |n| n / 10.0);
                    // "两秒半".
                    let value = if lower[end..].starts_with('半') { value + 0.5 } else { value };
                    // "三十来米": some thirty meters.
                    let is_rough = lower[..at].ends_with(['多', '来', '余', '几', '把']);
                    out.push((Quantity { value: value * factor, start, end, is_rough }, end));
                }
            }
        }
        // The longest unit at a number: "km" rather than "m".
        out.sort_by(|a, b| a.0.start.cmp(&b.0.start).then(b.1.cmp(&a.1)));
        out.dedup_by_key(|q| q.0.start);
        out.into_iter().map(|q| q.0).collect()
    }

    /// The stated number of the thing whose name starts at `at`: "三头黄牛", "four big sheep".
    pub fn count_before(&self, text: &str, at: usize, counters: &CharSet) -> Option<f64> {
        /// Maximum number of Latin words, or of Chinese characters, between the number and the name.
        const BETWEEN: (usize, usize) = (1, 3);
        let before = text[..at].trim_end();
        if text.is_ascii() {
            let number = |word: &str| {
                let word = word.to_ascii_lowercase();
                self.numbers.get(&word).copied().or_else(|| word.parse().ok())
            };
            let mut last = before.rsplit(' ').take(BETWEEN.0 + 1);
            let first = last.next()?;
            let is_plain = first.len() > 2 && first.chars().all(|c| c.is_ascii_alphabetic());
            let second = last.next().filter(|w| is_plain && w.ends_with(|c: char| c.is_ascii_alphanumeric()));
            return number(first).or_else(|| number(second?));
        }
        let mut near = before.char_indices().rev().take(BETWEEN.1 + 1);
        let counter = near.find(|(_, c)| counters.contains(*c) || !c.is_alphanumeric() || *c == '的')?;
        // "Four pupils in school uniform" is "四个穿校服的学生": the number is before the clause that ends with "的".
        if counter.1 == '的' {
            const CLAUSE: usize = 9;
            let head = &before[..counter.0];
            let mut all = head.char_indices().rev().take(CLAUSE).take_while(|(_, c)| c.is_alphanumeric());
            let (at, _) = all.find(|(at, c)| counters.contains(*c) && self.ends_with_number(&head[..*at]))?;
            let c = head[..at].chars().next_back()?;
            return self.numbers.get(c.encode_utf8(&mut [0; 4]) as &str).copied();
        }
        let before = before[..counter.0].trim_end();
        let c = before.chars().next_back().filter(|_| counters.contains(counter.1))?;
        let counts = before[..before.len() - c.len_utf8()].ends_with('第');
        (!counts).then(|| self.numbers.get(c.encode_utf8(&mut [0; 4]) as &str).copied()).flatten()
    }

    /// `text` ends with a Chinese numeral that counts: not "第二".
    fn ends_with_number(&self, text: &str) -> bool {
        let mut last = text.chars().rev();
        let is_number =
            last.next().is_some_and(|c| self.numbers.contains_key(c.encode_utf8(&mut [0; 4]) as &str));
        is_number && last.next() != Some('第')
    }

    /// The number that ends at `at`, with its first byte.
    fn number_before(&self, text: &str, at: usize) -> Option<(f64, usize)> {
        let before = text[..at].trim_end_matches([' ', '-', '多', '来', '余']);
        let digits = before.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
        if digits.len() < before.len() {
            return before[digits.len()..].parse().ok().map(|v| (v, digits.len()));
        }
        let chinese = before.trim_end_matches(|c: char| {
            !c.is_ascii() && self.numbers.contains_key(c.encode_utf8(&mut [0; 4]) as &str)
        });
        if chinese.len() < before.len() {
            // "Some tens of meters".
            if chinese.ends_with(['几', '数']) {
                return None;
            }
            return self.chinese(&before[chinese.len()..]).map(|v| (v, chinese.len()));
        }
        // "Four hundred", "twenty-five".
        let (mut all, mut start) = (Vec::new(), before.len());
        for word in before.rsplit([' ', '-']).take(4) {
            // "A hundred and twenty".
            if word != "and" || all.is_empty() {
                let Some(n) = self.numbers.get(word) else { break };
                all.push(*n);
                start = before[..start].rfind(word)?;
            }
        }
        let (mut sum, mut last) = (0.0, 0.0);
        for n in all.into_iter().rev() {
            if n >= 100.0 {
                sum += if last > 0.0 { last * n } else { n };
                last = 0.0;
            } else {
                last += n;
            }
        }
        (sum + last > 0.0).then_some((sum + last, start))
    }

    fn chinese(&self, text: &str) -> Option<f64> {
        let (mut sum, mut last) = (0.0, 0.0);
        for c in text.chars() {
            let n = *self.numbers.get(c.encode_utf8(&mut [0; 4]) as &str)?;
            if n >= 10.0 {
                sum += if last == 0.0 { n } else { last * n };
                last = 0.0;
            } else {
                // "四五十": somewhere between.
                last = if last > 0.0 && (n - last - 1.0).abs() < 0.1 { last + 0.5 } else { n };
            }
        }
        Some(sum + last)
    }
}

/// The lists as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawQuantities {
    units: BTreeMap<String, BTreeMap<String, f64>>,
    numbers: BTreeMap<String, f64>,
    away: Words,
    beside: BTreeMap<String, Words>,
}

impl RawQuantities {
    pub(super) fn compile(&self) -> Quantities {
        let units = self
            .units
            .iter()
            .flat_map(|(unit, words)| words.iter().map(move |(w, f)| (unit.clone(), w.clone(), *f)));
        let beside = self.beside.iter().map(|(id, w)| (id.clone(), w.all().map(str::to_owned).collect()));
        Quantities {
            units: units.collect(),
            numbers: self.numbers.clone(),
            away: self.away.all().map(str::to_owned).collect(),
            beside: beside.collect(),
        }
    }
}
