//! The words of a label's texts (`schema/label_words.yaml`, which documents each list), compiled to one search: things,
//! sides, states, colors, hindsight, placeholders. The label checks interpret them.

mod aftermath;
mod apart;
mod bearing;
mod clauses;
mod compared;
mod compile;
mod concepts;
mod draft_notes;
mod forms;
mod numbers;
mod quantity;
mod remote;
mod subjects;
mod undecided;

pub use aftermath::{Aftermath, NewSubject, TellWord};
pub use apart::Apart;
pub use bearing::{Bearing, Bears};
pub use clauses::{Clauses, Divider};
pub use compared::{CharSet, Compared, hashed};
pub use concepts::{ConceptSet, Concepts};
pub use forms::Forms;
pub use numbers::Numbers;
pub use quantity::{Quantities, Quantity};
pub use remote::Remote;
pub use subjects::Subjects;
pub use undecided::{ClauseMood, Undecided};

use serde::Deserialize;
use std::collections::{BTreeMap, HashSet};
use std::ops::Range;
use whyroad_model::{Bilingual, Diagnostic};

use crate::lexicon::trie::{Found, Trie};
use crate::lexicon::units::Units;
use crate::yaml_text;

/// Maximum bytes of a text that may be unfinished: a longer one has other content.
pub const LONGEST_UNFINISHED: usize = 60;
/// Between the parts of one, beside a dash between spaces.
const PART_MARKS: &str = ",;:()[]，；：（）【】—–";
/// Letters and digits of a placeholder; the list is checked against it.
const LONGEST_PLACEHOLDER: usize = 32;

/// A set of groups of things, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GroupSet(pub u64);

impl GroupSet {
    /// True when the two have a group in common.
    pub fn meets(self, other: GroupSet) -> bool {
        self.0 & other.0 != 0
    }

    /// Both together.
    #[must_use]
    pub fn with(self, other: GroupSet) -> GroupSet {
        GroupSet(self.0 | other.0)
    }

    /// The elements not in `other`.
    #[must_use]
    pub fn without(self, other: GroupSet) -> GroupSet {
        GroupSet(self.0 & !other.0)
    }

    /// The elements that are also in `other`.
    #[must_use]
    pub fn only(self, other: GroupSet) -> GroupSet {
        GroupSet(self.0 & other.0)
    }

    /// True when there is no group.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

/// Kinds of things that the checks use by name; empty where the file has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KnownKinds {
    /// The vehicle ahead of the ego.
    pub lead: GroupSet,
    /// Vehicles that wait in a queue.
    pub queue: GroupSet,
    /// Any vehicle.
    pub vehicle: GroupSet,
    /// Vehicles that are not in the ego's lane.
    pub elsewhere: GroupSet,
    /// Things that cause no decision by themselves: gaps and lanes.
    pub no_cause: GroupSet,
    /// The road itself.
    pub road: GroupSet,
    /// Distances, speeds and room.
    pub gap: GroupSet,
    /// Lights.
    pub light: GroupSet,
    /// Road users and animals.
    pub actor: GroupSet,
    /// Signs, lights and stop lines, whose names state the required action.
    pub sign: GroupSet,
    /// The ego's route.
    pub route: GroupSet,
    /// Things that block the view.
    pub sight: GroupSet,
    /// Things whose absence leaves nothing to respond to.
    pub adverse: GroupSet,
    /// Conditions of the road, its surface, the light or the view; not precipitation.
    pub condition: GroupSet,
}

/// States and actions of a thing, one bit each: `doings` of the file, and the states of the same names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Doings(pub u32);

impl Doings {
    /// True when the two have one in common.
    pub fn meets(self, other: Doings) -> bool {
        self.0 & other.0 != 0
    }

    /// Both together.
    #[must_use]
    pub fn with(self, other: Doings) -> Doings {
        Doings(self.0 | other.0)
    }

    /// The elements that are also in `other`.
    #[must_use]
    pub fn only(self, other: Doings) -> Doings {
        Doings(self.0 & other.0)
    }

    /// The elements not in `other`.
    #[must_use]
    pub fn without(self, other: Doings) -> Doings {
        Doings(self.0 & !other.0)
    }

    /// True when the set is empty.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

/// A group of words for one kind of thing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ObjectGroup {
    /// Its id.
    pub id: String,
    /// A trace that names one needs a component that names it.
    pub named: bool,
    /// The group itself, as a set.
    pub own: GroupSet,
    /// Groups that can stand for it, itself included.
    pub near: GroupSet,
}

