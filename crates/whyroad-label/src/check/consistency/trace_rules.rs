//! Rules of the trace text (LABELING.md 7): its form, and its agreement with the decisions.

use crate::check::consistency::ego_at_last;
use crate::check::consistency::last_action;
use crate::check::consistency::sequel;
use crate::check::consistency::trace::{Force, Mention, Reading, TraceVerdict, aftermath, form, judge};
use crate::check::consistency::trace_stems::{self, ByStem};
use crate::check::consistency::undecided;
use crate::check::excerpt::excerpt;
use crate::check::reading::Named;
use crate::check::texts::TextScope;
use crate::check::view::View;
use whyroad_framework::DecisionSets;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::decision_table::ClassDecisions;
use whyroad_framework::label_words::Divider;
use whyroad_framework::lexicon::Lexicon;
use whyroad_model::Bilingual;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::label_fields::{name, pointer};

/// Text of the trace about later events, as bytes. Mentions after the decision are removed from `reading`.
pub(in crate::check) fn aftermath(
    text: &str,
    scope: &TextScope<'_>,
    reading: &mut Reading,
) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, lexicon, .. } = *scope;
    let decides =
        |m: &Mention| matches!(m.force, Force::Asserted | Force::Doubtful) && says_label(m, lexicon, label);
    // A set speed is kept on the way: nothing is resumed.
    let set_speed = label.longitudinal.get() == Some(Longitudinal::SetSpeedTracking);
    let resumes = |m: &Mention| match lexicon.phrases[m.phrase].longitudinal.as_slice() {
        [] => None,
        _ if set_speed => None,
        all if all.contains(&Longitudinal::Resume) => {
            let slows =
                [Longitudinal::YieldToAgent, Longitudinal::StopForRegulation, Longitudinal::StopForObstacle];
            (!slows.iter().any(|d| all.contains(d))).then_some(true)
        }
        _ => Some(false),
    };
    let Some(found) = aftermath::find(text, texts, reading, words, &decides, &resumes) else {
        let resolved = || aftermath::resolved(text, texts, reading, words, &decides);
        return responds(label).then(resolved).flatten().or_else(|| aftermath::done(text, texts, words));
    };
    reading.mentions.retain(|m| m.start < found.0);
    reading.end = reading.end.min(found.0);
    Some(found)
}

/// "I let the car settle", where no component speaks of a vehicle: the ego is let do it, and nobody is given way to.
pub(in crate::check) fn leave_out_own_vehicle(text: &str, scope: &TextScope<'_>, reading: &mut Reading) {
    let TextScope { texts, words, .. } = *scope;
    if !text.is_ascii() || texts.components.iter().any(|f| f.groups.meets(words.known.vehicle)) {
        return;
    }
    let own = |m: &Mention| {
        // To the end of the word behind it.
        let behind = text[m.end..].trim_start().split_once(' ').map_or(0, |(_, rest)| rest.len() + 1);
        let lower = text[m.start..text.len() - behind].to_ascii_lowercase();
        lower.strip_prefix("let ").is_some_and(|object| words.subjects.may_be_ego.iter().any(|w| object == w))
    };
    reading.mentions.retain(|m| !own(m));
}

/// The decision responds to somebody in the way, so that it has no cause once he is out of it.
pub(in crate::check) fn responds(label: &View<'_>) -> bool {
    match label.longitudinal.get() {
        Some(d) => matches!(d, Longitudinal::YieldToAgent | Longitudinal::StopForObstacle),
        None => matches!(label.lateral.get(), Some(Lateral::InLaneNudge | Lateral::OutOfLaneNudge)),
    }
}

/// What a trace states about the label's decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::check) enum Said {
    /// It states this decision, or another one.
    Decision,
    /// It has words that are not in any list.
    Unread,
    /// It is too short to contain a reason.
    TooLittle,
}

