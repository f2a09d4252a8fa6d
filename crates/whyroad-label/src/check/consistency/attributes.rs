//! Compares distances, numbers and sides in a trace, also of parts (wheels, indicators), with those in the components.

use crate::check::texts::TextScope;
use std::collections::BTreeSet;
use whyroad_framework::LabelWords;
use whyroad_framework::label_words::{Divider, Quantity};
use whyroad_model::decision::LateralDirection;

/// Minimum length that is compared; shorter ones are margins and widths, which a trace may add.
const LEAST_LENGTH_M: f64 = 3.0;

/// Bytes of a distance in the trace, if none of the trace's distances is in any component, although the components have
/// some.
pub(super) fn other_length(scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, .. } = *scope;
    let text = label.trace.get()?;
    let lengths = |text: &str| -> Vec<Quantity> {
        let all = words.quantities.lengths(text).into_iter();
        all.filter(|q| q.value >= LEAST_LENGTH_M).collect()
    };
    let said = lengths(text);
    let first = said.first()?;
    let given: Vec<Quantity> =
        label.parts.iter().filter_map(|c| c.description.get()).flat_map(lengths).collect();
    let known = said.iter().any(|q| given.iter().any(|g| g.is_about(q)));
    (!given.is_empty() && !known).then_some((first.start, first.end))
}

/// Bytes of a number in the trace that is in no component, if the trace has all other numbers of the components except
/// one: the one replaces the other. A number that is more than three times the other one describes something else.
pub(super) fn other_number(scope: &TextScope<'_>) -> Option<(usize, usize)> {
    const MOST_RATIO: f64 = 3.0;
    /// Numbers among which the same is looked for.
    const MOST: usize = 64;
    let TextScope { label, words, .. } = *scope;
    // The same number twice is one.
    let all = |text: &str| {
        let mut out: Vec<Quantity> = Vec::new();
        for q in words.quantities.all(text, &words.subjects.counters) {
            if out.len() > MOST || !out.iter().any(|o| o.value == q.value && o.is_about(&q)) {
                out.push(q);
            }
        }
        out
    };
    let said = all(label.trace.get()?);
    let given: Vec<Quantity> = label.parts.iter().filter_map(|c| c.description.get()).flat_map(all).collect();
    let unknown = |q: &&Quantity, all: &[Quantity]| !all.iter().any(|o| o.is_about(q));
    let mut new = said.iter().filter(|q| unknown(q, &given));
    let mut missing = given.iter().filter(|q| unknown(q, &said));
    let (Some(n), None, Some(m), None) = (new.next(), new.next(), missing.next(), missing.next()) else {
        return None;
    };
    let ratio = n.value.max(m.value) / n.value.min(m.value);
    (said.len() > 1 && ratio < MOST_RATIO).then_some((n.start, n.end))
}

/// Bytes of a limit of speed in the trace, if the components have another one: the number beside the word for it, "限速
/// 六十", "a limit of 60", "a 60 sign".
pub(super) fn other_limit(scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, .. } = *scope;
    let limits = |text: &str| -> Vec<Quantity> {
        let lower = text.to_ascii_lowercase();
        let all = words.quantities.all(text, &words.subjects.counters);
        let is_limit = |q: &&Quantity| {
            let before = lower[..q.start].trim_end();
            let behind = lower[q.end..].trim_start();
            match text.is_ascii() {
                true => {
                    let near = [" limit of", " limit to", " limit is", "limit", "sign says", "sign reads"];
                    near.iter().any(|w| before.ends_with(w))
                        || ["sign", "limit"].iter().any(|w| behind.starts_with(w))
                }
                false => before.ends_with("限速") || before.ends_with("限速为"),
            }
        };
        all.iter().filter(is_limit).copied().collect()
    };
    let said = limits(label.trace.get()?);
    let first = said.first()?;
    let given: Vec<Quantity> =
        label.parts.iter().filter_map(|c| c.description.get()).flat_map(limits).collect();
    let same = |a: &Quantity, b: &Quantity| (a.value - b.value).abs() < 1.0;
    let known = said.iter().any(|q| given.iter().any(|g| same(q, g)));
    (!given.is_empty() && !known).then_some((first.start, first.end))
}

/// Bytes of a side in the trace, before its last clause, that no component names, if they name the other side and the
/// trace does not. The side of the ego's own maneuver is left out. `until`: end of the text that is read.
pub(super) fn other_side_of_all(scope: &TextScope<'_>, until: usize) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, .. } = *scope;
    let text = label.trace.get()?;
    let end = until.min(text.len());
    let (last, _) = words.clauses.around(&texts.units, end..end, text.len(), &|d| d != Divider::Item);
    let [left, right] = words.subjects.sides(text.get(..last)?);
    let own = match label.direction.get() {
        Some(LateralDirection::Left) => Some(true),
        Some(LateralDirection::Right) => Some(false),
        _ => None,
    };
    let (is_left, at) = match (left, right) {
        (Some(at), None) => (true, at),
        (None, Some(at)) => (false, at),
        _ => return None,
    };
    let given = label.parts.iter().filter_map(|c| c.description.get()).map(|text| words.subjects.sides(text));
    let (own_side, other) = given.fold((false, false), |(own, other), [left, right]| {
        let (a, b) = if is_left { (left, right) } else { (right, left) };
        (own || a.is_some(), other || b.is_some())
    });
    (other && !own_side && own != Some(is_left)).then_some(at)
}

/// A part on a side: "left wheel", "右转向灯".
struct SidedPart {
    /// Index in `side_parts`.
    part: usize,
    is_left: bool,
    start: usize,
    end: usize,
}

/// Bytes of a part that is on the other side in the components: the trace never names their side.
pub(super) fn other_side(scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, .. } = *scope;
    let said = sided_parts(label.trace.get()?, words);
    if said.is_empty() {
        return None;
    }
    let sided = |p: &SidedPart| (p.part, p.is_left);
    let given = label.parts.iter().filter_map(|c| c.description.get()).flat_map(|t| sided_parts(t, words));
    let given: BTreeSet<(usize, bool)> = given.map(|p| sided(&p)).collect();
    let same: BTreeSet<usize> = said.iter().filter(|s| given.contains(&sided(s))).map(|s| s.part).collect();
    let is_other = |s: &&SidedPart| {
        given.contains(&(s.part, !s.is_left)) && !given.contains(&sided(s)) && !same.contains(&s.part)
    };
    said.iter().find(is_other).map(|s| (s.start, s.end))
}

/// All parts in a text that have a side.
fn sided_parts(text: &str, words: &LabelWords) -> Vec<SidedPart> {
    let lower = text.to_ascii_lowercase();
    let mut out = Vec::new();
    for (word, is_left) in [("左", true), ("右", false), ("left", true), ("right", false)] {
        for (start, _) in lower.match_indices(word) {
            let from = start + word.len();
            let part = words.subjects.side_parts.iter().enumerate().find_map(|(i, names)| {
                names.iter().find_map(|name| {
                    // "Left-hand wheel", "左侧前轮".
                    let rest = lower[from..].trim_start_matches([' ', '-', '侧', '边']);
                    let rest = rest.strip_prefix("hand ").unwrap_or(rest);
                    rest.starts_with(name.as_str()).then(|| (i, lower.len() - rest.len() + name.len()))
                })
            });
            if let Some((part, end)) = part {
                out.push(SidedPart { part, is_left, start, end });
            }
        }
    }
    out
}
