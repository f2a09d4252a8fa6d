//! The shape of the road here and ahead: grade, minimum width, number of lanes, where the ego's lane or the road itself
//! ends. Along the ego's lane (`corridor.rs`) for grade and width, along its way (`way.rs`) for the rest.

use crate::geometry::{interpolate, p2};
use crate::road::ego_lane::{OnCorridor, lane_count};
use crate::road::merging::merges_away;

use crate::road::on_road::{OnRoad, within_horizon};
use crate::road::way::{Way, beside};
use crate::table::TableBuilder;
use whyroad_model::catalog::id;
use whyroad_model::road_map::Lane;

/// The grade is that of a chord from this far behind to this far ahead, m.
const GRADE_REACH_M: f64 = 5.0;
/// Minimum length of a chord at the end of the map, m.
const LEAST_CHORD_M: f64 = 3.0;
/// Maximum plausible grade; with a steeper one the heights are wrong. The steepest street of the world has 0.35.
const STEEPEST: f64 = 0.35;
/// Look-ahead distance for grades, m.
const GRADE_AHEAD_M: f64 = 60.0;
/// Look-ahead distance for widths, m.
const WIDTH_AHEAD_M: f64 = 50.0;
/// Distance ahead at which lanes are counted, m.
const COUNT_AHEAD_M: f64 = 100.0;
const STEP_M: f64 = 2.0;

/// Height of a lane's center line by arc length; `None` where the map has no heights.
struct Heights {
    s: Vec<f64>,
    z: Vec<f64>,
}

impl Heights {
    fn of(lane: &Lane) -> Option<Self> {
        let (mut s, mut z) = (Vec::new(), Vec::new());
        let (mut at, mut before) = (0.0, None);
        for p in &lane.center {
            let here = p2(p.x, p.y);
            let step = before.map_or(f64::INFINITY, |b| (here - b).norm());
            // As in `Polyline`, which drops repeated points.
            if step <= 1e-3 {
                continue;
            }
            at += if before.is_some() { step } else { 0.0 };
            before = Some(here);
            if p.z.is_finite() {
                s.push(at);
                z.push(p.z);
            }
        }
        (s.len() >= 2).then_some(Self { s, z })
    }
}

struct Profile<'a> {
    on: &'a OnRoad<'a>,
    /// By lane of the road.
    heights: Vec<Option<Heights>>,
}

impl Profile<'_> {
    /// Height of the ego's lane at arc length `s` of its corridor.
    fn z(&self, at: OnCorridor<'_>, s: f64) -> Option<f64> {
        let k = at.corridor.lanes.partition_point(|(_, start)| *start <= s).max(1) - 1;
        let (lane, start) = at.corridor.lanes[k];
        self.heights[lane].as_ref().map(|h| interpolate(&h.s, &h.z, s - start))
    }

    fn lane_grade(&self, at: OnCorridor<'_>, s: f64) -> Option<f64> {
        let (low, high) = ((s - GRADE_REACH_M).max(0.0), (s + GRADE_REACH_M).min(at.corridor.line.length()));
        if high - low < LEAST_CHORD_M {
            return None;
        }
        Some((self.z(at, high)? - self.z(at, low)?) / (high - low))
    }

    /// Grade of the road at `ds` ahead of the ego's center; of its path if it has no lane with heights.
    fn grade(&self, frame: usize, ds: f64) -> Option<f64> {
        self.raw_grade(frame, ds).filter(|g| g.abs() <= STEEPEST)
    }

    fn raw_grade(&self, frame: usize, ds: f64) -> Option<f64> {
        if let Some(at) = self.on.lanes.at(frame) {
            return self.lane_grade(at, at.s + ds);
        }
        let path = self.on.path;
        let s = path.ego_s[frame] + ds;
        let (low, high) = ((s - GRADE_REACH_M).max(path.driven.0), (s + GRADE_REACH_M).min(path.driven.1));
        (high - low >= LEAST_CHORD_M).then(|| (path.z_at(high) - path.z_at(low)) / (high - low))
    }

    fn steepest_ahead(&self, frame: usize) -> f64 {
        let steps = (GRADE_AHEAD_M / STEP_M) as usize;
        let grades = (0..=steps).filter_map(|k| self.grade(frame, k as f64 * STEP_M));
        grades.fold(f64::NAN, |worst, g| if worst.abs() >= g.abs() { worst } else { g })
    }
}