/// Form of the trace, and its agreement with the decisions.
pub(in crate::check) fn trace(
    scope: &TextScope<'_>,
    class: Option<&ClassDecisions>,
    names: &DecisionSets,
    reading: &Reading,
    sink: &mut dyn Sink,
) -> Said {
    let TextScope { label, texts, words, lexicon, .. } = *scope;
    let Some(text) = label.trace.get() else { return Said::TooLittle };
    if text.trim().is_empty() {
        sink.report(Finding::error("label.trace.empty", pointer::COC_TRACE), &|| {
            Words::new("因果描述为空", "the trace is empty").hint(
                "按“状态、原因、决策”的顺序写 50 至 100 字",
                "write the state, why it matters, and the decision, in about 30 to 60 words",
            )
        });
        return Said::TooLittle;
    }
    let limits = &lexicon.limits;
    let seen = form(text, limits);
    let short = seen.length < limits.too_short_below;
    if limits.too_long_above > 0 && seen.length > limits.too_long_above {
        sink.report(Finding::warning("label.trace.too_long", pointer::COC_TRACE), &|| {
            Words::new(
                format!("因果描述过长（约 {} 字）", seen.length),
                format!("the trace is too long (about {} words)", seen.length / 2),
            )
            .hint(
                "只留影响决策的内容，50 至 100 字",
                "keep only what affects the decision, about 30 to 60 words",
            )
        });
    }
    if limits.too_long_above > 0 && seen.numbers > limits.numbers_above {
        sink.report(Finding::warning("label.trace.numbers", pointer::COC_TRACE), &|| {
            Words::new(
                format!("因果描述中数字过多（{} 个）", seen.numbers),
                format!("the trace has too many numbers ({})", seen.numbers),
            )
            .hint(
                "先定性描述：“很近”“较快”，数字只留关键的",
                "describe it in words first (close, fast); keep only the numbers that matter",
            )
        });
    }
    if let Some((start, end)) = reading.decision_id {
        sink.report(
            Finding::warning("label.trace.decision_id", pointer::COC_TRACE).part(start, end),
            &|| {
                let id = &text[start..end];
                Words::new(
                    format!("因果描述中出现决策标识 '{id}'"),
                    format!("the trace contains the decision identifier '{id}'"),
                )
                .hint("用自然语言写决策", "name the decision in natural language")
            },
        );
    }
    if let Some(v) = refused_at_last(scope, reading) {
        verdict(&v, text, names, false, sink);
        return Said::Decision;
    }
    let (longitudinal, lateral) = (label.longitudinal, label.lateral);
    let (mut none, mut found) = (false, false);
    let no_side = ego_at_last::says_no_side(scope);
    let says_no_side = no_side.is_some();
    let is_about =
        |v: &TraceVerdict, d: Lateral| matches!(v, TraceVerdict::NotStated { label, .. } if *label == d.id());
    let going = ego_at_last::goes_on(scope);
    let foresees = ego_at_last::foresees(text, &words.forms);
    judge(reading, lexicon, longitudinal.get(), lateral.get(), label.direction.get(), &mut |v| {
        // An unreadable decision is not a null decision: its channel is not judged.
        let unreadable = match &v {
            // "So it goes on standing where it is": what it did before is no new decision.
            TraceVerdict::Unlabelled { channel: name::LONGITUDINAL, start, .. } => {
                longitudinal == Slot::Broken || goes_on(&text[..*start])
            }
            TraceVerdict::Unlabelled { .. } => lateral == Slot::Broken,
            _ => false,
        };
        // "The left-turn waiting area", "we are first for the left turn": a name.
        let is_name = match v {
            TraceVerdict::Unlabelled { start, end, says, .. } if says == Lateral::Turn.id() => {
                let inside = |n: &Named| n.start <= end && n.end > end;
                text[..start].ends_with('是') || texts.trace.named.iter().any(inside)
            }
            _ => false,
        };
        let unreadable = unreadable || is_name;
        if !unreadable {
            let mut v = v;
            let by_stem = |decision: &str, other: Option<Lateral>, apart: Option<(usize, usize)>| {
                // It is known which channel is not stated: the stems of the other one do not matter.
                let across = lateral.get().filter(|d| d.id() == decision);
                let both = match across {
                    Some(_) => (None, across),
                    None => (longitudinal.get(), other),
                };
                trace_stems::read(text, reading, lexicon, both, texts, words, apart)
            };
            match v {
                TraceVerdict::NotStated { label: decision, .. } => {
                    match by_stem(decision, lateral.get(), None) {
                        ByStem::Stated { .. } => match goes_to_other_side(text, scope, reading) {
                            Some(other) => v = other,
                            None => return,
                        },
                        ByStem::Denied(start, end) => {
                            v = TraceVerdict::Denied { label: decision, start, end }
                        }
                        ByStem::Against(start, end) => {
                            v = TraceVerdict::Against { label: decision, start, end }
                        }
                        ByStem::Unread => {
                            let denied =
                                denied_of_vehicle(text, scope, reading).or_else(|| refused(text, reading));
                            let keeps = || last_action::keeps_speed(text, longitudinal.get(), &words.forms);
                            let side = || goes_to_other_side(text, scope, reading);
                            if let Some((start, end)) = denied {
                                v = TraceVerdict::Denied { label: decision, start, end };
                            } else if let Some(other) = side() {
                                v = other;
                            } else if let Some((start, end)) = keeps() {
                                v = TraceVerdict::Against { label: decision, start, end };
                            } else if let Some(other) = going.clone() {
                                v = other;
                            }
                        }
                    }
                }
                // Words that are in no phrase may still state it: "take some speed off".
                // Pulling over is a movement to the side, too.
                TraceVerdict::OtherDecision { label: decision, ref says, .. }
                    if says.len() > 1 && decision == Lateral::PullOver.id() =>
                {
                    return;
                }
                TraceVerdict::OtherDecision { label: decision, ref says, start, end }
                    if says.len() > 1
                        && matches!(
                            by_stem(decision, None, Some((start, end))),
                            ByStem::Stated { contested: false }
                        ) =>
                {
                    return;
                }
                _ => {}
            }
            let not_stated = matches!(v, TraceVerdict::NotStated { .. });
            none |= not_stated;
            found = true;
            // A trace that is too short is reported for its length.
            if !(not_stated && seen.length < limits.too_short_below / 2) {
                let read = not_stated
                    && (undecided::is_undecided(text, reading, texts, words, undecided::Strict::No)
                        || !reading.marked && last_action::describes_at_last(text, &words.forms)
                        || ego_at_last::describes(text, &words.forms)
                        || foresees
                        || lateral.get().is_some_and(|d| says_no_side && is_about(&v, d)));
                verdict(&v, text, names, read, sink);
            }
        }
    });
    // Stated only in words about other road users' actions, or about the state.
    let decision = || {
        let along = longitudinal.get().filter(|d| *d != Longitudinal::SetSpeedTracking).map(|d| d.id());
        along.or_else(|| lateral.get().filter(|d| *d != Lateral::LaneKeeping).map(|d| d.id()))
    };
    let by_phrase = || {
        reading
            .mentions
            .iter()
            .any(|m| !m.by_other && m.force != Force::Negated && says_label(m, lexicon, label))
    };
    let decided = || longitudinal.get().map(|d| d.id()).or_else(|| lateral.get().map(|d| d.id()));
    if let (false, false, Some(id)) = (found, short, if foresees { decided() } else { decision() })
        && (!by_phrase() && undecided::is_undecided(text, reading, texts, words, undecided::Strict::Yes)
            || foresees)
    {
        (found, none) = (true, true);
        let v = TraceVerdict::NotStated {
            label: id,
            start: reading.decision_from.min(reading.end),
            end: reading.end,
        };
        verdict(&v, text, names, true, sink);
    }
    if let (false, Some(v)) = (found, side_beside(text, scope, reading)) {
        found = true;
        verdict(&v, text, names, false, sink);
    }
    if let (true, Some(v)) = (!found || none, last_action::other_side(scope)) {
        found = true;
        verdict(&v, text, names, false, sink);
    }
    if let (false, Some(v)) = (found, going) {
        found = true;
        verdict(&v, text, names, false, sink);
    }
    if let (false, Some(v)) = (found, no_side) {
        (found, none) = (true, true);
        verdict(&v, text, names, true, sink);
    }
    found = found || last_action::without_decision(scope, sink);
    found = found || ego_at_last::aside_without_decision(scope, sink);
    found = found || ego_at_last::slows_without_decision(scope, sink);
    let says = |m: &Mention| says_label(m, lexicon, label);
    found = found || sequel::second_action(scope, reading, class, names, &says, sink);
    // "Does not yield and turns left": the other channel is stated.
    if let (false, Some(along), Some(_)) = (found, longitudinal.get(), lateral.get()) {
        let stated = reading.mentions.iter().any(|m| {
            !m.by_other
                && m.force != Force::Negated
                && lexicon.phrases[m.phrase].longitudinal.contains(&along)
        });
        let read = || trace_stems::read(text, reading, lexicon, (Some(along), None), texts, words, None);
        if !stated && let ByStem::Denied(start, end) = read() {
            found = true;
            verdict(&TraceVerdict::Denied { label: along.id(), start, end }, text, names, false, sink);
        }
    }
    // A short trace may still contain all three: "yellow, far away, stopping".
    let too_short = short
        && (none && seen.length < limits.too_short_below / 2
            || !found && (seen.length < limits.too_short_below / 3 || texts.trace.words == 0));
    if too_short {
        sink.report(Finding::error("label.trace.too_short", pointer::COC_TRACE), &|| {
            Words::new(
                format!("因果描述太短（约 {} 字），写不下状态、原因和决策", seen.length),
                format!(
                    "the trace is too short for state, reason and decision (about {} words)",
                    seen.length / 2
                ),
            )
            .hint("写 50 至 100 字", "write about 30 to 60 words")
        });
    }
    match (too_short, none) {
        (true, _) => Said::TooLittle,
        (_, true) => Said::Unread,
        _ => Said::Decision,
    }
}

