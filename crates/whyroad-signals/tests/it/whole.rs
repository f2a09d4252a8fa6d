//! The table as a whole: it agrees with the catalog, and does not depend on where the world's origin is, how its
//! axes lie, or when the drive took place.
use crate::scene::{Table, add, add_seen, area, car, drive, near, road};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};
use whyroad_model::ObjectClass::{Bus, Pedestrian};
use whyroad_model::road_map::{Facility, LaneMark, Point3, Sign, StopLine};
use whyroad_model::scene::{ContextState, LightColor, LightState, TurnSignal};
use whyroad_model::vocabulary::{CONTEXT_KINDS, ContextValues, FACILITY_KINDS, SIGN_KINDS};
use whyroad_model::{Column, Drive, Nanos};
use whyroad_signals::{Catalog, SignalKind, SignalScope};

/// A drive with everything that a log can have: a lane change, a bend of nothing, a lead, a walker, a gap, lights.
pub(crate) fn full() -> Drive {
    let shift = |t: f64| 1.75 * (1.0 - (PI * ((t - 2.0).clamp(0.0, 4.1)) / 4.1).cos());
    let mut d = drive(90, move |t| (9.0 * t, shift(t), (shift(t + 0.01) - shift(t - 0.01)).atan2(0.18)));
    let mut m = road();
    m.crosswalks = vec![area("z", &[(60.0, -5.0), (63.0, -5.0), (63.0, 10.0), (60.0, 10.0)])];
    m.junctions = vec![area("j", &[(64.0, -5.0), (80.0, -5.0), (80.0, 10.0), (64.0, 10.0)])];
    m.stop_lines = vec![StopLine {
        id: "s".into(),
        line: vec![Point3 { x: 58.0, y: 3.5, z: 0.0 }],
        lane_ids: vec!["l0".into()],
    }];
    d.map = Some(m);
    car(&mut d, "lead", |t| (25.0 + 7.0 * t, 0.2, 0.0));
    car(&mut d, "on", |t| (120.0 - 11.0 * t, 7.0, PI - 0.013));
    add(&mut d, "ped", Pedestrian, (0.6, 0.7), |t| (61.0, -8.0 + 1.4 * t, FRAC_PI_2));
    add_seen(&mut d, "bus", Bus, (12.0, 2.6), |i| i > 5 && i != 40, |t| (-30.0 + 9.0 * t, 3.4, 0.01));
    for track in &mut d.tracks {
        track.turn_signal = vec![Some(TurnSignal::Off); track.frames.len()];
    }
    let light = |time: i64, color| LightState {
        lane_id: "l0".into(),
        to_lane_id: None,
        time: Nanos(time),
        color,
        countdown_s: Some(9.0),
    };
    d.lights = Some(vec![light(0, LightColor::Red), light(5_000_000_000, LightColor::Green)]);
    let bus = &mut d.ego.as_mut().unwrap().bus;
    bus.brake = vec![Some(false); 90];
    bus.aeb = vec![Some(false); 90];
    bus.cruise = vec![Some(true); 90];
    bus.turn_signal = vec![Some(TurnSignal::Left); 90];
    bus.route_command = vec![Some("straight".into()); 90];
    tell_the_road(&mut d);
    d
}

/// Limits, marks, tags, one facility and sign of every kind, one context state of every kind.
fn tell_the_road(d: &mut Drive) {
    let map = d.map.as_mut().unwrap();
    for lane in &mut map.lanes {
        lane.speed_limit_mps = Some(13.89);
        (lane.left_mark, lane.right_mark) = (LaneMark::Dashed, LaneMark::Solid);
    }
    map.lanes[0].tags = vec!["acceleration".into()];
    map.complete_for = ["bus_lane", "tidal", "variable"].map(str::to_owned).into();
    for (i, kind) in FACILITY_KINDS.iter().enumerate() {
        let (x, half) = (20.3 + 7.0 * i as f64, 2.0);
        let boundary =
            area("", &[(x, -30.0), (x + half, -30.0), (x + half, 30.0), (x, 30.0), (x, -30.0)]).boundary;
        map.facilities.push(Facility { id: (*kind).into(), kind: (*kind).into(), boundary });
    }
    map.facilities.sort_by(|a, b| a.id.cmp(&b.id));
    for (i, kind) in SIGN_KINDS.iter().enumerate() {
        let position = Point3 { x: 31.0 + 5.0 * i as f64, y: -5.0, z: 2.0 };
        let (id, kind) = ((*kind).to_owned(), (*kind).to_owned());
        map.signs.push(Sign { id, kind, position, lane_ids: vec![], value: None, facing: None });
    }
    let states = CONTEXT_KINDS.iter().map(|(kind, values)| ContextState {
        time: Nanos(0),
        kind: (*kind).into(),
        value: match values {
            ContextValues::Words(words) => words[0].into(),
            ContextValues::Number(_) => "100".into(),
        },
        source: "test".into(),
        confidence: None,
    });
    d.context = Some(states.collect());
}

