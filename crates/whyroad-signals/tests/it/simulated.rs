//! The bundled simulated drives: the simulator's own outputs (`lanechange.xml.gz`, `tls.xml.gz`) and the events in
//! `examples/drives/README.md` must be reproduced by the signals.
use crate::scene::{Table, near};
use std::path::Path;
use whyroad_ingest::{Options, find_sources, read};
use whyroad_model::Tri::{False, True};

fn drive(name: &str) -> Table {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives").join(name);
    let (sources, _) = find_sources(None, &[folder]);
    // All of the simulation, not what a sensor sees of it.
    let options = Options::default().with(&whyroad_ingest::sumo::SENSOR_RANGE, f64::INFINITY);
    Table::of(&read(&sources[0], &options).0.unwrap())
}

#[test]
fn the_ego_changes_lanes_when_the_simulator_says() {
    let t = drive("multilane");
    // lanechange.xml.gz: the ego goes from straight_1 to straight_2, dir="1" (left), at 43.70 s: the moment its front
    // bumper is over the line. The box's center is there within a frame or two; the movement lasts 4 s by SUMO's types.
    assert_eq!(t.span("ego.lane_change", "right"), None);
    let (first, last) = t.span("ego.lane_change", "left").unwrap();
    assert!((415..430).contains(&first) && (450..462).contains(&last), "{first}..{last}");
    let crossed = (0..640).find(|&i| t.ego("ego.lane_offset", i) < -1.0).unwrap();
    assert!((436..=440).contains(&crossed), "{crossed}");
    // README: a bend of 22 m radius: 1/22 = 0.0455.
    let sharpest = (0..640).map(|i| t.ego("map.curvature", i)).fold(0.0, f64::max);
    near(sharpest, 1.0 / 22.0, 0.004);
}

#[test]
fn the_light_the_queue_and_the_turns_of_the_junction_drive() {
    let t = drive("signal_junction");
    // README: queues behind a lead at a red light, both start at green, right turn, left turn at a green light.
    assert_eq!(t.ego_category("light.state", 150), Some("red"));
    assert_eq!(t.ego_flag("lead.exists", 200), True);
    assert_eq!(t.ego_flag("ego.standstill", 200), True);
    let green =
        (0..620).find(|&i| t.ego_category("light.state", i).is_some_and(|s| s.starts_with("green"))).unwrap();
    let starts = (green..620).find(|&i| t.ego_flag("ego.standstill", i) == False).unwrap();
    assert!(starts > green && starts - green < 30, "green at {green}, off at {starts}");
    let movements: Vec<&str> = {
        let mut all: Vec<&str> = (0..620).filter_map(|i| t.ego_category("ego.movement", i)).collect();
        all.dedup();
        all
    };
    assert_eq!(movements, ["right", "left"]);
    // SUMO's own gap keeps 2.5 m at standstill (minGap of its types).
    near(t.ego("lead.gap", 220), 2.5, 0.1);
}
