//! Ramps, merges and splits outside of junctions: where another stream of traffic joins the ego's way, where its lanes
//! split, and the kind of the current lane. From the lanes' links and neighbors; from tags if the source has them.

use crate::road::network::Road;
use crate::road::on_road::{OnRoad, within_horizon};
use crate::road::way::{Way, beside};
use crate::table::TableBuilder;
use std::cell::OnceCell;
use std::collections::BTreeSet;
use whyroad_model::Tri;
use whyroad_model::catalog::{
    id,
    value::{MapFacilityChange, MapMergeZone},
};
use whyroad_model::road_map::LaneKind;

/// Maximum length of an acceleration or deceleration lane, m.
const ZONE_M: f64 = 500.0;
/// Maximum distance from the end of the ego's lane that counts as lane_drop, m.
const DROP_M: f64 = 150.0;
/// Maximum length of a connection between the main road and a ramp, m.
const CONNECTOR_M: f64 = 100.0;
/// The change between ramp and main road is reported for this long before and after it, s.
const CHANGE_S: f64 = 1.0;

fn for_vehicles(road: &Road, lane: usize) -> bool {
    matches!(road.lanes[lane].kind, LaneKind::Vehicle | LaneKind::Bus)
}

/// All lanes of the road that `lane` belongs to, itself first.
fn whole_road(road: &Road, lane: usize) -> Vec<usize> {
    std::iter::once(lane).chain(beside(road, lane)).collect()
}

/// Lanes that lead into step `k` of the way, except the step before and those inside junctions.
fn others_into<'a>(road: &'a Road, way: &'a Way, k: usize) -> impl Iterator<Item = usize> + 'a {
    let own = way.steps[k - 1].lane;
    let lane = way.steps[k].lane;
    let mine = road.lanes[own].in_junction || road.lanes[lane].in_junction;
    let others = road.lanes[lane].predecessors.iter().copied().filter(move |&p| !mine && p != own);
    others.filter(|&p| !road.lanes[p].in_junction && for_vehicles(road, p))
}

/// True when the lanes are adjacent just before they merge: they are neighbors, or the lanes before them are.
fn side_by_side(road: &Road, a: usize, b: usize) -> bool {
    let before = |lane: usize| road.lanes[lane].predecessors.clone();
    beside(road, a).contains(&b)
        || before(a).iter().any(|&p| before(b).iter().any(|&q| p != q && beside(road, p).contains(&q)))
}

/// Lateral shift of the lane to the start of `into`, m.
fn shift(road: &Road, lane: usize, into: usize) -> f64 {
    let start = road.lanes[into].center.point_at(0.0);
    let shift_of = |lane: usize| {
        let line = &road.lanes[lane].center;
        // Relative to the line's own beginning: a lane that bends to end in the other lane is shifted by its width.
        let (origin, heading) = (line.point_at(0.0), line.smooth_heading_at(0.0, 0.5));
        crate::geometry::P2::from_heading(heading).cross(start - origin).abs()
    };
    shift_of(lane)
}

/// True when the lane of step `k` ends by merging with its neighbor, and is the one that yields.
pub fn merges_away(on: &OnRoad<'_>, way: &Way, k: usize) -> bool {
    let (road, own, into) = (on.road, way.steps[k].lane, way.steps[k + 1].lane);
    others_into(road, way, k + 1).any(|other| {
        let tagged = |lane: usize| {
            let before = road.lanes[lane].predecessors.iter().copied();
            before.chain([lane]).any(|l| on.lane(l).is_some_and(|l| l.is_tagged("acceleration")))
        };
        side_by_side(road, own, other)
            && match (tagged(own), tagged(other)) {
                (true, false) => true,
                (false, true) => false,
                _ => shift(road, own, into) > shift(road, other, into) + 0.5,
            }
    })
}

/// Distance from the front bumper to where another lane leads into the way, or where the ego's lane ends.
fn to_merge(on: &OnRoad<'_>, way: &Way, front: f64) -> f64 {
    let joins = |k: &usize| way.steps[*k].hopped || others_into(on.road, way, *k).next().is_some();
    let at = (1..way.steps.len()).filter(|&k| way.steps[k].from >= front).find(joins);
    at.map_or(f64::INFINITY, |k| within_horizon(way.steps[k].from - front))
}

