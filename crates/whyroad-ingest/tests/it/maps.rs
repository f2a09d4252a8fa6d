//! Maps beside a log. The network of `tests/fixtures/maps` was written twice by SUMO's netconvert, as its own format
//! and as OpenDRIVE; our two readers must find the same roads in both.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use whyroad_ingest::{
    AdapterRef, MAP, MAP_OFFSET, MAP_ORIGIN, MAP_PROJECTION, Options, Source, SourceReport, sumo,
};
use whyroad_lake::{Lake, WriteOutcome};
use whyroad_model::road_map::{Lane, LaneKind, LayerState, MapLayer, Point3};
use whyroad_model::{Drive, Need, RoadMap};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/maps").join(name)
}

fn read(options: &Options) -> (Drive, SourceReport) {
    let source = Source { adapter: AdapterRef(&sumo::Sumo), path: fixture("town.fcd.xml.gz"), part: None };
    let (drive, report) = whyroad_ingest::read(&source, options);
    assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
    (drive.unwrap(), report)
}

fn codes(report: &SourceReport) -> Vec<&'static str> {
    report.diagnostics.iter().map(|d| d.code).filter(|c| !c.starts_with("sumo.")).collect()
}

fn both() -> (RoadMap, RoadMap) {
    let net = read(&Options::default().with(&sumo::NET, fixture("town.net.xml"))).0.map.unwrap();
    let (drive, report) = read(&Options::default().with(&MAP, fixture("town.xodr")));
    assert_eq!(codes(&report), ["map.replaced", "ingest.limit.connector"], "{:?}", report.diagnostics);
    (net, drive.map.unwrap())
}

fn apart(a: Option<&Point3>, b: Option<&Point3>) -> f64 {
    let (a, b) = (a.unwrap(), b.unwrap());
    (a.x - b.x).hypot(a.y - b.y)
}

/// Lanes outside junctions, and for each the one of the other map that begins and ends where it does.
fn pairs<'m>(net: &'m RoadMap, xodr: &'m RoadMap) -> Vec<(&'m Lane, &'m Lane)> {
    let outside = |m: &'m RoadMap| m.lanes.iter().filter(|l| !l.in_junction && !l.id.starts_with(':'));
    let of_xodr: Vec<&Lane> = outside(xodr).collect();
    outside(net)
        .map(|a| {
            let reach = |b: &&Lane| {
                apart(a.center.first(), b.center.first()).max(apart(a.center.last(), b.center.last()))
            };
            let near: Vec<&&Lane> = of_xodr.iter().filter(|b| reach(b) < 0.25).collect();
            assert_eq!(near.len(), 1, "{}", a.id);
            (a, *near[0])
        })
        .collect()
}

#[test]
fn the_same_network_as_sumo_and_as_opendrive() {
    let (net, xodr) = both();
    let pairs = pairs(&net, &xodr);
    assert_eq!(pairs.len(), 18);
    let name: BTreeMap<&str, &str> = pairs.iter().map(|(a, b)| (a.id.as_str(), b.id.as_str())).collect();
    for (a, b) in &pairs {
        assert_eq!(a.kind, b.kind, "{}", a.id);
        // netconvert writes widths and limits to two digits.
        assert!((a.width_m.unwrap() - b.width_m.unwrap()).abs() < 0.01, "{}", a.id);
        assert!((a.speed_limit_mps.unwrap() - b.speed_limit_mps.unwrap()).abs() < 0.01, "{}", a.id);
        let other = |id: &Option<String>| id.as_deref().map(|id| name[id].to_owned());
        assert_eq!(other(&a.right_neighbor), b.right_neighbor, "{}", a.id);
        // One lies on the other: half way between two corners, and at the corners but for their rounding, which
        // netconvert does for OpenDRIVE.
        let off = |p: Point3| b.center.windows(2).map(|w| to_segment(w[0], w[1], p)).fold(f64::MAX, f64::min);
        for w in a.center.windows(2) {
            let middle = Point3 { x: (w[0].x + w[1].x) / 2.0, y: (w[0].y + w[1].y) / 2.0, z: 0.0 };
            assert!(off(middle) < 0.05, "{}: {}", a.id, off(middle));
            assert!(off(w[1]) < 0.7, "{}: {}", a.id, off(w[1]));
        }
    }
    // Which lanes outside of junctions can be reached from which.
    let reached = |map: &RoadMap, from: &Lane, inside: &dyn Fn(&Lane) -> bool| -> BTreeSet<String> {
        let (mut open, mut out) = (from.successors.clone(), BTreeSet::new());
        while let Some(id) = open.pop() {
            match map.lane(&id) {
                Some(l) if inside(l) => open.extend(l.successors.iter().cloned()),
                Some(l) => drop(out.insert(l.id.clone())),
                None => {}
            }
        }
        out
    };
    let outside: BTreeSet<&str> = name.values().copied().collect();
    for (a, b) in pairs.iter().filter(|(a, _)| a.kind == LaneKind::Vehicle) {
        let want: BTreeSet<String> = reached(&net, a, &|l| l.id.starts_with(':'))
            .iter()
            .map(|id| name[id.as_str()].to_owned())
            .collect();
        assert_eq!(reached(&xodr, b, &|l| !outside.contains(l.id.as_str())), want, "{}", a.id);
        // Those that lead out of the network lead out of the map.
        let leaves = |l: &Lane| l.successors.iter().any(|s| s.starts_with("beyond:"));
        assert_eq!(leaves(a), leaves(b), "{}", a.id);
        assert_eq!(a.junction_id.is_some(), b.junction_id.is_some(), "{}", a.id);
    }
    // One crossroads; the place at which the motorway parts is none in either.
    assert_eq!((net.junctions.len(), xodr.junctions.len()), (1, 1));
    assert_eq!(net.crosswalks.len(), xodr.crosswalks.len());
    let stops = |m: &RoadMap| -> BTreeSet<String> {
        let vehicles = m.stop_lines.iter().flat_map(|s| s.lane_ids.clone());
        vehicles.collect()
    };
    let want: BTreeSet<String> =
        stops(&net).iter().filter_map(|id| name.get(id.as_str())).map(|s| (*s).to_owned()).collect();
    assert_eq!(stops(&xodr), want);
    for line in &xodr.stop_lines {
        let theirs =
            net.stop_lines.iter().map(|s| apart(s.line.first(), line.line.first())).fold(f64::MAX, f64::min);
        assert!(theirs < 0.25, "{}: {theirs}", line.id);
    }
    assert_eq!(xodr.layer(MapLayer::StopLines), LayerState::Derived);
    assert_eq!(xodr.layer(MapLayer::Connections), LayerState::Complete);
}

