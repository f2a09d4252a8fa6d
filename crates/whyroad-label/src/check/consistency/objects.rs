//! Things in the trace that no component names, or that have another location or color there. A component in words that
//! are in no list may name anything.

use crate::check::consistency::attributes;
use crate::check::consistency::given::{Given, painted, turned};
use crate::check::consistency::trace_rules::Said;
use crate::check::overlap;
use crate::check::reading::{Named, TextFacts};
use crate::check::subject;
use crate::check::texts::{TextScope, Texts};
use crate::check::view::View;
use std::collections::BTreeSet;
use std::ops::Range;
use whyroad_framework::LabelWords;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::label_words::{Divider, GroupSet};
use whyroad_model::label_fields::pointer;

/// Each thing in the trace, up to `until`, is in a component.
pub(in crate::check) fn unnamed(scope: &TextScope<'_>, until: usize, said: Said, sink: &mut dyn Sink) {
    let TextScope { label, texts, words, background, about, .. } = *scope;
    let Some(text) = label.trace.get() else { return };
    // The things of a component that cannot be read, such as a malformed field, are not known.
    let unread = label.parts.iter().any(|c| c.description.get().is_none());
    if unread || texts.all_components(words).is_empty() {
        return;
    }
    let (any, beside) = (texts.components_there(words, false), texts.components_there(words, true));
    let is_new = |n: &&Named| {
        let group = &words.objects[n.group];
        group.named && !group.own.meets(if n.side.is_some() { beside } else { any })
    };
    // "The vehicle" may be the ego if the trace states its decision in words that are in no list.
    let may_be_ego = |n: &Named| {
        said == Said::Unread
            && (words.subjects.is_general(&text[n.start..n.end])
                || !subject::is_introduced(text, n.start, words))
    };
    // So may "the car", where no component mentions one; and a "light" may be a vehicle's.
    let says_little = |n: &Named| {
        let name = &text[n.start..n.end];
        let is_given = || !subject::is_introduced(text, n.start, words);
        words.subjects.is_vague(name)
            || words.subjects.is_part(name) && is_given()
            || !any.meets(words.known.vehicle)
                && words.objects[n.group].own.meets(words.known.vehicle)
                && words.subjects.may_be_ego.iter().any(|w| ends_with(&text[..n.end], w))
                && (words.subjects.is_general(name) || text.is_ascii() || is_given())
    };
    // "Traffic or no traffic".
    let either =
        |n: &Named| texts.trace.named.iter().any(|m| m.absent && m.group == n.group && m.clause == n.clause);
    // If the class is about the road or the view, other words may describe their condition: "a crater of a pothole".
    let describes = |n: &Named| {
        about.meets(words.known.condition) && words.objects[n.group].own.meets(words.known.condition)
    };
    // "Its trailer" belongs to the named road user; "cars either side" are any cars: in English, a road user that is
    // introduced as a cause at the beginning of a sentence has an article.
    let is_beside = |n: &Named| {
        let before = text[..n.start].trim_end();
        let begins = before.is_empty() || before.ends_with(['.', '!', '?', ';']);
        text[n.start..n.end].is_ascii() && (begins || subject::is_owned(before, words))
    };
    // Why the cause was not observed: "UNOBSERVED, because the officer's order cannot be heard".
    let unobserved = texts
        .trace
        .unobserved
        .map(|(a, b)| words.clauses.around(&texts.units, a..b, text.len(), &|d| d == Divider::Sentence));
    // "A car's length short", "wide enough for a car of our size".
    let measures = |n: &Named| {
        let behind = text[n.end..].trim_start_matches("'s").trim_start();
        let measure = ["length", "width", "of our size", "like ours", "of this size", "of its size"];
        measure.iter().any(|w| behind.starts_with(w))
    };
    // "A driver may misjudge us": it need not be there.
    let may_be = |n: &Named| {
        let mut clause = true;
        let next = text[n.end..].split(' ').take(6).take_while(|w| {
            let inside = clause;
            clause &= !w.ends_with([',', ';', '.', ':']);
            inside
        });
        text[n.start..n.end].is_ascii() && next.into_iter().any(|w| ["may", "might", "could"].contains(&w))
    };
    let is_of_unobserved = |n: &Named| unobserved.is_some_and(|(a, b)| (a..b).contains(&n.start));
    let is_new = |n: &&Named| {
        is_new(n)
            && !may_be_ego(n)
            && !says_little(n)
            && !either(n)
            && !describes(n)
            && !is_beside(n)
            && !is_of_unobserved(n)
            && !measures(n)
            && !may_be(n)
            && !subject::is_no_noun(text, n.start, n.end, words)
            && is_presented(text, n, texts, words)
    };
    let mut new = texts.trace.there().filter(|n| n.start < until).filter(is_new).peekable();
    // In other words, or in a component's words that are in no list: few labels reach this check.
    let unread = new.peek().map(|_| Unread::of(label, texts, words, background));
    let Some(n) = new.find(|n| unread.as_ref().is_some_and(|u| !u.may_name(text, n, texts, words))) else {
        return differs(scope, until, said, sink);
    };
    sink.report(
        Finding::warning("label.trace.unnamed_object", pointer::COC_TRACE).part(n.start, n.end),
        &|| {
            let thing = &text[n.start..n.end];
            Words::new(
                format!("因果描述提到“{thing}”，但没有任何关键要素提到它"),
                format!("the trace mentions '{thing}', which no critical component names"),
            )
            .hint("补上该要素，或从因果描述中删去", "add it as a component, or remove it from the trace")
        },
    );
}

