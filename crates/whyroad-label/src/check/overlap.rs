//! Words that a trace shares with the components, whatever they name. Only asked before a finding is made.

use super::view::View;

/// Words of Latin letters that say nothing of a scene.
const PLAIN: [&str; 46] = [
    "about", "above", "after", "already", "also", "another", "around", "back", "because", "been", "before",
    "being", "both", "does", "down", "each", "from", "going", "have", "here", "into", "just", "more", "must",
    "need", "needs", "only", "onto", "other", "over", "should", "since", "some", "than", "that", "their",
    "them", "then", "there", "they", "this", "which", "while", "will", "with", "would",
];
/// Characters that say nothing of a scene.
const PARTICLES: &str =
    "的了着过在是有和与把被从到也都很就又再还个一辆台之其这那而且并因此为于以所则对向自车本应需要当";
/// Words of what the ego does and where it is: a trace that shares no other repeats its decision.
const OWN: [&str; 22] = [
    "lane", "lanes", "slow", "slows", "brake", "brakes", "braking", "stop", "stops", "yield", "yields",
    "speed", "change", "changes", "left", "right", "line", "follow", "merge", "merges", "turn", "turns",
];

/// Units of a trace that are compared: a longer one is reported for its length.
const MOST_UNITS: usize = 200;

/// Distinct pairs of Chinese characters, or words of four letters and more, that the parts `inside` of the trace share
/// with the components.
pub(super) fn shared(label: &View<'_>, text: &str, inside: &dyn Fn(usize) -> bool) -> usize {
    let mut ours: Vec<String> = Vec::new();
    units(text, |at, unit| {
        if ours.len() < MOST_UNITS && inside(at) {
            ours.push(unit);
        }
    });
    ours.sort_unstable();
    ours.dedup();
    let mut theirs: Vec<String> = Vec::new();
    for c in label.parts.iter().filter_map(|c| c.description.get()) {
        units(c, |_, unit| theirs.push(unit));
    }
    theirs.sort_unstable();
    ours.iter().filter(|u| theirs.binary_search(u).is_ok()).count()
}

/// Characters of deciding and of reasons in general.
const OF_DECIDING: &str =
    "考虑选择决定安全判断场景情况原因理由执行操作采取措施根据要想得该应当需必须打算准备时候到了最终结果规则";

/// The parts `inside` hold so much that they are no mere repetition: characters or words of their own.
pub(super) fn says_more(text: &str, inside: &dyn Fn(usize) -> bool) -> bool {
    if text.is_ascii() {
        let mut all = Vec::new();
        units(text, |at, unit| {
            if all.len() < MOST_UNITS && inside(at) && !all.contains(&unit) {
                all.push(unit);
            }
        });
        return all.len() >= 5;
    }
    let mut all: Vec<char> = text
        .char_indices()
        .take(MOST_UNITS)
        .filter(|(at, c)| {
            inside(*at) && c.is_alphabetic() && !PARTICLES.contains(*c) && !OF_DECIDING.contains(*c)
        })
        .map(|(_, c)| c)
        .collect();
    all.sort_unstable();
    all.dedup();
    all.len() >= 6
}

/// Units of a text with the byte at which each starts.
fn units(text: &str, mut take: impl FnMut(usize, String)) {
    let mut last: Option<(usize, char)> = None;
    let mut word = (0, String::new());
    let end = std::iter::once((text.len(), ' '));
    for (at, c) in text.char_indices().chain(end) {
        if c.is_ascii_alphabetic() {
            if word.1.is_empty() {
                word.0 = at;
            }
            word.1.push(c.to_ascii_lowercase());
            last = None;
            continue;
        }
        let w = std::mem::take(&mut word.1);
        if w.len() >= 4 && !PLAIN.contains(&w.as_str()) && !OWN.contains(&w.as_str()) {
            let stem = w.strip_suffix('s').filter(|s| s.len() >= 4).unwrap_or(&w).to_owned();
            take(word.0, stem);
        }
        if !c.is_alphabetic() || PARTICLES.contains(c) {
            last = None;
            continue;
        }
        if let Some((start, before)) = last {
            take(start, format!("{before}{c}"));
        }
        last = Some((at, c));
    }
}
