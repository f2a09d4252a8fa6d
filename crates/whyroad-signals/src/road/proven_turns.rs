//! Turns at junctions that the ego's own way proves where there is no map: a way that is straight, bends by about a
//! right angle as tightly as at the corner of a street, and is straight again. It knows no road: where there is no such
//! turn, nothing is known of junctions.
//!
//! What the way does not tell: a street that itself bends at a right angle on a radius of at most 25 m looks the same.
//! Roundabouts (bends to the other side before and behind), hairpins and U-turns (more than 130 deg), serpentines
//! (bends close to each other), ways through car parks (slow all along) and parking maneuvers (no way behind, or
//! reversing) are left out; so are turns of which the recording shows no straight way before or behind.

use crate::ego::motion::{EgoMotion, STANDSTILL_SET_MPS};
use crate::geometry::unwrap;
use crate::road::junction::movement;
use crate::road::own_turns::{Place, places, runs};
use crate::road::path::DrivenPath;
use crate::table::TableBuilder;
use std::f64::consts::PI;
use std::ops::Range;
use whyroad_model::Tri;
use whyroad_model::catalog::id;

/// Least and greatest angle: a turn by less than 60 deg looks like a bend of the road, by more than 130 deg like a
/// hairpin or a U-turn.
const ANGLE_RAD: (f64, f64) = (PI / 3.0, 130.0 * PI / 180.0);
/// Least angle of the part on a radius of at most 25 m: a bend of a road that is a little tighter once is none.
const TIGHT_RAD: f64 = PI / 6.0;
/// The angle is taken from this far before the tight part to this far behind it, m: drivers steer in and out over some
/// two car's lengths.
const STEERING_M: f64 = 8.0;
/// Before and behind that the way is straight for this distance, m.
const STRAIGHT_M: f64 = 5.0;
/// Straight: headings differ by at most this, 10 deg; the last of steering is in it, and no bend of 25 m radius.
const STRAIGHT_RAD: f64 = PI / 18.0;
/// No bend to the other side within this distance, m: the ring of a roundabout of up to 50 m radius bends by 15 deg on
/// what is left of it.
const AROUND_M: f64 = 30.0;
/// Such a bend, 15 deg: more than a change of lane, or swinging out before the corner.
const OTHER_SIDE_RAD: f64 = PI / 12.0;
/// As near the ego is as fast as this once, m/s: 18 km/h; in car parks it is not.
const STREET_MPS: f64 = 5.0;

/// One turn.
struct ProvenTurn {
    /// Frames from its first to its last place.
    frames: Range<usize>,
    /// To the left positive, rad.
    angle: f64,
}

/// The turns that the way proves, in order.
fn proven_turns(path: &DrivenPath, ego: &EgoMotion) -> Vec<ProvenTurn> {
    let places = places(path, &unwrap(&ego.heading));
    runs(&places).into_iter().filter_map(|run| proven(&places, run, ego)).collect()
}

/// The turn of a part of the way that bends to one side, if it is one at a junction.
fn proven(places: &[Place], (from, to): (usize, usize), ego: &EgoMotion) -> Option<ProvenTurn> {
    let (begins, ends) = (places[from].s, places[to].s);
    let within = |a: f64, b: f64| {
        let first = places.partition_point(|p| p.s < a);
        &places[first..places.partition_point(|p| p.s <= b).max(first)]
    };
    let recorded = |a: f64, b: f64| places[0].s <= a && b <= places[places.len() - 1].s;
    if !recorded(begins - STEERING_M - STRAIGHT_M, ends + STEERING_M + STRAIGHT_M) {
        return None;
    }
    let turning = within(begins - STEERING_M, ends + STEERING_M);
    let angle = turning.last()?.heading - turning.first()?.heading;
    let straight = |a: f64| {
        let (least, greatest) = spread(within(a, a + STRAIGHT_M));
        greatest - least <= STRAIGHT_RAD
    };
    let is_straight = straight(begins - STEERING_M - STRAIGHT_M) && straight(ends + STEERING_M);
    let (before, behind) = (within(begins - AROUND_M, begins), within(ends, ends + AROUND_M));
    // Headings to the side of the turn of where it begins, and to the other side of where it ends.
    let side = angle.signum();
    let other_side = |from: &Place, to: &Place| (from.heading - to.heading) * side > OTHER_SIDE_RAD;
    let swings = before.iter().any(|p| other_side(p, &places[from]))
        || behind.iter().any(|p| other_side(&places[to], p));
    let around = within(begins - AROUND_M, ends + AROUND_M);
    // Until it is beyond: who reverses gets to no further place.
    let beyond = places.iter().find(|p| p.s > ends + AROUND_M).map_or(ego.len(), |p| p.frame);
    let frames = around.first()?.frame..beyond;
    let reverses = ego.forward_speed[frames.clone()].iter().any(|v| *v < -STANDSTILL_SET_MPS);
    let on_a_street = ego.speed[frames].iter().any(|v| *v >= STREET_MPS);
    let tight = (places[to].heading - places[from].heading) * side >= TIGHT_RAD;
    let about_right = (ANGLE_RAD.0..=ANGLE_RAD.1).contains(&angle.abs());
    (tight && about_right && is_straight && !swings && !reverses && on_a_street)
        .then(|| ProvenTurn { frames: places[from].frame..places[to].frame + 1, angle })
}

/// Least and greatest heading of these places, rad.
fn spread(places: &[Place]) -> (f64, f64) {
    let headings = places.iter().map(|p| p.heading);
    headings.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), h| (least.min(h), greatest.max(h)))
}

/// Writes `ego.in_junction`, `movement`, `turn_angle` and `map.distance_to_junction` as far as the ego's way proves
/// them; nothing where it proves no junction.
pub fn write(path: &DrivenPath, ego: &EgoMotion, table: &mut TableBuilder<'_>) {
    let turns = proven_turns(path, ego);
    if turns.is_empty() {
        return;
    }
    let at = |i: usize| turns.iter().find(|turn| turn.frames.contains(&i));
    let frames = || 0..ego.len();
    table.flag(id::EGO_IN_JUNCTION, frames().map(|i| at(i).map_or(Tri::Unknown, |_| Tri::True)).collect());
    table.category(id::EGO_MOVEMENT, frames().map(|i| at(i).and_then(|turn| movement(turn.angle, true))));
    table.number(id::EGO_TURN_ANGLE, frames().map(|i| at(i).map_or(f64::NAN, |turn| turn.angle)).collect());
    table.number(id::MAP_DISTANCE_TO_JUNCTION, frames().map(|i| at(i).map_or(f64::NAN, |_| 0.0)).collect());
    for signal in [
        id::EGO_IN_JUNCTION.id(),
        id::EGO_MOVEMENT.id(),
        id::EGO_TURN_ANGLE.id(),
        id::MAP_DISTANCE_TO_JUNCTION.id(),
    ] {
        table.is_partial(signal);
    }
}
