//! RefAV's definitions at their thresholds (the ego is 4 m x 2 m), and on recorded AV2 logs compared with an
//! independent computation in NumPy (examples/truth/refav/make.py), whose results are stored beside it. Skipped if the
//! logs are not present.
use crate::scene::{Table, add, add_seen, car, drive, map, near, road};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::PathBuf;
use whyroad_ingest::{Options, find_sources, read};
use whyroad_model::ObjectClass::{Car, Cone, Pedestrian};
use whyroad_model::Tri::{False, True};

#[test]
fn relative_directions_by_hand() {
    let mut d = drive(10, |t| (10.0 * t, 0.0, 0.0));
    // Boxes of 4 m: 50 m apart at a center distance of 54 m.
    for (id, x, y) in [
        ("f50", 53.9, 0.0),
        ("f51", 54.2, 0.0),
        ("front_left", 3.0, 20.0),
        ("back", -2.1, -20.0),
        ("left", 1.9, 4.0),
        ("right", 0.0, -4.0),
    ] {
        car(&mut d, id, move |t| (x + 10.0 * t, y, 0.0));
    }
    let t = Table::of(&d);
    for (id, expected) in [
        ("f50", "front"),
        ("f51", "none"),
        ("front_left", "front"),
        ("back", "back"),
        ("left", "left"),
        ("right", "right"),
    ] {
        assert_eq!(t.category(id, "target.refav_relative_direction", 5), Some(expected), "{id}");
    }
}

#[test]
fn following_by_hand() {
    let mut d = drive(10, |t| (10.0 * t, 0.0, 0.0));
    for (id, x, y, heading) in [
        ("near", 26.9, 0.0, 0.0),
        ("far", 27.1, 0.0, 0.0),
        ("turned", 10.0, 0.5, 61.0_f64.to_radians()),
        ("beside", 10.0, 3.5, 0.0),
        // In the lane beside (its edge is at 1.75), its side at 0.9: within the ego's half width of 1 m.
        ("reaches_in", 15.0, 1.9, 0.0),
        ("behind", -10.0, 0.0, 0.0),
    ] {
        car(&mut d, id, move |t| (x + 10.0 * t * heading.cos(), y + 10.0 * t * heading.sin(), heading));
    }
    d.map = Some(road());
    let t = Table::of(&d);
    for (id, expected) in [
        ("near", True),
        ("far", False),
        ("turned", False),
        ("beside", False),
        ("reaches_in", True),
        ("behind", False),
    ] {
        assert_eq!(t.flag(id, "target.refav_following", 0), expected, "{id}");
    }
}

#[test]
fn crossing_and_standing_by_hand() {
    // The ego stands, front at x = 2. A walker crosses at x = 11.9 from y = -4 at 1 m/s: over the side line at -1 after
    // 3 s; crossing is all of its way until y = 5. Another at x = 12.1 is beyond the 10 m.
    let mut d = drive(120, |_| (0.0, 0.0, 0.0));
    add(&mut d, "crosses", Pedestrian, (0.6, 0.6), |t| (11.9, -4.0 + t, FRAC_PI_2));
    add(&mut d, "beyond", Pedestrian, (0.6, 0.6), |t| (12.1, -4.0 + t, FRAC_PI_2));
    // 2.9 m along: stationary for RefAV; 3.1 m not.
    add(&mut d, "stays", Pedestrian, (0.6, 0.6), |t| (30.0 + 0.29 * t.min(10.0), 0.0, 0.0));
    add(&mut d, "goes", Pedestrian, (0.6, 0.6), |t| (30.0 + 0.31 * t.min(10.0), 5.0, 0.0));
    let t = Table::of(&d);
    let on: Vec<usize> =
        (0..120).filter(|&i| t.flag("crosses", "target.refav_crossed_by", i) == True).collect();
    // y < 5 until 9 s; a point exactly on the bound may fall to either side by rounding.
    assert_eq!(on[0], 0);
    assert!((89..=90).contains(on.last().unwrap()), "{on:?}");
    assert!((0..120).all(|i| t.flag("beyond", "target.refav_crossed_by", i) == False));
    assert_eq!(t.flag("stays", "target.refav_stationary", 5), True);
    assert_eq!(t.flag("goes", "target.refav_stationary", 5), False);
    assert_eq!(t.ego_flag("ego.refav_stationary", 5), True);
}

