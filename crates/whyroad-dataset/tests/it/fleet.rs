//! A small fleet: straight drives in a town whose streets run east, each at its own speed with a car ahead, and
//! accepted labels for them in the exchange format (`examples/cutin_urgent_example.en.json` with other times).

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use whyroad_dataset::licence::{BUNDLED, LicenceTable};
use whyroad_dataset::{Built, DatasetError, Inputs, LabelStream, Media, Spec, Step, build, spec};
use whyroad_framework::Framework;
use whyroad_label::check::Recordings;
use whyroad_lake::Lake;
use whyroad_model::road_map::{Lane, Point3, RoadMap};
use whyroad_model::scene::{DriveMeta, Ego, Motion, Track};
use whyroad_model::{ClipId, Drive, DriveId, Nanos, Need, ObjectClass};

/// 2026-01-15T10:30:00Z.
const START_S: i64 = 1_768_473_000;

/// A drive: where its street is, how fast it goes.
#[derive(Clone)]
pub struct Plan {
    pub id: String,
    /// y of the street, m.
    pub street_m: f64,
    pub speed_mps: f64,
    pub session: Option<String>,
    pub licence: Option<String>,
    /// Whether the log states when it was recorded.
    pub dated: bool,
}

pub fn plan(id: &str, street_m: f64, speed_mps: f64) -> Plan {
    Plan {
        id: id.into(),
        street_m,
        speed_mps,
        session: None,
        licence: Some("Apache-2.0".into()),
        dated: true,
    }
}

/// Everybody gains speed alike, so that no two moments of a drive are the same.
pub const ACCEL_MPS2: f64 = 0.3;

fn along(x0: f64, y: f64, speed: f64, n: usize) -> Motion {
    let t = |i: usize| i as f64 / 10.0;
    Motion {
        x: (0..n).map(|i| x0 + speed * t(i) + 0.5 * ACCEL_MPS2 * t(i) * t(i)).collect(),
        y: vec![y; n],
        z: vec![0.0; n],
        heading: vec![0.0; n],
        vx: (0..n).map(|i| speed + ACCEL_MPS2 * t(i)).collect(),
        vy: vec![0.0; n],
        accel: vec![ACCEL_MPS2; n],
        yaw_rate: vec![0.0; n],
        forward: vec![],
    }
}

/// 30 s at 10 Hz.
pub fn drive(plan: &Plan) -> Drive {
    let n = 300;
    let lead = Track {
        id: "lead".into(),
        class: ObjectClass::Car,
        source_class: "car".into(),
        frames: (0..n as u32).collect(),
        motion: Motion { z: vec![0.1; n], ..along(20.0 + plan.speed_mps, plan.street_m, plan.speed_mps, n) },
        length_m: vec![4.5; n],
        width_m: vec![1.8; n],
        height_m: vec![1.5; n],
        interior_points: vec![f64::NAN; n],
        ..Track::default()
    };
    let point = |x: f64| Point3 { x, y: plan.street_m, z: 0.0 };
    let lane = Lane {
        id: format!("street_{}", plan.street_m),
        center: (0..60).map(|i| point(f64::from(i) * 20.0 - 100.0)).collect(),
        width_m: Some(3.5),
        ..Lane::default()
    };
    Drive {
        meta: DriveMeta {
            drive_id: DriveId::from(plan.id.as_str()),
            format: "hand".into(),
            source: "fleet".into(),
            place: Some("town".into()),
            licence: plan.licence.clone(),
            session: plan.session.clone(),
            content_hash: format!("{}-{}-{}", plan.id, plan.street_m, plan.speed_mps),
            missing: Need::absent([(!plan.dated, Need::Date)]),
            ..DriveMeta::default()
        },
        times: (0..n as i64).map(|i| Nanos(START_S * 1_000_000_000 + i * 100_000_000)).collect(),
        ego: Some(Ego {
            length_m: 4.8,
            width_m: 1.9,
            height_m: 1.5,
            reference_to_centre_m: 1.4,
            motion: along(0.0, plan.street_m, plan.speed_mps, n),
            ..Ego::default()
        }),
        tracks: vec![lead],
        map: Some(RoadMap { lanes: vec![lane], ..RoadMap::default() }),
        ..Drive::default()
    }
}

