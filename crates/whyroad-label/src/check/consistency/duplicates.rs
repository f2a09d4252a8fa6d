//! Components with the same meaning, in equal or similar words.

use super::meaning::Meaning;
use crate::check::reading::{Named, TextFacts};
use crate::check::texts::TextScope;
use crate::check::{overlap, subject};
use whyroad_framework::LabelWords;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::label_words::{Compared, GroupSet, hashed};
use whyroad_model::label_fields::pointer;

/// Maximum number of components that are compared with each other; people usually name two to five.
const COMPARED: usize = 40;
/// Minimum share of the shorter text that the longer one contains, in pairs and in words.
const ALIKE: f64 = 0.8;
const ALIKE_WORDS: f64 = 0.88;
/// Minimum number of words, or characters; fewer may be equal by chance.
const LEAST_WORDS: usize = 6;
const LEAST_CHARACTERS: usize = 9;
/// A lower minimum, where nearly all are equal.
const FEW_CHARACTERS: usize = 7;
/// Pairs of texts with a smaller common share are not compared.
const FEWEST_CONTENT: f64 = 0.5;
/// Minimum number of words and things, and share of the shorter text that the longer one contains: in Latin letters,
/// and in Chinese.
const CONCEPTS_LATIN: (usize, f64) = (5, 0.7);
const CONCEPTS_CHINESE: (usize, f64) = (12, 0.62);
/// Shorter lengths are widths and margins, which things of one kind may have in common.
const LEAST_DISTANCE_M: f64 = 5.0;
/// Minimum number of words without articles, pronouns and auxiliaries.
const LEAST_CONTENT: usize = 4;

/// No component is a duplicate of another one.
///
/// `background`: things that are not the subject of a text.
pub(in crate::check) fn duplicates(scope: &TextScope<'_>, sink: &mut dyn Sink) {
    let TextScope { label, texts, words, background, .. } = *scope;
    if label.parts.len() < 2 {
        return;
    }
    // Texts that name nothing in common are not compared in detail.
    let near = |f: &TextFacts| {
        f.named.iter().fold(GroupSet::default(), |set, n| set.with(words.objects[n.group].near))
    };
    let groups: Vec<GroupSet> = texts.components.iter().take(COMPARED).map(near).collect();
    let may_repeat = groups
        .iter()
        .enumerate()
        .any(|(i, g)| groups[..i].iter().any(|other| other.meets(*g) || other.is_empty() || g.is_empty()));
    if !may_repeat {
        return;
    }
    let outlines: Vec<Outline> = label
        .parts
        .iter()
        .take(COMPARED)
        .filter_map(|c| Some(Outline::of(c.description.get()?, &words.compared)))
        .collect();
    let facts = &texts.components[..texts.components.len().min(COMPARED)];
    let text = |k: usize| label.parts[k].description.get().unwrap_or_default();
    // An action of the ego differs from an action of another road user.
    let of_ego = |k: usize| {
        text(k).split(['，', ',', '。', ';', '；']).any(|c| {
            let c = c.trim_start();
            words.subjects.begins_with_ego(c) || words.subjects.begins_with_own_system(c)
        })
    };
    let meanings: Vec<Meaning<'_>> =
        (0..facts.len()).map(|k| Meaning::of(text(k), &facts[k], words, background)).collect();
    // Two linked objects are two things, however similar the texts are.
    let linked = |k: usize| &label.parts[k].objects;
    let other_objects = |i: usize, j: usize| {
        !linked(i).is_empty() && !linked(j).is_empty() && !linked(i).iter().any(|id| linked(j).contains(id))
    };
    let lanes: Vec<u8> = (0..facts.len()).map(|k| lanes(text(k), &facts[k], words)).collect();
    let other_lanes = |i: usize, j: usize| lanes[i] != 0 && lanes[j] != 0 && lanes[i] & lanes[j] == 0;
    let are_two = |i: usize, j: usize| other_objects(i, j) || other_lanes(i, j);
    let same_facts = |i: usize, j: usize| {
        !are_two(i, j)
            && groups[i].meets(groups[j])
            && of_ego(i) == of_ego(j)
            && (introduced_twice((text(i), &facts[i]), (text(j), &facts[j]), words)
                || meanings[i].may_repeat(&meanings[j])
                    && (adds_nothing((text(i), &facts[i]), (text(j), &facts[j]), words, background)
                        || adds_nothing((text(j), &facts[j]), (text(i), &facts[i]), words, background))
                || meanings[i].is_same(&meanings[j], words))
    };
    let by_facts = (1..facts.len()).any(|i| (0..i).any(|j| same_facts(i, j)));
    let by_words =
        outlines.iter().enumerate().any(|(i, o)| outlines[..i].iter().any(|other| o.may_be_alike(other)));
    if !by_words && !by_facts {
        return;
    }
    // Components that cannot be read are no parts: the place among the parts differs from the index in the document.
    let all: Vec<(usize, Pieces)> = label
        .parts
        .iter()
        .zip(&texts.components)
        .take(COMPARED)
        .enumerate()
        .filter_map(|(k, (c, facts))| Some((k, pieces(c.description.get()?, facts, &words.compared))))
        .collect();
    for (i, (at, own)) in all.iter().enumerate() {
        let alike = |(k, other): &&(usize, Pieces)| {
            !are_two(*at, *k) && is_alike(own, other) || by_facts && same_facts(*at, *k)
        };
        let Some((first, _)) = all[..i].iter().find(alike) else { continue };
        let [first, index] = [*first, *at].map(|k| label.parts[k].index);
        let at = pointer::critical_components_item_description(index);
        sink.report(Finding::warning("label.component.duplicate", at), &|| {
            Words::new(
                format!("关键要素 {} 与 {} 说的是同一件事", first + 1, index + 1),
                format!("components {} and {} have the same meaning", first + 1, index + 1),
            )
            .hint("合并为一个要素", "merge them into one component")
        });
    }
}

