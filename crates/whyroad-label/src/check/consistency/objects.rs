//! Things in the trace that no component names, or that have another location or color there. A component in words that
//! are in no list may name anything.

use crate::check::consistency::attributes;
use crate::check::consistency::trace_rules::Said;
use crate::check::overlap;
use crate::check::reading::{Named, TextFacts};
use crate::check::subject;
use crate::check::texts::{TextScope, Texts};
use crate::check::view::View;
use whyroad_framework::LabelWords;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::label_words::GroupSet;
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
    let is_new = |n: &&Named| {
        is_new(n)
            && !may_be_ego(n)
            && !says_little(n)
            && !either(n)
            && !describes(n)
            && !is_beside(n)
            && !subject::is_no_noun(text, n.start, n.end, words)
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
    let meant = |n: &Named| -> Vec<&Named> {
        let group = &words.objects[n.group];
        let all = || texts.components.iter().flat_map(|f| f.there()).filter(|c| words.objects[c.group].named);
        // Things with the same name, otherwise all that may be meant.
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
        let color = word.next().filter(|c| words.color_chars.iter().any(|(own, _)| own == c))?;
        (word.as_str() == "车").then_some(color)
    };
    let given = || {
        let parts = label.parts.iter().zip(&texts.components);
        parts.flat_map(move |(c, f)| f.there().filter_map(move |n| painted(c.description.get(), n)))
    };
    let other_car = |n: &Named| {
        painted(Some(text), n).is_some_and(|c| given().next().is_some() && !given().any(|g| g == c))
    };
    // "From the right" of a road user that is oncoming in its component.
    let says_opposite = |text: &str| {
        let lower = text.to_ascii_lowercase();
        words.subjects.opposite.iter().any(|w| lower.contains(w.as_str()))
    };
    let not_opposite = |n: &Named| {
        let acts = words.objects[n.group].own.meets(words.known.actor);
        n.side.is_some() && acts && !says_opposite(text) && {
            let parts = || label.parts.iter().zip(&texts.components);
            let same = |f: &TextFacts| {
                f.there().any(|c| words.objects[c.group].own.meets(words.objects[n.group].near))
            };
            let sided = parts().any(|(_, f)| same(f) && f.there().any(|c| c.side.is_some()));
            !sided && parts().any(|(c, f)| same(f) && c.description.get().is_some_and(says_opposite))
        }
    };
    // "Behind us" of a road user that is ahead of the ego in its component, where no other can be meant.
    let at_end = |text: &str, n: &Named| {
        let marks = |c: char| "，。；！？,;!?".contains(c);
        let from = text[..n.start].rfind(marks).map_or(0, |i| i + 1);
        let to = text[n.end..].find(marks).map_or(text.len(), |i| n.end + i);
        let clause =
            text.get(from..to).or_else(|| text.get(n.start..to)).unwrap_or_default().to_ascii_lowercase();
        let [before, behind] =
            words.subjects.at.each_ref().map(|all| all.iter().any(|w| clause.contains(w.as_str())));
        (before != behind).then_some(before)
    };
    let is_elsewhere = |n: &Named| {
        let own = words.objects[n.group].own;
        if !own.meets(words.known.vehicle) {
            return false;
        }
        let parts = label.parts.iter().zip(&texts.components);
        let mut same = parts.flat_map(|(c, f)| {
            let near = words.objects[n.group].near;
            f.there().filter(move |o| words.objects[o.group].own.meets(near)).map(move |o| (c, o))
        });
        let (Some((c, other)), None) = (same.next(), same.next()) else { return false };
        let given = c.description.get().and_then(|t| at_end(t, other));
        given.is_some_and(|g| at_end(text, n).is_some_and(|said| said != g))
    };
    // The components' names for the same thing, with their texts.
    let same_in_parts = |n: &Named| {
        let own = words.objects[n.group].own;
        let parts = label.parts.iter().zip(&texts.components);
        let texts = parts.filter_map(|(c, f)| Some((c.description.get()?, f)));
        texts.flat_map(move |(t, f)| {
            f.there().filter(move |m| words.objects[m.group].own == own).map(move |m| (t, m))
        })
    };
    // "Three cows" where the component has two.
    let other_count = |n: &Named| {
        let count = |t: &str, n: &Named| words.quantities.count_before(t, n.start, &words.subjects.counters);
        let Some(said) = count(text, n) else { return false };
        let one = |t: &str, m: &Named| subject::is_single(t, m.start).then_some(1.0);
        let given: Vec<f64> =
            same_in_parts(n).filter_map(|(t, m)| count(t, m).or_else(|| one(t, m))).collect();
        // "A car" and "a van" are two cars.
        if said <= given.iter().sum() && given.len() > 1 {
            return false;
        }
        words.objects[n.group].own.meets(words.known.actor) && !given.is_empty() && !given.contains(&said)
    };
    // A bend or a wall on the other side: as a word of its own, or as a part of its name.
    let turned = |t: &str, n: &Named| {
        let word = t.get(n.start..n.end).unwrap_or_default();
        match word.chars().next() {
            Some('左') => Some(true),
            Some('右') => Some(false),
            _ => n.side,
        }
    };
    let is_fixed = |n: &Named| {
        let own = words.objects[n.group].own;
        own.meets(words.known.adverse.with(words.known.sight)) && !own.meets(words.known.actor)
    };
    let other_bend = |n: &Named| {
        let Some(side) = turned(text, n).filter(|_| is_fixed(n)) else { return false };
        let given: Vec<bool> = same_in_parts(n).filter_map(|(t, m)| turned(t, m)).collect();
        !given.is_empty() && !given.contains(&side)
    };
    // It stands, although its component states that it moves off.
    let other_doing = |n: &Named| {
        let own = words.objects[n.group].own;
        if !own.meets(words.known.actor) {
            return false;
        }
        let mut same =
            texts.components.iter().filter(|f| f.there().any(|m| words.objects[m.group].own == own));
        let (Some(given), None) = (same.next(), same.next()) else { return false };
        let others = texts
            .trace
            .there()
            .filter(|m| m.clause == n.clause && words.objects[m.group].own.meets(words.known.actor));
        if given.does.is_empty()
            || given.there().filter(|m| words.objects[m.group].own.meets(words.known.actor)).count() > 1
            || others.count() > 1
        {
            return false;
        }
        let opposite = words.opposite_of(given.does).without(given.does);
        let (from, to) = words.clauses.around(&texts.units, n.start..n.end, text.len(), &|_| true);
        let acts = || texts.trace.acts.iter().filter(|a| (from..to).contains(&a.start) && !a.denied);
        acts().any(|a| a.doing.meets(opposite)) && !acts().any(|a| a.doing.meets(given.does))
    };
    let is_part = |n: &Named, text: Option<&str>| {
        text.and_then(|t| t.get(n.start..n.end)).is_some_and(|t| words.subjects.is_part(t))
    };
    let differs = |n: &&Named| {
        if is_part(n, Some(text)) || !words.objects[n.group].named || (said == Said::Unread && general(n)) {
            return false;
        }
        // Most things are mentioned without either.
        let same = if n.side.is_some() || n.color.is_some() { meant(n) } else { Vec::new() };
        let side = n.side.is_some_and(|s| {
            same.iter().any(|c| c.side == Some(!s)) && !same.iter().any(|c| c.side == Some(s))
        });
        let color = n.color.is_some_and(|k| {
            same.iter().any(|c| c.color.is_some_and(|o| o != k)) && !same.iter().any(|c| c.color == Some(k))
        });
        side || color || other_car(n) || not_opposite(n) || is_elsewhere(n)
    };
    let is_other =
        |n: &&Named| differs(n) || other_count(n) || other_bend(n) || other_doing(n) || other_kind(n, scope);
    let other_thing = texts.trace.there().filter(|n| n.start < until).find(is_other);
    let other_thing = other_thing.or_else(|| other_light(scope, until)).map(|n| (n.start, n.end));
    let other_side = || attributes::other_side(scope).or_else(|| attributes::other_side_of_all(scope, until));
    let other_number = || attributes::other_length(scope).or_else(|| attributes::other_number(scope));
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

/// A pickup in the trace for the hatchback of the components: its kind is none of theirs, and each component that may
/// be meant was read and has a kind.
fn other_kind(n: &Named, scope: &TextScope<'_>) -> bool {
    let TextScope { label, texts, words, .. } = *scope;
    let Some(name) = label.trace.get().and_then(|t| t.get(n.start..n.end)) else { return false };
    let name = name.to_ascii_lowercase();
    let parts = || {
        let parts = label.parts.iter().zip(&texts.components);
        parts.filter_map(|(c, f)| Some((c.description.get()?, f)))
    };
    let all = || parts().flat_map(|(t, f)| f.named.iter().map(move |m| (t, m)));
    let given_name = |t: &str, m: &Named| t.get(m.start..m.end).unwrap_or_default().to_ascii_lowercase();
    // "The taxi" of a minibus taxi; "the tires" of the ego.
    if words.subjects.is_part(&name) || all().any(|(t, m)| given_name(t, m).contains(&name)) {
        return false;
    }
    let own = words.objects[n.group].own;
    words.apart.kinds(&name).into_iter().any(|(family, said)| {
        let kinds = |t: &str, m: &Named| {
            let all = words.apart.kinds(t.get(m.start..m.end).unwrap_or_default());
            all.into_iter().find(|(f, _)| *f == family).map_or(0, |(_, kinds)| kinds)
        };
        let given = all().fold(0, |set, (t, m)| set | kinds(t, m));
        let near = |m: &Named| words.objects[m.group].near.meets(own);
        // "The trailer", behind a flatbed trailer: refers to it.
        let refers = |t: &str, m: &Named| {
            !subject::is_introduced(t, m.start, words)
                && m.side.is_none()
                && all().any(|(u, o)| kinds(u, o) != 0 && given_name(u, o).ends_with(&given_name(t, m)))
        };
        let general = |(t, m): (&str, &Named)| {
            let there = !m.absent && !m.supposed && !words.subjects.is_of_many(&given_name(t, m));
            there && near(m) && kinds(t, m) == 0 && !refers(t, m)
        };
        given != 0
            && given & said == 0
            && !all().any(general)
            && !parts()
                .any(|(t, f)| !f.named.iter().any(|m| kinds(t, m) != 0) && subject::is_unread(t, f, words))
    })
}

/// The light in the trace, if its color is that of no light in the components.
fn other_light<'t>(scope: &TextScope<'t>, until: usize) -> Option<&'t Named> {
    let TextScope { label, texts, words, .. } = *scope;
    if !texts.trace.groups.meets(words.known.light) {
        return None;
    }
    // "The light has just dropped to red": after the name, in the same clause.
    let color = |text: Option<&str>, n: &Named| {
        let text = text?;
        let own = words.light_color(text.get(n.start..n.end)?);
        let rest = text.get(n.end..)?;
        let end = rest.find(|c| "，。；,;.".contains(c)).unwrap_or(rest.len());
        own.or_else(|| words.light_color(&rest[..end]))
    };
    // A road user that runs a red light has a light of its own.
    let jumped = |t: Option<&str>, n: &Named| t.is_some_and(|t| t[..n.start].ends_with(['闯', '抢']));
    let is_light = |n: &&Named| words.objects[n.group].own.meets(words.known.light);
    let given: Vec<usize> = label
        .parts
        .iter()
        .zip(&texts.components)
        .flat_map(|(c, f)| {
            let text = c.description.get();
            f.there().filter(is_light).filter(move |n| !jumped(text, n)).filter_map(move |n| color(text, n))
        })
        .collect();
    let said: Vec<(&Named, usize)> = texts
        .trace
        .there()
        .filter(|n| n.start < until)
        .filter(is_light)
        .filter_map(|n| Some((n, color(label.trace.get(), n)?)))
        .collect();
    let (n, _) = said.first()?;
    (!given.is_empty() && !said.iter().any(|(_, c)| given.contains(c))).then_some(n)
}
