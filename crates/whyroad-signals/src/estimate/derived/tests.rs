//! Expected values: the taxonomy's thresholds, and the meaning of each channel.
use super::*;
use whyroad_model::scene::{DriveMeta, Ego, EgoBus, GeoPosition, Motion};
use whyroad_model::{Drive, Nanos};

/// `n` frames from `utc` on, driving at 10 m/s along `heading` with this acceleration.
fn drive(n: usize, utc: &str, heading: f64, accel: impl Fn(usize) -> f64) -> Drive {
    let start = Nanos::parse_iso(utc).unwrap();
    Drive {
        times: (0..n).map(|i| start + Nanos(i as i64 * 100_000_000)).collect(),
        ego: Some(Ego {
            motion: Motion {
                x: vec![0.0; n],
                y: vec![0.0; n],
                heading: vec![heading; n],
                vx: vec![10.0; n],
                vy: vec![0.0; n],
                accel: (0..n).map(accel).collect(),
                ..Motion::unknown(n)
            },
            ..Ego::default()
        }),
        ..Drive::default()
    }
}

fn with_derived(drive: &Drive) -> Drive {
    let mut out = Cow::Borrowed(drive);
    add_derived(&mut out);
    out.into_owned()
}

fn state<'a>(drive: &'a Drive, kind: &str, frame: usize) -> Option<&'a str> {
    let until = |s: &&ContextState| s.kind == kind && s.time <= drive.times[frame];
    drive.context.iter().flatten().rfind(until).map(|s| s.value.as_str())
}

fn bus(drive: &mut Drive, set: impl FnOnce(&mut EgoBus)) {
    set(&mut drive.ego.as_mut().unwrap().bus);
}

/// Beijing, 39.9 N 116.4 E, at the equinox: the sun rises in the east at 06:14 and sets in the west at 18:24 local time
/// (UTC+8), as almanacs give it.
#[test]
fn light_follows_from_place_time_and_heading() {
    let beijing = GeoPosition { latitude_deg: 39.9, longitude_deg: 116.4 };
    let (east, west) = (0.0, std::f64::consts::PI);
    let light = |utc: &str, heading: f64, weather: Option<&str>| {
        let mut d = drive(3, utc, heading, |_| 0.0);
        d.meta = DriveMeta { position: Some(beijing), ..DriveMeta::default() };
        d.context =
            weather.map(|w| changes(&d, "weather", &[Some(if w == "clear" { "clear" } else { "rain" }); 3]));
        let d = with_derived(&d);
        state(&d, "lighting", 1).map(str::to_owned)
    };
    let at = |utc, heading, weather| light(utc, heading, weather).unwrap_or_default();
    assert_eq!(at("2024-03-20T04:00:00Z", east, None), "day");
    assert_eq!(at("2024-03-20T16:00:00Z", east, None), "night");
    assert_eq!(at("2024-03-20T10:40:00Z", east, None), "dusk", "16 minutes after sunset");
    // One hour after sunrise and one hour before sunset the sun is about 10 degrees above the horizon.
    assert_eq!(at("2024-03-19T23:14:00Z", east, Some("clear")), "glare");
    assert_eq!(at("2024-03-19T23:14:00Z", west, Some("clear")), "day", "the sun is behind");
    assert_eq!(at("2024-03-20T09:24:00Z", west, Some("clear")), "glare");
    assert_eq!(at("2024-03-20T09:24:00Z", west, Some("rain")), "day");
    assert_eq!(light("2024-03-20T09:24:00Z", west, None), None, "nothing is known of the sky");
    // A clock that was never set.
    assert_eq!(light("1980-01-06T04:00:00Z", east, None), None);
}

#[test]
fn without_a_place_nothing_is_known_of_the_light() {
    let d = drive(3, "2024-03-20T04:00:00Z", 0.0, |_| 0.0);
    assert!(with_derived(&d).context.is_none());
}

#[test]
fn rain_is_concluded_from_wipers_that_run_on() {
    let mut d = drive(600, "2024-03-20T04:00:00Z", 0.0, |_| 0.0);
    // Two seconds of washing; from 20 s on a wipe every 5 s until 45 s.
    let wipes = |i: usize| (10..30).contains(&i) || ((200..450).contains(&i) && i % 50 < 10);
    bus(&mut d, |b| b.wipers = (0..600).map(|i| Some(wipes(i))).collect());
    let d = with_derived(&d);
    assert_eq!(state(&d, "weather", 100), Some("unknown"), "washing is no rain");
    assert_eq!(state(&d, "weather", 330), Some("unknown"), "13 s of wiping");
    assert_eq!(state(&d, "weather", 400), Some("rain"));
    assert_eq!(state(&d, "weather", 599), Some("unknown"), "the wipers have stood for 14 s");
}

#[test]
fn what_the_log_states_is_not_replaced() {
    let mut d = drive(600, "2024-03-20T04:00:00Z", 0.0, |_| 0.0);
    bus(&mut d, |b| b.wipers = vec![Some(true); 600]);
    d.context = Some(changes(&d, "weather", &[Some("snow"); 600]));
    assert_eq!(state(&with_derived(&d), "weather", 500), Some("snow"));
}

#[test]
fn a_shock_is_a_rough_place() {
    let mut d = drive(60, "2024-03-20T04:00:00Z", 0.0, |_| 0.0);
    bus(&mut d, |b| b.vertical_accel = (0..60).map(|i| if i == 30 { -4.5 } else { 1.0 }).collect());
    let d = with_derived(&d);
    assert_eq!(state(&d, "surface", 29), Some("unknown"));
    assert_eq!(state(&d, "surface", 30), Some("rough"));
    assert_eq!(state(&d, "surface", 40), Some("unknown"));
}

/// Emergency braking of 6 m/s2 within 0.5 s from frame 20 on.
fn emergency(i: usize) -> f64 {
    match i {
        0..20 => 0.0,
        20..25 => -1.2 * (i - 19) as f64,
        25..40 => -6.0,
        _ => 0.0,
    }
}

fn aeb(d: &Drive) -> Vec<Option<bool>> {
    with_derived(d).ego.unwrap().bus.aeb
}

#[test]
fn hard_braking_with_the_foot_on_the_throttle_is_the_systems() {
    let mut d = drive(60, "2024-03-20T04:00:00Z", 0.0, emergency);
    bus(&mut d, |b| b.throttle = (0..60).map(|i| if i < 25 { 0.2 } else { 0.0 }).collect());
    let flags = aeb(&d);
    assert_eq!((flags[10], flags[30], flags[50]), (Some(false), Some(true), Some(false)));
}

#[test]
fn hard_braking_by_the_driver_is_not() {
    let mut d = drive(60, "2024-03-20T04:00:00Z", 0.0, emergency);
    bus(&mut d, |b| b.brake = (0..60).map(|i| Some((17..40).contains(&i))).collect());
    assert_eq!(aeb(&d)[30], Some(false));
}

#[test]
fn without_pedals_hard_braking_tells_nothing_and_gentle_braking_all() {
    let flags = aeb(&drive(60, "2024-03-20T04:00:00Z", 0.0, emergency));
    assert_eq!((flags[10], flags[30]), (Some(false), None));
    let flags = aeb(&drive(60, "2024-03-20T04:00:00Z", 0.0, |i| if i < 30 { -3.0 } else { 0.0 }));
    assert!(flags.iter().all(|f| *f == Some(false)));
    assert!(aeb(&drive(60, "2024-03-20T04:00:00Z", 0.0, |_| f64::NAN)).is_empty());
}
