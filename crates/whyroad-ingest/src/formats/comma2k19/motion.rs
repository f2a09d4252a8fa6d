//! Camera poses (earth-centered) to the motion of the car's box center in a local frame, at frame times.

use super::recording::Pose;
use crate::assemble::angles::wrap_angle;
use crate::assemble::geodesy::LocalFrame;
use crate::assemble::resample::linear;
use crate::assemble::se3::{rotate, slerp};
use whyroad_model::scene::Motion;

/// Poses come at 20 Hz; across a longer hole nothing is interpolated, s.
const POSE_GAP_S: f64 = 0.25;

/// Toyota RAV4 of 2016 to 2018 (the maker's data sheet): 4.605 m by 1.845 m by 1.675 m. The data set's Civic is 4.63 m
/// by 1.80 m, close enough that one box serves for both.
pub(super) const EGO_LENGTH_M: f64 = 4.605;
/// See [`EGO_LENGTH_M`].
pub(super) const EGO_WIDTH_M: f64 = 1.845;
/// See [`EGO_LENGTH_M`].
pub(super) const EGO_HEIGHT_M: f64 = 1.675;
/// The camera is behind the windscreen at about mid-length; where exactly is not published, so nothing is added.
pub(super) const CAMERA_TO_CENTER_M: f64 = 0.0;

/// Motion at `frames` (seconds on the log's clock). Velocity is the data set's own.
pub(super) fn at_frames(pose: &Pose, frames: &[f64]) -> Motion {
    let Some(&origin) = pose.positions.first() else { return Motion::unknown(frames.len()) };
    let local = LocalFrame::at_ecef(origin);
    let column = |values: &[[f64; 3]], i: usize, map: &dyn Fn([f64; 3]) -> [f64; 3]| {
        let v: Vec<f64> = values.iter().map(|&p| map(p)[i]).collect();
        linear(&pose.times, &v, frames, POSE_GAP_S)
    };
    let point = |p| local.point(p);
    let direction = |v| local.direction(v);
    let (x, y, z) = (
        column(&pose.positions, 0, &point),
        column(&pose.positions, 1, &point),
        column(&pose.positions, 2, &point),
    );
    let (vx, vy) = (column(&pose.velocities, 0, &direction), column(&pose.velocities, 1, &direction));
    let heading: Vec<f64> = frames
        .iter()
        .map(|&t| {
            let Some(q) = orientation(pose, t) else { return f64::NAN };
            // The quaternion takes the camera's forward, right, down axes to the Earth's frame (seen in the data:
            // forward turned by it points along the velocity to within 4 degrees, its inverse 30 degrees off).
            let forward = local.direction(rotate(q, [1.0, 0.0, 0.0]));
            wrap_angle(forward[1].atan2(forward[0]))
        })
        .collect();
    Motion { x, y, z, heading, vx, vy, ..Motion::unknown(frames.len()) }
}

/// True when there is a pose at `t`, or poses around it that are near enough.
pub(super) fn covers(pose: &Pose, t: f64) -> bool {
    orientation(pose, t).is_some()
}

fn orientation(pose: &Pose, t: f64) -> Option<[f64; 4]> {
    let next = pose.times.partition_point(|&s| s < t);
    if pose.times.get(next) == Some(&t) {
        return Some(pose.orientations[next]);
    }
    let before = next.checked_sub(1)?;
    let gap = pose.times.get(next)? - pose.times[before];
    (gap <= POSE_GAP_S)
        .then(|| slerp(pose.orientations[before], pose.orientations[next], (t - pose.times[before]) / gap))
}