/// The lanes that a text names, one bit each: that of the ego, the left one, the right one.
fn lanes(text: &str, facts: &TextFacts, words: &LabelWords) -> u8 {
    let lower = text.to_ascii_lowercase();
    let own = words.subjects.own_lane.iter().any(|w| lower.contains(w.as_str()));
    let named = facts.named.iter().filter_map(|n| lower.get(n.start..n.end));
    let lanes = named.filter(|word| word.ends_with("lane") || word.ends_with("车道"));
    lanes.fold(u8::from(own), |bits, word| match word {
        word if word.starts_with("left") || word.contains('左') => bits | 2,
        word if word.starts_with("right") || word.contains('右') => bits | 4,
        _ => bits,
    })
}

/// The first text adds nothing about its things: no thing, side, color or number that the second does not have, and
/// both describe the same road users.
fn adds_nothing(
    a: (&str, &TextFacts),
    b: (&str, &TextFacts),
    words: &LabelWords,
    background: GroupSet,
) -> bool {
    let own = |n: &Named| words.objects[n.group].own;
    // A vehicle on the same side, or of the same color, may have any name.
    let alike = |n: &Named, m: &Named| {
        let marked = (n.side.is_some() && n.side == m.side) || (n.color.is_some() && n.color == m.color);
        own(n).meets(words.known.vehicle) && own(m).meets(words.known.vehicle) && marked
    };
    let near = |n: &Named, m: &Named| own(n).meets(words.objects[m.group].near) || alike(n, m);
    let is_known = |n: &Named| {
        let agrees = |m: &&Named| {
            n.absent == m.absent
                && n.supposed == m.supposed
                && (n.side.is_none() || n.side == m.side)
                && (n.color.is_none() || m.color.is_none() || n.color == m.color)
        };
        own(n).without(words.known.road).is_empty()
            || b.1.named.iter().filter(|m| near(n, m)).any(|m| agrees(&m))
    };
    if same_place(a, b, words, &near) {
        return true;
    }
    if !a.1.named.iter().all(is_known) {
        return false;
    }
    // Things that both say are present, except for places.
    let things = |f: &'_ TextFacts| {
        let there = f.there().filter(|n| !own(n).meets(background));
        there.fold(GroupSet::default(), |set, n| set.with(own(n)))
    };
    let shared = |n: &&Named| !own(n).meets(background) && b.1.there().any(|m| near(n, m));
    let both = a.1.there().filter(shared).fold(GroupSet::default(), |set, n| set.with(own(n)));
    let same = if both.meets(words.known.actor) {
        // Introduced twice at the same place, where one does nothing that is known.
        let new = |text: &str, n: &Named| subject::is_introduced(text, n.start, words);
        let twice = |n: &Named| {
            let painted = |m: &Named| n.color.is_some() && n.color == m.color;
            let again = |m: &Named| {
                near(n, m)
                    && n.side.is_some()
                    && n.side == m.side
                    && (new(a.0, n) && new(b.0, m) || painted(m))
            };
            own(n).meets(words.known.actor) && b.1.there().any(again)
        };
        let open = a.1.does.is_empty() || b.1.does.is_empty();
        a.1.does.meets(b.1.does) || open && a.1.there().any(twice)
    } else if both.meets(words.known.light) {
        let color = |text| words.light_color(text);
        things(a.1).without(words.known.light).is_empty() && color(a.0).is_some() && color(a.0) == color(b.0)
    } else {
        let sided = |n: &Named| n.side.is_some() && b.1.there().any(|m| near(n, m) && n.side == m.side);
        !both.is_empty() && (both.0.count_ones() > 1 || a.1.there().any(sided) || a.1.does.meets(b.1.does))
    };
    same && (!words.numbers.any(a.0) || words.numbers.any(b.0))
}