/// The trace says that the thing is there: it introduces it ("a cyclist", "有个骑手"), says on which side or where it
/// is, or begins a clause with it in Chinese. A name behind a verb, a preposition or "the" may be of something said in
/// general, long passed or known by another word: "past the toll station the fog came up", "as grandma used to say".
fn is_presented(text: &str, n: &Named, texts: &Texts, words: &LabelWords) -> bool {
    if n.side.is_some() || n.color.is_some() || n.ahead || subject::is_introduced(text, n.start, words) {
        return true;
    }
    let (from, to) = words.clauses.around(&texts.units, n.start..n.end, text.len(), &|_| true);
    if text[n.start..n.end].is_ascii() {
        // Plurals, and what is said to be somewhere: "workers stand beside it", "the lorry behind".
        let behind = text[n.end..to].to_ascii_lowercase();
        let mut next = behind.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty());
        const PLACES: [&str; 15] = [
            "are",
            "behind",
            "beside",
            "next",
            "to",
            "on",
            "in",
            "at",
            "two",
            "ahead",
            "tucked",
            "coming",
            "crossing",
            "over",
            "alongside",
        ];
        let placed = next.next().is_some_and(|w| PLACES.contains(&w));
        let many = text[n.start..n.end].ends_with('s') && !text[from..n.start].trim_end().ends_with("the");
        // "Has just gone amber".
        let is_event =
            words.objects[n.group].own.meets(words.known.light) && text[n.start..n.end].contains(' ');
        return placed || many || is_event;
    }
    // Its clause begins with it, or with where it is.
    let before = text[from..n.start].chars().next_back();
    // The ego responds to it: "let the school bus in".
    let is_met = |c: char| "让等给跟".contains(c) && words.objects[n.group].own.meets(words.known.vehicle);
    if before.is_some_and(|c| words.subjects.counters.contains(c) || is_met(c)) {
        return true;
    }
    let is_place = |c: char| "方面边侧口旁头里上后前外内处间的色号了".contains(c);
    let begins = before.is_none_or(|c| !c.is_alphanumeric() || is_place(c));
    let acts =
        text[n.end..to].contains(char::is_alphanumeric) || text[n.start..n.end].chars().nth(2).is_some();
    begins && acts
}

/// `text` ends with `word`, in upper or lower case.
fn ends_with(text: &str, word: &str) -> bool {
    let end = text.len().checked_sub(word.len()).and_then(|from| text.get(from..));
    end.is_some_and(|end| end.eq_ignore_ascii_case(word))
}

