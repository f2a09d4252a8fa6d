//! The ego's lateral motion after a keyframe, and which lateral decisions it supports (LABELING.md 2).

use super::Driven;
use whyroad_model::TrackId;
use whyroad_model::decision::{Lateral, LateralDirection};

/// Minimum sideways movement that is not noise, m.
const OFFSET_M: f64 = 0.35;
/// Minimum change of heading of a turn, degrees.
const TURN_DEG: f64 = 25.0;

/// How a decision contradicts the recorded motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Conflict {
    /// The ego changes lanes to that side.
    ChangesLane { frame: usize, left: bool },
    /// It does not change lanes.
    NoLaneChange,
    /// Its heading turns to the other side, degrees; left is positive.
    TurnsOther { degrees: f64 },
    /// Its heading hardly changes, degrees.
    NoTurn { degrees: f64 },
    /// It does not reverse.
    NoReverse,
    /// It moves to the other side within its lane, m.
    MovesOther { away_m: f64 },
    /// The linked object is on the side to which it would move, m from the path.
    ThingThere { lateral_m: f64 },
}

/// The contradiction between `decision` and the recorded motion; `objects` are those that the components link. A drive
/// that ends within 3 s is not judged.
pub(crate) fn conflict(
    w: &Driven<'_>,
    decision: Lateral,
    direction: Option<LateralDirection>,
    objects: &[&str],
) -> Option<Conflict> {
    if !w.lasts(3.0) {
        return None;
    }
    match decision {
        Lateral::LaneChange => lane_change(w, direction),
        // The way round a roundabout bends to both sides.
        Lateral::Turn if (w.keyframe..w.end).any(|f| w.flag("map.in_roundabout", f).is_true()) => None,
        Lateral::Turn => turn(w, direction),
        Lateral::LaneKeeping => {
            let (frame, left) = first_lane_change(w, w.keyframe..(w.keyframe + 31).min(w.end))?;
            Some(Conflict::ChangesLane { frame, left })
        }
        Lateral::InLaneNudge | Lateral::OutOfLaneNudge => nudge(w, direction?, objects),
        Lateral::Reverse => {
            let backs =
                (w.keyframe..w.range_end).filter_map(|f| w.number("ego.forward_speed", f)).any(|v| v < -0.2);
            let known = w.number("ego.forward_speed", w.keyframe).is_some() && w.lasts(6.0);
            (!backs && known).then_some(Conflict::NoReverse)
        }
        Lateral::ManeuverAbort | Lateral::MergeOrSplit | Lateral::PullOver => None,
    }
}

/// The first frame in which the ego changes lanes, and whether to the left.
pub(crate) fn first_lane_change(w: &Driven<'_>, mut frames: std::ops::Range<usize>) -> Option<(usize, bool)> {
    frames.find_map(|f| {
        w.category("ego.lane_change", f).filter(|c| matches!(*c, "left" | "right")).map(|c| (f, c == "left"))
    })
}

/// The ego plainly does what `decision` says, to that side: it changes lanes, or turns by at least 25 degrees.
pub(crate) fn shows(w: &Driven<'_>, decision: Lateral, direction: Option<LateralDirection>) -> bool {
    let left = match direction {
        Some(LateralDirection::Left) => true,
        Some(LateralDirection::Right) => false,
        _ => return false,
    };
    match decision {
        Lateral::LaneChange => {
            first_lane_change(w, w.keyframe..w.range_end).is_some_and(|(_, to_left)| to_left == left)
        }
        Lateral::Turn => {
            let changes = w.heading_changes(w.range_end);
            let most = changes.iter().map(|c| if left { *c } else { -c }).fold(0.0, f64::max);
            most.to_degrees() >= TURN_DEG
        }
        _ => false,
    }
}

fn lane_change(w: &Driven<'_>, direction: Option<LateralDirection>) -> Option<Conflict> {
    let from = w.keyframe.saturating_sub(10);
    match (first_lane_change(w, from..w.range_end), direction) {
        (Some((frame, left)), Some(direction)) => {
            ((direction == LateralDirection::Left) != left).then_some(Conflict::ChangesLane { frame, left })
        }
        (Some(_), None) => None,
        (None, _) => {
            let known = (from..w.range_end).filter(|&f| w.category("ego.lane_change", f).is_some()).count();
            let all = known * 10 >= (w.range_end - from) * 9 && w.lasts(6.0);
            all.then_some(Conflict::NoLaneChange)
        }
    }
}

fn turn(w: &Driven<'_>, direction: Option<LateralDirection>) -> Option<Conflict> {
    let changes = w.heading_changes(w.range_end);
    let extreme = changes.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    let degrees = extreme.to_degrees();
    let against = match direction {
        Some(LateralDirection::Left) => degrees < -TURN_DEG,
        Some(LateralDirection::Right) => degrees > TURN_DEG,
        _ => false,
    };
    if against {
        return Some(Conflict::TurnsOther { degrees });
    }
    // An ego that waits first may turn after the window.
    let moves = w.speeds(w.keyframe..w.range_end).is_some_and(|s| s.min > 2.0);
    (degrees.abs() < 12.0 && moves && w.lasts(6.0)).then_some(Conflict::NoTurn { degrees })
}

/// Checks for movement to the decided side, and away from the object that is avoided.
fn nudge(w: &Driven<'_>, direction: LateralDirection, objects: &[&str]) -> Option<Conflict> {
    let left = direction == LateralDirection::Left;
    let offset = |f: usize| w.number("ego.lane_offset", f);
    if let Some(start) = offset(w.keyframe) {
        let moved: Vec<f64> = (w.keyframe..w.end).filter_map(|f| Some(offset(f)? - start)).collect();
        // A jump is another lane's center line.
        let jumps = moved.windows(2).any(|p| (p[1] - p[0]).abs() > 1.0);
        let (min, max) = moved.iter().fold((0.0_f64, 0.0_f64), |(a, b), m| (a.min(*m), b.max(*m)));
        let (to, away_m) = if left { (max, -min) } else { (-min, max) };
        if !jumps && away_m > OFFSET_M && to < 0.15 {
            return Some(Conflict::MovesOther { away_m });
        }
    }
    // The avoided object, if one is linked, is on the other side.
    let [id] = objects else { return None };
    let row = w.signals.target(&TrackId::from(*id)).and_then(|t| t.row(w.keyframe));
    let lateral_m = w.signals.target_columns.get("target.path_lateral")?.number(row?)?;
    ((left && lateral_m > 1.0) || (!left && lateral_m < -1.0)).then_some(Conflict::ThingThere { lateral_m })
}
