//! A small map written by hand; expected places by hand.

use super::*;
use crate::maps::options::{MAP, MAP_COMPLETE, MAP_DATUM, MAP_ORIGIN, MAP_PROJECTION};
use crate::options::Options;
use whyroad_model::road_map::{LaneKind, LaneMark, Point3, TurnKind};

/// Nodes on a grid of 10 m, named by their place: id 100 + 10 * column + row, at (10 column, 4 row).
fn nodes() -> String {
    let mut out = String::new();
    for column in 0..4 {
        for row in 0..4 {
            let (id, x, y) = (100 + 10 * column + row, 10 * column, 4 * row);
            out += &format!(
                r#"<node id="{id}" lat="{}" lon="{}"><tag k="local_x" v="{x}"/><tag k="local_y" v="{y}"/>
                <tag k="ele" v="3"/></node>"#,
                49.0 + f64::from(y) / 111_000.0,
                8.0 + f64::from(x) / 73_000.0
            );
        }
    }
    out
}

fn way(id: i64, nodes: &[i64], tags: &[(&str, &str)]) -> String {
    let refs: String = nodes.iter().map(|n| format!(r#"<nd ref="{n}"/>"#)).collect();
    format!(r#"<way id="{id}">{refs}{}</way>"#, tagged(tags))
}

fn tagged(tags: &[(&str, &str)]) -> String {
    tags.iter().map(|(k, v)| format!(r#"<tag k="{k}" v="{v}"/>"#)).collect()
}

fn relation(id: i64, members: &[(&str, i64, &str)], tags: &[(&str, &str)]) -> String {
    let members: String = members
        .iter()
        .map(|(kind, id, role)| format!(r#"<member type="{kind}" ref="{id}" role="{role}"/>"#))
        .collect();
    format!(r#"<relation id="{id}">{members}{}</relation>"#, tagged(tags))
}

fn lanelet(id: i64, left: i64, right: i64, tags: &[(&str, &str)], elements: &[i64]) -> String {
    let mut members = vec![("way", left, "left"), ("way", right, "right")];
    members.extend(elements.iter().map(|e| ("relation", *e, "regulatory_element")));
    let mut all = vec![("type", "lanelet"), ("subtype", "road")];
    all.retain(|(k, _)| !tags.iter().any(|(own, _)| own == k));
    all.extend(tags);
    relation(id, &members, &all)
}

fn file(content: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.osm");
    std::fs::write(&path, format!("<?xml version=\"1.0\"?>\n<osm version=\"0.6\">{content}</osm>")).unwrap();
    (dir, path)
}

fn reading(content: &str, options: &Options) -> MapReading {
    let (_dir, path) = file(content);
    let out = read(&path, &Placement::of(options).unwrap()).unwrap();
    assert!(out.count.adds_up(), "{:?}", out.count);
    out
}

/// Two lanes eastwards from column 0 to 1, the lower of which goes on to column 2; the upper bound is drawn backwards.
fn street() -> String {
    [
        nodes(),
        way(1, &[112, 102], &[("type", "line_thin"), ("subtype", "solid_dashed")]),
        way(2, &[101, 111], &[("type", "line_thin"), ("subtype", "dashed")]),
        way(3, &[100, 110], &[("type", "curbstone")]),
        way(4, &[111, 121], &[("type", "virtual")]),
        way(5, &[110, 120], &[("type", "line_thick"), ("subtype", "solid")]),
        way(6, &[111, 110], &[("type", "stop_line")]),
        way(7, &[121, 120], &[("type", "traffic_light"), ("subtype", "red_yellow_green")]),
        way(8, &[130, 131], &[("type", "traffic_sign"), ("subtype", "de274-30")]),
        way(9, &[120, 130], &[]),
        way(10, &[121, 131], &[]),
        lanelet(50, 1, 2, &[("speed_limit", "50 km/h")], &[]),
        lanelet(51, 2, 3, &[("speed_limit", "50")], &[60]),
        lanelet(52, 4, 5, &[("turn_direction", "straight")], &[61]),
        lanelet(53, 10, 9, &[("subtype", "crosswalk")], &[]),
        lanelet(54, 99, 5, &[], &[]),
        relation(
            60,
            &[("way", 7, "refers"), ("way", 6, "ref_line")],
            &[("type", "regulatory_element"), ("subtype", "traffic_light")],
        ),
        relation(61, &[("way", 8, "refers")], &[("type", "regulatory_element"), ("subtype", "speed_limit")]),
    ]
    .concat()
}

#[test]
fn lanelets_are_turned_linked_and_marked() {
    let r = reading(&street(), &Options::default());
    let ids: Vec<&str> = r.map.lanes.iter().map(|l| l.id.as_str()).collect();
    assert_eq!(ids, ["50", "51", "52"]);
    let (upper, lower, next) =
        (r.map.lane("50").unwrap(), r.map.lane("51").unwrap(), r.map.lane("52").unwrap());
    // The upper bound runs west in the file; driving east, it is on the left.
    assert_eq!((upper.left[0].x, upper.left[0].y, upper.left[1].x), (0.0, 8.0, 10.0));
    assert_eq!((upper.center[0].y, upper.center[0].z), (6.0, 3.0));
    // Solid on the left driving west is solid on the right driving east.
    assert_eq!((upper.left_mark, upper.right_mark), (LaneMark::DashedSolid, LaneMark::Dashed));
    assert_eq!((next.left_mark, lower.right_mark), (LaneMark::None, LaneMark::Unknown));
    assert_eq!(upper.right_neighbor.as_deref(), Some("51"));
    assert_eq!(lower.left_neighbor.as_deref(), Some("50"));
    assert_eq!(
        (&lower.successors[..], &next.predecessors[..]),
        (&["52".to_owned()][..], &["51".to_owned()][..])
    );
    assert_eq!(upper.successors, ["beyond:50"]);
    assert!((upper.speed_limit_mps.unwrap() - 50.0 / 3.6).abs() < 1e-9);
    assert!((next.speed_limit_mps.unwrap() - 30.0 / 3.6).abs() < 1e-9, "by the element");
    assert!(next.in_junction && next.turn == Some(TurnKind::Straight) && r.map.junctions.len() == 1);
    assert_eq!(r.map.crosswalks[0].id, "53");
    assert_eq!(
        (r.map.stop_lines.len(), r.map.stop_lines[0].lane_ids.as_slice()),
        (1, &["51".to_owned()][..])
    );
    assert_eq!(r.map.facilities[0].kind, "traffic_light");
    assert_eq!(
        (r.map.signs[0].kind.as_str(), r.map.signs[0].lane_ids.as_slice()),
        ("speed_limit", &["52".to_owned()][..])
    );
    assert_eq!(r.invalid, ["lanelet 54: way 99 is not in the file"]);
    assert_eq!(r.map.layer(MapLayer::Connections), LayerState::Complete);
    assert_eq!(r.map.layer(MapLayer::SpeedLimits), LayerState::Complete);
    assert_eq!(r.map.layer(MapLayer::Lights), LayerState::Partial);
    assert_eq!(r.map.layer(MapLayer::Ramps), LayerState::Absent);
}

/// Members of a lanelet with bounds of several ways.
fn pieced(id: i64, left: &[i64], right: &[i64]) -> String {
    let of = |ways: &[i64], role: &'static str| ways.iter().map(|w| ("way", *w, role)).collect::<Vec<_>>();
    let members = [of(left, "left"), of(right, "right")].concat();
    relation(id, &members, &[("type", "lanelet"), ("subtype", "road")])
}

#[test]
fn a_bound_in_several_ways_is_joined_where_they_meet() {
    let painted = |subtype: &'static str| [("type", "line_thin"), ("subtype", subtype)];
    let content = [
        nodes(),
        // From column 0 to 3 in three pieces: the middle one backwards, listed last.
        way(1, &[101, 111], &painted("dashed")),
        way(2, &[121, 131], &painted("dashed")),
        way(3, &[121, 111], &painted("dashed")),
        way(4, &[100, 110], &painted("solid")),
        way(5, &[110, 120, 130], &painted("dashed")),
        // Above: one way beside all of it.
        way(6, &[102, 132], &painted("solid")),
        way(7, &[101, 111, 121, 131], &painted("solid")),
        pieced(50, &[1, 2, 3], &[4, 5]),
        pieced(51, &[6], &[1, 3, 2]),
        pieced(52, &[6], &[4, 2]),
        pieced(53, &[6], &[1, 1]),
    ]
    .concat();
    let r = reading(&content, &Options::default());
    let (lower, upper) = (r.map.lane("50").unwrap(), r.map.lane("51").unwrap());
    let xs = |line: &[Point3]| line.iter().map(|p| p.x).collect::<Vec<_>>();
    assert_eq!(xs(&lower.left), [0.0, 10.0, 20.0, 30.0]);
    assert_eq!(xs(&lower.right), [0.0, 10.0, 20.0, 30.0]);
    assert_eq!((lower.left_mark, lower.right_mark), (LaneMark::Dashed, LaneMark::Unknown));
    assert_eq!((lower.left_neighbor.as_deref(), upper.right_neighbor.as_deref()), (Some("51"), Some("50")));
    assert_eq!(
        r.invalid,
        [
            "lanelet 52: the ways of its right bound do not meet end to end; join or reorder them",
            "lanelet 53: its right bound names a way twice"
        ]
    );
}

#[test]
fn two_painted_lines_beside_each_other_are_a_crosswalk() {
    let marking = [("type", "pedestrian_marking")];
    let content = [
        street(),
        // 4 m apart and 10 m long; the second runs backwards. Then one alone, 10 m farther and at right angles.
        way(20, &[102, 112], &marking),
        way(21, &[113, 103], &marking),
        way(22, &[130, 133], &marking),
    ]
    .concat();
    let r = reading(&content, &Options::default());
    let ids: Vec<&str> = r.map.crosswalks.iter().map(|c| c.id.as_str()).collect();
    assert_eq!(ids, ["53", "crosswalk_20_21"]);
    let corners: Vec<(f64, f64)> = r.map.crosswalks[1].boundary.iter().map(|p| (p.x, p.y)).collect();
    assert_eq!(corners, [(0.0, 8.0), (10.0, 8.0), (10.0, 12.0), (0.0, 12.0), (0.0, 8.0)]);
}

#[test]
fn boards_are_found_by_their_kind_and_apply_to_all_lanes_that_name_them() {
    let sign =
        |id: i64, kind: &'static str| way(id, &[130, 131], &[("type", "traffic_sign"), ("subtype", kind)]);
    let yielding = |id: i64, board: &'static str, line: &'static str, lane: i64| {
        let members = [("way", 30, board), ("way", 6, line), ("relation", lane, "yield")];
        relation(id, &members, &[("type", "regulatory_element"), ("subtype", "right_of_way")])
    };
    let content = [
        street(),
        sign(30, "de205"),
        sign(31, "usW5-1"),
        // Faces those who come the wrong way.
        sign(32, "usR5-1"),
        // The roles the wrong way round, as in INTERACTION's DR_DEU_Roundabout_OF; then right, for another lane.
        yielding(62, "ref_line", "refers", 50),
        yielding(63, "refers", "ref_line", 51),
    ]
    .concat();
    let r = reading(&content, &Options::default());
    let signs: Vec<(&str, &[String])> =
        r.map.signs.iter().map(|s| (s.kind.as_str(), s.lane_ids.as_slice())).collect();
    let both = ["50".to_owned(), "51".to_owned()];
    assert_eq!(signs, [("yield", &both[..]), ("warning", &[][..]), ("speed_limit", &["52".to_owned()][..])]);
    let stops: Vec<&[String]> = r.map.stop_lines.iter().map(|s| s.lane_ids.as_slice()).collect();
    assert_eq!(stops, [&both[..]]);
}

/// Lanelet2, RegulatoryElementTagging, All Way Stop: the lines are in the order of the lanelets; without lines, they
/// stop where they end. Lanes eastwards at y = 2 and 6 that end at x = 10; the boards stand beside either.
#[test]
fn each_lanelet_of_an_all_way_stop_has_its_own_line_and_board() {
    let element = |lines: &[(&'static str, i64, &'static str)]| {
        let members = [("relation", 51, "yield"), ("relation", 50, "yield")];
        let boards = [("way", 31, "refers"), ("way", 32, "refers")];
        let members = [&members[..], &boards[..], lines].concat();
        relation(70, &members, &[("type", "regulatory_element"), ("subtype", "all_way_stop")])
    };
    let board = |id: i64, node: i64| way(id, &[node], &[("type", "traffic_sign"), ("subtype", "usR1-1")]);
    let lines = [
        way(40, &[110, 111], &[("type", "stop_line")]),
        way(41, &[111, 112], &[("type", "stop_line")]),
        board(31, 112),
        board(32, 110),
    ]
    .concat();
    let content = |more: String| street() + &lines + &more;
    let r =
        reading(&content(element(&[("way", 40, "ref_line"), ("way", 41, "ref_line")])), &Options::default());
    let stops: Vec<(&str, &[String])> =
        r.map.stop_lines.iter().map(|s| (s.id.as_str(), s.lane_ids.as_slice())).collect();
    let (lower, upper) = (["51".to_owned()], ["50".to_owned()]);
    assert!(
        stops.contains(&("stop_40", &lower[..])) && stops.contains(&("stop_41", &upper[..])),
        "{stops:?}"
    );
    let boards: Vec<(&str, &[String])> = r
        .map
        .signs
        .iter()
        .filter(|s| s.kind == "stop")
        .map(|s| (s.id.as_str(), s.lane_ids.as_slice()))
        .collect();
    assert_eq!(boards, [("sign_31", &upper[..]), ("sign_32", &lower[..])]);
    let r = reading(&content(element(&[])), &Options::default());
    let ends: Vec<&str> = r.map.stop_lines.iter().map(|s| s.id.as_str()).collect();
    assert!(ends.contains(&"stop_50") && ends.contains(&"stop_51"), "{ends:?}");
}

#[test]
fn a_lanelet_for_both_directions_is_driven_both_ways() {
    let content = street().replace(r#"<tag k="speed_limit" v="50 km/h"/>"#, r#"<tag k="one_way" v="no"/>"#);
    let r = reading(&content, &Options::default());
    let (there, back) = (r.map.lane("50").unwrap(), r.map.lane("50:back").unwrap());
    assert_eq!((back.center[0].x, back.center.last().unwrap().x), (10.0, 0.0));
    assert_eq!((back.left[0].y, back.right[0].y), (4.0, 8.0));
    // The lane beside it runs the other way now.
    assert_eq!(back.left_neighbor.as_deref(), Some("51"));
    assert_eq!(there.right_neighbor.as_deref(), Some("51"));
    assert_eq!(there.speed_limit_mps, None);
    assert_eq!(r.map.layer(MapLayer::SpeedLimits), LayerState::Partial);
}

#[test]
fn degrees_need_an_origin_and_a_declared_datum() {
    let no_local = street().replace("local_", "other_");
    let (_dir, path) = file(&no_local);
    let unplaced = read(&path, &Placement::of(&Options::default()).unwrap());
    assert!(matches!(unplaced, Err(MapFault::Unplaced(_))));
    // The map's own origin: 4 m are 4 / 111 000 deg of latitude, 10 m 10 / 73 000 deg of longitude. A degree at 49 deg
    // is 111 205 m and 73 171 m long.
    let options = Options::default().with(&MAP_ORIGIN, "49.0,8.0").with(&MAP_PROJECTION, "local");
    let r = reading(&no_local, &options);
    let p = r.map.lane("50").unwrap().left[1];
    assert!(
        (p.x - 10.0 * 73_171.0 / 73_000.0).abs() < 0.01 && (p.y - 8.0 * 111_205.0 / 111_000.0).abs() < 0.01,
        "{p:?}"
    );
    // Germany is not shifted with any declared datum; a datum that is not known is refused.
    let gcj = reading(&no_local, &options.clone().with(&MAP_DATUM, "gcj02"));
    assert_eq!(gcj.map.lane("50").unwrap().left[1], p);
    assert!(Placement::of(&options.with(&MAP_DATUM, "bd09")).is_err());
    assert!(Placement::of(&Options::default().with(&MAP_ORIGIN, "north")).is_err());
}

#[test]
fn a_map_in_gcj02_lies_where_it_does_in_wgs84() {
    // The published pair of Beijing, once as origin and once as map: both are shifted alike.
    let at = |lat: f64, lon: f64| {
        let node = |id: i64, dlat: f64, dlon: f64| {
            format!(r#"<node id="{id}" lat="{}" lon="{}"/>"#, lat + dlat, lon + dlon)
        };
        [
            node(1, 0.0, 0.0),
            node(2, 0.0, 0.001),
            node(3, -0.00003, 0.0),
            node(4, -0.00003, 0.001),
            way(5, &[1, 2], &[]),
            way(6, &[3, 4], &[]),
            lanelet(7, 5, 6, &[], &[]),
        ]
        .concat()
    };
    let wgs = Options::default().with(&MAP_ORIGIN, "39.911954,116.377817");
    let gcj = Options::default()
        .with(&MAP_ORIGIN, "39.91334545536069,116.38404722455657")
        .with(&MAP_DATUM, "gcj02");
    let (a, b) = (
        reading(&at(39.911954, 116.377817), &wgs),
        reading(&at(39.913_345_455_360_69, 116.384_047_224_556_57), &gcj),
    );
    let (p, q) = (a.map.lanes[0].left[0], b.map.lanes[0].left[0]);
    assert!((p.x - q.x).hypot(p.y - q.y) < 0.1 && p.x.hypot(p.y) < 0.1, "{p:?} {q:?}");
    // Undeclared, the shift is not guessed: the map lies 570 m away.
    let wrong = reading(&at(39.913_345_455_360_69, 116.384_047_224_556_57), &wgs);
    let q = wrong.map.lanes[0].left[0];
    assert!((q.x.hypot(q.y) - 555.0).abs() < 30.0, "{q:?}");
}

/// The outer ways of a multipolygon come in any order and direction, and may make several rings (OpenStreetMap wiki,
/// Relation:multipolygon). Corners on the grid of `nodes`: the first ring is 20 m by 8 m, the second 10 m by 4 m.
#[test]
fn ways_of_an_area_come_in_any_order() {
    let content = nodes()
        + &way(1, &[100, 110, 120], &[])
        + &way(2, &[102, 112, 122], &[])
        + &way(3, &[122, 121, 120], &[])
        + &way(4, &[102, 101, 100], &[])
        + &way(5, &[122, 132, 133, 123, 122], &[])
        + &way(6, &[100, 110], &[])
        + &way(7, &[102, 112], &[])
        + &relation(
            20,
            &[
                ("way", 1, "outer"),
                ("way", 2, "outer"),
                ("way", 5, "outer"),
                ("way", 4, "outer"),
                ("way", 3, "outer"),
            ],
            &[("type", "multipolygon"), ("subtype", "parking")],
        )
        + &relation(
            21,
            &[("way", 6, "outer"), ("way", 7, "outer")],
            &[("type", "multipolygon"), ("subtype", "parking")],
        );
    let out = reading(&content, &Options::default());
    let size = |f: &Facility| {
        let extent = |of: fn(&Point3) -> f64| {
            let all = f.boundary.iter().map(of);
            all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
        };
        (extent(|p| p.x).round(), extent(|p| p.y).round())
    };
    let found: Vec<_> = out.map.facilities.iter().map(|f| (f.id.as_str(), size(f))).collect();
    assert_eq!(found, [("area_20", (20.0, 8.0)), ("area_20_1", (10.0, 4.0))]);
    assert_eq!(out.invalid, ["multipolygon 21: its outer ways make no ring"]);
}

/// The user declares what a map shows in full; a word that is no part of a map is reported and changes nothing.
#[test]
fn parts_are_declared_complete() {
    let content = nodes()
        + &way(1, &[100, 110, 120], &[])
        + &way(2, &[101, 111, 121], &[])
        + &lanelet(10, 2, 1, &[], &[]);
    let (_dir, path) = file(&content);
    let with = |list: &str| {
        let options = Options::default().with(&MAP, path.clone()).with(&MAP_COMPLETE, list.to_owned());
        crate::maps::load(&path, &options)
    };
    let state = |list: &str| with(list).map.unwrap().map.layer(MapLayer::Crosswalks);
    assert_eq!(state(""), LayerState::Absent);
    assert_eq!(state("crosswalks, lights"), LayerState::Complete);
    let wrong = with("crosswalk,lights");
    assert_eq!(wrong.diagnostics.iter().map(|d| d.code).collect::<Vec<_>>(), ["map.complete"]);
    assert_eq!(wrong.diagnostics[0].hint.as_ref().unwrap().en, "did you mean 'crosswalks'?");
    let map = wrong.map.unwrap().map;
    assert!(map.layer(MapLayer::Crosswalks) == LayerState::Absent && map.covers("traffic_light"));
}

/// SinD's map of Tianjin leaves the subtype of the ways over the junction out, and has stop lines in elements that no
/// lanelet names: both are told by the geometry. Lanes 4 m wide, in two pieces from x = 0 to 10 and 10 to 20.
#[test]
fn lanelets_without_a_subtype_are_road_and_stop_lines_find_their_lanes() {
    let content = nodes()
        + &way(1, &[100, 110], &[])
        + &way(2, &[101, 111], &[])
        + &way(3, &[110, 120], &[])
        + &way(4, &[111, 121], &[])
        + &way(5, &[110, 111], &[("type", "stop_line")])
        + &lanelet(10, 2, 1, &[], &[])
        + &lanelet(11, 4, 3, &[("subtype", "")], &[])
        + &relation(
            12,
            &[("way", 4, "left"), ("way", 3, "right")],
            &[("type", "lanelet"), ("participant:pedestrian", "yes")],
        )
        + &relation(
            30,
            &[("way", 5, "ref_line")],
            &[("type", "regulatory_element"), ("subtype", "traffic_light")],
        );
    let out = reading(&content, &Options::default());
    let kinds: Vec<_> = out.map.lanes.iter().map(|l| (l.id.as_str(), l.kind)).collect();
    assert_eq!(kinds, [("10", LaneKind::Vehicle), ("11", LaneKind::Vehicle), ("12", LaneKind::Sidewalk)]);
    assert_eq!(
        (out.untyped, out.map.lane("10").unwrap().successors.clone()),
        (vec!["11".into()], vec!["11".into()])
    );
    assert!(out.map.stop_lines[0].lane_ids.contains(&"10".to_owned()), "{:?}", out.map.stop_lines);
}

/// Spellings that maps have instead of the format's: `bikelane`, OpenStreetMap's `maxspeed`. The format's own tag comes
/// first.
#[test]
fn other_spellings_of_subtypes_and_limits_are_read() {
    let with = |tags: &[(&str, &str)]| {
        let from = tagged(&[("subtype", "road"), ("speed_limit", "50 km/h")]);
        let content = street();
        assert!(content.contains(&from));
        let r = reading(&content.replacen(&from, &tagged(tags), 1), &Options::default());
        r.map.lane("50").cloned().unwrap()
    };
    let limit =
        |tags: &[(&str, &str)]| with(&[&[("subtype", "road")], tags].concat()).speed_limit_mps.unwrap();
    assert!((limit(&[("maxspeed", "36")]) - 10.0).abs() < 1e-9);
    assert!((limit(&[("maxspeed", "36"), ("speed_limit", "72")]) - 20.0).abs() < 1e-9);
    for (word, kind) in [
        ("bikelane", LaneKind::Bike),
        ("bicycle_lane", LaneKind::Bike),
        ("Bike_Lane", LaneKind::Bike),
        ("sidewalk", LaneKind::Sidewalk),
    ] {
        assert_eq!(with(&[("subtype", word)]).kind, kind, "{word}");
    }
}
