//! How a target and the ego near each other along the ego's path: the gap and the closing speed, once per row for all
//! measures that ask for them.

use crate::geometry::wrap;
use crate::target::gaps::{self, gap};
use crate::target::placement::{Approach, PlacedRows, Placement, Surroundings, Target};
use std::f64::consts::PI;
use whyroad_model::scene::Track;

/// Closing slower than this is not closing, m/s: it is within what differentiated positions can tell.
pub const CLOSING_LEAST_MPS: f64 = 0.1;
/// Motion within this of the path's direction is along it: 45 deg (RefAV).
const ALONG_RAD: f64 = PI / 4.0;
/// An oncoming target meets the ego head-on only where both are aligned to within this: 20 deg.
const HEAD_ON_RAD: f64 = 20.0 * PI / 180.0;

/// How a target goes relative to the ego's path where it is.
#[derive(Clone, Copy, PartialEq)]
pub enum Course {
    /// With it, to within 45 deg.
    Along,
    /// Against it, nearly in line with the ego.
    HeadOn,
    /// Everything else.
    Across,
}

/// How `p` goes.
pub fn course_of(p: &Placement) -> Course {
    let turned = p.turned();
    let straight = || wrap(p.path.heading - p.heading_at_ego).abs() < HEAD_ON_RAD;
    if turned <= ALONG_RAD {
        Course::Along
    } else if turned > PI - HEAD_ON_RAD && straight() {
        // A car of the same direction that backs up goes against the path as well.
        Course::HeadOn
    } else {
        Course::Across
    }
}

/// Speed of a target along the path, of what can be closed on: what goes across recedes at best, m/s.
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

/// Closing speed of an in-path pair along the path, m/s; 0 when the two will not meet there. A target that goes
/// across recedes at best: its sideways motion brings it out of the path, not nearer along it. Whatever does not go
/// along the path must still be in it when the ego gets there: a car that passes the mouth of the ego's left turn, or
/// a walker who has crossed by then, is on no collision course along the path (`target.ttc_box` and `target.pet`
/// look at those). Most targets are not in the path: of an infinite gap nothing is asked.
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
