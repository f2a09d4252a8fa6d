//! Latitude and longitude where meters belong: the log states that the ego drives, and its positions hardly change; or
//! other vehicles are where the ego is; or its heading turns further than a car can on the way that the positions show.

use super::{FIRST_FRAMES, MOVING_MPS};
use crate::assemble::angles::wrap_angle;
use crate::assemble::frames::median;
use whyroad_model::scene::{Drive, Ego, Motion};
use whyroad_model::{Bilingual, Diagnostic};

/// A degree is 111 km: the positions change by less than this share of the stated speed.
const SHARE: f64 = 1e-3;
/// Fewer rows in motion are no evidence.
const LEAST: usize = 10;
const MOST_DEGREES: f64 = 180.0;
const MOST_LATITUDE: f64 = 90.0;
/// Centers of two vehicles are further apart, m; as degrees this is some kilometers, as far as objects are seen.
const IN_ONE_PLACE: f64 = 0.1;
/// Vehicles that are so near to the ego in all rows, other than the ego among the objects.
const LEAST_VEHICLES: usize = 2;
/// A heading that turns by this, rad, takes a car several meters: the tightest turning circles have a radius of 4 m.
const TURN_RAD: f64 = 0.3;
/// The positions follow the heading within this, rad: a car at rest whose heading drifts does not move along it. East
/// and north are not equally long in degrees, which turns the course by up to this at 60 degrees of latitude.
const ALONG_RAD: f64 = 0.7;

/// Sets positions in degrees to unknown.
pub(super) fn positions(drive: &mut Drive) -> Option<Diagnostic> {
    let start = *drive.times.first()?;
    let ego = drive.ego.as_ref()?;
    let m = &stated_positions(ego);
    let n = m.len().min(FIRST_FRAMES);
    let stated = |i: usize| {
        let along = m.forward.get(i).copied().unwrap_or(f64::NAN);
        [m.speed(i), along, ego.bus.speed_mps.get(i).copied().unwrap_or(f64::NAN)]
            .into_iter()
            .find(|v| v.is_finite())
            .map(f64::abs)
    };
    let shares: Vec<f64> = (1..n)
        .filter_map(|i| {
            let speed = stated(i).filter(|v| *v > MOVING_MPS)?;
            let dt = drive.times[i].seconds_since(start) - drive.times[i - 1].seconds_since(start);
            let shown = (m.x[i] - m.x[i - 1]).hypot(m.y[i] - m.y[i - 1]) / dt;
            shown.is_finite().then_some(shown / speed)
        })
        .collect();
    let in_degrees =
        |m: &Motion| (0..m.len()).all(|i| !(m.x[i].abs() > MOST_DEGREES || m.y[i].abs() > MOST_DEGREES));
    // A receiver that repeats its last position is another fault.
    let moves = shares.iter().any(|s| *s > 0.0);
    let is_slower = shares.len() >= LEAST && moves && median(&shares) < SHARE;
    if !in_degrees(m) || !(is_slower || are_in_one_place(drive, m) || turns_on_the_spot(m)) {
        return None;
    }
    let motions =
        drive.ego.iter_mut().map(|e| &mut e.motion).chain(drive.tracks.iter_mut().map(|t| &mut t.motion));
    for m in motions {
        m.x.fill(f64::NAN);
        m.y.fill(f64::NAN);
    }
    Some(
        Diagnostic::error(
            "ingest.position.degrees",
            Bilingual::new(
                "自车在行驶（或转向，或其他车辆与之重叠），而位置几乎不变：位置像是经纬度（度），不是米；位置记为未知",
                "the ego drives, turns or overlaps with all other vehicles, and its positions hardly change: they seem to be \
                 degrees, not meters; positions are set to unknown",
            ),
        )
        .with_hint(Bilingual::new(
            "把经纬度投影为以米为单位的平面坐标（例如 UTM）后重新导入",
            "project latitude and longitude to a plane in meters (UTM, for example) and ingest again",
        )),
    )
}

/// The motion of the ego's reference point, as the log states it: the way from it to the center of the car was added in
/// meters.
fn stated_positions(ego: &Ego) -> Motion {
    let mut m = ego.motion.clone();
    let ahead = if ego.reference_to_centre_m.is_finite() { ego.reference_to_centre_m } else { 0.0 };
    for i in 0..m.len() {
        let (sin, cos) = m.heading[i].sin_cos();
        if sin.is_finite() {
            m.x[i] -= ahead * cos;
            m.y[i] -= ahead * sin;
        }
    }
    m
}

/// True where all vehicles are always in the place of the ego, which moves.
fn are_in_one_place(drive: &Drive, ego: &Motion) -> bool {
    let is_latitude = |m: &Motion| m.y.iter().all(|y| y.is_nan() || y.abs() <= MOST_LATITUDE);
    let (mut rows, mut vehicles) = (0, 0);
    for track in drive.tracks.iter().filter(|t| t.class.is_vehicle()) {
        let m = &track.motion;
        let apart = |(i, &frame): (usize, &u32)| {
            let frame = frame as usize;
            (m.x[i] - ego.x[frame]).hypot(m.y[i] - ego.y[frame])
        };
        let known: Vec<f64> = track.frames.iter().enumerate().map(apart).filter(|d| d.is_finite()).collect();
        if known.iter().any(|d| *d > IN_ONE_PLACE) || !is_latitude(m) {
            return false;
        }
        rows += known.len();
        vehicles += usize::from(!known.is_empty());
    }
    rows >= LEAST && vehicles >= LEAST_VEHICLES && is_latitude(ego)
}

/// True where the heading turns on less way than any car needs, and the positions follow it.
fn turns_on_the_spot(m: &Motion) -> bool {
    let known: Vec<usize> = (0..m.len())
        .filter(|&i| m.x[i].is_finite() && m.y[i].is_finite() && m.heading[i].is_finite())
        .collect();
    let (mut turned, mut way, mut aside) = (0.0, 0.0, Vec::new());
    for (&i, &k) in known.iter().zip(known.iter().skip(1)) {
        let (dx, dy) = (m.x[k] - m.x[i], m.y[k] - m.y[i]);
        turned += wrap_angle(m.heading[k] - m.heading[i]);
        way += dx.hypot(dy);
        if dx != 0.0 || dy != 0.0 {
            aside.push(wrap_angle(dy.atan2(dx) - m.heading[i]).abs());
        }
    }
    let is_latitude = m.y.iter().all(|y| y.is_nan() || y.abs() <= MOST_LATITUDE);
    is_latitude
        && turned.abs() >= TURN_RAD
        && way < IN_ONE_PLACE
        && aside.len() >= LEAST
        && aside.iter().filter(|a| **a > ALONG_RAD).count() * 10 < aside.len()
}
