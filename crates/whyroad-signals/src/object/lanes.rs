//! Lanes of all objects, and relations of lanes on the whole road: one lane of several segments, the same side or the
//! opposite side of a road.

use super::body::Body;
use crate::geometry::{P2, wrap};
use crate::road::lanes::{LanePlace, Tether, assign};
use crate::road::network::{LaneShape, Road};
use crate::target::lanes::drives;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use whyroad_model::road_map::LaneKind;

/// Minimum change of direction of a junction lane that turns, rad (RefAV: 30 deg).
const TURN_RAD: f64 = std::f64::consts::FRAC_PI_6;
/// Minimum difference of directions of opposite lanes, rad.
const AGAINST_RAD: f64 = 0.75 * std::f64::consts::PI;
/// Maximum distance of the opposite side beyond the edge, m: a median strip.
const MEDIAN_M: f64 = 6.0;
/// Maximum number of segments in each direction.
const MOST_SEGMENTS: usize = 200;

/// Lanes of the objects by their rows.
pub struct BodyLanes {
    /// Assigned positions of objects that drive in lanes, by object and row.
    pub places: Vec<Vec<Option<LanePlace>>>,
    /// The lane of each object, by object and row: the assigned one, else the one under the center.
    pub lanes: Vec<Vec<Option<usize>>>,
    chains: RefCell<BTreeMap<usize, Rc<BTreeSet<usize>>>>,
    sides: RefCell<BTreeMap<usize, Rc<Sides>>>,
}

/// The lanes of a road, relative to one of them.
#[derive(Debug, Default)]
pub struct Sides {
    /// Lanes in the same direction.
    pub same: BTreeSet<usize>,
    /// Lanes in the opposite direction.
    pub opposite: BTreeSet<usize>,
}

impl BodyLanes {
    /// Lanes of all objects.
    pub fn new(road: &Road, bodies: &[Body]) -> Self {
        let places: Vec<Vec<Option<LanePlace>>> = bodies.iter().map(|b| places(road, b)).collect();
        let lane = |(b, places): (&Body, &Vec<Option<LanePlace>>)| {
            let of = |i: usize| places[i].map(|p| p.lane).or_else(|| lane_under(road, b, i));
            (0..places.len()).map(of).collect()
        };
        let lanes = bodies.iter().zip(&places).map(lane).collect();
        Self { places, lanes, chains: RefCell::default(), sides: RefCell::default() }
    }

    /// The segments that form one lane with this one: straight on over joints, forward and backward.
    pub fn chain(&self, road: &Road, lane: usize) -> Rc<BTreeSet<usize>> {
        if let Some(done) = self.chains.borrow().get(&lane) {
            return done.clone();
        }
        let chain = Rc::new(chain(road, lane));
        self.chains.borrow_mut().insert(lane, chain.clone());
        chain
    }

    /// Both sides of the road of a lane.
    pub fn sides(&self, road: &Road, lane: usize) -> Rc<Sides> {
        if let Some(done) = self.sides.borrow().get(&lane) {
            return done.clone();
        }
        let same = self.beside(road, lane);
        let opposite = same.iter().find_map(|l| opposite_of(road, *l));
        let opposite = opposite.map(|l| self.beside(road, l)).unwrap_or_default();
        let sides = Rc::new(Sides { same, opposite });
        self.sides.borrow_mut().insert(lane, sides.clone());
        sides
    }

    /// The adjacent lanes of the same direction, with the segments that continue them.
    fn beside(&self, road: &Road, lane: usize) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        let mut todo = vec![lane];
        while let Some(lane) = todo.pop() {
            for segment in self.chain(road, lane).iter().copied() {
                if found.insert(segment) {
                    todo.extend(road.lanes[segment].neighbors.into_iter().flatten());
                }
            }
        }
        found
    }
}

