//! Reads a trace clause by clause: a clause may support its decision, contradict it, or state it. A trace that has
//! clauses against its decision and none for it denies its own cause, whatever its words.

use crate::check::consistency::trace::Reading;
use crate::check::consistency::trace_rules;
use crate::check::overlap;
use crate::check::reading::{Act, Named, TextFacts};
use crate::check::subject;
use crate::check::texts::TextScope;
use crate::check::view::View;
use whyroad_framework::LabelWords;
use whyroad_framework::label_words::{Divider, Doings, GroupSet};

/// Maximum number of clauses that are read.
const MOST_CLAUSES: usize = 24;

/// The things and actions in the components.
struct Given<'t> {
    facts: &'t [TextFacts],
    things: GroupSet,
    does: Doings,
}

/// Bytes of the first clause that contradicts the decision of a trace in which no clause supports it.
///
/// `background`: groups that describe the location of something. `about`: the triggers of the class.
pub(super) fn against(scope: &TextScope<'_>, reading: &Reading) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, lexicon, background, about } = *scope;
    let text = label.trace.get()?;
    let trace = &texts.trace;
    let absent = trace.named.iter().any(|n| n.absent);
    let silent = trace.harmless.is_empty() && trace.clear.is_empty() && trace.irrelevant.is_none();
    if silent && trace.acts.is_empty() && !absent {
        return None;
    }
    let there = texts.components.iter().flat_map(TextFacts::there);
    let given = Given {
        facts: &texts.components,
        things: there
            .filter(|n| !words.objects[n.group].own.without(background).is_empty())
            .fold(about.without(words.known.actor), |set, n| set.with(words.objects[n.group].near)),
        does: texts.components.iter().fold(Doings::default(), |all, f| all.with(f.does)),
    };
    let decided = |from: usize, to: usize| match reading.marked {
        true => from >= reading.decision_from,
        false => trace_rules::states_decision(reading, lexicon, label, from, to),
    };
    // It is said not to do what its component states, and nowhere to do it.
    let before = |a: &&Act| !reading.marked || a.start < reading.decision_from;
    let acts = || trace.acts.iter().filter(before).filter(|a| a.doing.only(words.reaching).meets(given.does));
    let around =
        |a: &Act| words.clauses.around(&texts.units, a.start..a.end, text.len(), &|d| d != Divider::Aside);
    // "Lets it back out first": a clause that states the decision states no fact.
    let in_decision = |a: &Act| {
        let (from, to) = around(a);
        decided(from, to)
    };
    let asserted = acts().any(|a| !a.denied && !in_decision(a));
    if !asserted && let Some(a) = acts().find(|a| a.denied && by_somebody(a, trace, words)) {
        return Some(around(a));
    }
    // The same, expressed by what it does instead: "shows no sign of backing out".
    let instead = words.opposite_of(given.does.only(words.reaching)).only(words.calm);
    // "Cannot be trusted to stay put".
    let unable = |a: &Act| {
        let before = text[around(a).0..a.start].to_ascii_lowercase();
        words.subjects.unable.iter().any(|w| before.contains(w.as_str()))
    };
    let calm = |a: &&Act| !a.denied && a.doing.meets(instead) && !a.doing.meets(given.does) && !unable(a);
    if !asserted
        && let Some(a) = trace.acts.iter().filter(before).find(calm)
        && by_somebody(a, trace, words)
    {
        return Some(around(a));
    }
    if let Some(at) = hinders_nothing(scope, reading).or_else(|| rules_others(scope, reading)) {
        return Some(at);
    }
    let (mut from, mut first, mut named) = (0, None, false);
    for _ in 0..MOST_CLAUSES {
        let end = words.clauses.clause_end(&texts.units, from, text.len());
        let is_last = text[end..].chars().all(|c| !c.is_alphanumeric());
        if !is_last && !decided(from, end) {
            match speaks(label, text, (from, end), trace, words, &given) {
                Speaks::For => return None,
                Speaks::Names { new: true } if first.is_some() => return None,
                Speaks::Against => drop(first.get_or_insert((from, end))),
                Speaks::Names { .. } => named |= first.is_none(),
                Speaks::Neither => {}
            }
        }
        if is_last {
            break;
        }
        // Every named road user must be said to be harmless in the same sentence.
        if named && first.is_none() && text[end..].starts_with(['.', ';', '!', '?', '。', '；', '！', '？'])
        {
            return None;
        }
        from = end + text[end..].chars().next().map_or(1, char::len_utf8);
    }
    first.map(|(from, end)| {
        let clause = &text[from..end];
        let begin = clause.find(char::is_alphanumeric).unwrap_or(0);
        (from + begin, from + clause.trim_end().len().max(begin))
    })
}