/// "The vehicle does not stop", where no component mentions a vehicle: the ego. Bytes of what is denied.
fn denied_of_vehicle(text: &str, scope: &TextScope<'_>, reading: &Reading) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, lexicon, .. } = *scope;
    if texts.components.iter().any(|f| f.groups.meets(words.known.vehicle)) {
        return None;
    }
    let named = |m: &Mention| {
        let (from, _) = words.clauses.around(&texts.units, m.start..m.end, text.len(), &|_| true);
        let before = text[from..m.start].to_ascii_lowercase();
        words.subjects.may_be_ego.iter().any(|w| before.contains(w.as_str()))
    };
    let denied = |m: &&Mention| m.clause == reading.last_clause && m.by_other && m.denied;
    let m = reading.mentions.iter().filter(denied).find(|m| says_label(m, lexicon, label) && named(m))?;
    Some((m.start, m.end))
}

/// "By rule it has to let it go first, and it does not": the ego is named, and the last action that it is said not to
/// do is the label's decision, whatever it has to do according to the clauses before.
fn refused_at_last(scope: &TextScope<'_>, reading: &Reading) -> Option<TraceVerdict> {
    let TextScope { label, lexicon, .. } = *scope;
    let (start, _, clause) = reading.refused?;
    let says = |m: &&Mention| !m.by_other && says_label(m, lexicon, label);
    let own = || reading.mentions.iter().filter(says);
    let asserted = |m: &Mention| matches!(m.force, Force::Asserted | Force::Doubtful);
    if clause + 1 < reading.last_clause || own().any(|m| m.start >= start && asserted(m)) {
        return None;
    }
    let denied =
        |m: &&Mention| m.clause == clause && m.force == Force::Negated && m.by_ego && m.start >= start;
    let m = own().find(denied)?;
    let along = |d: &Longitudinal| lexicon.phrases[m.phrase].longitudinal.contains(d);
    let label = match label.longitudinal.get().filter(along) {
        Some(d) => d.id(),
        None => label.lateral.get()?.id(),
    };
    Some(TraceVerdict::Denied { label, start: m.start, end: m.end })
}

