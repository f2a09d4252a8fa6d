//! Records against the texts: a number that differs in the texts, a vehicle that no component names, "none" where a
//! component has it. What the texts do not state is not judged.

use crate::check::reading::{self, Named, TextFacts};
use crate::check::texts::TextScope;
use crate::check::view::View;
use whyroad_framework::LabelWords;
use whyroad_framework::check::class_index::Prescribed;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::label_words::GroupSet;
use whyroad_framework::lexicon::units::Units;
use whyroad_framework::record_types::RecordValue;
use whyroad_model::label_fields::pointer;

/// Numbers that differ by less than this share are the same.
const SAME: f64 = 0.15;

/// The values of the records agree with the texts.
pub(in crate::check) fn against_texts(
    scope: &TextScope<'_>,
    class: Option<&Prescribed>,
    sink: &mut dyn Sink,
) {
    let TextScope { label, words, .. } = *scope;
    let Slot::Is(records) = &label.records else { return };
    if words.is_empty() {
        return;
    }
    for (id, value) in records {
        let spec = class.and_then(|c| c.records.iter().find(|(k, ..)| k == id));
        let Some((_, title, unit)) = spec else { continue };
        let said = match *value {
            RecordValue::Number(n) => {
                let other = unit.as_ref().and_then(|u| other_number(label, id, n, u, words));
                other.or_else(|| falls_uphill(label, id, n))
            }
            RecordValue::Flag(there) => there.then(|| denied_light(scope)).flatten(),
            RecordValue::Text(text) => other_ordinal(label, text, words)
                .or_else(|| other_place(label, text, words))
                .or_else(|| other_thing(scope, text)),
            RecordValue::Nested => None,
        };
        let Some(said) = said else { continue };
        sink.report(Finding::warning("label.record.value", pointer::records_of(id)), &|| {
            Words::new(
                format!("“{}”与文字不符：文字说“{said}”", title.zh),
                format!("the {} does not agree with the texts: '{said}'", title.en),
            )
            .hint("改正其中有误的一处", "correct the one that is wrong")
        });
    }
}

/// A slope upwards with a negative grade: the name of the class.
fn falls_uphill(label: &View<'_>, id: &str, value: f64) -> Option<String> {
    let up = label.scenario.l3.get() == Some("slope_up");
    (up && id == "grade" && value < 0.0).then(|| "slope_up".to_owned())
}

/// Texts of the components and the trace.
fn all_texts<'a>(label: &View<'a>) -> impl Iterator<Item = &'a str> {
    let parts: Vec<&'a str> = label.parts.iter().filter_map(|c| c.description.get()).collect();
    parts.into_iter().chain(label.trace.get())
}

/// The number in the texts where they state the record's quantity, and none of them has the record's value.
fn other_number(label: &View<'_>, id: &str, value: f64, unit: &str, words: &LabelWords) -> Option<String> {
    let beside = words.quantities.beside.get(id)?;
    let value = value.abs();
    let within = |share: f64, a: f64, b: f64| (a - b).abs() <= share * a.abs().max(b.abs()).max(1e-9);
    let same = |a: f64, b: f64| within(SAME, a, b);
    let all: Vec<(&str, f64, usize)> = all_texts(label)
        .flat_map(|t| words.quantities.find(t, unit).into_iter().map(move |q| (t, q.value, q.start)))
        .collect();
    // "Little more than two seconds": people round.
    let rounds = |t: &str, at: usize| {
        const ROUGH: [&str; 12] = [
            "about ",
            "around ",
            "roughly ",
            "some ",
            "more than ",
            "less than ",
            "nearly ",
            "约",
            "大概",
            "不到",
            "差不多",
            "来",
        ];
        let from = t[..at].char_indices().rev().nth(12).map_or(0, |(i, _)| i);
        let before = t[from..at].to_ascii_lowercase();
        ROUGH.iter().any(|w| before.contains(w))
    };
    if all.iter().any(|(t, n, at)| rounds(t, *at) && within(2.0 * SAME, *n, value)) {
        return None;
    }
    // A difference may be stated by its two operands.
    let differs_by = |(_, a, _): &(&str, f64, usize)| all.iter().any(|(_, b, _)| same((a - b).abs(), value));
    if all.iter().any(|q| same(q.1, value) || differs_by(q)) {
        return None;
    }
    let clause = |text: &str, at: usize| {
        let mark = |c: char| "，。；！？,;!?.".contains(c);
        let from =
            text[..at].rfind(mark).map_or(0, |i| i + text[i..].chars().next().map_or(1, char::len_utf8));
        let to = text[at..].find(mark).map_or(text.len(), |i| at + i);
        text[from..to].trim().to_owned()
    };
    let states = |text: &str, at: usize| {
        let part = clause(text, at).to_ascii_lowercase();
        beside.is_empty() || beside.iter().any(|w| part.contains(w.as_str()))
    };
    // "At 20 m": the location of something.
    let is_place = |text: &str, at: usize| text[..at].ends_with(" at ");
    all.iter().find(|(t, _, at)| states(t, *at) && !is_place(t, *at)).map(|(t, _, at)| clause(t, *at))
}