/// Minimum width of the lane from the ego's front on; lanes inside junctions have no width of their own.
fn least_width(on: &OnRoad<'_>, at: OnCorridor<'_>) -> f64 {
    let from = at.s + on.ego.front();
    let to = (from + WIDTH_AHEAD_M).min(at.corridor.line.length());
    let mut least = f64::NAN;
    for (k, &(lane, start)) in at.corridor.lanes.iter().enumerate() {
        if on.road.lanes[lane].in_junction {
            continue;
        }
        let (mut s, end) = (start.max(from), at.corridor.lane_end(k).min(to));
        while s < end {
            let (left, right) = at.corridor.widths_at(s);
            least = least.min(left + right);
            s += STEP_M;
        }
    }
    least
}

fn count_ahead(on: &OnRoad<'_>, way: &Way, front: f64) -> f64 {
    let s = front + COUNT_AHEAD_M;
    if s > way.steps.last().map_or(0.0, |step| step.to) {
        return f64::NAN;
    }
    // Lanes inside a junction cross one another; the lanes behind it count.
    let road_lane = way.steps[way.step_at(s)..].iter().find(|step| !on.road.lanes[step.lane].in_junction);
    road_lane.map_or(f64::NAN, |step| lane_count(on.road, step.lane))
}

/// Position on the way where the ego's lane ends.
fn lane_end(on: &OnRoad<'_>, way: &Way, front: f64) -> f64 {
    let ends = |k: &usize| way.steps[*k + 1].hopped || merges_away(on, way, *k);
    let end = (0..way.steps.len() - 1).find(ends);
    end.map_or(f64::INFINITY, |k| within_horizon(way.steps[k].to - front))
}

/// Position where the road ends; NaN if the map states that it continues outside of the map.
fn dead_end(on: &OnRoad<'_>, way: &Way, front: f64) -> f64 {
    let Some(last) = way.steps.last().filter(|_| way.ends) else { return f64::INFINITY };
    let distance = within_horizon(last.to - front);
    let leads_out = |lane: usize| on.lane(lane).is_some_and(|l| !l.successors.is_empty());
    let leaves = leads_out(last.lane) || beside(on.road, last.lane).into_iter().any(leads_out);
    if leaves && distance.is_finite() { f64::NAN } else { distance }
}

/// Distance to the first lane that leads only back, along the way.
fn turns_back(on: &OnRoad<'_>, way: &Way, front: f64) -> f64 {
    use whyroad_model::road_map::TurnKind;
    let only_back = |lane: usize| {
        let next = &on.road.lanes[lane].successors;
        let back = |&n: &usize| on.lane(n).is_some_and(|l| l.turn == Some(TurnKind::Uturn));
        // A way that leaves the map continues.
        let all_here = on.lane(lane).is_some_and(|l| l.successors.len() == next.len());
        !next.is_empty() && all_here && next.iter().all(back)
    };
    let ends = |lane: usize| {
        let road: Vec<usize> = std::iter::once(lane).chain(beside(on.road, lane)).collect();
        // A lane of the road without successors does not continue the way.
        road.iter().any(|&l| only_back(l))
            && road.iter().all(|&l| only_back(l) || on.lane(l).is_some_and(|l| l.successors.is_empty()))
    };
    let end = way.steps.iter().find(|step| step.to >= front && ends(step.lane));
    end.map_or(f64::INFINITY, |step| within_horizon(step.to - front))
}

/// Writes `map.grade`, `grade_ahead`, `lane_width_ahead`, `lane_count_ahead`, `lane_ends`, `dead_end_distance`.
pub fn write(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    let heights = (0..on.road.lanes.len()).map(|i| on.lane(i).and_then(Heights::of)).collect();
    let profile = Profile { on, heights };
    let frames = || 0..on.frames();
    let known = |i: usize| on.ego.is_known(i);
    let grade = |i: usize| if known(i) { profile.grade(i, 0.0).unwrap_or(f64::NAN) } else { f64::NAN };
    table.number(id::MAP_GRADE, frames().map(grade).collect());
    let steepest = |i: usize| if known(i) { profile.steepest_ahead(i) } else { f64::NAN };
    table.number(id::MAP_GRADE_AHEAD, frames().map(steepest).collect());
    let width = |i: usize| on.lanes.at(i).map_or(f64::NAN, |at| least_width(on, at));
    table.number(id::MAP_LANE_WIDTH_AHEAD, frames().map(width).collect());
    table.number(id::MAP_LANE_COUNT_AHEAD, on.ahead(|_, way, front| count_ahead(on, way, front)));
    table.number(id::MAP_LANE_ENDS, on.ahead(|_, way, front| lane_end(on, way, front)));
    let ending = |_, way: &Way, front| {
        let (end, back) = (dead_end(on, way, front), turns_back(on, way, front));
        if back.is_finite() { back } else { end }
    };
    table.number(id::MAP_DEAD_END_DISTANCE, on.ahead(ending));
}
