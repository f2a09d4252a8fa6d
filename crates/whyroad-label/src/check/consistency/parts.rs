//! Components that contradict the decision: in them the ego does the opposite or not what is decided, the path for
//! which it stops is free, or the side to which it goes is not. The actions of other road users are the reason, and are
//! not judged.

use crate::check::consistency::trace::{self, Force};
use crate::check::consistency::trace_rules;
use crate::check::reading::{Named, TextFacts};
use crate::check::texts::TextScope;
use crate::check::view::ComponentView;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::label_words::KnownKinds;
use whyroad_framework::lexicon::units::Units;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::label_fields::pointer;

/// No component contradicts the decision.
pub(in crate::check) fn against_decision(scope: &TextScope<'_>, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, .. } = *scope;
    if words.is_empty() {
        return false;
    }
    let parts = label.parts.iter().zip(&texts.components);
    let found = parts.filter_map(|(c, f)| Some((c.index, c.description.get()?, f))).find_map(|(i, t, f)| {
        let at = ego_acts(t, scope)
            .or_else(|| ego_refuses(t, scope))
            .or_else(|| place_is_free(i, t, scope))
            .or_else(|| denies_another(i, t, scope))
            .or_else(|| way_is_free(t, f, scope))
            .or_else(|| no_room(t, f, scope))
            .or_else(|| room_for_aborted(t, f, scope))
            .or_else(|| against_another(i, t, f, scope))
            .or_else(|| nothing_to_respond_to(t, scope))
            .or_else(|| route_refuses(t, f, scope))
            .or_else(|| side_is_taken(i, t, f, scope))
            .or_else(|| is_over(i, t, scope))?;
        Some((i, t, at))
    });
    let Some((index, text, (start, end))) = found else { return false };
    let at = pointer::critical_components_item_description(index);
    sink.report(Finding::warning("label.trace.contradicts", at).part(start, end), &|| {
        let phrase = text[start..end].trim();
        Words::new(
            format!("关键要素说“{phrase}”，与决策相反"),
            format!("the component says '{phrase}', which contradicts the decision"),
        )
        .hint("改正要素，或检查决策", "correct the component, or check the decision")
    });
    true
}

/// Bytes of an action of the ego that contradicts the decision: it speeds up or continues where it should slow, or it
/// does not do what is decided. That it cannot do something is a reason.
fn ego_acts(text: &str, scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, lexicon, .. } = *scope;
    if !words.subjects.begins_with_ego(text) {
        return None;
    }
    let along = label.longitudinal.get().filter(|d| {
        matches!(
            d,
            Longitudinal::YieldToAgent
                | Longitudinal::StopForObstacle
                | Longitudinal::StopForRegulation
                | Longitudinal::RoadSpeedAdaptation
                | Longitudinal::LeadFollowing
        )
    });
    let across = label.lateral.get().filter(|d| *d != Lateral::LaneKeeping);
    let lower = text.to_ascii_lowercase();
    if words.subjects.unable.iter().any(|w| lower.contains(w.as_str())) {
        return None;
    }
    let reading = trace::read(text, &Units::of(text), lexicon);
    let is_own =
        |m: &&trace::Mention| trace_rules::says_label(m, lexicon, label) && m.force == Force::Negated;
    let refused = reading.refused.is_some();
    if let Some(m) = reading.mentions.iter().find(|m| refused && is_own(m) && m.by_ego) {
        return Some((m.start, m.end));
    }
    along?;
    if lexicon.stems.find(text, along, across).is_some() {
        return None;
    }
    let refused =
        |at: &(usize, usize)| reading.refused.is_some_and(|(from, to, _)| from <= at.1 && at.0 <= to);
    let denied = lexicon.stems.denied(text, along, None).filter(refused);
    denied.or_else(|| lexicon.stems.speeds(text, along, across))
}

