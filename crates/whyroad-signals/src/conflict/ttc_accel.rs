//! Time to collision when both keep their current accelerations: along the path, and of the boxes. A braking road user
//! stops and stays stopped. At equal accelerations the path's time is `target.ttc`.

use crate::conflict::ttc::ttc;
use crate::ego::motion::EgoMotion;
use crate::geometry::{OrientedBox, P2, wrap};
use crate::table::TableBuilder;
use crate::target::approach::{Course, along, course_of};
use crate::target::interaction::Interaction;
use crate::target::placement::{Placement, Surroundings};
use crate::target::rows::Rows;
use whyroad_model::ObjectClass;
use whyroad_model::catalog::id;

/// Accelerations that differ by at most this are equal, m/s2 (CriMe TTC).
const EQUAL_MPS2: f64 = 0.1;
/// Maximum time to contact, s: no acceleration lasts as long.
const HORIZON_S: f64 = 30.0;
/// The same for boxes, s.
const BOX_HORIZON_S: f64 = 10.0;
/// Boxes nearer than this touch, m.
const TOUCH_M: f64 = 0.01;
/// Minimum time between two checks of the boxes, s: it can only hide a contact of centimeters.
const LEAST_STEP_S: f64 = 0.02;

/// Motion along a line: speed m/s and acceleration m/s2; it ends where the speed reaches zero.
#[derive(Clone, Copy, Debug)]
struct Line {
    speed: f64,
    accel: f64,
}

impl Line {
    /// Time until the speed is zero, s; infinite when the acceleration increases it.
    fn stops_after(self) -> f64 {
        if self.speed * self.accel < 0.0 { -self.speed / self.accel } else { f64::INFINITY }
    }

    /// Distance covered after `t` seconds, m.
    fn covered(self, t: f64) -> f64 {
        let t = t.min(self.stops_after());
        self.speed * t + self.accel * t * t / 2.0
    }

    /// Speed and acceleration after `t` seconds.
    fn after(self, t: f64) -> Line {
        if t >= self.stops_after() {
            return Line { speed: 0.0, accel: 0.0 };
        }
        Line { speed: self.speed + self.accel * t, accel: self.accel }
    }

    /// The maximum speed within `t` seconds, without sign, m/s.
    fn fastest(self, t: f64) -> f64 {
        self.speed.abs().max(self.after(t).speed.abs())
    }
}

/// First time at which `behind` has gained `gap` meters on `ahead`, s; infinite beyond the horizon.
fn time_to_close(gap: f64, behind: Line, ahead: Line) -> f64 {
    let mut borders = [0.0, behind.stops_after(), ahead.stops_after(), HORIZON_S];
    borders.sort_by(f64::total_cmp);
    for pair in borders.windows(2) {
        let (from, to) = (pair[0], pair[1].min(HORIZON_S));
        if to <= from {
            continue;
        }
        let left = gap + ahead.covered(from) - behind.covered(from);
        let (b, a) = (behind.after(from), ahead.after(from));
        if let Some(t) = first_root(left, b.speed - a.speed, b.accel - a.accel)
            && from + t <= to + 1e-9
        {
            return from + t;
        }
    }
    f64::INFINITY
}

/// Least `t >= 0` with `gain t + more t^2 / 2 = gap`.
fn first_root(gap: f64, gain: f64, more: f64) -> Option<f64> {
    if more.abs() < 1e-9 {
        return (gain > 1e-9).then(|| gap / gain);
    }
    let inside = gain * gain + 2.0 * more * gap;
    if inside < 0.0 {
        return None;
    }
    let root = inside.sqrt();
    let (t1, t2) = ((-gain - root) / more, (-gain + root) / more);
    [t1.min(t2), t1.max(t2)].into_iter().find(|t| *t >= 0.0)
}

/// Acceleration of a target along the ego's path at its position, m/s2; 0 for a target that moves across it.
pub fn accel_along(p: &Placement, accel: f64) -> f64 {
    if course_of(p) == Course::Across {
        0.0
    } else {
        accel * wrap(p.footprint.heading - p.path.heading).cos()
    }
}

