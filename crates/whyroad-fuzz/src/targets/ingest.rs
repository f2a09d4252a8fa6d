//! Logs of every format: one file of a small log is changed, and the whole log is read as `whyroad ingest` reads it.

mod made;

use super::{cut, file, unchanged, work_folder};
use crate::harness::Target;
use std::fs;
use std::path::Path;
use whyroad_ingest::{AdapterRef, MAP, MAP_ORIGIN, Options, batches, comma2k19, find_sources, formats, mcap};

/// Frames of a log that is made here, and of its small form.
const FRAMES: i64 = 12;
const FEW: i64 = 3;

/// Name and content of a file.
type Files = Vec<(String, Vec<u8>)>;

/// A small log.
struct Log {
    format: &'static str,
    files: Files,
    /// Files of a few rows, by name: they lie beside the changed one, and are its small seeds.
    small: Files,
    options: fn(&Path) -> Options,
}

fn defaults(_: &Path) -> Options {
    Options::default()
}

fn read_log(format: AdapterRef, folder: &Path, options: &Options) {
    let (sources, _) = find_sources(Some(format), &[folder.to_owned()]);
    for batch in batches(&sources) {
        drop(whyroad_ingest::read(&batch[0], options));
    }
}

impl Log {
    /// The target that changes `name` of the log; `more` are further seeds of that file.
    fn changing(&self, target: &str, name: &str, more: Vec<Vec<u8>>) -> Target {
        let folder = work_folder();
        // What is read beside the changed file is short.
        for (name, content) in self.files.iter().chain(&self.small) {
            let path = folder.path().join(name);
            let _ = path.parent().map(fs::create_dir_all);
            let _ = fs::write(path, content);
        }
        let named = |files: &Files| files.iter().find(|(n, _)| n == name).map(|(_, content)| content.clone());
        let path = folder.path().join(name);
        let options = self.options;
        let format = formats::by_name(self.format).unwrap_or(formats::ALL[0]);
        let run = move |bytes: &[u8]| {
            let _ = fs::write(&path, bytes);
            // Made again for each run: a map that was read is kept with its options.
            read_log(format, folder.path(), &options(folder.path()));
        };
        Target {
            name: target.to_owned(),
            seeds: named(&self.files).into_iter().chain(more).collect(),
            small: named(&self.small).into_iter().collect(),
            repair: unchanged,
            run: Box::new(run),
        }
    }
}

/// Each file that `cut` makes smaller, cut to `most` rows.
fn cut_to(most: usize, files: &Files) -> Files {
    let cut = |(name, content): &(String, Vec<u8>)| {
        let cut = match name.rsplit('.').next() {
            Some("csv") => cut::lines(content, most + 1),
            Some("xml" | "osm" | "xodr") => cut::xml(content, most),
            Some("json") => cut::json(content, most),
            _ => return None,
        };
        (cut.len() < content.len()).then(|| (name.clone(), cut))
    };
    files.iter().filter_map(cut).collect()
}

fn fixture(name: &str) -> Vec<u8> {
    file(&format!("crates/whyroad-ingest/tests/fixtures/{name}"))
}

fn files(list: &[(&str, &str)]) -> Files {
    list.iter().map(|(name, from)| ((*name).to_owned(), fixture(from))).collect()
}

pub(super) fn targets() -> Vec<Target> {
    let mut out = sumo();
    out.extend(av2());
    out.extend(comma());
    out.extend(tables());
    out.extend(maps());
    out.extend(bags());
    out.extend(pai());
    out.extend(others());
    out
}

fn sumo() -> Vec<Target> {
    let beside = [
        ("net.xml", "crossroads.net.xml"),
        ("rou.xml", "crossroads.rou.xml"),
        ("tls.xml", "crossroads.lights.xml"),
    ];
    let log = |fcd: &str, from: &str| {
        let list: Vec<(&str, &str)> = beside.into_iter().chain([(fcd, from)]).collect();
        let files = files(&list);
        Log { format: "sumo", small: cut_to(3, &files), files, options: defaults }
    };
    let plain = log("fcd.xml", "crossroads.fcd.xml");
    let gz = {
        let mut log = log("fcd.xml.gz", "crossroads.fcd.xml");
        let short = cut::xml(&fixture("crossroads.fcd.xml"), 3);
        log.files.iter_mut().filter(|(n, _)| n == "fcd.xml.gz").for_each(|(_, c)| *c = made::gzip(c));
        log.small.push(("fcd.xml.gz".into(), made::gzip(&short)));
        log
    };
    vec![
        plain.changing("sumo-fcd", "fcd.xml", vec![]),
        plain.changing("sumo-net", "net.xml", vec![]),
        plain.changing("sumo-types", "rou.xml", vec![]),
        plain.changing("sumo-lights", "tls.xml", vec![]),
        log("fcd.csv", "crossroads_table.fcd.csv").changing("sumo-fcd-csv", "fcd.csv", vec![]),
        log("fcd.xml.xz", "compressed/crossroads.fcd.xml.xz").changing("sumo-xz", "fcd.xml.xz", vec![]),
        log("fcd.xml.zst", "compressed/crossroads.fcd.xml.zst").changing("sumo-zst", "fcd.xml.zst", vec![]),
        gz.changing("sumo-gz", "fcd.xml.gz", vec![]),
    ]
}

