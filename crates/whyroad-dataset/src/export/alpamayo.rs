//! The tree that the Alpamayo recipes read (`PhysicalAIAVDatasetLocalInterface`). Each sample and language is a
//! pseudo-clip of its own, because the loader takes only the first event of a clip; the event lies at 5.1 s of the
//! clip's 20 s time line. Reasoning is written under `cot` (which the recipe reads) and `coc` (which the released files
//! have). Samples that the loader would drop are listed in `preflight.json`, with the reason.

use super::parquet_file::{Columns, bytes};
use super::{NO_TRACE, Output, SampleWriter, route_text, traces};
use crate::DatasetError;
use crate::item::SplitName;
use crate::sample::{Sample, Trajectory};
use crate::spec::Reference;
use arrow_array::{ArrayRef, BooleanArray, Float64Array, Int64Array, StringArray};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use whyroad_model::{Bilingual, Lang};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Where t0 lies in the pseudo-clip, microseconds: after the 1.6 s of history that the loader needs, and where the
/// recipe's `use_default_keyframe` looks.
const T0_US: i64 = 5_100_000;
/// Time that the loader needs before and after t0, s.
const HISTORY_S: f32 = 1.5;
const FUTURE_S: f32 = 6.4;
/// Clips per chunk.
const PER_CHUNK: usize = 100;
/// Cameras that the loader takes by default.
const CAMERAS: [&str; 4] = [
    "camera_cross_left_120fov",
    "camera_front_wide_120fov",
    "camera_cross_right_120fov",
    "camera_front_tele_30fov",
];
/// Frames per second of a pseudo-clip's video.
const VIDEO_HZ: u32 = 10;

#[derive(Default)]
pub(super) struct Writer {
    clips: Vec<Clip>,
    chunk: Option<Chunk>,
    preflight: BTreeMap<Bilingual, Vec<String>>,
    /// Clips that the loader takes, whose poses are of another point than its own data.
    box_centre: Vec<String>,
    /// Clips with steps of unknown height, which is written as 0.
    flat: Vec<String>,
}

/// The data of a clip for the indexes.
struct Clip {
    id: String,
    chunk: usize,
    split: &'static str,
    cluster: String,
    trace: String,
    route: Option<String>,
    meta_action: String,
    cameras: Vec<String>,
}

/// Archives that are open.
struct Chunk {
    number: usize,
    count: usize,
    egomotion: ZipWriter<File>,
    cameras: BTreeMap<String, ZipWriter<File>>,
}

impl SampleWriter for Writer {
    fn add(&mut self, sample: Sample, split: SplitName, out: &mut Output) -> Result<(), DatasetError> {
        let sample = &sample;
        let Some(egomotion) = egomotion(sample) else {
            out.report.leave_out(sample, "a pose, speed, acceleration or yaw rate of the ego is unknown");
            return Ok(());
        };
        let texts = traces(sample, out.options.language);
        if texts.is_empty() {
            out.report.leave_out(sample, NO_TRACE);
            return Ok(());
        }
        for (lang, text) in texts {
            let suffix = if lang == Lang::Zh { "zh" } else { "en" };
            let id = format!("{}-{suffix}", sample.sample_id);
            let chunk = self.chunk(split.name(), out)?;
            let number = chunk.number;
            zip_file(&mut chunk.egomotion, &format!("{id}.egomotion.parquet"), &egomotion, out)?;
            let cameras = cameras(sample, &id, chunk, out)?;
            chunk.count += 1;
            let faults = faults(sample, &cameras);
            if sample.ego.reference != "rear_axle" && faults.is_empty() {
                self.box_centre.push(id.clone());
            }
            if [&sample.history, &sample.future].iter().any(|part| part.z.iter().any(Option::is_none)) {
                self.flat.push(id.clone());
            }
            for reason in faults {
                self.preflight.entry(reason).or_default().push(id.clone());
            }
            out.write(&format!("meta_actions/{id}.txt"), meta_actions(sample).as_bytes())?;
            self.clips.push(Clip {
                id,
                chunk: number,
                split: split.name(),
                cluster: sample.scenario_id.clone(),
                trace: text.to_owned(),
                route: route_text(sample, lang).map(str::to_owned),
                meta_action: meta_action_at_t0(sample),
                cameras,
            });
            out.report.records += 1;
        }
        Ok(())
    }