/// Content of components in words that are in no list.
struct Unread<'a> {
    /// All components.
    all: Vec<&'a str>,
    /// Components whose thing was not read.
    things: Vec<&'a str>,
    /// Components with only a place, so that any sign or surface may be meant.
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

    /// A component may be about the thing `n` of the trace `text`: it contains a word of its name; or its own thing was
    /// not read, and the clause of `n` has words of the component, or no clause has.
    fn may_name(&self, text: &str, n: &Named, texts: &Texts, words: &LabelWords) -> bool {
        let compared = &words.compared;
        let acts = words.objects[n.group].own.meets(words.known.actor);
        if self.place_only && !acts {
            return true;
        }
        if self.all.iter().any(|c| overlap::has_word_of(c, &text[n.start..n.end], acts, words)) {
            return true;
        }
        // "The vehicle": whatever its name in the component.
        if !self.things.is_empty() && words.subjects.is_general(&text[n.start..n.end]) {
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

/// The side and color of a thing in the trace are those in its component.
fn differs(scope: &TextScope<'_>, until: usize, said: Said, sink: &mut dyn Sink) {
    let TextScope { label, texts, words, .. } = *scope;
    let Some(text) = label.trace.get() else { return };
    let general = |n: &Named| words.subjects.is_general(&text[n.start..n.end]);
    let given = Given::of(scope, text);
    // "The blue car" for the white one: the color is part of the word.
    let other_car = |n: &Named| {
        painted(Some(text), n, words).is_some_and(|c| {
            let painted = given.painted();
            !painted.is_empty() && !painted.contains(&c)
        })
    };
    // "Three cows" where the component has two.
    let other_count = |n: &Named| {
        let count = |t: &str, n: &Named| words.quantities.count_before(t, n.start, &words.subjects.counters);
        let Some(said) = count(text, n) else { return false };
        let one = |t: &str, m: &Named| subject::is_single(t, m.start).then_some(1.0);
        let counts = given.counts(n, &|t, m| count(t, m).or_else(|| one(t, m)));
        // "A car" and "a van" are two cars.
        if said <= counts.sum && counts.number > 1 {
            return false;
        }
        words.objects[n.group].own.meets(words.known.actor)
            && counts.number > 0
            && !counts.different.contains(&said)
    };
    let is_fixed = |n: &Named| {
        let own = words.objects[n.group].own;
        own.meets(words.known.adverse.with(words.known.sight)) && !own.meets(words.known.actor)
    };
    let other_bend = |n: &Named| {
        let Some(side) = turned(text, n).filter(|_| is_fixed(n)) else { return false };
        let turns = given.turns(n);
        let all = texts.trace.there().filter(|m| m.start < until && m.group == n.group);
        let also = all.filter_map(|m| turned(text, m)).any(|s| turns.contains(&s));
        !turns.is_empty() && !turns.contains(&side) && !also
    };
    // It stands, although its component states that it moves off.
    let other_doing = |n: &Named| {
        if !words.objects[n.group].own.meets(words.known.actor) {
            return false;
        }
        let Some(does) = given.doing(n) else { return false };
        if given.actors_in_clause(n.clause) > 1 {
            return false;
        }
        let opposite = words.opposite_of(does).without(does);
        let (from, to) = words.clauses.around(&texts.units, n.start..n.end, text.len(), &|_| true);
        let acts = || texts.trace.acts_in(from, to).iter().filter(|a| !a.denied);
        acts().any(|a| a.doing.meets(opposite)) && !acts().any(|a| a.doing.meets(does))
    };
    let is_part = |n: &Named, text: Option<&str>| {
        text.and_then(|t| t.get(n.start..n.end)).is_some_and(|t| words.subjects.is_part(t))
    };
    let differs = |n: &&Named| {
        if is_part(n, Some(text)) || !words.objects[n.group].named || (said == Said::Unread && general(n)) {
            return false;
        }
        // Most things are mentioned without either.
        let marked = (n.side.is_some() || n.color.is_some()) && {
            let same = given.meant(n);
            let also = |s: bool| {
                let all = texts.trace.there().filter(|m| m.start < until && m.group == n.group);
                all.filter_map(|m| m.side).any(|m| m == s)
            };
            let side =
                n.side.is_some_and(|s| same.sides.contains(&!s) && !same.sides.contains(&s) && !also(!s));
            side || n.color.is_some_and(|k| !same.colors.is_empty() && !same.colors.contains(&k))
        };
        marked || other_car(n) || n.side.is_some() && given.is_opposite(n)
    };
    let is_other = |n: &&Named| {
        differs(n) || other_count(n) || other_bend(n) || other_doing(n) || given.is_other_kind(n)
    };
    let other_thing = texts.trace.there().filter(|n| n.start < until).find(is_other);
    let other_thing = other_thing.or_else(|| other_light(scope, until)).map(|n| (n.start, n.end));
    let other_side = || attributes::other_side(scope).or_else(|| attributes::other_side_of_all(scope, until));
    let other_number = || {
        let length = attributes::other_length(scope).or_else(|| attributes::other_limit(scope));
        length.or_else(|| attributes::other_number(scope))
    };
    let Some((start, end)) = other_thing.or_else(other_number).or_else(other_side) else {
        return;
    };
    sink.report(Finding::warning("label.trace.object_differs", pointer::COC_TRACE).part(start, end), &|| {
        let thing = &text[start..end];
        Words::new(
            format!("因果描述中的“{thing}”与关键要素所说的不同（方位、距离、颜色、数量或动作）"),
            format!(
                "'{thing}' differs between the trace and the component (side, distance, color, number or action)"
            ),
        )
        .hint("改正其中有误的一处", "correct the one that is wrong")
    });
}

/// The light in the trace, if its color is that of no light in the components.
fn other_light<'t>(scope: &TextScope<'t>, until: usize) -> Option<&'t Named> {
    let TextScope { label, texts, words, .. } = *scope;
    if !texts.trace.groups.meets(words.known.light) {
        return None;
    }
    // "The light has just dropped to red": after the name, in the same clause.
    let color = |text: &str, n: &Named, clause: &mut ClauseColor| {
        let own = words.light_color(text.get(n.start..n.end)?);
        own.or_else(|| clause.after(text, n.end, words))
    };
    // A road user that runs a red light has a light of its own.
    let jumped = |t: Option<&str>, n: &Named| t.is_some_and(|t| t[..n.start].ends_with(['闯', '抢']));
    let is_light = |n: &&Named| words.objects[n.group].own.meets(words.known.light);
    let mut given: BTreeSet<usize> = BTreeSet::new();
    for (c, f) in label.parts.iter().zip(&texts.components) {
        let (text, mut clause) = (c.description.get(), ClauseColor::default());
        let lights = f.there().filter(is_light).filter(|n| !jumped(text, n));
        given.extend(lights.filter_map(|n| color(text?, n, &mut clause)));
    }
    let (trace, mut clause) = (label.trace.get()?, ClauseColor::default());
    let lights = texts.trace.there().filter(|n| n.start < until).filter(is_light);
    let mut said = lights.filter_map(|n| Some((n, color(trace, n, &mut clause)?)));
    let (n, first) = said.next()?;
    let by_clause = |clause: &str| words.last_light_color(clause).map(|(_, color)| color);
    // "While it was yellow I was in two minds, now it is red".
    let also = || trace.split(|c| "，。；,;.".contains(c)).filter_map(by_clause).any(|c| given.contains(&c));
    let is_given = given.contains(&first) || said.any(|(_, c)| given.contains(&c)) || also();
    (!given.is_empty() && !is_given).then_some(n)
}

/// The last color of a light in a clause, kept for the names in it.
#[derive(Default)]
struct ClauseColor {
    /// Bytes that were searched, to the end of the clause.
    searched: Option<Range<usize>>,
    /// First byte of the color's word, and the color.
    found: Option<(usize, usize)>,
}

impl ClauseColor {
    /// The last color between the byte `from` and the end of its clause.
    fn after(&mut self, text: &str, from: usize, words: &LabelWords) -> Option<usize> {
        let letter = |c: char| c.is_ascii_alphanumeric();
        // A word that begins here is whole, although a letter precedes it.
        let divides_a_word = text[..from].ends_with(letter) && text[from..].starts_with(letter);
        if divides_a_word || !self.searched.as_ref().is_some_and(|s| s.start <= from && from <= s.end) {
            let rest = &text[from..];
            let end = rest.find(|c| "，。；,;.".contains(c)).unwrap_or(rest.len());
            self.found = words.last_light_color(&rest[..end]).map(|(at, color)| (from + at, color));
            self.searched = (!divides_a_word).then_some(from..from + end);
        }
        self.found.filter(|(at, _)| *at >= from).map(|(_, color)| color)
    }
}
