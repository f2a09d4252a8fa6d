//! Rules of the class: the ids and what they prescribe (TAXONOMY.md, LABELING.md 4).

use super::{Finding, Sink, Words};
use crate::check::class_index::{ClassIndex, Found, Level, OTHER, Prescribed, own_id};
use crate::check::view::{ScenarioView, Slot, View};
use whyroad_model::messages::KeyframeType;

/// The ids and, where they are a class, `full_id` against them. `base` is the pointer of the object that holds them.
pub(in crate::check) fn scenario<'i>(
    s: &ScenarioView<'_>,
    classes: &'i ClassIndex,
    base: &'static str,
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
    // With an unreadable L3 nothing is known of the leaf.
    if matches!(s.l3, Slot::Broken) { None } else { Some(found) }
}

fn wrong(
    level: Level,
    l1: &str,
    l2: Option<&str>,
    l3: Option<&str>,
    classes: &ClassIndex,
    base: &'static str,
    sink: &mut dyn Sink,
) {
    let (id, key, parent) = match level {
        Level::L1 => (l1, "l1", String::new()),
        Level::L2 => (l2.unwrap_or_default(), "l2", l1.to_owned()),
        Level::L3 => (l3.unwrap_or_default(), "l3", format!("{l1}.{}", l2.unwrap_or_default())),
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
            format!("there is no {} class '{id}'", key.to_uppercase()),
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

fn full_id(s: &ScenarioView<'_>, base: &'static str, sink: &mut dyn Sink) {
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
    sink.report(Finding::error("label.scenario.full_id", format!("{base}/full_id")), &|| {
        let made = [Some(l1), Some(l2), l3].into_iter().flatten().collect::<Vec<_>>().join(".");
        Words::new(
            format!("full_id '{full}' 与 l1/l2/l3 拼成的 '{made}' 不一致"),
            format!("full_id '{full}' does not agree with l1, l2 and l3, which make '{made}'"),
        )
    });
}

/// What the class prescribes.
pub(super) fn prescribed(label: &View<'_>, class: &Prescribed, sink: &mut dyn Sink) {
    let s = &label.scenario;
    let name = || {
        let l3 = s.l3.get().filter(|l3| *l3 != OTHER);
        [s.l1.get(), s.l2.get(), l3].into_iter().flatten().collect::<Vec<_>>().join(".")
    };
    if let (Some(wanted), Some(kind)) = (class.kind, label.keyframe.kind.get())
        && kind != wanted
    {
        sink.report(Finding::error("label.keyframe.type", "/keyframe/type"), &|| {
            let (zh, en) = match wanted {
                KeyframeType::Reactive => ("单一时刻", "one moment"),
                KeyframeType::Proactive => ("一段区间", "a range"),
            };
            Words::new(
                format!("{} 的关键帧类型是 {wanted}（{zh}），此处写作 {kind}", name()),
                format!("the keyframe of {} is {wanted} ({en}), not {kind}", name()),
            )
            .hint(
                format!("改为 \"{wanted}\"，或检查场景类别"),
                format!("write \"{wanted}\", or check the scenario class"),
            )
        });
    }
    if class.uncertainty_high && label.components.get().is_some_and(|c| c.count > 0 && !c.any_high) {
        sink.report(Finding::error("label.uncertainty.missing", "/critical_components"), &|| {
            Words::new(
                format!("{} 要求至少一个关键要素标记 uncertainty = high", name()),
                format!("{} needs at least one critical component with uncertainty high", name()),
            )
            .hint(
                "在描述盲区、遮挡或意图不明的要素上写 \"uncertainty\": \"high\"",
                "write \"uncertainty\": \"high\" at the component that describes the blind spot, occlusion or unclear intention",
            )
        });
    }
    if let Some(wanted) = class.lateral {
        let given = match label.lateral {
            Slot::Is(l) => Some(Some(l)),
            Slot::Absent => Some(None),
            Slot::Broken => None,
        };
        if given.is_some_and(|g| g != Some(wanted)) {
            sink.report(Finding::error("label.lateral.mandated", "/driving_decision/lateral"), &|| {
                let found = given.flatten().map_or("null", |l| l.id());
                Words::new(
                    format!("{} 规定横向决策为 {wanted}，此处为 {found}", name()),
                    format!("{} prescribes the lateral decision {wanted}, found {found}", name()),
                )
                .hint(
                    format!("改为 \"{wanted}\"，或检查场景类别"),
                    format!("write \"{wanted}\", or check the scenario class"),
                )
            });
        }
    }
    let filled: &[&str] = match &label.records {
        Slot::Is(filled) => filled,
        Slot::Absent => &[],
        Slot::Broken => return,
    };
    for (id, title, unit) in class.records.iter().filter(|(id, ..)| !filled.contains(&id.as_str())) {
        sink.report(Finding::error("label.record.missing", format!("/records/{id}")), &|| {
            let unit =
                unit.as_ref().map(|u| (format!("（单位 {u}）"), format!(" in {u}"))).unwrap_or_default();
            Words::new(
                format!("{} 要求记录“{}”", name(), title.zh),
                format!("{} obliges you to record the {}", name(), title.en),
            )
            .hint(
                format!("在 records 中写 \"{id}\"{}；从片段中看不出时写“未知”", unit.0),
                format!("write \"{id}\"{} in records, \"unknown\" where the clip does not show it", unit.1),
            )
        });
    }
}
