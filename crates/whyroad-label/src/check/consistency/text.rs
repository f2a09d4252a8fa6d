//! Texts with one another and with the class: components that repeat one another, a trace that names what no component
//! does, and words that belong to another class.

use crate::check::overlap;
use crate::check::reading::{Named, TextFacts};
use crate::check::subject;
use crate::check::texts::Texts;
use crate::check::view::View;
use whyroad_framework::LabelWords;
use whyroad_framework::check::class_index::Prescribed;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::label_words::{Compared, GroupSet, hashed};
use whyroad_model::Bilingual;
use whyroad_model::decision::Longitudinal;
use whyroad_model::label_fields::pointer;

/// Components beyond this are not compared with one another: people name two to five.
const COMPARED: usize = 40;
/// Share of the shorter text that the longer one holds, in pairs and in words.
const ALIKE: f64 = 0.8;
const ALIKE_WORDS: f64 = 0.88;
/// Fewer words, or characters, may be the same by chance.
const LEAST_WORDS: usize = 6;
const LEAST_CHARACTERS: usize = 9;
/// Fewer, where nearly all are the same.
const FEW_CHARACTERS: usize = 7;
/// No pair of texts is compared that shares less.
const FEWEST_CONTENT: f64 = 0.5;
/// Words and things, and the share of the shorter text that the longer one holds: of Latin letters, and Chinese.
const CONCEPTS_LATIN: (usize, f64) = (5, 0.7);
const CONCEPTS_CHINESE: (usize, f64) = (12, 0.62);
/// Words without articles, pronouns and auxiliaries.
const LEAST_CONTENT: usize = 4;

/// No component is said twice.
pub(in crate::check) fn duplicates(label: &View<'_>, texts: &Texts, words: &LabelWords, sink: &mut dyn Sink) {
    if label.parts.len() < 2 {
        return;
    }
    // Texts that name nothing in common are not taken apart.
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
    if !outlines.iter().enumerate().any(|(i, o)| outlines[..i].iter().any(|other| o.may_be_alike(other))) {
        return;
    }
    let all: Vec<(usize, Pieces)> = label
        .parts
        .iter()
        .zip(&texts.components)
        .take(COMPARED)
        .filter_map(|(c, facts)| Some((c.index, pieces(c.description.get()?, facts, &words.compared))))
        .collect();
    for (i, (index, own)) in all.iter().enumerate() {
        let Some((first, _)) = all[..i].iter().find(|(_, other)| is_alike(own, other)) else { continue };
        let at = pointer::critical_components_item_description(*index);
        sink.report(Finding::warning("label.component.duplicate", at), &|| {
            Words::new(
                format!("关键要素 {} 与 {} 说的是同一件事", first + 1, index + 1),
                format!("components {} and {} say the same", first + 1, index + 1),
            )
            .hint("合并为一个要素", "make one component of them")
        });
    }
}

/// A text taken apart.
struct Pieces {
    /// Characters, or words in Latin letters; hashed, sorted, each once.
    units: Vec<u64>,
    /// Pairs of them.
    pairs: Vec<u64>,
    /// Units that are not empty words.
    content: Vec<u64>,
    is_latin: bool,
    /// Groups that it names, with side and color: texts that differ in these differ.
    named: Vec<Said>,
}

/// Which units and pairs of units a text has, as bits: a bit that is missing is a unit that is missing. Most components
/// are told apart by it.
#[derive(Clone, Copy, Default)]
struct Outline {
    units: [u64; 2],
    pairs: [u64; 4],
    /// Units that are surely not empty words.
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

