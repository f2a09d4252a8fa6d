//! Requirements of the class (TAXONOMY.md, LABELING.md 4).

use crate::check::view::View;
use whyroad_framework::DecisionSets;
use whyroad_framework::check::class_index::Prescribed;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_model::label_fields::pointer;
use whyroad_model::messages::KeyframeType;

/// Requirements of the class.
pub(in crate::check) fn prescribed(
    label: &View<'_>,
    class: &Prescribed,
    names: &DecisionSets,
    sink: &mut dyn Sink,
) {
    let name = &class.title;
    if let (Some(wanted), Some(kind)) = (class.kind, label.keyframe.kind.get())
        && kind != wanted
    {
        sink.report(Finding::error("label.keyframe.type", pointer::KEYFRAME_TYPE), &|| {
            let words = |kind: KeyframeType| match kind {
                KeyframeType::Reactive => ("单一时刻（reactive）", "one moment (reactive)"),
                KeyframeType::Proactive => ("一段区间（proactive）", "a range (proactive)"),
            };
            let (wanted, kind) = (words(wanted), words(kind));
            Words::new(
                format!("“{}”的关键帧是{}，此处为{}", name.zh, wanted.0, kind.0),
                format!("the keyframe of '{}' is {}, not {}", name.en, wanted.1, kind.1),
            )
            .hint(
                format!("改为{}，或检查场景类别", wanted.0),
                format!("make it {}, or check the scenario class", wanted.1),
            )
        });
    }
    if class.uncertainty_high && label.components.get().is_some_and(|c| c.count > 0 && !c.any_high) {
        sink.report(Finding::error("label.uncertainty.missing", pointer::CRITICAL_COMPONENTS), &|| {
            Words::new(
                format!("“{}”要求至少一个关键要素的不确定性为“高”", name.zh),
                format!("'{}' needs at least one critical component of high uncertainty", name.en),
            )
            .hint(
                "把描述盲区、遮挡或意图不明的要素的不确定性设为“高”",
                "set the uncertainty of the component that describes the blind spot, occlusion or unclear intention to high",
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
            sink.report(Finding::error("label.lateral.mandated", pointer::DRIVING_DECISION_LATERAL), &|| {
                let wanted = names.name(wanted.id());
                let found = match given.flatten() {
                    Some(l) => names.name(l.id()),
                    None => names.null_decision.name.clone(),
                };
                Words::new(
                    format!("“{}”规定横向决策为“{}”，此处为“{}”", name.zh, wanted.zh, found.zh),
                    format!(
                        "'{}' prescribes the lateral decision '{}', found '{}'",
                        name.en, wanted.en, found.en
                    ),
                )
                .hint(
                    format!("改为“{}”，或检查场景类别", wanted.zh),
                    format!("choose '{}', or check the scenario class", wanted.en),
                )
            });
        }
    }
}
