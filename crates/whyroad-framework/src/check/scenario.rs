//! The ids of a class: their form, whether they are a class of the taxonomy, and whether `full_id` agrees with them
//! (TAXONOMY.md, LABELING.md 4).

use super::class_index::{ClassIndex, Found, Level, own_id};
use super::finding::{Finding, Sink, Words};
use super::json::Node;
use super::slot::Slot;
use super::walk::Walk;
use whyroad_model::Severity;
use whyroad_model::label_fields::name;

/// The class of a sample, as far as it can be read.
#[derive(Clone, Copy, Debug, Default)]
pub struct ScenarioView<'a> {
    /// L1 id.
    pub l1: Slot<&'a str>,
    /// L2 id.
    pub l2: Slot<&'a str>,
    /// L3 id; absent is null.
    pub l3: Slot<&'a str>,
    /// `l1.l2.l3`.
    pub full_id: Slot<&'a str>,
}

impl ScenarioView<'_> {
    /// Of a document in which the class cannot be read at all.
    pub const BROKEN: Self =
        ScenarioView { l1: Slot::Broken, l2: Slot::Broken, l3: Slot::Broken, full_id: Slot::Broken };
}

/// The ids of a class; also those of a `scenario_label`.
pub fn read<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, pointer: &str) -> ScenarioView<'d> {
    let Some(mut o) = walk.object(node, pointer.to_owned()) else { return ScenarioView::BROKEN };
    let mut need = |walk: &mut Walk<'d>, key| {
        let at = o.at(key);
        walk.need(&mut o, key).map_or(Slot::Broken, |n| walk.text(Some(n), &at))
    };
    let (l1, l2) = (need(walk, name::L1), need(walk, name::L2));
    let mut optional = |walk: &mut Walk<'d>, key| {
        let (node, at) = (o.get(key), o.at(key));
        walk.text(node, &at)
    };
    let (l3, full_id) = (optional(walk, name::L3), optional(walk, name::FULL_ID));
    walk.close(o, Severity::Warning);
    ScenarioView { l1, l2, l3, full_id }
}

/// The ids and, where they are a class, `full_id` against them. `base` is the pointer of the object that holds them.
pub fn check<'i>(
    s: &ScenarioView<'_>,
    classes: &'i ClassIndex,
    base: &str,
    sink: &mut dyn Sink,
) -> Option<Found<'i>> {
    let l1 = s.l1.get()?;
    let (l2, l3) = match (s.l2, s.l3) {
        (Slot::Is(l2), Slot::Is(l3)) => (Some(l2), Some(l3)),
        (Slot::Is(l2), _) => (Some(l2), None),
        _ => (None, None),
    };
    let found = classes.find(l1, l2, l3);
    if let Found::Wrong { level } = found {
        wrong(level, l1, l2, l3, classes, base, sink);
        return Some(found);
    }
    full_id(s, base, sink);
    // With an unreadable L3 the leaf is unknown.
    if matches!(s.l3, Slot::Broken) { None } else { Some(found) }
}

fn wrong(
    level: Level,
    l1: &str,
    l2: Option<&str>,
    l3: Option<&str>,
    classes: &ClassIndex,
    base: &str,
    sink: &mut dyn Sink,
) {
    let (id, key, parent) = match level {
        Level::L1 => (l1, name::L1, String::new()),
        Level::L2 => (l2.unwrap_or_default(), name::L2, l1.to_owned()),
        Level::L3 => (l3.unwrap_or_default(), name::L3, format!("{l1}.{}", l2.unwrap_or_default())),
    };
    let pointer = format!("{base}/{key}");
    let elsewhere = classes.elsewhere(level, id);
    if !elsewhere.is_empty() {
        sink.report(Finding::error("label.scenario.wrong_parent", pointer), &|| {
            let places: Vec<String> = elsewhere.iter().take(3).map(ToString::to_string).collect();
            let (list_zh, list) = (places.join("、"), places.join(", "));
            let words = Words::new(
                format!("'{parent}' 下没有 '{id}'；它属于 {list_zh}"),
                format!("'{id}' is not under '{parent}' but under {list}"),
            );
            let choices = classes.choices(level, Some(l1), l2);
            match (elsewhere.len(), level) {
                (1, Level::L2) => {
                    let right = &elsewhere[0].l1;
                    words.hint(format!("l1 是否应为 '{right}'？"), format!("should l1 be '{right}'?"))
                }
                _ => choices_hint(words, &parent, &choices),
            }
        });
        return;
    }
    sink.report(Finding::error("label.scenario.unknown", pointer), &|| {
        let words = Words::new(
            format!("没有名为 '{id}' 的 {} 类别", key.to_uppercase()),
            format!("{} class '{id}' not found", key.to_uppercase()),
        );
        let (l1, l2) = match level {
            Level::L1 => (None, None),
            Level::L2 => (Some(l1), None),
            Level::L3 => (Some(l1), l2),
        };
        match classes.meant(level, id, l1, l2) {
            Some(s) => {
                let (own, full) = (own_id(s), s.to_string());
                if full == own {
                    words.meant(own)
                } else {
                    words.hint(
                        format!("是否想写 '{own}'（{full}）？"),
                        format!("did you mean '{own}' ({full})?"),
                    )
                }
            }
            None => choices_hint(words, &parent, &classes.choices(level, l1, l2)),
        }
    });
}

fn choices_hint(words: Words, parent: &str, choices: &[&str]) -> Words {
    if choices.is_empty() {
        return words;
    }
    let (zh, en) = (choices.join("、"), choices.join(", "));
    if parent.is_empty() {
        words.one_of(&zh, &en)
    } else {
        words.hint(format!("'{parent}' 下可选：{zh}"), format!("under '{parent}' there are: {en}"))
    }
}

fn full_id(s: &ScenarioView<'_>, base: &str, sink: &mut dyn Sink) {
    let (Some(full), Some(l1), Some(l2)) = (s.full_id.get(), s.l1.get(), s.l2.get()) else { return };
    let l3 = match s.l3 {
        Slot::Is(l3) => Some(l3),
        Slot::Absent => None,
        Slot::Broken => return,
    };
    let mut rest = full;
    let mut agrees = true;
    for (i, part) in [Some(l1), Some(l2), l3].into_iter().flatten().enumerate() {
        if i > 0 {
            match rest.strip_prefix('.') {
                Some(r) => rest = r,
                None => agrees = false,
            }
        }
        match rest.strip_prefix(part) {
            Some(r) => rest = r,
            None => agrees = false,
        }
    }
    if agrees && rest.is_empty() {
        return;
    }
    sink.report(Finding::error("label.scenario.full_id", format!("{base}/{}", name::FULL_ID)), &|| {
        let made = [Some(l1), Some(l2), l3].into_iter().flatten().collect::<Vec<_>>().join(".");
        Words::new(
            format!("full_id '{full}' 与 l1/l2/l3 拼成的 '{made}' 不一致"),
            format!("full_id '{full}' does not agree with l1, l2 and l3, which make '{made}'"),
        )
    });
}