    /// False where [`is_alike`] is false, whatever the texts name.
    fn may_be_alike(&self, other: &Self) -> bool {
        let missing = |a: &[u64], b: &[u64]| -> usize {
            a.iter().zip(b).map(|(a, b)| (a & !b).count_ones() as usize).sum()
        };
        // Of the shorter list at most this share is missing in the other. Which one is shorter is not known here, nor
        // how often a unit is repeated.
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
type Said = (usize, Option<bool>, Option<usize>);

fn pieces(text: &str, facts: &TextFacts, words: &Compared) -> Pieces {
    let mut units: Vec<u64> = Vec::new();
    each_unit(text, words, |unit| units.push(unit));
    let mut pairs: Vec<u64> = units.windows(2).map(|w| pair_of(w[0], w[1])).collect();
    let mut content: Vec<u64> = units.iter().copied().filter(|u| !words.is_empty_word(*u)).collect();
    for list in [&mut units, &mut pairs, &mut content] {
        list.sort_unstable();
        list.dedup();
    }
    let mut named: Vec<_> = facts.named.iter().map(|n| (n.group, n.side, n.colour)).collect();
    named.sort_unstable();
    named.dedup();
    Pieces { units, pairs, content, is_latin: text.is_ascii(), named }
}

/// Gives each word of Latin letters and each character that is not a particle to `take`, hashed.
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
        let is_letter = matches!(c, '\u{4e00}'..='\u{9fff}') || (!c.is_ascii() && c.is_alphanumeric());
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
    // What one text leaves open is no difference.
    let differ = |n: &Said, m: &Said| {
        n.1.zip(m.1).is_some_and(|(x, y)| x != y) || n.2.zip(m.2).is_some_and(|(x, y)| x != y)
    };
    let apart = |n: &Said| {
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
    // The same words in another order: few words of Latin letters, or many Chinese characters.
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
    let same_things = a.named.iter().any(|n| b.named.iter().any(|m| m.0 == n.0));
    (same_things && share(&concepts(a), &concepts(b), least_concepts, part_concepts))
        || share(&a.pairs, &b.pairs, 5, ALIKE)
        || share(&a.units, &b.units, least, part)
        || (!a.is_latin && share(&a.units, &b.units, FEW_CHARACTERS, 0.95))
        || (a.is_latin && share(&a.content, &b.content, LEAST_CONTENT, 1.0))
        || (a.is_latin && a.content.len() >= 3 && a.content == b.content)
}

/// The trace speaks of what the components speak of. True when it has nothing to do with them. `acts`: it names the
/// ego, or something that a driver does.
pub(in crate::check) fn unrelated(
    label: &View<'_>,
    texts: &Texts,
    words: &LabelWords,
    background: GroupSet,
    acts: bool,
    sink: &mut dyn Sink,
) -> bool {
    if words.is_empty() || label.trace.get().is_none_or(|t| t.trim().is_empty()) {
        return false;
    }
    let components = texts.all_components(words);
    let nothing = texts.trace.groups.is_empty()
        && texts.trace.words == 0
        && !label.trace.get().is_some_and(|t| words.is_of_driving(t))
        || !acts && !texts.trace.groups.meets(components);
    let speaks_of = texts.trace.groups.without(background);
    if !nothing && (components.is_empty() || speaks_of.is_empty() || texts.trace.groups.meets(components)) {
        return false;
    }
    // Other words may still be shared, fewer of them where a component is in words that no list knows.
    let enough = |t: &str| if t.is_ascii() || any_unread(label, texts, words) { 1 } else { 2 };
    if label.trace.get().is_some_and(|t| {
        overlap::shared(label, t, &words.compared, &|_| true) >= enough(t)
            || overlap::shares_characters(label, t, words)
    }) {
        return false;
    }
    sink.report(Finding::warning("label.text.unrelated", pointer::COC_TRACE), &|| {
        Words::new(
            "因果描述与关键要素无关：没有提到其中任何一个",
            "the trace has nothing to do with the components: it names none of them",
        )
        .hint("按要素写出状态、原因、决策", "write state, reason and decision from the components")
    });
    true
}

/// Each thing in the trace, as far as `until`, is in a component.
pub(in crate::check) fn unnamed(
    label: &View<'_>,
    texts: &Texts,
    words: &LabelWords,
    background: GroupSet,
    until: usize,
    sink: &mut dyn Sink,
) {
    let Some(text) = label.trace.get() else { return };
    // What a component that cannot be read names is not known: that of a broken field.
    let unread = label.parts.iter().any(|c| c.description.get().is_none());
    if unread || texts.all_components(words).is_empty() {
        return;
    }
    let (any, beside) = (texts.components_there(words, false), texts.components_there(words, true));
    let is_new = |n: &&Named| {
        let group = &words.objects[n.group];
        group.named && !group.own.meets(if n.side.is_some() { beside } else { any })
    };
    let mut new = texts.trace.there().filter(|n| n.start < until).filter(is_new).peekable();
    // In other words, or one that a component has in words that no list knows: most labels do not come to this.
    let unread = new.peek().map(|_| Unread::of(label, texts, words, background));
    let Some(n) = new.find(|n| unread.as_ref().is_some_and(|u| !u.may_name(text, n, texts, words))) else {
        return differs(label, texts, words, until, sink);
    };
    sink.report(
        Finding::warning("label.trace.unnamed_object", pointer::COC_TRACE).part(n.start, n.end),
        &|| {
            let thing = &text[n.start..n.end];
            Words::new(
                format!("因果描述提到“{thing}”，但没有任何关键要素提到它"),
                format!("the trace speaks of '{thing}', which no critical component names"),
            )
            .hint("补上该要素，或从因果描述中删去", "add it as a component, or leave it out of the trace")
        },
    );
}

/// What components speak of in words that no list knows.
struct Unread<'a> {
    /// All components.
    all: Vec<&'a str>,
    /// Those whose thing was not read.
    things: Vec<&'a str>,
    /// Without more than a place, so that any sign or surface may be meant.
    place_only: bool,
}

impl<'a> Unread<'a> {
    fn of(label: &View<'a>, texts: &Texts, words: &LabelWords, background: GroupSet) -> Self {
        let parts = || {
            let parts = label.parts.iter().zip(&texts.components);
            parts.filter_map(|(c, f)| Some((c.description.get()?, f)))
        };
        let place_only = |f: &TextFacts| {
            let own = f.groups.without(background).is_empty() && f.states.is_empty();
            own && !f.groups.is_empty() && !f.groups.meets(words.known.no_cause)
        };
        Self {
            all: parts().map(|(t, _)| t).collect(),
            things: parts().filter(|(t, f)| subject::is_unread(t, f, words)).map(|(t, _)| t).collect(),
            place_only: parts().any(|(_, f)| place_only(f)),
        }
    }