/// Bytes of the statement that nothing hides or hinders, in a class about something that does: stated for everything in
/// the trace, or stated twice.
fn hinders_nothing(scope: &TextScope<'_>, reading: &Reading) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, about, .. } = *scope;
    let text = label.trace.get()?;
    let bad = words.known.adverse.with(words.known.sight).without(words.known.actor).only(about);
    if bad.is_empty() || about.meets(words.known.actor) {
        return None;
    }
    let before = |at: usize| !reading.marked || at < reading.decision_from;
    let around = |at: (usize, usize)| {
        words.clauses.around(&texts.units, at.0..at.1, text.len(), &|d| d != Divider::Aside)
    };
    let clear: Vec<(usize, usize)> =
        texts.trace.clear.iter().filter(|c| before(c.0)).map(|c| around(*c)).collect();
    let first = *clear.first()?;
    let said = |n: &Named| {
        let own = words.objects[n.group].own;
        own.meets(bad) && !clear.iter().any(|(from, to)| (*from..*to).contains(&n.start))
    };
    let alone = !texts.trace.there().any(said) && !texts.trace.named.iter().any(|n| n.supposed && said(n));
    let twice = clear.iter().any(|c| *c != first);
    (alone || twice).then_some(first)
}

/// Bytes of the statement that the only light or sign of the trace does not apply to the ego, in a class about one:
/// "the red is for the tram and does not apply to our lane". Not where another one is named after it.
fn rules_others(scope: &TextScope<'_>, reading: &Reading) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, about, .. } = *scope;
    let text = label.trace.get()?;
    let control = words.known.light.with(words.known.sign);
    let at = texts.trace.irrelevant.filter(|_| about.meets(control))?;
    let before = |at: usize| !reading.marked || at < reading.decision_from;
    let named = texts.trace.there().filter(|n| before(n.start) && words.objects[n.group].own.meets(control));
    let mut clauses: Vec<_> = named.map(|n| (n.clause, n.start)).collect();
    clauses.dedup_by_key(|c| c.0);
    let (from, to) = words.clauses.around(&texts.units, at.0..at.1, text.len(), &|d| d != Divider::Aside);
    // "Nobody on the cross road makes no odds".
    let about_another =
        |n: &Named| (from..at.0).contains(&n.start) && !words.objects[n.group].own.meets(control);
    let only = matches!(clauses[..], [(_, start)] if before(at.0) && start < at.0);
    (only && !texts.trace.named.iter().any(about_another)).then_some((from, to))
}

/// Bytes of a sign that the trace says is missing although a component has it: "there is no speed limit sign".
pub(super) fn sign_is_missing(scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, .. } = *scope;
    let text = label.trace.get()?;
    let own = |n: &Named| words.objects[n.group].own;
    let is_kind = |n: &Named| text[n.end..].starts_with(['的', '路']);
    let stop_line = words.kinds.get("stop_line").copied().unwrap_or_default();
    let control = words.known.light.with(stop_line);
    let same = |n: &Named, m: &Named| own(n).meets(words.objects[m.group].near);
    let given = |n: &Named| texts.components.iter().any(|f| f.there().any(|m| same(n, m)));
    let gone = |n: &Named| texts.components.iter().any(|f| f.named.iter().any(|m| m.absent && same(n, m)));
    let is_missing = |n: &&Named| {
        n.absent
            && !own(n).only(words.known.sign).without(control).is_empty()
            && !is_kind(n)
            && given(n)
            && !gone(n)
            && !texts.trace.there().any(|m| same(n, m))
    };
    texts.trace.named.iter().find(is_missing).map(|n| (n.start, n.end))
}

/// Bytes of the statement that the route does not require the maneuver whose cause it is: "the navigation does not want
/// this exit". Not where a sign or a marking forbids going on, which contradicts the route.
pub(super) fn route_denied(scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, about, .. } = *scope;
    let text = label.trace.get()?;
    let route = |n: &Named| words.objects[n.group].own.meets(words.known.route);
    let rules = words.known.sign.with(words.kinds.get("marking").copied().unwrap_or_default());
    let parts = || texts.components.iter();
    if !parts().any(|f| f.there().any(route)) || about.meets(rules) {
        return None;
    }
    let clause =
        |n: &Named| words.clauses.around(&texts.units, n.start..n.end, text.len(), &|d| d != Divider::Aside);
    let denies = |n: &Named| {
        let (_, to) = clause(n);
        let behind = text[n.end..to].to_ascii_lowercase();
        words.subjects.route_not.iter().any(|w| behind.contains(w.as_str()))
    };
    let mut named = texts.trace.named.iter().filter(|n| route(n)).peekable();
    let first = **named.peek()?;
    named.all(denies).then(|| clause(&first))
}

