//! The datum of latitudes and longitudes. GCJ-02, the datum of Chinese web maps, shifts WGS 84 by 100 to 700 m. A datum
//! applies where it is declared; it is never guessed from coordinates.

use std::f64::consts::PI;

/// Semi-major axis and first eccentricity squared of the Krasovsky 1940 ellipsoid, which the shift is defined on.
const A: f64 = 6_378_245.0;
const E2: f64 = 0.006_693_421_622_965_943;
/// The inverse stops when a step moves less than this, degrees: 0.1 mm.
const STEP_DEG: f64 = 1e-9;

/// What latitudes and longitudes refer to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Datum {
    /// WGS 84: GNSS receivers, OpenStreetMap.
    #[default]
    Wgs84,
    /// GCJ-02: maps published in China.
    Gcj02,
}

impl Datum {
    /// From its usual names, in any case, with or without hyphens; `None` for any other.
    pub fn parse(name: &str) -> Option<Self> {
        match name.trim().to_lowercase().replace(['-', '_', ' '], "").as_str() {
            "wgs84" | "epsg:4326" => Some(Datum::Wgs84),
            "gcj02" => Some(Datum::Gcj02),
            _ => None,
        }
    }

    /// Latitude and longitude in WGS 84, degrees.
    pub fn to_wgs84(self, lat: f64, lon: f64) -> (f64, f64) {
        match self {
            Datum::Wgs84 => (lat, lon),
            Datum::Gcj02 => unshifted(lat, lon),
        }
    }
}

/// WGS 84 to GCJ-02, degrees; outside of China's rectangle nothing is shifted.
fn shifted(lat: f64, lon: f64) -> (f64, f64) {
    if !(72.004..=137.8347).contains(&lon) || !(0.8293..=55.8271).contains(&lat) {
        return (lat, lon);
    }
    let (x, y) = (lon - 105.0, lat - 35.0);
    let waves = |v: f64, long: [f64; 2]| {
        let first = 20.0 * (v * PI).sin() + 40.0 * (v / 3.0 * PI).sin();
        let second = long[0] * (v / 12.0 * PI).sin() + long[1] * (v / 30.0 * PI).sin();
        (first + second) * 2.0 / 3.0
    };
    let short = (20.0 * (6.0 * x * PI).sin() + 20.0 * (2.0 * x * PI).sin()) * 2.0 / 3.0;
    let root = x.abs().sqrt();
    let north = -100.0
        + 2.0 * x
        + 3.0 * y
        + 0.2 * y * y
        + 0.1 * x * y
        + 0.2 * root
        + short
        + waves(y, [160.0, 320.0]);
    let east =
        300.0 + x + 2.0 * y + 0.1 * x * x + 0.1 * x * y + 0.1 * root + short + waves(x, [150.0, 300.0]);
    let phi = lat.to_radians();
    let magic = 1.0 - E2 * phi.sin().powi(2);
    let meridian = A * (1.0 - E2) / (magic * magic.sqrt());
    let parallel = A / magic.sqrt() * phi.cos();
    (lat + (north / meridian).to_degrees(), lon + (east / parallel).to_degrees())
}

/// GCJ-02 to WGS 84 by fixed-point iteration: the shift changes by less than a thousandth of the distance.
fn unshifted(lat: f64, lon: f64) -> (f64, f64) {
    let mut at = (lat, lon);
    for _ in 0..30 {
        let there = shifted(at.0, at.1);
        let step = (lat - there.0, lon - there.1);
        at = (at.0 + step.0, at.1 + step.1);
        if step.0.abs().max(step.1.abs()) < STEP_DEG {
            break;
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs that the open-source library eviltransform publishes with its tests: WGS 84, GCJ-02.
    const PAIRS: [[f64; 4]; 3] = [
        [31.177_427_6, 121.527_210_6, 31.175_303_983_645_97, 121.531_541_859_215],
        [22.543_847, 113.912_316, 22.540_796_131_694_766, 113.917_176_480_836_3],
        [39.911_954, 116.377_817, 39.913_345_455_360_69, 116.384_047_224_556_57],
    ];

    /// Distance of two near points, m.
    fn meters(a: (f64, f64), b: (f64, f64)) -> f64 {
        let north = (a.0 - b.0) * 111_132.0;
        let east = (a.1 - b.1) * 111_320.0 * a.0.to_radians().cos();
        north.hypot(east)
    }

    #[test]
    fn published_pairs_agree_in_both_directions() {
        for [lat, lon, gcj_lat, gcj_lon] in PAIRS {
            let there = shifted(lat, lon);
            assert!(meters(there, (gcj_lat, gcj_lon)) < 1e-3, "{there:?}");
            let back = Datum::Gcj02.to_wgs84(gcj_lat, gcj_lon);
            assert!(meters(back, (lat, lon)) < 0.01, "{back:?}");
            // The shift is large before it is undone: hundreds of meters.
            assert!(meters((lat, lon), (gcj_lat, gcj_lon)) > 400.0);
        }
    }

    #[test]
    fn the_inverse_holds_all_over_china() {
        for i in 0..40 {
            for k in 0..40 {
                let at = (18.0 + 0.85 * f64::from(i), 74.0 + 1.5 * f64::from(k));
                let (lat, lon) = shifted(at.0, at.1);
                assert!(meters(Datum::Gcj02.to_wgs84(lat, lon), at) < 0.1, "{at:?}");
            }
        }
    }

    #[test]
    fn abroad_and_in_wgs84_nothing_moves() {
        assert_eq!(Datum::Gcj02.to_wgs84(48.99, 8.4), (48.99, 8.4));
        assert_eq!(Datum::Wgs84.to_wgs84(39.9, 116.4), (39.9, 116.4));
        assert_eq!(Datum::parse("GCJ-02"), Some(Datum::Gcj02));
        assert_eq!(Datum::parse("bd09"), None);
    }
}
