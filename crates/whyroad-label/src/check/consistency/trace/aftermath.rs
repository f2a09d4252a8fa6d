//! Text of a trace after its decision. LABELING.md 7 requires state, reason, decision: a clause after the decision that
//! reports an event reports what became known only afterwards, whatever its words. A clause that gives a reason, a
//! purpose or a plan does not. This is not a language parser: it uses tense in English and aspect in Chinese, from
//! lists of `schema/label_words.yaml`.

use super::{Force, Mention, Reading};
use crate::check::reading::{Named, TextFacts, is_predicted};
use crate::check::texts::Texts;
use whyroad_framework::LabelWords;
use whyroad_framework::label_words::{Divider, TellWord};

/// Maximum number of clauses after the decision that are read, and of bytes of one.
const MOST_CLAUSES: usize = 24;
const LONGEST_CLAUSE: usize = 1000;

/// The first words after the decision that report an event, as bytes of `text`.
///
/// `decides`: the mention states the label's decision. `resumes`: true if it means to start again, false if to stop or
/// slow.
pub(in crate::check::consistency) fn find(
    text: &str,
    texts: &Texts,
    reading: &Reading,
    words: &LabelWords,
    decides: &dyn Fn(&Mention) -> bool,
    resumes: &dyn Fn(&Mention) -> Option<bool>,
) -> Option<(usize, usize)> {
    if words.is_empty() {
        return None;
    }
    // The marked decision, if the trace marks one; otherwise the first clause that states one, or the last one without
    // a subject of its own.
    let deciding = || {
        let all = reading.mentions.iter().filter(|m| !reading.marked || m.start >= reading.decision_from);
        all.filter(|m| decides(m))
    };
    // "The ego is to turn left" is its route.
    let meant = |m: &Mention| !reading.marked && text[..m.start].ends_with(['要', '想', '需', '得']);
    // An instruction by a sign, a light or the route is not the decision, if another clause states it.
    let shown = |m: &Mention| {
        let (from, _) = words.clauses.around(&texts.units, m.start..m.end, text.len(), &|_| true);
        let shows = words.known.sign.with(words.known.route);
        let mut before = texts.trace.named.iter().filter(|n| (from..m.start).contains(&n.start));
        !reading.marked && before.any(|n| words.objects[n.group].own.meets(shows))
    };
    // "There stands a row of cars": "停了一排车".
    let is_there = |m: &Mention| {
        let behind = text[m.end..].trim_start_matches(['了', '着', '有']);
        behind.len() < text.len() - m.end
            && behind
                .starts_with(|c| words.subjects.counts.contains(c) || words.subjects.counters.contains(c))
    };
    let own = |m: &&Mention| !m.by_other && m.force == Force::Asserted && !meant(m) && !is_there(m);
    let stated = deciding().filter(own).find(|m| !shown(m)).or_else(|| deciding().find(own));
    // A topic at the beginning of the trace: "turning right there is no arrow; ... we turn right".
    let head = words.clauses.clause_end(&texts.units, 0, text.len());
    let stated = match stated {
        Some(m) if !reading.marked && m.start < head && !m.by_ego => {
            deciding().filter(own).filter(|n| n.start >= head && !shown(n) && n.by_ego).last().or(stated)
        }
        _ => stated,
    };
    let stated = stated.or_else(|| deciding().find(|m| !m.by_other && reading.marked));
    let stated = stated.or_else(|| deciding().filter(|m| m.carried || m.force == Force::Asserted).last());
    let decided = match stated {
        Some(m) => m.end,
        None if reading.marked => {
            reading.decision_from + text[reading.decision_from..].chars().next()?.len_utf8()
        }
        None => return None,
    };
    // What is told before the ego's own words for the decision was visible then: the earlier mention was of something
    // else ("the light lets us go, ... I let off the brake and move off").
    let tells = |m: &&Mention| m.by_ego && matches!(m.force, Force::Asserted | Force::Doubtful);
    let last = deciding().filter(tells).last().map_or(0, |m| m.start);
    // Nor is what is told before the last statement of the decision: "a left turn gives way, that is an old rule; ...
    // we brake and wait".
    let at_last =
        deciding().filter(|m| !m.by_other && m.force == Force::Asserted).last().map_or(0, |m| m.start);
    // A trace in the past tense has its decision in the past tense, too.
    let in_past = stated.is_some_and(|m| is_past(&text[m.start..m.end], words));
    let stops = stated.is_some_and(|m| resumes(m) == Some(false));
    let clause_end = |from: usize| words.clauses.clause_end(&texts.units, from, text.len());
    let mut start = clause_end(decided);
    // "Because ..." continues to the end of its sentence.
    let mut because = false;
    // A limited number of clauses: a longer trace is reported for its length.
    for _ in 0..MOST_CLAUSES {
        if start >= text.len() {
            break;
        }
        let end = clause_end(start + text[start..].chars().next()?.len_utf8());
        let clause = &text[start..end];
        because &= !clause.starts_with(['.', ';', '!', '?', '。', '；', '！', '？']);
        let own = reading.mentions.iter().filter(|m| (start..end).contains(&m.start) && !m.by_other);
        let own_decision = own.clone().any(decides);
        // Starting again comes after the stop.
        let exempt = || {
            let mut any = false;
            words
                .aftermath
                .trace_hits(&texts.units, start..end, |tell, _, _| any |= tell == TellWord::Exempt);
            any
        };
        if let Some(m) = own.clone().find(|m| stops && m.force == Force::Asserted && resumes(m) == Some(true))
            && !because
            && !exempt()
        {
            return Some((m.start, m.end));
        }
        if clause.len() > LONGEST_CLAUSE {
            break;
        }
        // "It was standing at the stop, but its indicator is on now": before the keyframe.
        let until_now = || {
            let (_, until) =
                words.clauses.around(&texts.units, start..end, text.len(), &|d| d == Divider::Sentence);
            text.is_ascii() && until > end && words.aftermath.is_now(&text[end..until])
        };
        match told(clause, start, texts, words, own_decision, in_past) {
            Told::Event(_, _, false) if until_now() => {}
            Told::Event(from, to, sure) if !because && (sure || last.max(at_last) < end) => {
                return Some((start + from, start + to));
            }
            Told::Exempt => because |= words.clauses.reason.iter().any(|w| clause.contains(w.as_str())),
            _ => {}
        }
        start = end;
    }
    None
}

