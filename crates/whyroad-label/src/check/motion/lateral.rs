//! The lateral decision against the ego's path after the keyframe.

use super::window::Window;
use crate::check::view::View;
use whyroad_framework::DecisionSets;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_model::Bilingual;
use whyroad_model::TrackId;
use whyroad_model::decision::{Lateral, LateralDirection};
use whyroad_model::label_fields::pointer;

/// Sideways movement that is no noise, m.
const OFFSET_M: f64 = 0.35;

pub(super) fn check(label: &View<'_>, w: &Window<'_>, names: &DecisionSets, sink: &mut dyn Sink) {
    let Slot::Is(decision) = label.lateral else { return };
    if !w.lasts(3.0) {
        return;
    }
    let name = names
        .lateral(decision)
        .map_or_else(|| Bilingual::new(decision.id(), decision.id()), |t| t.name.clone());
    let at = pointer::DRIVING_DECISION_LATERAL;
    let report = |sink: &mut dyn Sink, zh: String, en: String| {
        sink.report(Finding::error("label.motion.contradicts", at), &|| {
            Words::new(
                format!("标注为“{}”，但记录显示：{zh}", name.zh),
                format!("the label says '{}', but the recording shows: {en}", name.en.to_lowercase()),
            )
            .hint(
                "对照行驶轨迹检查决策、方向和关键帧",
                "check decision, direction and keyframe against the path driven",
            )
        });
    };
    let direction = label.direction.get();
    match decision {
        Lateral::LaneChange => lane_change(w, direction, sink, &report),
        Lateral::Turn => turn(w, direction, sink, &report),
        Lateral::LaneKeeping => {
            let soon = w.keyframe..(w.keyframe + 31).min(w.end);
            let changed =
                soon.clone().find(|&f| matches!(w.category("ego.lane_change", f), Some("left" | "right")));
            if let Some(f) = changed {
                let (t, side) = (w.seconds(f), side_words(w.category("ego.lane_change", f) == Some("left")));
                report(
                    sink,
                    format!("关键帧后 {t:.1} s 自车向{}换道", side.zh),
                    format!("the ego changes lane to the {} {t:.1} s after the keyframe", side.en),
                );
            }
        }
        Lateral::InLaneNudge | Lateral::OutOfLaneNudge => {
            if let Some(direction) = direction {
                nudge(label, w, direction, sink, &report);
            }
        }
        Lateral::Reverse => {
            let backs =
                (w.keyframe..w.range_end).filter_map(|f| w.number("ego.forward_speed", f)).any(|v| v < -0.2);
            if !backs && w.number("ego.forward_speed", w.keyframe).is_some() && w.lasts(6.0) {
                report(sink, "自车没有后退".to_owned(), "the ego does not drive backwards".to_owned());
            }
        }
        Lateral::ManeuverAbort | Lateral::MergeOrSplit | Lateral::PullOver => {}
    }
}

type Report<'r> = dyn Fn(&mut dyn Sink, String, String) + 'r;

fn side_words(left: bool) -> Bilingual {
    if left { Bilingual::new("左", "left") } else { Bilingual::new("右", "right") }
}

fn lane_change(
    w: &Window<'_>,
    direction: Option<LateralDirection>,
    sink: &mut dyn Sink,
    report: &Report<'_>,
) {
    let from = w.keyframe.saturating_sub(10);
    let found = (from..w.range_end).find_map(|f| {
        w.category("ego.lane_change", f).filter(|c| matches!(*c, "left" | "right")).map(|c| (f, c == "left"))
    });
    match (found, direction) {
        (Some((f, left)), Some(direction)) if (direction == LateralDirection::Left) != left => {
            let (t, side) = (w.seconds(f), side_words(left));
            report(
                sink,
                format!("关键帧后 {t:.1} s 自车向{}换道", side.zh),
                format!("the ego changes lane to the {} {t:.1} s after the keyframe", side.en),
            );
        }
        (None, _) => {
            let known = (from..w.range_end).filter(|&f| w.category("ego.lane_change", f).is_some()).count();
            if known * 10 >= (w.range_end - from) * 9 && w.lasts(6.0) {
                report(
                    sink,
                    format!("关键帧后 {:.0} s 内自车没有换道", w.seconds(w.range_end - 1)),
                    format!(
                        "the ego does not change lane within {:.0} s of the keyframe",
                        w.seconds(w.range_end - 1)
                    ),
                );
            }
        }
        _ => {}
    }
}