/// State or action of a road user.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaidState {
    /// Stands.
    Standing,
    /// Slows or brakes.
    Slowing,
    /// Goes across.
    Crossing,
    /// Comes into the lane.
    CuttingIn,
    /// Drives backwards.
    Reversing,
}

impl SaidState {
    /// The state of this name in `states` of the file.
    pub fn from_id(id: &str) -> Option<Self> {
        Some(match id {
            "standing" => Self::Standing,
            "slowing" => Self::Slowing,
            "crossing" => Self::Crossing,
            "cutting_in" => Self::CuttingIn,
            "reversing" => Self::Reversing,
            _ => return None,
        })
    }

    /// The corresponding name in `doings`: a braking vehicle is about to stand.
    fn doing(self) -> &'static str {
        match self {
            Self::Standing | Self::Slowing => "stopping",
            Self::Crossing => "crossing",
            Self::CuttingIn => "cutting_in",
            Self::Reversing => "reversing",
        }
    }
}

/// Role of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WordRole {
    /// A thing: index of its group.
    Object(usize),
    /// A side: true is left.
    Side(bool),
    /// An action, also as one of the doings.
    State(SaidState, Doings),
    /// A property of a thing that is not a state.
    Doing(Doings),
    /// Far away.
    Distant,
    /// A distance beyond the thing that is named next.
    Beyond,
    /// In a short text: the text is still to be written.
    Template,
    /// In any position: something is still to be written.
    Unwritten,
    /// There is no reason.
    NoReason,
    /// The thing named before has no part in the decision.
    Irrelevant,
    /// The cause was not observed.
    Unobserved,
    /// The named thing is only compared with something.
    Likened,
    /// A color: index in the file's order of names.
    Color(usize),
    /// Only known afterwards.
    Hindsight,
    /// In a component: a consequence of the ego's own response.
    AfterResponse,
    /// The nearby thing is ahead of the ego.
    Ahead,
    /// The following thing is absent.
    Absent,
    /// The following event does not happen.
    Denied,
    /// The rest of the clause is hypothetical.
    Supposed,
    /// The things named in the clause may be there or not.
    Uncertain,
    /// The road user that the ego responds to is gone, which needs no response.
    Resolved,
    /// The ego continues as before.
    Unchanged,
    /// Only hides the words inside it.
    Plain,
}

/// A word found in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WordHit {
    /// Its role.
    pub role: WordRole,
    /// First byte in the text.
    pub start: usize,
    /// One past its last byte.
    pub end: usize,
}

/// All words.
#[derive(Clone, Debug, Default)]
pub struct LabelWords {
    /// Groups of things, in file order.
    pub objects: Vec<ObjectGroup>,
    /// Unions of groups by name; every group is also its own kind.
    pub kinds: BTreeMap<String, GroupSet>,
    names: BTreeMap<String, Bilingual>,
    placeholders: HashSet<String>,
    /// The first two letters of each, sorted.
    placeholder_starts: Vec<[char; 2]>,
    unfinished: HashSet<String>,
    /// In lower case.
    instructions: Vec<String>,
    /// Notes in brackets that a text is a draft, in lower case.
    draft_notes: Vec<String>,
    trie: Trie,
    roles: Vec<WordRole>,
    reasons: Trie,
    scene: Trie,
    /// Words for events after the decision.
    pub aftermath: Aftermath,
    /// Names that exclude one another.
    pub apart: Apart,
    /// Statements of texts besides their things.
    pub bearing: Bearing,
    /// With one of these before it, hindsight is a prediction.
    pub imagined: Vec<String>,
    /// With one of these anywhere in the clause, a passing time is a prediction.
    pub predicted: Vec<String>,
    /// Words of each color of a light.
    pub lights: Vec<Vec<String>>,
    /// The first characters of colors in Chinese, which directly precede a name: "红卡车".
    pub color_chars: Vec<(char, usize)>,
    /// Words for numbers.
    pub numbers: Numbers,
    /// How texts are divided.
    pub clauses: Clauses,
    /// Words for road users, in lower case.
    pub road_users: Vec<String>,
    /// Kinds that the checks use.
    pub known: KnownKinds,
    /// Actions of road users off the road that affect the road.
    pub reaching: Doings,
    /// Actions that give nobody on the road a reason to respond.
    pub calm: Doings,
    /// Properties that exclude each other.
    pub opposite: Vec<(Doings, Doings)>,
    /// Words that are ignored when texts are compared.
    pub compared: Compared,
    /// Words for an ego that keeps its course or speed, in lower case.
    pub unchanged_course: Vec<String>,
    /// Words to find the thing that a component describes.
    pub subjects: Subjects,
    /// Times and distances that are far from any decision.
    pub remote: Remote,
    /// Statements that are recognized by their place.
    pub forms: Forms,
    /// Numbers with a unit.
    pub quantities: Quantities,
    /// Words that say nearly the same.
    pub concepts: Concepts,
    /// Numbers of exits, in order.
    exits: Vec<Vec<String>>,
    /// Words to distinguish a clause without a decision from one that may decide.
    pub undecided: Undecided,
}