/// A light that the texts say is absent.
fn denied_light(scope: &TextScope<'_>) -> Option<String> {
    let TextScope { label, texts, words, .. } = *scope;
    let light = |n: &&Named| words.objects[n.group].own.meets(words.known.light);
    let all = || texts.components.iter().chain([&texts.trace]);
    let absent = |f: &TextFacts| f.named.iter().filter(|n| light(n)).any(|n| n.absent);
    if !all().any(absent) || all().any(|f| f.there().any(|n| light(&n))) {
        return None;
    }
    let at = texts.components.iter().position(absent);
    at.and_then(|i| label.parts.get(i)?.description.get()).or(label.trace.get()).map(str::to_owned)
}

/// The exit, if its number in the texts differs.
fn other_ordinal(label: &View<'_>, record: &str, words: &LabelWords) -> Option<String> {
    let ordinal = |text: &str| words.ordinal_of_exit(text);
    let own = words.ordinal(record)?;
    // "I have passed the first exit, it is the second": every clause.
    let clauses = all_texts(label).flat_map(|t| t.split(['，', '。', '；', ',', '.', ';']));
    let said: Vec<(usize, &str)> = clauses.filter_map(|t| Some((ordinal(t)?, t))).collect();
    let (_, text) = said.first()?;
    (!said.iter().any(|(n, _)| *n == own)).then(|| (*text).to_owned())
}

/// Ahead of or behind the ego, if the texts have the opposite.
fn other_place(label: &View<'_>, record: &str, words: &LabelWords) -> Option<String> {
    let is = |text: &str, i: usize| {
        let lower = text.to_ascii_lowercase();
        words.subjects.at[i].iter().any(|w| lower.contains(w.as_str()))
    };
    let record = record.trim();
    let own = ["ahead", "behind"].iter().position(|w| *w == record);
    let own = own.or_else(|| ["前方", "后方"].iter().position(|w| *w == record))?;
    let other = 1 - own;
    let mut all = all_texts(label);
    if all_texts(label).any(|t| is(t, own)) {
        return None;
    }
    all.find(|t| is(t, other)).map(str::to_owned)
}

/// A road user or thing that the record names and no text does; or that is on the other side; or "none", where a
/// component states what hides the view or is oncoming.
fn other_thing(scope: &TextScope<'_>, record: &str) -> Option<String> {
    let TextScope { label, texts, words, .. } = *scope;
    let facts = reading::read(record, &Units::of(record), words);
    let own = |n: &Named| words.objects[n.group].own;
    let all = || texts.components.iter().chain([&texts.trace]);
    let lower = record.to_ascii_lowercase();
    if words.subjects.nothing.iter().any(|w| lower.starts_with(w.as_str())) {
        let speaks =
            |f: &&TextFacts| f.there().any(|n| own(n).meets(words.known.sight)) && f.clear.is_empty();
        let hidden = texts.components.iter().position(|f| speaks(&f));
        let opposite =
            |t: &str| words.subjects.opposite.iter().any(|w| t.to_ascii_lowercase().contains(w.as_str()));
        let comes = || {
            let mut parts = label.parts.iter().zip(&texts.components);
            parts.position(|(c, f)| {
                f.there().any(|n| own(n).meets(words.known.actor))
                    && c.description.get().is_some_and(opposite)
            })
        };
        // "None" alone, or about traffic; if it is about the light or the view, another thing is meant.
        let at = hidden.or_else(comes)?;
        return label.parts.get(at)?.description.get().map(str::to_owned);
    }
    let near = all()
        .flat_map(|f| &f.named)
        .fold(GroupSet::default(), |set, n| set.with(words.objects[n.group].near));
    let says_where = words.known.no_cause.with(words.known.road).with(words.known.sight);
    // The light of a place is seldom said where the class says it: "tunnel".
    let lighting = words.kinds.get("lighting").copied().unwrap_or_default();
    let says_where = says_where.with(lighting);
    let things = || facts.there().filter(|n| !own(n).without(says_where).is_empty());
    let unread = label
        .parts
        .iter()
        .zip(&texts.components)
        .any(|(c, f)| c.description.get().is_none_or(|t| crate::check::subject::is_unread(t, f, words)));
    let quote = || label.parts.first().and_then(|c| c.description.get()).map(str::to_owned);
    if !unread && things().next().is_some() && !things().any(|n| own(n).meets(near)) {
        return quote();
    }
    let other_side = |n: &&Named| {
        n.side.is_some_and(|side| {
            let same =
                || all().flat_map(TextFacts::there).filter(|m| own(m).meets(words.objects[n.group].near));
            same().any(|m| m.side == Some(!side)) && !same().any(|m| m.side == Some(side))
        })
    };
    things().find(other_side).and_then(|_| quote())
}
