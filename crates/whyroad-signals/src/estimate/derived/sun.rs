//! Daylight and glare from the position of the sun over the ego.
//!
//! The sun's position uses the Astronomical Almanac's low-precision formulas as given by Michalsky ("The Astronomical
//! Almanac's algorithm for approximate solar position (1950-2050)", Solar Energy 40 (3), 1988), with an accuracy of
//! 0.01 degrees.

use crate::geometry::wrap;
use std::f64::consts::{FRAC_PI_2, TAU};
use whyroad_model::scene::GeoPosition;
use whyroad_model::{Drive, Nanos};

/// 2000-01-01 12:00 UTC, the epoch of the formulas, s since 1970.
const J2000_S: f64 = 946_728_000.0;
const DAY_S: f64 = 86_400.0;
/// Plausible dates; others come from clocks that were never set, s since 1970.
const PLAUSIBLE_S: std::ops::Range<f64> = 946_684_800.0..4_102_444_800.0;
/// Radius of the Earth, m.
const EARTH_M: f64 = 6_371_000.0;
/// Elevation of the sun at the end of civil twilight, deg.
const NIGHT_DEG: f64 = -6.0;
/// Maximum angle between the sun and the driving direction for glare, deg. If the sun is higher, the roof shades the
/// driver's eyes.
const DAZZLES_DEG: f64 = 25.0;

/// Position of the sun seen from a place on Earth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sun {
    /// Above the horizon, without refraction, rad.
    pub elevation: f64,
    /// Clockwise from north, 0 to 2 pi.
    pub azimuth: f64,
}

/// Position of the sun at `time` (UTC).
pub(super) fn sun(place: GeoPosition, time: Nanos) -> Sun {
    let days = (time.0 as f64 / 1e9 - J2000_S) / DAY_S;
    let degrees = |x: f64| x.rem_euclid(360.0).to_radians();
    let mean_longitude = degrees(280.460 + 0.985_647_4 * days);
    let mean_anomaly = degrees(357.528 + 0.985_600_3 * days);
    let ecliptic_longitude = mean_longitude
        + 1.915_f64.to_radians() * mean_anomaly.sin()
        + 0.020_f64.to_radians() * (2.0 * mean_anomaly).sin();
    let obliquity = (23.439 - 0.000_000_4 * days).to_radians();
    let right_ascension = (obliquity.cos() * ecliptic_longitude.sin()).atan2(ecliptic_longitude.cos());
    let declination = (obliquity.sin() * ecliptic_longitude.sin()).asin();
    // Greenwich mean sidereal time; 18.697374558 h at the epoch.
    let sidereal = (18.697_374_558 + 24.065_709_824_419_08 * days).rem_euclid(24.0) / 24.0 * TAU;
    let hour_angle = sidereal + place.longitude_deg.to_radians() - right_ascension;
    let latitude = place.latitude_deg.to_radians();
    let elevation =
        (declination.sin() * latitude.sin() + declination.cos() * latitude.cos() * hour_angle.cos()).asin();
    let east = -declination.cos() * hour_angle.sin();
    let north = declination.sin() * latitude.cos() - declination.cos() * latitude.sin() * hour_angle.cos();
    Sun { elevation, azimuth: east.atan2(north).rem_euclid(TAU) }
}

/// Angle between the driving direction (counter-clockwise from east) and the sun, rad.
fn off_course(sun: Sun, heading: f64) -> f64 {
    let aside = wrap(FRAC_PI_2 - sun.azimuth - heading);
    (sun.elevation.cos() * aside.cos()).clamp(-1.0, 1.0).acos()
}

/// The origin of the world frame, moved by `x` to the east and `y` to the north, m.
fn moved(origin: GeoPosition, x: f64, y: f64) -> GeoPosition {
    let parallel = EARTH_M * origin.latitude_deg.to_radians().cos();
    GeoPosition {
        latitude_deg: origin.latitude_deg + (y / EARTH_M).to_degrees(),
        longitude_deg: origin.longitude_deg + (x / parallel).to_degrees(),
    }
}

