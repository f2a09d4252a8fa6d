//! Whole logs: one file of a small log is changed, and all of it is read as `whyroad ingest` reads it; from memory
//! where the format allows it (`log-*`), else from a folder (`folder-*`), which takes longer.

use super::made::{self, containers, tables};
use super::{cut, fixture, readers, unchanged, work_folder};
use crate::harness::Target;
use std::fs;
use std::path::Path;
use whyroad_ingest::{
    AdapterRef, FilesInMemory, MAP, MAP_ORIGIN, Options, batches, find_sources, formats, sumo,
};

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

fn read_log(format: AdapterRef, folder: &Path, options: &Options) -> bool {
    let (sources, _) = find_sources(Some(format), &[folder.to_owned()]);
    let drives = batches(&sources).map(|batch| whyroad_ingest::read(&batch[0], options).0.is_some());
    drives.fold(false, |any, drive| any | drive)
}

impl Log {
    /// Of a format that reads from memory: the target that changes `name`; `more` are further seeds of that file.
    fn changing(&self, target: &str, name: &str, more: Vec<Vec<u8>>) -> Target {
        // What is read beside the changed file is short.
        let beside: FilesInMemory = self.files.iter().chain(&self.small).cloned().collect();
        let changed = name.to_owned();
        let format = self.format();
        let run = move |bytes: &[u8]| {
            let mut files = beside.clone();
            files.insert(changed.clone(), bytes.to_vec());
            let drives = whyroad_ingest::read_files(format, &files, &Options::default());
            drives.iter().any(|(drive, _)| drive.is_some())
        };
        self.target(&format!("log-{target}"), name, more, Box::new(run))
    }

    /// The same through a folder.
    fn changing_in_folder(&self, target: &str, name: &str, more: Vec<Vec<u8>>) -> Target {
        let folder = work_folder();
        for (name, content) in self.files.iter().chain(&self.small) {
            let path = folder.path().join(name);
            let _ = path.parent().map(fs::create_dir_all);
            let _ = fs::write(path, content);
        }
        let path = folder.path().join(name);
        let (format, options) = (self.format(), self.options);
        let run = move |bytes: &[u8]| {
            let _ = fs::write(&path, bytes);
            // Made again for each run: a map that was read is kept with its options.
            read_log(format, folder.path(), &options(folder.path()))
        };
        self.target(&format!("folder-{target}"), name, more, Box::new(run))
    }

    fn format(&self) -> AdapterRef {
        formats::by_name(self.format).unwrap_or(formats::ALL[0])
    }

