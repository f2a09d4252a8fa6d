//! Rules of the decision and its causes (LABELING.md 2 and 3).

use crate::check::view::View;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_model::label_fields::pointer;

/// A direction where one belongs, none where none does, and one that the decision can have.
pub(in crate::check) fn direction(label: &View<'_>, sink: &mut dyn Sink) {
    const AT: &str = pointer::DRIVING_DECISION_LATERAL_DIRECTION;
    let allowed = match label.lateral {
        Slot::Is(l) => l.directions(),
        Slot::Absent => &[],
        Slot::Broken => return,
    };
    let named = || label.lateral.get().map_or("null", |l| l.id());
    let list = |or: &str| allowed.iter().map(|d| d.id()).collect::<Vec<_>>().join(or);
    match label.direction {
        Slot::Absent if !allowed.is_empty() => {
            sink.report(Finding::error("label.direction.missing", AT), &|| {
                Words::new(
                    format!("横向决策 {} 必须有 lateral_direction", named()),
                    format!("the lateral decision {} needs a lateral_direction", named()),
                )
                .hint(format!("写 {} 之一", list("、")), format!("write one of {}", list(", ")))
            })
        }
        Slot::Is(d) if allowed.is_empty() => {
            sink.report(Finding::error("label.direction.unexpected", AT), &|| {
                Words::new(
                    format!("横向决策 {} 没有方向，此处却写了 {d}", named()),
                    format!("the lateral decision {} has no direction, but {d} is given", named()),
                )
                .hint(
                    "删去 lateral_direction，或检查横向决策",
                    "leave lateral_direction out, or check the lateral decision",
                )
            })
        }
        Slot::Is(d) if !allowed.contains(&d) => {
            sink.report(Finding::error("label.direction.invalid", AT), &|| {
                Words::new(
                    format!("横向决策 {} 的方向不能是 {d}", named()),
                    format!("the lateral decision {} cannot go {d}", named()),
                )
                .hint(format!("写 {} 之一", list("、")), format!("write one of {}", list(", ")))
            })
        }
        _ => {}
    }
}

/// Something caused the decision.
pub(in crate::check) fn components(label: &View<'_>, sink: &mut dyn Sink) {
    if label.components.get().is_some_and(|c| c.count == 0) {
        sink.report(Finding::error("label.components.empty", pointer::CRITICAL_COMPONENTS), &|| {
            Words::new("critical_components 为空", "critical_components is empty")
                .hint("至少写一个影响决策的关键要素", "name at least one thing that bears on the decision")
        });
    }
}