/// Words before the decision that state that the road user to which it responds is already out of the way, as bytes of
/// `text`: "she changed her mind and went back, so the ego yields". Not where another road user appears before the
/// decision.
pub(in crate::check::consistency) fn resolved(
    text: &str,
    texts: &Texts,
    reading: &Reading,
    words: &LabelWords,
    decides: &dyn Fn(&Mention) -> bool,
) -> Option<(usize, usize)> {
    if texts.trace.resolved.is_empty() {
        return None;
    }
    let stated = || reading.mentions.iter().find(|m| !m.by_other && m.force == Force::Asserted && decides(m));
    let decision = if reading.marked { reading.decision_from } else { stated()?.start };
    let is_over = |&(start, end): &(usize, usize)| {
        let (from, to) = words.clauses.around(&texts.units, start..end, text.len(), &|_| true);
        let mut exempt = false;
        words.aftermath.trace_hits(&texts.units, from..to, |tell, _, _| exempt |= tell == TellWord::Exempt);
        let another = |n: &Named| n.start >= end && n.start < decision && words.objects[n.group].named;
        end <= decision && !exempt && !texts.trace.there().any(another)
    };
    texts.trace.resolved.iter().copied().find(is_over)
}

/// Words for a time when the ego has already responded, or the road user to which it responds has finished, as bytes of
/// `text`: "after it had merged". Not where the clause states what the ego waits for.
pub(in crate::check::consistency) fn done(
    text: &str,
    texts: &Texts,
    words: &LabelWords,
) -> Option<(usize, usize)> {
    let end = text.len();
    let is_told = |&(start, to): &(usize, usize)| {
        // "Having reached the stop, the ego ...": before its decision.
        if text[..start].trim().is_empty() && text[start..].starts_with("Having") {
            return false;
        }
        // How the ego got where it is: "having come round the corner, ..." in Chinese.
        let head = text.find(['，', '。', '；', ',']).unwrap_or(0);
        if !text.is_ascii() && start < head {
            return false;
        }
        // "Not going over there we get nowhere".
        // "If he wants to come in, then ..." needs no condition in Chinese.
        if text[..start].chars().rev().take(2).any(|c| "不没别要想若真".contains(c)) {
            return false;
        }
        let (from, until) = words.clauses.around(&texts.units, start..to, end, &|_| true);
        let mut exempt = false;
        words.aftermath.trace_hits(&texts.units, from..until, |tell, a, b| {
            exempt |= tell == TellWord::Exempt && !(a >= start && b <= to);
        });
        // "It would be on top of us before we were up to speed", "if there is a car behind the crest, ...".
        let (sentence, _) = words.clauses.around(&texts.units, start..to, end, &|d| d == Divider::Sentence);
        if is_predicted(&text[sentence..start], words) {
            return false;
        }
        // "Moving over hinders nobody either".
        if text[to..].starts_with('不') {
            return false;
        }
        // "It hardly moved for a while, and now it does": before the keyframe.
        let now = words.aftermath.is_now(&text[to..]);
        !exempt && !now
    };
    texts.trace.done.iter().copied().find(is_told)
}

/// Content of a clause.
enum Told {
    Nothing,
    Exempt,
    /// Bytes of the clause; true: an outcome, also before a decision.
    Event(usize, usize, bool),
}