    /// A component may speak of the thing `n` of the trace `text`: it has a word of its name; or its own thing was not
    /// read, and the clause of `n` has words of the component, or no clause has.
    fn may_name(&self, text: &str, n: &Named, texts: &Texts, words: &LabelWords) -> bool {
        let compared = &words.compared;
        let acts = words.objects[n.group].own.meets(words.known.actor);
        if self.place_only && !acts {
            return true;
        }
        if self.all.iter().any(|c| overlap::has_word_of(c, &text[n.start..n.end], acts, words)) {
            return true;
        }
        // "The vehicle": whatever it is called in the component.
        if !self.things.is_empty() && words.subjects.general.contains(&text[n.start..n.end].to_lowercase()) {
            return true;
        }
        let (from, to) = words.clauses.around(&texts.units, n.start..n.end, text.len(), &|_| true);
        let joint = |part: &str, at: &dyn Fn(usize, usize) -> usize, last: bool| {
            let all = words.clauses.beside.iter().filter_map(|w| {
                let found = if last { part.rfind(w.as_str()) } else { part.find(w.as_str()) };
                found.map(|i| at(i, w.len()))
            });
            if last { all.max() } else { all.min() }
        };
        let from = joint(&text[from..n.start], &|i, length| from + i + length, true).unwrap_or(from);
        let to = joint(&text[n.end..to], &|i, _| n.end + i, false).unwrap_or(to);
        let introduced = subject::is_introduced(text, n.start, words);
        self.things.iter().any(|c| {
            let shared = |inside: &dyn Fn(usize) -> bool| overlap::shared_with(c, text, compared, inside);
            let inside = |at: usize| (from..to).contains(&at) && !(n.start..n.end).contains(&at);
            shared(&inside) > 0 || (!introduced && shared(&|_| true) == 0)
        })
    }
}

/// What the trace says of a thing's side and color is what its component says.
fn differs(label: &View<'_>, texts: &Texts, words: &LabelWords, until: usize, sink: &mut dyn Sink) {
    let Some(text) = label.trace.get() else { return };
    let meant = |n: &Named| -> Vec<&Named> {
        let group = &words.objects[n.group];
        let all = || texts.components.iter().flat_map(|f| f.there()).filter(|c| words.objects[c.group].named);
        // Whoever is called by the same name, otherwise whoever may be meant.
        let same: Vec<&Named> = all().filter(|c| words.objects[c.group].own == group.own).collect();
        if same.is_empty() {
            all().filter(|c| words.objects[c.group].own.meets(group.near)).collect()
        } else {
            same
        }
    };
    // "The blue car" for the white one: the color is part of the word.
    let painted = |text: Option<&str>, n: &Named| {
        let mut word = text?.get(n.start..n.end)?.chars();
        let colour = word.next().filter(|c| "白黑红蓝灰银黄绿".contains(*c))?;
        (word.as_str() == "车").then_some(colour)
    };
    let given = || {
        let parts = label.parts.iter().zip(&texts.components);
        parts.flat_map(move |(c, f)| f.there().filter_map(move |n| painted(c.description.get(), n)))
    };
    let other_car = |n: &Named| {
        painted(Some(text), n).is_some_and(|c| given().next().is_some() && !given().any(|g| g == c))
    };
    let differs = |n: &&Named| {
        if !words.objects[n.group].named {
            return false;
        }
        // Most are said without either.
        let same = if n.side.is_some() || n.colour.is_some() { meant(n) } else { Vec::new() };
        let side = n.side.is_some_and(|s| {
            same.iter().any(|c| c.side == Some(!s)) && !same.iter().any(|c| c.side == Some(s))
        });
        let colour = n.colour.is_some_and(|k| {
            same.iter().any(|c| c.colour.is_some_and(|o| o != k)) && !same.iter().any(|c| c.colour == Some(k))
        });
        side || colour || other_car(n)
    };
    let other_light = || other_light(label, texts, words, until);
    let Some(n) = texts.trace.there().filter(|n| n.start < until).find(differs).or_else(other_light) else {
        return;
    };
    sink.report(Finding::warning("label.trace.object_differs", pointer::COC_TRACE).part(n.start, n.end), &|| {
        let thing = &text[n.start..n.end];
        Words::new(
            format!("因果描述中的“{thing}”与关键要素所说的方位或颜色不同"),
            format!("the trace puts '{thing}' on another side, or gives it another color, than the component does"),
        )
        .hint("改正其中有误的一处", "correct the one that is wrong")
    });
}

/// The light of the trace, where it has a color that no component gives a light.
fn other_light<'t>(
    label: &View<'_>,
    texts: &'t Texts,
    words: &LabelWords,
    until: usize,
) -> Option<&'t Named> {
    if !texts.trace.groups.meets(words.known.light) {
        return None;
    }
    let colour = |text: Option<&str>, n: &Named| {
        let word = text?.get(n.start..n.end)?.to_lowercase();
        let last = |names: &[String]| names.iter().filter_map(|w| word.rfind(w.as_str())).max();
        // The last one: "from green to yellow".
        let all = words.lights.iter().enumerate();
        all.filter_map(|(i, names)| Some((last(names)?, i))).max().map(|(_, i)| i)
    };
    let is_light = |n: &&Named| words.objects[n.group].own.meets(words.known.light);
    let given: Vec<usize> = label
        .parts
        .iter()
        .zip(&texts.components)
        .flat_map(|(c, f)| f.there().filter(is_light).filter_map(|n| colour(c.description.get(), n)))
        .collect();
    let said: Vec<(&Named, usize)> = texts
        .trace
        .there()
        .filter(|n| n.start < until)
        .filter(is_light)
        .filter_map(|n| Some((n, colour(label.trace.get(), n)?)))
        .collect();
    let (n, _) = said.first()?;
    (!given.is_empty() && !said.iter().any(|(_, c)| given.contains(c))).then_some(n)
}