    fn finish(&mut self, out: &mut Output) -> Result<(), DatasetError> {
        self.close(out)?;
        out.write("features.csv", features_csv().as_bytes())?;
        out.write("clip_index.parquet", &bytes(self.clip_index(), Some("clip_id"))?)?;
        out.write("metadata/feature_presence.parquet", &bytes(self.presence(), Some("clip_id"))?)?;
        out.write("reasoning/ood_reasoning.parquet", &bytes(self.reasoning(), Some("clip_id"))?)?;
        out.json("navigation.json", &self.navigation())?;
        out.write("training.yaml", self.training().as_bytes())?;
        for (reason, clips) in &self.preflight {
            out.report.notes.push(of_clips((clips.len(), self.clips.len()), reason));
        }
        if !self.box_centre.is_empty() {
            out.report.notes.push(of_clips((self.box_centre.len(), self.clips.len()), &box_centre(out)));
        }
        if !self.flat.is_empty() {
            out.report.notes.push(of_clips((self.flat.len(), self.clips.len()), &unknown_heights()));
        }
        let dropped: BTreeMap<&str, &Vec<String>> =
            self.preflight.iter().map(|(reason, clips)| (reason.en.as_str(), clips)).collect();
        out.json(
            "preflight.json",
            &json!({
                "clips": self.clips.len(), "dropped_by_the_loader": dropped,
                "poses_of_the_box_centre": self.box_centre, "z_unknown_written_as_0": self.flat,
            }),
        )
    }
}

impl Writer {
    /// The chunk that takes the next clip. The loader chooses clips by chunk, so none has clips of two splits.
    fn chunk(&mut self, split: &str, out: &mut Output) -> Result<&mut Chunk, DatasetError> {
        let other = self.clips.last().is_some_and(|c| c.split != split);
        if other || self.chunk.as_ref().is_some_and(|c| c.count >= PER_CHUNK) {
            self.close(out)?;
        }
        let number = self.clips.last().map_or(0, |c| c.chunk + usize::from(self.chunk.is_none()));
        match &mut self.chunk {
            Some(chunk) => Ok(chunk),
            none => {
                let file = out.create(&format!("labels/egomotion/egomotion.chunk_{number:04}.zip"))?;
                let egomotion = ZipWriter::new(file);
                Ok(none.insert(Chunk { number, count: 0, egomotion, cameras: BTreeMap::new() }))
            }
        }
    }

    fn close(&mut self, out: &Output) -> Result<(), DatasetError> {
        let Some(chunk) = self.chunk.take() else { return Ok(()) };
        for archive in std::iter::once(chunk.egomotion).chain(chunk.cameras.into_values()) {
            archive.finish().map_err(|e| DatasetError::broken(&out.root, e))?;
        }
        Ok(())
    }

    fn ids(&self) -> (String, ArrayRef) {
        ("clip_id".to_owned(), Arc::new(StringArray::from_iter_values(self.clips.iter().map(|c| &c.id))))
    }

    fn clip_index(&self) -> Columns {
        let chunks = self.clips.iter().map(|c| c.chunk as i64);
        vec![
            ("clip_is_valid".to_owned(), Arc::new(BooleanArray::from(vec![true; self.clips.len()]))),
            ("chunk".to_owned(), Arc::new(Int64Array::from_iter_values(chunks))),
            ("split".to_owned(), Arc::new(StringArray::from_iter_values(self.clips.iter().map(|c| c.split)))),
            self.ids(),
        ]
    }

    fn presence(&self) -> Columns {
        let mut out: Columns =
            vec![("egomotion".to_owned(), Arc::new(BooleanArray::from(vec![true; self.clips.len()])))];
        for camera in CAMERAS {
            let there: Vec<bool> = self.clips.iter().map(|c| c.cameras.iter().any(|n| n == camera)).collect();
            out.push((camera.to_owned(), Arc::new(BooleanArray::from(there))));
        }
        out.push(self.ids());
        out
    }

    fn reasoning(&self) -> Columns {
        let events = self
            .clips
            .iter()
            .map(|c| json!([{ "event_start_timestamp": T0_US, "cot": c.trace, "coc": c.trace }]).to_string());
        let texts = |of: &dyn Fn(&Clip) -> String| -> ArrayRef {
            Arc::new(StringArray::from_iter_values(self.clips.iter().map(of)))
        };
        vec![
            ("event_cluster".to_owned(), texts(&|c| c.cluster.clone())),
            ("events".to_owned(), Arc::new(StringArray::from_iter_values(events))),
            ("split".to_owned(), texts(&|c| c.split.to_owned())),
            self.ids(),
        ]
    }

