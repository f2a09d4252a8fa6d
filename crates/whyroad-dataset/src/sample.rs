//! One sample of a release in memory: a keyframe of a drive with the model's input (history, images, route) and its
//! target (trace, decisions, components, future). The same struct is the row of the release's Parquet files; the
//! columns have the names of its fields (`docs/reference/release.md` lists them).
//!
//! Frame of every position, heading and velocity: right-handed, metric, x forward, y left, z up, origin and axes
//! those of the ego's reference point at t0 (the keyframe's frame). Times are seconds from t0. `None` is unknown,
//! never zero.

pub mod schema;

use serde::{Deserialize, Serialize};

/// Version of the sample's columns; the minor part rises with new columns, the major part when a reader would
/// misread.
pub const SAMPLE_VERSION: &str = "1.1.0";

/// One row. A column that a reader left out is read as its default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Sample {
    /// 16 hexadecimal digits of a hash of drive id, keyframe time and class: the same sample in every release.
    pub sample_id: String,
    /// `train`, `val` or `test`.
    pub split: String,
    /// Sampling weight; the mean over the training split is 1, and 1 in the other splits.
    pub weight: f64,
    /// Trigger category.
    pub l1: String,
    /// Scenario.
    pub l2: String,
    /// Variant; `None` when the label names the L2 only.
    pub l3: Option<String>,
    /// `l1.l2` or `l1.l2.l3`.
    pub scenario_id: String,
    /// Other triggers that were active, full ids.
    pub secondary_scenarios: Vec<String>,
    /// Longitudinal decision (one of nine ids); `None` is "no change of decision".
    pub longitudinal: Option<String>,
    /// Lateral decision (one of nine ids); `None` is "no change of decision".
    pub lateral: Option<String>,
    /// `left`, `right` or `uturn`, where the lateral decision has a side.
    pub lateral_direction: Option<String>,
    /// The trace in Chinese, when there is a label in Chinese.
    pub trace_zh: Option<String>,
    /// The trace in English, when there is a label in English.
    pub trace_en: Option<String>,
    /// Critical components of the label.
    pub components: Vec<Component>,
    /// Causes of the longitudinal decision.
    pub cause_longitudinal: Option<Cause>,
    /// Causes of the lateral decision.
    pub cause_lateral: Option<Cause>,
    /// Route instruction at t0 as the log has it: `left`, `right`, `straight`, `uturn`, `exit`, `none`; `None`: no
    /// route in the log. Never taken from the future.
    pub route: Option<String>,
    /// The route instruction as a sentence in Chinese.
    pub route_text_zh: Option<String>,
    /// The route instruction as a sentence in English.
    pub route_text_en: Option<String>,
    /// Where the sample comes from.
    pub lineage: Lineage,
    /// Its group keys.
    pub groups: Groups,
    /// The ego's box and reference point.
    pub ego: EgoBox,
    /// The past, t0 included, oldest first.
    pub history: Trajectory,
    /// The future, t0 excluded.
    pub future: Trajectory,
    /// Tracked objects that were observed at or before t0 within the radius, nearest at t0 first.
    pub objects: Vec<Object>,
    /// Lanes, crosswalks, stop lines, junctions within the radius; `None`: the log has no map.
    pub map: Option<Vec<MapElement>>,
    /// Traffic lights at t0; `None`: the log has no lights.
    pub lights: Option<Vec<Light>>,
    /// Weather, surface, lighting and the like at t0; `None`: the log states none.
    pub context: Option<Vec<ContextValue>>,
    /// Images, by camera, then time.
    pub images: Vec<Image>,
    /// The label as JSON (DATA_FORMAT.md 4).
    pub label_json: String,
    /// The label of the same keyframe in the other language, as JSON.
    pub label_json_other: Option<String>,
    /// Versions of the label that a checker returned for rework, as JSON, oldest first.
    pub rejected: Vec<Rejected>,
}

impl Sample {
    /// False for a text of another tool (`whyroad labels import`), whose decision is unknown: no change of decision is
    /// a decision, too, but it has a cause, and such a text has none.
    pub fn states_decision(&self) -> bool {
        self.longitudinal.is_some() || self.lateral.is_some() || !self.components.is_empty()
    }
}

/// A label version that was returned.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rejected {
    /// The version as JSON.
    pub label_json: String,
    /// Its trace.
    pub trace: Option<String>,
    /// The checker's reason.
    pub reason: Option<String>,
}