/// Bytes of the label's decision in a later clause of a component, where the ego does not take it: "..., and the ego
/// has not changed to the left".
fn ego_refuses(text: &str, scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, lexicon, .. } = *scope;
    let starts =
        std::iter::once(0).chain(text.match_indices(['，', ',', ';', '；']).map(|(at, c)| at + c.len()));
    let from = starts
        .map(|at| at + (text[at..].len() - text[at..].trim_start().len()))
        .find(|at| words.subjects.begins_with_ego(&text[*at..]) || text[*at..].starts_with('我'))?;
    let part = text.get(from..)?;
    let lower = part.to_ascii_lowercase();
    let room = words.forms.room.find(&lower).is_some();
    if room || words.subjects.unable.iter().any(|w| lower.contains(w.as_str())) {
        return None;
    }
    let reading = trace::read(part, &Units::of(part), lexicon);
    let refuses = |m: &&trace::Mention| {
        // Directly before it: "has not", "instead of".
        let near =
            (m.start.saturating_sub(30)..=m.start).find(|i| lower.is_char_boundary(*i)).unwrap_or(m.start);
        let before = &lower[near..m.start];
        let before = before.rsplit(['，', ',']).next().unwrap_or_default();
        let not = match part.is_ascii() {
            true => words.forms.instead.find(before).is_some(),
            // Not inside another name: "no left-turn light" is "没有左转专用灯".
            false => {
                before.contains(['没', '未'])
                    && !lower[m.end..].starts_with(|c: char| c.is_alphanumeric() && c != '了')
            }
        };
        not && !m.by_other && trace_rules::says_label(m, lexicon, label) && m.force == Force::Negated
    };
    let m = reading.mentions.iter().find(refuses)?;
    Some((from + m.start, from + m.end))
}

/// Bytes of the statement that nothing is at a place where another component says that somebody or something is.
/// English only: the place is the words before the statement. Not of the side to which the ego goes.
fn place_is_free(index: usize, text: &str, scope: &TextScope<'_>) -> Option<(usize, usize)> {
    /// Minimum number and share of the words for the place that the other component has.
    const SHARED: (usize, f64) = (2, 0.6);
    const EMPTY: [&str; 12] =
        ["the", "our", "its", "and", "for", "with", "has", "one", "are", "now", "ahead", "all"];
    let TextScope { label, texts, words, .. } = *scope;
    if !text.is_ascii() {
        return None;
    }
    let lower = text.to_ascii_lowercase();
    let (start, end) = words.forms.free.find(&lower)?;
    let side = match label.direction.get() {
        Some(LateralDirection::Left) => "left",
        Some(LateralDirection::Right) => "right",
        _ => "",
    };
    let content = |t: &str| -> Vec<String> {
        let all = t.split(|c: char| !c.is_ascii_alphabetic()).filter(|w| w.len() > 2 && !EMPTY.contains(w));
        let mut out: Vec<String> = all.map(str::to_owned).collect();
        out.sort_unstable();
        out.dedup();
        out
    };
    let place = content(&lower[..start]);
    if place.iter().any(|w| w == side) {
        return None;
    }
    let site = words.kinds.get("site").copied().unwrap_or_default();
    let filled = |f: &TextFacts| {
        let there = |n: &Named| words.objects[n.group].own.meets(words.known.actor.with(site));
        f.there().any(there) || f.acts.iter().any(|a| !a.denied && a.doing.meets(words.reaching))
    };
    let mut others = label.parts.iter().zip(&texts.components).filter(|(c, _)| c.index != index);
    let same = others.any(|(c, f)| {
        let Some(other) = c.description.get().map(str::to_ascii_lowercase) else { return false };
        let own = content(&other);
        let shared = place.iter().filter(|w| own.contains(w)).count();
        words.forms.free.find(&other).is_none()
            && shared >= SHARED.0
            && shared as f64 >= SHARED.1 * place.len() as f64
            && filled(f)
    });
    same.then_some((start, end))
}