/// TTC along the path with both accelerations, s.
fn along_path(p: &Placement, accel: f64, around: &Surroundings<'_>) -> f64 {
    let ego = around.ego;
    let gap = p.approach.gap;
    if gap.is_nan() || gap.is_infinite() {
        return gap;
    }
    if gap <= 0.0 {
        return 0.0;
    }
    let own = Line { speed: ego.forward_speed[p.frame], accel: ego.accel[p.frame] };
    let theirs = Line { speed: along(p), accel: accel_along(p, accel) };
    if (own.accel - theirs.accel).is_nan() || (own.speed - theirs.speed).is_nan() {
        return f64::NAN;
    }
    if (own.accel - theirs.accel).abs() <= EQUAL_MPS2 {
        return ttc(p.approach);
    }
    let t = time_to_close(gap, own, theirs);
    let meets = t.is_infinite() || course_of(p) == Course::Along || around.meets(p, t);
    if meets { t } else { f64::INFINITY }
}

/// The projection onto an axis of the area that a box sweeps, m.
fn swept(footprint: &OrientedBox, way: P2, axis: P2) -> (f64, f64) {
    let ((low, high), along) = (footprint.shadow(axis), way.dot(axis));
    if along < 0.0 { (low + along, high) } else { (low, high + along) }
}

/// True if the swept areas are separate on some axis, by more than rounding errors.
fn stay_apart(a: &OrientedBox, da: P2, ma: Line, b: &OrientedBox, db: P2, mb: Line) -> bool {
    // The direction never reverses, so the distance is longest at the end.
    let (of_a, of_b) = (da * ma.covered(BOX_HORIZON_S), db * mb.covered(BOX_HORIZON_S));
    [da.left(), db.left(), da, db].into_iter().any(|axis| {
        let (a, b) = (swept(a, of_a, axis), swept(b, of_b, axis));
        a.1 + 2.0 * TOUCH_M < b.0 || b.1 + 2.0 * TOUCH_M < a.0
    })
}

/// First contact of two boxes that move along straight lines, s. The step is the minimum time in which they can come
/// into contact.
fn contact(a: &OrientedBox, da: P2, ma: Line, b: &OrientedBox, db: P2, mb: Line) -> f64 {
    if stay_apart(a, da, ma, b, db, mb) {
        return f64::INFINITY;
    }
    let fastest = ma.fastest(BOX_HORIZON_S) + mb.fastest(BOX_HORIZON_S);
    let around = a.radius() + b.radius();
    let mut t = 0.0;
    while t <= BOX_HORIZON_S {
        let at = |c: P2, direction: P2, line: Line| c + direction * line.covered(t);
        let (x, y) = (a.moved_to(at(a.center, da, ma)), b.moved_to(at(b.center, db, mb)));
        // Circles first: they are sufficient for boxes that are far apart.
        let circles = (x.center - y.center).norm() - around;
        let apart = if circles > 1.0 { circles } else { x.distance(&y) };
        if apart <= TOUCH_M {
            return t;
        }
        if fastest <= 1e-6 {
            break;
        }
        t += (apart / fastest).max(LEAST_STEP_S);
    }
    f64::INFINITY
}

/// TTC of the boxes with both accelerations, s.
fn boxes(p: &Placement, class: ObjectClass, accel: f64, ego: &EgoMotion) -> f64 {
    let own = Line { speed: ego.forward_speed[p.frame], accel: ego.accel[p.frame] };
    if !p.is_sized() || (own.speed + own.accel + p.velocity.x + p.velocity.y + accel).is_nan() {
        return f64::NAN;
    }
    if !p.same_level || !p.within_reach() {
        return f64::INFINITY;
    }
    // Vehicles move in the direction of their heading; pedestrians may face another direction.
    let forward = p.footprint.direction();
    let (direction, speed) = if class.is_vehicle() || p.speed() < 1e-6 {
        (forward, p.velocity.dot(forward))
    } else {
        (p.velocity * (1.0 / p.speed()), p.speed())
    };
    let theirs = Line { speed, accel };
    let footprint = ego.footprint(p.frame);
    contact(&footprint, footprint.direction(), own, &p.footprint, direction, theirs)
}

