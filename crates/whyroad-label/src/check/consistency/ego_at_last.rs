//! What the last clauses of a trace say that the ego does, by the meaning of their words rather than by a phrase: it
//! goes on where it has to slow, it moves aside where the label has no lateral decision, or no word is about a side
//! although the label has a maneuver to one. Used only where nothing else was found.

use crate::check::consistency::last_action::{LATERAL, LONGITUDINAL, clauses, last_sentence, report};
use crate::check::consistency::trace::TraceVerdict;
use crate::check::reading::Named;
use crate::check::texts::{TextScope, Texts};
use whyroad_framework::LabelWords;
use whyroad_framework::check::{Sink, Slot};
use whyroad_framework::label_words::Forms;
use whyroad_framework::phrases::Phrases;
use whyroad_model::decision::{Lateral, Longitudinal};

/// Clauses at the end of a trace that state the decision.
const DECIDING: usize = 2;

/// A text without Chinese: "coupé" is in an English one.
fn is_latin(text: &str) -> bool {
    !text.chars().any(|c| ('\u{3400}'..='\u{9fff}').contains(&c))
}

/// First byte and text of the last clauses, at most `most`; `lower` is in lower case.
fn last_clauses<'t>(lower: &'t str, most: usize, forms: &Forms) -> Vec<(usize, &'t str)> {
    if is_latin(lower) {
        let (from, sentence) = last_sentence(lower);
        let mut out = Vec::new();
        for (at, clause) in clauses(sentence) {
            let mut begin = 0;
            while let Some((a, b)) = forms.links.find(&clause[begin..]) {
                out.push((from + at + begin, &clause[begin..begin + a]));
                begin += b;
            }
            out.push((from + at + begin, &clause[begin..]));
        }
        out.retain(|(_, c)| c.contains(char::is_alphanumeric));
        return out.split_off(out.len().saturating_sub(most));
    }
    let mut out = Vec::new();
    let mut end = lower.len();
    for (at, c) in lower.char_indices().rev().filter(|(_, c)| "，,、：；;。！？".contains(*c)) {
        let from = at + c.len_utf8();
        if lower[from..end].contains(char::is_alphanumeric) {
            out.push((from, &lower[from..end]));
        }
        end = at;
        if out.len() == most {
            break;
        }
    }
    if out.len() < most && lower[..end].contains(char::is_alphanumeric) {
        out.push((0, &lower[..end]));
    }
    out.reverse();
    out
}

/// One of the words, which are whole in English.
fn has(list: &Phrases, text: &str) -> bool {
    list.find(text).is_some()
}

/// The words of a part of an English clause, before a verb, leave the ego as its subject.
fn by_ego(before: &str, forms: &Forms) -> bool {
    let mut all = before.split(|c: char| !c.is_ascii_alphanumeric() && c != '\'').filter(|w| !w.is_empty());
    let ego = |w: &str| forms.of_ego.iter().any(|l| l == w);
    let nobody = before.trim().is_empty();
    !has(&forms.not_of_ego, before) && (nobody || all.any(ego))
}

/// The part of a Chinese clause before a verb names somebody else, or points to them.
fn names_another(before: &str, forms: &Forms) -> bool {
    let rest = forms.not_others.iter().fold(before.to_owned(), |t, w| t.replace(w.as_str(), ""));
    rest.contains(['车', '人', '它', '他', '她'])
}

/// The ego goes on where its decision is to slow, to stop, to give way or to follow, and nothing in its last clauses is
/// about slowing.
pub(super) fn goes_on(scope: &TextScope<'_>) -> Option<TraceVerdict> {
    let TextScope { label, words, .. } = *scope;
    let (text, along) = (label.trace.get()?, label.longitudinal.get()?);
    let slows = matches!(
        along,
        Longitudinal::YieldToAgent
            | Longitudinal::StopForObstacle
            | Longitudinal::StopForRegulation
            | Longitudinal::RoadSpeedAdaptation
            | Longitudinal::LeadFollowing
    );
    if !slows || label.lateral.get().is_some_and(|l| l != Lateral::LaneKeeping) {
        return None;
    }
    let forms = &words.forms;
    let lower = text.to_ascii_lowercase();
    let last = last_clauses(&lower, DECIDING, forms);
    if last.iter().any(|(_, c)| has(&forms.slowing, c)) {
        return None;
    }
    let found = last.iter().find_map(|(at, clause)| {
        let (a, b) = forms.going.find(clause)?;
        let before = &clause[..a];
        let own = match is_latin(text) {
            true => by_ego(before, forms),
            false => !before.contains(['不', '别', '没']) && !names_another(before, forms),
        };
        own.then_some((at + a, at + b))
    });
    found.map(|(start, end)| TraceVerdict::Against { label: along.id(), start, end })
}

