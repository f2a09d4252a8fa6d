//! Motion model of a vehicle: a bicycle whose rear axle follows its heading. State: position of the box center (m),
//! heading (rad), forward speed (m/s, negative in reverse), yaw rate (rad/s), acceleration along the heading (m/s2).
//! Acceleration changes by white jerk, the yaw rate by a white change of the lateral acceleration.

use super::kalman::Model;
use super::matrix::{Matrix, identity, zero};
use whyroad_model::ObjectClass;

/// Components of the state.
pub const X: usize = 0;
/// m.
pub const Y: usize = 1;
/// rad.
pub const HEADING: usize = 2;
/// m/s.
pub const SPEED: usize = 3;
/// rad/s.
pub const YAW_RATE: usize = 4;
/// m/s2.
pub const ACCEL: usize = 5;

/// Distance from the rear axle to the center of a vehicle, as a share of its length.
pub const REAR_TO_CENTER: f64 = 0.27;
/// Change of acceleration within a second, one standard deviation, m/s2. For the speeds of 43 simulated drives with
/// noise of 0.2 m and 0.3 m/s, 0.5 % of the errors exceed three standard deviations; with 1.2 it was 1.6 %.
const JERK: f64 = 2.0;
/// Change of lateral acceleration within a second, one standard deviation, m/s2.
const LATERAL_JERK: f64 = 0.8;
/// Minimum speed by which the change of lateral acceleration is divided for that of the yaw rate, m/s.
const LEAST_SPEED_MPS: f64 = 2.0;
/// Sideways slip within a second, m: deviation from the model.
const SLIP_M: f64 = 0.05;
/// Uncertainty of the point about which a vehicle turns, as a share of the distance between that point and its center:
/// trailers, hand-drawn boxes and a simulator whose vehicles follow their lane with both ends differ by the whole
/// distance. With a fixed point, the positions of such a vehicle would turn its heading back.
const LEVER_SHARE: f64 = 1.0;
/// Drift of the heading within a second in addition to the yaw rate, rad.
const DRIFT_RAD: f64 = 0.005;

/// For each component, the other components on which it depends: the off-diagonal derivatives that `predict` sets; the
/// others are zero.
const COUPLED: [(usize, &[usize]); 4] = [
    (X, &[HEADING, SPEED, YAW_RATE, ACCEL]),
    (Y, &[HEADING, SPEED, YAW_RATE, ACCEL]),
    (HEADING, &[YAW_RATE]),
    (SPEED, &[ACCEL]),
];

/// True for objects that move along their heading.
pub fn on_wheels(class: ObjectClass) -> bool {
    class.is_vehicle()
        || matches!(class, ObjectClass::Bicycle | ObjectClass::Bicyclist | ObjectClass::Motorcyclist)
}

/// The model for one vehicle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bicycle {
    /// From the rear axle to the box center, m.
    pub rear_to_center_m: f64,
}

impl Model<6> for Bicycle {
    const ANGLE: Option<usize> = Some(HEADING);

    type Kept = [f64; 10];

    fn kept(f: &Matrix<6>) -> [f64; 10] {
        [
            f[X][HEADING],
            f[X][SPEED],
            f[X][YAW_RATE],
            f[X][ACCEL],
            f[Y][HEADING],
            f[Y][SPEED],
            f[Y][YAW_RATE],
            f[Y][ACCEL],
            f[HEADING][YAW_RATE],
            f[SPEED][ACCEL],
        ]
    }

    fn derivatives(kept: &[f64; 10]) -> Matrix<6> {
        let mut f = identity();
        for (row, of_place) in [(X, &kept[..4]), (Y, &kept[4..8])] {
            f[row][HEADING] = of_place[0];
            f[row][SPEED] = of_place[1];
            f[row][YAW_RATE] = of_place[2];
            f[row][ACCEL] = of_place[3];
        }
        (f[HEADING][YAW_RATE], f[SPEED][ACCEL]) = (kept[8], kept[9]);
        f
    }