/// Some component speaks of a thing in words that no list knows.
fn any_unread(label: &View<'_>, texts: &Texts, words: &LabelWords) -> bool {
    let mut parts = label.parts.iter().zip(&texts.components);
    parts.any(|(c, f)| c.description.get().is_none_or(|t| subject::is_unread(t, f, words)))
}

/// A stop is decided once: whoever stands already and goes on standing decides nothing (LABELING.md 6, minimality).
pub(in crate::check) fn unchanged(label: &View<'_>, texts: &Texts, sink: &mut dyn Sink) {
    let stops = matches!(
        label.longitudinal.get(),
        Some(
            Longitudinal::StopForRegulation
                | Longitudinal::StopForObstacle
                | Longitudinal::YieldToAgent
                | Longitudinal::LeadFollowing
        )
    );
    let (Some((start, end)), Some(text), true) = (texts.trace.unchanged, label.trace.get(), stops) else {
        return;
    };
    sink.report(
        Finding::warning("label.decision.unchanged", pointer::DRIVING_DECISION_LONGITUDINAL),
        &|| {
            let phrase = &text[start..end];
            Words::new(
                format!("因果描述说“{phrase}”：自车只是保持原状，没有做出新的决策"),
                format!("the trace says '{phrase}': the ego goes on as before, which is no new decision"),
            )
            .hint(
                "选“无决策变化”；或把关键帧移到自车开始减速之前",
                "choose 'no change of decision', or move the keyframe to before the ego starts to slow",
            )
        },
    );
}

