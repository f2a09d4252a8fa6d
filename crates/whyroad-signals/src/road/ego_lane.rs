//! The ego's lane in each frame with its corridor, and the signals about the ego in it: offset, width, lateral
//! speed, wheel over line, lane count. Left is positive, as seen in driving direction.

use crate::ego::motion::EgoMotion;
use crate::geometry::{OrientedBox, P2};
use crate::road::corridor::Corridor;
use crate::road::lanes::{LanePlace, Tether, assign};
use crate::road::network::Road;
use crate::table::TableBuilder;
use std::collections::BTreeMap;
use whyroad_model::Tri;
use whyroad_model::catalogue::{Number, PerFrame, Signal, id};
use whyroad_model::road_map::LaneKind;

/// A side must be this far over a line to count, m: boxes and maps are good to about a decimetre.
pub const OVER_LINE_M: f64 = 0.1;

/// Where the ego is on its lane.
pub struct EgoLane {
    /// By frame; `None` where no lane is assigned.
    pub places: Vec<Option<LanePlace>>,
    corridors: BTreeMap<usize, Corridor>,
}

/// A corridor and a place on it.
#[derive(Clone, Copy)]
pub struct OnCorridor<'a> {
    /// The corridor of the ego's lane.
    pub corridor: &'a Corridor,
    /// Arc length of the ego's centre on it, m.
    pub s: f64,
    /// Offset of the ego's centre, left positive, m.
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
    let reach = footprint.radius() + 3.0;
    footprint.corners().iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &corner| {
        let lateral = corridor.line.project_between(corner, s - reach, s + reach).lateral;
        (low.min(lateral), high.max(lateral))
    })
}

/// Lanes for vehicles and buses beside one another in the direction of `lane`, itself included.
pub fn lane_count(road: &Road, lane: usize) -> f64 {
    let mut count = 1;
    for side in 0..2 {
        let mut at = lane;
        // Bounded: a map whose neighbours form a ring must not hang us.
        for _ in 0..16 {
            let Some(next) = road.lanes[at].neighbours[side] else { break };
            at = next;
            if matches!(road.lanes[at].kind, LaneKind::Vehicle | LaneKind::Bus) {
                count += 1;
            }
        }
    }
    f64::from(count)
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
        left + right
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
}