/// A critical component.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Component {
    /// Name within the label, referred to by the causes.
    pub id: Option<String>,
    /// Free category.
    pub category: Option<String>,
    /// In words.
    pub description: String,
    /// `low` or `high`.
    pub uncertainty: Option<String>,
    /// When it could be observed, seconds from t0 (never positive).
    pub evidence_t_s: Vec<f32>,
    /// Track ids.
    pub objects: Vec<String>,
}

/// Causes of one decision.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cause {
    /// Ids of components.
    pub components: Vec<String>,
    /// Why no cause could be observed.
    pub unobserved: Option<String>,
}

/// Where a sample comes from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Lineage {
    /// Drive in the lake.
    pub drive_id: String,
    /// Content hash of the drive when the sample was cut.
    pub drive_hash: String,
    /// Clip that the label names.
    pub clip_id: String,
    /// Episode that led to the label; `None` when the label's source does not state it.
    pub episode_id: Option<String>,
    /// Track that the episode's rule bound.
    pub target_id: Option<String>,
    /// Task of the labeling service.
    pub task_id: Option<String>,
    /// Time of t0, nanoseconds since 1970 as the log states it.
    pub keyframe_time_ns: i64,
    /// Frame of t0 in the drive.
    pub keyframe_frame: u32,
    /// SHA-256 of `label_json`.
    pub label_sha256: String,
    /// Format version of the label.
    pub label_version: Option<String>,
    /// State in the labeling service (`accepted`, `submitted`, ...), or `draft`, or `imported` for labels of a plain
    /// file.
    pub label_status: String,
    /// True when a person other than the author accepted it; false for every draft.
    pub checked: bool,
    /// `person`, `model` or `rule`.
    pub label_source: Option<String>,
    /// The author.
    pub label_by: Option<String>,
    /// Version of the taxonomy that the label was made with.
    pub taxonomy_version: Option<String>,
    /// Version of the mining rules.
    pub rule_version: Option<String>,
    /// Match score of the episode, 0 to 1.
    pub score: Option<f64>,
}

/// Group keys. Samples that share one of the keys that the spec splits by are in one split.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Groups {
    /// Connected component, numbered from 0 in order of its first sample id.
    pub component: u32,
    /// Recording session.
    pub session: Option<String>,
    /// Vehicle.
    pub vehicle: Option<String>,
    /// City or road network.
    pub place: Option<String>,
    /// Cell of the place grid or name of the polygon.
    pub place_cell: Option<String>,
    /// Date of t0, UTC, `YYYY-MM-DD`.
    pub date: Option<String>,
    /// Source of the drive.
    pub source: String,
    /// License of the drive: an id of `schema/licences.yaml`.
    pub licence: String,
    /// Frame of `position`: `geo` (on the Earth) or `map:<place>`; `None`: no position that other drives can be
    /// compared with.
    pub position_frame: Option<String>,
    /// The reference point at t0, m: x, y, 0 of the map, or a point of the Earth's sphere around its center, so that
    /// distances of samples can be computed by subtraction.
    pub position: Option<Vec<f64>>,
    /// Longitude and latitude at t0, degrees, where the drive states its position on Earth.
    pub longitude_latitude: Option<Vec<f64>>,
    /// Reference point at t0 in the drive's world frame, m.
    pub world_x: Option<f64>,
    /// m.
    pub world_y: Option<f64>,
    /// m.
    pub world_z: Option<f64>,
    /// Heading at t0, rad counter-clockwise from x, (-pi, pi].
    pub world_heading: Option<f64>,
}

/// The ego's box.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EgoBox {
    /// m.
    pub length_m: Option<f32>,
    /// m.
    pub width_m: Option<f32>,
    /// m.
    pub height_m: Option<f32>,
    /// `rear_axle` or `box_centre`: the point that every pose of the sample refers to.
    pub reference: String,
    /// From the reference point forward to the box center, m.
    pub reference_to_centre_m: f32,
}

