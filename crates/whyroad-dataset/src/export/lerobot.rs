//! LeRobot v3: every sample is an episode at the sample's rate, history then future; the trace is a persistent language
//! row from t0 on (style `plan`), meta actions are rows of style `motion`. Images of a release exist at a few moments
//! only and are not in this export: a LeRobot episode needs one per frame.

use super::parquet_file::{Columns, bytes};
use super::{NO_TRACE, Output, SampleWriter, TraceLanguage, traces};
use crate::DatasetError;
use crate::item::SplitName;
use crate::sample::{Sample, Trajectory};
use arrow_array::builder::{Float32Builder, ListBuilder, StringBuilder, StructBuilder};
use arrow_array::{
    ArrayRef, FixedSizeListArray, Float32Array, Int64Array, ListArray, StringArray, new_null_array,
};
use arrow_schema::{DataType, Field, Fields};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;
use whyroad_model::Bilingual;

/// State of the vehicle per frame.
const STATE: [&str; 6] = ["speed", "heading", "x", "y", "accel", "yaw_rate"];
/// The training target per frame: the motion of the next step.
const ACTION: [&str; 2] = ["accel", "yaw_rate"];
/// Episodes per data file.
const EPISODES_PER_FILE: usize = 1000;

#[derive(Default)]
pub(super) struct Writer {
    rate_hz: Option<f64>,
    frames: usize,
    tasks: BTreeMap<String, i64>,
    task_order: Vec<String>,
    episodes: Vec<Episode>,
    waiting: Frames,
    file: usize,
    statistics: Vec<Statistics>,
    splits: BTreeMap<&'static str, (usize, usize)>,
}

struct Episode {
    task: String,
    length: usize,
    first: usize,
    file: usize,
}

/// Frames not written yet.
#[derive(Default)]
struct Frames {
    episodes: usize,
    state: Vec<f32>,
    action: Vec<f32>,
    timestamp: Vec<f32>,
    frame: Vec<i64>,
    episode: Vec<i64>,
    index: Vec<i64>,
    task: Vec<i64>,
    language: Vec<Arc<Vec<Row>>>,
}

/// A row of `language_persistent`.
#[derive(Clone)]
struct Row {
    content: String,
    style: &'static str,
    timestamp: f32,
}

/// Sums for `stats.json`.
#[derive(Clone, Default)]
struct Statistics {
    values: Vec<f32>,
}

impl SampleWriter for Writer {
    fn add(&mut self, sample: Sample, split: SplitName, out: &mut Output) -> Result<(), DatasetError> {
        let sample = &sample;
        let Some((times, rows)) = frames_of(sample) else {
            out.report.leave_out(sample, "a frame's pose, speed, acceleration or yaw rate is unknown");
            return Ok(());
        };
        let step = f64::from(times[1] - times[0]);
        let rate = (1.0 / step).round();
        if *self.rate_hz.get_or_insert(rate) != rate {
            out.report.leave_out(sample, "another rate than the samples before");
            return Ok(());
        }
        let language = Arc::new(language(sample, out.options.language, times[0]));
        if language.iter().all(|r| r.style != "plan") {
            out.report.leave_out(sample, NO_TRACE);
            return Ok(());
        }
        if self.waiting.episodes >= EPISODES_PER_FILE {
            self.flush(out)?;
        }
        let task = task(sample);
        let next = self.tasks.len() as i64;
        let task_index = *self.tasks.entry(task.clone()).or_insert_with(|| {
            self.task_order.push(task.clone());
            next
        });
        let episode = self.episodes.len();
        let w = &mut self.waiting;
        self.statistics.resize(STATE.len() + ACTION.len(), Statistics::default());
        for (i, row) in rows.iter().enumerate() {
            let after = rows.get(i + 1).unwrap_or(row);
            let action = [after[4], after[5]];
            w.state.extend(row);
            w.action.extend(action);
            for (s, v) in self.statistics.iter_mut().zip(row.iter().chain(&action)) {
                s.values.push(*v);
            }
            w.timestamp.push(times[i] - times[0]);
            w.frame.push(i as i64);
            w.episode.push(episode as i64);
            w.index.push((self.frames + i) as i64);
            w.task.push(task_index);
            w.language.push(language.clone());
        }
        w.episodes += 1;
        self.episodes.push(Episode { task, length: rows.len(), first: self.frames, file: self.file });
        self.frames += rows.len();
        let range = self.splits.entry(split.name()).or_insert((episode, episode));
        range.1 = episode + 1;
        out.report.records += 1;
        Ok(())
    }