/// True when the lanes of the road at `lane` lead into more than one road.
fn parts(road: &Road, lane: usize) -> bool {
    let next: BTreeSet<usize> = whole_road(road, lane)
        .into_iter()
        .flat_map(|l| road.lanes[l].successors.iter().copied())
        .filter(|&l| for_vehicles(road, l) && !road.lanes[l].in_junction)
        .collect();
    let Some(&first) = next.first() else { return false };
    let same = whole_road(road, first);
    let after = |l: usize| road.lanes[l].successors.iter().copied().collect::<BTreeSet<usize>>();
    let (joined, beyond) = (|l: &usize| same.contains(l), after(first));
    next.iter().any(|l| {
        // Short pieces between two roads are not always stated to be neighbors; the lanes behind them are.
        let meets = after(*l).iter().any(|b| beyond.iter().any(|a| a == b || beside(road, *a).contains(b)));
        !joined(l) && !meets
    })
}

/// `splits` caches the results of [`parts`] by lane.
fn to_split(on: &OnRoad<'_>, splits: &[OnceCell<bool>], way: &Way, front: f64) -> f64 {
    let splits = |k: &usize| {
        let lane = way.steps[*k].lane;
        !on.road.lanes[lane].in_junction && *splits[lane].get_or_init(|| parts(on.road, lane))
    };
    let at = (0..way.steps.len()).filter(|&k| way.steps[k].to >= front).find(splits);
    at.map_or(f64::INFINITY, |k| within_horizon(way.steps[k].to - front))
}

/// True for a short piece whose whole traffic goes to or comes from a ramp: an actor on it has left the main road's
/// lane, or has not reached it yet. An acceleration or deceleration lane is not one, because through lanes are adjacent
/// to it.
fn connects_ramp(road: &Road, lane: usize, is_ramp: impl Fn(usize) -> bool) -> bool {
    let all_ramps = |next: &[usize]| !next.is_empty() && next.iter().all(|&l| is_ramp(l));
    let one_way = |links: fn(&crate::road::network::LaneShape) -> &Vec<usize>| {
        whole_road(road, lane).into_iter().all(|l| all_ramps(links(&road.lanes[l])))
    };
    !road.lanes[lane].in_junction
        && road.lanes[lane].center.length() < CONNECTOR_M
        && (one_way(|l| &l.successors) || one_way(|l| &l.predecessors))
}

/// Role of a lane for traffic that joins or leaves, independent of the ego's position.
#[derive(Clone, Copy, Default)]
struct Role {
    ramp: bool,
    /// Traffic comes from a ramp onto it.
    joined: bool,
    /// It leads to a ramp.
    leaves: bool,
    /// The map states that it is an acceleration lane.
    acceleration: bool,
    deceleration: bool,
}

impl Role {
    fn of(on: &OnRoad<'_>, lane: usize) -> Self {
        let road = on.road;
        let tagged = |l: usize, tag: &str| on.lane(l).is_some_and(|l| l.is_tagged(tag));
        // Also over a short piece between the two roads.
        let near = |links: fn(&crate::road::network::LaneShape) -> &Vec<usize>| -> Vec<usize> {
            let first = links(&road.lanes[lane]);
            first
                .iter()
                .copied()
                .chain(first.iter().flat_map(|&l| links(&road.lanes[l]).iter().copied()))
                .collect()
        };
        let ramp = tagged(lane, "ramp") || connects_ramp(road, lane, |l| tagged(l, "ramp"));
        let through = !ramp && road.lanes[lane].center.length() < ZONE_M;
        Self {
            ramp,
            joined: through && near(|l| &l.predecessors).into_iter().any(|l| tagged(l, "ramp")),
            leaves: through && near(|l| &l.successors).into_iter().any(|l| tagged(l, "ramp")),
            acceleration: tagged(lane, "acceleration"),
            deceleration: tagged(lane, "deceleration"),
        }
    }

    fn weaves(self) -> bool {
        (self.joined || self.acceleration) && (self.leaves || self.deceleration)
    }