impl LabelWords {
    /// From the text of `schema/label_words.yaml`; `file` is named in diagnostics. An unreadable file gives an empty
    /// word list, which finds nothing.
    pub fn parse(file: &str, text: &str) -> (LabelWords, Vec<Diagnostic>) {
        let what = Bilingual::new("词表", "the word list");
        let raw: File = match yaml_text::read("lexicon.syntax", file, text, what) {
            Ok((raw, _)) => raw,
            Err(finding) => return (LabelWords::default(), vec![*finding]),
        };
        let (words, problems) = compile::compile(&raw);
        let diagnostics =
            problems.into_iter().map(|m| Diagnostic::error("lexicon.pattern", m).in_file(file)).collect();
        (words, diagnostics)
    }

    /// Passes the words of `text` to `take` in order, never overlapping.
    pub fn hits(&self, text: &str, take: impl FnMut(WordHit)) {
        self.hits_in(&Units::of(text), 0..text.len(), take);
    }

    /// The same for a part of a text that has been cut, which begins and ends between units.
    pub fn hits_in(&self, units: &Units, bytes: Range<usize>, mut take: impl FnMut(WordHit)) {
        let hit = |f: Found| WordHit { role: self.roles[f.word], start: f.start, end: f.end };
        self.trie.find_in(units, bytes, |f| take(hit(f)));
    }

    /// True when there are no words at all: nothing can be said about a text then.
    pub fn is_empty(&self) -> bool {
        self.roles.is_empty()
    }

    /// Displayed name of a kind; its id where the file has no name.
    pub fn kind_name(&self, id: &str) -> Bilingual {
        self.names.get(id).cloned().unwrap_or_else(|| Bilingual::same(id))
    }

    /// True when a text consists of nothing but a placeholder: one of the list, one character repeated, or no letter.
    pub fn is_placeholder(&self, text: &str) -> bool {
        let mut letters = text.chars().filter(|c| c.is_alphanumeric());
        let Some(first) = letters.next() else { return true };
        let (mut same, mut digits, mut count) = (true, first.is_ascii_digit(), 1_usize);
        for c in letters {
            same = same && c.to_lowercase().eq(first.to_lowercase());
            digits = digits && c.is_ascii_digit();
            count += 1;
            if !same && !digits {
                // Most texts end here: their beginning is not in the list, or they are longer.
                let begins = count == 2 && is_plain(first) && is_plain(c);
                if begins
                    && self
                        .placeholder_starts
                        .binary_search(&[first, c].map(|c| c.to_ascii_lowercase()))
                        .is_err()
                {
                    return false;
                }
                if count > LONGEST_PLACEHOLDER {
                    return false;
                }
            }
        }
        (same && count > 1) || digits || self.placeholders.contains(&compile::bare(text))
    }

    /// True when a part of a short text states that the text is still to be written: `路况：同上`, `part 2 - fill in`.
    pub fn is_unfinished(&self, text: &str) -> bool {
        text.len() <= LONGEST_UNFINISHED
            && text
                .split(|c: char| PART_MARKS.contains(c))
                .flat_map(|part| part.split(" - "))
                .any(|part| self.unfinished.contains(&compile::bare(part)))
    }