    fn target(&self, target: &str, name: &str, more: Vec<Vec<u8>>, run: crate::harness::Parser) -> Target {
        let named = |files: &Files| files.iter().find(|(n, _)| n == name).map(|(_, content)| content.clone());
        Target {
            name: target.to_owned(),
            seeds: named(&self.files).into_iter().chain(more).collect(),
            small: named(&self.small).into_iter().collect(),
            repair: unchanged,
            run,
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
        plain.changing_in_folder("sumo-fcd", "fcd.xml", vec![]),
        plain.changing_in_folder("sumo-net", "net.xml", vec![]),
        plain.changing_in_folder("sumo-types", "rou.xml", vec![]),
        plain.changing_in_folder("sumo-lights", "tls.xml", vec![]),
        log("fcd.csv", "crossroads_table.fcd.csv").changing_in_folder("sumo-fcd-csv", "fcd.csv", vec![]),
        log("fcd.xml.xz", "compressed/crossroads.fcd.xml.xz").changing_in_folder(
            "sumo-xz",
            "fcd.xml.xz",
            vec![],
        ),
        log("fcd.xml.zst", "compressed/crossroads.fcd.xml.zst").changing_in_folder(
            "sumo-zst",
            "fcd.xml.zst",
            vec![],
        ),
        gz.changing_in_folder("sumo-gz", "fcd.xml.gz", vec![]),
    ]
}

fn av2() -> Vec<Target> {
    let map = made::av2_map();
    let sensor = |frames| -> Files {
        vec![
            ("annotations.feather".into(), tables::feather(&tables::annotations(frames))),
            ("city_SE3_egovehicle.feather".into(), tables::feather(&tables::poses(frames))),
            ("map/log_map_archive_a____PIT_city_1.json".into(), map.clone()),
        ]
    };
    let sensor = Log { format: "av2", files: sensor(FRAMES), small: sensor(FEW), options: defaults };
    let motion = |frames| -> Files {
        vec![
            ("scenario_a.parquet".into(), tables::parquet(&tables::scenario(frames))),
            ("log_map_archive_a.json".into(), map.clone()),
        ]
    };
    let motion = Log { format: "av2-motion", files: motion(FRAMES), small: motion(FEW), options: defaults };
    vec![
        sensor.changing_in_folder("av2-annotations", "annotations.feather", vec![]),
        sensor.changing_in_folder("av2-poses", "city_SE3_egovehicle.feather", vec![]),
        sensor.changing_in_folder("av2-map", "map/log_map_archive_a____PIT_city_1.json", vec![]),
        motion.changing_in_folder("av2-motion-parquet", "scenario_a.parquet", vec![]),
    ]
}

fn comma() -> Vec<Target> {
    let log = Log {
        format: "comma2k19",
        files: made::comma_segment(40),
        small: made::comma_segment(4),
        options: defaults,
    };
    let arrays = ["frame_times", "frame_positions", "frame_orientations", "frame_gps_times"];
    let mut out: Vec<Target> = arrays
        .iter()
        .map(|a| log.changing(&format!("npy-{a}"), &format!("global_pose/{a}"), vec![]))
        .collect();
    for array in ["t", "address", "data"] {
        out.push(log.changing(
            &format!("npy-can-{array}"),
            &format!("processed_log/CAN/raw_can/{array}"),
            vec![],
        ));
    }
    out.push(log.changing("npy-radar", "processed_log/CAN/radar/value", vec![]));
    out
}

fn tables() -> Vec<Target> {
    let example = readers::example;
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
            ("ego.parquet".into(), tables::parquet(&tables::table_ego(FRAMES))),
        ],
        small: vec![("ego.parquet".into(), tables::parquet(&tables::table_ego(FEW)))],
        options: defaults,
    };
    out.push(parquet.changing("table-parquet", "ego.parquet", vec![]));
    let names = ["2026-01-15_pose.csv", "2026-01-15_objects.csv", "lanes.csv"];
    let mut files: Files = names
        .iter()
        .map(|n| ((*n).to_owned(), super::file(&format!("examples/table_fleet/following/{n}"))))
        .collect();
    files.push(("mapping.yaml".into(), super::file("examples/table_fleet/fleet.yaml")));
    let fleet = Log { format: "table", small: cut_to(4, &files), files, options: defaults };
    out.push(fleet.changing("table-mapping", "mapping.yaml", vec![]));
    out.push(fleet.changing("table-mapped", "2026-01-15_pose.csv", vec![]));
    out
}

/// The fixture has no vehicle that is named as the ego.
fn with_ego() -> Options {
    Options::default().with(&sumo::EGO, "a".to_owned())
}