/// The texts speak of what the class is about. Reported only where they speak of something else, and of nothing and
/// nobody whom no list knows. `background`: what no text is about.
pub(in crate::check) fn class(
    label: &View<'_>,
    texts: &Texts,
    words: &LabelWords,
    background: GroupSet,
    prescribed: &Prescribed,
    sink: &mut dyn Sink,
) -> bool {
    let Some(class) = &prescribed.decisions else { return false };
    if class.about.is_empty() || texts.components.is_empty() || words.is_empty() {
        return false;
    }
    let all = texts.components.iter().fold(texts.trace.groups, |set, f| set.with(f.groups));
    let unknown_actor = texts.components.iter().any(|f| !f.states.is_empty());
    if all.meets(class.about) || all.without(background).is_empty() || unknown_actor {
        return false;
    }
    if any_unread(label, texts, words) {
        return false;
    }
    sink.report(Finding::warning("label.text.class", pointer::SCENARIO), &|| {
        let about: Vec<Bilingual> = class.about_names.iter().map(|id| words.kind_name(id)).collect();
        let list = |pick: fn(&Bilingual) -> &String, or: &str| {
            about.iter().map(|b| pick(b).as_str()).collect::<Vec<_>>().join(or)
        };
        Words::new(
            format!("“{}”的文字应提到：{}；这里没有", prescribed.title.zh, list(|b| &b.zh, "、")),
            format!(
                "the texts of '{}' should speak of: {}; these do not",
                prescribed.title.en,
                list(|b| &b.en, ", ")
            ),
        )
        .hint(
            "检查场景类别，或补上触发决策的要素",
            "check the scenario class, or add the component that triggered the decision",
        )
    });
    true
}