/// Bytes of the statement that what another component names has gone: "the pickup has just left the road". Not of what
/// the component introduces, and not where the ego starts or goes on.
fn is_over(index: usize, text: &str, scope: &TextScope<'_>) -> Option<(usize, usize)> {
    /// Characters between the word for what is done and the one for going.
    const NEAR: usize = 9;
    /// Characters before both that may name the thing.
    const NAME: usize = 24;
    let TextScope { label, words, .. } = *scope;
    let responds = matches!(
        label.longitudinal.get(),
        Some(
            Longitudinal::YieldToAgent
                | Longitudinal::StopForObstacle
                | Longitudinal::StopForRegulation
                | Longitudinal::LeadFollowing
        )
    ) || matches!(
        label.lateral.get(),
        Some(Lateral::LaneChange | Lateral::InLaneNudge | Lateral::OutOfLaneNudge | Lateral::ManeuverAbort)
    );
    if !responds {
        return None;
    }
    let lower = text.to_ascii_lowercase();
    let forms = &words.forms;
    let gone = || {
        forms.already.everywhere(&lower).find_map(|(at, w)| {
            let from = at + w.len();
            // Some words on, in the clause.
            let near = lower[from..].char_indices().take_while(|(_, c)| !"，；。".contains(*c)).take(NEAR);
            let to = near.last().map_or(from, |(i, c)| from + i + c.len_utf8());
            forms.gone.find(&lower[from..to]).map(|(_, b)| (at, from + b))
        })
    };
    let (start, end) = forms.over.find(&lower).or_else(|| gone().filter(|_| !text.is_ascii()))?;
    let mut others = label.parts.iter().filter(|c| c.index != index).filter_map(|c| c.description.get());
    let before = &lower[..start];
    let same = if text.is_ascii() {
        const NEW: [&str; 4] = ["a", "an", "another", "one"];
        let all: Vec<&str> =
            before.split(|c: char| !c.is_ascii_alphabetic()).filter(|w| !w.is_empty()).collect();
        let last = all.iter().rev().find(|w| w.len() > 2).map(|w| w.trim_end_matches('s'))?;
        let has = |t: &str| {
            let t = t.to_ascii_lowercase();
            t.split(|c: char| !c.is_ascii_alphabetic()).any(|w| w.trim_end_matches('s') == last)
        };
        !all.iter().any(|w| NEW.contains(w)) && others.any(has)
    } else {
        let mut chars: Vec<char> = before.chars().rev().filter(|c| c.is_alphanumeric()).take(NAME).collect();
        chars.reverse();
        let pairs: Vec<String> = chars.windows(2).map(|w| w.iter().collect()).collect();
        // "Its front wheel has turned into our lane".
        let of_part = before.ends_with(['轮', '头', '尾', '身']);
        let comes = ["我", "自车", "本车"].iter().any(|w| lower[end..].starts_with(w));
        !of_part && !comes && others.any(|t| pairs.iter().any(|p| t.contains(p.as_str())))
    };
    same.then_some((start, end))
}

/// Bytes of "there is no ..." in a Chinese component, where another one has the same words as being there.
fn denies_another(index: usize, text: &str, scope: &TextScope<'_>) -> Option<(usize, usize)> {
    const NONE: &str = "没有";
    const LEAST: usize = 4;
    let at = text.find(NONE)?;
    let rest = text[at + NONE.len()..].trim_start_matches("任何");
    let thing = rest.split(['，', '。', '；', '、']).next().filter(|t| t.chars().count() >= LEAST)?;
    let mut others =
        scope.label.parts.iter().filter(|c| c.index != index).filter_map(|c| c.description.get());
    let there = others.any(|t| {
        t.match_indices(thing).any(|(i, _)| {
            let before = t[..i].trim_end_matches(['个', '条', '一', '辆', '块', '道']);
            before.ends_with('有') && !before.ends_with("没有")
        })
    });
    there.then_some((at, at + NONE.len() + (text.len() - at - NONE.len() - rest.len()) + thing.len()))
}

/// Bytes of the statement that the ego's path is free, where it stops or yields: not about another lane or side.
fn way_is_free(text: &str, facts: &TextFacts, scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, about, .. } = *scope;
    let responds =
        matches!(label.longitudinal.get(), Some(Longitudinal::YieldToAgent | Longitudinal::StopForObstacle));
    if !responds || label.lateral.get().is_some() {
        return None;
    }
    // Not "out of our path": the time of this is unknown.
    let free = |at: &&(usize, usize)| {
        let phrase = text[at.0..at.1].to_ascii_lowercase();
        words.subjects.free.iter().any(|w| phrase.contains(w.as_str()))
    };
    let first = *facts.harmless.iter().find(free).or_else(|| {
        let sight = about.meets(words.known.sight) && !about.meets(words.known.adverse);
        facts.clear.first().filter(|_| sight)
    })?;
    if facts.named.iter().any(|n| words.objects[n.group].own.meets(words.known.actor)) {
        return None;
    }
    let sided = facts.named.iter().any(|n| n.side.is_some()) || words.subjects.speaks_of_side(text);
    let lower = text.to_ascii_lowercase();
    let elsewhere = words.subjects.opposite.iter().chain(&words.subjects.beside_ego);
    let opposite = elsewhere.into_iter().any(|w| lower.contains(w.as_str()));
    (!sided && !opposite).then_some(first)
}

