//! Motion model of people and small objects: constant velocity, which changes by white acceleration, separately on each
//! axis; and a heading that changes at a constant rate.

use super::kalman::Model;
use super::matrix::Matrix;

/// One axis: a value and its rate.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Change of the rate within a second, one standard deviation.
    pub change: f64,
}

/// Change of velocity of people within a second, m/s.
pub const WALKER: Axis = Axis { change: 0.7 };
/// Change of the yaw rate within a second, rad/s.
pub const TURN: Axis = Axis { change: 0.4 };

impl Model<2> for Axis {
    const ANGLE: Option<usize> = None;

    type Kept = Matrix<2>;

    fn kept(derivatives: &Matrix<2>) -> Matrix<2> {
        *derivatives
    }

    fn derivatives(kept: &Matrix<2>) -> Matrix<2> {
        *kept
    }

    fn predict(&self, s: &[f64; 2], dt: f64) -> ([f64; 2], Matrix<2>) {
        ([s[0] + s[1] * dt, s[1]], [[1.0, dt], [0.0, 1.0]])
    }

    fn noise(&self, _: &[f64; 2], dt: f64) -> Matrix<2> {
        let q = self.change * self.change;
        let cross = q * dt * dt / 2.0;
        [[q * dt * dt * dt / 3.0, cross], [cross, q * dt]]
    }
}
