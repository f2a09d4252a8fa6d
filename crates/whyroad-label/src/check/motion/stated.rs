//! Numbers and states that the trace gives the ego and the linked object, against the recording at the keyframe.

use super::object::place::{DISTANCE, DISTANCES_M, SPEED};
use crate::check::reading::{Named, TextFacts};
use crate::check::texts::Texts;
use crate::check::view::View;
use crate::driven::{Driven, kmh};
use whyroad_framework::LabelWords;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::label_words::{Divider, Quantity, SaidState};
use whyroad_model::TrackId;
use whyroad_model::label_fields::pointer;

/// An ego that is said to stand does not drive this fast, m/s.
const DRIVES_MPS: f64 = 3.0;
/// The ego, right before a number or a state.
const EGO_ZH: [&str; 4] = ["自车", "本车", "我车", "我们"];
const EGO_EN: [&str; 6] = ["the ego", "our car", "we are doing", "we're doing", "we are at", "we drive at"];
/// Other road users to whom a speed in the same clause may belong.
const ACTORS: [&str; 5] = ["前车", "它", "对方", "行人", "the lead"];
/// What else a number in the same clause may be about.
const OTHERS: [&str; 21] = [
    "限速",
    "目标",
    "降到",
    "减到",
    "加到",
    "升到",
    "低于",
    "超过",
    "以内",
    "以下",
    "路口",
    "停止线",
    "斑马线",
    "limit",
    "down to",
    "up to",
    "below",
    "above",
    "under",
    "junction",
    "stop line",
];
/// The ego stands.
const STANDS_ZH: [&str; 8] = ["停在", "停着", "静止", "已停", "已经停", "正停", "处于停车", "一直停"];
const STANDS_EN: [&str; 8] = [
    "the ego is stationary",
    "the ego is standing",
    "the ego stands",
    "we are stopped",
    "we're stopped",
    "we are standing still",
    "we're standing still",
    "we are stationary",
];
/// Words between the ego and its state.
const FILLERS: [&str; 6] = ["", "正", "还", "已", "已经", "仍"];
/// Before a thing that was named before.
const REFERENCES: [&str; 10] =
    ["那辆", "这辆", "该", "该辆", "那名", "这名", "那台", "that ", "this ", "the same "];
/// What begins the decision.
const DECISION: [&str; 9] = ["因此", "所以", "于是", "故而", "从而", ", so ", " so we", "therefore", "hence"];

pub(super) fn check(
    label: &View<'_>,
    texts: &Texts,
    words: &LabelWords,
    w: &Driven<'_>,
    sink: &mut dyn Sink,
) {
    let Some(trace) = label.trace.get() else { return };
    let lower = trace.to_ascii_lowercase();
    // What follows is the decision and what the ego will do.
    let end = DECISION.iter().filter_map(|d| lower.find(d)).min().unwrap_or(lower.len());
    let told = &lower[..end];
    if let Some((said, recorded)) = ego_speed(told, texts, words, w) {
        report(
            sink,
            format!("因果描述称自车车速为 {said:.0} km/h，关键帧时为 {recorded:.0} km/h"),
            format!("the trace gives the ego {said:.0} km/h, at the keyframe it drives {recorded:.0} km/h"),
        );
    } else if let Some(v) = w.speed(w.keyframe).filter(|v| *v > DRIVES_MPS && says_standing(told)) {
        let v = kmh(v);
        report(
            sink,
            format!("因果描述称自车停着，关键帧时车速为 {v:.0} km/h"),
            format!("the trace says that the ego stands, at the keyframe it drives {v:.0} km/h"),
        );
    }
    if let Some(v) = stands(label, texts, told, words, w) {
        report(
            sink,
            format!("因果描述称目标停着，关键帧时它的车速为 {v:.0} km/h"),
            format!("the trace says that the object stands, at the keyframe it drives {v:.0} km/h"),
        );
    }
    if let Some((said, recorded)) = distance(label, texts, told, words, w) {
        report(
            sink,
            format!("因果描述称目标在 {said:.0} m 处，关键帧时距自车 {recorded:.0} m"),
            format!(
                "the trace places the object at {said:.0} m, at the keyframe it is {recorded:.0} m from the ego"
            ),
        );
    }
}