fn turn(w: &Window<'_>, direction: Option<LateralDirection>, sink: &mut dyn Sink, report: &Report<'_>) {
    let changes = w.heading_changes(w.range_end);
    let Some(extreme) = changes.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())) else { return };
    let degrees = extreme.to_degrees();
    let against = match direction {
        Some(LateralDirection::Left) => degrees < -25.0,
        Some(LateralDirection::Right) => degrees > 25.0,
        _ => false,
    };
    if against {
        let side = side_words(degrees > 0.0);
        report(
            sink,
            format!("自车航向向{}转了 {:.0}°", side.zh, degrees.abs()),
            format!("the ego's heading turns {:.0} degrees to the {}", degrees.abs(), side.en),
        );
        return;
    }
    // Who waits first may turn after the window.
    let moves = w.speeds(w.keyframe..w.range_end).is_some_and(|s| s.min > 2.0);
    if degrees.abs() < 12.0 && moves && w.lasts(6.0) {
        report(
            sink,
            format!("{:.0} s 内自车航向只变化 {:.0}°，没有转弯", w.seconds(w.range_end - 1), degrees.abs()),
            format!(
                "the ego's heading changes by {:.0} degrees in {:.0} s: it does not turn",
                degrees.abs(),
                w.seconds(w.range_end - 1)
            ),
        );
    }
}

/// Moves to the labeled side, and away from what it is labeled to avoid.
fn nudge(
    label: &View<'_>,
    w: &Window<'_>,
    direction: LateralDirection,
    sink: &mut dyn Sink,
    report: &Report<'_>,
) {
    let left = direction == LateralDirection::Left;
    let offset = |f: usize| w.number("ego.lane_offset", f);
    if let Some(start) = offset(w.keyframe) {
        let moved: Vec<f64> = (w.keyframe..w.end).filter_map(|f| Some(offset(f)? - start)).collect();
        // A jump is another lane's center line.
        let jumps = moved.windows(2).any(|p| (p[1] - p[0]).abs() > 1.0);
        let (min, max) = moved.iter().fold((0.0_f64, 0.0_f64), |(a, b), m| (a.min(*m), b.max(*m)));
        let (to, away) = if left { (max, -min) } else { (-min, max) };
        if !jumps && away > OFFSET_M && to < 0.15 {
            let side = side_words(!left);
            report(
                sink,
                format!("自车在车道内向{}移动了 {away:.1} m", side.zh),
                format!("the ego moves {away:.1} m to the {} within its lane", side.en),
            );
            return;
        }
    }
    // The thing that is avoided, where one is linked, stands on the other side.
    let objects: Vec<&str> = label.parts.iter().flat_map(|c| c.objects.iter().copied()).collect();
    let [id] = objects[..] else { return };
    let signals = &w.recorded.signals;
    let row = signals.target(&TrackId::from(id)).and_then(|t| t.row(w.keyframe));
    let Some(lateral) = row.and_then(|r| signals.target_columns.get("target.path_lateral")?.number(r)) else {
        return;
    };
    if (left && lateral > 1.0) || (!left && lateral < -1.0) {
        sink.report(
            Finding::error("label.motion.side", pointer::DRIVING_DECISION_LATERAL_DIRECTION),
            &|| {
                let (side, there) = (side_words(left), side_words(lateral > 0.0));
                Words::new(
                    format!(
                        "障碍物在行驶路径{}侧 {:.1} m，自车不会向{}避让",
                        there.zh,
                        lateral.abs(),
                        side.zh
                    ),
                    format!(
                        "the obstacle is {:.1} m to the {} of the path; the ego would not nudge to the {}",
                        lateral.abs(),
                        there.en,
                        side.en
                    ),
                )
            },
        );
    }
}
