//! The JSON tables of a nuScenes set, read row by row: only what belongs to the scenes asked for is kept, so that
//! memory is bounded by these however large the set is, and one pass over the tables serves all of them. Schema:
//! nuScenes documentation, "nuScenes schema" (devkit 1.2).

use crate::encodings::input::Folder;
use serde::de::{DeserializeOwned, DeserializeSeed, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::collections::{HashMap, HashSet};
use std::io::BufReader;
use std::marker::PhantomData;
use std::rc::Rc;

#[derive(Deserialize)]
pub(super) struct Scene {
    pub token: String,
    pub name: String,
    pub log_token: String,
}

#[derive(Clone, Default, Deserialize)]
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
    #[serde(deserialize_with = "microseconds")]
    timestamp: i64,
    scene_token: String,
}

#[derive(Deserialize)]
pub(super) struct Annotation {
    pub sample_token: String,
    pub instance_token: String,
    /// Box center, m, in the map's frame.
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
    #[serde(deserialize_with = "microseconds")]
    pub timestamp: i64,
}

#[derive(Deserialize)]
pub(super) struct EgoPose {
    token: String,
    pub translation: [f64; 3],
    pub rotation: [f64; 4],
    /// µs
    #[serde(deserialize_with = "microseconds")]
    pub timestamp: i64,
}

/// A time in µs: an integer as in the published tables; converters also write floats (also in scientific notation) and
/// strings of either.
fn microseconds<'de, D: Deserializer<'de>>(from: D) -> Result<i64, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Written {
        Integer(i64),
        Float(f64),
        Text(String),
    }
    let exact = |v: f64| (v.is_finite() && v.abs() < 9e15).then(|| v.round() as i64);
    let time = match Written::deserialize(from)? {
        Written::Integer(t) => Some(t),
        Written::Float(t) => exact(t),
        Written::Text(t) => t.trim().parse().ok().or_else(|| exact(t.trim().parse().ok()?)),
    };
    time.ok_or_else(|| serde::de::Error::custom("a timestamp is not a number of microseconds"))
}

/// Everything of one scene.
pub(super) struct SceneTables {
    pub scene: Scene,
    pub log: Log,
    /// Times of the keyframes by token, µs.
    pub samples: HashMap<String, i64>,
    pub annotations: Vec<Annotation>,
    /// Category of each instance, of this scene and of those read with it.
    pub categories: Rc<HashMap<String, String>>,
    pub data: Vec<SampleData>,
    pub poses: Vec<EgoPose>,
}

/// A table that could not be read: its name, and why.
#[derive(Clone)]
pub(super) struct TableError {
    pub table: &'static str,
    pub reason: String,
}

/// Bytes of a table that are read at once; tables are gigabytes in size.
const BUFFER: usize = 1 << 20;

/// Calls `keep` for every row of a table, one at a time.
fn each_row<T: DeserializeOwned>(
    dir: Folder<'_>,
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
    let file = dir.file(&format!("{table}.json")).ok_or_else(|| fail("the file is missing".to_owned()))?;
    let (file, length) = file.open().map_err(|e| fail(e.to_string()))?;
    let buffer = usize::try_from(length).unwrap_or(BUFFER).min(BUFFER);
    let mut json = serde_json::Deserializer::from_reader(BufReader::with_capacity(buffer, file));
    json.deserialize_seq(Rows(keep, PhantomData)).map_err(|e| fail(e.to_string()))
}

/// Number of scenes.
pub(super) fn scene_count(dir: Folder<'_>) -> Result<u64, TableError> {
    let mut n = 0;
    each_row(dir, "scene", |_: serde::de::IgnoredAny| n += 1)?;
    Ok(n)
}