#[test]
fn the_table_agrees_with_the_catalog() {
    for (drive, complete) in
        [(full(), true), (drive(30, |t| (5.0 * t, 0.0, 0.0)), false), (Drive::default(), false)]
    {
        let table = Table::of(&drive).0;
        let rows = table.targets.iter().map(|t| t.frames.len()).sum::<usize>();
        for def in Catalog::bundled().iter() {
            let (columns, others, len) = match def.scope {
                SignalScope::Frame => (&table.frame_columns, &table.target_columns, table.times.len()),
                SignalScope::Target => (&table.target_columns, &table.frame_columns, rows),
                SignalScope::Object | SignalScope::Pair => continue,
            };
            assert!(!others.contains_key(&def.name), "{} is in the other scope", def.name);
            let missing = table.unavailable.contains_key(&def.name);
            let Some(column) = columns.get(&def.name) else {
                assert!(missing, "{} is neither given nor unavailable", def.name);
                continue;
            };
            assert!(!missing && !table.partial.contains_key(&def.name), "{} is given and lacking", def.name);
            assert_eq!(column.len(), len, "{}", def.name);
            match (column, &def.kind) {
                (Column::Number(_), SignalKind::Number(_)) | (Column::Flag(_), SignalKind::Flag) => {}
                (Column::Category { names, codes }, SignalKind::Category(values)) => {
                    assert_eq!(names, values, "{}", def.name);
                    assert!(
                        codes.iter().all(|&c| usize::from(c) < values.len() || c == u16::MAX),
                        "{}",
                        def.name
                    );
                }
                _ => panic!("{} has values of another kind than the catalog says", def.name),
            }
            // The way here is shorter than the 500 m over which these look: unknown, as the catalog says.
            let far = ["map.bends_around", "map.mean_grade"].contains(&def.name.as_str());
            if complete && !far {
                assert!(column.known_count() > 0, "{} is known nowhere", def.name);
            }
        }
        let known =
            table.frame_columns.keys().chain(table.target_columns.keys()).chain(table.unavailable.keys());
        // Beside a number that is estimated stands its deviation, `<signal>.sd` (docs/reference/lake.md).
        let of = |n: &str| Catalog::bundled().get(n.strip_suffix(".sd").unwrap_or(n)).is_some();
        assert!(known.into_iter().all(|n| of(n)));
        assert!(!complete || table.unavailable.is_empty(), "{:?}", table.unavailable);
    }
}

#[test]
fn the_light_that_holds_is_the_latest_one_ahead() {
    let t = Table::of(&full());
    // The ego is in l0 from 4 s on (its lane change crosses the line then); the light turns green at 5 s of the
    // epoch, which is 4 s of the drive (it starts at 1 s).
    assert_eq!(t.ego_category("light.state", 10), Some("none"), "the right lane has no light");
    assert_eq!(t.ego_category("light.state", 50), Some("green"));
    // At 5 s: x = 45, front bumper 47, stop line 58.
    near(t.ego("light.distance_to_stop_line", 50), 11.0, 0.1);
    assert_eq!(t.ego_category("light.state", 70), Some("none"), "passed at 6.4 s");
}

fn moved(mut d: Drive, angle: f64, dx: f64, dy: f64, later: i64) -> Drive {
    let (sin, cos) = angle.sin_cos();
    let turn = |x: f64, y: f64| (x * cos - y * sin, x * sin + y * cos);
    let shift = |m: &mut whyroad_model::scene::Motion| {
        for i in 0..m.len() {
            (m.vx[i], m.vy[i]) = turn(m.vx[i], m.vy[i]);
            let (x, y) = turn(m.x[i], m.y[i]);
            (m.x[i], m.y[i]) = (x + dx, y + dy);
            m.heading[i] = (m.heading[i] + angle).sin().atan2((m.heading[i] + angle).cos());
        }
    };
    shift(&mut d.ego.as_mut().unwrap().motion);
    d.tracks.iter_mut().for_each(|t| shift(&mut t.motion));
    let map = d.map.as_mut().unwrap();
    let lanes = map.lanes.iter_mut().flat_map(|l| [&mut l.left, &mut l.right, &mut l.center]);
    let areas = map.crosswalks.iter_mut().chain(&mut map.junctions).map(|a| &mut a.boundary);
    let areas = areas.chain(map.facilities.iter_mut().map(|f| &mut f.boundary));
    for s in &mut map.signs {
        let (x, y) = turn(s.position.x, s.position.y);
        (s.position.x, s.position.y) = (x + dx, y + dy);
    }
    for p in lanes.chain(areas).chain(map.stop_lines.iter_mut().map(|l| &mut l.line)).flatten() {
        let (x, y) = turn(p.x, p.y);
        (p.x, p.y) = (x + dx, y + dy);
    }
    d.times.iter_mut().for_each(|t| t.0 += later);
    d.lights.iter_mut().flatten().for_each(|l| l.time.0 += later);
    d.context.iter_mut().flatten().for_each(|c| c.time.0 += later);
    d
}

