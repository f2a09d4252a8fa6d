//! Completes the ego's way through a junction in which the recording ends, from the lanes of the junction.

use crate::geometry::wrap;
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

/// What each lane of the junction that the ego may be following where the recording ends turns from there on, rad: the
/// nearest lane first. `junction`: arc lengths of the path at which it begins and ends, m.
///
/// Empty if the recording does not end inside, or too soon, or if the ego follows no lane there.
pub fn rest_by_lanes(road: &Road, path: &DrivenPath, junction: (f64, f64)) -> Vec<f64> {
    let ((from, to), (first, last)) = (junction, path.driven);
    let cut_at_the_end_only = first <= from && last < to;
    if !cut_at_the_end_only || last - from < LEAST_WAY_M.max((to - from) / 2.0) {
        return Vec::new();
    }
    let (place, course) = (path.line.point_at(last), path.heading_at(last));
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
        let own = wrap(center.heading_at(center.length()) - center.smooth_heading_at(s, COURSE_M));
        onward(road, lane, LANES_IN_A_ROW).into_iter().map(move |rest| own + rest)
    });
    turns.collect()
}

/// What the lanes of the junction turn that follow this one, rad: one value for each way.
fn onward(road: &Road, lane: usize, left: usize) -> Vec<f64> {
    let successors = road.lanes[lane].successors.iter().copied();
    let inside: Vec<usize> = successors.filter(|&l| road.lanes[l].in_junction).collect();
    if inside.is_empty() || left == 0 {
        return vec![0.0];
    }
    let turns = inside.into_iter().flat_map(|l| {
        let center = &road.lanes[l].center;
        let own = wrap(center.heading_at(center.length()) - center.heading_at(0.0));
        onward(road, l, left - 1).into_iter().map(move |rest| own + rest)
    });
    turns.collect()
}
