//! From the lists of `schema/label_words.yaml` to one search.

use super::{Doings, File, GroupSet, KnownKinds, LabelWords, ObjectGroup, SaidState, WordRole};
use crate::lexicon::expand::choices;
use crate::lexicon::trie::Trie;
use std::collections::{BTreeMap, HashSet};
use whyroad_model::Bilingual;

/// Maximum number of groups of things in a set.
const MAX_GROUPS: usize = 64;
/// Maximum number of doings in a set.
const MAX_DOINGS: usize = 32;

/// The words, and the errors in the file's patterns.
pub(super) fn compile(raw: &File) -> (LabelWords, Vec<Bilingual>) {
    let mut b = Builder { texts: BTreeMap::new(), problems: Vec::new() };
    let objects = groups(raw, &mut b);
    for (i, o) in raw.objects.iter().enumerate() {
        b.all(o.zh.iter().chain(&o.en).map(String::as_str), WordRole::Object(i));
    }
    b.all(raw.sides.left.all(), WordRole::Side(true));
    b.all(raw.sides.right.all(), WordRole::Side(false));
    let s = &raw.states;
    for (words, state) in [
        (&s.standing, SaidState::Standing),
        (&s.slowing, SaidState::Slowing),
        (&s.crossing, SaidState::Crossing),
        (&s.cutting_in, SaidState::CuttingIn),
        (&s.reversing, SaidState::Reversing),
    ] {
        let role = WordRole::State(state, doing(raw, state.doing(), &mut b));
        b.all(words.all(), role);
    }
    limit(["doings"; 2], ["项", "entries"], raw.doings.len(), MAX_DOINGS, &mut b.problems);
    for (id, words) in &raw.doings {
        let role = WordRole::Doing(doing(raw, id, &mut b));
        b.all(words.all(), role);
    }
    let opposite: Vec<_> = raw
        .opposite
        .iter()
        .map(|pair| (doing(raw, &pair[0], &mut b), doing(raw, &pair[1], &mut b)))
        .collect();
    let mut all =
        |ids: &[String]| ids.iter().fold(Doings::default(), |all, id| all.with(doing(raw, id, &mut b)));
    let (reaching, calm) = (all(&raw.reaching), all(&raw.calm));
    b.all(raw.template.all(), WordRole::Template);
    b.all(raw.no_reason.all(), WordRole::NoReason);
    b.all(raw.distant.all(), WordRole::Distant);
    b.all(raw.beyond.all(), WordRole::Beyond);
    for (i, words) in raw.colours.values().enumerate() {
        b.all(words.all(), WordRole::Color(i));
    }
    let colors = raw.colours.values().enumerate();
    let color_chars =
        colors.flat_map(|(i, w)| w.zh.iter().filter_map(move |t| Some((t.chars().next()?, i, t.len()))));
    // "银" is silver rather than "银灰".
    let mut color_chars: Vec<(char, usize, usize)> = color_chars.collect();
    color_chars.sort_by_key(|(_, _, length)| *length);
    let color_chars = color_chars.into_iter().map(|(c, i, _)| (c, i)).collect();
    b.all(raw.hindsight.firm.all(), WordRole::Hindsight);
    b.all(raw.resolved.all(), WordRole::Resolved);
    b.all(raw.ahead.all(), WordRole::Ahead);
    b.all(raw.absent.all(), WordRole::Absent);
    b.all(raw.denied.all(), WordRole::Denied);
    b.all(raw.supposed.all(), WordRole::Supposed);
    b.all(raw.unchanged.all(), WordRole::Unchanged);
    b.all(raw.uncertain.all(), WordRole::Uncertain);
    b.all(raw.aftermath.component.all(), WordRole::AfterResponse);
    b.all(raw.unwritten.all(), WordRole::Unwritten);
    b.all(raw.irrelevant.all(), WordRole::Irrelevant);
    b.all(raw.unobserved.all(), WordRole::Unobserved);
    b.all(raw.likened.all(), WordRole::Likened);
    b.all(raw.hindsight.plain.all(), WordRole::Plain);
    b.all(raw.plain.all(), WordRole::Plain);

    let mut kinds: BTreeMap<String, GroupSet> =
        objects.iter().map(|o: &ObjectGroup| (o.id.clone(), o.own)).collect();
    for (name, members) in &raw.kinds {
        let mut set = GroupSet::default();
        for member in members {
            match objects.iter().find(|o| o.id == *member) {
                Some(o) => set = set.with(o.own),
                None => b.unknown_group(member),
            }
        }
        let known = kinds.entry(name.clone()).or_default();
        *known = known.with(set);
    }

    let kind = |id: &str| kinds.get(id).copied().unwrap_or_default();
    let acts = ["vehicle", "vru", "animal"].into_iter().fold(GroupSet::default(), |set, k| set.with(kind(k)));
    let known = KnownKinds {
        actor: acts,
        lead: kind("lead"),
        queue: kind("queue"),
        vehicle: kind("vehicle"),
        elsewhere: kind("oncoming").with(kind("parked_vehicle")).with(kind("broken_down")),
        no_cause: kind("gap").with(kind("lane")),
        road: kind("road"),
        gap: kind("gap"),
        light: kind("light"),
        sign: kind("sign"),
        route: kind("route"),
        sight: kind("occlusion"),
        adverse: kind("adverse"),
        condition: ["road_shape", "surface", "lighting", "weather", "occlusion", "dark"]
            .into_iter()
            .fold(GroupSet::default(), |set, k| set.with(kind(k)))
            .without(kind("rain").with(kind("snow"))),
    };

    // "Queue" implies waiting, and "no car" has no action.
    let is_user = |role: &WordRole| matches!(role, WordRole::Object(i) if objects[*i].own.meets(acts) && !objects[*i].own.meets(known.queue));
    let road_users = (b.texts.iter())
        .filter(|(text, role)| is_user(role) && !text.starts_with(['有', '无', '没']))
        .map(|(text, _)| text.clone())
        .collect();

    let Builder { texts, mut problems } = b;
    let trie = trie(texts.keys().map(String::as_str), &mut problems);
    let mut reasons: Vec<String> =
        raw.unobserved_because.all().flat_map(|p| expanded(p, &mut problems)).collect();
    reasons.sort_unstable();
    reasons.dedup();
    let reasons = self::trie(reasons.iter().map(String::as_str), &mut problems);
    let placeholders: HashSet<String> = raw.placeholder.all().map(bare).collect();
    let mut placeholder_starts: Vec<[char; 2]> = placeholders.iter().filter_map(|p| first_two(p)).collect();
    placeholder_starts.sort_unstable();
    let roles = texts.into_values().collect();
    let mut scene: Vec<String> = raw.scene.all().flat_map(|p| expanded(p, &mut problems)).collect();
    scene.sort_unstable();
    scene.dedup();
    let scene = self::trie(scene.iter().map(String::as_str), &mut problems);
    let aftermath = raw.aftermath.compile(&mut problems);
    let bearing = raw.bearing.compile(&mut problems);
    let names = raw.names.iter().map(|(id, n)| (id.clone(), Bilingual::new(&n.zh, &n.en))).collect();
    let compared = raw.compared.compile();
    let clauses = raw.clauses.compile();
    let words = LabelWords {
        objects,
        kinds,
        names,
        placeholders,
        placeholder_starts,
        unfinished: raw.unfinished.all().map(bare).collect(),
        instructions: raw.instructions.all().map(str::to_lowercase).collect(),
        draft_notes: raw.draft_notes.all().map(str::to_lowercase).collect(),
        trie,
        roles,
        reasons,
        scene,
        aftermath,
        bearing,
        imagined: raw.hindsight.imagined.all().map(str::to_owned).collect(),
        predicted: raw.hindsight.predicted.all().map(str::to_owned).collect(),
        lights: raw.lights.values().map(|w| w.all().map(str::to_owned).collect()).collect(),
        color_chars,
        numbers: raw.numbers.compile(),
        clauses,
        road_users,
        known,
        reaching,
        calm,
        opposite,
        compared,
        subjects: raw.subjects.compile(&mut problems),
        unchanged_course: raw.unchanged_course.all().map(str::to_owned).collect(),
        apart: super::apart::compile(&raw.apart, &mut problems),
        concepts: super::concepts::compile(&raw.concepts, &["unseen", "hides"], &mut problems),
        remote: raw.remote.compile(),
        forms: raw.forms.compile(&mut problems),
        quantities: raw.quantities.compile(),
        exits: raw.exits.iter().map(|w| w.all().map(str::to_owned).collect()).collect(),
        undecided: raw.undecided.compile(),
    };
    (words, problems)
}

