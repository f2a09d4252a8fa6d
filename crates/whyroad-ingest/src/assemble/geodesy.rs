//! From the Earth to a flat local frame: WGS 84 earth-centered coordinates to east, north, up around an origin.

/// Semi-major axis of the WGS 84 ellipsoid, m (NGA.STND.0036).
const A: f64 = 6_378_137.0;
/// First eccentricity squared of the WGS 84 ellipsoid.
const E2: f64 = 6.694_379_990_141_33e-3;

/// A local frame: x east, y north, z up, meters from its origin. Flat: at 10 km the ground is 8 m below.
#[derive(Clone, Copy, Debug)]
pub struct LocalFrame {
    origin: [f64; 3],
    rows: [[f64; 3]; 3],
}

impl LocalFrame {
    /// The frame at an earth-centered, earth-fixed point (m).
    pub fn at_ecef(origin: [f64; 3]) -> Self {
        let (lat, lon) = latitude_longitude(origin);
        let ((sp, cp), (sl, cl)) = (lat.sin_cos(), lon.sin_cos());
        let rows = [[-sl, cl, 0.0], [-sp * cl, -sp * sl, cp], [cp * cl, cp * sl, sp]];
        Self { origin, rows }
    }

    /// An earth-centered point in this frame.
    pub fn point(&self, ecef: [f64; 3]) -> [f64; 3] {
        self.direction(std::array::from_fn(|i| ecef[i] - self.origin[i]))
    }

    /// An earth-centered direction or velocity in this frame.
    pub fn direction(&self, v: [f64; 3]) -> [f64; 3] {
        self.rows.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
    }
}

/// Geodetic latitude and longitude, rad, of an earth-centered point: fixed-point iteration on the latitude, which
/// near the surface gains more than two digits a round.
fn latitude_longitude(p: [f64; 3]) -> (f64, f64) {
    let r = p[0].hypot(p[1]);
    let mut lat = p[2].atan2(r * (1.0 - E2));
    for _ in 0..6 {
        let n = A / (1.0 - E2 * lat.sin().powi(2)).sqrt();
        lat = (p[2] + E2 * n * lat.sin()).atan2(r);
    }
    (lat, p[1].atan2(p[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_at_the_equator_and_a_known_point() {
        // On the equator at longitude 0: east is +y, north is +z, up is +x of the Earth's frame.
        let f = LocalFrame::at_ecef([A, 0.0, 0.0]);
        let p = f.point([A + 3.0, 1.0, 2.0]);
        assert!((p[0] - 1.0).abs() < 1e-9 && (p[1] - 2.0).abs() < 1e-9 && (p[2] - 3.0).abs() < 1e-9);
        // Latitude 45 deg on the ellipsoid: N = a / sqrt(1 - e2/2), x = N cos 45, z = N (1 - e2) sin 45 (the
        // definition).
        let n = A / (1.0 - E2 / 2.0).sqrt();
        let s = std::f64::consts::FRAC_1_SQRT_2;
        let (lat, lon) = latitude_longitude([n * s, 0.0, n * (1.0 - E2) * s]);
        assert!((lat - std::f64::consts::FRAC_PI_4).abs() < 1e-12 && lon == 0.0);
    }
}
