//! Checks decisions against the class and against each other, with the table `scenarios/decisions.yaml`.

use crate::check::motion::Shown;
use crate::check::view::View;
use whyroad_framework::check::class_index::Prescribed;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::decision_table::{ClassDecisions, Fit};
use whyroad_framework::{DecisionSets, DecisionTable};
use whyroad_model::Bilingual;
use whyroad_model::decision::{Lateral, Longitudinal};
use whyroad_model::label_fields::pointer;

const CODE: &str = "label.decision.impossible";
/// Where the recorded motion shows the decision.
const CLASS_CODE: &str = "label.class.motion";

/// Reports at most one impossible part: the channel that contradicts the class, then the pair. Returns true when there
/// is one.
pub(in crate::check) fn decisions(
    label: &View<'_>,
    prescribed: &Prescribed,
    class: &ClassDecisions,
    table: &DecisionTable,
    names: &DecisionSets,
    shown: &dyn Fn() -> Shown,
    sink: &mut dyn Sink,
) -> bool {
    let (Some(along), Some(across)) = (given(label.longitudinal), given(label.lateral)) else { return false };
    let along_name = |d: Option<Longitudinal>| match d.and_then(|d| names.longitudinal(d)) {
        Some(text) => text.name.clone(),
        None => Bilingual::new("无决策变化", "no change of decision"),
    };
    let across_name = |d: Option<Lateral>| match d.and_then(|d| names.lateral(d)) {
        Some(text) => text.name.clone(),
        None => Bilingual::new("无决策变化", "no change of decision"),
    };
    let impossible = |sink: &mut dyn Sink, at: &'static str, found: &Bilingual, usual: Vec<Bilingual>| {
        let shown = match at {
            pointer::DRIVING_DECISION_LONGITUDINAL => shown().longitudinal,
            pointer::DRIVING_DECISION_LATERAL | pointer::DRIVING_DECISION_LATERAL_DIRECTION => {
                shown().lateral
            }
            _ => false,
        };
        if shown {
            sink.report(Finding::warning(CLASS_CODE, pointer::SCENARIO), &|| {
                let class = &prescribed.title;
                Words::new(
                    format!("“{}”没有决策“{}”，但记录中自车确实这样行驶：场景类别可能不对", class.zh, found.zh),
                    format!(
                        "the class '{}' has no decision '{}', but the recording shows it: the class may be wrong",
                        class.en, found.en
                    ),
                )
                .hint(
                    "决策可以这样写；告诉负责人应为哪个场景类别",
                    "the decision may stay; tell the lead which class it should be",
                )
            });
            return true;
        }
        sink.report(Finding::error(CODE, at), &|| {
            let class = &prescribed.title;
            let list = |pick: fn(&Bilingual) -> &String, or: &str| {
                usual.iter().map(|b| pick(b).as_str()).collect::<Vec<_>>().join(or)
            };
            Words::new(
                format!("“{}”不允许决策“{}”", class.zh, found.zh),
                format!("the class '{}' does not allow the decision '{}'", class.en, found.en),
            )
            .hint(
                format!("通常为：{}；否则检查场景类别", list(|b| &b.zh, "、")),
                format!("usual: {}; otherwise check the scenario class", list(|b| &b.en, ", ")),
            )
        });
        true
    };
    let usual_along =
        || class.longitudinal.iter().filter(|(_, f)| *f == Fit::Usual).map(|(d, _)| along_name(*d)).collect();
    let usual_across = || {
        class.lateral.iter().filter(|(_, f)| *f == Fit::Usual).map(|(e, _)| across_name(e.lateral)).collect()
    };
    if class.longitudinal_fit(along) == Fit::Impossible {
        return impossible(sink, pointer::DRIVING_DECISION_LONGITUDINAL, &along_name(along), usual_along());
    }
    // There is a separate rule for a prescribed lateral decision.
    if prescribed.lateral.is_none() && class.lateral_fit(across) == Fit::Impossible {
        return impossible(sink, pointer::DRIVING_DECISION_LATERAL, &across_name(across), usual_across());
    }
    if let (Some(across), Some(direction)) = (across, label.direction.get())
        && across.directions().contains(&direction)
        && class.direction_fit(across, Some(direction)) == Fit::Impossible
    {
        return impossible(
            sink,
            pointer::DRIVING_DECISION_LATERAL_DIRECTION,
            &Bilingual::new(
                format!("{}（{direction}）", across_name(Some(across)).zh),
                format!("{} {direction}", across_name(Some(across)).en),
            ),
            usual_across(),
        );
    }
    if class.decides && along.is_none() && across.is_none() {
        return impossible(sink, pointer::DRIVING_DECISION, &along_name(None), usual_along());
    }
    if let (Some(along), Some(across)) = (along, across)
        && table.impossible_pairs.contains(&(along, across))
    {
        sink.report(Finding::error(CODE, pointer::DRIVING_DECISION), &|| {
            let (a, b) = (along_name(Some(along)), across_name(Some(across)));
            Words::new(
                format!("“{}”与“{}”不能同时成立", a.zh, b.zh),
                format!("'{}' and '{}' cannot be combined", a.en, b.en),
            )
            .hint(
                "只填关键帧之后的第一个动作，另一个方向上选“无决策变化”",
                "state the first action after the keyframe; choose 'no change' for the other",
            )
        });
        return true;
    }
    false
}

/// A channel's decision, which may be null; `None` where it could not be read.
fn given<T>(slot: Slot<T>) -> Option<Option<T>> {
    match slot {
        Slot::Is(d) => Some(Some(d)),
        Slot::Absent => Some(None),
        Slot::Broken => None,
    }
}