/// The action in the last clause that the ego, named there, does not do, in any words: "we are not shifting over".
/// Bytes from the negating word to the end.
fn refused(text: &str, reading: &Reading) -> Option<(usize, usize)> {
    let (start, _, clause) = reading.refused?;
    let end = reading.end.min(text.len());
    let other = |m: &Mention| m.clause == clause && m.start > start && m.force != Force::Negated;
    (clause == reading.last_clause && start < end && !reading.mentions.iter().any(other))
        .then_some((start, end))
}

/// The side of a movement that the trace states in words that are in no list, if it is not the label's: "and over
/// leftwards we go". Not where the deciding part also names the label's side, or a road user is there.
fn goes_to_other_side(text: &str, scope: &TextScope<'_>, reading: &Reading) -> Option<TraceVerdict> {
    let TextScope { label, texts, words, .. } = *scope;
    let direction = label.direction.get()?;
    let (own, other, says) = match direction {
        LateralDirection::Left => (0, 1, LateralDirection::Right),
        LateralDirection::Right => (1, 0, LateralDirection::Left),
        LateralDirection::Uturn => return None,
    };
    let end = reading.end.min(text.len());
    // Without a word that marks it, the decision is in the last clause.
    let (last, _) = words.clauses.around(&texts.units, end..end, text.len(), &|d| d != Divider::Item);
    let from = if reading.marked { reading.decision_from } else { last.max(reading.decision_from) };
    let part = text.get(from..end)?.to_ascii_lowercase();
    let find = |side: usize| {
        let all = words.subjects.goes_to[side].iter();
        all.filter_map(|w| Some((part.find(w.as_str())?, w.len()))).min()
    };
    let (at, length) = find(other)?;
    let range = from..end;
    // "So we slow for the kid and shade over to the right": a movement between the name and the side.
    const NEAR: usize = 12;
    let of_somebody = |n: &Named| {
        let beside = n.end <= from + at && from + at - n.end <= NEAR || n.start >= from + at + length;
        range.contains(&n.start)
            && n.side.is_some()
            && beside
            && words.objects[n.group].own.meets(words.known.actor)
    };
    (find(own).is_none() && !texts.trace.named.iter().any(of_somebody)).then(|| TraceVerdict::OtherSide {
        label: direction,
        says,
        start: from + at,
        end: from + at + length,
    })
}