fn to_segment(a: Point3, b: Point3, p: Point3) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let share = (((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy).max(1e-12)).clamp(0.0, 1.0);
    (p.x - a.x - share * dx).hypot(p.y - a.y - share * dy)
}

#[test]
fn a_lanelet2_map_in_its_own_meters_and_in_degrees() {
    // Drawn on the approach from the west of the same town (`street.osm`): lanes at y = 98.4 and 95.2.
    let of_a = || Options::default().with(&sumo::EGO, "a").with(&MAP, fixture("street.osm"));
    let (drive, report) = read(&of_a());
    // The others drive where this map has nothing.
    assert_eq!(codes(&report), ["map.replaced", "map.vehicles.off"], "{:?}", report.diagnostics);
    let map = drive.map.unwrap();
    let ids: Vec<&str> = map.lanes.iter().map(|l| l.id.as_str()).collect();
    assert_eq!(ids, ["2001", "2002", "2003", "2004"]);
    let (left, right) = (map.lane("2001").unwrap(), map.lane("2002").unwrap());
    assert!((left.center[0].y - 98.4).abs() < 1e-9 && (right.center[0].y - 95.2).abs() < 1e-9);
    assert_eq!(
        (right.left_neighbor.as_deref(), &left.successors[..]),
        (Some("2001"), &["2003".to_owned()][..])
    );
    assert!((left.speed_limit_mps.unwrap() - 50.0 / 3.6).abs() < 1e-9);
    assert_eq!((map.crosswalks.len(), map.junctions.len()), (1, 1));
    assert_eq!(map.stop_lines[0].lane_ids, ["2001", "2002"]);
    // The degrees are those of the same points around 49 N 8 E.
    let degrees = of_a().with(&MAP_ORIGIN, "49.0,8.0").with(&MAP_PROJECTION, "local");
    let there = read(&degrees).0.map.unwrap();
    for (a, b) in map.lanes.iter().zip(&there.lanes) {
        for (p, q) in a.left.iter().zip(&b.left) {
            assert!((p.x - q.x).hypot(p.y - q.y) < 0.02, "{} {p:?} {q:?}", a.id);
        }
    }
}

#[test]
fn the_map_stays_with_the_drive_and_another_map_replaces_it() {
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let source = Source { adapter: AdapterRef(&sumo::Sumo), path: fixture("town.fcd.xml.gz"), part: None };
    let outcome = |options: &Options| whyroad_ingest::ingest(&source, options, &lake).outcome;
    let with = Options::default().with(&MAP, fixture("town.xodr"));
    assert_eq!(
        (outcome(&with), outcome(&with)),
        (Some(WriteOutcome::Written), Some(WriteOutcome::Unchanged))
    );
    assert_eq!(outcome(&Options::default()), Some(WriteOutcome::Replaced));
    let drive = {
        outcome(&with);
        lake.read_drive(&lake.drive_ids()[0]).unwrap()
    };
    assert!(drive.map.unwrap().lane("72_0_-1").is_some() && drive.meta.map_ref.as_deref() == Some("town"));
    assert!(!drive.meta.missing.contains(&Need::Map));
}

