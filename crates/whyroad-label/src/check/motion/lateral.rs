//! The lateral decision against the ego's path after the keyframe.

use crate::check::view::View;
use crate::driven::Driven;
use crate::driven::across::{self, Conflict};
use whyroad_framework::DecisionSets;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_model::Bilingual;
use whyroad_model::decision::LateralDirection;
use whyroad_model::label_fields::pointer;

pub(super) fn check(label: &View<'_>, w: &Driven<'_>, names: &DecisionSets, sink: &mut dyn Sink) {
    let Slot::Is(decision) = label.lateral else { return };
    let direction = label.direction.get();
    let objects: Vec<&str> = label.parts.iter().flat_map(|c| c.objects.iter().copied()).collect();
    let Some(conflict) = across::conflict(w, decision, direction, &objects) else { return };
    if let Conflict::ThingThere { lateral_m } = conflict {
        let left = direction == Some(LateralDirection::Left);
        let finding = Finding::error("label.motion.side", pointer::DRIVING_DECISION_LATERAL_DIRECTION);
        sink.report(finding, &|| {
            let (side, there, m) = (side_words(left), side_words(lateral_m > 0.0), lateral_m.abs());
            Words::new(
                format!("障碍物在行驶路径{}侧 {m:.1} m，自车不会向{}避让", there.zh, side.zh),
                format!(
                    "the obstacle is {m:.1} m to the {} of the path; the ego would not nudge to the {}",
                    there.en, side.en
                ),
            )
        });
        return;
    }
    let name = names
        .lateral(decision)
        .map_or_else(|| Bilingual::new(decision.id(), decision.id()), |t| t.name.clone());
    let shown = in_words(w, direction, conflict);
    sink.report(Finding::error("label.motion.contradicts", pointer::DRIVING_DECISION_LATERAL), &|| {
        Words::new(
            format!("标注为“{}”，但记录显示：{}", name.zh, shown.zh),
            format!("the label is '{}', but the recording shows: {}", name.en.to_lowercase(), shown.en),
        )
        .hint(
            "对照行驶轨迹检查决策、方向和关键帧",
            "check decision, direction and keyframe against the path driven",
        )
    });
}

fn side_words(left: bool) -> Bilingual {
    if left { Bilingual::new("左", "left") } else { Bilingual::new("右", "right") }
}

/// The recorded motion as text. Chinese and English.
fn in_words(w: &Driven<'_>, direction: Option<LateralDirection>, conflict: Conflict) -> Bilingual {
    let last = w.seconds(w.range_end - 1);
    match conflict {
        Conflict::ChangesLane { frame, left } => {
            let (t, side) = (w.seconds(frame), side_words(left));
            Bilingual::new(
                format!("关键帧后 {t:.1} s 自车向{}换道", side.zh),
                format!("the ego changes lanes to the {} {t:.1} s after the keyframe", side.en),
            )
        }
        Conflict::NoLaneChange => Bilingual::new(
            format!("关键帧后 {last:.0} s 内自车没有换道"),
            format!("the ego does not change lanes within {last:.0} s of the keyframe"),
        ),
        Conflict::TurnsOther { degrees } => {
            let side = side_words(degrees > 0.0);
            Bilingual::new(
                format!("自车航向向{}转了 {:.0}°", side.zh, degrees.abs()),
                format!("the ego's heading turns {:.0} degrees to the {}", degrees.abs(), side.en),
            )
        }
        Conflict::NoTurn { degrees } => Bilingual::new(
            format!("{last:.0} s 内自车航向只变化 {:.0}°，没有转弯", degrees.abs()),
            format!(
                "the ego's heading changes by {:.0} degrees in {last:.0} s: it does not turn",
                degrees.abs()
            ),
        ),
        Conflict::NoReverse => Bilingual::new("自车没有后退", "the ego does not reverse"),
        Conflict::MovesOther { away_m } => {
            let side = side_words(direction != Some(LateralDirection::Left));
            Bilingual::new(
                format!("自车在车道内向{}移动了 {away_m:.1} m", side.zh),
                format!("the ego moves {away_m:.1} m to the {} within its lane", side.en),
            )
        }
        Conflict::ThingThere { .. } => Bilingual::default(),
    }
}
