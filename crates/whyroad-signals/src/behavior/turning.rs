//! Change of the ego's heading over a steering action: an evasive swerve returns to its original direction, an ordinary
//! turn does not.

use crate::geometry::unwrap;
use crate::series::GAP_S;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use whyroad_model::catalog::id;

/// From this long before ...
const BEFORE_S: f64 = 1.0;
/// ... until this long after, s.
const AFTER_S: f64 = 3.0;
/// Minimum time after it that must be recorded, s.
const LEAST_AFTER_S: f64 = 1.0;

/// Writes `ego.net_turn`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let (ego, times) = (scene.around.ego, scene.times);
    let headings = unwrap(&ego.heading);
    let joined = |a: usize, b: usize| times[b] - times[a] <= GAP_S && headings[a.max(b)].is_finite();
    let net = |i: usize| {
        if !headings[i].is_finite() {
            return f64::NAN;
        }
        let (mut first, mut last) = (i, i);
        while first > 0 && times[i] - times[first - 1] <= BEFORE_S + 0.02 && joined(first - 1, first) {
            if !headings[first - 1].is_finite() {
                break;
            }
            first -= 1;
        }
        while last + 1 < times.len() && times[last + 1] - times[i] <= AFTER_S + 0.02 && joined(last, last + 1)
        {
            last += 1;
        }
        if times[last] - times[i] < LEAST_AFTER_S - 0.02 {
            f64::NAN
        } else {
            headings[last] - headings[first]
        }
    };
    table.number(id::EGO_NET_TURN, (0..ego.len()).map(net).collect());
}