fn told(
    clause: &str,
    offset: usize,
    texts: &Texts,
    words: &LabelWords,
    own_decision: bool,
    in_past: bool,
) -> Told {
    let mut out = Told::Nothing;
    // A plan or a purpose, whatever else the clause tells: "past it, then back to our lane".
    let mut exempt = false;
    let mut ends = Vec::new();
    let somebody_acts = |start: usize, end: usize| {
        has_subject(clause, start, offset, &texts.trace, words) || is_new_subject(clause, start, end, words)
    };
    let is_sequel = |word: &str| words.aftermath.sequel.iter().any(|w| w == word);
    let others_act = |clause: &str| {
        let inside = |n: &Named| (offset..offset + clause.len()).contains(&n.start);
        let acts = |n: &Named| words.objects[n.group].own.meets(words.known.actor);
        clause.contains(['了', '才'])
            || texts.trace.there().any(|n| inside(n) && acts(n))
            || words.subjects.has_pronoun(clause)
    };
    words.aftermath.trace_hits(&texts.units, offset..offset + clause.len(), |tell, start, end| {
        let (start, end) = (start - offset, end - offset);
        ends.push((start, end));
        exempt |= tell == TellWord::Exempt;
        if !matches!(out, Told::Nothing) {
            return;
        }
        out = match tell {
            TellWord::Exempt => Told::Exempt,
            TellWord::Outcome => Told::Event(start, end, true),
            TellWord::Past if !(own_decision && in_past) => Told::Event(start, end, false),
            // The next action that the ego intends is its plan: "then goes back to its lane".
            TellWord::Event if !own_decision && (!is_sequel(&clause[start..end]) || others_act(clause)) => {
                Told::Event(start, end, false)
            }
            // "Let it through first, then left": where to.
            TellWord::PastOfSubject
                if clause[start..end].eq_ignore_ascii_case("left")
                    && !clause[end..].contains(char::is_alphanumeric) =>
            {
                Told::Nothing
            }
            TellWord::PastOfSubject if !(own_decision && in_past) && somebody_acts(start, end) => {
                Told::Event(start, end, false)
            }
            _ => Told::Nothing,
        };
    });
    if exempt && matches!(out, Told::Event(_, _, false)) {
        return Told::Exempt;
    }
    if !matches!(out, Told::Nothing) || (own_decision && in_past) || !clause.is_ascii() {
        return out;
    }
    // Regular verbs.
    let mut at = 0;
    for word in clause.split(|c: char| !c.is_ascii_alphabetic()) {
        let (start, end) = (at, at + word.len());
        at = end + 1;
        let past = word.len() >= 5 && word.ends_with("ed") && !word.ends_with("eed");
        // "Until we've sorted that out": a participle.
        let before = clause[..start].trim_end().to_ascii_lowercase();
        let perfect = ["'ve", "'s", "'d", "'re", "'m"].iter().any(|w| before.ends_with(w));
        if past && !perfect && !ends.contains(&(start, end)) && somebody_acts(start, end) {
            return Told::Event(start, end, false);
        }
    }
    out
}

/// The phrase is in the past tense.
fn is_past(phrase: &str, words: &LabelWords) -> bool {
    let first =
        phrase.split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default().to_ascii_lowercase();
    first.ends_with("ed") && !first.ends_with("eed") || words.aftermath.decided.contains(&first)
}

/// The word at `start` has a subject right before it: a pronoun, or a thing that the text names.
fn has_subject(clause: &str, start: usize, offset: usize, facts: &TextFacts, words: &LabelWords) -> bool {
    let before = clause[..start].trim_end();
    let end = offset + before.len();
    // The ego itself changes a measure: "speed adjusted".
    // A road does not act: "one lane left".
    let acts_not = words.known.gap.with(words.known.road).with(words.known.no_cause);
    let is_measure = |n: &Named| words.objects[n.group].own.meets(acts_not);
    if facts.named.iter().any(|n| n.end == end && !is_measure(n)) {
        return true;
    }
    let last = before.rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
    // "Never stopped", "soon left".
    if last.ends_with("ly") || words.aftermath.between.iter().any(|w| w == last) {
        return last.len() < before.len()
            && has_subject(clause, before.len() - last.len(), offset, facts, words);
    }
    words.aftermath.subjects.iter().any(|s| last.eq_ignore_ascii_case(s))
}

/// The text in the clause before the word `start..end` is a noun phrase, and the text after it makes the word a verb:
/// "and two potatoes rolled out of her basket".
fn is_new_subject(clause: &str, start: usize, end: usize, words: &LabelWords) -> bool {
    const LONGEST: usize = 7;
    let lists = &words.aftermath.new_subject;
    let has = |list: &[String], word: &str| list.iter().any(|w| w.eq_ignore_ascii_case(word));
    let of = |part| str::split(part, |c: char| !c.is_ascii_alphanumeric()).filter(|w: &&str| !w.is_empty());
    let before: Vec<&str> = of(&clause[..start]).skip_while(|w| has(&words.clauses.joint, w)).collect();
    let ([first, rest @ ..], Some(last)) = (before.as_slice(), before.last()) else { return false };
    let is_noun = !has(&lists.own, last) && !last.ends_with("ly");
    (2..=LONGEST).contains(&before.len())
        && has(&lists.begins, first)
        && !rest.iter().any(|w| has(&lists.breaks, w) || (w.len() > 5 && w.ends_with("ing")))
        && is_noun
        && of(&clause[end..]).next().is_none_or(|w| has(&lists.behind, w) || w.ends_with("ly"))
}