/// A label of the drive `seconds` after its start, with that leaf of `reactive_agent.cutin`.
pub fn label(plan: &Plan, seconds: f64, l3: &str) -> serde_json::Value {
    let text = include_str!("../../../../examples/cutin_urgent_example.en.json");
    let mut label: serde_json::Value = serde_json::from_str(text).unwrap();
    let clip = (seconds / 20.0) as usize;
    let at = |offset: f64| Nanos(START_S * 1_000_000_000).plus_secs(seconds + offset).to_string();
    let frame = |offset: f64| ((seconds + offset - 20.0 * clip as f64) * 10.0).round() as i64;
    label["clip_id"] = ClipId::of(&DriveId::from(plan.id.as_str()), clip).to_string().into();
    label["scenario"]["l3"] = l3.into();
    label["scenario"]["full_id"] = format!("reactive_agent.cutin.{l3}").into();
    label["time_range"] = serde_json::json!({
        "start_timestamp": at(-1.0), "end_timestamp": at(1.0),
        "start_frame_idx": frame(-1.0), "end_frame_idx": frame(1.0),
    });
    label["keyframe"]["timestamp"] = at(0.0).into();
    label["keyframe"]["frame_idx"] = frame(0.0).into();
    for component in label["critical_components"].as_array_mut().unwrap() {
        component["evidence_times"] = serde_json::json!([at(0.0)]);
    }
    label
}

/// A lake and labels below a temporary folder.
pub struct Fleet {
    pub dir: tempfile::TempDir,
    pub lake: Lake,
    /// With it, labels are compared with their drives.
    pub recordings: Option<Arc<dyn Recordings>>,
    pub labels: String,
    /// Bytes after the labels.
    pub more_lines: Vec<u8>,
    /// Name of the labels' file.
    pub source: String,
    pub framework: Framework,
    pub spec_text: String,
}

impl Fleet {
    /// Drives and labels: two keyframes each, far apart.
    pub fn new(plans: &[Plan]) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let lake = Lake::create_or_open(dir.path().join("lake")).unwrap();
        let mut labels = String::new();
        for p in plans {
            lake.write_drive(&drive(p)).unwrap();
            for (seconds, l3) in [(5.0, "urgent"), (15.0, "slow")] {
                labels += &format!("{}\n", label(p, seconds, l3));
            }
        }
        Self {
            dir,
            lake,
            labels,
            more_lines: Vec::new(),
            source: "labels.jsonl".into(),
            framework: Framework::bundled().clone(),
            spec_text: "name: test\n".into(),
            recordings: None,
        }
    }

    /// Eight drives in streets 100 m apart, each at its own speed.
    pub fn town() -> Self {
        let plans: Vec<Plan> = (0..8)
            .map(|i| plan(&format!("drive{i}"), f64::from(i) * 100.0, 6.0 + 3.7 * f64::from(i)))
            .collect();
        Self::new(&plans)
    }

    pub fn out(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    pub fn build(&self, out: &Path) -> Result<Built, DatasetError> {
        self.build_until(out, usize::MAX)
    }

    /// Builds until `steps` steps are done.
    pub fn build_until(&self, out: &Path, steps: usize) -> Result<Built, DatasetError> {
        let done = std::sync::atomic::AtomicUsize::new(0);
        let progress =
            |_: Step, _: usize, _: usize| done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1 < steps;
        self.build_with(out, &progress)
    }

    /// Builds with `progress`.
    pub fn build_with(
        &self,
        out: &Path,
        progress: &(dyn Fn(Step, usize, usize) -> bool + Sync),
    ) -> Result<Built, DatasetError> {
        let framework = &self.framework;
        let spec: Spec = spec::read(&self.spec_text, "spec.yaml", framework).unwrap();
        let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
        let inputs = Inputs {
            spec,
            spec_text: self.spec_text.clone(),
            framework,
            licences: &table,
            lake: &self.lake,
            recordings: self.recordings.clone(),
            media: Media::default(),
            spec_dir: self.dir.path(),
            out,
            queries: &|_, _| None,
            restart: false,
        };
        let bytes = [self.labels.as_bytes(), &self.more_lines].concat();
        let lines = Box::new(Cursor::new(bytes));
        build(&inputs, vec![LabelStream { name: self.source.clone(), lines }], progress)
    }
}

/// Every file below a folder with its content.
pub fn content(dir: &Path) -> std::collections::BTreeMap<String, Vec<u8>> {
    let mut out = std::collections::BTreeMap::new();
    let mut todo = vec![dir.to_owned()];
    while let Some(folder) = todo.pop() {
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            if entry.path().is_dir() {
                todo.push(entry.path());
            } else {
                let name = entry.path().strip_prefix(dir).unwrap().display().to_string();
                out.insert(name, std::fs::read(entry.path()).unwrap());
            }
        }
    }
    out
}