    /// Chunks of a split as the loader writes a range: half open.
    fn chunks(&self, split: &str) -> Option<String> {
        let mut of_split = self.clips.iter().filter(|c| c.split == split).map(|c| c.chunk);
        let first = of_split.next()?;
        Some(format!("{first}-{}", of_split.next_back().unwrap_or(first) + 1))
    }

    /// A Hydra configuration on top of the recipe's `sft_base`. The recipe's defaults train the trajectory at a fixed
    /// moment; here the moment is the event's and the reasoning is in both lists.
    fn training(&self) -> String {
        let mut out = "# Put this file beside the recipe's sft_base.yaml and set local_dir to this folder.\n\
             # chunk_ids is half open; a chunk has clips of one split only. Without `cot` in the lists only the trajectory is\n\
             # trained. For route texts use alpamayo.data.pai_nav.PAIDatasetWithNav with annotations_path navigation.json and\n\
             # `route` in components_order; that loader does not read `cot`.\n\
             defaults:\n  - sft_base\n  - _self_\ndata:\n"
            .to_owned();
        for (split, key) in [("train", "train_dataset"), ("val", "val_dataset")] {
            let Some(chunks) = self.chunks(split) else { continue };
            let _ = write!(
                out,
                "  {key}:\n    local_dir: .\n    chunk_ids: \"{chunks}\"\n    use_default_keyframe: false\n    \
                 reasoning_metadata: reasoning/ood_reasoning.parquet\n    vla_preprocess_args:\n      \
                 components_order: [\"image\", \"traj_history\", \"prompt\", \"cot\", \"traj_future\"]\n      \
                 components_prompt: [\"cot\", \"traj_future\"]\n      label_components: [\"cot\", \"traj_future\"]\n"
            );
        }
        out
    }

    /// The loader's code reads `t0_relative`; its documentation names `t0`.
    fn navigation(&self) -> Vec<Value> {
        let entry = |c: &Clip| {
            json!({
                "clip_id": c.id,
                "t0": T0_US,
                "t0_relative": T0_US,
                "nav_text": c.route,
                "cot": c.trace,
                "meta_action": c.meta_action,
            })
        };
        self.clips.iter().filter(|c| c.route.is_some()).map(entry).collect()
    }
}

/// Why poses are of the box center, and what to do about it: the loader takes such clips.
fn box_centre(out: &Output) -> Bilingual {
    match out.reference {
        Reference::RearAxle => Bilingual::new(
            "加载器会读取，但位姿是框中心的：记录没有说明后轴的位置",
            "taken by the loader, but poses are of the box center: the log does not state where the rear axle is",
        ),
        Reference::BoxCentre => Bilingual::new(
            "加载器会读取，但位姿是框中心的，即 spec 中的 sample.reference；加载器自己的数据以后轴（rear_axle）为准",
            "taken by the loader, but poses are of the box center, as sample.reference in the spec says; rear_axle is \
             what the loader's own data has",
        ),
    }
}

fn unknown_heights() -> Bilingual {
    Bilingual::new(
        "高度未知，z 写为 0：该格式没有未知值",
        "z is 0 where the height is unknown: the format has no unknown values",
    )
}

/// A note on some of all clips.
fn of_clips((n, all): (usize, usize), what: &Bilingual) -> Bilingual {
    Bilingual::new(
        format!("{all} 个片段中的 {n} 个：{}（见 preflight.json）", what.zh),
        format!("{n} of {all} clips: {} (preflight.json)", what.en),
    )
}

/// Why the loader drops a clip.
fn faults(sample: &Sample, cameras: &[String]) -> Vec<Bilingual> {
    let mut out = Vec::new();
    if sample.history.t_s.first().is_none_or(|t| *t > -HISTORY_S + 0.01) {
        out.push(Bilingual::new(
            format!("历史不足 {HISTORY_S} s"),
            format!("less than {HISTORY_S} s of history"),
        ));
    }
    if sample.future.t_s.last().is_none_or(|t| *t < FUTURE_S - 0.01) {
        out.push(Bilingual::new(
            format!("未来不足 {FUTURE_S} s"),
            format!("less than {FUTURE_S} s of future"),
        ));
    }
    let missing: Vec<&str> = CAMERAS.into_iter().filter(|c| !cameras.iter().any(|have| have == c)).collect();
    if !missing.is_empty() {
        let missing = missing.join(", ");
        out.push(Bilingual::new(format!("缺少相机：{missing}"), format!("cameras are missing: {missing}")));
    }
    out
}