/// Bytes of the statement that the other one lets the ego go first, where the ego yields, or that its lane is free
/// ahead, where it follows.
fn nothing_to_respond_to(text: &str, scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, .. } = *scope;
    let said = match label.longitudinal.get().filter(|_| label.lateral.get().is_none())? {
        Longitudinal::YieldToAgent => &words.subjects.lets_ego_go,
        Longitudinal::LeadFollowing => &words.subjects.free_ahead,
        _ => return None,
    };
    let lower = text.to_ascii_lowercase();
    if words.subjects.unable.iter().any(|w| lower.contains(w.as_str())) {
        return None;
    }
    said.iter().filter_map(|w| lower.find(w.as_str()).map(|at| (at, at + w.len()))).min()
}

/// Bytes of the statement that the route does not lead where the ego turns off: "the route does not take the exit".
fn route_refuses(text: &str, facts: &TextFacts, scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, lexicon, .. } = *scope;
    let across = label
        .lateral
        .get()
        .filter(|d| matches!(d, Lateral::Turn | Lateral::MergeOrSplit | Lateral::LaneChange))?;
    let route = facts.there().find(|n| words.objects[n.group].own.meets(words.known.route))?;
    let behind = text[route.end..].to_ascii_lowercase();
    let (at, length) =
        words.subjects.route_not.iter().filter_map(|w| Some((behind.find(w.as_str())?, w.len()))).min()?;
    let from = route.end + at;
    let stem = lexicon.stems.find(&text[from + length..], None, Some(across))?;
    Some((from, from + length + stem))
}

/// Bytes of a road user on the side to which the ego goes, in a component that begins with the side (Chinese) or says
/// that he is in that lane (English), where another component says that this side is free.
fn side_is_taken(
    index: usize,
    text: &str,
    facts: &TextFacts,
    scope: &TextScope<'_>,
) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, .. } = *scope;
    let goes = matches!(
        label.lateral.get(),
        Some(Lateral::LaneChange | Lateral::OutOfLaneNudge | Lateral::MergeOrSplit)
    );
    let left = match label.direction.get().filter(|_| goes)? {
        LateralDirection::Left => true,
        LateralDirection::Right => false,
        LateralDirection::Uturn => return None,
    };
    // Over the line, the ego meets who is oncoming.
    let crosses = label.lateral.get() == Some(Lateral::OutOfLaneNudge);
    let names = if left { ["左", "left lane"] } else { ["右", "right lane"] };
    let has = |t: &str, all: &[String]| {
        let lower = t.to_ascii_lowercase();
        all.iter().any(|w| lower.contains(w.as_str()))
    };
    let there = |t: &str| {
        let own =
            if t.is_ascii() { t.to_ascii_lowercase().contains(names[1]) } else { t.starts_with(names[0]) };
        own || crosses && has(t, &words.subjects.opposite)
    };
    let actor = |n: &&Named| words.objects[n.group].own.meets(words.known.vehicle);
    let free = |f: &TextFacts, t: &str| {
        f.named.iter().filter(actor).any(|n| n.absent)
            || !f.there().any(|n| actor(&n)) && has(t, &words.subjects.free)
    };
    let is_open = has(text, &words.subjects.free) || facts.named.iter().any(|n| n.absent || n.supposed);
    if is_open || !there(text) || words.remote.find(text).is_some() {
        return None;
    }
    let other = |(c, f): (&ComponentView<'_>, &TextFacts)| {
        c.index != index && c.description.get().is_some_and(|t| there(t) && free(f, t))
    };
    let denied = label.parts.iter().zip(&texts.components).any(other);
    // "The nearest car is 50 m behind": far enough.
    let far = words.quantities.lengths(text).iter().any(|q| q.value >= 50.0);
    // "An officer waves traffic to the left lane": who acts is somebody else.
    let first = facts.there().find(|n| words.objects[n.group].own.meets(words.known.actor));
    let many = |n: &&Named| text.get(n.start..n.end).is_some_and(|name| words.subjects.is_of_many(name));
    let n = first.filter(|n| actor(n) && !many(n) && denied && !far)?;
    Some((n.start, n.end))
}

