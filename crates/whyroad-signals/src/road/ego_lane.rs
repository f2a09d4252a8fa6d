//! The ego's lane in each frame with its corridor, and the signals about the ego in it: offset, width, lateral speed,
//! wheel over line, lane count. Left is positive, in driving direction.

use crate::ego::motion::EgoMotion;
use crate::geometry::{OrientedBox, P2, wrap};
use crate::road::corridor::Corridor;
use crate::road::lanes::{LanePlace, Tether, assign};
use crate::road::network::Road;
use crate::table::TableBuilder;
use std::collections::BTreeMap;
use whyroad_model::Tri;
use whyroad_model::catalog::{Number, PerFrame, Signal, id};
use whyroad_model::road_map::LaneKind;

/// Minimum distance of a side over a line, m: boxes and maps are accurate to about a decimeter.
pub const OVER_LINE_M: f64 = 0.1;

/// Minimum distance of a side inside a lane of oncoming traffic at which it uses that lane, m.
const INSIDE_M: f64 = 0.3;
/// Minimum angle between the headings for a lane of oncoming traffic: 120 deg.
const ONCOMING_RAD: f64 = 2.0 * std::f64::consts::FRAC_PI_3;

/// Position of the ego on its lane.
pub struct EgoLane {
    /// By frame; `None` where no lane is assigned.
    pub places: Vec<Option<LanePlace>>,
    corridors: BTreeMap<usize, Corridor>,
}

/// A corridor and a position on it.
#[derive(Clone, Copy)]
pub struct OnCorridor<'a> {
    /// The corridor of the ego's lane.
    pub corridor: &'a Corridor,
    /// Arc length of the ego's center on it, m.
    pub s: f64,
    /// Offset of the ego's center, left positive, m.
    pub lateral: f64,
    /// The lane.
    pub lane: usize,
}

impl EgoLane {
    /// Assigns the ego's lanes over the drive.
    pub fn new(road: &Road, ego: &EgoMotion) -> Self {
        let rows: Vec<(P2, f64, f64)> =
            (0..ego.len()).map(|i| (ego.position[i], ego.z[i], ego.heading[i])).collect();
        let places = assign(road, &rows, Tether::EGO);
        let mut route: Vec<usize> = places.iter().flatten().map(|p| p.lane).collect();
        route.sort_unstable();
        route.dedup();
        let corridors = route.iter().filter_map(|&l| Some((l, Corridor::new(road, l, &route)?))).collect();
        Self { places, corridors }
    }

    /// The ego on its corridor in `frame`.
    pub fn at(&self, frame: usize) -> Option<OnCorridor<'_>> {
        let place = self.places.get(frame)?.as_ref()?;
        let corridor = self.corridors.get(&place.lane)?;
        Some(OnCorridor { corridor, s: corridor.s_of(place), lateral: place.lateral, lane: place.lane })
    }
}

/// Lateral extent `(lowest, highest)` of a box on a corridor near `s`, left positive, m.
pub fn lateral_extent(corridor: &Corridor, footprint: &OrientedBox, s: f64) -> (f64, f64) {
    let radius = footprint.radius();
    let nearby = corridor.line.nearby(s, radius + 3.0, (footprint.center, radius));
    let corners = corridor.line.project_each(footprint.corners(), &nearby);
    corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), on| {
        (low.min(on.lateral), high.max(on.lateral))
    })
}

/// Number of adjacent lanes for vehicles and buses in the direction of `lane`, including itself.
pub fn lane_count(road: &Road, lane: usize) -> f64 {
    let mut count = 1;
    for side in 0..2 {
        let mut at = lane;
        // Bounded: in a map whose neighbors form a ring the loop would not end.
        for _ in 0..16 {
            let Some(next) = road.lanes[at].neighbors[side] else { break };
            at = next;
            if matches!(road.lanes[at].kind, LaneKind::Vehicle | LaneKind::Bus) {
                count += 1;
            }
        }
    }
    f64::from(count)
}

/// True if a corner or the middle of a side of the box is inside a lane of oncoming traffic, outside junctions.
fn in_opposing_lane(road: &Road, footprint: &OrientedBox, z: f64) -> bool {
    let [a, b, c, d] = footprint.corners();
    let points = [a, b, c, d, (a + b) * 0.5, (c + d) * 0.5];
    road.lanes_near(footprint.center, footprint.radius()).into_iter().any(|l| {
        let lane = &road.lanes[l];
        let rolls = matches!(lane.kind, LaneKind::Vehicle | LaneKind::Bus);
        rolls
            && !lane.in_junction
            && lane.on_level(z)
            && points.iter().any(|&p| {
                let at = lane.center.project(p);
                let (left, right) = lane.widths_at(at.s);
                let along = lane.center.smooth_heading_at(at.s, 2.0);
                at.s > 0.0
                    && at.s < lane.center.length()
                    && at.lateral < left - INSIDE_M
                    && at.lateral > INSIDE_M - right
                    && wrap(along - footprint.heading).abs() >= ONCOMING_RAD
            })
    })
}

/// Writes the signals of this family.
pub fn write(lanes: &EgoLane, road: &Road, ego: &EgoMotion, table: &mut TableBuilder<'_>) {
    let n = ego.len();
    let mut number = |id: Signal<PerFrame, Number>, value: &dyn Fn(usize, OnCorridor<'_>) -> f64| {
        table.number(id, (0..n).map(|i| lanes.at(i).map_or(f64::NAN, |on| value(i, on))).collect());
    };
    number(id::EGO_LANE_OFFSET, &|_, on| on.lateral);
    number(id::EGO_LANE_WIDTH, &|_, on| {
        let (left, right) = on.corridor.widths_at(on.s);
        if road.lanes[on.lane].width_is_known { left + right } else { f64::NAN }
    });
    number(id::EGO_LATERAL_SPEED, &|i, on| {
        let across = P2::from_heading(on.corridor.line.smooth_heading_at(on.s, 2.0)).left();
        ego.velocity[i].dot(across)
    });
    number(id::MAP_LANE_COUNT, &|_, on| lane_count(road, on.lane));
    let over = |i: usize| {
        let Some(on) = lanes.at(i) else { return Tri::Unknown };
        if road.lanes[on.lane].in_junction {
            return Tri::False;
        }
        if !ego.length.is_finite() || !ego.width.is_finite() {
            return Tri::Unknown;
        }
        let (low, high) = lateral_extent(on.corridor, &ego.footprint(i), on.s);
        let (left, right) = on.corridor.widths_at(on.s);
        Tri::from(high > left + OVER_LINE_M || low < -right - OVER_LINE_M)
    };
    table.flag(id::EGO_WHEEL_OVER_LINE, (0..n).map(over).collect());
    let opposing = |i: usize| {
        if !ego.is_known(i) || !ego.length.is_finite() || !ego.width.is_finite() {
            return Tri::Unknown;
        }
        Tri::from(in_opposing_lane(road, &ego.footprint(i), ego.z[i]))
    };
    table.flag(id::EGO_IN_OPPOSING_LANE, (0..n).map(opposing).collect());
}
