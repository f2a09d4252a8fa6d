//! Gap, time headway, TTC with and without acceleration, DST, ALongReq and BTN against commonroad-crime 0.4.5 on a
//! scene where its definitions and ours agree (examples/truth/crime: the scene and its values, made by `make.py`;
//! expected values are CriMe's). Where it is wrong, what is right by hand is expected, and that it differs is held
//! too.

use crate::scene::{Table, near};
use std::path::Path;
use whyroad_model::ObjectClass;

/// CriMe's answers for one vehicle: step, then hw, thw, ttc, dst, a_long_req, btn.
fn theirs(vehicle: &str) -> Vec<(usize, [f64; 6])> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/truth/crime/crime.csv");
    let text = std::fs::read_to_string(file).expect("the committed values");
    let rows = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let of = rows.filter(|cells| cells[1] == vehicle).map(|cells| {
        (cells[0].parse().expect("a step"), std::array::from_fn(|i| cells[i + 2].parse().expect("a number")))
    });
    of.collect()
}

/// The scene of make.py: centers, speeds, accelerations and sizes.
fn table() -> Table {
    let mut drive = crate::scene::drive(60, |t| (15.0 * t, 0.0, 0.0));
    let ego = drive.ego.as_mut().expect("an ego");
    (ego.length_m, ego.width_m) = (4.6, 1.8);
    crate::scene::add(&mut drive, "200", ObjectClass::Truck, (12.0, 2.4), |t| (45.0 + 10.0 * t, 0.0, 0.0));
    crate::scene::add(&mut drive, "300", ObjectClass::Motorcycle, (2.2, 0.9), |t| {
        (30.0 + 17.0 * t, 0.0, 0.0)
    });
    crate::scene::add(&mut drive, "400", ObjectClass::Car, (4.6, 1.8), |t| {
        (25.0 + 8.0 * t + 0.5 * t * t, 0.0, 0.0)
    });
    crate::scene::add(&mut drive, "500", ObjectClass::Car, (4.6, 1.8), |t| {
        (75.0 + 14.0 * t - t * t, 0.0, 0.0)
    });
    Table::of(&drive)
}

#[test]
fn headway_and_ttc_are_crimes() {
    let table = table();
    for vehicle in ["200", "300"] {
        let rows = theirs(vehicle);
        assert_eq!(rows.len(), 10);
        for (step, [hw, thw, ttc, ..]) in rows {
            let ours = |name: &str| table.num(vehicle, name, step);
            near(ours("target.gap"), hw, 1e-3);
            // CriMe's is the first step of 0.1 s at which the ego is there.
            let late = thw - ours("target.thw");
            assert!((-1e-6..0.1).contains(&late), "{vehicle} {step}: {late}");
            // Infinite on both sides, or equal to CriMe's rounding.
            for name in ["target.ttc", "target.ttc_accel"] {
                assert!(ours(name) == ttc || (ours(name) - ttc).abs() < 0.006, "{vehicle} {step}: {name}");
            }
        }
    }
}

#[test]
fn acceleration_measures_are_crimes() {
    let table = table();
    for vehicle in ["200", "400"] {
        for (step, [hw, _, ttc, dst, required, btn]) in theirs(vehicle) {
            let ours = |name: &str| table.num(vehicle, name, step);
            // CriMe rounds the headway's ends on its smoothed lane: centimeters.
            near(ours("target.gap"), hw, 0.02);
            near(ours("target.ttc_accel"), ttc, 0.02);
            near(ours("target.a_long_req"), required, 0.0051);
            near(ours("target.btn"), btn, 0.0051 / 11.5 + 1e-4);
            if dst >= 0.0 {
                // The safety time leaves little room at 400: a centimeter of headway moves the quotient by per cents.
                near(ours("target.dst"), dst, 0.006 + 0.02 * dst);
            } else {
                // A negative one means that the safety time is used up.
                assert_eq!(ours("target.dst"), f64::INFINITY, "{vehicle} {step}");
            }
        }
    }
}

#[test]
fn where_crime_is_wrong_by_hand() {
    let table = table();
    // 500 brakes at 2 m/s2, 1 m/s slower, 70.4 m ahead: t + t^2 = 70.4, t = (sqrt(1 + 4 * 70.4) - 1) / 2 = 7.905 s;
    // but it stands after 7 s and 49 m: 119.4 m at 15 m/s are 7.96 s. CriMe takes it for accelerating: never.
    let (_, [_, _, ttc, _, required, _]) = theirs("500")[0];
    assert_eq!((ttc, required), (f64::INFINITY, 0.0), "CriMe");
    near(table.num("500", "target.ttc_accel", 0), 119.4 / 15.0, 1e-3);
    near(table.num("500", "target.a_long_req", 0), -2.0 - 1.0 / (2.0 * 70.4), 1e-3);
    // 300 draws away at 2 m/s: CriMe squares that into a need to brake.
    let (_, [_, _, _, dst, required, _]) = theirs("300")[0];
    assert!(required < 0.0 && dst < 0.0, "CriMe");
    assert_eq!(table.num("300", "target.a_long_req", 0), 0.0);
    assert_eq!(table.num("300", "target.dst", 0), 0.0);
}