/// A text without spaces and punctuation, in lower case: how placeholders are compared.
pub(super) fn bare(text: &str) -> String {
    text.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

fn first_two(text: &str) -> Option<[char; 2]> {
    let mut chars = text.chars();
    Some([chars.next()?, chars.next()?])
}

/// The doing of this name, as a set.
fn doing(raw: &File, id: &str, b: &mut Builder) -> Doings {
    match raw.doings.keys().position(|k| k == id) {
        Some(i) => Doings(1_u32.checked_shl(u32::try_from(i).unwrap_or(u32::MAX)).unwrap_or(0)),
        None => {
            b.problems
                .push(Bilingual::new(format!("doings 中没有 '{id}'"), format!("doings has no entry '{id}'")));
            Doings::default()
        }
    }
}

/// Reports a list of more than `maximum` entries; names of the list and of its entries in Chinese and English.
pub(super) fn limit(
    list: [&str; 2],
    entries: [&str; 2],
    n: usize,
    maximum: usize,
    problems: &mut Vec<Bilingual>,
) {
    if n > maximum {
        problems.push(Bilingual::new(
            format!("{} 至多 {maximum} {of}，现有 {n} {of}", list[0], of = entries[0]),
            format!("{} has {n} {}, maximum {maximum}", list[1], entries[1]),
        ));
    }
}

fn groups(raw: &File, b: &mut Builder) -> Vec<ObjectGroup> {
    limit(["objects"; 2], ["组", "groups"], raw.objects.len(), MAX_GROUPS, &mut b.problems);
    let own = |i: usize| GroupSet(1_u64.checked_shl(u32::try_from(i).unwrap_or(u32::MAX)).unwrap_or(0));
    let mut out: Vec<ObjectGroup> = raw
        .objects
        .iter()
        .enumerate()
        .map(|(i, o)| ObjectGroup { id: o.id.clone(), named: o.named, own: own(i), near: own(i) })
        .collect();
    for (i, o) in raw.objects.iter().enumerate() {
        for near in &o.near {
            match raw.objects.iter().position(|other| other.id == *near) {
                Some(j) => {
                    out[i].near = out[i].near.with(own(j));
                    out[j].near = out[j].near.with(own(i));
                }
                None => b.unknown_group(near),
            }
        }
    }
    out
}

pub(super) fn expanded(pattern: &str, problems: &mut Vec<Bilingual>) -> Vec<String> {
    match choices(pattern) {
        Some(texts) => texts.into_iter().map(|t| t.to_lowercase()).collect(),
        None => {
            problems.push(Bilingual::new(
                format!("模式 '{pattern}' 的括号不成对"),
                format!("pattern '{pattern}' has a bracket that is not closed"),
            ));
            Vec::new()
        }
    }
}

pub(super) fn trie<'w>(words: impl Iterator<Item = &'w str>, problems: &mut Vec<Bilingual>) -> Trie {
    Trie::new(words).unwrap_or_else(|| {
        problems.push(Bilingual::new(
            "词表过大，或含有基本多文种平面之外的字",
            "the word list is too large, or has characters outside the basic plane",
        ));
        Trie::default()
    })
}

struct Builder {
    texts: BTreeMap<String, WordRole>,
    problems: Vec<Bilingual>,
}

impl Builder {
    fn all<'w>(&mut self, patterns: impl Iterator<Item = &'w str>, role: WordRole) {
        for pattern in patterns {
            for text in expanded(pattern, &mut self.problems) {
                match self.texts.get(&text) {
                    Some(other) if *other != role => self.problems.push(Bilingual::new(
                        format!("'{text}' 在词表中有两种含义"),
                        format!("'{text}' has two meanings in the word list"),
                    )),
                    _ => {
                        self.texts.insert(text, role);
                    }
                }
            }
        }
    }

    fn unknown_group(&mut self, name: &str) {
        self.problems.push(Bilingual::new(
            format!("objects 中没有 '{name}'"),
            format!("objects has no group '{name}'"),
        ));
    }
}
