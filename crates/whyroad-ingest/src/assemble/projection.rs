//! Degrees to meters of a log's frame: UTM around an origin, as Lanelet2's `UtmProjector` places its maps, or the
//! tangent plane at the origin.

use crate::assemble::geodesy::LocalFrame;

/// WGS 84 (NGA.STND.0036): semi-major axis, m, and flattening.
const A: f64 = 6_378_137.0;
const F: f64 = 1.0 / 298.257_223_563;
/// Scale of UTM on its central meridian, and its false easting, m.
const K0: f64 = 0.9996;
const FALSE_EASTING_M: f64 = 500_000.0;

/// Which projection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProjectionKind {
    /// Universal transverse Mercator, less the origin's own easting and northing.
    Utm,
    /// East and north in the plane that touches the ellipsoid at the origin.
    Local,
}

/// A projection with its origin.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    /// Central meridian, deg, and easting and northing of the origin, m.
    utm: Option<(f64, [f64; 2])>,
    local: LocalFrame,
}

impl Projection {
    /// Around an origin, degrees (WGS 84).
    pub fn new(kind: ProjectionKind, lat: f64, lon: f64) -> Self {
        let meridian = f64::from(zone(lat, lon)) * 6.0 - 183.0;
        let utm = (kind == ProjectionKind::Utm).then(|| (meridian, utm(lat, lon, meridian)));
        Self { utm, local: LocalFrame::at_ecef(ecef(lat, lon)) }
    }

    /// x and y of a point, m.
    pub fn point(&self, lat: f64, lon: f64) -> [f64; 2] {
        match self.utm {
            Some((meridian, origin)) => {
                let [x, y] = utm(lat, lon, meridian);
                [x - origin[0], y - origin[1]]
            }
            None => {
                let [x, y, _] = self.local.point(ecef(lat, lon));
                [x, y]
            }
        }
    }
}

/// UTM's zone, with its exceptions in Norway.
fn zone(lat: f64, lon: f64) -> u8 {
    let plain = (((lon + 180.0) / 6.0).floor() as i64).clamp(0, 59) as u8 + 1;
    match (lat, lon) {
        _ if (56.0..64.0).contains(&lat) && (3.0..12.0).contains(&lon) => 32,
        _ if lat >= 72.0 && (0.0..9.0).contains(&lon) => 31,
        _ if lat >= 72.0 && (9.0..21.0).contains(&lon) => 33,
        _ if lat >= 72.0 && (21.0..33.0).contains(&lon) => 35,
        _ if lat >= 72.0 && (33.0..42.0).contains(&lon) => 37,
        _ => plain,
    }
}

/// Easting and northing from the equator (also in the south): Krueger's series in the third flattening, to its fourth
/// power, which is good to less than a millimeter.
fn utm(lat: f64, lon: f64, meridian: f64) -> [f64; 2] {
    let n = F / (2.0 - F);
    let (n2, n3, n4) = (n * n, n * n * n, n * n * n * n);
    let radius = A / (1.0 + n) * (1.0 + n2 / 4.0 + n4 / 64.0);
    let alpha = [
        n / 2.0 - 2.0 / 3.0 * n2 + 5.0 / 16.0 * n3 + 41.0 / 180.0 * n4,
        13.0 / 48.0 * n2 - 3.0 / 5.0 * n3 + 557.0 / 1440.0 * n4,
        61.0 / 240.0 * n3 - 103.0 / 140.0 * n4,
        49_561.0 / 161_280.0 * n4,
    ];
    let e = (F * (2.0 - F)).sqrt();
    let (sin, dlon) = (lat.to_radians().sin(), (lon - meridian).to_radians());
    let t = (sin.atanh() - e * (e * sin).atanh()).sinh();
    let xi = t.atan2(dlon.cos());
    let eta = (dlon.sin() / t.hypot(dlon.cos())).asinh();
    let (mut x, mut y) = (eta, xi);
    for (j, a) in alpha.iter().enumerate() {
        let k = 2.0 * (j + 1) as f64;
        x += a * (k * xi).cos() * (k * eta).sinh();
        y += a * (k * xi).sin() * (k * eta).cosh();
    }
    [FALSE_EASTING_M + K0 * radius * x, K0 * radius * y]
}

/// The point on the ellipsoid, earth-centered, m.
fn ecef(lat: f64, lon: f64) -> [f64; 3] {
    let e2 = F * (2.0 - F);
    let ((sp, cp), (sl, cl)) = (lat.to_radians().sin_cos(), lon.to_radians().sin_cos());
    let n = A / (1.0 - e2 * sp * sp).sqrt();
    [n * cp * cl, n * cp * sl, n * (1.0 - e2) * sp]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utm_of_known_points() {
        // On a central meridian the northing is the meridian arc times 0.9996: 4 984 944.378 m to 45 deg.
        let [x, y] = utm(45.0, 9.0, 9.0);
        assert!((x - 500_000.0).abs() < 1e-6 && (y - 0.9996 * 4_984_944.378).abs() < 0.001, "{y}");
        // The CN Tower, 43 38 33.24 N, 79 23 13.7 W: zone 17, 630084 m E, 4833438 m N.
        let (lat, lon) = (43.0 + 38.0 / 60.0 + 33.24 / 3600.0, -(79.0 + 23.0 / 60.0 + 13.7 / 3600.0));
        assert_eq!(zone(lat, lon), 17);
        let [x, y] = utm(lat, lon, -81.0);
        assert!((x - 630_084.0).abs() < 1.0 && (y - 4_833_438.0).abs() < 1.0, "{x} {y}");
        assert_eq!([zone(60.4, 5.3), zone(48.9, 8.4), zone(0.0, -180.0), zone(0.0, 180.0)], [32, 32, 1, 60]);
    }

    #[test]
    fn both_projections_begin_at_the_origin_and_differ_by_the_grid() {
        let (lat, lon) = (49.0, 8.0);
        let utm = Projection::new(ProjectionKind::Utm, lat, lon);
        let local = Projection::new(ProjectionKind::Local, lat, lon);
        assert!(utm.point(lat, lon).iter().chain(&local.point(lat, lon)).all(|v| v.abs() < 1e-6));
        // 0.001 deg of latitude is 111.21 m at 49 deg (radius of the meridian 6 371 700 m).
        let [x, y] = local.point(lat + 0.001, lon);
        assert!(x.abs() < 1e-3 && (y - 111.21).abs() < 0.02, "{x} {y}");
        // 1 deg west of the central meridian, grid north is turned by -1 deg * sin(49 deg).
        let [x, y] = utm.point(lat + 0.001, lon);
        let turned = x.atan2(y).to_degrees();
        assert!((turned - 49.0_f64.to_radians().sin()).abs() < 0.01, "{turned}");
    }
}
