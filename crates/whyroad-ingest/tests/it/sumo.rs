//! A network and a drive small enough to compute by hand (`tests/fixtures/crossroads.net.xml`, `crossroads.fcd.xml`).
//!
//! Road W-J-E runs along y = 0, one lane each way, 3.2 m wide; N and S join at J (0, 0), so J is a junction. West of
//! it, at P (-50, 0), the road is joined by nothing: P is none. The ego (5 m long) drives east in the south lane (y =
//! -1.6) at 10 m/s with its front bumper at x = -40 + 10 t.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};
use whyroad_ingest::{AdapterRef, Options, START, SourceReport, find_sources, sumo};
use whyroad_model::road_map::{LaneKind, TurnKind};
use whyroad_model::scene::{LightColor, TurnSignal};
use whyroad_model::{Drive, Nanos, Need, ObjectClass, Severity};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures")
}

fn codes(r: &SourceReport) -> Vec<&'static str> {
    r.diagnostics.iter().map(|d| d.code).collect()
}

fn crossroads() -> (Drive, SourceReport) {
    let (drive, report) = sumo::read(&fixtures().join("crossroads.fcd.xml"), &Options::default());
    assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
    (drive.unwrap(), report)
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6
}

/// Lanes of left-hand networks are numbered from the left; the opposite direction is on the right.
#[test]
fn left_hand_networks_are_mirrored() {
    let dir = fcd(0.1, 3, |t| vec![car("ego", 10.0 + 10.0 * t, 1.6)]);
    let lanes = |edge: &str, ends: &str, rows: [&str; 2]| {
        let row = |(i, y): (usize, &&str)| {
            format!(r#"<lane id="{edge}_{i}" index="{i}" speed="13.9" length="100" shape="{y}"/>"#)
        };
        let rows: String = rows.iter().enumerate().map(row).collect();
        format!(r#"<edge id="{edge}" {ends}>{rows}</edge>"#)
    };
    let east = lanes("east", r#"from="a" to="b""#, ["0,4.8 100,4.8", "0,1.6 100,1.6"]);
    let west = lanes("west", r#"from="b" to="a""#, ["100,-4.8 0,-4.8", "100,-1.6 0,-1.6"]);
    fs::write(dir.path().join("net.xml"), format!(r#"<net lefthand="true">{east}{west}</net>"#)).unwrap();
    let map = read(&dir).0.unwrap().map.unwrap();
    let beside = |id: &str| {
        let lane = map.lane(id).unwrap();
        (lane.left_neighbor.clone(), lane.right_neighbor.clone())
    };
    assert_eq!(beside("east_0"), (None, Some("east_1".to_owned())));
    assert_eq!(beside("east_1"), (Some("east_0".to_owned()), Some("west_1".to_owned())));
    assert_eq!(beside("west_1"), (Some("west_0".to_owned()), Some("east_1".to_owned())));
}

/// FCD of a few objects: `(id, attributes)` for each step of `step_s`.
fn fcd(step_s: f64, steps: usize, objects: impl Fn(f64) -> Vec<String>) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let mut text = String::from("<fcd-export>\n");
    for i in 0..steps {
        let t = i as f64 * step_s;
        text += &format!("<timestep time=\"{t:.2}\">\n{}\n</timestep>\n", objects(t).join("\n"));
    }
    fs::write(dir.path().join("fcd.xml"), text + "</fcd-export>\n").unwrap();
    dir
}

fn car(id: &str, x: f64, y: f64) -> String {
    format!(
        r#"<vehicle id="{id}" x="{x:.2}" y="{y:.2}" angle="90.00" type="DEFAULT_VEHTYPE" speed="10.00"/>"#
    )
}

fn read(dir: &tempfile::TempDir) -> (Option<Drive>, SourceReport) {
    let (drive, report) = sumo::read(&dir.path().join("fcd.xml"), &Options::default());
    assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
    (drive, report)
}

/// FCD counts seconds from the start of the simulation: when it is driven is known only if the user says so.
#[test]
fn the_date_is_missing_unless_a_start_is_given() {
    assert!(crossroads().0.meta.missing.contains(&Need::Date));
    let options = Options::default().with(&START, Nanos::parse_iso("2025-06-01T07:00:00Z").unwrap());
    let (drive, _) = sumo::read(&fixtures().join("crossroads.fcd.xml"), &options);
    assert!(!drive.unwrap().meta.missing.contains(&Need::Date));
}

#[test]
fn bumpers_become_centers_and_degrees_from_north_radians_from_east() {
    let (drive, report) = crossroads();
    let drive = crate::estimated(drive);
    assert!(report.diagnostics.is_empty(), "{:?}", report.diagnostics);
    assert_eq!(drive.meta.drive_id.as_str(), "crossroads-ego");
    assert_eq!(drive.times[0], Nanos::parse_iso("2026-01-01T00:00:00Z").unwrap());
    assert_eq!(drive.times[3], Nanos::parse_iso("2026-01-01T00:00:00.300Z").unwrap());
    let ego = drive.ego.as_ref().unwrap();
    assert_eq!((ego.length_m, ego.reference_to_centre_m), (5.0, -2.5));
    for i in 0..5 {
        assert!(
            near(ego.motion.x[i], -42.5 + i as f64)
                && near(ego.motion.y[i], -1.6)
                && near(ego.motion.heading[i], 0.0)
        );
        assert!(
            near(ego.motion.vx[i], 10.0) && near(ego.motion.vy[i], 0.0) && near(ego.motion.yaw_rate[i], 0.0)
        );
    }
    // FCD's own acceleration (1.5 at step 2), signals 2 (left) from step 2, 8 (brake) at step 4 beside it.
    assert!(near(ego.motion.accel[2], 1.5));
    assert_eq!(ego.bus.turn_signal[1..3], [Some(TurnSignal::Off), Some(TurnSignal::Left)]);
    assert_eq!(ego.bus.brake[3..5], [Some(false), Some(true)]);

    assert!(drive.track(&"ego".into()).is_none(), "the ego is not among the tracks");
    // The oncoming lorry: 9 m long by its vType, heading west (270 degrees), so its center is east of its bumper.
    let lorry = drive.track(&"lorry".into()).unwrap();
    assert_eq!((lorry.class, lorry.source_class.as_str()), (ObjectClass::Truck, "truck/lorry9"));
    assert!(
        near(lorry.motion.x[0], 30.0 + 4.5)
            && near(lorry.motion.heading[0], PI)
            && near(lorry.motion.vx[0], -8.0)
    );
    // A northbound cyclist (0 degrees), SUMO's default 1.6 m: 0.8 m behind its front wheel.
    let bike = drive.track(&"bike".into()).unwrap();
    assert_eq!(bike.class, ObjectClass::Bicycle);
    assert!(
        near(bike.motion.y[0], -20.8)
            && near(bike.motion.heading[0], PI / 2.0)
            && near(bike.motion.vy[0], 4.0)
    );
    // A person whose stated speed is wrong: 1.5 m/s north by its positions.
    let walker = drive.track(&"walker".into()).unwrap();
    assert_eq!(walker.class, ObjectClass::Pedestrian);
    assert!(
        near(walker.motion.y[0], 5.0) && near(walker.motion.vy[2], 1.5) && near(walker.motion.vx[2], 0.0)
    );
    assert!(drive.track(&"rider".into()).is_none(), "a person in a vehicle has no box of its own");
    // The lorry leaves after step 2.
    assert_eq!(lorry.frames, [0, 1, 2]);
}

#[test]
fn the_network_becomes_a_map() {
    let map = crossroads().0.map.unwrap();
    let lane = |id: &str| map.lane(id).unwrap();
    // South edge y = -3.2, north edge y = 0 for the eastbound lane.
    let east = lane("pj_1");
    assert!(east.left.iter().all(|p| near(p.y, 0.0)) && east.right.iter().all(|p| near(p.y, -3.2)));
    assert_eq!((east.kind, east.speed_limit_mps, east.in_junction), (LaneKind::Vehicle, Some(13.89), false));
    assert_eq!(east.junction_id.as_deref(), Some("J"));
    assert_eq!(lane("pj_0").kind, LaneKind::Sidewalk);
    assert_eq!((east.right_neighbor.as_deref(), east.left_neighbor.as_deref()), (Some("pj_0"), Some("jp_1")));
    assert_eq!(lane("jp_1").left_neighbor.as_deref(), Some("pj_1"), "the opposite lane");
    assert_eq!(east.successors, [":J_0_0", ":J_1_0"]);
    assert_eq!((lane(":J_0_0").turn, lane(":J_1_0").turn), (Some(TurnKind::Straight), Some(TurnKind::Left)));
    assert_eq!(lane(":J_0_0").successors, ["je_0"]);
    assert_eq!(lane("je_0").predecessors, [":J_0_0"]);
    assert!(lane(":J_0_0").in_junction && lane(":J_0_0").speed_limit_mps.is_none());
    assert!(!lane(":P_0_0").in_junction, "P joins two nodes only");
    assert_eq!(lane("jn_0").kind, LaneKind::Bus);
    assert_eq!(lane("js_0").kind, LaneKind::Bike);
    assert_eq!(map.junctions.iter().map(|j| j.id.as_str()).collect::<Vec<_>>(), ["J"]);
    // The crossing runs from (-12, 3.2) to (-12, -3.2), 4 m wide.
    let corners = &map.crosswalks[0].boundary;
    let (min, max) = corners.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.x), b.max(p.x)));
    assert!(map.crosswalks.len() == 1 && near(min, -14.0) && near(max, -10.0), "{corners:?}");
    // The light at J stops pj_1 at its end, x = -10.
    assert_eq!(map.stop_lines.len(), 1);
    assert!(
        map.stop_lines[0].lane_ids == ["pj_1"] && map.stop_lines[0].line.iter().all(|p| near(p.x, -10.0))
    );
    // Neither rails nor walking areas.
    assert!(map.lane("rail_0").is_none() && map.lane(":J_w0_0").is_none());
}

#[test]
fn light_states_are_those_of_the_links() {
    let options = Options::default().with(&sumo::LIGHTS, fixtures().join("crossroads.lights.xml"));
    let (drive, _) = sumo::read(&fixtures().join("crossroads.fcd.xml"), &options);
    let lights = drive.unwrap().lights.unwrap();
    let got: Vec<_> = lights
        .iter()
        .map(|l| (l.to_lane_id.as_deref().unwrap(), l.time.0 % 1_000_000_000, l.color))
        .collect();
    // Link 0 straight, link 1 left; "Gr" at 0, "yr" at 0.2 s, "yr" again at 0.3 s (no change), "rg" at 0.4 s.
    assert_eq!(
        got,
        [
            (":J_0_0", 0, LightColor::Green),
            (":J_1_0", 0, LightColor::Red),
            (":J_0_0", 200_000_000, LightColor::Yellow),
            (":J_0_0", 400_000_000, LightColor::Red),
            (":J_1_0", 400_000_000, LightColor::GreenYield),
        ]
    );
}

#[test]
fn frames_without_the_ego_are_cut_and_counted() {
    let dir = fcd(0.1, 30, |t| {
        let mut all = vec![car("other", 50.0 + 10.0 * t, 0.0)];
        if t >= 0.95 {
            all.push(car("ego", 10.0 * t, 0.0));
        }
        all
    });
    let (drive, report) = read(&dir);
    let drive = drive.unwrap();
    assert_eq!(drive.frame_count(), 20);
    assert_eq!(
        drive.times[0].0 % 10_000_000_000,
        1_000_000_000 + Options::default().start().0 % 10_000_000_000
    );
    assert_eq!(report.tables[0].set_aside.get("ego_away"), Some(&10));
    assert_eq!(drive.tracks[0].frames.len(), 20);
    assert!(!report.lost_input() && codes(&report) == ["sumo.net.missing"]);
}

#[test]
fn twenty_hertz_is_thinned_and_one_hertz_is_filled_and_said_so() {
    let scene = |t: f64| vec![car("ego", 10.0 * t, 0.0), car("other", 30.0 + 10.0 * t, 3.0)];
    let (drive, report) = read(&fcd(0.05, 21, scene));
    assert_eq!(drive.unwrap().frame_count(), 11);
    assert_eq!(report.tables[0].set_aside.get("between_frames"), Some(&20));

    let (drive, report) = read(&fcd(1.0, 4, scene));
    let drive = crate::estimated(drive.unwrap());
    assert_eq!(drive.frame_count(), 31);
    assert!(codes(&report).contains(&"sumo.fcd.step"));
    let other = &drive.tracks[0].motion;
    assert!(near(other.x[15], 30.0 + 15.0 - 2.5) && near(other.vx[15], 10.0) && near(other.accel[15], 0.0));
}

#[test]
fn a_lane_change_without_duration_is_a_jump_and_no_speed() {
    let dir = fcd(0.1, 20, |t| vec![car("ego", 10.0 * t, if t < 0.95 { 0.0 } else { 3.2 })]);
    let (drive, report) = read(&dir);
    let warning = report.diagnostics.iter().find(|d| d.code == "sumo.fcd.lane_jump").unwrap();
    assert!(warning.message.en.starts_with("1 sideways jump"), "{}", warning.message.en);
    let m = crate::estimated(drive.unwrap()).ego.unwrap().motion;
    assert!(m.vy.iter().all(|v| near(*v, 0.0)) && m.vx.iter().all(|v| near(*v, 10.0)), "{:?}", m.vy);
}

#[test]
fn a_lane_change_with_duration_has_its_sideways_speed() {
    // 3.2 m in 3.2 s: 1 m/s to the left.
    let dir = fcd(0.1, 20, |t| vec![car("ego", 10.0 * t, t)]);
    let m = crate::estimated(read(&dir).0.unwrap()).ego.unwrap().motion;
    assert!(m.vy.iter().all(|v| near(*v, 1.0)) && m.vx.iter().all(|v| near(*v, 10.0)), "{:?}", m.vy);
}

#[test]
fn what_is_wrong_is_named_and_the_rest_is_kept() {
    let scene = |t: f64| vec![car("ego", 10.0 * t, 0.0), car("x", 9.0, 9.0)];
    let dir = fcd(0.1, 10, scene);
    let file = dir.path().join("fcd.xml");
    let text = fs::read_to_string(&file).unwrap();

    fs::write(&file, &text[..text.len() / 2]).unwrap();
    let (drive, report) = read(&dir);
    assert!(drive.unwrap().frame_count() >= 4);
    assert!(codes(&report).contains(&"sumo.fcd.broken") && report.lost_input());

    fs::write(&file, text.replacen("angle=\"90.00\"", "", 1).replacen("x=\"9.00\"", "x=\"nan\"", 1)).unwrap();
    let (drive, report) = read(&dir);
    assert_eq!(report.tables[0].dropped.get("invalid"), Some(&2));
    assert_eq!(drive.unwrap().frame_count(), 9);

    let (drive, report) = sumo::read(&file, &Options::default().with(&sumo::EGO, "nobody"));
    let error = report.diagnostics.iter().find(|d| d.severity == Severity::Error).unwrap();
    assert!(
        drive.is_none()
            && error.code == "sumo.ego.missing"
            && error.hint.as_ref().unwrap().en.contains("ego, x")
    );

    for other in ["", "no xml", "<routes/>"] {
        fs::write(&file, other).unwrap();
        let (drive, report) = read(&dir);
        assert!(
            drive.is_none() && codes(&report) == ["sumo.fcd.unreadable"],
            "{other}: {:?}",
            codes(&report)
        );
    }
}

#[test]
fn the_bundled_drives_are_found_and_read_whole() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives");
    let (sources, problems) = find_sources(Some(AdapterRef(&sumo::Sumo)), &[folder]);
    assert!(problems.is_empty());
    let names: Vec<_> =
        sources.iter().map(|s| s.path.parent().unwrap().file_name().unwrap().to_owned()).collect();
    assert_eq!(names, ["back_street", "multilane", "signal_junction"]);
    for s in &sources {
        let (drive, report) = whyroad_ingest::read(s, &Options::default());
        let drive = drive.unwrap();
        assert!(report.diagnostics.is_empty() && !report.lost_input(), "{:?}", report.diagnostics);
        assert!(drive.frame_count() > 400 && drive.map.is_some());
        assert_eq!(drive.ego.unwrap().length_m, 4.8, "from types.rou.xml, one folder up");
    }
}

#[test]
fn every_code_has_a_page() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics");
    let missing: Vec<_> =
        whyroad_ingest::codes().into_iter().filter(|c| !docs.join(format!("{c}.md")).is_file()).collect();
    assert!(missing.is_empty(), "no page for {missing:?}");
}