/// Bytes of the statement that there is no room on the side to which the ego goes.
fn no_room(text: &str, facts: &TextFacts, scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, .. } = *scope;
    let goes = matches!(
        label.lateral.get(),
        Some(Lateral::LaneChange | Lateral::InLaneNudge | Lateral::OutOfLaneNudge | Lateral::MergeOrSplit)
    );
    let left = match label.direction.get().filter(|_| goes)? {
        LateralDirection::Left => true,
        LateralDirection::Right => false,
        LateralDirection::Uturn => return None,
    };
    let side = if left { ["左", "left"] } else { ["右", "right"] };
    let other = if left { ["右", "right"] } else { ["左", "left"] };
    let lower = text.to_ascii_lowercase();
    let has = |names: [&str; 2]| lower.contains(names[0]) || lower.contains(names[1]);
    let gone = |n: &&Named| n.absent && words.objects[n.group].own.meets(words.known.gap);
    let none = facts.named.iter().find(gone).map(|n| (n.start, n.end));
    let full = || {
        let all = words.subjects.full.iter();
        all.filter_map(|w| lower.find(w.as_str()).map(|at| (at, at + w.len()))).min()
    };
    (has(side) && !has(other)).then(|| none.or_else(full)).flatten()
}

/// Bytes of the statement that nobody is there, where the ego aborts its maneuver: on a side, in a component that names
/// no road user. It may be about the lane to which the ego returns.
fn room_for_aborted(text: &str, facts: &TextFacts, scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, .. } = *scope;
    let acts = |n: &Named| words.objects[n.group].own.meets(words.known.actor);
    let lower = text.to_ascii_lowercase();
    let of_own_lane = words.subjects.own_lane.iter().any(|w| lower.contains(w.as_str()));
    if label.lateral.get() != Some(Lateral::ManeuverAbort)
        || facts.there().any(acts)
        || of_own_lane
        || !words.subjects.speaks_of_side(text)
    {
        return None;
    }
    facts.named.iter().find(|n| n.absent && acts(n)).map(|n| (n.start, n.end))
}

/// Bytes of the statement of a component that another one denies: that something present is absent, that it hides or
/// hinders nothing, or that the road user to which the ego responds is out of the way.
fn against_another(
    index: usize,
    text: &str,
    facts: &TextFacts,
    scope: &TextScope<'_>,
) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, about, .. } = *scope;
    let KnownKinds { adverse, sight, actor, .. } = words.known;
    let others = || {
        let all = label.parts.iter().zip(&texts.components).filter(|(c, _)| c.index != index);
        all.flat_map(|(_, f)| f.there())
    };
    let own = |n: &Named| words.objects[n.group].own;
    let bad = adverse.with(sight).without(actor).only(about);
    // Statements about what may come or may exist deny nothing. Nor do those about where the ego has been.
    let lower = text.to_ascii_lowercase();
    let is_earlier = words.subjects.earlier.iter().any(|w| lower.contains(w.as_str()));
    if facts.named.iter().any(|n| n.supposed) || text.contains("会不会") || is_earlier {
        return None;
    }
    let is_there = |n: &Named| facts.there().any(|m| m.group == n.group);
    // "A junction without lights": the kind of the thing.
    let is_kind = |n: &Named| text[n.end..].starts_with('的');
    // The side to which the ego goes may be free of it.
    let goes_there = label.direction.get().is_some() && words.subjects.speaks_of_side(text);
    let missing = |n: &&Named| {
        let elsewhere = || others().any(|m| m.group == n.group);
        n.absent && own(n).meets(bad) && !goes_there && !is_kind(n) && !is_there(n) && elsewhere()
    };
    if let Some(n) = facts.named.iter().find(missing) {
        return Some((n.start, n.end));
    }
    let clear = || {
        let hinders = |n: &Named| own(n).meets(bad);
        // Another part of the road may be free.
        if !matches!(label.lateral.get(), None | Some(Lateral::LaneKeeping))
            || words.subjects.speaks_of_side(text)
        {
            return None;
        }
        facts.clear.first().filter(|_| !facts.there().any(hinders) && others().any(hinders)).copied()
    };
    let harmless = || {
        let same = |n: &Named| own(n).meets(actor) && others().any(|m| m.group == n.group);
        let responds = label.longitudinal == Slot::Is(Longitudinal::YieldToAgent)
            || label.longitudinal == Slot::Is(Longitudinal::StopForObstacle);
        let said = facts.named.iter().any(same) && facts.acts.iter().all(|a| a.denied);
        facts.harmless.first().filter(|_| responds && said).copied()
    };
    clear().or_else(harmless)
}
