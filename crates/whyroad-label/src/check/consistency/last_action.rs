//! What the last sentence of a trace says the ego does, by its verb and side rather than by a phrase: a movement where
//! the channel has no decision, and a movement to the other side. Used only where no phrase of the trace has said
//! anything about it.

use crate::check::consistency::trace::TraceVerdict;
use crate::check::texts::TextScope;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::label_words::Forms;
use whyroad_framework::phrases::Phrases;
use whyroad_model::decision::{LateralDirection, Longitudinal};
use whyroad_model::label_fields::pointer;

/// Clauses at the end of the last sentence that state the decision.
const DECIDING: usize = 2;
/// Maximum bytes between a verb of movement and its side.
const NEAR: usize = 36;

/// First byte and text of the last sentence.
pub(in crate::check) fn last_sentence(text: &str) -> (usize, &str) {
    let end = text.trim_end().trim_end_matches(['.', '。', '!', '！', '；', ';']).len();
    let body = &text[..end];
    let from = body
        .char_indices()
        .filter(|(at, c)| {
            "。；！？".contains(*c) || ".!?;".contains(*c) && body[at + 1..].starts_with(char::is_whitespace)
        })
        .map(|(at, c)| at + c.len_utf8())
        .next_back()
        .unwrap_or(0);
    (from, &body[from..])
}

/// First byte and text of each clause of a part.
pub(in crate::check) fn clauses(part: &str) -> Vec<(usize, &str)> {
    let mut out = Vec::new();
    let mut from = 0;
    for (at, c) in part.char_indices().filter(|(_, c)| "，,".contains(*c)) {
        out.push((from, &part[from..at]));
        from = at + c.len_utf8();
    }
    out.push((from, &part[from..]));
    out.retain(|(_, c)| c.contains(char::is_alphanumeric));
    out
}

/// The label has no lateral decision, and the last sentence says that the ego leaves its lane. Returns true when it
/// does.
pub(super) fn without_decision(scope: &TextScope<'_>, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, .. } = *scope;
    let Some(text) = label.trace.get() else { return false };
    if label.lateral != Slot::Absent || label.longitudinal == Slot::Broken || texts.trace.unchanged.is_some()
    {
        return false;
    }
    let lower = text.to_ascii_lowercase();
    let forms = &words.forms;
    let (from, sentence) = last_sentence(&lower);
    let all = clauses(sentence);
    let last = all.iter().rev().take(DECIDING).rev();
    let found = last.filter_map(|(at, clause)| {
        let (a, b) = moves(clause, forms)?;
        Some((from + at + a, from + at + b))
    });
    let Some((start, end)) = found.min() else { return false };
    report(text, (start, end), LATERAL, sink);
    true
}

/// Names of the channel of a decision.
pub(super) const LATERAL: [&str; 2] = ["横向", "lateral"];
pub(super) const LONGITUDINAL: [&str; 2] = ["纵向", "longitudinal"];

/// Reports bytes of the trace that say what the ego does, where the label has no decision of that channel.
pub(super) fn report(text: &str, (start, end): (usize, usize), [zh, en]: [&str; 2], sink: &mut dyn Sink) {
    sink.report(Finding::warning("label.trace.unlabelled", pointer::COC_TRACE).part(start, end), &|| {
        let phrase = &text[start..end];
        Words::new(
            format!("因果描述说自车“{phrase}”，{zh}决策却是“无决策变化”"),
            format!("the trace says '{phrase}' about the ego, but the {en} decision is 'no change'"),
        )
        .hint("确有新决策时补上，否则改写因果描述", "add the decision if there was one, or rewrite the trace")
    });
}

/// Bytes of a movement of the ego out of its lane in a clause that is about the ego.
fn moves(clause: &str, forms: &Forms) -> Option<(usize, usize)> {
    let (at, end) = forms.sideways.find(clause)?;
    let before = &clause[..at];
    let begins = match clause.is_ascii() {
        true => forms.begins.find(before).is_some(),
        // The movement itself may begin the clause: "往左并到...".
        false => forms.begins.iter().any(|w| !w.is_ascii() && clause.trim_start().starts_with(w.as_str())),
    };
    let behind =
        (end + NEAR / 3..=clause.len()).find(|i| clause.is_char_boundary(*i)).unwrap_or(clause.len());
    let named = forms.not_others.iter().fold(before.to_owned(), |text, w| text.replace(w.as_str(), ""));
    let other = forms.others.find(&named).is_some();
    let denied = forms.denied.find(&clause[..behind]).is_some();
    let room = forms.room.find(&clause[end..]).is_some();
    (begins && !other && !denied && !room).then_some((at, end))
}

/// All movements of the deciding clauses go to the side that the label's decision does not have.
pub(super) fn other_side(scope: &TextScope<'_>) -> Option<TraceVerdict> {
    let TextScope { label, words, .. } = *scope;
    let (text, direction) = (label.trace.get()?, label.direction.get()?);
    label.lateral.get()?;
    let (own, other, says) = match direction {
        LateralDirection::Left => (["左", "left"], ["右", "right"], LateralDirection::Right),
        LateralDirection::Right => (["右", "right"], ["左", "left"], LateralDirection::Left),
        LateralDirection::Uturn => return None,
    };
    let lower = text.to_ascii_lowercase();
    let (from, sentence) = last_sentence(&lower);
    let deciding = if text.is_ascii() { usize::MAX } else { DECIDING };
    let all = clauses(sentence);
    let mut found = None;
    for (at, clause) in all.iter().rev().take(deciding).rev() {
        let sides = sides(clause, &words.forms);
        if sides.iter().any(|(_, _, side)| own.contains(side)) {
            return None;
        }
        let first = sides.iter().find(|(_, _, side)| other.contains(side));
        found = found.or(first.map(|(a, b, _)| (from + at + a, from + at + b)));
    }
    let (start, end) = found?;
    Some(TraceVerdict::OtherSide { label: direction, says, start, end })
}

