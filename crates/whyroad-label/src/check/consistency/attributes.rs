//! What a trace says of distances and of the sides of parts (wheels, indicators), against what the components say.

use crate::check::texts::TextScope;
use whyroad_framework::LabelWords;
use whyroad_framework::label_words::Quantity;

/// Shorter lengths are margins and widths, which a trace may add.
const LEAST_LENGTH_M: f64 = 3.0;

/// Bytes of a distance of the trace, where none that it gives is in any component, though the components give some.
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

/// A part on a side: "left wheel", "右转向灯".
struct SidedPart {
    /// Index in `side_parts`.
    part: usize,
    is_left: bool,
    start: usize,
    end: usize,
}

/// Bytes of a part that is on the other side in the components: the trace never names the side that they give.
pub(super) fn other_side(scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, .. } = *scope;
    let said = sided_parts(label.trace.get()?, words);
    if said.is_empty() {
        return None;
    }
    let given: Vec<SidedPart> =
        label.parts.iter().filter_map(|c| c.description.get()).flat_map(|t| sided_parts(t, words)).collect();
    let same = |a: &SidedPart, b: &SidedPart| a.part == b.part && a.is_left == b.is_left;
    let is_other = |s: &&SidedPart| {
        given.iter().any(|g| g.part == s.part)
            && !given.iter().any(|g| same(g, s))
            && !said.iter().any(|o| given.iter().any(|g| same(g, o) && o.part == s.part))
    };
    said.iter().find(is_other).map(|s| (s.start, s.end))
}

/// All parts of a text that are said to be on a side.
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