/// `context.lighting` outdoors: day, dusk, night; glare where the log states a clear sky and the sun is ahead. If the
/// sun is ahead and the sky is unknown, the lighting is unknown.
pub(super) fn lighting(drive: &Drive) -> Vec<Option<&'static str>> {
    let (Some(origin), Some(ego), Some(first)) = (drive.meta.position, &drive.ego, drive.times.first())
    else {
        return Vec::new();
    };
    if !PLAUSIBLE_S.contains(&(first.0 as f64 / 1e9)) || !drive.meta.is_dated() {
        return Vec::new();
    }
    let mut sky: Vec<(Nanos, &str)> = drive
        .context
        .iter()
        .flatten()
        .filter(|s| s.kind == "weather")
        .map(|s| (s.time, s.value.as_str()))
        .collect();
    sky.sort_by_key(|s| s.0);
    let m = &ego.motion;
    let at = |i: usize| {
        let (x, y, heading) = (m.x[i], m.y[i], m.heading[i]);
        if !(x.is_finite() && y.is_finite() && heading.is_finite()) {
            return None;
        }
        let time = drive.times[i];
        let sun = sun(moved(origin, x, y), time);
        let above = sun.elevation.to_degrees();
        if above < NIGHT_DEG {
            return Some("night");
        }
        if above < 0.0 {
            return Some("dusk");
        }
        if off_course(sun, heading).to_degrees() > DAZZLES_DEG {
            return Some("day");
        }
        let weather = sky.partition_point(|s| s.0 <= time).checked_sub(1).map(|k| sky[k].1);
        match weather {
            Some("clear") => Some("glare"),
            Some("rain" | "snow" | "fog") => Some("day"),
            _ => None,
        }
    };
    (0..m.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(latitude_deg: f64, longitude_deg: f64, utc: &str) -> (f64, f64) {
        let sun = sun(GeoPosition { latitude_deg, longitude_deg }, Nanos::parse_iso(utc).unwrap());
        (sun.elevation.to_degrees(), sun.azimuth.to_degrees())
    }

    /// Reda and Andreas, "Solar position algorithm for solar radiation applications", NREL/TP-560-34302 (2008),
    /// appendix A.5: 2003-10-17, 12:30:30 at UTC-7, 39.742476 N 105.1786 W: zenith 50.11162 deg, azimuth 194.34024
    /// deg.
    #[test]
    fn the_sun_is_where_nrel_publishes_it() {
        let (elevation, azimuth) = at(39.742_476, -105.178_6, "2003-10-17T19:30:30Z");
        assert!((elevation - (90.0 - 50.111_62)).abs() < 0.03, "{elevation}");
        assert!((azimuth - 194.340_24).abs() < 0.03, "{azimuth}");
    }

    /// On the equator at the March equinox of 2024 (20 March, 03:06 UTC) the sun passes the zenith within a degree;
    /// half a day later it is below the horizon.
    #[test]
    fn at_the_equinox_the_sun_passes_over_the_equator() {
        // Noon at longitude 0 is 12:07:30 UTC that day: the equation of time is -7.5 min.
        let (elevation, _) = at(0.0, 0.0, "2024-03-20T12:07:30Z");
        assert!(elevation > 89.0, "{elevation}");
        let (elevation, _) = at(0.0, 0.0, "2024-03-20T23:50:00Z");
        assert!(elevation < -80.0, "{elevation}");
    }

    #[test]
    fn the_sun_ahead_is_no_angle_away() {
        let low_in_the_west = Sun { elevation: 0.0, azimuth: 270.0_f64.to_radians() };
        assert!(off_course(low_in_the_west, std::f64::consts::PI) < 1e-6);
        assert!((off_course(low_in_the_west, 0.0).to_degrees() - 180.0).abs() < 1e-6);
        let high = Sun { elevation: 60.0_f64.to_radians(), azimuth: 270.0_f64.to_radians() };
        assert!((off_course(high, std::f64::consts::PI).to_degrees() - 60.0).abs() < 1e-6);
    }
}