/// The only linked object of the kind that the text says to stand, and its speed at the keyframe, km/h, where it
/// plainly drives. What the component says is compared with what was known then; whoever writes the trace has seen it
/// drive.
fn stands(label: &View<'_>, texts: &Texts, text: &str, words: &LabelWords, w: &Driven<'_>) -> Option<f64> {
    let standing = |n: &&Named| n.start < text.len() && n.state == Some(SaidState::Standing);
    let named: Vec<_> = texts.trace.there().filter(|n| super::object::is_tracked(words, n)).collect();
    let thing = named.iter().copied().find(standing)?;
    // Others of its kind: which of them stands is open.
    let own = words.objects[thing.group].own;
    let is_meant = |n: &Named| REFERENCES.iter().any(|r| text.get(..n.start).is_some_and(|t| t.ends_with(r)));
    if named.iter().any(|n| !standing(n) && !is_meant(n) && words.objects[n.group].near.meets(own)) {
        return None;
    }
    let speaks = |facts: &TextFacts| facts.there().any(|n| words.objects[n.group].near.meets(own));
    let mut of_kind = label.parts.iter().zip(&texts.components).filter(|(_, facts)| speaks(facts));
    let ((part, _), None) = (of_kind.next()?, of_kind.next()) else { return None };
    let [id] = part.objects.as_slice() else { return None };
    let row = w.signals.target(&TrackId::from(*id))?.row(w.keyframe)?;
    let v = w.signals.target_columns.get("target.speed")?.number(row)?;
    (v > DRIVES_MPS).then(|| kmh(v))
}

fn report(sink: &mut dyn Sink, zh: String, en: String) {
    sink.report(Finding::warning("label.motion.stated", pointer::COC_TRACE), &|| {
        Words::new(zh.clone(), en.clone())
            .hint("改正因果描述中的数值或状态", "correct the value or the state in the trace")
    });
}

/// The clause around a number, and where it begins.
fn clause<'t>(text: &'t str, said: &Quantity, texts: &Texts, words: &LabelWords) -> (usize, &'t str) {
    let divides = |d| matches!(d, Divider::Sentence | Divider::Clause);
    let (start, end) = words.clauses.around(&texts.units, said.start..said.end, text.len(), &divides);
    (start, &text[start..end])
}

/// The speed that the text gives the ego, and its speed at the keyframe, km/h, where they differ.
fn ego_speed(text: &str, texts: &Texts, words: &LabelWords, w: &Driven<'_>) -> Option<(f64, f64)> {
    let found = words.quantities.find(text, "km/h");
    let [said] = found.as_slice() else { return None };
    let (start, of) = clause(text, said, texts, words);
    let before = &text[start..said.start];
    let is_ego = EGO_ZH.iter().chain(&EGO_EN).any(|e| before.contains(e));
    if !is_ego || ACTORS.iter().chain(&OTHERS).any(|o| of.contains(o)) {
        return None;
    }
    let recorded = kmh(w.speed(w.keyframe)?);
    SPEED.is_exceeded(recorded, said.value).then_some((said.value, recorded))
}

/// The text says that the ego stands.
fn says_standing(text: &str) -> bool {
    let is_zh = EGO_ZH.iter().any(|ego| {
        text.match_indices(ego).any(|(at, _)| {
            let rest = &text[at + ego.len()..];
            FILLERS.iter().any(|f| {
                rest.strip_prefix(f).is_some_and(|rest| STANDS_ZH.iter().any(|s| rest.starts_with(s)))
            })
        })
    });
    is_zh || STANDS_EN.iter().any(|s| text.contains(s))
}

/// The distance that the text gives its only road user, and that of the only linked object, m, where they differ.
fn distance(
    label: &View<'_>,
    texts: &Texts,
    text: &str,
    words: &LabelWords,
    w: &Driven<'_>,
) -> Option<(f64, f64)> {
    let lengths = words.quantities.lengths(text);
    let [said] = lengths.as_slice() else { return None };
    let (start, of) = clause(text, said, texts, words);
    let named: Vec<_> =
        texts.trace.there().filter(|n| (start..start + of.len()).contains(&n.start)).collect();
    let [thing] = named.as_slice() else { return None };
    let linked: Vec<&str> = label.parts.iter().flat_map(|c| c.objects.iter().copied()).collect();
    let [id] = linked.as_slice() else { return None };
    // The thing is one of the component's kind.
    let is_linked = |facts: &TextFacts| {
        facts.there().any(|n| words.objects[n.group].near.meets(words.objects[thing.group].own))
    };
    if !super::object::is_tracked(words, thing)
        || !texts.components.iter().any(is_linked)
        || !DISTANCES_M.contains(&said.value)
        || OTHERS.iter().any(|o| of.contains(o))
    {
        return None;
    }
    let track = TrackId::from(*id);
    let row = w.signals.target(&track)?.row(w.keyframe)?;
    let recorded = w.signals.target_columns.get("target.distance")?.number(row)?;
    DISTANCE.is_exceeded(recorded, said.value).then_some((said.value, recorded))
}
