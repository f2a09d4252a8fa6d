//! The JSON tables of a nuScenes set, read row by row: only what belongs to one scene is kept, so that memory is
//! bounded by a scene however large the set is. Schema: nuScenes documentation, "nuScenes schema" (devkit 1.2).

use serde::de::{DeserializeOwned, DeserializeSeed, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::BufReader;
use std::marker::PhantomData;
use std::path::Path;

#[derive(Deserialize)]
pub(super) struct Scene {
    pub token: String,
    pub name: String,
    pub log_token: String,
}

#[derive(Default, Deserialize)]
pub(super) struct Log {
    pub token: String,
    #[serde(default)]
    pub vehicle: String,
    #[serde(default)]
    pub location: String,
}

#[derive(Deserialize)]
struct Sample {
    token: String,
    timestamp: i64,
    scene_token: String,
}

#[derive(Deserialize)]
pub(super) struct Annotation {
    pub sample_token: String,
    pub instance_token: String,
    /// Box centre, m, in the map's frame.
    pub translation: [f64; 3],
    /// Width, length, height, m.
    pub size: [f64; 3],
    /// w, x, y, z
    pub rotation: [f64; 4],
    #[serde(default)]
    pub num_lidar_pts: Option<f64>,
}

#[derive(Deserialize)]
struct Instance {
    token: String,
    category_token: String,
}

#[derive(Deserialize)]
struct Category {
    token: String,
    name: String,
}

#[derive(Deserialize)]
pub(super) struct SampleData {
    sample_token: String,
    pub ego_pose_token: String,
    pub filename: String,
    /// µs
    pub timestamp: i64,
}

#[derive(Deserialize)]
pub(super) struct EgoPose {
    token: String,
    pub translation: [f64; 3],
    pub rotation: [f64; 4],
    /// µs
    pub timestamp: i64,
}

/// Everything of one scene.
pub(super) struct SceneTables {
    pub scene: Scene,
    pub log: Log,
    /// Times of the keyframes by token, µs.
    pub samples: HashMap<String, i64>,
    pub annotations: Vec<Annotation>,
    /// Category of each instance.
    pub categories: HashMap<String, String>,
    pub data: Vec<SampleData>,
    pub poses: Vec<EgoPose>,
}

/// A table that could not be read: its name, and why.
pub(super) struct TableError {
    pub table: &'static str,
    pub reason: String,
}

/// Calls `keep` for every row of a table, one at a time.
fn each_row<T: DeserializeOwned>(
    dir: &Path,
    table: &'static str,
    keep: impl FnMut(T),
) -> Result<(), TableError> {
    struct Rows<T, F>(F, PhantomData<T>);
    impl<'de, T: Deserialize<'de>, F: FnMut(T)> Visitor<'de> for Rows<T, F> {
        type Value = ();
        fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("a list of rows")
        }
        fn visit_seq<A: SeqAccess<'de>>(mut self, mut seq: A) -> Result<(), A::Error> {
            while let Some(row) = seq.next_element()? {
                (self.0)(row);
            }
            Ok(())
        }
    }
    impl<'de, T: Deserialize<'de>, F: FnMut(T)> DeserializeSeed<'de> for Rows<T, F> {
        type Value = ();
        fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<(), D::Error> {
            d.deserialize_seq(self)
        }
    }
    let fail = |reason: String| TableError { table, reason };
    let file = File::open(dir.join(format!("{table}.json"))).map_err(|e| fail(e.to_string()))?;
    let mut json = serde_json::Deserializer::from_reader(BufReader::with_capacity(1 << 20, file));
    json.deserialize_seq(Rows(keep, PhantomData)).map_err(|e| fail(e.to_string()))
}

/// Number of scenes.
pub(super) fn scene_count(dir: &Path) -> Result<u64, TableError> {
    let mut n = 0;
    each_row(dir, "scene", |_: serde::de::IgnoredAny| n += 1)?;
    Ok(n)
}

/// The scene at `index` in `scene.json`, and all rows that belong to it.
pub(super) fn read(dir: &Path, index: u64) -> Result<SceneTables, TableError> {
    let (mut scene, mut at) = (None, 0);
    each_row(dir, "scene", |s: Scene| {
        if at == index {
            scene = Some(s);
        }
        at += 1;
    })?;
    let scene = scene.ok_or(TableError { table: "scene", reason: format!("it has no scene {index}") })?;
    let mut log = Log::default();
    each_row(dir, "log", |l: Log| {
        if l.token == scene.log_token {
            log = l;
        }
    })?;
    let mut samples = HashMap::new();
    each_row(dir, "sample", |s: Sample| {
        if s.scene_token == scene.token {
            samples.insert(s.token, s.timestamp);
        }
    })?;
    let (mut annotations, mut instances) = (Vec::new(), HashSet::new());
    each_row(dir, "sample_annotation", |a: Annotation| {
        if samples.contains_key(&a.sample_token) {
            instances.insert(a.instance_token.clone());
            annotations.push(a);
        }
    })?;
    let mut names = HashMap::new();
    each_row(dir, "category", |c: Category| drop(names.insert(c.token, c.name)))?;
    let mut categories = HashMap::new();
    each_row(dir, "instance", |i: Instance| {
        if instances.contains(&i.token) {
            categories.insert(i.token, names.get(&i.category_token).cloned().unwrap_or_default());
        }
    })?;
    let (mut data, mut wanted) = (Vec::new(), HashSet::new());
    each_row(dir, "sample_data", |d: SampleData| {
        if samples.contains_key(&d.sample_token) {
            wanted.insert(d.ego_pose_token.clone());
            data.push(d);
        }
    })?;
    let mut poses = Vec::new();
    each_row(dir, "ego_pose", |p: EgoPose| {
        if wanted.contains(&p.token) {
            poses.push(p);
        }
    })?;
    // One localisation gave all poses, but those of the lidar are the ones that keyframes are annotated in.
    let lidar: HashSet<&str> =
        data.iter().filter(|d| d.filename.contains("LIDAR_TOP")).map(|d| d.ego_pose_token.as_str()).collect();
    if lidar.len() >= 2 {
        poses.retain(|p| lidar.contains(p.token.as_str()));
    }
    poses.sort_by_key(|p| p.timestamp);
    poses.dedup_by_key(|p| p.timestamp);
    Ok(SceneTables { scene, log, samples, annotations, categories, data, poses })
}
