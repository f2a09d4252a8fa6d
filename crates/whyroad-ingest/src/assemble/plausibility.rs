//! Speeds that cannot be: an identity switch or a bad box, not a motion. The position stays, the motion becomes
//! unknown.

use whyroad_model::ObjectClass;
use whyroad_model::scene::Motion;

/// The highest speed over ground that is believed for a class, m/s.
pub fn max_speed_mps(class: ObjectClass) -> f64 {
    match class {
        // The fastest sprint on record peaks at 12.4 m/s (Bolt, Berlin 2009).
        ObjectClass::Pedestrian => 12.5,
        // Wheelchairs and skaters downhill.
        ObjectClass::WheeledPedestrian => 20.0,
        // Racing cyclists on a descent reach about 110 km/h.
        ObjectClass::Bicycle | ObjectClass::Bicyclist | ObjectClass::EBike => 32.0,
        // Greyhounds and horses: 70 km/h.
        ObjectClass::Animal => 20.0,
        _ => 80.0,
    }
}

/// Makes the motion of impossible rows unknown; the number of rows.
pub fn forget_impossible(class: ObjectClass, motion: &mut Motion) -> usize {
    let limit = max_speed_mps(class);
    let rows: Vec<usize> = (0..motion.len()).filter(|&i| motion.speed(i) > limit).collect();
    for &i in &rows {
        motion.vx[i] = f64::NAN;
        motion.vy[i] = f64::NAN;
        motion.accel[i] = f64::NAN;
    }
    rows.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pedestrian_at_sixty_is_unknown_and_a_car_is_not() {
        let motion = || Motion { vx: vec![16.7, 1.4], vy: vec![0.0; 2], ..Motion::unknown(2) };
        let mut walker = motion();
        assert_eq!(forget_impossible(ObjectClass::Pedestrian, &mut walker), 1);
        assert!(walker.vx[0].is_nan() && walker.vx[1] == 1.4);
        assert_eq!(forget_impossible(ObjectClass::Car, &mut motion()), 0);
    }
}