/// The side of a movement in the trace, if it is separate from the verb: "moves over to the lane on the right". Not
/// where it is the side of a road user, or where the label's side is named, too.
fn side_beside(text: &str, scope: &TextScope<'_>, reading: &Reading) -> Option<TraceVerdict> {
    let TextScope { label, texts, words, lexicon, .. } = *scope;
    let (lateral, direction) = (label.lateral.get()?, label.direction.get()?);
    let (own, other, says) = match direction {
        LateralDirection::Left => (["左", "left"], ["右", "right"], LateralDirection::Right),
        LateralDirection::Right => (["右", "right"], ["左", "left"], LateralDirection::Left),
        LateralDirection::Uturn => return None,
    };
    let moves = |m: &&Mention| {
        let known = lexicon.phrases[m.phrase].lateral.contains(&lateral);
        known && m.force == Force::Asserted && m.start >= reading.decision_from && !m.by_other
    };
    let m = reading.mentions.iter().find(moves)?;
    let (_, end) = words.clauses.around(&texts.units, m.start..m.end, text.len(), &|_| true);
    let behind = text.get(m.end..end)?.to_ascii_lowercase();
    // "Left" is a participle, too.
    let has = |part: &str, side: [&str; 2]| {
        part.contains(side[0]) || part.split(|c: char| !c.is_ascii_alphabetic()).any(|w| w == side[1])
    };
    let decision = text.get(reading.decision_from.min(m.start)..)?.to_ascii_lowercase();
    let at = behind.find(other[0]).or_else(|| behind.rfind(&format!(" {}", other[1])))?;
    let of_somebody = |n: &whyroad_framework::label_words::ObjectGroup| {
        !n.own.meets(words.known.no_cause) && !n.own.meets(words.known.road)
    };
    let range = m.start..end;
    let another = texts.trace.named.iter().filter(|n| range.contains(&n.start) && n.side.is_some());
    if has(&decision, own)
        || m.side.is_some()
        || another.into_iter().any(|n| of_somebody(&words.objects[n.group]))
    {
        return None;
    }
    // "The right of way", "on the right of it".
    let rest = &behind[at..];
    if [" right of", " left of", " right away", " left over"].iter().any(|w| rest.starts_with(w)) {
        return None;
    }
    Some(TraceVerdict::OtherSide { label: direction, says, start: m.start, end })
}