fn av2() -> Vec<Target> {
    let map = made::av2_map();
    let sensor = |frames| -> Files {
        vec![
            ("annotations.feather".into(), made::annotations(frames)),
            ("city_SE3_egovehicle.feather".into(), made::poses(frames)),
            ("map/log_map_archive_a____PIT_city_1.json".into(), map.clone()),
        ]
    };
    let sensor = Log { format: "av2", files: sensor(FRAMES), small: sensor(FEW), options: defaults };
    let motion = |frames| -> Files {
        vec![
            ("scenario_a.parquet".into(), made::scenario(frames)),
            ("log_map_archive_a.json".into(), map.clone()),
        ]
    };
    let motion = Log { format: "av2-motion", files: motion(FRAMES), small: motion(FEW), options: defaults };
    vec![
        sensor.changing("av2-annotations", "annotations.feather", vec![]),
        sensor.changing("av2-poses", "city_SE3_egovehicle.feather", vec![]),
        sensor.changing("av2-map", "map/log_map_archive_a____PIT_city_1.json", vec![]),
        motion.changing("av2-motion-parquet", "scenario_a.parquet", vec![]),
    ]
}

fn comma() -> Vec<Target> {
    let log = Log {
        format: "comma2k19",
        files: made::comma_segment(40),
        small: made::comma_segment(4),
        options: |folder| Options::default().with(&comma2k19::DBC, folder.join("car.dbc")),
    };
    let arrays = ["frame_times", "frame_positions", "frame_orientations", "frame_gps_times"];
    let mut out: Vec<Target> = arrays
        .iter()
        .map(|a| log.changing(&format!("npy-{a}"), &format!("1/global_pose/{a}"), vec![]))
        .collect();
    for array in ["t", "address", "data"] {
        out.push(log.changing(
            &format!("npy-can-{array}"),
            &format!("1/processed_log/CAN/raw_can/{array}"),
            vec![],
        ));
    }
    out.push(log.changing("npy-radar", "1/processed_log/CAN/radar/value", vec![]));
    out.push(log.changing("dbc", "car.dbc", vec![]));
    out
}

fn tables() -> Vec<Target> {
    let example = |name: &str| file(&format!("examples/table/following/{name}"));
    let names =
        ["drive.yaml", "ego.csv", "objects.csv", "lanes.csv", "areas.csv", "lights.csv", "context.csv"];
    let files: Files = names.iter().map(|n| ((*n).to_owned(), example(n))).collect();
    let log = Log { format: "table", small: cut_to(4, &files), files, options: defaults };
    let mut out: Vec<Target> = names
        .iter()
        .map(|n| log.changing(&format!("table-{}", n.split('.').next().unwrap_or(n)), n, vec![]))
        .collect();
    let parquet = Log {
        format: "table",
        files: vec![
            ("drive.yaml".into(), example("drive.yaml")),
            ("ego.parquet".into(), made::ego_parquet(FRAMES)),
        ],
        small: vec![("ego.parquet".into(), made::ego_parquet(FEW))],
        options: defaults,
    };
    out.push(parquet.changing("table-parquet", "ego.parquet", vec![]));
    out
}

/// Maps beside a log on the same ground.
fn maps() -> Vec<Target> {
    let log = |name: &'static str, from: &'static str, options: fn(&Path) -> Options| {
        let files = files(&[("fcd.xml.gz", "maps/town.fcd.xml.gz"), (name, from)]);
        let mut small = cut_to(2, &files);
        let drive = made::gunzip(&fixture("maps/town.fcd.xml.gz"));
        small.push(("fcd.xml.gz".into(), made::gzip(&cut::xml(&drive, 3))));
        Log { format: "sumo", small, files, options }
    };
    vec![
        log("map.xodr", "maps/town.xodr", |f| Options::default().with(&MAP, f.join("map.xodr"))).changing(
            "map-opendrive",
            "map.xodr",
            vec![],
        ),
        log("map.osm", "maps/street.osm", |f| Options::default().with(&MAP, f.join("map.osm"))).changing(
            "map-lanelet2",
            "map.osm",
            vec![],
        ),
        log("degrees.osm", "maps/street.osm", |f| {
            Options::default().with(&MAP, f.join("degrees.osm")).with(&MAP_ORIGIN, "49,8")
        })
        .changing("map-lanelet2-degrees", "degrees.osm", vec![]),
    ]
}