    /// It is a weaving lane without a tag for a separate lane.
    fn weaving_only(self) -> bool {
        self.weaves() && !self.aside()
    }

    /// Not a through lane: a ramp, or an acceleration or deceleration lane.
    fn aside(self) -> bool {
        self.ramp || self.acceleration || self.deceleration
    }
}

/// True when the lane begins beside a through lane: no lane leads to it, or the lane that does also leads into the
/// adjacent lane, directly or over a short piece. If no lane leads to the adjacent lanes either, the map begins there.
fn begins_beside(road: &Road, lane: usize) -> bool {
    let next = |l: usize| road.lanes[l].successors.iter().copied();
    let before = |l: usize| road.lanes[l].predecessors.iter().copied();
    let near: Vec<usize> = road.lanes[lane].neighbors.into_iter().flatten().collect();
    let goes_on = |p: usize| {
        let reached = next(p).chain(next(p).flat_map(|l| road.lanes[l].successors.iter().copied()));
        reached.chain(before(p).flat_map(next).flat_map(next)).any(|l| near.contains(&l))
    };
    before(lane).all(goes_on) && near.iter().any(|&l| before(l).next().is_some())
}

/// True when an actor that stays in the lane gets onto a ramp; a lane that may also continue along the main road
/// belongs to the main road.
fn only_leaves(on: &OnRoad<'_>, lane: usize) -> bool {
    let ramp = |l: usize| on.lane(l).is_some_and(|l| l.is_tagged("ramp"));
    let next = |l: usize| on.road.lanes[l].successors.iter().copied();
    next(lane).all(|l| ramp(l) || next(l).any(ramp))
}

fn zone(on: &OnRoad<'_>, roles: &[Role], lane: usize, ends: f64) -> MapMergeZone {
    let role = roles[lane];
    let beside = on.road.lanes[lane].neighbors.into_iter().flatten();
    if on.road.lanes[lane].in_junction || role.ramp {
        MapMergeZone::None
    } else if role.weaves() {
        MapMergeZone::Weaving
    } else if role.acceleration || (role.joined && ends <= ZONE_M && ends.is_finite()) {
        MapMergeZone::Acceleration
    } else if role.deceleration || (role.leaves && only_leaves(on, lane) && begins_beside(on.road, lane)) {
        MapMergeZone::Deceleration
    } else if beside.into_iter().any(|n| roles[n].weaves()) {
        MapMergeZone::Weaving
    } else if ends <= DROP_M {
        MapMergeZone::LaneDrop
    } else {
        MapMergeZone::None
    }
}

/// A merge or split nearer than this may belong to a ramp, m.
const CALM_M: f64 = 30.0;
/// Between two frames with this time difference the ego may pass a merge or split at that distance, s: 30 m at 10 m/s.
const CALM_S: f64 = 3.0;

/// If no data show which lanes are ramps: no change while no other road joins or leaves the ego's road, unknown near
/// places where one does.
fn calm(on: &OnRoad<'_>, merges: &[f64], splits: &[f64]) -> Vec<Option<MapFacilityChange>> {
    let apart: Vec<bool> = merges.iter().zip(splits).map(|(m, s)| *m > CALM_M && *s > CALM_M).collect();
    let around = |i: usize| {
        let from = on.times.partition_point(|t| *t < on.times[i] - CALM_S);
        let to = on.times.partition_point(|t| *t <= on.times[i] + CALM_S);
        apart[from..to].iter().all(|a| *a)
    };
    (0..on.frames()).map(|i| (on.ego.is_known(i) && around(i)).then_some(MapFacilityChange::None)).collect()
}

