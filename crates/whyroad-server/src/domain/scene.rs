//! A drive as shown on the labeling screen. Columns have one value per frame of `times`; null is unknown.

use super::workflow::Stage;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use whyroad_model::Bilingual;

/// Numbers of one column; null is unknown.
pub type Numbers = Vec<Option<f64>>;

/// The scene of a task, as far as it may be shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SceneView {
    /// How much is shown.
    pub stage: Stage,
    /// Nominal frames per second.
    pub frame_rate: f64,
    /// Times, ISO 8601, only of the frames that may be shown.
    pub times: Vec<String>,
    /// The same times in seconds from the suggested keyframe.
    pub t_s: Vec<f64>,
    /// Frame number in the clip of each time; negative before the clip.
    pub clip_frames: Vec<i64>,
    /// Index into `times` of the suggested keyframe.
    pub keyframe_index: usize,
    /// The ego; null when the log has no pose.
    pub ego: Option<EgoView>,
    /// Everything else, by id.
    pub tracks: Vec<TrackView>,
    /// States of traffic lights from their index on; ordered by lane, then index.
    pub lights: Vec<LightView>,
    /// Meta actions.
    pub meta: MetaView,
    /// Camera frames.
    pub cameras: Vec<CameraView>,
    /// Signals of the rule and of the plots by name, of the ego or of the rule's target: numbers, truth values or
    /// category names. In a column of numbers, `none` means known to be absent (no lead, no conflict: infinite).
    pub signals: BTreeMap<String, Vec<Value>>,
    /// Standard deviations of numbers, where they were estimated: of `signals`, and of the ego's speed, acceleration
    /// and yaw rate as `ego.forward_speed`, `ego.accel` and `ego.yaw_rate`.
    #[serde(default)]
    pub deviations: BTreeMap<String, Numbers>,
    /// Where a rate of change is uncertain, because it was computed without what precedes or follows: intervals of the
    /// first index into `times` and one past the last. By the same names. In Stage I the drive ends at the keyframe.
    #[serde(default)]
    pub uncertain: BTreeMap<String, Vec<[usize; 2]>>,
    /// Description of each of `signals`.
    pub about: BTreeMap<String, SignalAbout>,
    /// `stage2` while the future is withheld.
    pub hidden_until: Option<String>,
}

/// Description of a signal: how to read its column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SignalAbout {
    /// Type of its values.
    pub kind: SignalKind,
    /// Unit of its numbers, a base unit (`m`, `m/s2`, `rad`); null for pure numbers, truth values and categories.
    pub unit: Option<String>,
    /// Its title.
    pub title: Bilingual,
    /// Its meaning.
    pub meaning: Bilingual,
}

/// Type of a signal's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SignalKind {
    /// Numbers.
    Number,
    /// True or false.
    Flag,
    /// Category names.
    Category,
}

/// The ego, one value per time in each column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EgoView {
    /// Box length and width, m.
    pub size: [f64; 2],
    /// m.
    pub x: Numbers,
    /// m.
    pub y: Numbers,
    /// rad.
    pub heading: Numbers,
    /// m/s, negative backwards.
    pub speed: Numbers,
    /// m/s2 along the heading.
    pub accel: Numbers,
    /// rad/s.
    pub yaw_rate: Numbers,
    /// Steering wheel, rad, left positive.
    pub steering: Numbers,
    /// `off`, `left`, `right`, `hazard`.
    pub turn_signal: Vec<Option<String>>,
}

/// One object; columns start at `first`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrackView {
    /// Track id.
    pub id: String,
    /// Class.
    pub class: String,
    /// m, as last seen.
    pub length: Option<f64>,
    /// m, as last seen.
    pub width: Option<f64>,
    /// Index into `times` of the first value.
    pub first: usize,
    /// m.
    pub x: Numbers,
    /// m.
    pub y: Numbers,
    /// rad.
    pub heading: Numbers,
    /// m/s over ground.
    pub speed: Numbers,
    /// Share of it that is visible to the ego, 0 to 1.
    pub visible: Numbers,
}