fn zip_file(
    archive: &mut ZipWriter<File>,
    name: &str,
    content: &[u8],
    out: &Output,
) -> Result<(), DatasetError> {
    // Stored, without a clock: as the released archives, and equal for equal releases.
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    archive.start_file(out.member(name)?, options).map_err(|e| DatasetError::broken(&out.root, e))?;
    archive.write_all(content).map_err(DatasetError::io(&out.root))
}

/// `egomotion.parquet` of a clip: pose in the rig at t0, velocity and acceleration along the same axes.
fn egomotion(sample: &Sample) -> Option<Vec<u8>> {
    let names = ["qx", "qy", "qz", "qw", "x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az", "curvature"];
    let mut time = Vec::new();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    for part in [&sample.history, &sample.future] {
        for i in 0..part.t_s.len() {
            time.push(T0_US + (f64::from(part.t_s[i]) * 1e6).round() as i64);
            for (column, value) in columns.iter_mut().zip(state(part, i)?) {
                column.push(value);
            }
        }
    }
    let mut all: Columns = vec![("timestamp".to_owned(), Arc::new(Int64Array::from(time)))];
    for (name, column) in names.into_iter().zip(columns) {
        all.push((name.to_owned(), Arc::new(Float64Array::from(column))));
    }
    bytes(all, None).ok()
}

fn state(t: &Trajectory, i: usize) -> Option<[f64; 14]> {
    let at = |column: &[Option<f32>]| column.get(i).copied().flatten().map_or(f64::NAN, f64::from);
    let (x, y, heading) = (at(&t.x), at(&t.y), at(&t.heading));
    if !(x.is_finite() && y.is_finite() && heading.is_finite()) {
        return None;
    }
    // Heights are relative to t0; a log without heights is flat.
    let z = at(&t.z);
    let z = if z.is_finite() { z } else { 0.0 };
    let (speed, accel, rate) = (at(&t.speed), at(&t.accel), at(&t.yaw_rate));
    let (sin, cos) = heading.sin_cos();
    let half = heading / 2.0;
    // The reader interpolates every column and refuses values that are not finite. Below 0.5 m/s the direction of
    // travel is not defined; the bound keeps the curvature finite there.
    let curvature = rate / speed.abs().max(0.5) * if speed < 0.0 { -1.0 } else { 1.0 };
    if !(speed.is_finite() && accel.is_finite() && rate.is_finite()) {
        return None;
    }
    Some([
        0.0,
        0.0,
        half.sin(),
        half.cos(),
        x,
        y,
        z,
        speed * cos,
        speed * sin,
        0.0,
        accel * cos - speed * rate * sin,
        accel * sin + speed * rate * cos,
        0.0,
        curvature,
    ])
}

/// Videos of the sample's cameras; returns the names of those that were written.
fn cameras(
    sample: &Sample,
    id: &str,
    chunk: &mut Chunk,
    out: &mut Output,
) -> Result<Vec<String>, DatasetError> {
    let mut by_camera: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (i, image) in sample.images.iter().enumerate().filter(|(_, i)| i.camera != "bev") {
        by_camera.entry(&image.camera).or_default().push(i);
    }
    let Some(ffmpeg) = out.options.ffmpeg.clone() else {
        if !by_camera.is_empty() {
            out.report.leave_out(sample, "images: ffmpeg is not installed");
        }
        return Ok(Vec::new());
    };
    let mut written = Vec::new();
    for (camera, images) in by_camera {
        let Some(name) =
            CAMERAS.into_iter().find(|c| *c == camera || c.strip_prefix("camera_") == Some(camera))
        else {
            continue;
        };
        // The type of an image becomes part of the names of files for ffmpeg.
        for i in &images {
            out.member(&format!("image.{}", sample.images[*i].format))?;
        }
        let Some(video) = encode(sample, &images, &ffmpeg, &out.root)? else {
            out.report.leave_out(sample, "images: ffmpeg could not encode them");
            continue;
        };
        let times = images.iter().map(|i| T0_US + (f64::from(sample.images[*i].t_s) * 1e6).round() as i64);
        let times: Columns =
            vec![("timestamp".to_owned(), Arc::new(Int64Array::from_iter_values(times)) as ArrayRef)];
        if !chunk.cameras.contains_key(name) {
            let file = out.create(&format!("camera/{name}/{name}.chunk_{:04}.zip", chunk.number))?;
            chunk.cameras.insert(name.to_owned(), ZipWriter::new(file));
        }
        if let Some(archive) = chunk.cameras.get_mut(name) {
            zip_file(archive, &format!("{id}.{name}.mp4"), &video, out)?;
            zip_file(archive, &format!("{id}.{name}.timestamps.parquet"), &bytes(times, None)?, out)?;
            written.push(name.to_owned());
        }
    }
    Ok(written)
}