fn places(road: &Road, body: &Body) -> Vec<Option<LanePlace>> {
    let tether = match body.class {
        _ if body.track.is_none() => Tether::EGO,
        class if class.is_vehicle() => Tether::VEHICLE,
        class if drives(class) => Tether::BICYCLE,
        _ => return vec![None; body.position.len()],
    };
    let rows: Vec<(P2, f64, f64)> =
        (0..body.position.len()).map(|i| (body.position[i], body.z[i], body.heading[i])).collect();
    assign(road, &rows, tether)
}

/// The lane under the center; of several (in junctions they overlap) the one whose center line is nearest.
fn lane_under(road: &Road, body: &Body, i: usize) -> Option<usize> {
    let p = body.position[i];
    if !p.is_finite() {
        return None;
    }
    let holds = |lane: &LaneShape| {
        lane.kind != LaneKind::Sidewalk
            && lane.on_level(body.z[i])
            && lane.area.as_ref().is_some_and(|a| a.contains(p))
    };
    let under = road.lanes_near(p, 0.0).into_iter().filter(|l| holds(&road.lanes[*l]));
    let away = |l: usize| road.lanes[l].center.distance(p);
    under.min_by(|a, b| away(*a).total_cmp(&away(*b)))
}

fn ends(lane: &LaneShape) -> (f64, f64) {
    (lane.center.smooth_heading_at(0.0, 1.0), lane.center.smooth_heading_at(lane.center.length(), 1.0))
}

fn is_turn(lane: &LaneShape) -> bool {
    let (from, to) = ends(lane);
    lane.in_junction && wrap(to - from).abs() > TURN_RAD
}

fn chain(road: &Road, lane: usize) -> BTreeSet<usize> {
    let mut found = BTreeSet::from([lane]);
    if is_turn(&road.lanes[lane]) {
        return found;
    }
    let next = |l: usize, forward: bool| {
        let own = &road.lanes[l];
        let candidates = if forward { &own.successors } else { &own.predecessors };
        let bend = |other: usize| {
            let (a, b) = if forward { (l, other) } else { (other, l) };
            wrap(ends(&road.lanes[b]).0 - ends(&road.lanes[a]).1).abs()
                + wrap(ends(&road.lanes[other]).1 - ends(&road.lanes[other]).0).abs()
        };
        let straight = candidates.iter().copied().filter(|c| !is_turn(&road.lanes[*c]));
        straight.min_by(|a, b| bend(*a).total_cmp(&bend(*b)))
    };
    for forward in [true, false] {
        let mut at = lane;
        for _ in 0..MOST_SEGMENTS {
            match next(at, forward) {
                Some(l) if found.insert(l) => at = l,
                _ => break,
            }
        }
    }
    found
}

/// A lane of the opposite direction beside this one: beyond the edge that has no neighbor of the same direction.
fn opposite_of(road: &Road, lane: usize) -> Option<usize> {
    let own = &road.lanes[lane];
    if own.in_junction {
        return None;
    }
    let middle = own.center.length() / 2.0;
    let heading = own.center.smooth_heading_at(middle, 1.0);
    let (left, right) = own.widths_at(middle);
    let across = P2::from_heading(heading).left();
    [(0, left), (1, -right)].into_iter().filter(|(side, _)| own.neighbors[*side].is_none()).find_map(
        |(_, edge)| {
            let outward = edge.signum();
            let mut beyond = 0.5;
            while beyond <= MEDIAN_M {
                let p = own.center.point_at(middle) + across * (edge + outward * beyond);
                let against = road.lanes_near(p, 0.0).into_iter().find(|l| {
                    let other = &road.lanes[*l];
                    let at = other.center.project(p);
                    let turned = wrap(other.center.smooth_heading_at(at.s, 1.0) - heading).abs();
                    other.kind != LaneKind::Sidewalk
                        && !other.in_junction
                        && turned > AGAINST_RAD
                        && other.area.as_ref().is_some_and(|a| a.contains(p))
                });
                if against.is_some() {
                    return against;
                }
                beyond += 0.5;
            }
            None
        },
    )
}
