//! Lateral movement of an actor by its own steering, independent of the map: lane lines wander, widen and fork where
//! all traffic drives straight on. Measured between two points of its path relative to the mean of its directions
//! there, so that neither a straight path nor one of constant curvature counts as lateral movement.

use crate::geometry::{P2, wrap};

/// A point on an actor's path.
#[derive(Clone, Copy, Debug)]
pub struct OnWay {
    /// m, world.
    pub position: P2,
    /// Direction of motion, rad; not the heading of the box, which points inwards in a bend.
    pub direction: f64,
}

/// Lateral distance of `to` from the path that a constant steering angle gives from `from`, left positive, m; NaN if
/// either is unknown.
pub fn own_shift(from: OnWay, to: OnWay) -> f64 {
    let mean = from.direction + 0.5 * wrap(to.direction - from.direction);
    (to.position - from.position).dot(P2::from_heading(mean).left())
}

/// Maximum movement of an actor towards `sign` (1 left, -1 right) from a point of `before` to one of `after`, never
/// negative, m. Entering or leaving a bend looks like a movement, too, so this only shows that an actor did not move,
/// not that it did.
pub fn most_shifted(before: &[OnWay], after: &[OnWay], sign: f64) -> f64 {
    let pairs = before.iter().flat_map(|&a| after.iter().map(move |&b| sign * own_shift(a, b)));
    pairs.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::p2;

    fn on(x: f64, y: f64, direction: f64) -> OnWay {
        OnWay { position: p2(x, y), direction }
    }

    #[test]
    fn straight_on_and_round_a_bend_nothing_moves_sideways() {
        assert!(
            own_shift(on(0.0, 0.0, 0.3), on(40.0 * 0.3_f64.cos(), 40.0 * 0.3_f64.sin(), 0.3)).abs() < 1e-9
        );
        // A quarter of a circle of 50 m to the left, and across the wrap of the angles.
        assert!(own_shift(on(0.0, 0.0, 0.0), on(50.0, 50.0, std::f64::consts::FRAC_PI_2)).abs() < 1e-9);
        assert!(own_shift(on(0.0, 0.0, 3.0), on(-50.0, 0.0, -3.0)).abs() < 1e-9);
    }

    #[test]
    fn a_lane_change_moves_by_a_lane_to_its_side() {
        assert!((own_shift(on(0.0, 0.0, 0.0), on(60.0, 3.5, 0.0)) - 3.5).abs() < 1e-9);
        assert!((own_shift(on(0.0, 0.0, 0.0), on(60.0, -3.5, 0.0)) + 3.5).abs() < 1e-9);
    }

    #[test]
    fn the_most_of_all_pairs_to_one_side_counts() {
        let before = [on(0.0, 0.0, 0.0), on(10.0, 0.0, 0.0)];
        let after = [on(20.0, 0.1, 0.0), on(40.0, 1.2, 0.0)];
        assert!((most_shifted(&before, &after, 1.0) - 1.2).abs() < 1e-9);
        assert!(
            most_shifted(&before, &after, -1.0).abs() < 1e-9 && most_shifted(&[], &after, 1.0).abs() < 1e-9
        );
    }
}
