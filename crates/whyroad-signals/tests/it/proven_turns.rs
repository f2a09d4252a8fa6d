//! Turns at junctions that the ego's way proves without a map. Ways of straights and arcs, driven at 10 m/s: the turn
//! is the arc, and what it is called follows from its angle by hand.
use crate::scene::{Table, drive, lane, map};
use crate::terrain::winding;
use std::f64::consts::PI;
use whyroad_model::Tri::{True, Unknown};
use whyroad_model::{Drive, Need, Tri};

/// 1/m: a radius of 12 m.
const CORNER: f64 = 1.0 / 12.0;
/// Length of a quarter of a circle of 12 m radius, m.
const QUARTER: f64 = 6.0 * PI;

const SIGNALS: [&str; 4] = ["ego.in_junction", "ego.movement", "ego.turn_angle", "map.distance_to_junction"];

/// A turn to the left at 40 m, a straight before and behind.
const TURN: &[(f64, f64)] = &[(40.0, 0.0), (QUARTER, CORNER), (100.0, 0.0)];

fn proven(d: &Drive) -> bool {
    let table = Table::of(d).0;
    let partial = SIGNALS.map(|name| table.partial.contains_key(name));
    let columns = SIGNALS.map(|name| table.frame_columns.contains_key(name));
    let absent = SIGNALS.map(|name| table.unavailable.get(name) == Some(&vec![Need::Map]));
    assert!(partial == columns && partial.iter().zip(absent).all(|(p, a)| *p != a), "{partial:?} {absent:?}");
    assert!(partial.iter().all(|p| *p == partial[0]));
    partial[0]
}

#[test]
fn a_turn_between_straights_is_one_at_a_junction() {
    let t = Table::of(&drive(101, winding(TURN)));
    // The arc is from 4 s to 5.9 s.
    let inside: Vec<Tri> = [30, 45, 50, 55, 70].map(|i| t.ego_flag("ego.in_junction", i)).into();
    assert_eq!(inside, [Unknown, True, True, True, Unknown]);
    assert_eq!(t.ego_category("ego.movement", 50), Some("left"));
    assert_eq!(t.ego_category("ego.movement", 70), None);
    assert!((t.ego("ego.turn_angle", 50) - PI / 2.0).abs() < 0.02);
    assert_eq!(t.ego("map.distance_to_junction", 50), 0.0);
    // How far the next junction is, nothing tells: one may come before the turn.
    assert!(t.ego("map.distance_to_junction", 30).is_nan());
    assert_eq!(t.0.partial["ego.in_junction"], [Need::Map]);
    assert!(!t.0.shows_all("ego.in_junction") && t.0.shows_all("ego.speed"));
    // Nothing else of the road follows from it.
    assert!(t.0.unavailable.contains_key("map.junction_arms"));
    let t = Table::of(&drive(101, winding(&[(40.0, 0.0), (QUARTER, -CORNER), (100.0, 0.0)])));
    assert_eq!(t.ego_category("ego.movement", 50), Some("right"));
}

#[test]
fn what_is_not_the_shape_of_a_turn_proves_nothing() {
    let ways: [(&str, &'static [(f64, f64)]); 9] = [
        ("a straight", &[(100.0, 0.0)]),
        ("a bend of 90 deg on 40 m", &[(40.0, 0.0), (62.8, 0.025), (100.0, 0.0)]),
        (
            "a bend on 30 m, once on 20 m",
            &[(40.0, 0.0), (20.0, 0.033), (5.0, 0.05), (20.0, 0.033), (100.0, 0.0)],
        ),
        ("50 deg", &[(40.0, 0.0), (10.5, CORNER), (100.0, 0.0)]),
        ("a hairpin of 170 deg", &[(40.0, 0.0), (35.6, CORNER), (100.0, 0.0)]),
        (
            "straight over a roundabout: 45 deg right, 90 deg left, 45 deg right",
            &[(40.0, 0.0), (9.4, -CORNER), (QUARTER, CORNER), (9.4, -CORNER), (100.0, 0.0)],
        ),
        (
            "left round a roundabout: the ring is left by a bend to the right",
            &[
                (40.0, 0.0),
                (9.4, -CORNER),
                (4.0, 0.0),
                (25.1, CORNER),
                (4.0, 0.0),
                (9.4, -CORNER),
                (100.0, 0.0),
            ],
        ),
        (
            "serpentines, 15 m apart",
            &[(40.0, 0.0), (QUARTER, CORNER), (15.0, 0.0), (QUARTER, -CORNER), (100.0, 0.0)],
        ),
        ("a circle", &[(40.0, 0.0), (200.0, CORNER)]),
    ];
    for (what, way) in ways {
        assert!(!proven(&drive(140, winding(way))), "{what}");
    }
    assert!(proven(&drive(140, winding(TURN))));
}

#[test]
fn what_the_record_does_not_show_is_not_proven() {
    // The turn ends at 58.85 m; steering out and the straight are 13 m: to 71.85 m.
    assert!(!proven(&drive(70, winding(TURN))));
    assert!(proven(&drive(75, winding(TURN))));
    // It begins 10 m before the turn.
    assert!(!proven(&drive(100, |t| winding(TURN)(t + 3.0))));
    assert!(proven(&drive(100, |t| winding(TURN)(t + 2.5))));
}

#[test]
fn car_parks_and_maneuvers_prove_nothing() {
    // 4 m/s all along.
    assert!(!proven(&drive(260, |t| winding(TURN)(0.4 * t))));
    // Round the corner, on to 74 m, and 3 m back at 2 m/s, within 30 m behind it.
    let there_and_back = |t: f64| winding(TURN)(if t < 7.4 { t } else { 7.4 - 0.2 * (t - 7.4).min(1.5) });
    assert!(!proven(&drive(110, there_and_back)));
}

#[test]
fn a_drive_with_a_map_is_not_touched() {
    let mut d = drive(101, winding(TURN));
    d.map = Some(map(vec![lane("a", &[(0.0, 0.0), (40.0, 0.0)], 3.5)]));
    assert!(Table::of(&d).0.partial.is_empty());
}
