//! The road signals in the simulated drives, compared with data that `examples/truth/road.py` read from the networks:
//! an independent Python reader that uses the simulator's lane ids, while the signals find lanes by geometry.
use crate::scene::Table;
use flate2::read::GzDecoder;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use whyroad_ingest::{DEFAULT_START, Options, find_sources, read};
use whyroad_model::Tri;

struct Row {
    ego: String,
    time: f64,
    cells: BTreeMap<String, String>,
}

impl Row {
    fn number(&self, name: &str) -> f64 {
        self.cells[name].parse().unwrap()
    }
    fn flag(&self, name: &str) -> bool {
        self.cells[name] == "1"
    }
}

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name)
}

fn truth(name: &str) -> Vec<Row> {
    let mut text = String::new();
    GzDecoder::new(File::open(folder(name).join("road.csv.gz")).unwrap()).read_to_string(&mut text).unwrap();
    let mut lines = text.lines().map(|l| l.split(',').map(str::to_owned).collect::<Vec<_>>());
    let header = lines.next().unwrap();
    lines
        .map(|row| Row {
            ego: row[0].clone(),
            time: row[1].parse().unwrap(),
            cells: header.iter().cloned().zip(row).collect(),
        })
        .collect()
}

/// Name of the value of `map.lane_turns` for SUMO's directions.
fn turns(directions: &str) -> Option<&'static str> {
    let has = |c: char| directions.contains(c);
    Some(match (has('s'), has('l'), has('r'), has('t')) {
        (true, true, true, _) => "any",
        (true, true, false, _) => "straight_left",
        (true, false, true, _) => "straight_right",
        (false, true, true, _) => "left_right",
        (true, false, false, _) => "straight",
        (false, true, false, true) => "left_uturn",
        (false, true, false, false) => "left",
        (false, false, true, _) => "right",
        (false, false, false, true) => "uturn",
        (false, false, false, false) => return None,
    })
}

#[derive(Default)]
struct Tally(BTreeMap<&'static str, (usize, usize, Vec<String>)>);

impl Tally {
    fn add(&mut self, what: &'static str, agrees: bool, row: &Row, seen: impl std::fmt::Debug) {
        let (all, wrong, examples) = self.0.entry(what).or_default();
        *all += 1;
        if !agrees {
            *wrong += 1;
            examples.push(format!("{} at {}: {seen:?} for {:?}", row.ego, row.time, row.cells));
        }
    }
}

fn compare(name: &str, tally: &mut Tally) {
    let rows = truth(name);
    let mut egos: Vec<String> = rows.iter().map(|r| r.ego.clone()).collect();
    egos.dedup();
    for ego in egos {
        let options = Options::default()
            .with(&whyroad_ingest::sumo::EGO, ego.as_str())
            .with(&whyroad_ingest::sumo::SENSOR_RANGE, f64::INFINITY);
        let (sources, _) = find_sources(None, &[folder(name)]);
        let drive = read(&sources[0], &options).0.unwrap();
        let t = Table::of(&drive);
        let own: Vec<&Row> = rows.iter().filter(|r| r.ego == ego).collect();
        for (k, &row) in own.iter().enumerate() {
            let close = |i: &usize| (drive.times[*i].seconds_since(DEFAULT_START) - row.time).abs() < 0.01;
            let Some(i) = (0..drive.times.len()).find(close) else { continue };
            // While the body is over a line, the assigned lane may depend on a centimeter.
            if t.ego("ego.lane_offset", i).is_nan() || t.ego("ego.lane_offset", i).abs() > 1.2 {
                continue;
            }
            let near = |a: f64, b: f64, tolerance: f64| (a - b).abs() <= tolerance;
            let limit = t.ego("map.speed_limit", i);
            tally.add("limit", near(limit, row.number("limit_mps"), 1e-9), row, limit);
            let count = t.ego("map.lane_count", i);
            tally.add("lanes", near(count, row.number("lanes"), 0.0), row, count);
            let ramp = t.ego_flag("map.on_ramp", i);
            tally.add("ramp", ramp == Tri::from(row.flag("ramp")), row, ramp);
            for (name, cell) in [("map.left_lane", "left"), ("map.right_lane", "right")] {
                let seen = t.ego_category(name, i);
                let same = matches!(seen, Some("same" | "bus"));
                tally.add(cell, same == row.flag(cell), row, seen);
            }
            let to_end = row.number("to_end_m");
            if !row.flag("junction") || to_end > 100.0 {
                continue;
            }
            // The ego's front is at the end of its lane when it reaches the junction; the path there bends a little.
            let distance = t.ego("map.distance_to_junction", i);
            // The path over a lane change is longer than the lane, by meters at very low speed.
            let edge = |lane: &str| lane.rsplit_once('_').unwrap().0.to_owned();
            let stays = own[k..]
                .iter()
                .take_while(|r| edge(&r.cells["lane"]) == edge(&row.cells["lane"]))
                .all(|r| r.cells["lane"] == row.cells["lane"]);
            if stays {
                tally.add("distance", near(distance, to_end, 1.0), row, distance);
            }
            let arms = t.ego("map.junction_arms", i);
            tally.add("arms", arms == row.number("arms"), row, arms);
            let exits = t.ego("map.junction_exits", i);
            tally.add("exits", exits == row.number("exits"), row, exits);
            let turning = t.ego_category("map.lane_turns", i);
            tally.add("turns", turning == turns(&row.cells["turns"]), row, turning);
            let lights = t.ego_flag("map.junction_signalised", i);
            // Also where the log has no light states: the network says which junctions have lights.
            tally.add("lights", lights == Tri::from(row.flag("lights")), row, lights);
            if row.flag("lights") && stays {
                let line = t.ego("map.distance_to_stop_line", i);
                tally.add("stop line", near(line, to_end, 0.5), row, line);
            }
        }
    }
}

#[test]
fn the_road_is_what_the_network_says() {
    let mut tally = Tally::default();
    for name in
        ["truth/grid", "truth/motorway", "drives/back_street", "drives/multilane", "drives/signal_junction"]
    {
        compare(name, &mut tally);
    }
    for (what, (all, wrong, examples)) in &tally.0 {
        println!("{what}: {} of {all} agree", all - wrong);
        examples.iter().take(3).for_each(|e| println!("  {e}"));
    }
    for (what, (all, wrong, examples)) in &tally.0 {
        assert!(*all > 40, "{what}: only {all} places");
        assert!(*wrong * 100 <= *all, "{what}: {wrong} of {all} differ: {:?}", examples.first());
    }
}