/// Values agree, numbers to within what moving the origin by kilometers costs in rounding.
fn same(a: &Column, b: &Column, row: usize) -> bool {
    match (a.number(row), b.number(row)) {
        (Some(x), Some(y)) => x == y || (x - y).abs() < 1e-4 * (1.0 + x.abs()),
        (None, None) => a.flag(row) == b.flag(row) && a.category(row) == b.category(row),
        _ => false,
    }
}

/// Some signals are found by probing at equal steps. In a scene drawn along the axes, places of the grid lie exactly
/// on edges of boxes and areas, and rounding puts them on either side: such a signal may differ by a step or two, m,
/// rad and share.
fn step_of(name: &str) -> f64 {
    match name {
        // The path is probed every half meter.
        "map.distance_to_junction" | "map.distance_to_crosswalk" => 0.5,
        // Places along the path, a meter apart.
        "map.sight_distance" => 1.0,
        // Of 30 by 4 places, a row across or along.
        "map.hidden_beside" => 30.0 / 120.0,
        // Until a place of that grid: a meter at the 9 m/s of this drive.
        "map.time_to_hidden_beside" => 0.12,
        "map.sight_angle" => 0.05,
        _ => 0.0,
    }
}

/// A lake may come from elsewhere, so a drive may have positions that `ingest` would have refused: whatever they are,
/// the work on them is bounded.
#[test]
fn a_position_at_a_billion_meters_costs_no_more_than_another() {
    let one = |d: &mut Drive| d.ego.as_mut().unwrap().motion.x[45] = 1e9;
    let all = |d: &mut Drive| d.ego.as_mut().unwrap().motion.x.iter_mut().for_each(|x| *x += 1e9);
    let half = |d: &mut Drive| d.ego.as_mut().unwrap().motion.y[45..].iter_mut().for_each(|y| *y = -1e9);
    let fast = |d: &mut Drive| {
        let motion = &mut d.ego.as_mut().unwrap().motion;
        (0..90).for_each(|i| motion.x[i] = 1e9 * i as f64);
    };
    let lead = |d: &mut Drive| d.tracks[0].motion.x[20] = 1e9;
    let lane = |d: &mut Drive| d.map.as_mut().unwrap().lanes[0].center[0].x = -1e9;
    let large = |d: &mut Drive| d.tracks[0].length_m.iter_mut().for_each(|l| *l = 1e9);
    type Change<'a> = (&'a str, &'a dyn Fn(&mut Drive));
    let changes: [Change<'_>; 7] = [
        ("one frame of the ego", &one),
        ("the whole ego", &all),
        ("half of the ego", &half),
        ("a speed of 1e10 m/s", &fast),
        ("one row of a track", &lead),
        ("one point of a lane", &lane),
        ("a length", &large),
    ];
    for (what, change) in changes {
        let mut d = full();
        change(&mut d);
        let (done, waits) = std::sync::mpsc::channel();
        std::thread::spawn(move || done.send(whyroad_signals::derive(&d).frame_columns.len()));
        let columns = waits.recv_timeout(std::time::Duration::from_secs(20));
        assert!(columns.is_ok_and(|n| n > 50), "{what}: {columns:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nothing_depends_on_the_worlds_axes_origin_or_clock(
        angle in -PI..PI, dx in -5e3..5e3, dy in -5e3..5e3, later in 0_i64..1_000_000_000_000,
    ) {
        let (a, b) = (Table::of(&full()).0, Table::of(&moved(full(), angle, dx, dy, later)).0);
        for (name, column) in a.frame_columns.iter().chain(&a.target_columns) {
            // The world's own quantity; and quotients that magnify a gap's millimeters where the denominator is small.
            if matches!(name.as_str(), "ego.heading" | "map.time_to_junction" | "map.time_to_crosswalk" | "target.dst") {
                continue;
            }
            let other = b.frame_columns.get(name).or_else(|| b.target_columns.get(name)).unwrap();
            let step = step_of(name);
            let alike = |i: usize| same(column, other, i)
                || matches!((column.number(i), other.number(i)), (Some(x), Some(y)) if (x - y).abs() <= step);
            let differing = (0..column.len()).filter(|&i| !alike(i)).count();
            // A value exactly on a threshold may fall to either side of it by rounding: one row at most. (One row of
            // map.hidden_beside and map.sight_distance does: there the eye touches an edge, and sees everything or
            // nothing.)
            prop_assert!(differing <= 1, "{name}: {differing} of {} rows differ", column.len());
        }
    }
}