    /// Bytes of the first part of a text, of any length, that was left from a template: an instruction in brackets,
    /// `××`, `___`, `xx`.
    pub fn left_open(&self, text: &str) -> Option<(usize, usize)> {
        let is_sign = |c: char| "×╳＿_".contains(c);
        if let Some(at) = text.find(is_sign) {
            let run = &text[at..at + text[at..].find(|c| !is_sign(c)).unwrap_or(text.len() - at)];
            if run.chars().nth(1).is_some() {
                return Some((at, at + run.len()));
            }
        }
        let mut from = 0;
        for word in text.split(|c: char| !c.is_ascii_alphanumeric()) {
            let at = text[from..].find(word).map_or(from, |i| from + i);
            from = at + word.len();
            if word.len() >= 2 && word.bytes().all(|b| b.eq_ignore_ascii_case(&b'x')) {
                return Some((at, from));
            }
        }
        let bracketed = text.match_indices(['(', '[', '（', '【', '<', '《', '{']).find_map(|(at, open)| {
            let inside = &text[at + open.len()..];
            let end = inside.find([')', ']', '）', '】', '>', '》', '}'])?;
            let says = inside[..end].trim().to_ascii_lowercase();
            let is_open = self.instructions.iter().any(|w| {
                let rest = says.strip_prefix(w.as_str());
                rest.is_some_and(|r| !w.is_ascii() || !r.starts_with(|c: char| c.is_ascii_alphanumeric()))
            }) || self.unfinished.contains(&compile::bare(&says));
            is_open.then_some((at, at + open.len() + end))
        });
        bracketed.filter(|_| !self.instructions.is_empty())
    }

    /// The properties that exclude any of `doings`.
    pub fn opposite_of(&self, doings: Doings) -> Doings {
        self.opposite.iter().fold(Doings::default(), |all, (a, b)| {
            let all = if a.meets(doings) { all.with(*b) } else { all };
            if b.meets(doings) { all.with(*a) } else { all }
        })
    }

    /// True when `text` has a word about roads and traffic.
    pub fn is_of_driving(&self, text: &str) -> bool {
        let mut any = false;
        self.scene.find(text, |_| any = true);
        any
    }

    /// The text distinguishes a thing from another one of its kind: "a second van", "另一辆".
    pub fn tells_another(&self, text: &str) -> bool {
        has_one_of(text, &self.subjects.another)
    }

    /// The last color of a light in `text`, as an index in the file's order: "from green to yellow".
    pub fn light_color(&self, text: &str) -> Option<usize> {
        self.last_light_color(text).map(|(_, color)| color)
    }

    /// The same with the first byte of its word.
    pub fn last_light_color(&self, text: &str) -> Option<(usize, usize)> {
        let lower = text.to_ascii_lowercase();
        // "Hundred" is not a color.
        let whole = |at: usize, w: &str| {
            let letter = |c: char| c.is_ascii_alphanumeric();
            !w.is_ascii() || !lower[..at].ends_with(letter) && !lower[at + w.len()..].starts_with(letter)
        };
        let found = |w: &String| lower.rmatch_indices(w.as_str()).map(|(at, _)| at).find(|at| whole(*at, w));
        let last = |names: &[String]| names.iter().filter_map(found).max();
        let all = self.lights.iter().enumerate();
        all.filter_map(|(i, names)| Some((last(names)?, i))).max()
    }

    /// The number of an exit, from 0, that a record states.
    pub fn ordinal(&self, record: &str) -> Option<usize> {
        let lower = record.to_ascii_lowercase();
        self.exits.iter().position(|words| words.iter().any(|w| lower.contains(w.as_str())))
    }

    /// The number of the exit, from 0, that a text mentions.
    pub fn ordinal_of_exit(&self, text: &str) -> Option<usize> {
        /// Bytes after the number.
        const NEAR: usize = 16;
        let lower = text.to_ascii_lowercase();
        let is_exit = |at: usize| {
            let end = (at + NEAR).min(lower.len());
            let end = (end..=lower.len()).find(|i| lower.is_char_boundary(*i)).unwrap_or(lower.len());
            lower[at..end].contains("出口") || lower[at..end].contains("exit")
        };
        self.exits.iter().position(|words| {
            words.iter().any(|w| lower.match_indices(w.as_str()).any(|(at, w)| is_exit(at + w.len())))
        })
    }

    /// True when `text` states why something could not be observed.
    pub fn gives_reason(&self, text: &str) -> bool {
        let mut any = false;
        self.reasons.find(text, |_| any = true);
        any
    }
}

/// A letter that is its own lower case, or one of ASCII.
fn is_plain(c: char) -> bool {
    c.is_ascii() || !c.is_uppercase()
}

