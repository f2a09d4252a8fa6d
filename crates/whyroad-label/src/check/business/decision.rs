//! Rules of the decision and its causes (LABELING.md 2 and 3).

use crate::check::consistency::trace_rules::direction_name;
use crate::check::view::View;
use whyroad_framework::DecisionSets;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_model::Bilingual;
use whyroad_model::label_fields::pointer;

/// The direction is present if the decision needs one, absent if not, and one that the decision can have.
pub(in crate::check) fn direction(label: &View<'_>, names: &DecisionSets, sink: &mut dyn Sink) {
    const AT: &str = pointer::DRIVING_DECISION_LATERAL_DIRECTION;
    let allowed = match label.lateral {
        Slot::Is(l) => l.directions(),
        Slot::Absent => &[],
        Slot::Broken => return,
    };
    let named = || match label.lateral.get() {
        Some(l) => names.name(l.id()),
        None => names.null_decision.name.clone(),
    };
    let list = |pick: fn(&Bilingual) -> &String, or: &str| {
        let all: Vec<Bilingual> = allowed.iter().map(|d| direction_name(*d)).collect();
        all.iter().map(|b| pick(b).as_str()).collect::<Vec<_>>().join(or)
    };
    let choose = |words: Words| {
        words.hint(
            format!("可选：{}", list(|b| &b.zh, "、")),
            format!("choose one of: {}", list(|b| &b.en, ", ")),
        )
    };
    match label.direction {
        Slot::Absent if !allowed.is_empty() => {
            sink.report(Finding::error("label.direction.missing", AT), &|| {
                let name = named();
                choose(Words::new(
                    format!("横向决策“{}”必须有方向", name.zh),
                    format!("the lateral decision '{}' needs a direction", name.en),
                ))
            })
        }
        Slot::Is(d) if allowed.is_empty() => {
            sink.report(Finding::error("label.direction.unexpected", AT), &|| {
                let (name, d) = (named(), direction_name(d));
                Words::new(
                    format!("横向决策“{}”没有方向，此处却写了“{}”", name.zh, d.zh),
                    format!("the lateral decision '{}' has no direction, but '{}' is given", name.en, d.en),
                )
                .hint("删去方向，或检查横向决策", "remove the direction, or check the lateral decision")
            })
        }
        Slot::Is(d) if !allowed.contains(&d) => {
            sink.report(Finding::error("label.direction.invalid", AT), &|| {
                let (name, d) = (named(), direction_name(d));
                choose(Words::new(
                    format!("横向决策“{}”的方向不能是“{}”", name.zh, d.zh),
                    format!("the lateral decision '{}' cannot have the direction '{}'", name.en, d.en),
                ))
            })
        }
        _ => {}
    }
}

/// The decision has at least one component.
pub(in crate::check) fn components(label: &View<'_>, sink: &mut dyn Sink) {
    if label.components.get().is_some_and(|c| c.count == 0) {
        sink.report(Finding::error("label.components.empty", pointer::CRITICAL_COMPONENTS), &|| {
            Words::new("没有写任何关键要素", "the label has no critical component")
                .hint("至少写一个影响决策的关键要素", "add at least one component that affects the decision")
        });
    }
}
