//! MCAP recordings: ROS 2 (CDR), protobuf and JSON messages, each decoded by the schema that the file carries.
//!
//! Without a mapping file, the message types whose meaning is fixed are read: `nav_msgs/Odometry`,
//! `geometry_msgs/PoseStamped`, `foxglove.PoseInFrame` as the ego, `vision_msgs/Detection3DArray` and
//! `foxglove.SceneUpdate` (entities with a cube) as objects. A mapping file defines the rest. Frames are every 0.1 s of
//! the ego's time; messages' own stamps are used, the log's time where they have none. Not read: transforms (`tf`),
//! maps, lights, pictures. ROS 1 bags (`rosbag`) are read by the same code.

mod bus;
mod fields;
pub(crate) mod findings;
mod mapping;
mod rows;
mod values;

use crate::adapter::{Adapter, DriveSink, FilesInMemory, FormatAbout, Located, Source, whole};
use crate::assemble::class_names::class_of;
use crate::assemble::coverage::{stretches, unobserved};
use crate::assemble::frames::{Frames, Sample, Sampled};
use crate::assemble::resample::{MAX_GAP_S, linear};
use crate::assemble::se3::{self, Se3};
use crate::encodings::input::Input;
use crate::encodings::mcap_records::{self, Channel};
use crate::encodings::{cdr, protobuf};
use crate::file_reader::FileReader;
use crate::options::{LICENCE, OptionSpec, OptionType, Options};
use crate::report::{RowCount, SourceReport};
use crate::source::{
    ContentHash, drive_id, file_label, find_files, implausible_span, implausible_step, impossible_speeds,
    resampled,
};
use fields::FieldCounts;
use mapping::{Frame, Mapping, Role, Rule};
use rows::{BusRow, EgoRow, ObjectRow, Rows, Stamp};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use whyroad_model::scene::{DriveMeta, Ego, Track};
use whyroad_model::{Diagnostic, Drive, Nanos, Need};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 3;
/// The file that says which topics are what.
pub const MAPPING: OptionSpec =
    OptionSpec::new("mapping", OptionType::File, "FILE", "mapping file: which topics are what");
/// Poses further apart do not belong to one motion, s; in logs slower than 10 Hz, as many of their steps.
const EGO_GAP_S: f64 = MAX_GAP_S;
const EGO_GAP_STEPS: f64 = 1.5;
/// Objects are interpolated over gaps up to this, s: detectors run at 2 to 20 Hz.
const OBJECT_GAP_S: f64 = 0.6;
/// Stamps up to a day, ns, are those of a clock that began at 0: of a simulation.
const CLOCK_FROM_ZERO_NS: i64 = 86_400_000_000_000;
/// Names that the vehicle's own frame has by convention (ROS REP 105 and common use).
const EGO_FRAMES: [&str; 6] = ["base_link", "base_footprint", "ego", "ego_vehicle", "vehicle", "rear_axle"];

/// MCAP recordings.
pub struct Mcap;

impl Adapter for Mcap {
    fn about(&self) -> &'static FormatAbout {
        const {
            &FormatAbout {
                name: "mcap",
                summary: "MCAP recordings: ROS 2 (CDR), protobuf and JSON messages",
                example: "mcap drive.mcap --mapping topics.yaml --lake lake",
                options: &[MAPPING, LICENCE],
                codes: findings::CODES,
            }
        }
    }

    fn find(&self, path: &Path) -> Vec<Located> {
        whole(find_recordings(path))
    }

    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>) {
        drives.put(read(&source.path, options));
    }

    fn read_files(&self, files: &FilesInMemory, options: &Options, drives: &mut DriveSink<'_>) {
        read_in_memory(files, &CONTAINER, options, drives);
    }
}

/// MCAP files at or below `path`, sorted.
pub fn find_recordings(path: &Path) -> Vec<PathBuf> {
    find_by_ending(path, "mcap")
}

/// Files with this ending (without a dot) at or below `path`, sorted.
pub(super) fn find_by_ending(path: &Path, ending: &str) -> Vec<PathBuf> {
    find_files(path, |file| file.extension().is_some_and(|e| e == ending))
}

/// Reads one recording. `None` when there is nothing that could be kept; the report says why.
pub fn read(path: &Path, options: &Options) -> (Option<Drive>, SourceReport) {
    read_container(path, &CONTAINER, options)
}

