//! Headings of the ego that turn while it stands: receivers that take the heading from the last two positions, and
//! compasses without a correction. A car needs way to turn; one that stands keeps its heading.

use super::warning;
use crate::assemble::angles::wrap_angle;
use whyroad_model::scene::{Drive, Ego};
use whyroad_model::{Bilingual, Diagnostic};

/// The point of the pose stays within this of where it came to stand, m: errors of a receiver at rest.
const STANDS_M: f64 = 0.2;
/// On that way a car turns by 0.08 rad at most: the rear axle goes round in circles of 2.5 m and more.
const TURNED_RAD: f64 = 0.1;

/// Gives a standing ego the heading with which it came to stand, and puts its middle there.
pub(super) fn check(drive: &mut Drive) -> Option<Diagnostic> {
    let ego = drive.ego.as_mut()?;
    let rows = impossible(ego);
    let n = rows.len();
    for (i, heading) in rows {
        let from = reference(ego, i);
        let (sin, cos) = heading.sin_cos();
        let d = ego.reference_to_centre_m;
        let m = &mut ego.motion;
        m.heading[i] = heading;
        (m.x[i], m.y[i]) = (from[0] + d * cos, from[1] + d * sin);
    }
    let d = warning(
        "ingest.heading.standing",
        format!("自车静止时航向在转动：{n} 行航向不可能，改为停下时的航向"),
        format!(
            "the heading of the ego turns while it stands: {n} headings are impossible and set to the one with which it came \
             to stand"
        ),
    );
    (n > 0).then(|| {
        d.with_hint(Bilingual::new(
            "接收机由相邻两个位置推算航向时会这样：静止时保持上一航向",
            "receivers do so that take the heading from the last two positions: hold the last heading at rest",
        ))
    })
}

/// The point that the source's pose is of, m.
fn reference(ego: &Ego, i: usize) -> [f64; 2] {
    let (m, d) = (&ego.motion, ego.reference_to_centre_m);
    // Unknown where the source states the middle itself.
    let d = if d.is_finite() { d } else { 0.0 };
    let (sin, cos) = m.heading[i].sin_cos();
    [m.x[i] - d * cos, m.y[i] - d * sin]
}

/// The rows, and the heading that they have instead; each decided from earlier ones only.
fn impossible(ego: &Ego) -> Vec<(usize, f64)> {
    let mut out = Vec::new();
    // Where it came to stand, and its heading there.
    let mut stood: Option<([f64; 2], f64)> = None;
    for i in 0..ego.motion.len() {
        let (at, heading) = (reference(ego, i), ego.motion.heading[i]);
        if ![at[0], at[1], heading].iter().all(|v| v.is_finite()) {
            continue;
        }
        match stood {
            Some((from, held)) if (at[0] - from[0]).hypot(at[1] - from[1]) < STANDS_M => {
                if wrap_angle(heading - held).abs() > TURNED_RAD {
                    out.push((i, held));
                }
            }
            _ => stood = Some((at, heading)),
        }
    }
    out
}
