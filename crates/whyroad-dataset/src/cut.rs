//! Stage 2: a sample cut from its drive around the keyframe, not from the 20 s clip. The model's input is taken from
//! the drive cut at the keyframe (`states(drive, keyframe + 1)`), its target from the whole window.

mod images;
mod label;
mod motion;
mod objects;
mod road;

pub use images::{Blurring, Media};

use crate::item::{Cut, DAY_NS, Dropped, Stage, hex};
use crate::labels::LabelRecord;
use crate::pose::Pose;
use crate::sample::{ContextValue, Groups, Light, Lineage, MapElement, Sample};
use crate::spec::{Incomplete, Spec};
use crate::{descriptor, place};
use motion::Window;
use road::Road;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use whyroad_framework::Framework;
use whyroad_label::check::Checker;
use whyroad_model::scene::FrameOfReference;
use whyroad_model::time::frame_at;
use whyroad_model::{Drive, Nanos, SignalTable};

/// Farthest that a label's keyframe may be from a frame of the drive, s: a frame and a half at 10 Hz.
const KEYFRAME_REACH_S: f64 = 0.15;

/// A candidate, read back from disk.
pub(crate) struct Candidate<'a> {
    pub id: String,
    pub keyframe: Nanos,
    pub status: &'a str,
    pub checked: bool,
    pub label: LabelRecord,
    pub other: Option<LabelRecord>,
}

/// A drive that is being cut.
pub(crate) struct Cutter<'a> {
    pub spec: &'a Spec,
    pub framework: &'a Framework,
    pub drive: &'a Drive,
    /// Signals of the whole drive; only where episodes are drafted.
    pub signals: Option<SignalTable>,
    pub licence: &'a str,
    pub media: &'a Media,
    /// Checks drafts.
    checker: Checker<'a>,
    road: Road,
}

