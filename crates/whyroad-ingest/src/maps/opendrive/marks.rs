//! Marks on the edges of lanes, as seen in driving direction.

use super::document::{DocLane, Mark};
use super::spans::longest;
use whyroad_model::road_map::LaneMark;

/// Marks on the left and right edge of a lane. A lane's own marks are those of its outer edge; `inner` are those of the
/// lane before it, or of the middle.
pub(super) fn of(lane: &DocLane, inner: &[Mark], forward: bool, length: f64) -> (LaneMark, LaneMark) {
    // Two lines are named from the inside to the outside: on the left side, that is from right to left. Those of the
    // middle (0) are named from left to right.
    let outer = along(&lane.marks, length);
    let outer = if lane.id > 0 { swapped(outer) } else { outer };
    let inner = along(inner, length);
    let inner = if lane.id > 1 { swapped(inner) } else { inner };
    match (forward, lane.id > 0) {
        (true, false) => (inner, outer),
        (true, true) => (outer, inner),
        (false, false) => (swapped(outer), swapped(inner)),
        (false, true) => (swapped(inner), swapped(outer)),
    }
}

/// The mark over most of the section.
fn along(marks: &[Mark], length: f64) -> LaneMark {
    let by_start: Vec<(f64, LaneMark)> = marks.iter().map(|m| (m.offset, mark(&m.kind))).collect();
    longest(&by_start, 0.0, length).unwrap_or(LaneMark::Unknown)
}

fn mark(kind: &str) -> LaneMark {
    match kind {
        "none" => LaneMark::None,
        "solid" => LaneMark::Solid,
        "broken" | "botts dots" => LaneMark::Dashed,
        "solid solid" => LaneMark::DoubleSolid,
        "broken broken" => LaneMark::DoubleDashed,
        "solid broken" => LaneMark::SolidDashed,
        "broken solid" => LaneMark::DashedSolid,
        // Grass, curbs and what the file describes line by line.
        _ => LaneMark::Unknown,
    }
}

/// The same mark seen the other way.
fn swapped(mark: LaneMark) -> LaneMark {
    match mark {
        LaneMark::SolidDashed => LaneMark::DashedSolid,
        LaneMark::DashedSolid => LaneMark::SolidDashed,
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lane(id: i32, kind: &str) -> DocLane {
        let marks = vec![Mark { offset: 0.0, kind: kind.into() }];
        DocLane { id, marks, ..DocLane::default() }
    }

    #[test]
    fn two_lines_are_seen_from_either_side() {
        // In the middle: solid on the left by ascending stations, dashed on the right. A driver going forward on the
        // right side has the dashed line on the near side, that is on the right of the two.
        let middle = [Mark { offset: 0.0, kind: "solid broken".into() }];
        let right = of(&lane(-1, "solid"), &middle, true, 10.0);
        assert_eq!(right, (LaneMark::SolidDashed, LaneMark::Solid));
        // Against it, on the left side, the solid one is on the driver's side.
        let left = of(&lane(1, "broken"), &middle, false, 10.0);
        assert_eq!(left, (LaneMark::DashedSolid, LaneMark::Dashed));
    }

    #[test]
    fn the_outer_line_of_the_left_side_is_named_from_the_inside() {
        // Lane 1 drives backward; its outer edge is on its right: inside (its left) solid, outside dashed.
        let (_, right) = of(&lane(1, "solid broken"), &[], false, 10.0);
        assert_eq!(right, LaneMark::SolidDashed);
        // Lane 2 has that edge on its left.
        let inner = lane(1, "solid broken");
        let (left, _) = of(&lane(2, "solid"), &inner.marks, false, 10.0);
        assert_eq!(left, LaneMark::SolidDashed);
        assert_eq!(of(&lane(-1, ""), &[], true, 10.0), (LaneMark::Unknown, LaneMark::Unknown));
    }
}