/// Writes `target.ttc_accel`, `ttc_box_accel`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let rows = Rows::new(scene.drive, table);
    let targets = scene.targets;
    let [path, both] = rows.placed_columns(targets, |k, r, p| {
        let accel = targets[k].accel[r];
        let of_boxes = boxes(p, targets[k].track.class, accel, scene.around.ego);
        [along_path(p, accel, scene.around), of_boxes]
    });
    table.number(id::TARGET_TTC_ACCEL, path);
    table.number(id::TARGET_TTC_BOX_ACCEL, both);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(speed: f64, accel: f64) -> Line {
        Line { speed, accel }
    }

    #[test]
    fn closing_times_by_hand() {
        // 20 m, 10 m/s faster, lead brakes at 4: 10 t + 2 t^2 = 20, t = (-10 + sqrt 260) / 4 = 1.5311 s.
        let t = time_to_close(20.0, line(20.0, 0.0), line(10.0, -4.0));
        assert!((t - (260.0_f64.sqrt() - 10.0) / 4.0).abs() < 1e-9);
        // The lead at 4 m/s brakes at 4 and stops after 1 s and 2 m; 8 m ahead, ego 4 m/s: 10 m at 4 m/s = 2.5 s.
        assert!((time_to_close(8.0, line(4.0, 0.0), line(4.0, -4.0)) - 2.5).abs() < 1e-9);
        // The ego stops after 12.5 m (10 m/s at -4): 13 m give no contact, 12 m do: 10 t - 2 t^2 = 12 at t = 2 s.
        assert_eq!(time_to_close(13.0, line(10.0, -4.0), line(0.0, 0.0)), f64::INFINITY);
        assert!((time_to_close(12.0, line(10.0, -4.0), line(0.0, 0.0)) - 2.0).abs() < 1e-9);
        // It moves away, but will be reached: -2 t + t^2 = 8, t = 4.
        assert!((time_to_close(8.0, line(8.0, 2.0), line(10.0, 0.0)) - 4.0).abs() < 1e-9);
    }

    #[test]
    fn boxes_that_brake_by_hand() {
        let b = |x: f64| OrientedBox::new(P2 { x, y: 0.0 }, 0.0, 4.0, 2.0);
        let forward = P2 { x: 1.0, y: 0.0 };
        // Bumpers 12 m apart, as above: 2 s.
        let t = contact(&b(0.0), forward, line(10.0, -4.0), &b(16.0), forward, line(0.0, 0.0));
        assert!((t - 2.0).abs() < 0.03, "{t}");
        let t = contact(&b(0.0), forward, line(10.0, -4.0), &b(17.0), forward, line(0.0, 0.0));
        assert_eq!(t, f64::INFINITY);
    }

    #[test]
    fn who_stays_apart_has_no_contact() {
        // Compared with small steps through the ten seconds, from all sides.
        let (mut apart, mut met) = (0, 0);
        for k in 0..4000_u32 {
            let turn = |n: u32| f64::from(k * n % 63) * 0.1;
            let a = OrientedBox::new(P2 { x: 0.0, y: 0.0 }, turn(1), 4.7, 1.9);
            let center = P2 { x: f64::from(k % 41) - 20.0, y: f64::from(k % 37) * 0.8 - 14.0 };
            let b = OrientedBox::new(center, turn(5), 4.0, 2.0);
            let (da, db) = (a.direction(), P2::from_heading(turn(11)));
            let (ma, mb) =
                (line(f64::from(k % 13) - 3.0, f64::from(k % 7) - 3.0), line(f64::from(k % 11), -1.0));
            let nearest = (0..=1000_u32).map(|i| {
                let t = f64::from(i) * 0.01;
                a.moved_to(da * ma.covered(t)).distance(&b.moved_to(center + db * mb.covered(t)))
            });
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            if stay_apart(&a, da, ma, &b, db, mb) {
                assert!(nearest > TOUCH_M, "{k} {nearest}");
                apart += 1;
            }
            met += u32::from(nearest <= TOUCH_M);
        }
        assert!(apart > 1000 && met > 400, "{apart} {met}");
    }
}