/// A light from a moment on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LightView {
    /// Lane that it controls.
    pub lane_id: String,
    /// Lane after it, where movements are distinguished.
    pub to_lane_id: Option<String>,
    /// Index into `times` from which on it has this state; 0 for a state that began before.
    pub t_index: usize,
    /// `red`, `yellow`, `green`, ...
    pub colour: String,
}

/// Meta actions, one per time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MetaView {
    /// Longitudinal.
    pub longitudinal: Vec<Option<String>>,
    /// Lateral.
    pub lateral: Vec<Option<String>>,
}

/// One camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CameraView {
    /// Name.
    pub camera: String,
    /// Frames, in time order.
    pub frames: Vec<CameraFrame>,
}

/// One image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CameraFrame {
    /// Number for `/media/{camera}/{index}`, from 0 at the first image shown.
    pub index: usize,
    /// Index into `times` of the last moment not after it; 0 before the first.
    pub t_index: usize,
    /// Seconds from the suggested keyframe.
    pub t_s: f64,
    /// Its address.
    pub url: String,
}

/// The map around the keyframe (in Stage I) or around the shown drive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MapView {
    /// Lanes, by id.
    pub lanes: Vec<LaneView>,
    /// Pedestrian crossings, as polygons.
    pub crosswalks: Vec<Shape>,
    /// Stop lines.
    pub stop_lines: Vec<Shape>,
    /// Junction areas.
    pub junctions: Vec<Shape>,
    /// Where vehicles may drive.
    pub drivable: Vec<Shape>,
    /// Buildings, tunnels and the like, with their kind.
    pub facilities: Vec<Shape>,
    /// Signs, one point each, with their kind.
    pub signs: Vec<Shape>,
}

/// One lane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LaneView {
    /// Id.
    pub id: String,
    /// Left edge, [x, y] in m.
    pub left: Vec<[f64; 2]>,
    /// Right edge.
    pub right: Vec<[f64; 2]>,
    /// Center line.
    pub centre: Vec<[f64; 2]>,
    /// Mark on the left edge.
    pub left_mark: String,
    /// Mark on the right edge.
    pub right_mark: String,
    /// Its users.
    pub kind: String,
    /// Inside a junction.
    pub in_junction: bool,
}

/// A line or polygon of the map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Shape {
    /// Id.
    pub id: String,
    /// Its kind, where the list has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// [x, y] in m.
    pub points: Vec<[f64; 2]>,
}

fn shift(values: &mut Numbers, by: f64) {
    for value in values.iter_mut().flatten() {
        // The same precision as before.
        *value = ((*value - by) * 1e3).round() / 1e3;
    }
}

impl SceneView {
    /// Makes positions relative to `corner`, m.
    pub fn shift(&mut self, [x, y]: [f64; 2]) {
        if let Some(ego) = &mut self.ego {
            shift(&mut ego.x, x);
            shift(&mut ego.y, y);
        }
        for track in &mut self.tracks {
            shift(&mut track.x, x);
            shift(&mut track.y, y);
        }
    }
}

impl MapView {
    /// Makes positions relative to `corner`, m.
    pub fn shift(&mut self, [x, y]: [f64; 2]) {
        let moved = |points: &mut Vec<[f64; 2]>| {
            for p in points {
                *p = [((p[0] - x) * 1e3).round() / 1e3, ((p[1] - y) * 1e3).round() / 1e3];
            }
        };
        for lane in &mut self.lanes {
            moved(&mut lane.left);
            moved(&mut lane.right);
            moved(&mut lane.centre);
        }
        let areas = [
            &mut self.crosswalks,
            &mut self.stop_lines,
            &mut self.junctions,
            &mut self.drivable,
            &mut self.facilities,
            &mut self.signs,
        ];
        for shape in areas.into_iter().flatten() {
            moved(&mut shape.points);
        }
    }
}
