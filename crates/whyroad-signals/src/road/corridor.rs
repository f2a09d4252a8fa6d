//! A lane continued along a route: ahead through the successors that the actor takes (else the straightest), behind
//! through the lanes from which it came. One line with the widths to both edges.

use crate::geometry::{P2, Polyline};
use crate::road::lanes::LanePlace;
use crate::road::network::Road;

/// Length of a corridor ahead of its lane's start, in addition to the lane's own length, m.
pub const AHEAD_M: f64 = 160.0;
/// Length of a corridor behind the lane's start, m.
pub const BEHIND_M: f64 = 110.0;

/// A lane and its continuation, by arc length.
#[derive(Clone, Debug)]
pub struct Corridor {
    /// Center line.
    pub line: Polyline,
    left: Vec<f64>,
    right: Vec<f64>,
    /// Arc length at which each lane of the chain begins, in driving order.
    pub lanes: Vec<(usize, f64)>,
    base_start: f64,
}

/// The continuation of `last`, one of `options`: one on the route, else one beside the route, else the straightest.
fn choose(road: &Road, last: usize, options: &[usize], route: &[usize]) -> Option<usize> {
    let rank = |&i: &usize| {
        let beside = road.lanes[i].neighbors.iter().flatten().any(|n| route.contains(n));
        let order = if route.contains(&i) {
            0.0
        } else if beside {
            10.0
        } else {
            20.0
        };
        order + road.turn_of(i, last)
    };
    options.iter().copied().min_by(|a, b| rank(a).total_cmp(&rank(b)))
}

impl Corridor {
    /// The corridor of lane `base` for an actor whose route is `route` (all lanes it is ever in).
    pub fn new(road: &Road, base: usize, route: &[usize]) -> Option<Self> {
        let mut chain = vec![base];
        let mut reach = 0.0;
        // The lane itself may be shorter than the required length ahead of any position on it.
        while reach < AHEAD_M {
            let last = *chain.last()?;
            let Some(next) = choose(road, last, &road.lanes[last].successors, route) else { break };
            reach += road.lanes[next].center.length();
            chain.push(next);
        }
        let mut behind = Vec::new();
        let mut reach = 0.0;
        while reach < BEHIND_M {
            let last = behind.last().copied().unwrap_or(base);
            let Some(previous) = choose(road, last, &road.lanes[last].predecessors, route) else { break };
            reach += road.lanes[previous].center.length();
            behind.push(previous);
        }
        behind.reverse();
        let base_index = behind.len();
        behind.extend(chain);

        let (mut points, mut left, mut right) = (Vec::<P2>::new(), Vec::new(), Vec::new());
        let mut starts = Vec::new();
        for &index in &behind {
            let lane = &road.lanes[index];
            starts.push((index, points.len()));
            for (i, &p) in lane.center.points().iter().enumerate() {
                if points.last().is_some_and(|&q: &P2| (p - q).norm() <= 0.05) {
                    continue;
                }
                points.push(p);
                left.push(lane.left_width[i]);
                right.push(lane.right_width[i]);
            }
        }
        let line = Polyline::new(points)?;
        let s_at = |i: usize| line.arc_lengths().get(i).copied().unwrap_or(line.length());
        // A lane's first point is dropped when it repeats the last one of the lane before; the lane begins there.
        let lanes: Vec<(usize, f64)> = starts
            .iter()
            .enumerate()
            .map(|(k, &(lane, i))| (lane, s_at(if k == 0 { 0 } else { i.saturating_sub(1) })))
            .collect();
        let base_start = lanes[base_index].1;
        Some(Self { line, left, right, lanes, base_start })
    }

    /// Arc length on the corridor of a position on its base lane, m.
    pub fn s_of(&self, place: &LanePlace) -> f64 {
        self.base_start + place.s
    }

    /// Distances from the center line to the left and right edge at `s`, m.
    pub fn widths_at(&self, s: f64) -> (f64, f64) {
        self.line.interpolate_both([&self.left, &self.right], s)
    }

    /// Arc length where lane `k` of the chain ends, m.
    pub fn lane_end(&self, k: usize) -> f64 {
        self.lanes.get(k + 1).map_or(self.line.length(), |(_, s)| *s)
    }
}
