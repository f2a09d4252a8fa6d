//! Stated accelerations and yaw rates of the ego against the changes of its speed and heading: the wrong sign, or
//! another unit.
//!
//! Decided over the whole drive: the first seconds may have neither a brake nor a bend. That a source counts to the
//! other side says nothing about what happens later in the drive.

use super::{FIRST_FRAMES, agreement, warning};
use crate::assemble::angles::wrap_angle;
use crate::assemble::frames::median;
use whyroad_model::scene::{Drive, Motion};
use whyroad_model::{Bilingual, Diagnostic};

/// Changes are taken over this time, s.
const SPAN_S: f64 = 1.0;
/// Fewer changes are no evidence.
const LEAST: usize = 20;
/// Only clear changes: noise of positions of 0.2 m is 0.6 m/s2.
const CLEAR_MPS2: f64 = 1.2;
/// The same of turns: 6 degrees a second.
const CLEAR_RADPS: f64 = 0.1;
/// A median ratio of what is stated to what is shown outside of this is another sign or unit. Accelerometers on slopes
/// and filters stay inside.
const RATIO: std::ops::RangeInclusive<f64> = 0.25..=4.0;

/// Sets accelerations and yaw rates that the speeds and headings contradict to unknown.
pub(super) fn check(drive: &mut Drive) -> Vec<Diagnostic> {
    let Some(start) = drive.times.first().copied() else { return Vec::new() };
    let seconds: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(start)).collect();
    let Some(ego) = &mut drive.ego else { return Vec::new() };
    let bus = &ego.bus.speed_mps;
    let m = &mut ego.motion;
    let mut out = Vec::new();
    let speeds: Vec<f64> = (0..m.len()).map(|i| speed(m, &seconds, bus, i)).collect();
    let accel = ratio(&m.accel, &seconds, CLEAR_MPS2, |a, b| speeds[b] - speeds[a]);
    if let Some(ratio) = accel {
        m.accel.fill(f64::NAN);
        out.push(accelerations(ratio));
    }
    let headings = &m.heading;
    let turning = ratio(&m.yaw_rate, &seconds, CLEAR_RADPS, |a, b| wrap_angle(headings[b] - headings[a]));
    if let Some(ratio) = turning {
        m.yaw_rate.fill(f64::NAN);
        out.push(yaw_rates(ratio));
    } else {
        out.extend(agreement::turning(m, &seconds[..seconds.len().min(FIRST_FRAMES)]));
    }
    out
}

/// Speed along the heading, m/s: as stated, else as the positions show it, else that of the bus.
fn speed(m: &Motion, seconds: &[f64], bus: &[f64], i: usize) -> f64 {
    let shown = || {
        let (from, to) = (i.saturating_sub(2), (i + 2).min(m.len() - 1));
        let (sin, cos) = m.heading[i].sin_cos();
        ((m.x[to] - m.x[from]) * cos + (m.y[to] - m.y[from]) * sin) / (seconds[to] - seconds[from])
    };
    let stated = [m.forward_speed(i), m.forward.get(i).copied().unwrap_or(f64::NAN), shown()];
    let bus = bus.get(i).copied().unwrap_or(f64::NAN);
    stated.into_iter().find(|v| v.is_finite()).unwrap_or(bus)
}

/// The median ratio of stated rates to clear changes, where it is none of the same sign and unit.
fn ratio(stated: &[f64], seconds: &[f64], clear: f64, change: impl Fn(usize, usize) -> f64) -> Option<f64> {
    let mut ratios = Vec::new();
    let mut end = 0;
    for i in 0..stated.len().min(seconds.len()) {
        while end < seconds.len() && seconds[end] < seconds[i] + SPAN_S - 1e-3 {
            end += 1;
        }
        if end >= seconds.len().min(stated.len()) {
            break;
        }
        let took = seconds[end] - seconds[i];
        let shown = change(i, end) / took;
        let mean = stated[i..=end].iter().sum::<f64>() / (end - i + 1) as f64;
        // A comparison with what is not known is false.
        if took <= 2.0 * SPAN_S && shown.abs() >= clear && mean.is_finite() {
            ratios.push(mean / shown);
        }
    }
    (ratios.len() >= LEAST).then(|| median(&ratios)).filter(|r| !RATIO.contains(r))
}

fn accelerations(ratio: f64) -> Diagnostic {
    let d = warning(
        "ingest.accel.contradicts",
        format!("自车的加速度与速度变化矛盾：为其 {ratio:.2} 倍（中位数）；加速度记为未知，改由速度估计"),
        format!(
            "the accelerations of the ego contradict the changes of its speed: they are {ratio:.2} times these (median); they \
             are set to unknown and estimated from the speeds"
        ),
    );
    d.with_hint(if (-1.5..-0.5).contains(&ratio) {
        Bilingual::new(
            "正负相反：沿航向加速为正，制动为负",
            "the sign is the other one: speeding up along the heading is positive, braking negative",
        )
    } else {
        Bilingual::new(
            "检查加速度的单位（m/s2；1 g 为 9.81 m/s2）与坐标轴（沿航向）",
            "check the unit of accelerations (m/s2; 1 g is 9.81 m/s2) and their axis (along the heading)",
        )
    })
}

fn yaw_rates(ratio: f64) -> Diagnostic {
    let d = warning(
        "ingest.yaw_rate.contradicts",
        format!(
            "自车的横摆角速度与航向变化矛盾：为其 {ratio:.2} 倍（中位数）；横摆角速度记为未知，改由航向估计"
        ),
        format!(
            "the yaw rates of the ego contradict the changes of its heading: they are {ratio:.2} times these (median); they \
             are set to unknown and estimated from the headings"
        ),
    );
    d.with_hint(if (-1.5..-0.5).contains(&ratio) {
        Bilingual::new("正负相反：左转（逆时针）为正", "the sign is the other one: turning left is positive")
    } else {
        Bilingual::new(
            "检查横摆角速度的单位（rad/s）：由度每秒换算时乘以 pi/180",
            "check the unit of yaw rates (rad/s): multiply those in degrees per second by pi/180",
        )
    })
}
