//! Lane changes of an actor from its sequence of lanes: from where it leaves the old lane's center until it is stable
//! in the new one (LABELING.md 4: phases execute and complete). The two lanes are adjacent and have the same direction;
//! a transition to a successor is not a lane change, whatever the geometry of the joint.

use crate::estimate::Aside;
use crate::geometry::P2;
use crate::road::corridor::Corridor;
use crate::road::lanes::LanePlace;
use crate::road::network::Road;
use crate::road::own_shift::{OnWay, most_shifted};
use crate::series::GAP_S;
use whyroad_model::catalog::value::EgoLaneChange;

/// Minimum lateral speed of an actor that moves across, below which it is stable, m/s (LABELING.md 4, RefAV).
const LATERAL_MPS: f64 = 0.1;
/// Standard deviations that the lateral speed and the offset must also exceed.
const DEVIATIONS: f64 = 1.5;
/// Maximum distance from the new lane's center at which the actor has arrived, m (LABELING.md 4).
const CENTERED_M: f64 = 0.3;
/// Time without lateral motion after which it is stable outside of the center, too, s.
const SETTLED_S: f64 = 2.0;
/// A shorter pause in the lateral motion does not end the beginning phase, s.
const PAUSE_S: f64 = 0.5;
/// Minimum lateral movement, m: less is caused by the map's joint, not by the actor.
const LEAST_SHIFT_M: f64 = 1.5;
/// Minimum share of it by the actor's own steering, m: where a lane forks off or ends, an actor that drives straight on
/// is in another lane.
const LEAST_OWN_SHIFT_M: f64 = 0.7;
/// Its steering is measured from this long before the crossing to this long after it, s.
const AROUND_S: f64 = 5.0;
/// Minimum speed at which the velocity determines the direction, m/s.
const DIRECTION_MPS: f64 = 0.5;
/// Minimum time in the new lane, s, unless the recording ends.
const LEAST_STAY_S: f64 = 1.0;
/// Maximum duration of a lane change on either side of the line, s.
const LONGEST_HALF_S: f64 = 10.0;

/// To which side an actor changes lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// One lane change, in rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// First row: it leaves the old lane's center.
    pub start: usize,
    /// First row with half of the actor in the new lane.
    pub crossing: usize,
    /// One past the last row: it is stable in the new lane.
    pub end: usize,
    /// The side.
    pub side: Side,
}

/// An actor's rows in ascending time.
pub struct Rows<'a> {
    /// s.
    pub times: &'a [f64],
    /// m, world.
    pub position: &'a [P2],
    /// m/s, world.
    pub velocity: &'a [P2],
    /// Assigned lanes.
    pub places: &'a [Option<LanePlace>],
    /// Accuracy of its lateral motion; empty where the log is exact.
    pub aside: &'a [Aside],
}

/// On which side of lane `a` lane `b` is, 0 left, 1 right; `None` when `b` follows `a` or is elsewhere.
fn side_of(road: &Road, a: usize, b: usize) -> Option<usize> {
    let mut front = vec![a];
    for _ in 0..3 {
        front = front.iter().flat_map(|&i| road.lanes[i].successors.iter().copied()).collect();
        if front.contains(&b) {
            return None;
        }
    }
    let beside = |x: usize, y: usize, side: usize| {
        road.lanes[x].neighbors[side] == Some(y) || road.lanes[y].neighbors[1 - side] == Some(x)
    };
    (0..2).find(|&side| {
        beside(a, b, side)
            || road.lanes[a].successors.iter().any(|&next| beside(next, b, side))
            || road.lanes[b].predecessors.iter().any(|&before| beside(a, before, side))
    })
}