/// The file as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[allow(dead_code)] // read by people
    version: String,
    objects: Vec<RawObject>,
    kinds: BTreeMap<String, Vec<String>>,
    names: BTreeMap<String, Name>,
    sides: RawSides,
    states: RawStates,
    doings: BTreeMap<String, Words>,
    opposite: Vec<[String; 2]>,
    reaching: Vec<String>,
    calm: Vec<String>,
    distant: Words,
    beyond: Words,
    numbers: numbers::RawNumbers,
    lights: BTreeMap<String, Words>,
    colours: BTreeMap<String, Words>,
    ahead: Words,
    absent: Words,
    denied: Words,
    supposed: Words,
    unchanged: Words,
    unchanged_course: Words,
    uncertain: Words,
    hindsight: RawHindsight,
    resolved: Words,
    aftermath: aftermath::RawAftermath,
    clauses: clauses::RawClauses,
    compared: compared::RawCompared,
    subjects: subjects::RawSubjects,
    undecided: undecided::RawUndecided,
    #[serde(default)]
    apart: apart::RawApart,
    #[serde(default)]
    concepts: BTreeMap<String, Words>,
    remote: remote::RawRemote,
    #[serde(default)]
    forms: forms::RawForms,
    quantities: quantity::RawQuantities,
    exits: Vec<Words>,
    placeholder: Words,
    unfinished: Words,
    template: Words,
    unwritten: Words,
    draft_notes: Words,
    instructions: Words,
    no_reason: Words,
    irrelevant: Words,
    bearing: bearing::RawBearing,
    unobserved: Words,
    likened: Words,
    plain: Words,
    scene: Words,
    unobserved_because: Words,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawObject {
    id: String,
    #[serde(default)]
    named: bool,
    #[serde(default)]
    near: Vec<String>,
    zh: Vec<String>,
    en: Vec<String>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSides {
    left: Words,
    right: Words,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawStates {
    standing: Words,
    slowing: Words,
    crossing: Words,
    cutting_in: Words,
    reversing: Words,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawHindsight {
    firm: Words,
    imagined: Words,
    predicted: Words,
    plain: Words,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Name {
    zh: String,
    en: String,
}

/// One list in both languages.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Words {
    #[serde(default)]
    zh: Vec<String>,
    #[serde(default)]
    en: Vec<String>,
}

/// The text has a word of Latin letters that is one.
fn has_word(text: &str, is_one: impl Fn(&str) -> bool) -> bool {
    text.split(|c: char| !c.is_ascii_alphabetic()).any(is_one)
}

/// The text has one of the words: in Latin letters as a word, else as a part of it.
fn has_one_of(text: &str, words: &[String]) -> bool {
    match text.is_ascii() {
        true => has_word(text, |word| words.iter().any(|w| word.eq_ignore_ascii_case(w))),
        false => words.iter().any(|w| text.contains(w.as_str())),
    }
}

impl Words {
    fn all(&self) -> impl Iterator<Item = &str> {
        self.zh.iter().chain(&self.en).map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words() -> LabelWords {
        let text = include_str!("../../../schema/label_words.yaml");
        let (words, found) = LabelWords::parse("schema/label_words.yaml", text);
        assert!(found.is_empty(), "{found:#?}");
        words
    }

    #[test]
    fn the_words_of_this_repository_are_found() {
        let words = words();
        let named = |text: &str| {
            let mut out = Vec::new();
            words.hits(text, |h| {
                if let WordRole::Object(g) = h.role {
                    out.push(words.objects[g].id.clone());
                }
            });
            out
        };
        assert_eq!(named("左前方白色轿车切入，右侧货车并行"), ["car", "truck"]);
        assert_eq!(named("公交车道上没有公交车"), ["marking", "bus"]);
        assert_eq!(named("The stop sign applies; a cyclist waits."), ["sign", "rider"]);
        let car = words.objects.iter().find(|o| o.id == "car").unwrap();
        assert!(car.near.meets(words.kinds["vehicle_any"]), "near is symmetric");
    }

    #[test]
    fn placeholders_and_reasons() {
        let words = words();
        for text in ["无", "test", "N/A", "...", "哈哈哈哈", "12345", "Lorem ipsum dolor sit amet.", " TODO "]
        {
            assert!(words.is_placeholder(text), "{text}");
        }
        assert!(words.placeholders.iter().all(|p| p.chars().count() <= LONGEST_PLACEHOLDER));
        for text in ["行人", "red light", "无灯路口"] {
            assert!(!words.is_placeholder(text), "{text}");
        }
        for text in ["前车：待补充", "要素二（略）", "component 3 - fill in", "Lorem ipsum, to follow"]
        {
            assert!(words.is_unfinished(text) && !words.is_placeholder(text), "{text}");
        }
        for text in ["前方红灯（已停车）", "van - parked on the right", "信号灯：红", "略微减速的前车"]
        {
            assert!(!words.is_unfinished(text), "{text}");
        }
        assert!(words.gives_reason("被货车遮挡") && !words.gives_reason("不太好说"));
    }
}