/// Whether the ego is beside the main road, by frame; unknown in junctions and off the lanes. A weaving lane belongs to
/// the ramp for an ego that comes from a ramp or leaves by one: it joins when it leaves that lane for the main road,
/// leaves when it enters it, and does neither when it drives from ramp to ramp. For an ego that only uses it, it is an
/// ordinary lane.
fn sides(on: &OnRoad<'_>, roles: &[Role]) -> Vec<Option<bool>> {
    let lane_at = |i: usize| on.lanes.at(i).map(|at| at.lane).filter(|&l| !on.road.lanes[l].in_junction);
    let frames: Vec<usize> = (0..on.frames()).filter(|&i| lane_at(i).is_some()).collect();
    let role = |i: usize| lane_at(i).map_or_else(Role::default, |l| roles[l]);
    let mut sides = vec![None; on.frames()];
    let same = |a: &usize, b: &usize| role(*a).weaving_only() == role(*b).weaving_only();
    let runs: Vec<&[usize]> = frames.chunk_by(same).collect();
    for (n, run) in runs.iter().enumerate() {
        let beyond = |other: Option<&&[usize]>, end: fn(&[usize]) -> Option<&usize>| {
            other.and_then(|r| end(r)).is_some_and(|&i| role(i).aside())
        };
        let to_ramp = beyond(n.checked_sub(1).and_then(|b| runs.get(b)), <[usize]>::last)
            || beyond(runs.get(n + 1), <[usize]>::first);
        for &i in *run {
            sides[i] = Some(if role(i).weaving_only() { to_ramp } else { role(i).aside() });
        }
    }
    sides
}

/// Changes between ramp and main road, one value per frame.
fn changes(on: &OnRoad<'_>, roles: &[Role]) -> Vec<Option<MapFacilityChange>> {
    let mut codes: Vec<Option<MapFacilityChange>> =
        (0..on.frames()).map(|i| on.ego.is_known(i).then_some(MapFacilityChange::None)).collect();
    let aside = sides(on, roles);
    let joint = |i: usize| on.lanes.at(i).is_some_and(|at| on.road.lanes[at.lane].in_junction);
    let mut before: Option<(usize, bool)> = None;
    for (i, side) in aside.iter().enumerate() {
        let Some(now) = *side else { continue };
        if let Some((last, was)) = before
            && was != now
        {
            let code = if now { MapFacilityChange::MainToRamp } else { MapFacilityChange::RampToMain };
            // It leaves the main road where a connection to the ramp begins, and has joined it where one from the ramp
            // ends.
            let from = if now && (last + 1..i).all(joint) { last + 1 } else { i };
            let near = |j: &usize| {
                on.times[*j] >= on.times[from] - CHANGE_S - 0.01
                    && on.times[*j] <= on.times[i] + CHANGE_S + 0.01
            };
            (0..on.frames()).filter(near).filter(|&j| on.ego.is_known(j)).for_each(|j| codes[j] = Some(code));
        }
        before = Some((i, now));
    }
    codes
}

/// Writes `map.on_ramp`, `merge_zone`, `distance_to_merge`, `distance_to_split`, `facility_change`.
pub fn write(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    let merges = on.ahead(|_, way, front| to_merge(on, way, front));
    let parting = vec![OnceCell::new(); on.road.lanes.len()];
    let splits = on.ahead(|_, way, front| to_split(on, &parting, way, front));
    let covered = on.map.complete_for.iter().any(|k| k == "ramp")
        || on
            .map
            .lanes
            .iter()
            .any(|l| ["ramp", "acceleration", "deceleration"].iter().any(|t| l.is_tagged(t)));
    let roles: Vec<Role> = (0..on.road.lanes.len()).map(|i| Role::of(on, i)).collect();
    let own = |i: usize| on.lanes.at(i).map(|at| at.lane);
    let ends = on.ahead(|_, way, front| {
        let end = (0..way.steps.len() - 1).find(|&k| way.steps[k + 1].hopped || merges_away(on, way, k));
        end.map_or(f64::INFINITY, |k| (way.steps[k].to - front).max(0.0))
    });
    let zones = (0..on.frames()).map(|i| own(i).map(|lane| zone(on, &roles, lane, ends[i])));
    table.category(id::MAP_MERGE_ZONE, zones);
    if covered {
        table.flag(
            id::MAP_ON_RAMP,
            on.flags(|i| own(i).map_or(Tri::Unknown, |lane| Tri::from(roles[lane].ramp))),
        );
        table.category(id::MAP_FACILITY_CHANGE, changes(on, &roles));
    } else {
        table.category(id::MAP_FACILITY_CHANGE, calm(on, &merges, &splits));
    }
    table.number(id::MAP_DISTANCE_TO_MERGE, merges);
    table.number(id::MAP_DISTANCE_TO_SPLIT, splits);
}