fn bags() -> Vec<Target> {
    let log = Log {
        format: "rosbag",
        files: files(&[("a.bag", "rosbag/lz4.bag"), ("map.yaml", "rosbag/tracks.yaml")]),
        small: Vec::new(),
        options: |folder| Options::default().with(&mcap::MAPPING, folder.join("map.yaml")),
    };
    let scene = files(&[("scene.json", "openlabel/scene.json")]);
    let labels = Log { format: "openlabel", small: cut_to(3, &scene), files: scene, options: defaults };
    vec![
        log.changing("rosbag-chunks", "a.bag", vec![fixture("rosbag/bz2.bag")]),
        log.changing("rosbag-plain", "a.bag", vec![fixture("rosbag/plain.bag")]),
        labels.changing("openlabel", "scene.json", vec![]),
    ]
}

/// The tree of PhysicalAI-AV, whose chunks are archives of Parquet files.
fn pai() -> Vec<Target> {
    let root = super::repository().join("crates/whyroad-ingest/tests/fixtures/pai/tree");
    let mut log = Log { format: "pai", files: Vec::new(), small: Vec::new(), options: defaults };
    files_below(&root, "", &mut log.files);
    let changed = [
        ("pai-features", "features.csv"),
        ("pai-clips", "clip_index.parquet"),
        ("pai-egomotion", "labels/egomotion/egomotion.chunk_0000.zip"),
        ("pai-obstacles", "labels/obstacle.offline/obstacle.offline.chunk_0000.zip"),
    ];
    changed.iter().map(|(target, name)| log.changing(target, name, vec![])).collect()
}

/// All files below `root`, by their names from `name` on, in order.
fn files_below(root: &Path, name: &str, out: &mut Files) {
    let mut names: Vec<String> = fs::read_dir(root.join(name))
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    for entry in names {
        let below = if name.is_empty() { entry } else { format!("{name}/{entry}") };
        match fs::read(root.join(&below)) {
            Ok(content) => out.push((below, content)),
            Err(_) => files_below(root, &below, out),
        }
    }
}

fn others() -> Vec<Target> {
    let mcap = Log {
        format: "mcap",
        files: files(&[("a.mcap", "mcap/fleet.mcap"), ("map.yaml", "mcap/fleet.yaml")]),
        small: Vec::new(),
        options: |folder| Options::default().with(&mcap::MAPPING, folder.join("map.yaml")),
    };
    let plain = Log {
        format: "mcap",
        files: files(&[("a.mcap", "mcap/ros2_lz4.mcap")]),
        small: Vec::new(),
        options: defaults,
    };
    let pickles =
        ["p2", "p3", "p4", "p5", "numpy1"].map(|p| fixture(&format!("scenarionet/sd_byhand_{p}.pkl")));
    let [first, more @ ..] = pickles;
    let scenario = Log {
        format: "scenarionet",
        files: vec![("sd_a.pkl".into(), first)],
        small: Vec::new(),
        options: defaults,
    };
    let waymo = Log {
        format: "waymo-motion",
        files: files(&[("a.tfrecord", "waymo/byhand.tfrecord-00000-of-00001")]),
        small: Vec::new(),
        options: defaults,
    };
    let mut behind = waymo.changing("waymo-messages", "a.tfrecord", vec![]);
    behind.repair = made::repair_tfrecord;
    let mut out = vec![
        mcap.changing("mcap-json", "a.mcap", vec![]),
        mcap.changing("mcap-mapping", "map.yaml", vec![]),
        plain.changing("mcap-chunks", "a.mcap", vec![fixture("mcap/foxglove_zstd.mcap")]),
        plain.changing("mcap-plain", "a.mcap", made::unchunked_mcap()),
        scenario.changing("pickle", "sd_a.pkl", more.to_vec()),
        waymo.changing("tfrecord", "a.tfrecord", vec![]),
        behind,
    ];
    out.extend(nuscenes());
    out
}

fn nuscenes() -> Vec<Target> {
    let mut log = Log { format: "nuscenes", files: Vec::new(), small: Vec::new(), options: defaults };
    let root = super::repository().join("crates/whyroad-ingest/tests/fixtures/nuscenes");
    for folder in ["v1.0-byhand", "can_bus", "maps/expansion"] {
        files_below(&root, folder, &mut log.files);
    }
    log.files.sort();
    log.small = cut_to(3, &log.files);
    let tables = ["scene", "sample", "sample_annotation", "sample_data", "ego_pose"];
    let mut out: Vec<Target> = tables
        .iter()
        .map(|t| log.changing(&format!("nuscenes-{t}"), &format!("v1.0-byhand/{t}.json"), vec![]))
        .collect();
    let first = |folder: &str| log.files.iter().map(|f| &f.0).find(|n| n.starts_with(folder)).cloned();
    for (target, folder) in [("nuscenes-bus", "can_bus/"), ("nuscenes-map", "maps/expansion/")] {
        out.extend(first(folder).map(|name| log.changing(target, &name, vec![])));
    }
    out
}
