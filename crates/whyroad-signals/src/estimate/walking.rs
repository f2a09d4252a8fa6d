//! Headings of people and animals in a log that states none, from their estimated motion: they may move any way, and
//! head where they go. Who stands heads where they went before; who has not gone yet has no heading.

use super::kinematics;
use super::smoother::Deviations;
use std::borrow::Cow;
use std::f64::consts::PI;
use whyroad_model::scene::{Motion, Track};
use whyroad_model::{Drive, ObjectClass};

/// Slower, nobody is known to go where they head, m/s.
const WALKS_MPS: f64 = 0.3;

fn may_go_any_way(class: ObjectClass) -> bool {
    matches!(class, ObjectClass::Pedestrian | ObjectClass::WheeledPedestrian | ObjectClass::Animal)
}

fn lacks_heading(track: &Track) -> bool {
    may_go_any_way(track.class) && !track.motion.heading.iter().any(|h| h.is_finite())
}

/// Adds these headings, with what follows from them; `deviations` are those of the tracks, `seconds` the times of the
/// frames.
pub(super) fn add_headings(
    drive: &mut Cow<'_, Drive>,
    deviations: &mut [Option<Deviations>],
    seconds: &[f64],
) {
    if !drive.tracks.iter().any(lacks_heading) {
        return;
    }
    for (track, sd) in drive.to_mut().tracks.iter_mut().zip(deviations) {
        if !lacks_heading(track) {
            continue;
        }
        let spread = head_along(&mut track.motion, sd.as_ref().map_or(&[], |sd| &sd.speed));
        if let Some(sd) = sd {
            sd.heading = spread;
        }
        let own: Vec<f64> = track.frames.iter().map(|&f| seconds[f as usize]).collect();
        let m = &mut track.motion;
        let accel = kinematics::acceleration(&own, &m.vx, &m.vy, &m.heading);
        let yaw_rate = kinematics::derive(&own, &m.x, &m.y, &m.heading, |_| false).yaw_rate;
        super::fill(&mut m.accel, &accel);
        super::fill(&mut m.yaw_rate, &yaw_rate);
    }
}

/// Sets the headings of `m` to the direction of its velocity. Returns their standard deviations, rad, from those of its
/// speed, m/s, where these are known.
fn head_along(m: &mut Motion, speed_sd: &[f64]) -> Vec<f64> {
    let mut last = (f64::NAN, f64::NAN);
    let mut spread = Vec::with_capacity(m.len());
    for i in 0..m.len() {
        let speed = m.speed(i);
        if speed >= WALKS_MPS {
            let sd = speed_sd.get(i).map_or(f64::NAN, |sd| (sd / speed).min(PI));
            last = (m.vy[i].atan2(m.vx[i]), sd);
        }
        m.heading[i] = last.0;
        spread.push(last.1);
    }
    spread
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_goes_heads_there_and_who_stands_heads_where_it_went() {
        let mut m =
            Motion { vx: vec![0.0, 0.0, 0.1, 0.0], vy: vec![0.0, 2.0, 0.0, -1.0], ..Motion::unknown(4) };
        let spread = head_along(&mut m, &[0.1; 4]);
        let quarter = std::f64::consts::FRAC_PI_2;
        assert!(m.heading[0].is_nan() && m.heading[1..] == [quarter, quarter, -quarter], "{m:?}");
        // 0.1 m/s across 2 m/s, which stays while it stands, and across 1 m/s.
        assert!(spread[0].is_nan() && spread[1..] == [0.05, 0.05, 0.1], "{spread:?}");
    }
}