    fn predict(&self, s: &[f64; 6], dt: f64) -> ([f64; 6], Matrix<6>) {
        let (half, lever) = (0.5 * dt, self.rear_to_center_m);
        let (sin, cos) = (s[HEADING] + s[YAW_RATE] * half).sin_cos();
        let ahead = s[SPEED] * dt + s[ACCEL] * dt * half;
        let aside = lever * s[YAW_RATE] * dt;
        let next = [
            s[X] + ahead * cos - aside * sin,
            s[Y] + ahead * sin + aside * cos,
            s[HEADING] + s[YAW_RATE] * dt,
            s[SPEED] + s[ACCEL] * dt,
            s[YAW_RATE],
            s[ACCEL],
        ];
        let mut f = identity();
        let (dx, dy) = (-ahead * sin - aside * cos, ahead * cos - aside * sin);
        f[X][HEADING] = dx;
        f[Y][HEADING] = dy;
        f[X][SPEED] = dt * cos;
        f[Y][SPEED] = dt * sin;
        f[X][YAW_RATE] = dx * half - lever * dt * sin;
        f[Y][YAW_RATE] = dy * half + lever * dt * cos;
        f[X][ACCEL] = dt * half * cos;
        f[Y][ACCEL] = dt * half * sin;
        f[HEADING][YAW_RATE] = dt;
        f[SPEED][ACCEL] = dt;
        (next, f)
    }

    fn moved(f: &Matrix<6>, matrix: &Matrix<6>) -> Matrix<6> {
        let mut out = *matrix;
        for (row, others) in COUPLED {
            let mut sum = matrix[row];
            for &k in others {
                for j in 0..6 {
                    sum[j] += f[row][k] * matrix[k][j];
                }
            }
            out[row] = sum;
        }
        out
    }

    fn moved_back(f: &Matrix<6>, matrix: &Matrix<6>) -> Matrix<6> {
        let mut out = *matrix;
        for (row, others) in COUPLED {
            for &k in others {
                for j in 0..6 {
                    out[k][j] += f[row][k] * matrix[row][j];
                }
            }
        }
        out
    }

    fn noise(&self, s: &[f64; 6], dt: f64) -> Matrix<6> {
        let (dt2, dt3) = (dt * dt, dt * dt * dt);
        let mut q = zero();
        let jerk = JERK * JERK;
        q[SPEED][SPEED] = jerk * dt3 / 3.0;
        q[SPEED][ACCEL] = jerk * dt2 / 2.0;
        q[ACCEL][SPEED] = q[SPEED][ACCEL];
        q[ACCEL][ACCEL] = jerk * dt;
        let turn = (LATERAL_JERK / s[SPEED].abs().max(LEAST_SPEED_MPS)).powi(2);
        q[HEADING][HEADING] = turn * dt3 / 3.0 + DRIFT_RAD * DRIFT_RAD * dt;
        q[HEADING][YAW_RATE] = turn * dt2 / 2.0;
        q[YAW_RATE][HEADING] = q[HEADING][YAW_RATE];
        q[YAW_RATE][YAW_RATE] = turn * dt;
        let swings = LEVER_SHARE * self.rear_to_center_m * s[YAW_RATE];
        let slip = (SLIP_M * SLIP_M + swings * swings) * dt;
        q[X][X] = slip;
        q[Y][Y] = slip;
        q
    }
}

#[cfg(test)]
mod tests {
    use super::super::matrix::{product, transposed};
    use super::*;

    #[test]
    fn all_derivatives_are_kept() {
        let (_, f) = Bicycle { rear_to_center_m: 1.2 }.predict(&[3.0, -4.0, 0.3, 12.0, 0.2, 0.7], 0.1);
        assert_eq!(Bicycle::derivatives(&Bicycle::kept(&f)), f);
    }

    #[test]
    fn a_matrix_is_moved_as_by_the_whole_product() {
        // A covariance without structure, moved on curves to either side, at standstill and in reverse.
        let matrix: Matrix<6> =
            std::array::from_fn(|i| std::array::from_fn(|j| (7.0 * i as f64 - 3.0 * j as f64).sin()));
        let bicycle = Bicycle { rear_to_center_m: 1.2 };
        for (heading, speed, yaw_rate) in
            [(0.3, 12.0, 0.2), (-2.9, 5.0, -0.4), (1.6, 0.0, 0.0), (0.0, -2.0, 0.1)]
        {
            let (_, f) = bicycle.predict(&[3.0, -4.0, heading, speed, yaw_rate, 0.7], 0.1);
            assert_eq!(Bicycle::moved(&f, &matrix), product(&f, &matrix), "{heading} {speed} {yaw_rate}");
            // Summed in another order.
            let (back, whole) = (Bicycle::moved_back(&f, &matrix), product(&transposed(&f), &matrix));
            for (value, expected) in back.as_flattened().iter().zip(whole.as_flattened()) {
                assert!((value - expected).abs() < 1e-14, "{heading} {speed} {yaw_rate}");
            }
        }
    }
}
