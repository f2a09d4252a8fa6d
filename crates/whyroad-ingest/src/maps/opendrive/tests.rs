//! Small maps written by hand; expected places by hand.

use super::*;
use whyroad_model::road_map::{LaneMark, Point3, TurnKind};

fn reading(roads: &str) -> MapReading {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.xodr");
    let header = r#"<header revMajor="1" revMinor="6" name="byhand"/>"#;
    std::fs::write(&path, format!("<?xml version=\"1.0\"?>\n<OpenDRIVE>{header}{roads}</OpenDRIVE>"))
        .unwrap();
    let out = read(&path).unwrap();
    assert!(out.count.adds_up(), "{:?}", out.count);
    out
}

fn straight(length: f64) -> String {
    format!(
        r#"<planView><geometry s="0" x="100" y="50" hdg="0" length="{length}"><line/></geometry></planView>"#
    )
}

fn lane(id: i32, kind: &str, width: f64, more: &str) -> String {
    format!(r#"<lane id="{id}" type="{kind}"><width sOffset="0" a="{width}"/>{more}</lane>"#)
}

fn near(p: Point3, x: f64, y: f64) -> bool {
    (p.x - x).abs() < 1e-6 && (p.y - y).abs() < 1e-6
}

#[test]
fn a_street_for_both_directions() {
    let limit = r#"<speed sOffset="0" max="30" unit="km/h"/>"#;
    let mark = |m: &str| format!(r#"<roadMark sOffset="0" type="{m}"/>"#);
    let roads = format!(
        r#"<road id="7" length="80" junction="-1">{}<type s="0" type="town"><speed max="50" unit="km/h"/></type>
        <elevationProfile><elevation s="0" a="2" b="0.1"/></elevationProfile>
        <lanes><laneOffset s="0" a="0.5"/><laneSection s="0"><left>{}{}</left>
        <center><lane id="0" type="none">{}</lane></center><right>{}{}{}</right></laneSection></lanes></road>"#,
        straight(80.0),
        lane(1, "driving", 3.0, &mark("solid")),
        lane(2, "sidewalk", 2.0, ""),
        mark("broken"),
        lane(-1, "driving", 3.5, &format!("{limit}{}", mark("solid solid"))),
        lane(-2, "border", 0.5, ""),
        lane(-3, "biking", 1.5, ""),
    );
    let r = reading(&roads);
    let ids: Vec<&str> = r.map.lanes.iter().map(|l| l.id.as_str()).collect();
    assert_eq!(ids, ["7_0_-1", "7_0_-3", "7_0_1", "7_0_2"]);
    assert_eq!(
        (r.name.as_deref(), r.count.kept["lane"], r.count.set_aside["not_a_road_user_lane"]),
        (Some("byhand"), 4, 1)
    );
    let forward = r.map.lane("7_0_-1").unwrap();
    // The middle is 0.5 m left of the reference line: lane -1 from 50.5 to 47.0.
    assert!(near(forward.left[0], 100.0, 50.5) && near(forward.right[0], 100.0, 47.0));
    assert!(near(forward.center[0], 100.0, 48.75) && near(*forward.center.last().unwrap(), 180.0, 48.75));
    // 2 m at the start, and 80 m of 10 %.
    assert!(
        (forward.center[0].z - 2.0).abs() < 1e-6 && (forward.center.last().unwrap().z - 10.0).abs() < 1e-6
    );
    assert!((forward.speed_limit_mps.unwrap() - 30.0 / 3.6).abs() < 1e-9);
    assert_eq!((forward.left_mark, forward.right_mark), (LaneMark::Dashed, LaneMark::DoubleSolid));
    assert_eq!(forward.left_neighbor.as_deref(), Some("7_0_1"));
    assert_eq!((forward.right_neighbor.as_deref(), forward.width_m), (None, Some(3.5)));
    let back = r.map.lane("7_0_1").unwrap();
    assert!(near(back.center[0], 180.0, 52.0) && near(*back.center.last().unwrap(), 100.0, 52.0));
    // Driving west, the left edge is the southern one.
    assert!(near(back.left[0], 180.0, 50.5) && near(back.right[0], 180.0, 53.5));
    assert!((back.speed_limit_mps.unwrap() - 50.0 / 3.6).abs() < 1e-9, "the road's");
    assert_eq!(back.left_neighbor.as_deref(), Some("7_0_-1"));
    assert_eq!(back.right_neighbor.as_deref(), Some("7_0_2"));
    let bike = r.map.lane("7_0_-3").unwrap();
    assert!(near(bike.center[0], 100.0, 50.5 - 3.5 - 0.5 - 0.75) && bike.kind == LaneKind::Bike);
    assert_eq!(r.map.layer(MapLayer::Heights), LayerState::Partial);
    assert_eq!(r.map.layer(MapLayer::Crosswalks), LayerState::Absent);
}

#[test]
fn left_hand_traffic_runs_the_other_way() {
    let roads = format!(
        r#"<road id="1" length="10" junction="-1" rule="LHT">{}<lanes><laneSection s="0"><right>{}</right></laneSection>
        </lanes></road>"#,
        straight(10.0),
        lane(-1, "driving", 3.0, "")
    );
    let r = reading(&roads);
    let l = r.map.lane("1_0_-1").unwrap();
    assert!(near(l.center[0], 110.0, 48.5) && near(l.left[0], 110.0, 47.0));
}

#[test]
fn sections_follow_each_other_and_a_lane_may_end() {
    let link = |next: i32| format!(r#"<link><successor id="{next}"/></link>"#);
    let roads = format!(
        r#"<road id="3" length="60" junction="-1">{}<lanes>
        <laneSection s="0"><right>{}{}</right></laneSection>
        <laneSection s="40"><right><lane id="-1" type="driving"><link><predecessor id="-1"/></link>
        <width sOffset="0" a="3"/><width sOffset="10" a="3" b="-0.1"/></lane></right></laneSection></lanes></road>"#,
        straight(60.0),
        lane(-1, "driving", 3.0, &link(-1)),
        lane(-2, "exit", 3.0, ""),
    );
    let r = reading(&roads);
    assert_eq!(r.map.lane("3_0_-1").unwrap().successors, ["3_1_-1"]);
    assert_eq!(r.map.lane("3_1_-1").unwrap().predecessors, ["3_0_-1"]);
    // The road ends at the border of the map, the second lane on the road.
    assert_eq!(r.map.lane("3_1_-1").unwrap().successors, ["beyond:3_1_-1"]);
    assert!(r.map.lane("3_0_-2").unwrap().successors.is_empty());
    assert!(r.map.lane("3_0_-2").unwrap().is_tagged("deceleration"));
    // 3 m, then narrower by 0.1 m each meter from 50 m on: 2 m at the end.
    let right = &r.map.lane("3_1_-1").unwrap().right;
    assert!(near(right[0], 140.0, 47.0) && near(*right.last().unwrap(), 160.0, 48.0));
    assert_eq!(r.map.layer(MapLayer::Ramps), LayerState::Partial);
}

#[test]
fn signals_and_objects_go_to_our_layers() {
    let roads = format!(
        r#"<road id="1" length="50" junction="-1">{}<lanes><laneSection s="0"><left>{}</left><right>{}</right></laneSection>
        </lanes><objects>
        <object id="z" type="crosswalk" s="30" t="0" hdg="0"><outlines><outline>
          <cornerRoad s="28" t="-3"/><cornerRoad s="32" t="-3"/><cornerRoad s="32" t="3"/><cornerRoad s="28" t="3"/>
        </outline></outlines></object>
        <object id="p" type="parkingSpace" s="10" t="-5" hdg="1.5707963267948966" length="5" width="2"/>
        <object id="t" type="tree" s="10" t="-9" hdg="0" length="1" width="1"/>
        <tunnel id="u" s="5" length="10"/></objects>
        <signals>
        <signal id="l" s="45" t="-3" orientation="+" dynamic="yes" country="OpenDRIVE" type="1000001" zOffset="5"/>
        <signal id="w" s="45" t="-4" orientation="+" dynamic="yes" country="OpenDRIVE" type="1000002"/>
        <signal id="v" s="20" t="-4" orientation="+" dynamic="no" country="DE" type="274" value="30" unit="km/h"/>
        <signal id="h" s="44" t="-1.5" orientation="+" dynamic="no" country="DE" type="294"/>
        </signals></road>"#,
        straight(50.0),
        lane(1, "driving", 3.0, ""),
        lane(-1, "driving", 3.0, "")
    );
    let r = reading(&roads);
    assert!(near(r.map.crosswalks[0].boundary[0], 128.0, 47.0) && r.map.crosswalks[0].boundary.len() == 5);
    let kinds: Vec<(&str, &str)> =
        r.map.facilities.iter().map(|f| (f.id.as_str(), f.kind.as_str())).collect();
    assert_eq!(
        kinds,
        [("light_l", "traffic_light"), ("p", "parking"), ("tunnel_u_0", "tunnel"), ("tunnel_u_1", "tunnel")]
    );
    // 5 m long across the road.
    let parking = &r.map.facilities[1].boundary;
    assert!(parking.iter().all(|p| (p.x - 110.0).abs() < 1.0 + 1e-9 && (p.y - 45.0).abs() < 2.5 + 1e-9));
    let sign = &r.map.signs[0];
    assert_eq!((sign.kind.as_str(), sign.lane_ids.as_slice()), ("speed_limit", &["1_0_-1".to_owned()][..]));
    assert!((sign.value.unwrap() - 30.0 / 3.6).abs() < 1e-9 && near(sign.position, 120.0, 46.0));
    assert_eq!(
        (r.map.stop_lines[0].id.as_str(), r.map.stop_lines[0].lane_ids.as_slice()),
        ("h", &["1_0_-1".to_owned()][..])
    );
    let features = r.features.unwrap();
    assert!(features.adds_up() && features.read == 7, "{features:?}");
    assert_eq!((features.set_aside["scenery"], features.set_aside["unknown_word"]), (1, 1));
    assert_eq!(r.map.layer(MapLayer::StopLines), LayerState::Partial);
}

/// Three arms at a junction, 20 m apart; from the west to the east and, by an arc of 10 m, to the north.
fn junction(arms: &str) -> String {
    let road = |id: u32, x: f64, y: f64, hdg: f64, link: &str| {
        format!(
            r#"<road id="{id}" length="50" junction="-1"><link>{link}</link><planView>
            <geometry s="0" x="{x}" y="{y}" hdg="{hdg}" length="50"><line/></geometry></planView>
            <lanes><laneSection s="0"><right>{}</right></laneSection></lanes></road>"#,
            lane(-1, "driving", 3.0, "")
        )
    };
    let over = |id: u32, shape: &str, length: f64, to: u32| {
        let link = r#"<link><predecessor id="-1"/><successor id="-1"/></link>"#;
        format!(
            r#"<road id="{id}" length="{length}" junction="9"><link>
            <predecessor elementType="road" elementId="1" contactPoint="end"/>
            <successor elementType="road" elementId="{to}" contactPoint="start"/></link><planView>
            <geometry s="0" x="-10" y="0" hdg="0" length="{length}">{shape}</geometry></planView>
            <lanes><laneSection s="0"><right>{}</right></laneSection></lanes></road>"#,
            lane(-1, "driving", 3.0, link)
        )
    };
    let (into, from) = (
        r#"<successor elementType="junction" elementId="9"/>"#,
        r#"<predecessor elementType="junction" elementId="9"/>"#,
    );
    let quarter = 5.0 * std::f64::consts::PI;
    [
        road(1, -60.0, 0.0, 0.0, into),
        road(2, 10.0, 0.0, 0.0, from),
        road(3, 0.0, 10.0, std::f64::consts::FRAC_PI_2, from),
        over(20, "<line/>", 20.0, 2),
        over(30, r#"<arc curvature="0.1"/>"#, quarter, 3),
        arms.to_owned(),
        r#"<junction id="9"><connection incomingRoad="1" connectingRoad="20" contactPoint="start"><laneLink from="-1" to="-1"/>
        </connection><connection incomingRoad="1" connectingRoad="30" contactPoint="start"><laneLink from="-1" to="-1"/>
        </connection><connection incomingRoad="1" connectingRoad="77" contactPoint="start"/></junction>"#
            .to_owned(),
    ]
    .concat()
}

#[test]
fn lanes_lead_over_a_junction() {
    let r = reading(&junction(""));
    assert_eq!(r.map.lane("1_0_-1").unwrap().successors, ["20_0_-1", "30_0_-1"]);
    assert_eq!(r.map.lane("30_0_-1").unwrap().successors, ["3_0_-1"]);
    let (left, ahead) = (r.map.lane("30_0_-1").unwrap(), r.map.lane("20_0_-1").unwrap());
    assert!(left.in_junction && ahead.in_junction && left.junction_id.as_deref() == Some("9"));
    assert_eq!((left.turn, ahead.turn), (Some(TurnKind::Left), Some(TurnKind::Straight)));
    // The turn ends 1.5 m right of the reference line, which heads north at (0, 10).
    assert!(near(*left.center.last().unwrap(), 1.5, 10.0), "{:?}", left.center.last());
    assert_eq!(r.map.lane("1_0_-1").unwrap().junction_id.as_deref(), Some("9"));
    assert_eq!(r.map.lane("2_0_-1").unwrap().junction_id, None);
    assert_eq!(r.map.junctions.len(), 1);
    assert_eq!(r.dangling, ["junction 9: road 1 -> road 77"]);
    assert_eq!(r.map.layer(MapLayer::Junctions), LayerState::Complete);
}

#[test]
fn where_a_road_only_parts_there_is_no_junction() {
    // The northern arm bends away by 30 deg only.
    let gentle = junction("").replace(r#"<arc curvature="0.1"/>"#, r#"<arc curvature="0.033333"/>"#).replace(
        &format!(r#"x="0" y="10" hdg="{}""#, std::f64::consts::FRAC_PI_2),
        r#"x="5" y="4" hdg="0.5236""#,
    );
    let r = reading(&gentle);
    assert!(
        r.map.junctions.is_empty() && r.map.lanes.iter().all(|l| !l.in_junction && l.junction_id.is_none())
    );
    assert_eq!(r.map.lane("1_0_-1").unwrap().successors.len(), 2);
}

#[test]
fn what_cannot_be_a_road_is_counted_and_the_rest_is_kept() {
    let good = format!(
        r#"<road id="1" length="10">{}<lanes><laneSection s="0"><right>{}</right></laneSection></lanes></road>"#,
        straight(10.0),
        lane(-1, "driving", 3.0, "")
    );
    let endless = good.replace(r#"id="1" length="10""#, r#"id="2" length="1e300""#);
    let shapeless = good.replace(r#"id="1""#, r#"id="3""#).replacen("<line/>", "<wave/>", 1);
    let widthless = good.replace(r#"id="1""#, r#"id="4""#).replace(r#"<width sOffset="0" a="3"/>"#, "");
    let r = reading(&[good, endless, shapeless, widthless].concat());
    assert_eq!((r.map.lanes.len(), r.count.dropped["invalid"]), (1, 3));
    let said: Vec<&str> = r.invalid.iter().map(String::as_str).collect();
    assert_eq!(
        said,
        [
            "road '2': its length is not that of a road",
            "road '3': a stretch of it has no known shape",
            "lane 4_0_-1: its width is not stated"
        ]
    );
}
