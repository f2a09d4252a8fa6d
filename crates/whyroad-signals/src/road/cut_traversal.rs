//! Completes the ego's movement through a junction in which the recording begins or ends, from the lanes of the junction:
//! only where every lane that the ego may be following there leads the same way.

use crate::geometry::wrap;
use crate::road::junction::{Stretch, movement};
use crate::road::network::Road;
use crate::road::path::DrivenPath;
use std::f64::consts::PI;

/// Maximum distance of the ego from the middle of a lane that it may be following, m.
const ON_LANE_M: f64 = 1.5;
/// Maximum difference between its course and that of such a lane: 15 deg.
const ALONG_RAD: f64 = PI / 12.0;
/// Minimum distance driven in the junction before its lanes tell anything, m, and at least half of the way through it:
/// lanes that part are together at first, and who has just entered has not passed it.
const LEAST_WAY_M: f64 = 8.0;
/// Courses of lanes are taken over this distance to both sides, m.
const COURSE_M: f64 = 1.0;
/// Maximum number of lanes of a junction that follow one another.
const LANES_IN_A_ROW: usize = 6;

/// Which end of a traversal.
#[derive(Clone, Copy)]
enum End {
    /// Where the ego enters the junction.
    Entry,
    /// Where it leaves it.
    Exit,
}

/// The change of heading over the whole traversal, rad, of which the recording has the part `angle`.
///
/// `None` if the recording lacks nothing, if the ego may be following lanes that lead different ways, or none.
pub fn completed(road: &Road, path: &DrivenPath, stretch: Stretch, angle: f64) -> Option<f64> {
    let (first, last) = path.driven;
    let inside = last.min(stretch.to) - first.max(stretch.from);
    if inside < LEAST_WAY_M.max((stretch.to - stretch.from) / 2.0) {
        return None;
    }
    let lacking = [(End::Entry, first, first > stretch.from), (End::Exit, last, last < stretch.to)];
    if lacking.iter().all(|(_, _, lacks)| !lacks) {
        return None;
    }
    let mut wholes = vec![angle];
    for (end, at, lacks) in lacking {
        if lacks {
            let rest = rests(road, path, at, end);
            wholes = wholes.iter().flat_map(|whole| rest.iter().map(move |rest| whole + rest)).collect();
        }
    }
    let same = |whole: &f64| movement(*whole, true) == movement(wholes[0], true);
    (!wholes.is_empty() && wholes.iter().all(same)).then(|| wholes[0])
}

/// What each lane that the ego may be following at `at` (arc length of the path) turns from there to that end of the
/// junction, rad: the nearest lane first.
fn rests(road: &Road, path: &DrivenPath, at: f64, end: End) -> Vec<f64> {
    let (place, course) = (path.line.point_at(at), path.heading_at(at));
    let mut near: Vec<_> = (road.lanes_near(place, ON_LANE_M).into_iter())
        .filter(|&lane| road.lanes[lane].in_junction)
        .filter_map(|lane| {
            let center = &road.lanes[lane].center;
            let on = center.project(place);
            let turned = wrap(center.smooth_heading_at(on.s, COURSE_M) - course);
            let covers = (-COURSE_M..=center.length() + COURSE_M).contains(&on.s);
            let follows = covers && on.lateral.abs() <= ON_LANE_M && turned.abs() <= ALONG_RAD;
            follows.then_some((on.lateral.abs(), lane, on.s))
        })
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let turns = near.into_iter().flat_map(|(_, lane, s)| {
        let center = &road.lanes[lane].center;
        let here = center.smooth_heading_at(s, COURSE_M);
        let own = match end {
            End::Entry => wrap(here - center.heading_at(0.0)),
            End::Exit => wrap(center.heading_at(center.length()) - here),
        };
        onward(road, lane, end, LANES_IN_A_ROW).into_iter().map(move |rest| own + rest)
    });
    turns.collect()
}

/// What the lanes of the junction turn that follow this one towards that end, rad: one value for each way.
fn onward(road: &Road, lane: usize, end: End, left: usize) -> Vec<f64> {
    let shape = &road.lanes[lane];
    let next = match end {
        End::Entry => &shape.predecessors,
        End::Exit => &shape.successors,
    };
    let inside: Vec<usize> = next.iter().copied().filter(|&l| road.lanes[l].in_junction).collect();
    if inside.is_empty() || left == 0 {
        return vec![0.0];
    }
    let turns = inside.into_iter().flat_map(|l| {
        let center = &road.lanes[l].center;
        let own = wrap(center.heading_at(center.length()) - center.heading_at(0.0));
        onward(road, l, end, left - 1).into_iter().map(move |rest| own + rest)
    });
    turns.collect()
}