/// Both introduce a road user of one kind as if it had not been named, and nothing shows that there are two: no other
/// side, color, number or distance, and no action of one that excludes the action of the other.
fn introduced_twice(a: (&str, &TextFacts), b: (&str, &TextFacts), words: &LabelWords) -> bool {
    let acts = |n: &&Named| words.objects[n.group].own.meets(words.known.actor);
    let head = |(t, f): (&str, &TextFacts)| {
        let n = *f.there().find(acts)?;
        subject::is_introduced(t, n.start, words).then_some(n)
    };
    let (Some(n), Some(m)) = (head(a), head(b)) else { return false };
    let same = words.objects[n.group].own == words.objects[m.group].own;
    let other = n.side.zip(m.side).is_some_and(|(x, y)| x != y)
        || n.color.zip(m.color).is_some_and(|(x, y)| x != y)
        || n.side.is_some() != m.side.is_some() && n.color.is_none()
        || words.tells_another(a.0)
        || words.tells_another(b.0);
    let lengths = |text| words.quantities.lengths(text);
    let (x, y) = (lengths(a.0), lengths(b.0));
    let apart = !x.is_empty() && !y.is_empty() && !x.iter().any(|q| y.iter().any(|r| q.is_about(r)));
    let doing = a.1.does.meets(b.1.does) || a.1.does.is_empty() != b.1.does.is_empty();
    same && !other && !apart && doing
}

/// Both describe a road user of one kind at the same distance, and neither says that there is another: two at the same
/// distance would be distinguished.
fn same_place(
    a: (&str, &TextFacts),
    b: (&str, &TextFacts),
    words: &LabelWords,
    near: &dyn Fn(&Named, &Named) -> bool,
) -> bool {
    let acts = |f: &&Named| words.objects[f.group].own.meets(words.known.actor.with(words.known.adverse));
    let (Some(n), Some(m)) = (a.1.there().find(acts), b.1.there().find(acts)) else { return false };
    let differ =
        n.side.zip(m.side).is_some_and(|(x, y)| x != y) || n.color.zip(m.color).is_some_and(|(x, y)| x != y);
    if differ || !near(n, m) && !near(m, n) || words.tells_another(a.0) || words.tells_another(b.0) {
        return false;
    }
    let lengths = |text| words.quantities.lengths(text);
    match (lengths(a.0).as_slice(), lengths(b.0).as_slice()) {
        ([x], [y]) => x.is_about(y) && x.value >= LEAST_DISTANCE_M,
        _ => false,
    }
}

/// A text in its parts.
struct Pieces {
    /// Characters, or words in Latin letters; hashed, sorted, without repetitions.
    units: Vec<u64>,
    /// Pairs of adjacent units.
    pairs: Vec<u64>,
    /// Units that are not function words.
    content: Vec<u64>,
    is_latin: bool,
    /// Groups that it names, with side and color: texts with different ones differ.
    named: Vec<Mentioned>,
}

/// Units and pairs of units of a text, as bits: a missing bit means a missing unit. Most pairs of components are
/// distinguished by this alone.
#[derive(Clone, Copy, Default)]
struct Outline {
    units: [u64; 2],
    pairs: [u64; 4],
    /// Units that are surely not function words.
    content: [u64; 2],
    /// With repetitions.
    count: usize,
}

impl Outline {
    fn of(text: &str, words: &Compared) -> Self {
        let mut out = Self::default();
        let mut last = None;
        each_unit(text, words, |unit| {
            let bits = unit.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let (word, bit) = ((bits >> 63) as usize, 1 << (bits >> 57 & 63));
            out.units[word] |= bit;
            if !words.may_be_empty(unit) {
                out.content[word] |= bit;
            }
            if let Some(last) = last.replace(unit) {
                let bits = pair_of(last, unit).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                out.pairs[(bits >> 62) as usize] |= 1 << (bits >> 56 & 63);
            }
            out.count += 1;
        });
        out
    }

