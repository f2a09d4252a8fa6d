//! Latitude and longitude where meters belong: the log states that the ego drives, and its positions hardly change.

use super::{FIRST_FRAMES, MOVING_MPS};
use crate::assemble::frames::median;
use whyroad_model::scene::{Drive, Motion};
use whyroad_model::{Bilingual, Diagnostic};

/// A degree is 111 km: the positions change by less than this share of the stated speed.
const SHARE: f64 = 1e-3;
/// Fewer rows in motion are no evidence.
const LEAST: usize = 10;
const MOST_DEGREES: f64 = 180.0;

/// Sets positions in degrees to unknown.
pub(super) fn positions(drive: &mut Drive) -> Option<Diagnostic> {
    let start = *drive.times.first()?;
    let ego = drive.ego.as_ref()?;
    let m = &ego.motion;
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
    if shares.len() < LEAST || !moves || median(&shares) >= SHARE || !in_degrees(m) {
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
                "自车在行驶，而位置几乎不变：位置像是经纬度（度），不是米；位置记为未知",
                "the ego drives and its positions hardly change: they seem to be degrees, not meters; positions are set \
                 to unknown",
            ),
        )
        .with_hint(Bilingual::new(
            "把经纬度投影为以米为单位的平面坐标（例如 UTM）后重新导入",
            "project latitude and longitude to a plane in meters (UTM, for example) and ingest again",
        )),
    )
}