/// The ego over time: one value per step in every list.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Trajectory {
    /// Seconds from t0.
    pub t_s: Vec<f32>,
    /// m.
    pub x: Vec<Option<f32>>,
    /// m.
    pub y: Vec<Option<f32>>,
    /// m.
    pub z: Vec<Option<f32>>,
    /// rad, (-pi, pi].
    pub heading: Vec<Option<f32>>,
    /// m/s along the heading, negative backwards.
    pub speed: Vec<Option<f32>>,
    /// m/s2 along the heading.
    pub accel: Vec<Option<f32>>,
    /// rad/s, counter-clockwise.
    pub yaw_rate: Vec<Option<f32>>,
    /// Longitudinal meta action (LABELING.md 5).
    pub meta_longitudinal: Vec<Option<String>>,
    /// Lateral meta action.
    pub meta_lateral: Vec<Option<String>>,
    /// Every step has a pose.
    pub complete: bool,
}

/// A tracked object: rows only for steps at which it was observed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Track id in the drive.
    pub id: String,
    /// Class by observations up to t0.
    pub class: String,
    /// The episode's target or an object that the label names.
    pub named: bool,
    /// m, at its last observation up to t0.
    pub length_m: Option<f32>,
    /// m.
    pub width_m: Option<f32>,
    /// m.
    pub height_m: Option<f32>,
    /// Seconds from t0, ascending; rows with `t_s > 0` are future.
    pub t_s: Vec<f32>,
    /// Box center, m.
    pub x: Vec<Option<f32>>,
    /// m.
    pub y: Vec<Option<f32>>,
    /// m; since 1.1.0, empty in older samples.
    #[serde(default)]
    pub z: Vec<Option<f32>>,
    /// rad.
    pub heading: Vec<Option<f32>>,
    /// m/s along the sample's x axis, over ground.
    pub vx: Vec<Option<f32>>,
    /// m/s along the sample's y axis, over ground.
    pub vy: Vec<Option<f32>>,
}

/// A part of the map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapElement {
    /// Id in the map.
    pub id: String,
    /// `lane`, `junction_lane`, `bus_lane`, `bike_lane`, `sidewalk`, `other_lane`, `crosswalk`, `stop_line`,
    /// `junction`.
    pub kind: String,
    /// Center line of a lane in driving direction, the line of a stop line, the outline of an area, m; points of one
    /// line that is cut by the radius several times follow each other.
    pub x: Vec<f32>,
    /// m.
    pub y: Vec<f32>,
    /// Mean width of a lane, m.
    pub width_m: Option<f32>,
    /// Legal limit, m/s.
    pub speed_limit_mps: Option<f32>,
    /// Lanes that can be entered at the end.
    pub successors: Vec<String>,
}

/// A traffic light.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Light {
    /// Lane that it controls.
    pub lane_id: String,
    /// Lane behind the light.
    pub to_lane_id: Option<String>,
    /// `red`, `yellow`, `green`, `green_yield`, ...
    pub color: String,
    /// When the state began or was observed, seconds from t0 (never positive).
    pub since_s: f32,
}

/// A stated condition.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContextValue {
    /// `weather`, `surface`, `lighting`, ...
    pub kind: String,
    /// In the words of `schema/signals.yaml`.
    pub value: String,
}

/// An image.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Image {
    /// Camera, or `bev` for an image that was rendered from the tables.
    pub camera: String,
    /// Seconds from t0, never positive.
    pub t_s: f32,
    /// File type: `png`, `jpg`, `webp`.
    pub format: String,
    /// SHA-256 of the bytes.
    pub sha256: String,
    /// The file's content.
    #[serde(with = "bytes")]
    pub bytes: Vec<u8>,
}

/// Bytes as one value, not as a list of numbers.
mod bytes {
    use serde::de::{Error, SeqAccess, Visitor};
    use serde::{Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(bytes: &[u8], s: S) -> Result<S::Ok, S::Error> {
        s.serialize_bytes(bytes)
    }

    struct Bytes;

    impl<'de> Visitor<'de> for Bytes {
        type Value = Vec<u8>;

        fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("bytes")
        }
        fn visit_bytes<E: Error>(self, v: &[u8]) -> Result<Vec<u8>, E> {
            Ok(v.to_vec())
        }
        fn visit_byte_buf<E: Error>(self, v: Vec<u8>) -> Result<Vec<u8>, E> {
            Ok(v)
        }
        fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Vec<u8>, A::Error> {
            let mut out = Vec::with_capacity(seq.size_hint().unwrap_or(0).min(1 << 20));
            while let Some(byte) = seq.next_element()? {
                out.push(byte);
            }
            Ok(out)
        }
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Vec<u8>, D::Error> {
        d.deserialize_byte_buf(Bytes)
    }
}