const CONTAINER: Container = Container {
    format: "mcap",
    revision: REVISION,
    ending: ".mcap",
    records: |input, each| mcap_records::read(input, each).iter().map(ToString::to_string).collect(),
    broken: findings::broken,
};

/// Calls a function for every message of a file; returns what was lost.
type ReadRecords = fn(&Input<'_>, &mut dyn FnMut(mcap_records::Message<'_>)) -> Vec<String>;

/// A kind of file with messages: how they are taken out of it. What they mean is the same for all.
pub(super) struct Container {
    pub format: &'static str,
    pub revision: u32,
    pub ending: &'static str,
    pub records: ReadRecords,
    pub broken: fn(&str, &str) -> Diagnostic,
}

/// Reads a file of messages.
pub(super) fn read_container(
    path: &Path,
    container: &Container,
    options: &Options,
) -> (Option<Drive>, SourceReport) {
    let mapping = options.file(&MAPPING).map(|file| (file.display().to_string(), file.into()));
    read_input(path, &path.into(), mapping, container, options)
}

/// The same from any input; `path` is its name. The mapping, where there is one, with its name.
pub(super) fn read_input(
    path: &Path,
    input: &Input<'_>,
    mapping: Option<(String, Input<'_>)>,
    container: &Container,
    options: &Options,
) -> (Option<Drive>, SourceReport) {
    let mut report = SourceReport::new(path.display().to_string());
    let drive = read_recording(path, input, mapping, container, options, &mut report);
    (drive, report)
}

/// A topic: its rule, how its messages are decoded, and the results.
struct Topic {
    rule: Rule,
    schema: String,
    decoder: Decoder,
    messages: usize,
    undecodable: usize,
    fields: FieldCounts,
    ego: Vec<EgoRow>,
    objects: Vec<ObjectRow>,
    bus: Vec<BusRow>,
    /// When objects were observed.
    observed: Vec<Stamp>,
}

enum Decoder {
    Json,
    Cdr(cdr::MessageType),
    Ros1(cdr::MessageType),
    Protobuf(protobuf::messages::MessageTypes),
    /// Why it cannot be decoded.
    None(String),
}

impl Topic {
    /// At least one of its messages was decoded.
    fn is_read(&self) -> bool {
        self.messages > self.undecodable
    }

    fn new(channel: &Channel, mapping: &Mapping) -> Self {
        let schema = &channel.schema;
        let rule = mapping.topics.get(&channel.topic).cloned().or_else(|| mapping::standard(&schema.name));
        let decoder = match (channel.encoding.as_str(), schema.encoding.as_str()) {
            ("json", _) => Decoder::Json,
            ("cdr", "ros2msg") => {
                Decoder::Cdr(cdr::MessageType::parse(&schema.name, &String::from_utf8_lossy(&schema.data)))
            }
            ("ros1", "ros1msg") => {
                Decoder::Ros1(cdr::MessageType::parse(&schema.name, &String::from_utf8_lossy(&schema.data)))
            }
            ("protobuf", "protobuf") => {
                let types = protobuf::messages::MessageTypes::parse(&schema.data);
                types.map_or(Decoder::None("its schema is broken".into()), Decoder::Protobuf)
            }
            (message, schema) => {
                Decoder::None(format!("encoding '{message}' with schema '{schema}' is not read"))
            }
        };
        let (rule, schema) = (rule.unwrap_or_default(), schema.name.clone());
        Self {
            rule,
            schema,
            decoder,
            messages: 0,
            undecodable: 0,
            fields: FieldCounts::default(),
            ego: Vec::new(),
            objects: Vec::new(),
            bus: Vec::new(),
            observed: Vec::new(),
        }
    }

    /// Applies `each` to the stamps of all rows.
    fn stamps(&mut self, mut each: impl FnMut(&mut Stamp)) {
        self.ego.iter_mut().for_each(|r| each(&mut r.stamp));
        self.objects.iter_mut().for_each(|r| each(&mut r.stamp));
        self.bus.iter_mut().for_each(|r| each(&mut r.stamp));
    }

    /// Fields that its messages do not have, or have in a form that is not understood.
    fn of_fields(&self, label: &str, name: &str) -> Vec<Diagnostic> {
        let mut out = Vec::new();
        for (field, count) in &self.fields.0 {
            let field = (*field, count);
            // A standard type has fields that may be left out.
            if count.absent == count.read && !self.rule.is_standard {
                out.push(findings::field_absent(label, name, self.rule.role, field));
            }
            out.extend(findings::field_unreadable(label, name, self.rule.role, field));
        }
        out
    }

    fn decode(&self, data: &[u8]) -> Option<Value> {
        match &self.decoder {
            Decoder::Json => serde_json::from_slice(data).ok(),
            Decoder::Cdr(t) => t.decode(data),
            Decoder::Ros1(t) => t.decode_ros1(data),
            Decoder::Protobuf(t) => t.decode(&self.schema, data),
            Decoder::None(_) => None,
        }
    }
}

/// Everything that the messages of a recording gave.
#[derive(Default)]
struct Recording {
    topics: BTreeMap<String, Topic>,
    counts: RowCounts,
}

/// The rows of each role.
struct RowCounts {
    ego: RowCount,
    objects: RowCount,
    bus: RowCount,
}

impl Default for RowCounts {
    fn default() -> Self {
        Self { ego: RowCount::new("ego"), objects: RowCount::new("objects"), bus: RowCount::new("bus") }
    }
}

impl RowCounts {
    fn of(&mut self, role: Role) -> &mut RowCount {
        match role {
            Role::Ego => &mut self.ego,
            Role::Bus => &mut self.bus,
            Role::Objects | Role::Ignore => &mut self.objects,
        }
    }

    /// Those of which there are rows, and of the two tables that every recording has.
    fn report(self, label: &str, report: &mut SourceReport) {
        let has_bus = self.bus.read > 0;
        for count in [Some(self.ego), Some(self.objects), has_bus.then_some(self.bus)].into_iter().flatten() {
            if count.dropped_total() > 0 {
                report.diagnostics.push(findings::dropped(label, &count));
            }
            report.tables.push(count);
        }
    }
}

impl Recording {
    fn read(
        label: &str,
        input: &Input<'_>,
        container: &Container,
        mapping: &Mapping,
        hash: &mut ContentHash,
        report: &mut SourceReport,
    ) -> Self {
        let mut out = Self::default();
        let mut each = |m: mcap_records::Message<'_>| {
            let name = &m.channel.topic;
            if !out.topics.contains_key(name) {
                out.topics.insert(name.clone(), Topic::new(m.channel, mapping));
            }
            let Some(topic) = out.topics.get_mut(name) else { return };
            topic.messages += 1;
            if topic.rule.role == Role::Ignore {
                return;
            }
            hash.add(name, &m.log_time.to_le_bytes());
            hash.add(name, m.data);
            let Some(message) = topic.decode(m.data) else {
                topic.undecodable += 1;
                let count = out.counts.of(topic.rule.role);
                count.read += 1;
                count.drop_rows("undecodable", 1);
                return;
            };
            let Rows { ego, objects, bus, dropped, observed } =
                rows::of(&message, &topic.rule, m.log_time, &mut topic.fields);
            let count = out.counts.of(topic.rule.role);
            count.read += ego.len() + objects.len() + bus.len() + dropped.len();
            dropped.iter().for_each(|reason| count.drop_rows(reason, 1));
            topic.ego.extend(ego);
            topic.objects.extend(objects);
            topic.bus.extend(bus);
            topic.observed.extend(observed);
        };
        let errors = (container.records)(input, &mut each);
        report.diagnostics.extend(errors.iter().map(|e| (container.broken)(label, e)));
        report.diagnostics.extend(out.absent(label, mapping));
        for (name, t) in out.topics.iter().filter(|(_, t)| t.undecodable > 0) {
            let what = match &t.decoder {
                Decoder::None(reason) => reason.as_str(),
                _ => "they do not fit their schema",
            };
            report.diagnostics.push(findings::undecodable(label, name, what, t.undecodable));
        }
        out.settle_times(label, report);
        report.diagnostics.extend(out.topics.iter().flat_map(|(name, topic)| topic.of_fields(label, name)));
        out
    }

    /// Decides what stamps of 0 are. Where the other stamps are those of a clock that began at 0, the beginning. Where
    /// a topic has no other, they were not set, and the log's times are used. Otherwise the row has no time.
    fn settle_times(&mut self, label: &str, report: &mut SourceReport) {
        let from_zero = self.topics.values_mut().any(|topic| {
            let mut found = false;
            topic.stamps(|stamp| found |= !stamp.is_zero && (1..=CLOCK_FROM_ZERO_NS).contains(&stamp.time));
            found && topic.rule.time.is_some()
        });
        for (name, topic) in &mut self.topics {
            let (mut zeros, mut all) = (0, 0);
            topic.stamps(|stamp| {
                all += 1;
                zeros += usize::from(stamp.is_zero);
            });
            if from_zero && zeros < all {
                topic.stamps(|stamp| stamp.time = if stamp.is_zero { 0 } else { stamp.time });
            } else if zeros > 0 && zeros == all {
                report.diagnostics.push(findings::time_of_log(label, name, zeros));
            } else if zeros > 0 {
                topic.ego.retain(|r| !r.stamp.is_zero);
                topic.objects.retain(|r| !r.stamp.is_zero);
                topic.bus.retain(|r| !r.stamp.is_zero);
                self.counts.of(topic.rule.role).drop_rows("no_time", zeros);
            }
            topic.observed.retain_mut(|stamp| {
                if stamp.is_zero && from_zero && zeros < all {
                    stamp.time = 0;
                }
                !stamp.is_zero || from_zero || zeros == all
            });
        }
    }

    /// Frames in which a topic of objects has no messages.
    fn unobserved(&self, seconds: impl Fn(i64) -> f64, frames: &[f64]) -> Vec<bool> {
        let of_objects = self.topics.values().filter(|t| t.rule.role == Role::Objects && t.is_read());
        let times: Vec<Vec<f64>> = of_objects
            .map(|topic| {
                let mut times: Vec<f64> = topic.observed.iter().map(|s| seconds(s.time)).collect();
                times.sort_by(f64::total_cmp);
                times.dedup();
                times
            })
            .collect();
        unobserved(&times, frames, OBJECT_GAP_S)
    }

    /// Topics of the file that nothing reads, with their types.
    fn unread(&self, mapping: &Mapping) -> Vec<(&String, &Topic)> {
        let is_unread =
            |(n, t): &(&String, &Topic)| t.rule.role == Role::Ignore && !mapping.topics.contains_key(*n);
        self.topics.iter().filter(is_unread).collect()
    }

    /// Topics of the mapping that the file does not have.
    fn absent(&self, label: &str, mapping: &Mapping) -> Vec<Diagnostic> {
        // Of a file without any message that is said already.
        if self.topics.is_empty() {
            return Vec::new();
        }
        let others = list(&self.unread(mapping));
        let named = mapping.topics.iter().filter(|(_, rule)| rule.role != Role::Ignore);
        let absent = named.filter(|(n, _)| !self.topics.contains_key(*n));
        absent.map(|(n, _)| findings::topic_absent(label, n, &others)).collect()
    }

    /// The ego's poses by time. With several pose topics, odometry takes precedence over bare poses, then order by
    /// name.
    fn take_ego(&mut self, label: &str, report: &mut SourceReport) -> Vec<EgoRow> {
        let mut with_poses: Vec<(bool, &String)> = self
            .topics
            .iter()
            .filter(|(_, t)| !t.ego.is_empty())
            .map(|(n, t)| (t.rule.velocity.is_none(), n))
            .collect();
        with_poses.sort();
        let names: Vec<String> = with_poses.into_iter().map(|(_, n)| n.clone()).collect();
        let Some(taken) = names.first().cloned() else { return Vec::new() };
        if names.len() > 1 {
            report.diagnostics.push(findings::ego_ambiguous(label, &names.join(", "), &taken));
        }
        for other in &names[1..] {
            let rows = self.topics.get(other).map_or(0, |t| t.ego.len());
            self.counts.ego.set_aside("another_topic", rows);
        }
        let mut rows = self.topics.get_mut(&taken).map(|t| std::mem::take(&mut t.ego)).unwrap_or_default();
        let all = rows.len();
        rows.sort_by_key(|r| r.stamp.time);
        rows.dedup_by_key(|r| r.stamp.time);
        self.counts.ego.drop_rows("duplicate", all - rows.len());
        self.counts.ego.keep("pose", rows.len());
        rows
    }
}

