//! The lane of an actor over its whole track: the cheapest sequence of lanes (Viterbi) by position, heading and
//! continuity. This gives hysteresis (a short swing over a line is not a lane change), distinguishes the overlapping
//! lanes of a junction by the actor's origin and destination, and assigns no lane to an actor that is off the road, or
//! is stationary or drives against the lane.

use crate::geometry::{P2, wrap};
use crate::road::network::Road;
use whyroad_model::road_map::LaneKind;

/// Position of an actor on its lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LanePlace {
    /// Index into [`Road::lanes`].
    pub lane: usize,
    /// Arc length along the center line, m.
    pub s: f64,
    /// Offset from the center line, left positive, m.
    pub lateral: f64,
}

/// Parameters for assigning an actor to lanes. Costs are per frame and without unit; only their ratios matter.
#[derive(Clone, Copy, Debug)]
pub struct Tether {
    /// Cost of having no lane. A lane is not assigned if the center is farther beyond its edge than about this, m.
    none: f64,
    /// Lanes are considered until the center is this far beyond their edge, m.
    reach_m: f64,
    /// Cost of a bicycle lane for this kind of actor.
    bike_lane: f64,
}

impl Tether {
    /// The ego: it drives on roads, and its lane should survive borrowing the oncoming one.
    pub const EGO: Tether = Tether { none: 2.0, reach_m: 1.5, bike_lane: 0.5 };
    /// Other motor vehicles: many are parked beside the road.
    pub const VEHICLE: Tether = Tether { none: 0.8, reach_m: 1.0, bike_lane: 0.5 };
    /// Bicycles.
    pub const BICYCLE: Tether = Tether { none: 0.8, reach_m: 1.0, bike_lane: 0.0 };
}

/// Maximum difference between the actor's heading and that of its lane at its place.
pub const HEADING_LIMIT_RAD: f64 = 75.0 * std::f64::consts::PI / 180.0;
/// Tolerance at lane ends, so that a center between two joints has a lane, m.
const END_SLACK_M: f64 = 0.5;
const CHANGE_COST: f64 = 1.5;
const ENTER_OR_LEAVE_COST: f64 = 1.5;
const BACKWARD_COST: f64 = 1.0;
const UNRELATED_COST: f64 = 4.0;

/// Candidate lanes at a position, on any level, with their costs: in `found`; `near` is room for the search.
fn candidates(
    road: &Road,
    (p, heading): (P2, f64),
    tether: Tether,
    near: &mut Vec<usize>,
    found: &mut Vec<(LanePlace, f64)>,
) {
    found.clear();
    road.find_lanes_near(p, tether.reach_m, near);
    for &index in &*near {
        let lane = &road.lanes[index];
        // Most others lead elsewhere: where on them the actor would be is not asked.
        if lane.kind == LaneKind::Sidewalk || !lane.may_lead(heading, HEADING_LIMIT_RAD) {
            continue;
        }
        let at = lane.center.project(p);
        if at.s < -END_SLACK_M || at.s > lane.center.length() + END_SLACK_M {
            continue;
        }
        let (left, right) = lane.widths_at(at.s);
        let beyond = (at.lateral - left).max(-at.lateral - right).max(0.0);
        if beyond > tether.reach_m {
            continue;
        }
        let turned = wrap(heading - lane.center.smooth_heading_at(at.s, 2.0)).abs();
        if turned > HEADING_LIMIT_RAD {
            continue;
        }
        let half = ((left + right) / 2.0).max(0.5);
        let mut cost = 0.3 * (at.lateral / half).powi(2) + beyond + 0.5 * (turned / 0.35).powi(2);
        if lane.kind == LaneKind::Bike {
            cost += tether.bike_lane;
        }
        found.push((LanePlace { lane: index, s: at.s, lateral: at.lateral }, cost));
    }
}