/// The part `from..to` of the trace states the label's decision, for the ego.
pub(in crate::check) fn states_decision(
    reading: &Reading,
    lexicon: &Lexicon,
    label: &View<'_>,
    from: usize,
    to: usize,
) -> bool {
    reading.mentions_in(from, to).iter().any(|m| !m.by_other && says_label(m, lexicon, label))
}

/// The mention agrees with a decision of the label.
pub(super) fn says_label(m: &Mention, lexicon: &Lexicon, label: &View<'_>) -> bool {
    let says = &lexicon.phrases[m.phrase];
    label.longitudinal.get().is_some_and(|d| says.longitudinal.contains(&d))
        || label.lateral.get().is_some_and(|d| says.lateral.contains(&d))
}

/// A side, for messages.
pub(in crate::check) fn direction_name(direction: LateralDirection) -> Bilingual {
    match direction {
        LateralDirection::Left => Bilingual::new("左", "left"),
        LateralDirection::Right => Bilingual::new("右", "right"),
        LateralDirection::Uturn => Bilingual::new("掉头", "U-turn"),
    }
}

/// The words right before an action say that it goes on.
fn goes_on(before: &str) -> bool {
    const ZH: [&str; 8] = ["继续", "仍", "仍然", "依旧", "依然", "一直", "保持", "接着"];
    const EN: [&str; 8] =
        ["continues", "continue", "continuing", "keeps on", "keep on", "goes on", "go on", "carries on"];
    // "Goes on following and slowing": one action may stand between.
    const BETWEEN_ZH: [&str; 7] = ["", "跟车", "跟着", "跟着前车", "原地", "在原地", "跟随前车"];
    let lower = before.trim_end().to_ascii_lowercase();
    let zh = BETWEEN_ZH
        .iter()
        .any(|b| lower.strip_suffix(b).is_some_and(|rest| ZH.iter().any(|w| rest.ends_with(w))));
    let en = lower.strip_suffix(" to").unwrap_or(&lower);
    zh || EN.iter().any(|w| en.ends_with(w))
}

/// `A, B or C`.
fn either(names: &[&str], comma: &str, or: &str) -> String {
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{}{or}{last}", rest.join(comma)),
        _ => names.concat(),
    }
}

