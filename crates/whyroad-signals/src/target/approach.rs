//! Approach of a target and the ego along the ego's path: the gap and the closing speed, computed once per row for all
//! measures that use them.

use crate::geometry::wrap;
use crate::target::gaps::{self, gap};
use crate::target::placement::{Approach, PlacedRows, Placement, Surroundings, Target};
use std::f64::consts::PI;
use whyroad_model::scene::Track;

/// Minimum closing speed, m/s: a smaller one is within the accuracy of differentiated positions.
pub const CLOSING_LEAST_MPS: f64 = 0.1;
/// Motion within this angle of the path's direction is along it: 45 deg (RefAV).
const ALONG_RAD: f64 = PI / 4.0;
/// Maximum angle for a head-on approach of an oncoming target: 20 deg.
const HEAD_ON_RAD: f64 = 20.0 * PI / 180.0;

/// Direction of a target relative to the ego's path at its position.
#[derive(Clone, Copy, PartialEq)]
pub enum Course {
    /// In the path's direction, within 45 deg.
    Along,
    /// Against it, nearly in line with the ego.
    HeadOn,
    /// Everything else.
    Across,
}

/// The course of `p`. What is beside the ego does not come head-on any more: its side passes along the ego's way.
pub fn course_of(p: &Placement) -> Course {
    let turned = p.turned();
    let straight = || wrap(p.path.heading - p.heading_at_ego).abs() < HEAD_ON_RAD;
    if turned <= ALONG_RAD {
        Course::Along
    } else if turned > PI - HEAD_ON_RAD && straight() && !p.beside_ego {
        // A car of the same direction that reverses also moves against the path.
        Course::HeadOn
    } else {
        Course::Across
    }
}

/// Speed of a target along the path, m/s; never negative for a target that moves across, which can only recede.
pub fn along(p: &Placement) -> f64 {
    let along = gaps::along_signed(p);
    if course_of(p) == Course::Across { along.max(0.0) } else { along }
}

/// Places `track` in these of its rows, with gaps and closing speeds; `times` in seconds by frame.
pub fn place<'t>(around: &Surroundings<'_>, track: &'t Track, times: &[f64], rows: PlacedRows) -> Target<'t> {
    let mut target = around.place(track, times, rows);
    for p in target.places.iter_mut().flatten() {
        let gap = gap(p, around.ego.length);
        p.approach = Approach { gap, closing: closing(p, gap, around) };
    }
    target
}

/// Closing speed of an in-path pair along the path, m/s; 0 if the two will not meet there. A target that moves across
/// can only recede: its lateral motion moves it out of the path, not nearer along it. A target that does not move along
/// the path must still be in it when the ego gets there: a car that passes the end of the ego's left turn, or a
/// pedestrian who has crossed by then, is not on a collision course along the path (`target.ttc_box` and `target.pet`
/// cover these). Most targets are not in the path: for an infinite gap nothing is computed.
fn closing(p: &Placement, gap: f64, around: &Surroundings<'_>) -> f64 {
    if gap.is_infinite() {
        return 0.0;
    }
    let speed = around.ego.forward_speed[p.frame] - along(p);
    let meets = gap.is_nan()
        || course_of(p) == Course::Along
        || speed <= CLOSING_LEAST_MPS
        || around.meets(p, gap.max(0.0) / speed);
    if meets { speed } else { 0.0 }
}