#[test]
fn headings_and_junctions_by_hand() {
    let mut d = drive(10, |t| (10.0 * t, 0.0, 0.0));
    let going = |deg: f64| {
        let h = deg.to_radians();
        move |t: f64| (20.0 + 5.0 * t * h.cos(), 10.0 + 5.0 * t * h.sin(), h)
    };
    for (id, deg) in [("44", 44.0), ("46", 46.0), ("134", 134.0), ("136", -136.0), ("180", 180.0)] {
        car(&mut d, id, going(deg));
    }
    car(&mut d, "stands", |_| (30.0, 5.0, PI));
    add_seen(&mut d, "cone", Cone, (0.5, 0.5), |_| true, |_| (30.0, 5.0, PI));
    let mut inner = crate::scene::lane("j", &[(60.0, -20.0), (60.0, 20.0)], 4.0);
    inner.in_junction = true;
    d.map = Some(map(vec![inner]));
    // The lane's edge is at x = 58: 4.9 m and 5.1 m from it.
    add(&mut d, "at", Car, (4.0, 2.0), |_| (53.1, 0.0, 0.0));
    add(&mut d, "off", Car, (4.0, 2.0), |_| (52.9, 0.0, 0.0));
    let t = Table::of(&d);
    for (id, expected) in [
        ("44", "same"),
        ("46", "perpendicular"),
        ("134", "perpendicular"),
        ("136", "opposite"),
        ("180", "opposite"),
        ("stands", "opposite"),
        ("cone", "none"),
    ] {
        assert_eq!(t.category(id, "target.refav_heading", 5), Some(expected), "{id}");
    }
    assert_eq!(t.flag("at", "target.refav_near_intersection", 5), True);
    assert_eq!(t.flag("off", "target.refav_near_intersection", 5), False);
    assert_eq!(t.category("44", "target.refav_turning", 5), Some("none"));
    near(t.num("44", "target.speed", 5), 5.0, 1e-6);
}

/// The table of the log whose id begins with `prefix`.
fn log(prefix: &str) -> Option<Table> {
    let base = std::env::var_os("WHYROAD_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let logs = std::fs::read_dir(base.join("av2/sensor_logs")).ok()?;
    let folder = logs
        .flatten()
        .map(|e| e.path())
        .find(|p| p.file_name().and_then(|n| n.to_str()).is_some_and(|n| n.starts_with(prefix)))?;
    let (sources, _) = find_sources(None, &[folder]);
    Some(Table::of(&read(sources.first()?, &Options::default()).0?))
}

/// Number of rows with `value` for a question about `who` (ego or target).
fn count(t: &Table, who: &str, question: &str, value: &str) -> usize {
    let (columns, name) = match who {
        "ego" => (&t.0.frame_columns, format!("ego.refav_{question}")),
        _ => (&t.0.target_columns, format!("target.refav_{question}")),
    };
    let column = &columns[&name];
    let says = |row: &usize| match value {
        "true" => column.flag(*row) == True,
        _ => column.category(*row) == Some(value),
    };
    // RefAV has annotated rows only, not those that the estimator adds in gaps.
    let observed = t.0.target_columns.get("target.observed").filter(|_| who != "ego");
    (0..column.len()).filter(|&row| observed.is_none_or(|c| c.flag(row) == True)).filter(says).count()
}

#[test]
fn recorded_logs_give_refavs_counts() {
    // compare.py prints the agreement row by row; here the counts of each log and value are stored, so that the
    // repository needs no data of the logs.
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/truth/refav/counts.csv");
    let text = std::fs::read_to_string(file).unwrap();
    let mut tables: BTreeMap<String, Option<Table>> = BTreeMap::new();
    let mut compared = 0;
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [prefix, who, question, value, rows] = cells[..] else { panic!("{line}") };
        let Some(table) = tables.entry(prefix.to_owned()).or_insert_with(|| log(prefix)) else { continue };
        let (theirs, ours) = (rows.parse::<f64>().unwrap(), count(table, who, question, value) as f64);
        println!("{line}: ours {ours}");
        assert!((ours - theirs).abs() <= 0.02 * theirs + 4.0, "{line}: ours {ours}");
        compared += 1;
    }
    if compared == 0 {
        crate::require::skipped("recorded", "no recorded data");
    }
    assert!(compared == 0 || compared >= 20, "{compared}");
}