/// The scenes at `indices` in `scene.json` and all rows that belong to each, in one pass over the tables; an index that
/// `scene.json` does not have is an error of its own.
pub(super) fn read(
    dir: Folder<'_>,
    indices: &[u64],
) -> Result<Vec<Result<SceneTables, TableError>>, TableError> {
    let mut scenes = scenes(dir, indices)?;
    // Rows name their scene by a chain of tokens; here each token leads to the scene's place in `scenes`.
    let mut samples: HashMap<String, usize> = HashMap::new();
    let by_scene: HashMap<String, usize> =
        scenes.iter().flatten().enumerate().map(|(at, t)| (t.scene.token.clone(), at)).collect();
    let mut found: Vec<&mut SceneTables> = scenes.iter_mut().flatten().collect();
    each_row(dir, "sample", |s: Sample| {
        if let Some(&at) = by_scene.get(&s.scene_token) {
            found[at].samples.insert(s.token.clone(), s.timestamp);
            samples.insert(s.token, at);
        }
    })?;
    let mut instances = HashSet::new();
    each_row(dir, "sample_annotation", |a: Annotation| {
        if let Some(&at) = samples.get(&a.sample_token) {
            instances.insert(a.instance_token.clone());
            found[at].annotations.push(a);
        }
    })?;
    let categories = Rc::new(categories(dir, &instances)?);
    let mut wanted: HashMap<String, usize> = HashMap::new();
    each_row(dir, "sample_data", |d: SampleData| {
        if let Some(&at) = samples.get(&d.sample_token) {
            wanted.insert(d.ego_pose_token.clone(), at);
            found[at].data.push(d);
        }
    })?;
    each_row(dir, "ego_pose", |p: EgoPose| {
        if let Some(&at) = wanted.get(&p.token) {
            found[at].poses.push(p);
        }
    })?;
    for t in found {
        t.categories = Rc::clone(&categories);
        keep_lidar_poses(t);
    }
    Ok(scenes)
}

/// The scenes at `indices` with their logs, as yet without rows.
fn scenes(dir: Folder<'_>, indices: &[u64]) -> Result<Vec<Result<SceneTables, TableError>>, TableError> {
    let (mut found, mut at) = (HashMap::new(), 0);
    each_row(dir, "scene", |s: Scene| {
        if indices.contains(&at) {
            found.insert(at, s);
        }
        at += 1;
    })?;
    let mut logs = HashMap::new();
    each_row(dir, "log", |l: Log| drop(logs.insert(l.token.clone(), l)))?;
    let empty = |scene: Scene| SceneTables {
        log: logs.get(&scene.log_token).cloned().unwrap_or_default(),
        scene,
        samples: HashMap::new(),
        annotations: Vec::new(),
        categories: Rc::default(),
        data: Vec::new(),
        poses: Vec::new(),
    };
    let missing = |index| TableError { table: "scene", reason: format!("it has no scene {index}") };
    Ok(indices.iter().map(|i| found.remove(i).map(empty).ok_or_else(|| missing(i))).collect())
}

/// The category's name of each of these instances; empty where the tables do not say.
fn categories(dir: Folder<'_>, instances: &HashSet<String>) -> Result<HashMap<String, String>, TableError> {
    let mut names = HashMap::new();
    each_row(dir, "category", |c: Category| drop(names.insert(c.token, c.name)))?;
    let mut out = HashMap::new();
    each_row(dir, "instance", |i: Instance| {
        if instances.contains(&i.token) {
            out.insert(i.token, names.get(&i.category_token).cloned().unwrap_or_default());
        }
    })?;
    Ok(out)
}

/// One localization gave all poses, but those of the lidar are the ones that keyframes are annotated in.
fn keep_lidar_poses(t: &mut SceneTables) {
    let of_lidar = t.data.iter().filter(|d| d.filename.contains("LIDAR_TOP"));
    let lidar: HashSet<&str> = of_lidar.map(|d| d.ego_pose_token.as_str()).collect();
    if lidar.len() >= 2 {
        t.poses.retain(|p| lidar.contains(p.token.as_str()));
    }
    t.poses.sort_by_key(|p| p.timestamp);
    t.poses.dedup_by_key(|p| p.timestamp);
}