#[test]
fn buildings_signs_and_ramps_come_from_what_sumo_has() {
    let dir = fcd(0.1, 12, |t| vec![car("ego", 10.0 + 10.0 * t, -1.6)]);
    let lane = |id: &str, rest: &str, shape: &str| {
        format!(r#"<lane id="{id}" index="0" speed="22" length="9" {rest} shape="{shape}"/>"#)
    };
    // A ramp drawn by hand, known by the acceleration lane behind it; one imported, known by its type, in two parts
    // with a joint that has no type; a main road; and a carriageway that joins it, by its type no ramp.
    let net = format!(
        r#"<net>
        <edge id=":n_0" function="internal">{}</edge>
        <edge id=":n_1" function="internal">{}</edge>
        <edge id="main" from="w" to="n">{}</edge>
        <edge id=":n_2" function="internal">{}</edge>
        <edge id="drawn" from="y" to="n">{}</edge>
        <edge id="joining" from="v" to="n" type="highway.motorway">{}</edge>
        <edge id="linked" from="y" to="z" type="highway.motorway_link">{}</edge>
        <edge id=":z_0" function="internal">{}</edge>
        <edge id="linked_on" from="z" to="x" type="highway.motorway_link">{}</edge>
        <edge id="on" from="n" to="e">{}{}</edge>
        <connection from="main" to="on" fromLane="0" toLane="1" via=":n_1_0" dir="s"/>
        <connection from="drawn" to="on" fromLane="0" toLane="0" via=":n_0_0" dir="s"/>
        <connection from="joining" to="on" fromLane="0" toLane="0" via=":n_2_0" dir="s"/>
        <connection from="linked" to="linked_on" fromLane="0" toLane="0" via=":z_0_0" dir="s"/>
        <connection from=":z_0" to="linked_on" fromLane="0" toLane="0" dir="s"/>
        <connection from=":n_0" to="on" fromLane="0" toLane="0" dir="s"/>
        <connection from=":n_2" to="on" fromLane="0" toLane="0" dir="s"/>
        <connection from=":n_1" to="on" fromLane="0" toLane="1" dir="s"/></net>"#,
        lane(":n_0_0", "", "100,-4 102,-4"),
        lane(":n_1_0", "", "100,-1 102,-1"),
        lane("main_0", "", "0,-1 100,-1"),
        lane(":n_2_0", "", "100,-6 102,-4"),
        lane("drawn_0", "", "0,-30 100,-4"),
        lane("joining_0", "", "0,-45 100,-6"),
        lane("linked_0", "", "0,-60 100,-60"),
        lane(":z_0_0", "", "100,-60 101,-60"),
        lane("linked_on_0", "", "101,-60 200,-60"),
        lane("on_0", r#"acceleration="1""#, "102,-4 200,-4"),
        lane("on_1", "", "102,-1 200,-1"),
    );
    fs::write(dir.path().join("net.xml"), net).unwrap();
    let shapes = r#"<additional>
        <poly id="house" type="building.house" shape="0,5 10,5 10,15"/>
        <poly id="bump" type="speed_bump" shape="50,-3 50,0"/>
        <poly id="park" type="leisure.park" shape="0,50 10,50 10,60"/>
        <poi id="limit" type="sign.speed_limit" lane="main_0" pos="-20"><param key="value" value="13.89"/></poi>
        <poi id="stop" type="sign.stop" x="95" y="-4"/>
        <poi id="kiosk" type="shop" x="9" y="9"/></additional>"#;
    fs::write(dir.path().join("town.poly.xml"), shapes).unwrap();
    let (drive, report) = read(&dir);
    let map = drive.unwrap().map.unwrap();
    let tagged =
        |tag: &str| map.lanes.iter().filter(|l| l.is_tagged(tag)).map(|l| l.id.as_str()).collect::<Vec<_>>();
    assert_eq!(tagged("ramp"), [":n_0_0", ":z_0_0", "drawn_0", "linked_0", "linked_on_0"]);
    assert_eq!(tagged("acceleration"), ["on_0"]);
    let facilities: Vec<_> = map.facilities.iter().map(|f| (f.id.as_str(), f.kind.as_str())).collect();
    assert_eq!(facilities, [("bump", "speed_bump"), ("house", "building")]);
    assert_eq!(map.facilities[1].boundary.len(), 4, "closed");
    assert!(map.facilities.iter().flat_map(|f| &f.boundary).all(|p| p.z.is_nan()), "the file has no heights");
    let signs: Vec<_> = map.signs.iter().map(|s| (s.kind.as_str(), s.position.x, s.value)).collect();
    assert_eq!(signs, [("speed_limit", 80.0, Some(13.89)), ("stop", 95.0, None)]);
    assert_eq!(map.signs[0].lane_ids, ["main_0"]);
    assert_eq!(map.complete_for, ["acceleration", "bus_lane", "ramp", "roundabout", "traffic_light"]);
    let count = report.tables.iter().find(|t| t.table == "shapes").unwrap();
    assert_eq!((count.read, count.set_aside["scenery"]), (6, 2));

    fs::write(dir.path().join("town.poly.xml"), &shapes[..300]).unwrap();
    let (drive, report) = read(&dir);
    assert!(codes(&report).contains(&"sumo.shapes.unreadable"));
    assert!(
        drive.unwrap().map.unwrap().facilities.iter().any(|f| f.id == "house"),
        "what stands before the break"
    );
}

#[test]
fn a_type_may_be_an_animal_and_the_ego_may_tell_of_emergency_braking() {
    let dir = fcd(0.1, 4, |t| {
        let ego = car("ego", 10.0 * t, 0.0);
        // Active from 0.2 s on.
        let ego = ego.replace("/>", &format!(" whyroad.aeb=\"{}\"/>", u8::from(t > 0.15)));
        let cow = r#"<person id="cow" x="30.00" y="0.00" angle="90.00" type="cow" speed="0.00"/>"#;
        vec![ego, cow.to_owned(), cow.replace("cow", "walker")]
    });
    let types = r#"<additional><vType id="cow" vClass="pedestrian" length="2.2"><param key="whyroad.class" value="animal"/></vType>
<vType id="walker" vClass="pedestrian"><param key="other.class" value="animal"/></vType></additional>"#;
    fs::write(dir.path().join("types.add.xml"), types).unwrap();
    let drive = read(&dir).0.unwrap();
    assert_eq!(drive.ego.as_ref().unwrap().bus.aeb, [Some(false), Some(false), Some(true), Some(true)]);
    let class = |id: &str| drive.tracks.iter().find(|t| t.id.as_str() == id).unwrap().class;
    assert_eq!((class("cow"), class("walker")), (ObjectClass::Animal, ObjectClass::Pedestrian));
}

fn edge(id: &str, from: &str, to: &str, speed: f64, shape: &str) -> String {
    format!(
        r#"<edge id="{id}" from="{from}" to="{to}"><lane id="{id}_0" index="0" speed="{speed}" length="9" shape="{shape}"/></edge>"#
    )
}

fn inside(id: &str, shape: &str) -> String {
    format!(
        r#"<edge id=":{id}" function="internal"><lane id=":{id}_0" index="0" speed="30" length="9" shape="{shape}"/></edge>"#
    )
}

fn connection(from: &str, to: &str, via: &str) -> String {
    format!(r#"<connection from="{from}" to="{to}" fromLane="0" toLane="0" via=":{via}_0" dir="s"/>"#)
}

/// Both carriageways of a fast road use the same nodes; an exit with an ordinary type leaves one of them, and another
/// road has a side road that is driven both ways. Only the exit is a ramp, and its node is not a junction.
#[test]
fn an_exit_of_a_road_with_shared_nodes_is_a_ramp() {
    let dir = fcd(0.1, 12, |t| vec![car("ego", 10.0 + 10.0 * t, -1.6)]);
    let net = [
        edge("ab", "a", "b", 36.0, "0,-1.6 100,-1.6"),
        edge("ba", "b", "a", 36.0, "100,1.6 0,1.6"),
        edge("bc", "b", "c", 27.8, "110,-1.6 300,-1.6"),
        edge("cb", "c", "b", 36.0, "300,1.6 110,1.6"),
        edge("exit", "b", "x", 16.7, "110,-5 200,-30"),
        edge("on", "x", "y", 16.7, "202,-31 300,-80"),
        edge("cd", "c", "d", 27.8, "310,-1.6 400,-1.6"),
        edge("dc", "d", "c", 27.8, "400,1.6 310,1.6"),
        edge("side", "c", "s", 16.7, "310,-5 400,-50"),
        edge("back", "s", "c", 16.7, "400,-46 310,-1"),
        inside("b_0", "100,-1.6 110,-1.6"),
        inside("b_1", "100,-1.6 110,-5"),
        inside("b_2", "110,1.6 100,1.6"),
        inside("x_0", "200,-30 202,-31"),
        connection("ab", "bc", "b_0"),
        connection("ab", "exit", "b_1"),
        connection("cb", "ba", "b_2"),
        connection("exit", "on", "x_0"),
        r#"<connection from=":x_0" to="on" fromLane="0" toLane="0" dir="s"/>"#.to_owned(),
        connection("bc", "cd", "c_0"),
        connection("bc", "side", "c_1"),
        connection("dc", "cb", "c_2"),
        connection("back", "cd", "c_3"),
    ];
    fs::write(dir.path().join("net.xml"), format!("<net>{}</net>", net.concat())).unwrap();
    let map = read(&dir).0.unwrap().map.unwrap();
    let ramps: Vec<_> = map.lanes.iter().filter(|l| l.is_tagged("ramp")).map(|l| l.id.as_str()).collect();
    assert_eq!(ramps, [":x_0_0", "exit_0", "on_0"]);
    let junctions: Vec<_> = map.lanes.iter().filter(|l| l.in_junction).map(|l| l.id.as_str()).collect();
    assert_eq!(junctions, [""; 0], "neither where the exit leaves nor inside the ramp");
}

/// Two one-way roads in nearly opposite directions meet at a node. Where their ways cross, as in a diverging diamond
/// interchange, it is a junction; where each stays on its side, it is not.
#[test]
fn one_way_roads_that_cross_meet_at_a_junction() {
    for (y, expected) in [(2.0, vec!["c_0", ":n_0_0", ":n_1_0", "a_0"]), (-2.0, vec![])] {
        let dir = fcd(0.1, 12, |t| vec![car("ego", 10.0 + 10.0 * t, -8.0)]);
        let net = [
            edge("a", "w", "n", 14.0, "0,-10 90,-2"),
            edge("b", "n", "e", 14.0, &format!("110,{y} 200,10")),
            edge("c", "f", "n", 14.0, &format!("200,-10 110,{}", -y)),
            edge("d", "n", "v", 14.0, "90,2 0,10"),
            inside("n_0", &format!("90,-2 110,{y}")),
            inside("n_1", &format!("110,{} 90,2", -y)),
            connection("a", "b", "n_0"),
            connection("c", "d", "n_1"),
        ];
        fs::write(dir.path().join("net.xml"), format!("<net>{}</net>", net.concat())).unwrap();
        let map = read(&dir).0.unwrap().map.unwrap();
        let found: BTreeSet<_> =
            map.lanes.iter().filter(|l| l.junction_id.is_some()).map(|l| l.id.as_str()).collect();
        assert_eq!(found, expected.into_iter().collect(), "{y}");
    }
}
