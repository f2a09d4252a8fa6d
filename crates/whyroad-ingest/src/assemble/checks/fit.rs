//! Where vehicles drive and the center lines of lanes beside them: what the checks of a map's place compare.

use crate::assemble::geometry::Bounds;
use whyroad_model::road_map::{LaneKind, Point3};
use whyroad_model::scene::{Drive, Motion};
use whyroad_model::{ObjectClass, RoadMap};

/// A direction of motion is taken over this time, s, of those who move at this speed, m/s.
const SPAN_S: f64 = 0.5;
const MOVING_MPS: f64 = 3.0;
/// One position of a vehicle per this time, s, and at most this many of a vehicle.
const EVERY_S: f64 = 1.0;
const PER_VEHICLE: usize = 20;
/// Fewer positions are no evidence.
pub(super) const LEAST: usize = 25;

/// The center line of a lane, and where it lies.
pub(super) type LaneLine<'m> = (&'m [Point3], Bounds);

/// Where the vehicles drive, of each; `None` where there is too little.
pub(super) fn moments(drive: &Drive) -> Option<Vec<Vec<Moment>>> {
    let start = *drive.times.first()?;
    let seconds: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(start)).collect();
    let ego = drive.ego.iter().map(|e| driven(&e.motion, &seconds));
    let others = drive.tracks.iter().filter(|t| drives_in_lanes(t.class)).map(|t| {
        let times: Vec<f64> =
            t.frames.iter().map(|&f| seconds.get(f as usize).copied().unwrap_or(f64::NAN)).collect();
        driven(&t.motion, &times)
    });
    let vehicles: Vec<Vec<Moment>> = ego.chain(others).filter(|v| !v.is_empty()).collect();
    (vehicles.iter().map(Vec::len).sum::<usize>() >= LEAST).then_some(vehicles)
}

/// Lanes that vehicles drive in.
pub(super) fn lanes(map: &RoadMap) -> Vec<LaneLine<'_>> {
    let driven = map.lanes.iter().filter(|l| matches!(l.kind, LaneKind::Vehicle | LaneKind::Bus));
    driven.map(|l| (l.center.as_slice(), Bounds::of(&l.center))).collect()
}

/// Two-wheelers drive anywhere in a lane.
fn drives_in_lanes(class: ObjectClass) -> bool {
    let rides = matches!(class, ObjectClass::Motorcycle | ObjectClass::Motorcyclist | ObjectClass::Tricycle);
    class.is_vehicle() && !rides
}

/// Where a vehicle is and the direction in which it moves.
pub(super) struct Moment {
    pub at: [f64; 2],
    pub unit: [f64; 2],
}

impl Moment {
    /// Calls `each` with start, direction and length of the pieces of lanes within `reach`, m, and some beyond.
    pub fn each_near(
        &self,
        lanes: &[LaneLine<'_>],
        reach: f64,
        each: &mut dyn FnMut([f64; 2], [f64; 2], f64),
    ) {
        let [x, y] = self.at;
        let here = Bounds::of(&[Point3 { x, y, z: 0.0 }]);
        for (line, _) in lanes.iter().filter(|(_, bounds)| !bounds.are_apart(&here, reach)) {
            for w in line.windows(2) {
                let (dx, dy) = (w[1].x - w[0].x, w[1].y - w[0].y);
                let length = dx.hypot(dy);
                if length > 1e-3 {
                    each([w[0].x, w[0].y], [dx / length, dy / length], length);
                }
            }
        }
    }
}

/// Distance from a piece of a line that begins at `start`, m.
pub(super) fn distance_to(at: [f64; 2], start: [f64; 2], unit: [f64; 2], length: f64) -> f64 {
    let (x, y) = (at[0] - start[0], at[1] - start[1]);
    let along = (x * unit[0] + y * unit[1]).clamp(0.0, length);
    (x - along * unit[0]).hypot(y - along * unit[1])
}

/// Moments of a motion whose rows are at these times, s: one in [`EVERY_S`] while it moves.
fn driven(m: &Motion, seconds: &[f64]) -> Vec<Moment> {
    let mut out = Vec::new();
    let (mut end, mut next) = (0, f64::NEG_INFINITY);
    for i in 0..m.len().min(seconds.len()) {
        while end < seconds.len() && seconds[end] < seconds[i] + SPAN_S - 1e-3 {
            end += 1;
        }
        if end >= seconds.len().min(m.len()) || out.len() >= PER_VEHICLE {
            break;
        }
        let took = seconds[end] - seconds[i];
        let (dx, dy) = (m.x[end] - m.x[i], m.y[end] - m.y[i]);
        let length = dx.hypot(dy);
        // A comparison with what is not known is false.
        let moves = took <= 2.0 * SPAN_S && length >= MOVING_MPS * took && length > 0.0;
        if seconds[i] >= next && moves {
            let at = [f64::midpoint(m.x[i], m.x[end]), f64::midpoint(m.y[i], m.y[end])];
            out.push(Moment { at, unit: [dx / length, dy / length] });
            next = seconds[i] + EVERY_S;
        }
    }
    out
}
