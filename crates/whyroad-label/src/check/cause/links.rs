//! Causal rules (LABELING.md 6): each decision has a cause that could be observed, or states why not. They apply only
//! to fields that a document of format 2.1 may have; format 2.0 has none of them.

use crate::check::view::{CauseView, View};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use whyroad_framework::DecisionSets;
use whyroad_framework::check::class_index::{ClassIndex, Found, Prescribed};
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::taxonomy::did_you_mean;
use whyroad_model::Nanos;
use whyroad_model::label_fields::{name, pointer};

/// Component ids are unique.
pub(in crate::check) fn ids(label: &View<'_>, sink: &mut dyn Sink) {
    // Most labels have a few components, all with different ids.
    let few = label.parts.len() <= 8;
    let repeats = |i: usize| {
        let id = label.parts[i].id.get();
        id.is_some() && label.parts[..i].iter().any(|c| c.id.get() == id)
    };
    if few && !(1..label.parts.len()).any(repeats) {
        return;
    }
    let mut seen: HashMap<&str, usize> = HashMap::new();
    for c in &label.parts {
        let Some(id) = c.id.get() else { continue };
        let first = match seen.entry(id) {
            Entry::Occupied(first) => *first.get(),
            Entry::Vacant(free) => {
                free.insert(c.index);
                continue;
            }
        };
        sink.report(
            Finding::error("label.component.duplicate_id", pointer::critical_components_item_id(c.index)),
            &|| {
                Words::new(
                    format!("关键要素 {} 与 {} 的 id 都是 '{id}'", first, c.index),
                    format!("components {} and {} both have the id '{id}'", first, c.index),
                )
                .hint("为每个要素取不同的 id", "give each component a different id")
            },
        );
    }
}

/// Something that became visible only after the keyframe caused nothing. If there are two keyframes, the later one
/// counts.
pub(in crate::check) fn evidence(label: &View<'_>, sink: &mut dyn Sink) {
    let second = label.second.get().and_then(|k| k.timestamp.get());
    let Some(keyframe) = label.keyframe.timestamp.get().max(second) else { return };
    for c in &label.parts {
        let late = c.evidence.iter().enumerate().filter_map(|(k, t)| Some((k, t.get()?)));
        for (k, time) in late.filter(|(_, t)| *t > keyframe) {
            let at = pointer::critical_components_item_evidence_times_item(c.index, k);
            sink.report(Finding::error("label.evidence.after_keyframe", at), &|| {
                Words::new(
                    format!("证据时间 {time} 晚于关键帧 {keyframe}：关键帧之后才看到的不能是原因"),
                    format!("evidence at {time} is after the keyframe {keyframe}: what is seen later cannot be a cause"),
                )
                .hint(
                    "写关键帧当时或之前可见的时刻；之前看不到的要素应删去",
                    "give a time at or before the keyframe; remove a component that could not be seen by then",
                )
            });
        }
    }
}

/// Location of the cause of a channel's decision.
struct CauseChannel {
    name: &'static str,
    at: &'static str,
    unobserved: &'static str,
    component: fn(usize) -> String,
}

const LONGITUDINAL: CauseChannel = CauseChannel {
    name: name::LONGITUDINAL,
    at: pointer::CAUSES_LONGITUDINAL,
    unobserved: pointer::CAUSES_LONGITUDINAL_UNOBSERVED,
    component: pointer::causes_longitudinal_components_item,
};
const LATERAL: CauseChannel = CauseChannel {
    name: name::LATERAL,
    at: pointer::CAUSES_LATERAL,
    unobserved: pointer::CAUSES_LATERAL_UNOBSERVED,
    component: pointer::causes_lateral_components_item,
};

/// Each decision refers to a component, or is UNOBSERVED with a reason.
pub(in crate::check) fn causes(label: &View<'_>, names: &DecisionSets, sink: &mut dyn Sink) {
    let Slot::Is(causes) = &label.causes else { return };
    let known: Vec<&str> = label.parts.iter().filter_map(|c| c.id.get()).collect();
    let longitudinal = label.longitudinal.get().map(|d| d.id());
    let lateral = label.lateral.get().map(|d| d.id());
    let channels = [
        (&LONGITUDINAL, longitudinal, label.longitudinal.is_absent(), &causes.longitudinal),
        (&LATERAL, lateral, label.lateral.is_absent(), &causes.lateral),
    ];
    for (channel, decision, is_null, cause) in channels {
        match (decision, cause) {
            (Some(decision), Slot::Absent) => missing(channel, decision, names, sink),
            (Some(decision), Slot::Is(c)) if c.components.is_empty() && c.unobserved.is_absent() => {
                missing(channel, decision, names, sink);
            }
            (None, Slot::Is(_)) if is_null => without_decision(channel, sink),
            _ => {}
        }
        // If there are no components at all, that has already been reported.
        if let Slot::Is(cause) = cause
            && label.components.get().is_some_and(|c| c.count > 0)
        {
            components(channel, cause, &known, sink);
        }
    }
}

fn missing(channel: &CauseChannel, decision: &'static str, names: &DecisionSets, sink: &mut dyn Sink) {
    sink.report(Finding::error("label.cause.missing", channel.at), &|| {
        let name = names.name(decision);
        Words::new(format!("决策“{}”没有原因", name.zh), format!("the decision '{}' has no cause", name.en)).hint(
            "选出引起它的关键要素；看不到原因时选“未观测到”并写明理由",
            "choose the components that cause it; if none could be observed, choose unobserved and state the reason",
        )
    });
}