    /// False only where [`is_alike`] is false, whatever the texts name.
    fn may_be_alike(&self, other: &Self) -> bool {
        let missing = |a: &[u64], b: &[u64]| -> usize {
            a.iter().zip(b).map(|(a, b)| (a & !b).count_ones() as usize).sum()
        };
        // Of the shorter list at most this share may be missing in the other. It is not known here which one is
        // shorter, nor how often a unit is repeated.
        let few =
            |a: &[u64], b: &[u64], count: usize| missing(a, b) as f64 <= (1.0 - ALIKE) * count as f64 + 1e-6;
        few(&self.units, &other.units, self.count)
            || few(&other.units, &self.units, other.count)
            || few(&self.pairs, &other.pairs, self.count)
            || few(&other.pairs, &self.pairs, other.count)
            || missing(&self.content, &other.units) as f64 <= (1.0 - FEWEST_CONTENT) * self.count as f64
            || missing(&other.content, &self.units) as f64 <= (1.0 - FEWEST_CONTENT) * other.count as f64
    }
}

/// Group, side, color.
type Mentioned = (usize, Option<bool>, Option<usize>);

fn pieces(text: &str, facts: &TextFacts, words: &Compared) -> Pieces {
    let mut units: Vec<u64> = Vec::new();
    each_unit(text, words, |unit| units.push(unit));
    let mut pairs: Vec<u64> = units.windows(2).map(|w| pair_of(w[0], w[1])).collect();
    let mut content: Vec<u64> = units.iter().copied().filter(|u| !words.is_empty_word(*u)).collect();
    for list in [&mut units, &mut pairs, &mut content] {
        list.sort_unstable();
        list.dedup();
    }
    let mut named: Vec<_> = facts.named.iter().map(|n| (n.group, n.side, n.color)).collect();
    named.sort_unstable();
    named.dedup();
    Pieces { units, pairs, content, is_latin: text.is_ascii(), named }
}

/// Calls `take` with the hash of each Latin word and of each character that is not a particle.
fn each_unit(text: &str, words: &Compared, mut take: impl FnMut(u64)) {
    let mut word = 0_u64;
    for c in text.chars() {
        if c.is_ascii_alphanumeric() {
            word = hashed(word, c);
            continue;
        }
        if word != 0 {
            take(word);
            word = 0;
        }
        // Particles make no difference.
        let is_letter = overlap::is_han(c) || (!c.is_ascii() && c.is_alphanumeric());
        if is_letter && !words.particles.contains(c) {
            take(u64::from(c) | 1 << 40);
        }
    }
    if word != 0 {
        take(word);
    }
}

fn pair_of(first: u64, second: u64) -> u64 {
    first.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(17) ^ second
}

fn is_alike(a: &Pieces, b: &Pieces) -> bool {
    if a.units == b.units && a.pairs == b.pairs {
        return !a.units.is_empty();
    }
    // Something that one text does not state is no difference.
    let differ = |n: &Mentioned, m: &Mentioned| {
        n.1.zip(m.1).is_some_and(|(x, y)| x != y) || n.2.zip(m.2).is_some_and(|(x, y)| x != y)
    };
    let apart = |n: &Mentioned| {
        let same = b.named.iter().filter(|m| n.0 == m.0);
        same.clone().next().is_some() && same.clone().all(|m| differ(n, m))
    };
    if a.named.iter().any(apart) {
        return false;
    }
    let share = |a: &[u64], b: &[u64], least: usize, part: f64| {
        let shorter = a.len().min(b.len());
        let common = a.iter().filter(|p| b.binary_search(p).is_ok()).count();
        shorter >= least && common as f64 >= part * shorter as f64
    };
    // The same words in another order: a few Latin words, or many Chinese characters.
    let (least, part) = if a.is_latin { (LEAST_WORDS, ALIKE_WORDS) } else { (LEAST_CHARACTERS, ALIKE) };
    // The same things, sides and colors, in mostly the same words.
    let concepts = |p: &Pieces| {
        let groups = p.named.iter().map(|n| hashed(n.0 as u64 + 1, '#'));
        let mut all: Vec<u64> = p.content.iter().copied().chain(groups).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let (least_concepts, part_concepts) = if a.is_latin { CONCEPTS_LATIN } else { CONCEPTS_CHINESE };
    let (few, many) = if a.named.len() <= b.named.len() { (a, b) } else { (b, a) };
    let same_things =
        !few.named.is_empty() && few.named.iter().all(|n| many.named.iter().any(|m| m.0 == n.0));
    (same_things && share(&concepts(a), &concepts(b), least_concepts, part_concepts))
        || share(&a.pairs, &b.pairs, 5, ALIKE)
        || share(&a.units, &b.units, least, part)
        || (!a.is_latin && share(&a.units, &b.units, FEW_CHARACTERS, 0.95))
        || (a.is_latin && share(&a.content, &b.content, LEAST_CONTENT, 1.0))
        || (a.is_latin && a.content.len() >= 3 && a.content == b.content)
}