impl<'a> Cutter<'a> {
    pub fn new(
        spec: &'a Spec,
        framework: &'a Framework,
        (drive, signals): (&'a Drive, Option<SignalTable>),
        licence: &'a str,
        media: &'a Media,
    ) -> Self {
        let road = Road::new(drive.map.as_ref().filter(|_| spec.sample.map));
        let checker = Checker::new(framework);
        Self { spec, framework, drive, signals, licence, media, checker, road }
    }

    /// The sample, and what the later stages need of it.
    pub fn cut(&self, candidate: &Candidate<'_>) -> Result<(Sample, Cut), Dropped> {
        let drop = |reason, detail: String| Dropped::with(Stage::Sample, reason, detail);
        let drive = self.drive;
        let frame = frame_at(&drive.times, candidate.keyframe).min(drive.times.len().saturating_sub(1));
        let off = drive.times.get(frame).map_or(f64::INFINITY, |t| t.seconds_since(candidate.keyframe).abs());
        if off > KEYFRAME_REACH_S {
            return Err(drop("keyframe_outside", format!("{off:.2} s from the nearest frame")));
        }
        if drive.meta.frame_of_reference == FrameOfReference::Ego {
            return Err(drop("ego_pose", "the drive has no ego pose".into()));
        }
        self.check_weather(frame)?;
        let cut = &self.spec.sample;
        let window = Window::around(drive, frame, cut)
            .ok_or_else(|| drop("ego_pose", "no pose at the keyframe".into()))?;
        let (history, future) = (window.history(cut), window.future(cut));
        for (trajectory, reason) in [(&history, "history"), (&future, "future")] {
            if !trajectory.complete && cut.incomplete == Incomplete::Drop {
                let known = trajectory.x.iter().filter(|x| x.is_some()).count();
                return Err(drop(reason, format!("{known} of {} steps", trajectory.x.len())));
            }
        }
        let label = label::resolve(self, candidate)?;
        let named = label.named_objects(&candidate.label);
        let pose = window.pose;
        let map = self.road.around(&pose, cut.radius_m);
        let mut sample = Sample {
            sample_id: candidate.id.clone(),
            split: String::new(),
            weight: 1.0,
            ego: window.ego_box(cut),
            objects: objects::around(&window, cut, &named),
            lights: self.lights(frame, map.as_deref()),
            map,
            context: self.context(frame),
            lineage: Lineage {
                drive_id: drive.meta.drive_id.0.clone(),
                drive_hash: drive.meta.content_hash.clone(),
                keyframe_time_ns: drive.times[frame].0,
                keyframe_frame: u32::try_from(frame).unwrap_or(u32::MAX),
                label_status: candidate.status.to_owned(),
                checked: candidate.checked,
                episode_id: candidate.label.episode_id.clone(),
                target_id: candidate.label.target_id.clone(),
                task_id: candidate.label.task_id.clone(),
                rule_version: candidate.label.rule_version.clone(),
                score: candidate.label.score,
                ..Lineage::default()
            },
            groups: self.groups(&pose, drive.times[frame]),
            rejected: candidate.label.rejected.clone(),
            history,
            future,
            ..Sample::default()
        };
        self.route(frame, &mut sample);
        let (longitudinal, lateral) = (label.longitudinal(), label.lateral());
        label.write(&mut sample);
        sample.lineage.label_sha256 = hex(&Sha256::digest(sample.label_json.as_bytes()));
        sample.images = images::of(self, &window, frame)?;
        let position = place::position(&drive.meta, &pose);
        let facts = Cut {
            at: Default::default(),
            content: content_hash(&sample),
            descriptor: descriptor::of(&sample, &named),
            sketch: crate::dedup::trace::sketch(
                sample.trace_zh.as_deref().or(sample.trace_en.as_deref()).unwrap_or(""),
            ),
            position,
            day: drive.times[frame].0.div_euclid(DAY_NS) as i32,
            longitudinal,
            lateral,
            images: u16::try_from(sample.images.len()).unwrap_or(u16::MAX),
        };
        Ok((sample, facts))
    }

    /// The descriptor of a moment without a label: the one that [`Self::cut`] would compare. `None` where the drive has
    /// no pose or frame there.
    pub fn describe(&self, keyframe: Nanos, named: &BTreeSet<String>) -> Option<Vec<f32>> {
        let drive = self.drive;
        let frame = frame_at(&drive.times, keyframe).min(drive.times.len().checked_sub(1)?);
        if drive.times[frame].seconds_since(keyframe).abs() > KEYFRAME_REACH_S
            || drive.meta.frame_of_reference == FrameOfReference::Ego
        {
            return None;
        }
        let cut = &self.spec.sample;
        let window = Window::around(drive, frame, cut)?;
        let map = self.road.around(&window.pose, cut.radius_m);
        let sample = Sample {
            ego: window.ego_box(cut),
            objects: objects::around(&window, cut, named),
            lights: self.lights(frame, map.as_deref()),
            map,
            context: self.context(frame),
            history: window.history(cut),
            future: window.future(cut),
            ..Sample::default()
        };
        Some(descriptor::of(&sample, named))
    }

    fn check_weather(&self, frame: usize) -> Result<(), Dropped> {
        let wanted = &self.spec.select.weather;
        if wanted.is_empty() {
            return Ok(());
        }
        let stated = self.context(frame).unwrap_or_default();
        let weather = stated.iter().find(|c| c.kind == "weather").map_or("unknown", |c| c.value.as_str());
        if wanted.iter().any(|w| w == weather) {
            Ok(())
        } else {
            Err(Dropped::with(Stage::Select, "weather", weather))
        }
    }

    fn groups(&self, pose: &Pose, t0: Nanos) -> Groups {
        let meta = &self.drive.meta;
        let position = place::position(meta, pose);
        Groups {
            session: meta.session.clone(),
            vehicle: meta.vehicle.clone(),
            place: meta.place.clone(),
            date: t0.to_string().get(..10).filter(|_| meta.is_dated()).map(str::to_owned),
            source: meta.source.clone(),
            licence: self.licence.to_owned(),
            position: position.as_ref().map(|p| p.p.to_vec()),
            longitude_latitude: position.as_ref().filter(|p| p.frame == place::GEO).map(|p| p.plane.to_vec()),
            position_frame: position.map(|p| p.frame),
            world_x: finite(pose.x),
            world_y: finite(pose.y),
            world_z: finite(pose.z),
            world_heading: finite(pose.heading),
            ..Groups::default()
        }
    }

    /// The last state at or before t0 of each lane that the sample's map has; of every lane without a map.
    fn lights(&self, frame: usize, map: Option<&[MapElement]>) -> Option<Vec<Light>> {
        let (lights, t0) = (self.drive.lights.as_ref()?, self.drive.times[frame]);
        let mut out: Vec<Light> = Vec::new();
        for state in lights.iter().filter(|l| l.time <= t0) {
            let light = Light {
                lane_id: state.lane_id.clone(),
                to_lane_id: state.to_lane_id.clone(),
                color: word(&state.color),
                since_s: state.time.seconds_since(t0) as f32,
            };
            match out.iter_mut().find(|l| l.lane_id == light.lane_id && l.to_lane_id == light.to_lane_id) {
                Some(held) => *held = light,
                None => out.push(light),
            }
        }
        if let Some(map) = map {
            let near: BTreeSet<&str> = map.iter().map(|e| e.id.as_str()).collect();
            out.retain(|l| near.contains(l.lane_id.as_str()));
        }
        Some(out)
    }

    /// The last state of each kind at or before t0.
    fn context(&self, frame: usize) -> Option<Vec<ContextValue>> {
        let (states, t0) = (self.drive.context.as_ref()?, self.drive.times[frame]);
        let mut out: BTreeMap<&str, (Nanos, &str)> = BTreeMap::new();
        for s in states.iter().filter(|s| s.time <= t0) {
            let held = out.entry(&s.kind).or_insert((s.time, &s.value));
            if s.time >= held.0 {
                *held = (s.time, &s.value);
            }
        }
        let value = |(kind, (_, value)): (&str, (Nanos, &str))| ContextValue {
            kind: kind.into(),
            value: value.into(),
        };
        Some(out.into_iter().map(value).collect())
    }

    fn route(&self, frame: usize, sample: &mut Sample) {
        let command = self.drive.ego.as_ref().and_then(|e| e.bus.route_command.get(frame)).cloned().flatten();
        let (zh, en) = match command.as_deref() {
            Some("left") => ("左转", "Turn left"),
            Some("right") => ("右转", "Turn right"),
            Some("straight") => ("直行", "Go straight"),
            Some("uturn") => ("掉头", "Make a U-turn"),
            Some("exit") => ("驶出主路", "Take the exit"),
            Some("none") => ("沿当前道路行驶", "Continue on the current road"),
            _ => ("", ""),
        };
        let text = |t: &str| (!t.is_empty()).then(|| t.to_owned());
        (sample.route_text_zh, sample.route_text_en) = (text(zh), text(en));
        sample.route = command;
    }
}

fn finite(v: f64) -> Option<f64> {
    v.is_finite().then_some(v)
}

/// The serde name of a unit variant.
fn word<T: serde::Serialize>(value: &T) -> String {
    serde_json::to_value(value).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Hash of motion, objects and class without any id: a drive that was ingested twice gives equal hashes.
fn content_hash(sample: &Sample) -> [u8; 16] {
    let mut hash = blake3::Hasher::new();
    let mut put = |bytes: Vec<u8>| {
        hash.update(&bytes);
    };
    put(postcard::to_allocvec(&(&sample.scenario_id, &sample.history, &sample.future)).unwrap_or_default());
    for o in &sample.objects {
        put(postcard::to_allocvec(&(&o.class, &o.t_s, &o.x, &o.y, &o.heading)).unwrap_or_default());
    }
    let mut out = [0; 16];
    out.copy_from_slice(&hash.finalize().as_bytes()[..16]);
    out
}