/// A road user that acts is named before it.
fn by_somebody(act: &Act, trace: &TextFacts, words: &LabelWords) -> bool {
    let acts = |n: &Named| words.objects[n.group].own.meets(words.known.actor);
    trace.named.iter().any(|n| n.end <= act.start && acts(n))
}

/// Relation of a clause to the decision.
enum Speaks {
    For,
    /// It supports the decision, but only by a name, perhaps of a road user that was not named before.
    Names {
        new: bool,
    },
    Against,
    Neither,
}

fn speaks(
    label: &View<'_>,
    text: &str,
    (from, to): (usize, usize),
    trace: &TextFacts,
    words: &LabelWords,
    given: &Given<'_>,
) -> Speaks {
    let inside = |at: usize| (from..to).contains(&at);
    let own = || trace.named.iter().filter(|n| inside(n.start));
    let acts = || trace.acts.iter().filter(|a| inside(a.start));
    // A road user does what its component states.
    if acts().any(|a| !a.denied && a.doing.meets(given.does)) {
        return Speaks::For;
    }
    let carries = |n: &Named| !n.absent && words.objects[n.group].own.meets(given.things);
    let acting = |n: &Named| carries(n) && words.objects[n.group].own.meets(words.known.actor);
    // Words for standing still are no statement about the ego.
    let calm = if own().any(acting) { words.calm } else { Doings::default() };
    let opposite = words.opposite_of(given.does).with(calm).without(given.does);
    let any = |all: &[(usize, usize)]| all.iter().any(|(start, _)| inside(*start));
    let hindered = given.things.meets(words.known.adverse.with(words.known.sight));
    let irrelevant = trace.irrelevant.is_some_and(|(start, _)| inside(start));
    let harmless = any(&trace.harmless) || irrelevant || hindered && any(&trace.clear);
    let contradicts =
        acts().any(|a| if a.denied { a.doing.meets(given.does) } else { a.doing.meets(opposite) });
    // With the same name: "no cars" is no statement about the truck.
    let parts = || label.parts.iter().zip(given.facts).filter_map(|(c, f)| Some((c.description.get()?, f)));
    let there = |name: &str| {
        parts().any(|(t, f)| f.there().any(|n| t.get(n.start..n.end).is_some_and(|w| w.contains(name))))
    };
    let adverse = |n: &Named| {
        let own = words.objects[n.group].own.only(words.known.adverse);
        own.meets(given.things)
    };
    // "A hole or no hole".
    let doubted = |n: &Named| trace.there().any(|m| m.group == n.group);
    // "A junction without lights": the kind of the thing.
    let is_kind = |n: &Named| text[n.end..].starts_with('的');
    let missing =
        |n: &Named| n.absent && !is_kind(n) && !doubted(n) && (adverse(n) || there(&text[n.start..n.end]));
    // "At a junction without lights a truck comes".
    if harmless || contradicts || !own().any(acting) && own().any(missing) {
        return Speaks::Against;
    }
    let is_name = |at: usize| trace.named.iter().any(|n| (n.start..n.end).contains(&at));
    let is_common = |at: usize| words.subjects.is_common(text, at);
    let other = |at: usize| inside(at) && !is_name(at) && !is_common(at);
    let shared = || overlap::shared(label, text, &words.compared, &other);
    let enough = if text.is_ascii() { 1 } else { 2 };
    let says = acts().any(|a| !a.denied && a.doing.meets(words.reaching));
    let denies = acts().any(|a| a.denied);
    if says || !denies && shared() >= enough {
        return Speaks::For;
    }
    // Rain and bends are reasons by themselves, road users only by their actions.
    let by_itself = |n: &Named| !words.objects[n.group].own.meets(words.known.actor);
    match own().find(|n| carries(n)) {
        Some(_) if !denies && own().filter(|n| carries(n)).any(by_itself) => Speaks::For,
        Some(n) => Speaks::Names { new: !text.is_ascii() || subject::is_introduced(text, n.start, words) },
        None => Speaks::Neither,
    }
}