/// Cost of being in lane `b` one row after lane `a`.
fn transition(road: &Road, a: usize, b: usize) -> f64 {
    if a == b {
        return 0.0;
    }
    // Lanes can be shorter than the distance that a fast actor covers between two rows.
    let mut front = vec![a];
    for hop in 0..3 {
        front = front.iter().flat_map(|&i| road.lanes[i].successors.iter().copied()).collect();
        if front.contains(&b) {
            return 0.1 * f64::from(hop);
        }
    }
    let beside = |i: usize| road.lanes[i].neighbors.into_iter().flatten();
    let to_neighbor = beside(a).any(|n| n == b) || beside(b).any(|n| n == a);
    if to_neighbor {
        return CHANGE_COST;
    }
    let diagonal = beside(a).any(|n| road.lanes[n].successors.contains(&b))
        || road.lanes[a].successors.iter().any(|&n| beside(n).any(|m| m == b) || beside(b).any(|m| m == n));
    if diagonal {
        return CHANGE_COST + 0.1;
    }
    if road.lanes[b].successors.contains(&a) { BACKWARD_COST } else { UNRELATED_COST }
}

/// Cache of the costs of transitions between lanes: the same few are needed row after row.
#[derive(Default)]
struct Steps {
    /// By the lane that is left: the entered lanes, with the cost.
    known: Vec<(usize, Vec<(usize, f64)>)>,
}

impl Steps {
    fn between(&mut self, road: &Road, a: usize, b: usize) -> f64 {
        // The lanes of the last rows are at the end.
        let from = match self.known.iter().rposition(|(lane, _)| *lane == a) {
            Some(from) => from,
            None => {
                self.known.push((a, Vec::new()));
                self.known.len() - 1
            }
        };
        let to = &mut self.known[from].1;
        if let Some((_, cost)) = to.iter().rev().find(|(lane, _)| *lane == b) {
            return *cost;
        }
        let cost = transition(road, a, b);
        to.push((b, cost));
        cost
    }
}

/// The lane of each row, `None` where the actor is in no lane or its pose is unknown.
/// `rows` gives position (m), height (m) and heading (rad) of an actor in ascending time.
pub fn assign(road: &Road, rows: &[(P2, f64, f64)], tether: Tether) -> Vec<Option<LanePlace>> {
    // The states of all rows, one after another: for each row the candidates, followed by "no lane".
    let mut states: Vec<State> = Vec::with_capacity(3 * rows.len());
    let mut starts: Vec<usize> = Vec::with_capacity(rows.len());
    let mut steps = Steps::default();
    let mut here: Vec<(LanePlace, f64)> = Vec::new();
    let mut near: Vec<usize> = Vec::new();
    let mut last: Option<[u64; 3]> = None;
    for &(p, z, heading) in rows {
        let known = p.is_finite() && heading.is_finite();
        // A stationary actor has the same position as in the row before.
        let at = known.then(|| [p.x, p.y, heading].map(f64::to_bits));
        if known && at != last {
            candidates(road, (p, heading), tether, &mut near, &mut here);
            last = at;
        }
        let on_level = here.iter().filter(|(c, _)| known && road.lanes[c.lane].on_level(z));
        let candidates = on_level.map(|(c, cost)| (Some(*c), *cost));
        let before = starts.last().copied().unwrap_or(0)..states.len();
        starts.push(states.len());
        for (place, emission) in candidates.chain([(None, if known { tether.none } else { 0.0 })]) {
            if before.is_empty() {
                states.push(State { place, cost: emission, from: 0 });
                continue;
            }
            let mut best = (f64::INFINITY, before.start);
            for (i, from) in states[before.clone()].iter().enumerate() {
                let step = match (from.place, place) {
                    (Some(a), Some(b)) if a.lane == b.lane => 0.0,
                    (Some(a), Some(b)) => steps.between(road, a.lane, b.lane),
                    (None, None) => 0.0,
                    _ => ENTER_OR_LEAVE_COST,
                };
                if from.cost + step < best.0 {
                    best = (from.cost + step, before.start + i);
                }
            }
            states.push(State { place, cost: best.0 + emission, from: best.1 });
        }
    }
    let mut result = vec![None; rows.len()];
    let last = starts.last().copied().unwrap_or(0)..states.len();
    let cheapest = last.min_by(|&a, &b| states[a].cost.total_cmp(&states[b].cost));
    let mut at = cheapest.unwrap_or(0);
    for place in result.iter_mut().rev() {
        *place = states[at].place;
        at = states[at].from;
    }
    result
}

/// A lane, or none, in one row.
struct State {
    place: Option<LanePlace>,
    /// Cost of the cheapest sequence that ends here.
    cost: f64,
    /// The state of the row before in that sequence.
    from: usize,
}

#[cfg(test)]
mod tests;