/// The images as a video with a key frame per image; `None` when ffmpeg fails.
fn encode(
    sample: &Sample,
    images: &[usize],
    ffmpeg: &Path,
    root: &Path,
) -> Result<Option<Vec<u8>>, DatasetError> {
    let work = root.join(".frames");
    std::fs::create_dir_all(&work).map_err(DatasetError::io(&work))?;
    let format = &sample.images[images[0]].format;
    for (n, i) in images.iter().enumerate() {
        let path = work.join(format!("{n:04}.{format}"));
        std::fs::write(&path, &sample.images[*i].bytes).map_err(DatasetError::io(&path))?;
    }
    let video = work.join("video.mp4");
    let status = Command::new(ffmpeg)
        .args(["-y", "-loglevel", "error", "-framerate", &VIDEO_HZ.to_string(), "-i"])
        .arg(work.join(format!("%04d.{format}")))
        .args(["-c:v", "libx264", "-pix_fmt", "yuv420p", "-g", "1"])
        .arg(&video)
        .status()
        .map_err(DatasetError::io(ffmpeg))?;
    let content = status.success().then(|| std::fs::read(&video)).and_then(Result::ok);
    std::fs::remove_dir_all(&work).map_err(DatasetError::io(&work))?;
    Ok(content)
}

/// `gentle_accelerate` in the auto-labeler's spelling.
fn action_name(id: &str) -> String {
    let name = match id {
        "gentle_accelerate" => "GentleAcceleration",
        "strong_accelerate" => "StrongAcceleration",
        "gentle_decelerate" => "GentleDeceleration",
        "strong_decelerate" => "StrongDeceleration",
        "maintain_speed" => "MaintainSpeed",
        "stop" => "Stop",
        "reverse" => "Reverse",
        "steer_left" => "SteerLeft",
        "steer_right" => "SteerRight",
        "sharp_steer_left" => "SharpSteerLeft",
        "sharp_steer_right" => "SharpSteerRight",
        "reverse_left" => "ReverseLeft",
        "reverse_right" => "ReverseRight",
        "go_straight" => "GoStraight",
        other => other,
    };
    name.to_owned()
}

/// Lines of the auto-labeler's files: spans of equal meta actions, frames at the sample's rate from its start.
fn meta_actions(sample: &Sample) -> String {
    let mut out = String::new();
    type Of = fn(&Trajectory) -> &[Option<String>];
    let channels: [Of; 2] = [|t| &t.meta_longitudinal, |t| &t.meta_lateral];
    for of in channels {
        let all: Vec<Option<&str>> =
            of(&sample.history).iter().chain(of(&sample.future)).map(Option::as_deref).collect();
        let mut start = 0;
        for i in 1..=all.len() {
            if i == all.len() || all[i] != all[start] {
                if let Some(action) = all[start] {
                    let _ = writeln!(out, "{} - Agent:<ego>, Start:{start}, End:{i}", action_name(action));
                }
                start = i;
            }
        }
    }
    out
}

/// The meta action at t0 as the chat template writes it; empty where it is unknown.
fn meta_action_at_t0(sample: &Sample) -> String {
    let last = |column: &[Option<String>]| column.last().cloned().flatten();
    match (last(&sample.history.meta_longitudinal), last(&sample.history.meta_lateral)) {
        (Some(long), Some(lat)) => {
            format!("Longitudinal: {}.\nLateral: {}.", action_name(&long), action_name(&lat))
        }
        _ => String::new(),
    }
}

fn features_csv() -> String {
    let quoted = |value: Value| format!("\"{}\"", value.to_string().replace('"', "\"\""));
    let mut out = "feature,directory,chunk_path,clip_files_in_zip\n".to_owned();
    let egomotion = quoted(json!({ "egomotion": "{clip_id}.egomotion.parquet" }));
    let _ =
        writeln!(out, "egomotion,labels,labels/egomotion/egomotion.chunk_{{chunk_id:04d}}.zip,{egomotion}");
    for camera in CAMERAS {
        let files = quoted(json!({
            "video": format!("{{clip_id}}.{camera}.mp4"),
            "frame_timestamps": format!("{{clip_id}}.{camera}.timestamps.parquet"),
        }));
        let _ = writeln!(out, "{camera},camera,camera/{camera}/{camera}.chunk_{{chunk_id:04d}}.zip,{files}");
    }
    out
}
