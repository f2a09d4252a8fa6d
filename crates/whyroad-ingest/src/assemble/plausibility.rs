//! Impossible speeds: an identity switch or a bad box, not a motion. A stated velocity becomes unknown. Velocities from
//! positions are estimated later, so an impossible step between two positions is only counted and reported.

use crate::assemble::resample::MAX_GAP_S;
use whyroad_model::ObjectClass;
use whyroad_model::scene::Motion;

/// Sets impossible stated velocities to unknown. Returns the number of rows with such a velocity or with a larger
/// distance from the previous row than the object can move. `seconds` has the time of each row.
pub(crate) fn forget_impossible(class: ObjectClass, seconds: &[f64], m: &mut Motion) -> usize {
    let limit = class.max_speed_mps();
    let mut rows = 0;
    for i in 0..m.len() {
        let stated = m.speed(i);
        let along = m.forward.get(i).map_or(f64::NAN, |v| v.abs());
        if stated > limit || along > limit {
            (m.vx[i], m.vy[i], m.accel[i]) = (f64::NAN, f64::NAN, f64::NAN);
            m.forward.get_mut(i).into_iter().for_each(|v| *v = f64::NAN);
            rows += 1;
        } else if stated.is_nan() && along.is_nan() && i > 0 {
            let dt = seconds[i] - seconds[i - 1];
            let step = (m.x[i] - m.x[i - 1]).hypot(m.y[i] - m.y[i - 1]);
            rows += usize::from(dt <= MAX_GAP_S && step > limit * dt);
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pedestrian_at_sixty_is_unknown_and_a_car_is_not() {
        let motion = || Motion { vx: vec![16.7, 1.4], vy: vec![0.0; 2], ..Motion::unknown(2) };
        let mut walker = motion();
        assert_eq!(forget_impossible(ObjectClass::Pedestrian, &[0.0, 0.1], &mut walker), 1);
        assert!(walker.vx[0].is_nan() && walker.vx[1] == 1.4);
        assert_eq!(forget_impossible(ObjectClass::Car, &[0.0, 0.1], &mut motion()), 0);
    }

    #[test]
    fn a_step_that_cannot_be_is_counted_and_the_positions_stay() {
        // 2 m in 0.1 s, then 2 m in 1 s.
        let mut m = Motion { x: vec![0.0, 2.0, 4.0], y: vec![0.0; 3], ..Motion::unknown(3) };
        assert_eq!(forget_impossible(ObjectClass::Pedestrian, &[0.0, 0.1, 1.1], &mut m), 1);
        assert_eq!(m.x, [0.0, 2.0, 4.0]);
    }
}