/// Bytes of a movement to the side in the last clauses.
fn moves_aside(text: &str, texts: &Texts, words: &LabelWords) -> Option<(usize, usize)> {
    let forms = &words.forms;
    let lower = text.to_ascii_lowercase();
    let acts = |n: &&Named| words.objects[n.group].own.meets(words.known.actor);
    last_clauses(&lower, DECIDING, forms).into_iter().find_map(|(at, clause)| {
        let (a, b) = forms.aside.find(clause)?;
        let before = &clause[..a];
        if !is_latin(text) {
            let of_somebody = before.contains(['让', '它', '他', '她', '等', '不', '没', '别', '能', '来'])
                || clause[b..].contains(['来', '不'])
                || texts.trace.named.iter().filter(acts).any(|n| (at..at + a).contains(&n.start));
            // "From the left": the ego only where nobody is named before it.
            let begins = |w: &String| !w.is_ascii() && before.ends_with(w.as_str());
            let from = clause[a..].starts_with('从')
                && !before.trim().is_empty()
                && !forms.begins.iter().any(begins);
            return (!of_somebody && !from).then_some((at + a, at + b));
        }
        let behind = &clause[b..];
        let (p, q) = forms.place.find(behind)?;
        let between = &behind[..p];
        let place = &behind[p..q];
        let next = behind[q..].trim_start();
        let is_side = !["left", "right"].contains(&place)
            || forms.no_side.find(next).is_none_or(|(at, _)| at > 0 || between.contains("to the"));
        let own = !has(&forms.not_of_ego, before) && !has(&forms.placed, between) && is_side;
        own.then_some((at + a, at + b + q))
    })
}

/// The label has no lateral decision, and the last clauses say that the ego moves aside. Returns true when they do.
pub(super) fn aside_without_decision(scope: &TextScope<'_>, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, .. } = *scope;
    let Some(text) = label.trace.get() else { return false };
    if label.lateral != Slot::Absent || label.longitudinal == Slot::Broken || texts.trace.unchanged.is_some()
    {
        return false;
    }
    let Some((start, end)) = moves_aside(text, texts, words) else { return false };
    report(text, (start, end), LATERAL, sink);
    true
}

/// The label has no decision about the ego's speed, and the last clauses say that it slows. Returns true when they do.
pub(super) fn slows_without_decision(scope: &TextScope<'_>, sink: &mut dyn Sink) -> bool {
    /// Clauses of a Chinese trace that are read.
    const LAST: usize = 3;
    let TextScope { label, texts, words, .. } = *scope;
    let Some(text) = label.trace.get() else { return false };
    if label.longitudinal != Slot::Absent || label.lateral == Slot::Broken || texts.trace.unchanged.is_some()
    {
        return false;
    }
    let forms = &words.forms;
    let lower = text.to_ascii_lowercase();
    let most = if is_latin(text) { DECIDING } else { LAST };
    // "It was slowing already": what goes on is no decision.
    const GOES_ON: [&str; 14] = [
        "已", "维持", "还在", "继续", "仍", "保持", "此前", "之前", "一直", "already", "still", "keep",
        "goes on", "continu",
    ];
    let last = last_clauses(&lower, most, forms);
    if last.iter().any(|(_, c)| GOES_ON.iter().any(|w| c.contains(w))) {
        return false;
    }
    let found = last.into_iter().find_map(|(at, clause)| {
        let (a, b) = forms.slows.find(clause)?;
        let (before, behind) = (&clause[..a], &clause[b..]);
        let own = match is_latin(text) {
            true => by_ego(before, forms),
            false => {
                let open = before.contains(['不', '没', '别', '无', '光', '用', '靠']);
                !names_another(before, forms)
                    && !open
                    && !forms.slow_names.iter().any(|w| behind.starts_with(w.as_str()))
            }
        };
        own.then_some((at + a, at + b))
    });
    let Some((start, end)) = found else { return false };
    report(text, (start, end), LONGITUDINAL, sink);
    true
}

/// The last clause of a Chinese trace only foresees what would follow, and no clause of its sentence responds:
/// "再照这个速度开，就没地方停了". The trace states no decision.
pub(super) fn foresees(text: &str, forms: &Forms) -> bool {
    if is_latin(text) {
        return false;
    }
    let (_, sentence) = last_sentence(text);
    let all = clauses(sentence);
    let Some(((_, last), rest)) = all.split_last() else { return false };
    let begins = |c: &str| forms.if_so.iter().any(|w| c.trim_start().starts_with(w.as_str()));
    let supposes = begins(last) || rest.last().is_some_and(|(_, c)| begins(c));
    supposes && has(&forms.then_so, last) && !all.iter().any(|(_, c)| has(&forms.responds, c))
}