/// Movements to a side in a clause: bytes, and the name of the side.
fn sides<'c>(clause: &'c str, forms: &Forms) -> Vec<(usize, usize, &'c str)> {
    let mut out = Vec::new();
    let names: &[&str] = if clause.is_ascii() { &["left", "right"] } else { &["左", "右"] };
    for (at, side) in names.iter().flat_map(|name| clause.match_indices(name)) {
        let (before, behind) = (&clause[..at], &clause[at + side.len()..]);
        if clause.is_ascii() {
            let whole = before.ends_with(' ') && !behind.starts_with(|c: char| c.is_ascii_alphanumeric());
            let of_hand =
                behind.starts_with("-hand") || behind.starts_with(" hand") || behind.starts_with(" of");
            let near = (at.saturating_sub(NEAR)..=at).find(|i| clause.is_char_boundary(*i)).unwrap_or(at);
            if let Some((verb, _)) = forms.towards.find(&clause[near..at]).filter(|_| whole && !of_hand) {
                out.push((near + verb, at + side.len(), side));
            }
        } else if !behind.starts_with(['来', '后'])
            && let Some(w) = forms.towards.iter().find(|w| !w.is_ascii() && before.ends_with(w.as_str()))
        {
            out.push((at - w.len(), at + side.len(), side));
        }
    }
    out
}

/// Bytes of a clause at the end that states that the ego keeps its speed, where it has to slow, stop or give way.
pub(super) fn keeps_speed(text: &str, along: Option<Longitudinal>, forms: &Forms) -> Option<(usize, usize)> {
    let slows = matches!(
        along,
        Some(
            Longitudinal::RoadSpeedAdaptation
                | Longitudinal::YieldToAgent
                | Longitudinal::StopForRegulation
                | Longitudinal::StopForObstacle
        )
    );
    let lower = text.to_ascii_lowercase();
    if !slows {
        return None;
    }
    let (from, sentence) = last_sentence(&lower);
    let keeps = |clause: &str| {
        let any = |list: &Phrases| list.find(clause).is_some();
        any(&forms.pace) && (any(&forms.same) || any(&forms.kept)) && !any(&forms.changed)
    };
    let all = clauses(sentence);
    let found = all.iter().rev().take(DECIDING).find(|(_, clause)| keeps(clause));
    found.map(|(at, clause)| {
        let begin = from + at + (clause.len() - clause.trim_start().len());
        (begin, from + at + clause.len())
    })
}

/// The last sentence of an English trace describes something: it has a finite verb for how something is among its first
/// words, and no word for the ego or what it drives with.
pub(super) fn describes_at_last(text: &str, forms: &Forms) -> bool {
    const FIRST: usize = 8;
    const LEAST: usize = 5;
    if !text.is_ascii() {
        return false;
    }
    let lower = text.to_ascii_lowercase();
    let (_, sentence) = last_sentence(&lower);
    let all: Vec<&str> =
        sentence.split(|c: char| !c.is_ascii_alphanumeric() && c != '\'').filter(|w| !w.is_empty()).collect();
    let is_one = |list: &[String], w: &&str| list.iter().any(|l| l == w);
    all.len() >= LEAST
        && all.iter().take(FIRST).any(|w| is_one(&forms.is, w))
        && !all.iter().enumerate().any(|(i, w)| {
            // "We have the permission to go": what the ego has or is, rather than what it does.
            let has =
                ["we", "i", "ego"].contains(w) && ["have", "has"].contains(all.get(i + 1).unwrap_or(&""));
            !has && is_one(&forms.controls, w)
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_framework::Framework;

    #[test]
    fn the_last_sentence_is_cut_into_clauses() {
        let (from, sentence) = last_sentence("前面封了。再往里开就扎进去，我松油，并到左边。");
        assert_eq!(clauses(sentence).len(), 3);
        assert_eq!(from, "前面封了。".len());
        assert_eq!(last_sentence("At 0.5 m it stops. So we wait.").1.trim(), "So we wait");
    }

    #[test]
    fn a_movement_is_of_the_ego_only_where_nobody_else_moves() {
        let forms = &Framework::bundled().label_words().forms;
        for clause in ["打左灯并到左边车道", "我往右换到那条道上", "so we change lanes"] {
            assert!(moves(clause, forms).is_some(), "{clause}");
        }
        for clause in ["让面包车并进来", "两侧无绕行空间", "等它换到右边", "so we let it change lanes"]
        {
            assert!(moves(clause, forms).is_none(), "{clause}");
        }
    }

    #[test]
    fn a_description_is_no_decision() {
        let forms = &Framework::bundled().label_words().forms;
        assert!(describes_at_last("The gap is going. There is very little room left for it.", forms));
        assert!(!describes_at_last("There is a queue. The vehicle brakes and is held there.", forms));
    }
}