impl Rows<'_> {
    fn gap_after(&self, row: usize) -> bool {
        self.times[row + 1] - self.times[row] > GAP_S
    }

    /// Lateral speed from which it moves in this row, and below which it is stable, m/s: more than its noise.
    fn moving_mps(&self, row: usize) -> f64 {
        self.aside.get(row).map_or(LATERAL_MPS, |a| LATERAL_MPS.max(DEVIATIONS * a.speed_mps))
    }

    /// Distance from the center within which it has arrived, m: at least its noise.
    fn centered_m(&self, row: usize) -> f64 {
        self.aside.get(row).map_or(CENTERED_M, |a| CENTERED_M.max(DEVIATIONS * a.place_m))
    }

    /// Offset from a corridor's center and lateral speed, both positive towards `sign`.
    fn across(&self, corridor: &Corridor, row: usize, sign: f64) -> (f64, f64) {
        let at = corridor.line.project(self.position[row]);
        let left = P2::from_heading(corridor.line.smooth_heading_at(at.s, 2.0)).left();
        (sign * at.lateral, sign * self.velocity[row].dot(left))
    }

    /// Maximum lateral movement towards `sign` by its own steering around row `k`, m; `None` if it is stationary
    /// meanwhile, so that its direction is not always known.
    fn by_own_steering(&self, k: usize, sign: f64) -> Option<f64> {
        let near = |row: &usize| (self.times[*row] - self.times[k]).abs() <= AROUND_S;
        let rows = |all: std::ops::Range<usize>| all.filter(near).step_by(3);
        if rows(0..self.times.len()).any(|row| self.velocity[row].norm() < DIRECTION_MPS) {
            return None;
        }
        let place =
            |row: usize| OnWay { position: self.position[row], direction: self.velocity[row].heading() };
        let (before, after): (Vec<OnWay>, Vec<OnWay>) =
            (rows(0..k).map(place).collect(), rows(k..self.times.len()).map(place).collect());
        (!before.is_empty() && !after.is_empty()).then(|| most_shifted(&before, &after, sign))
    }

    /// First row of the change whose first row in the new lane is `k`.
    fn beginning(&self, road: &Road, old: &Corridor, k: usize, earliest: usize, sign: f64) -> usize {
        let mut start = k;
        let mut row = k;
        while row > earliest
            && !self.gap_after(row - 1)
            && self.times[k] - self.times[row - 1] <= LONGEST_HALF_S
        {
            row -= 1;
            // An actor that moves across while it leaves a junction's turn is still settling into its lane.
            if self.places[row].is_some_and(|p| road.lanes[p.lane].turns_in_junction()) {
                break;
            }
            let (offset, speed) = self.across(old, row, sign);
            if speed >= self.moving_mps(row)
                || (offset > self.centered_m(row) && start == row + 1 && speed > 0.0)
            {
                start = row;
            } else if self.times[start] - self.times[row] > PAUSE_S {
                break;
            }
        }
        start
    }

    /// The row in which it is farthest towards `sign`.
    fn farthest(&self, new: &Corridor, k: usize, latest: usize, sign: f64) -> usize {
        let offset = |row: usize| self.across(new, row, sign).0;
        (k..latest).max_by(|&a, &b| offset(a).total_cmp(&offset(b))).unwrap_or(k)
    }

    /// One past the last row of the change.
    fn end(&self, new: &Corridor, k: usize, latest: usize, sign: f64) -> usize {
        let mut still_since = None;
        for row in k..latest {
            let (offset, speed) = self.across(new, row, sign);
            let still = speed.abs() < self.moving_mps(row);
            let since = *still_since.get_or_insert(self.times[row]);
            if !still {
                still_since = None;
            }
            let settled =
                still && (offset.abs() < self.centered_m(row) || self.times[row] - since >= SETTLED_S);
            let broken = row + 1 < latest && self.gap_after(row);
            if settled || broken || self.times[row] - self.times[k] > LONGEST_HALF_S {
                return row + 1;
            }
        }
        latest
    }
}

/// The change in progress in each row; `None` where no lane is known.
pub fn changes(road: &Road, rows: &Rows<'_>) -> Vec<Option<EgoLaneChange>> {
    let mut codes: Vec<Option<EgoLaneChange>> =
        rows.places.iter().map(|p| p.as_ref().map(|_| EgoLaneChange::None)).collect();
    for change in found(road, rows) {
        let code = if change.side == Side::Left { EgoLaneChange::Left } else { EgoLaneChange::Right };
        codes[change.start..change.end].fill(Some(code));
    }
    codes
}

/// All lane changes of an actor, in order.
pub fn found(road: &Road, rows: &Rows<'_>) -> Vec<Change> {
    let n = rows.places.len();
    let mut changes = Vec::new();
    // (first row in the new lane, old lane, new lane, side)
    let mut steps: Vec<(usize, usize, usize, usize)> = Vec::new();
    let mut last: Option<(usize, usize)> = None;
    for (row, place) in rows.places.iter().enumerate() {
        let Some(place) = place else { continue };
        if let Some((before, old)) = last
            && old != place.lane
            && rows.times[row] - rows.times[before] < 2.0
            // Cutting a corner is not a lane change.
            && !road.lanes[old].turns_in_junction()
            && !road.lanes[place.lane].turns_in_junction()
            && let Some(side) = side_of(road, old, place.lane)
        {
            steps.push((row, old, place.lane, side));
        }
        last = Some((row, place.lane));
    }
    let mut route: Vec<usize> = rows.places.iter().flatten().map(|p| p.lane).collect();
    route.sort_unstable();
    route.dedup();
    for (x, &(k, old, new, side)) in steps.iter().enumerate() {
        let earliest = x.checked_sub(1).map_or(0, |w| steps[w].0);
        let latest = steps.get(x + 1).map_or(n, |s| s.0);
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let (Some(from), Some(to)) = (Corridor::new(road, old, &route), Corridor::new(road, new, &route))
        else {
            continue;
        };
        let start = rows.beginning(road, &from, k, earliest, sign);
        let end = match rows.end(&to, k, latest, sign) {
            // It was never stable there before the next change: it was there where it was farthest over.
            end if end == latest && latest < n => 1 + rows.farthest(&to, k, latest, sign),
            end => end,
        };
        let shift = rows.across(&from, end - 1, sign).0 - rows.across(&from, start, sign).0;
        let stayed = latest == n || rows.times[latest] - rows.times[k] >= LEAST_STAY_S;
        let steered = rows.by_own_steering(k, sign).is_none_or(|m| m >= LEAST_OWN_SHIFT_M);
        if shift >= LEAST_SHIFT_M && steered && stayed {
            let side = if side == 0 { Side::Left } else { Side::Right };
            changes.push(Change { start, crossing: k, end, side });
        }
    }
    changes
}