    fn finish(&mut self, out: &mut Output) -> Result<(), DatasetError> {
        self.flush(out)?;
        let index: Vec<i64> = (0..self.task_order.len() as i64).collect();
        let tasks: Columns = vec![
            ("task_index".to_owned(), Arc::new(Int64Array::from(index)) as ArrayRef),
            ("task".to_owned(), Arc::new(StringArray::from_iter_values(&self.task_order))),
        ];
        out.write("meta/tasks.parquet", &bytes(tasks, Some("task"))?)?;
        out.write("meta/episodes/chunk-000/file-000.parquet", &bytes(self.episode_columns(), None)?)?;
        out.json("meta/stats.json", &self.stats())?;
        out.report.notes.push(Bilingual::new(
            "此导出不含图像：LeRobot 的每一帧都须有图像",
            "images are not part of this export: a LeRobot episode needs one per frame",
        ));
        out.json("meta/info.json", &self.info())
    }
}

impl Writer {
    fn flush(&mut self, out: &mut Output) -> Result<(), DatasetError> {
        if self.waiting.episodes == 0 {
            return Ok(());
        }
        let w = std::mem::take(&mut self.waiting);
        let count = w.frame.len();
        let columns: Columns = vec![
            ("observation.state.vehicle".to_owned(), vectors(w.state, STATE.len())?),
            ("action".to_owned(), vectors(w.action, ACTION.len())?),
            ("timestamp".to_owned(), Arc::new(Float32Array::from(w.timestamp))),
            ("frame_index".to_owned(), Arc::new(Int64Array::from(w.frame))),
            ("episode_index".to_owned(), Arc::new(Int64Array::from(w.episode))),
            ("index".to_owned(), Arc::new(Int64Array::from(w.index))),
            ("task_index".to_owned(), Arc::new(Int64Array::from(w.task))),
            ("language_persistent".to_owned(), persistent(&w.language)),
            ("language_events".to_owned(), no_events(count)),
        ];
        let name = format!("data/chunk-{:03}/file-{:03}.parquet", self.file / 1000, self.file % 1000);
        self.file += 1;
        out.write(&name, &bytes(columns, None)?)
    }

    fn episode_columns(&self) -> Columns {
        let all = &self.episodes;
        let numbers = |of: &dyn Fn(usize, &Episode) -> usize| -> ArrayRef {
            Arc::new(Int64Array::from_iter_values(all.iter().enumerate().map(|(i, e)| of(i, e) as i64)))
        };
        let mut tasks = ListBuilder::new(StringBuilder::new());
        for e in all {
            tasks.values().append_value(&e.task);
            tasks.append(true);
        }
        vec![
            ("episode_index".to_owned(), numbers(&|i, _| i)),
            ("tasks".to_owned(), Arc::new(tasks.finish())),
            ("length".to_owned(), numbers(&|_, e| e.length)),
            ("data/chunk_index".to_owned(), numbers(&|_, e| e.file / 1000)),
            ("data/file_index".to_owned(), numbers(&|_, e| e.file % 1000)),
            ("dataset_from_index".to_owned(), numbers(&|_, e| e.first)),
            ("dataset_to_index".to_owned(), numbers(&|_, e| e.first + e.length)),
            ("meta/episodes/chunk_index".to_owned(), numbers(&|_, _| 0)),
            ("meta/episodes/file_index".to_owned(), numbers(&|_, _| 0)),
        ]
    }

