//! A rough road surface from the vertical acceleration of the body.

use whyroad_model::Drive;

/// Minimum vertical acceleration of a hole or hump, in contrast to the texture of the road, m/s2: 0.4 g, the threshold
/// of Mednis et al., "Real time pothole detection using Android smartphones with accelerometers" (DCOSS 2011).
const SHOCK_MPS2: f64 = 3.92;
/// Below this speed, doors and loading shake the car as much, m/s.
const DRIVING_MPS: f64 = 2.0;
/// The rough surface lasts until the rear axle is over it: frames after the last shock.
const AFTER_FRAMES: usize = 5;

/// `context.surface`: rough during and just after a shock; unknown elsewhere.
pub(super) fn surface(drive: &Drive) -> Vec<Option<&'static str>> {
    let Some(ego) = drive.ego.as_ref().filter(|e| !e.bus.vertical_accel.is_empty()) else {
        return Vec::new();
    };
    let felt = |i: usize| {
        let driving = ego.motion.speed(i) > DRIVING_MPS;
        driving && ego.bus.vertical_accel[i].abs() >= SHOCK_MPS2
    };
    let mut left = 0;
    (0..drive.times.len())
        .map(|i| {
            left = if felt(i) { AFTER_FRAMES + 1 } else { left };
            let rough = left > 0;
            left = left.saturating_sub(1);
            rough.then_some("rough")
        })
        .collect()
}