/// Topics with their types.
fn list(topics: &[(&String, &Topic)]) -> String {
    topics.iter().map(|(n, t)| format!("{n} ({})", t.schema)).collect::<Vec<_>>().join(", ")
}

fn read_mapping(
    file: Option<(String, Input<'_>)>,
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> Option<Mapping> {
    let Some((label, file)) = file else { return Some(Mapping::default()) };
    let text =
        file.text().map_err(|e| report.diagnostics.push(findings::mapping(&label, &e.to_string()))).ok()?;
    hash.add("mapping", text.as_bytes());
    let (mapping, problems) = Mapping::read(&label, &text);
    report.diagnostics.extend(problems.into_iter().map(findings::with_guide));
    mapping
}

fn read_recording(
    path: &Path,
    input: &Input<'_>,
    mapping: Option<(String, Input<'_>)>,
    container: &Container,
    options: &Options,
    report: &mut SourceReport,
) -> Option<Drive> {
    let label = path.display().to_string();
    let mut hash = ContentHash::new(container.format, container.revision);
    let mapping = read_mapping(mapping, &mut hash, report)?;
    let mut recording = Recording::read(&label, input, container, &mapping, &mut hash, report);
    let poses = recording.take_ego(&label, report);
    let (Some(first), true) = (poses.first().map(|r| r.stamp.time), poses.len() >= 2) else {
        let topics: Vec<String> =
            recording.topics.iter().map(|(n, t)| format!("{n} ({})", t.schema)).collect();
        report.diagnostics.push(findings::ego_missing(&label, &recording.counts.ego, &topics.join(", ")));
        return None;
    };
    let seconds = |ns: i64| ns.saturating_sub(first) as f64 / 1e9;
    let times: Vec<f64> = poses.iter().map(|r| seconds(r.stamp.time)).collect();
    if let Some(d) = implausible_span(&label, times[0], times[times.len() - 1], times.len()) {
        report.diagnostics.push(d);
        return None;
    }
    let mut frames = Frames::of(&times);
    if let Some(d) = implausible_step(&label, frames.native_step_s) {
        report.diagnostics.push(d);
        return None;
    }
    if frames.resampled() {
        report.diagnostics.push(resampled(&label, frames.native_step_s));
    }
    // `max` passes over NaN.
    let poses = Poses { rows: &poses, gap_s: (EGO_GAP_STEPS * frames.native_step_s).max(EGO_GAP_S) };
    // A gap in the log is a gap in the drive.
    let mut there = linear(&times, &times, &frames.seconds, poses.gap_s).into_iter();
    frames.seconds.retain(|_| there.next().is_some_and(f64::is_finite));
    let ego = ego(&poses, &times, &frames.seconds, &mapping);
    let unread = recording.unread(&mapping);
    if !unread.is_empty() {
        let messages = unread.iter().map(|(_, t)| t.messages).sum();
        report.diagnostics.push(findings::topics_unread(&label, &list(&unread), messages));
    }
    let bus_rows: Vec<BusRow> =
        recording.topics.values_mut().flat_map(|t| std::mem::take(&mut t.bus)).collect();
    let bus = bus::at_frames(&bus_rows, seconds, &frames.seconds);
    let count = &mut recording.counts.bus;
    bus::account(&bus_rows, seconds, &frames.seconds, &label, count, report);
    let tracks = tracks(&mut recording, &poses, seconds, &frames.seconds, &mapping, &label, report);
    let can = bus::has_values(&bus);
    let has_objects = recording.topics.values().any(|t| t.rule.role == Role::Objects && t.is_read());
    let unobserved = recording.unobserved(seconds, &frames.seconds);
    let times: Vec<Nanos> = frames.seconds.iter().map(|&s| Nanos(first).plus_secs(s)).collect();
    let missing = Need::absent([
        (!has_objects, Need::Objects),
        (ego.length_m.is_nan(), Need::EgoSize),
        (true, Need::Map),
        (true, Need::TrafficLights),
        (!can, Need::VehicleBus),
        (true, Need::WeatherAndSurface),
        (true, Need::CameraPictures),
    ]);
    recording.counts.report(&label, report);
    let name = file_label(path);
    Some(Drive {
        meta: DriveMeta {
            drive_id: options
                .drive_id
                .clone()
                .unwrap_or_else(|| drive_id(name.trim_end_matches(container.ending))),
            format: container.format.into(),
            source: container.format.into(),
            licence: options.licence(),
            content_hash: hash.finish(),
            can,
            missing,
            objects_unknown: if has_objects { stretches(&unobserved, &times) } else { Vec::new() },
            ..DriveMeta::default()
        },
        times,
        ego: Some(Ego { bus, ..ego }),
        tracks,
        ..Drive::default()
    })
}

/// Poses of the ego, and how far two of them may be apart, s.
struct Poses<'a> {
    rows: &'a [EgoRow],
    gap_s: f64,
}

fn ego(poses: &Poses<'_>, times: &[f64], frames: &[f64], mapping: &Mapping) -> Ego {
    let reference = mapping.ego.reference_to_centre_m;
    let mut sampled = Sampled::default();
    for (row, &time) in poses.rows.iter().zip(times) {
        // The velocity is that of the pose's point: away from it the middle of the car swings sideways in turns, but
        // goes as fast along the heading.
        let at_center = row.velocity.filter(|_| reference == 0.0);
        let velocity = at_center.map_or([f64::NAN; 2], |[ahead, left]| {
            let v = se3::rotate(row.pose.q, [ahead, left, 0.0]);
            [v[0], v[1]]
        });
        let forward = row.velocity.filter(|_| reference != 0.0).map_or(f64::NAN, |[ahead, _]| ahead);
        sampled.push(Sample {
            time,
            position: row.pose.apply([reference, 0.0, 0.0]),
            heading: se3::heading(row.pose.q),
            velocity,
            forward,
            ..Sample::UNKNOWN
        });
    }
    Ego {
        length_m: mapping.ego.length_m.unwrap_or(f64::NAN),
        width_m: mapping.ego.width_m.unwrap_or(f64::NAN),
        height_m: mapping.ego.height_m.unwrap_or(f64::NAN),
        reference_to_centre_m: reference,
        motion: sampled.motion_at(frames, poses.gap_s),
        known_at: sampled.lags(frames),
        ..Ego::default()
    }
}

impl Poses<'_> {
    /// Where the ego was at a time between two of its poses.
    fn at(&self, time: i64) -> Option<Se3> {
        let next = self.rows.partition_point(|r| r.stamp.time < time);
        let b = self.rows.get(next)?;
        if b.stamp.time == time {
            return Some(b.pose);
        }
        let a = &self.rows[next.checked_sub(1)?];
        let span = b.stamp.time.saturating_sub(a.stamp.time) as f64;
        let since = time.saturating_sub(a.stamp.time) as f64;
        (span <= self.gap_s * 1e9).then(|| a.pose.between(&b.pose, since / span))
    }
}

/// A place in the frame of the ego's pose `at`; without a height, that of the ego's plane serves for x and y.
fn place(at: Se3, position: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = position;
    let [wx, wy, wz] = at.apply([x, y, if z.is_nan() { 0.0 } else { z }]);
    [wx, wy, if z.is_nan() { f64::NAN } else { wz }]
}

/// A velocity over ground in the axes of the world; `axes` is the rotation of the axes in which it is stated.
fn in_world([x, y]: [f64; 2], axes: Option<[f64; 4]>) -> [f64; 2] {
    axes.map_or([x, y], |q| {
        let v = se3::rotate(q, [x, y, 0.0]);
        [v[0], v[1]]
    })
}

fn tracks(
    recording: &mut Recording,
    poses: &Poses<'_>,
    seconds: impl Fn(i64) -> f64,
    frames: &[f64],
    mapping: &Mapping,
    label: &str,
    report: &mut SourceReport,
) -> Vec<Track> {
    let rows: Vec<ObjectRow> =
        recording.topics.values_mut().flat_map(|t| std::mem::take(&mut t.objects)).collect();
    let count = &mut recording.counts.objects;
    let (world, own) =
        poses.rows.first().map_or(("", ""), |p| (p.frame_id.as_str(), p.child_frame_id.as_str()));
    let mut foreign: BTreeMap<String, usize> = BTreeMap::new();
    let mut objects: BTreeMap<String, (String, BTreeMap<i64, Sample>)> = BTreeMap::new();
    for row in rows {
        let id = row.frame_id.as_str();
        let frame = row.frame.or_else(|| {
            let ego = (!own.is_empty() && id == own) || EGO_FRAMES.contains(&id);
            if id == world { Some(Frame::World) } else { ego.then_some(Frame::Ego) }
        });
        let (pose, axes) = match frame {
            None => {
                *foreign.entry(row.frame_id.clone()).or_default() += 1;
                count.drop_rows("unknown_frame", 1);
                continue;
            }
            Some(Frame::World) => (row.pose, None),
            Some(Frame::Ego) => match poses.at(row.stamp.time) {
                Some(at) => {
                    let q = se3::compose(at.q, row.pose.q);
                    (Se3 { q, t: place(at, row.pose.t) }, Some(at.q))
                }
                None => {
                    count.drop_rows("no_pose", 1);
                    continue;
                }
            },
        };
        let velocity = row.velocity.map_or([f64::NAN; 2], |v| in_world(v, axes));
        let (size, heading) = (row.size, se3::heading(pose.q));
        let sample = Sample {
            time: seconds(row.stamp.time),
            position: pose.t,
            heading,
            velocity,
            size,
            ..Sample::UNKNOWN
        };
        let (_, samples) = objects.entry(row.id).or_insert_with(|| (row.class, BTreeMap::new()));
        if samples.insert(row.stamp.time, sample).is_some() {
            count.drop_rows("duplicate", 1);
        }
    }
    report.diagnostics.extend(foreign.iter().map(|(id, n)| findings::frame(label, id, *n)));
    let (mut out, mut unknown, mut impossible) = (Vec::new(), BTreeSet::new(), BTreeMap::new());
    for (id, (name, samples)) in objects {
        let class = mapping.classes.get(&name).copied().or_else(|| class_of(&name));
        if class.is_none() {
            unknown.insert(if name.is_empty() { "-".to_owned() } else { name.clone() });
        }
        let mut sampled = Sampled::default();
        samples.into_values().for_each(|s| sampled.push(s));
        let class = class.unwrap_or_default();
        let (track, rows) = sampled.track_at(&id, class, &name, frames, OBJECT_GAP_S);
        if rows > 0 {
            impossible.insert(id, rows);
        }
        // Seen once, between two frames, or while the ego was away.
        if track.frames.is_empty() {
            let drive = frames.first().zip(frames.last()).map(|(first, last)| *first..=*last);
            let is_in = |t: &f64| drive.as_ref().is_some_and(|drive| drive.contains(t));
            let is_between = sampled.times.iter().any(is_in);
            let why = if is_between { "between_frames" } else { "ego_away" };
            count.set_aside(why, sampled.times.len());
            continue;
        }
        count.keep("track", sampled.times.len());
        out.push(track);
    }
    if !unknown.is_empty() {
        report.diagnostics.push(findings::class(label, &unknown.into_iter().collect::<Vec<_>>().join(", ")));
    }
    report.diagnostics.extend(impossible_speeds(label, &impossible));
    out
}

/// For [`crate::readers`].
pub(crate) const READERS: &[FileReader] = &[FileReader {
    name: "mcap-mapping",
    read: |bytes| Mapping::read("mapping", &String::from_utf8_lossy(bytes)).0.is_some(),
}];

/// Reads the recording among these files by the mapping among them.
pub(super) fn read_in_memory(
    files: &FilesInMemory,
    container: &Container,
    options: &Options,
    drives: &mut DriveSink<'_>,
) {
    let ending = |ending: &str| files.iter().find(|(name, _)| name.ends_with(ending));
    let Some((name, recording)) = ending(container.ending) else { return };
    let mapping = ending(".yaml").map(|(name, text)| (name.clone(), Input::Memory(text)));
    let (path, input) = (Path::new(name), Input::Memory(recording));
    drives.put(read_input(path, &input, mapping, container, options));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A car that heads north (a quarter turn about z) states 10 m/s ahead: that is 10 m/s along y.
    #[test]
    fn velocities_in_the_axes_of_the_car_are_turned_into_the_world() {
        let north = [std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2];
        let [x, y] = in_world([10.0, 0.0], Some(north));
        assert!(x.abs() < 1e-9 && (y - 10.0).abs() < 1e-9);
        assert_eq!(in_world([10.0, 1.0], None), [10.0, 1.0]);
    }
}
