//! Rules of the class: what it prescribes (TAXONOMY.md, LABELING.md 4).

use crate::check::view::View;
use whyroad_framework::check::class_index::{OTHER, Prescribed};
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_model::label_fields::pointer;
use whyroad_model::messages::KeyframeType;

/// What the class prescribes.
pub(in crate::check) fn prescribed(label: &View<'_>, class: &Prescribed, sink: &mut dyn Sink) {
    let s = &label.scenario;
    let name = || {
        let l3 = s.l3.get().filter(|l3| *l3 != OTHER);
        [s.l1.get(), s.l2.get(), l3].into_iter().flatten().collect::<Vec<_>>().join(".")
    };
    if let (Some(wanted), Some(kind)) = (class.kind, label.keyframe.kind.get())
        && kind != wanted
    {
        sink.report(Finding::error("label.keyframe.type", pointer::KEYFRAME_TYPE), &|| {
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
        sink.report(Finding::error("label.uncertainty.missing", pointer::CRITICAL_COMPONENTS), &|| {
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
            sink.report(Finding::error("label.lateral.mandated", pointer::DRIVING_DECISION_LATERAL), &|| {
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
}