fn without_decision(channel: &CauseChannel, sink: &mut dyn Sink) {
    let (zh, en) =
        if channel.name == name::LONGITUDINAL { ("纵向", "longitudinal") } else { ("横向", "lateral") };
    sink.report(Finding::warning("label.cause.without_decision", channel.at), &|| {
        Words::new(
            format!("{zh}决策为“无决策变化”，却写了原因"),
            format!("the {en} decision is 'no change', but a cause is given"),
        )
        .hint("删去该原因，或补上决策", "remove the cause, or add the decision")
    });
}

fn components(channel: &CauseChannel, cause: &CauseView<'_>, known: &[&str], sink: &mut dyn Sink) {
    if let (Some(_), false) = (cause.unobserved.get(), cause.components.is_empty()) {
        sink.report(Finding::error("label.cause.both", channel.unobserved), &|| {
            Words::new(
                "既选了要素又写了“未观测到”：两者只能取一",
                "a cause is either components or unobserved, not both",
            )
        });
    }
    for (i, id) in cause.components.iter().enumerate().filter_map(|(i, s)| Some((i, s.get()?))) {
        if known.contains(&id) {
            continue;
        }
        let at = (channel.component)(i);
        sink.report(Finding::error("label.cause.unknown_component", at), &|| {
            let words = Words::new(
                format!("没有 id 为 '{id}' 的关键要素"),
                format!("no critical component has the id '{id}'"),
            );
            match did_you_mean(id, known.iter().copied()) {
                Some(near) => words.meant(near),
                None if known.is_empty() => words.hint(
                    "在要素上写 \"id\"，再在此处引用",
                    "give the component an \"id\" and refer to it here",
                ),
                None => words
                    .hint(format!("已有：{}", known.join("、")), format!("there are: {}", known.join(", "))),
            }
        });
    }
}

/// The second keyframe: present where the class has two, not before the first, in the time range.
pub(in crate::check) fn second_keyframe(label: &View<'_>, class: Option<&Prescribed>, sink: &mut dyn Sink) {
    let second = match &label.second {
        Slot::Is(k) => k,
        Slot::Broken => return,
        Slot::Absent => {
            // A document of format 2.0 has no field for it.
            let can_say = label.version.get().is_some_and(|v| !v.starts_with("2.0."));
            if can_say && class.is_some_and(|c| c.two_keyframes) {
                sink.report(
                    Finding::warning("label.second_keyframe.missing", pointer::SECOND_KEYFRAME),
                    &|| {
                        Words::new(
                            "该类别有两个关键帧，此处只有一个",
                            "this class has two keyframes, but the label has one",
                        )
                        .hint("补上第二个关键帧的时刻", "give the moment of the second keyframe")
                    },
                );
            }
            return;
        }
    };
    let Some(time) = second.timestamp.get() else { return };
    let at = pointer::SECOND_KEYFRAME_TIMESTAMP;
    if let Some(first) = label.keyframe.timestamp.get().filter(|first| time < *first) {
        sink.report(Finding::error("label.second_keyframe.order", at), &|| {
            Words::new(
                format!("第二关键帧 {time} 早于关键帧 {first}"),
                format!("the second keyframe {time} is before the keyframe {first}"),
            )
        });
    }
    let inside =
        |a: Option<Nanos>, b: Option<Nanos>| a.is_none_or(|a| a <= time) && b.is_none_or(|b| time <= b);
    if !inside(label.start.get(), label.end.get()) {
        sink.report(Finding::error("label.keyframe.outside_time_range", at), &|| {
            Words::new(
                format!("第二关键帧 {time} 不在时间范围内"),
                format!("the second keyframe {time} is not in the time range"),
            )
        });
    }
}

/// Secondary triggers are valid classes, and differ from the primary one.
pub(in crate::check) fn secondary(label: &View<'_>, classes: &ClassIndex, sink: &mut dyn Sink) {
    if label.secondary.is_empty() {
        return;
    }
    let s = &label.scenario;
    let primary = [s.l1.get(), s.l2.get(), s.l3.get()].into_iter().flatten().collect::<Vec<_>>().join(".");
    for (i, id) in label.secondary.iter().enumerate().filter_map(|(i, s)| Some((i, s.get()?))) {
        let at = pointer::secondary_scenarios_item(i);
        let mut parts = id.split('.');
        let (l1, l2, l3) = (parts.next().unwrap_or_default(), parts.next(), parts.next());
        if parts.next().is_some() || l2.is_none() || matches!(classes.find(l1, l2, l3), Found::Wrong { .. }) {
            sink.report(Finding::error("label.secondary.unknown", at), &|| {
                Words::new(
                    format!("'{id}' 不是分类体系中的类别"),
                    format!("'{id}' is not a class of the taxonomy"),
                )
                .hint("写完整 id：l1.l2.l3", "write the full id: l1.l2.l3")
            });
        } else if id == primary {
            sink.report(Finding::warning("label.secondary.primary", at), &|| {
                Words::new(
                    format!("'{id}' 已是主类别，不必再列为次要"),
                    format!("'{id}' is the primary class already"),
                )
            });
        }
    }
}