/// Maps beside a log on the same ground.
fn maps() -> Vec<Target> {
    let log = |name: &'static str, from: &'static str, options: fn(&Path) -> Options| {
        let files = files(&[("fcd.xml.gz", "maps/town.fcd.xml.gz"), (name, from)]);
        let mut small: Files = vec![(
            name.to_owned(),
            if name == "map.xodr" { cut::xml_children(&files[1].1, 2) } else { made::LANELET.into() },
        )];
        let drive = made::gunzip(&fixture("maps/town.fcd.xml.gz"));
        small.push(("fcd.xml.gz".into(), made::gzip(&cut::xml(&drive, 3))));
        Log { format: "sumo", small, files, options }
    };
    vec![
        log("map.xodr", "maps/town.xodr", |f| with_ego().with(&MAP, f.join("map.xodr"))).changing_in_folder(
            "map-opendrive",
            "map.xodr",
            vec![],
        ),
        log("map.osm", "maps/street.osm", |f| with_ego().with(&MAP, f.join("map.osm"))).changing_in_folder(
            "map-lanelet2",
            "map.osm",
            vec![],
        ),
        log("degrees.osm", "maps/street.osm", |f| {
            with_ego().with(&MAP, f.join("degrees.osm")).with(&MAP_ORIGIN, "49,8")
        })
        .changing_in_folder("map-lanelet2-degrees", "degrees.osm", vec![]),
    ]
}

fn bags() -> Vec<Target> {
    let log = Log {
        format: "rosbag",
        files: files(&[("a.bag", "rosbag/lz4.bag"), ("map.yaml", "rosbag/tracks.yaml")]),
        small: vec![("a.bag".into(), containers::bags(2).swap_remove(0))],
        options: defaults,
    };
    let scene = files(&[("scene.json", "openlabel/scene.json")]);
    let labels = Log { format: "openlabel", small: cut_to(2, &scene), files: scene, options: defaults };
    let mut chunks = log.changing("rosbag-chunks", "a.bag", vec![fixture("rosbag/bz2.bag")]);
    chunks.small = containers::bags(2).split_off(1);
    vec![
        chunks,
        log.changing("rosbag-plain", "a.bag", vec![]),
        labels.changing("openlabel", "scene.json", vec![]),
    ]
}

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
    changed.iter().map(|(target, name)| log.changing_in_folder(target, name, vec![])).collect()
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
    let fleet = Log {
        format: "mcap",
        files: files(&[("a.mcap", "mcap/fleet.mcap"), ("map.yaml", "mcap/fleet.yaml")]),
        small: vec![("a.mcap".into(), containers::fleet(2))],
        options: defaults,
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
    let mut messages = plain.changing("mcap-messages", "a.mcap", vec![fixture("mcap/foxglove_zstd.mcap")]);
    messages.small = containers::mcaps(2);
    let mut pickle = scenario.changing("scenarionet", "sd_a.pkl", more.to_vec());
    pickle.small = ["p2", "p4"].map(|p| fixture(&format!("fuzz/sd_small_{p}.pkl"))).to_vec();
    let mut out = vec![
        fleet.changing("mcap-json", "a.mcap", vec![]),
        fleet.changing("mcap-mapping", "map.yaml", vec![]),
        messages,
        pickle,
    ];
    out.extend(nuscenes());
    out
}

fn nuscenes() -> Vec<Target> {
    let mut log = Log { format: "nuscenes", files: Vec::new(), small: Vec::new(), options: defaults };
    let root = super::repository().join("crates/whyroad-ingest/tests/fixtures/nuscenes");
    let mut maps = Vec::new();
    files_below(&root.join("v1.0-byhand"), "", &mut log.files);
    files_below(&root.join("can_bus"), "", &mut log.files);
    files_below(&root.join("maps/expansion"), "", &mut maps);
    log.files.extend(maps.iter().cloned());
    log.small = cut_to(3, &log.files);
    let tables = ["scene", "sample", "sample_annotation", "sample_data", "ego_pose"];
    let mut out: Vec<Target> =
        tables.iter().map(|t| log.changing(&format!("nuscenes-{t}"), &format!("{t}.json"), vec![])).collect();
    out.extend(maps.first().map(|(map, _)| log.changing("nuscenes-map", map, vec![])));
    for part in ["vehicle_monitor", "steeranglefeedback"] {
        out.push(log.changing(&format!("nuscenes-{part}"), &format!("scene-0001_{part}.json"), vec![]));
    }
    out
}