/// The town with all reference lines moved by this, m.
fn town_moved(dx: f64, dy: f64) -> String {
    let text = fs::read_to_string(fixture("town.xodr")).unwrap();
    let moved = |text: &str, attribute: &str, by: f64| {
        let mut parts = text.split(attribute);
        let mut out = parts.next().unwrap().to_owned();
        for part in parts {
            let (value, rest) = part.split_once('"').unwrap();
            out += &format!("{attribute}{}\"{rest}", value.parse::<f64>().unwrap() + by);
        }
        out
    };
    moved(&moved(&text, " x=\"", dx), " y=\"", dy)
}

/// A map 1.5 m beside the road: the ego is on it, and lanes and lane changes would be wrong. SUMO's cars drive in the
/// middle of lanes.
#[test]
fn a_shifted_map_is_reported_with_the_shift_and_can_be_moved_back() {
    let dir = tempfile::tempdir().unwrap();
    let moved = dir.path().join("moved.xodr");
    fs::write(&moved, town_moved(1.0, -1.2)).unwrap();
    let with = Options::default().with(&MAP, moved);
    let (_, report) = read(&with);
    let said = report.diagnostics.iter().find(|d| d.code == "ingest.map.shifted").expect("a shift");
    let hint = said.hint.as_ref().unwrap();
    let stated = hint.en.split("--map-offset ").nth(1).unwrap().split('`').next().unwrap();
    let (x, y) = stated.split_once(',').unwrap();
    // The steps of the search are 0.25 m.
    let near = |text: &str, want: f64| (text.parse::<f64>().unwrap() - want).abs() <= 0.25;
    assert!(near(x, -1.0) && near(y, 1.2), "{stated}");
    let is_shifted = |report: &SourceReport| codes(report).contains(&"ingest.map.shifted");
    let (back, report) = read(&with.with(&MAP_OFFSET, "-1.0,1.2"));
    assert!(!is_shifted(&report), "{:?}", report.diagnostics);
    let (right, report) = read(&Options::default().with(&MAP, fixture("town.xodr")));
    assert!(!is_shifted(&report), "{:?}", report.diagnostics);
    let (back, right) = (back.map.unwrap(), right.map.unwrap());
    let points = |m: &RoadMap| -> Vec<Point3> { m.lanes.iter().flat_map(|l| l.center.clone()).collect() };
    for (p, q) in points(&back).iter().zip(points(&right)) {
        assert!((p.x - q.x).hypot(p.y - q.y) < 1e-6, "{p:?} {q:?}");
    }
    let wrong = Options::default().with(&MAP, fixture("town.xodr")).with(&MAP_OFFSET, "1.0");
    assert!(codes(&read(&wrong).1).contains(&"map.placement"));
}

#[test]
fn a_map_in_another_frame_is_reported_and_not_used() {
    let dir = tempfile::tempdir().unwrap();
    let moved = dir.path().join("moved.xodr");
    fs::write(&moved, town_moved(50_000.0, 0.0)).unwrap();
    let (drive, report) = read(&Options::default().with(&MAP, moved));
    assert!(codes(&report).contains(&"ingest.map.off"), "{:?}", report.diagnostics);
    let said = report.diagnostics.iter().find(|d| d.code == "ingest.map.off").unwrap();
    assert!(said.message.en.contains("another frame"), "{}", said.message.en);
    assert!(drive.map.is_none() && drive.meta.missing.contains(&Need::Map));
    assert!(codes(&report).contains(&"map.vehicles.off"));
    // Nothing of it is in the lake.
    let count = report.tables.iter().find(|t| t.table == "map").unwrap();
    assert!(count.adds_up() && count.read > 0 && count.kept_total() == 0, "{count:?}");
}

#[test]
fn files_that_are_no_maps_are_named_and_the_drive_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.xodr");
    fs::write(&path, "<net/>").unwrap();
    let (drive, report) = read(&Options::default().with(&MAP, path.clone()));
    assert_eq!(codes(&report), ["map.file.unreadable"]);
    assert!(drive.map.is_some(), "the network that lies beside the log");
    // Cut in the middle: what was read is used.
    let bytes = fs::read(fixture("town.xodr")).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let (drive, report) = read(&Options::default().with(&MAP, path.clone()));
    assert!(codes(&report).contains(&"map.file.broken"));
    assert!(drive.map.is_some_and(|m| !m.lanes.is_empty()));
    // Degrees without an origin.
    fs::write(&path, r#"<osm><node id="1" lat="49" lon="8"/></osm>"#).unwrap();
    assert_eq!(codes(&read(&Options::default().with(&MAP, path.clone())).1), ["map.placement"]);
    let wrong = Options::default().with(&MAP, path).with(&MAP_ORIGIN, "here");
    assert_eq!(codes(&read(&wrong).1), ["map.placement"]);
}
