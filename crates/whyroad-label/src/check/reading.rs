//! What a text of a label names: things with their side, colour and state, clause by clause. Not a parser of language;
//! what is said under an "if" or denied is marked as such, and the checks leave it alone.

use whyroad_framework::LabelWords;
use whyroad_framework::label_words::{GroupSet, SaidState, WordRole};

/// A thing that a text names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Named {
    /// Index of its group.
    pub group: usize,
    /// True is left.
    pub side: Option<bool>,
    pub colour: Option<usize>,
    /// What is said of it in its clause.
    pub state: Option<SaidState>,
    /// "No pedestrian": it is not there.
    pub absent: bool,
    /// "If a pedestrian", "a pedestrian may".
    pub supposed: bool,
    /// Number of its clause.
    pub clause: usize,
    /// Bytes of the text.
    pub start: usize,
    pub end: usize,
}

/// A text as read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct TextFacts {
    pub named: Vec<Named>,
    /// Groups of all things named, absent ones too.
    pub groups: GroupSet,
    /// Bytes of the first phrase of hindsight.
    pub hindsight: Option<(usize, usize)>,
    /// Words of any list.
    pub words: usize,
    /// States said of nothing that is named, in order.
    pub states: Vec<SaidState>,
}

/// Ends of clauses.
const CLAUSE_ENDS: [char; 13] = ['，', '。', '；', '：', '、', '！', '？', ',', '.', ';', ':', '!', '?'];
/// Under these, what follows in the clause is not said to be there.
const SUPPOSED: &[&str] = &[
    "若",
    "如果",
    "一旦",
    "可能",
    "万一",
    "是否",
    "会不会",
    "随时",
    "假如",
    "倘若",
    "潜在",
    "任何",
    "以防",
    "防止",
    "if ",
    "might ",
    "may ",
    "could ",
    "whether ",
    "any ",
    "potential",
    "possible",
    "in case",
    "unless",
    "can ",
    "would ",
    "should one",
    "other than",
    "in order to let",
    "should a",
    // What cannot be seen is not said to be there.
    "看不到",
    "看不见",
    "看不清",
    "看清",
    "cannot see",
    "can't see",
    "cannot be seen",
];
const ABSENT: [&str; 12] = [
    "无",
    "没有",
    "没",
    "未见",
    "并无",
    "no ",
    "without ",
    "not any ",
    "without any ",
    "clear of ",
    "free of ",
    "no other ",
];

/// Reads `text` with `words`.
pub(super) fn read(text: &str, words: &LabelWords) -> TextFacts {
    let mut out = TextFacts::default();
    let mut clause = Clause::default();
    let mut last_end = 0;
    words.hits(text, |hit| {
        let between = &text[last_end..hit.start];
        if let Some(end) = between.rfind(CLAUSE_ENDS) {
            clause.close(&mut out);
            clause = Clause { number: clause.number + 1, from: last_end + end, ..Clause::default() };
        }
        last_end = hit.end;
        if hit.role != WordRole::Plain {
            out.words += 1;
        }
        match hit.role {
            WordRole::Object(group) => {
                let before = &text[clause.from..hit.start];
                let absent = ABSENT.iter().any(|w| ends_with_word(before, w));
                out.groups = out.groups.with(words.objects[group].own);
                out.named.push(Named {
                    group,
                    side: clause.side,
                    colour: clause.colour.take(),
                    state: None,
                    absent,
                    supposed: is_supposed(before),
                    clause: clause.number,
                    start: hit.start,
                    end: hit.end,
                });
                clause.names += 1;
            }
            WordRole::Side(left) => {
                // "the car on the left": said behind it.
                let behind = out.named.last_mut().filter(|n| n.clause == clause.number && n.side.is_none());
                match behind {
                    Some(n) if text[hit.start..hit.end].is_ascii() => n.side = Some(left),
                    _ => clause.side = Some(left),
                }
            }
            WordRole::State(state) => {
                let denied = ABSENT
                    .iter()
                    .chain(&["不", "未", "not ", "n't "])
                    .any(|w| ends_with_word(&text[clause.from..hit.start], w));
                if !denied {
                    match out.named.last_mut().filter(|n| n.clause == clause.number && n.state.is_none()) {
                        Some(n) => n.state = Some(state),
                        None => clause.state = Some(state),
                    }
                }
            }
            WordRole::Colour(colour) => clause.colour = Some(colour),
            WordRole::Hindsight => {
                out.hindsight.get_or_insert((hit.start, hit.end));
            }
            WordRole::Plain => {}
        }
    });
    clause.close(&mut out);
    out
}

/// Since the last end of a clause.
#[derive(Default)]
struct Clause {
    number: usize,
    from: usize,
    side: Option<bool>,
    colour: Option<usize>,
    state: Option<SaidState>,
    names: usize,
}

impl Clause {
    fn close(&self, out: &mut TextFacts) {
        let Some(state) = self.state else { return };
        match out.named.iter_mut().find(|n| n.clause == self.number && n.state.is_none()) {
            Some(n) if self.names > 0 => n.state = Some(state),
            _ => out.states.push(state),
        }
    }
}

/// `word` is at the end of `before`, with at most one short word between: "no other", "没有任何".
fn ends_with_word(before: &str, word: &str) -> bool {
    let Some(at) = before.to_ascii_lowercase().rfind(word) else { return false };
    let rest = &before[at + word.len()..];
    let is_word =
        !word.is_ascii() || at == 0 || !before.as_bytes()[at - 1].is_ascii_alphanumeric() || word == "n't ";
    is_word && rest.chars().count() <= if word.is_ascii() { 12 } else { 2 }
}

fn is_supposed(before: &str) -> bool {
    let lower = before.to_ascii_lowercase();
    SUPPOSED.iter().any(|w| lower.contains(w))
}

impl TextFacts {
    /// Things that are said to be there.
    pub fn there(&self) -> impl Iterator<Item = &Named> {
        self.named.iter().filter(|n| !n.absent && !n.supposed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_framework::Framework;

    fn said(text: &str) -> Vec<String> {
        let words = &Framework::bundled().label_words;
        let facts = read(text, words);
        facts
            .named
            .iter()
            .map(|n| {
                let mut s = words.objects[n.group].id.clone();
                s += match n.side {
                    Some(true) => " left",
                    Some(false) => " right",
                    None => "",
                };
                if let Some(state) = n.state {
                    s += &format!(" {state:?}");
                }
                s + if n.absent { " absent" } else { "" } + if n.supposed { " supposed" } else { "" }
            })
            .collect()
    }

    #[test]
    fn things_have_side_state_and_mood() {
        assert_eq!(said("左前方白色轿车切入，右侧货车并行"), ["car left CuttingIn", "truck right"]);
        assert_eq!(said("后方没有来车，前车已停"), ["vehicle_any absent", "lead Standing"]);
        assert_eq!(said("若行人突然出现"), ["pedestrian supposed"]);
        assert_eq!(
            said("A cyclist on the right is crossing; no other vehicles."),
            ["rider right Crossing", "vehicle_any absent"]
        );
        assert_eq!(said("There is a parked van on the left"), ["parked_vehicle left"]);
    }
}