    fn stats(&mut self) -> Value {
        self.statistics.iter_mut().for_each(|s| s.values.sort_by(f32::total_cmp));
        let of = |parts: &[Statistics]| {
            let figure = |f: &dyn Fn(&Statistics) -> f64| parts.iter().map(f).collect::<Vec<f64>>();
            json!({
                "min": figure(&|s| s.quantile(0.0)),
                "max": figure(&|s| s.quantile(1.0)),
                "mean": figure(&Statistics::mean),
                "std": figure(&Statistics::deviation),
                "count": [self.frames],
                "q01": figure(&|s| s.quantile(0.01)),
                "q10": figure(&|s| s.quantile(0.10)),
                "q50": figure(&|s| s.quantile(0.50)),
                "q90": figure(&|s| s.quantile(0.90)),
                "q99": figure(&|s| s.quantile(0.99)),
            })
        };
        if self.statistics.is_empty() {
            return json!({});
        }
        let (state, action) = self.statistics.split_at(STATE.len());
        json!({ "observation.state.vehicle": of(state), "action": of(action) })
    }

    fn info(&self) -> Value {
        let scalar = |dtype: &str| json!({ "dtype": dtype, "shape": [1], "names": null });
        let vector = |names: &[&str]| json!({ "dtype": "float32", "shape": [names.len()], "names": names });
        let splits: BTreeMap<&str, String> =
            self.splits.iter().map(|(split, (from, to))| (*split, format!("{from}:{to}"))).collect();
        json!({
            "codebase_version": "v3.0",
            "robot_type": "vehicle",
            "total_episodes": self.episodes.len(),
            "total_frames": self.frames,
            "total_tasks": self.tasks.len(),
            "chunks_size": 1000,
            "data_files_size_in_mb": 100,
            "video_files_size_in_mb": 200,
            "fps": self.rate_hz.unwrap_or(10.0) as i64,
            "splits": splits,
            "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
            "video_path": null,
            "features": {
                "observation.state.vehicle": vector(&STATE),
                "action": vector(&ACTION),
                "timestamp": scalar("float32"),
                "frame_index": scalar("int64"),
                "episode_index": scalar("int64"),
                "index": scalar("int64"),
                "task_index": scalar("int64"),
                "language_persistent": scalar("language"),
                "language_events": scalar("language"),
            },
        })
    }
}

impl Statistics {
    fn mean(&self) -> f64 {
        self.values.iter().map(|v| f64::from(*v)).sum::<f64>() / self.values.len().max(1) as f64
    }

    fn deviation(&self) -> f64 {
        let mean = self.mean();
        let sum: f64 = self.values.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum();
        (sum / self.values.len().max(1) as f64).sqrt()
    }

    /// The values must be sorted.
    fn quantile(&self, q: f64) -> f64 {
        let at = ((self.values.len().saturating_sub(1)) as f64 * q).round() as usize;
        self.values.get(at).map_or(f64::NAN, |v| f64::from(*v))
    }
}

/// Times and rows of [`STATE`]; `None` when anything is unknown.
fn frames_of(sample: &Sample) -> Option<(Vec<f32>, Vec<[f32; 6]>)> {
    let (mut times, mut rows) = (Vec::new(), Vec::new());
    for part in [&sample.history, &sample.future] {
        for i in 0..part.t_s.len() {
            times.push(part.t_s[i]);
            rows.push(row(part, i)?);
        }
    }
    (times.len() > 1).then_some((times, rows))
}

fn row(t: &Trajectory, i: usize) -> Option<[f32; 6]> {
    let at = |column: &[Option<f32>]| column.get(i).copied().flatten();
    Some([at(&t.speed)?, at(&t.heading)?, at(&t.x)?, at(&t.y)?, at(&t.accel)?, at(&t.yaw_rate)?])
}