/// The label has a maneuver to the side, and no word of the last clauses can be about one.
pub(super) fn says_no_side(scope: &TextScope<'_>) -> Option<TraceVerdict> {
    /// Clauses of a Chinese trace that are read.
    const LAST: usize = 3;
    let TextScope { label, words, .. } = *scope;
    let text = label.trace.get()?;
    let across = label.lateral.get().filter(|l| *l != Lateral::LaneKeeping)?;
    let lower = text.to_ascii_lowercase();
    let forms = &words.forms;
    let lateral = &forms.lateral;
    if lateral.is_empty() {
        return None;
    }
    let (start, said) = match is_latin(text) {
        true => {
            let (from, sentence) = last_sentence(&lower);
            // "No need to touch the brakes": behind the decision.
            let (_, before) = last_sentence(lower[..from].trim_end());
            let denies = has(&forms.denied, sentence);
            (from, has(lateral, sentence) || denies && has(lateral, before))
        }
        false => {
            let nudges = matches!(across, Lateral::InLaneNudge | Lateral::OutOfLaneNudge);
            let list = if nudges { &forms.nudges } else { lateral };
            let last = last_clauses(&lower, LAST, forms);
            (last.first()?.0, last.iter().any(|(_, c)| has(list, c)))
        }
    };
    (!said).then(|| TraceVerdict::NotStated { label: across.id(), start, end: text.len() })
}

/// Bytes of the statement in the last clauses that the lane or the speed that is decided is the one of before.
pub(in crate::check) fn as_before(scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, .. } = *scope;
    let text = label.trace.get()?;
    let speed = label.longitudinal.get() == Some(Longitudinal::SetSpeedTracking);
    let lane = label.lateral.get() == Some(Lateral::LaneKeeping);
    if !speed && !lane {
        return None;
    }
    let lower = text.to_ascii_lowercase();
    let forms = &words.forms;
    let last = last_clauses(&lower, DECIDING, forms);
    let all = |list: &[&str]| last.iter().any(|(_, c)| list.iter().any(|w| c.contains(w)));
    let digits = is_latin(text) && last.iter().any(|(_, c)| c.contains(|c: char| c.is_ascii_digit()));
    let of_speed = speed && (digits || all(&["speed", "pace", "速"]));
    let of_lane = lane && all(&["lane", "middle", "centre", "center", "横向", "道", "居中", "方向"]);
    let (at, (a, b)) = last.iter().find_map(|(at, c)| Some((*at, forms.as_before.find(c)?)))?;
    (of_speed || of_lane).then_some((at + a, at + b))
}

/// The last sentence of an English trace describes something: it has a finite verb, the ego in it only has or is
/// something, and nothing in it is an order.
pub(super) fn describes(text: &str, forms: &Forms) -> bool {
    const LEAST: usize = 5;
    if !is_latin(text) {
        return false;
    }
    let lower = text.to_ascii_lowercase();
    let (_, sentence) = last_sentence(&lower);
    let is_one = |list: &Phrases, w: &str| list.iter().any(|l| l == w);
    let all: Vec<&str> =
        sentence.split(|c: char| !c.is_ascii_alphanumeric() && c != '\'').filter(|w| !w.is_empty()).collect();
    let finite = all.iter().any(|w| is_one(&forms.is, w) || w.ends_with("n't"));
    let gives_order = clauses(sentence).iter().any(|(_, c)| {
        let first = c.split(|c: char| !c.is_ascii_alphanumeric() && c != '\'').find(|w| !w.is_empty());
        first.is_some_and(|w| is_one(&forms.orders, w) || w.ends_with("ing"))
    });
    let acts = all.iter().enumerate().any(|(i, w)| {
        let subject = ["we", "i", "ego", "car", "vehicle", "it"].contains(w);
        subject
            && all.get(i + 1).is_some_and(|next| !is_one(&forms.stative, next) && !is_one(&forms.is, next))
    });
    let so = all.iter().enumerate().any(|(i, w)| *w == "so" && all.get(i + 1) != Some(&"that"));
    let controls = all.iter().any(|w| ["brake", "brakes", "braking", "braked", "unobserved"].contains(w));
    all.len() >= LEAST && finite && !gives_order && !acts && !so && !controls && !sentence.contains(':')
}