/// `read`: no part of the trace can be a decision in words that are in no list.
fn verdict(v: &TraceVerdict, text: &str, names: &DecisionSets, read: bool, sink: &mut dyn Sink) {
    let name = |id: &str| names.name(id);
    let check_end = |words: Words| {
        words.hint("检查决策，或改写因果描述的结尾", "check the decision, or rewrite the end of the trace")
    };
    let at = |f: Finding, start: &usize, end: &usize| f.part(*start, *end);
    match v {
        TraceVerdict::OtherDecision { label, says, start, end } => {
            let finding = Finding::error("label.trace.contradicts", pointer::COC_TRACE);
            sink.report(at(finding, start, end), &|| {
                let (phrase, label) = (&text[*start..*end], name(label));
                let says: Vec<Bilingual> = says.iter().map(|id| name(id)).collect();
                let zh: Vec<&str> = says.iter().map(|b| b.zh.as_str()).collect();
                let en: Vec<&str> = says.iter().map(|b| b.en.as_str()).collect();
                check_end(Words::new(
                    format!("决策是“{}”，因果描述却说“{phrase}”（{}）", label.zh, either(&zh, "、", "或")),
                    format!(
                        "the decision is '{}', but the trace says '{phrase}' ({})",
                        label.en,
                        either(&en, ", ", " or ")
                    ),
                ))
            });
        }
        TraceVerdict::Denied { label, start, end } => {
            let finding = Finding::error("label.trace.contradicts", pointer::COC_TRACE);
            sink.report(at(finding, start, end), &|| {
                let (phrase, label) = (&text[*start..*end], name(label));
                // A phrase like "不变" is a negation itself.
                let negates = !["不", "没", "未", "无"].iter().any(|no| phrase.starts_with(no));
                let (zh, en) = if negates { ("否定了", "negates") } else { ("说", "says") };
                check_end(Words::new(
                    format!("决策是“{}”，因果描述却{zh}“{phrase}”", label.zh),
                    format!("the decision is '{}', but the trace {en} '{phrase}'", label.en),
                ))
            });
        }
        TraceVerdict::Against { label, start, end } => {
            let finding = Finding::warning("label.trace.contradicts", pointer::COC_TRACE);
            sink.report(at(finding, start, end), &|| {
                let (phrase, label) = (&text[*start..*end], name(label));
                check_end(Words::new(
                    format!("决策是“{}”，因果描述却说自车“{phrase}”", label.zh),
                    format!("the decision is '{}', but the trace says '{phrase}' about the ego", label.en),
                ))
            });
        }
        TraceVerdict::OtherSide { label, says, start, end } => {
            let finding = Finding::error("label.trace.direction", pointer::COC_TRACE);
            sink.report(at(finding, start, end), &|| {
                let phrase = &text[*start..*end];
                let (label, says) = (direction_name(*label), direction_name(*says));
                Words::new(
                    format!("决策的方向是“{}”，因果描述却说“{phrase}”（{}）", label.zh, says.zh),
                    format!(
                        "the direction of the decision is {}, but the trace says '{phrase}' ({})",
                        label.en, says.en
                    ),
                )
                .hint("改正其中有误的一处", "correct the one that is wrong")
            });
        }
        TraceVerdict::Unlabelled { channel, says, start, end } => {
            let finding = Finding::warning("label.trace.unlabelled", pointer::COC_TRACE);
            sink.report(at(finding, start, end), &|| {
                let (phrase, says) = (&text[*start..*end], name(says));
                let (zh, en) = match *channel {
                    name::LONGITUDINAL => ("纵向", "longitudinal"),
                    _ => ("横向", "lateral"),
                };
                Words::new(
                    format!("因果描述说“{phrase}”（{}），{zh}决策却是“无决策变化”", says.zh),
                    format!("the trace says '{phrase}' ({}), but the {en} decision is 'no change'", says.en),
                )
                .hint(
                    "确有新决策时补上，否则改写因果描述",
                    "add the decision if there was one, or rewrite the trace",
                )
            });
        }
        TraceVerdict::NotStated { label, start, end } => {
            let code = "label.trace.decision_missing";
            let finding = match read {
                true => Finding::warning(code, pointer::COC_TRACE),
                false => Finding::note(code, pointer::COC_TRACE),
            };
            sink.report(at(finding, start, end), &|| {
                let (label, ending) = (name(label), excerpt(&text[*start..*end]));
                Words::new(
                    format!("因果描述写的决策是“{ending}”，没有说出“{}”", label.zh),
                    format!("the trace ends with '{ending}', which does not state '{}'", label.en),
                )
                .hint(
                    format!("以决策结尾，写出“{}”或同样意思的话；或检查决策", label.zh),
                    format!(
                        "end with the decision, in words that mean '{}'; or check the decision",
                        label.en
                    ),
                )
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::goes_on;

    /// LABELING.md 2: what the ego did before is no new decision.
    #[test]
    fn an_action_that_goes_on_is_told_from_a_new_one() {
        for before in
            ["因此自车继续", "因此自车仍然", "所以自车继续跟车", "so the ego continues to", "so we keep on"]
        {
            assert!(goes_on(before), "{before}");
        }
        for before in ["因此自车", "前车继续行驶，因此自车", "so the ego", "we continue to follow it and"]
        {
            assert!(!goes_on(before), "{before}");
        }
    }
}