/// The task: the route, which is known before the drive; without one, to continue.
fn task(sample: &Sample) -> String {
    sample.route_text_en.clone().unwrap_or_else(|| "Drive safely along the road.".to_owned())
}

/// Language of an episode: meta actions where they change, the trace from t0 on.
fn language(sample: &Sample, language: TraceLanguage, first: f32) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut last: Option<(&str, &str)> = None;
    for part in [&sample.history, &sample.future] {
        for (i, t) in part.t_s.iter().enumerate() {
            let at = |column: &'_ [Option<String>]| column.get(i).cloned().flatten();
            let (Some(long), Some(lat)) = (at(&part.meta_longitudinal), at(&part.meta_lateral)) else {
                continue;
            };
            if last != Some((long.as_str(), lat.as_str())) {
                rows.push(Row { content: format!("{long}, {lat}"), style: "motion", timestamp: t - first });
            }
            last = part
                .meta_longitudinal
                .get(i)
                .and_then(Option::as_deref)
                .zip(part.meta_lateral.get(i).and_then(Option::as_deref));
        }
    }
    for (_, trace) in traces(sample, language) {
        rows.push(Row { content: trace.to_owned(), style: "plan", timestamp: -first });
    }
    rows.sort_by(|a, b| a.timestamp.total_cmp(&b.timestamp));
    rows
}

fn vectors(values: Vec<f32>, width: usize) -> Result<ArrayRef, DatasetError> {
    let item = Arc::new(Field::new("item", DataType::Float32, true));
    let width = i32::try_from(width).unwrap_or(i32::MAX);
    FixedSizeListArray::try_new(item, width, Arc::new(Float32Array::from(values)), None)
        .map(|a| Arc::new(a) as ArrayRef)
        .map_err(|e| DatasetError::broken(std::path::Path::new("export"), e))
}

fn row_fields(with_time: bool) -> Fields {
    let text = |name: &str, nullable| Field::new(name, DataType::Utf8, nullable);
    let calls = DataType::List(Arc::new(text("item", true)));
    let mut fields = vec![text("role", false), text("content", true), text("style", true)];
    if with_time {
        fields.push(Field::new("timestamp", DataType::Float32, false));
    }
    fields.extend([text("camera", true), Field::new("tool_calls", calls, true)]);
    fields.into()
}

fn persistent(rows: &[Arc<Vec<Row>>]) -> ArrayRef {
    let fields = row_fields(true);
    let item = Arc::new(Field::new("item", DataType::Struct(fields.clone()), true));
    let mut list = ListBuilder::new(StructBuilder::from_fields(fields, 0)).with_field(item);
    for of_frame in rows {
        for row in of_frame.iter() {
            let s = list.values();
            for (i, text) in
                [(0, Some("assistant")), (1, Some(row.content.as_str())), (2, Some(row.style)), (4, None)]
            {
                if let Some(b) = s.field_builder::<StringBuilder>(i) {
                    b.append_option(text);
                }
            }
            if let Some(b) = s.field_builder::<Float32Builder>(3) {
                b.append_value(row.timestamp);
            }
            if let Some(b) = s.field_builder::<ListBuilder<Box<dyn arrow_array::builder::ArrayBuilder>>>(5) {
                b.append_null();
            }
            s.append(true);
        }
        list.append(true);
    }
    Arc::new(list.finish())
}

/// Empty lists of events.
fn no_events(count: usize) -> ArrayRef {
    let kind = DataType::Struct(row_fields(false));
    let item = Arc::new(Field::new("item", kind.clone(), true));
    let offsets = arrow_buffer::OffsetBuffer::new_zeroed(count);
    Arc::new(ListArray::new(item, offsets, new_null_array(&kind, 0), None))
}
