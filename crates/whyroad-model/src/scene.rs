//! Scene tables in memory: one drive in the common form of all formats. Positions are in a right-handed
//! metric world frame (x east-ish, y left of x, z up), headings in radians counter-clockwise from x in
//! (-pi, pi]. **Every pose, the ego's included, is the center of the object's box.** NaN in a number
//! means that the log does not state it.
//!
//! **Only what was measured.** A log without velocities has none here: they are estimated (`whyroad_signals::estimate`)
//! from the part of the drive that is left after [`Drive::until`] has cut it.

mod cut;
mod driving_side;

pub use driving_side::DrivingSide;

use crate::{DriveId, FrameRange, Nanos, Need, ObjectClass, RoadMap, TrackId};
use serde::{Deserialize, Serialize};

/// Frames in a clip: 20 s at 10 Hz (LABELING.md 4).
pub const CLIP_FRAMES: usize = 200;
/// Nominal frames per second of all scene tables.
pub const FRAME_RATE_HZ: f64 = 10.0;

/// One recorded drive.
#[derive(Clone, Debug, Default)]
pub struct Drive {
    /// What is known about the drive as a whole.
    pub meta: DriveMeta,
    /// Frame times, strictly ascending, nominally 10 Hz. All tables index into this by frame.
    pub times: Vec<Nanos>,
    /// The recording vehicle. `None` when the log has no pose for it.
    pub ego: Option<Ego>,
    /// Everything else that was tracked, ordered by id. Never contains the ego.
    pub tracks: Vec<Track>,
    /// The road, when the log has a map.
    pub map: Option<RoadMap>,
    /// Traffic light states, ordered by lane, then time. `None` when the log has none.
    pub lights: Option<Vec<LightState>>,
    /// Weather, surface and the like. `None` when the log has none.
    pub context: Option<Vec<ContextState>>,
    /// Camera frames, ordered by camera, then time. `None` when the log has none.
    pub media: Option<Vec<MediaFrame>>,
}

/// What is known about a drive as a whole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DriveMeta {
    /// Id, unique in the lake and safe as a folder name.
    pub drive_id: DriveId,
    /// Input format: `av2`, `sumo`, ...
    pub format: String,
    /// The vehicle or fleet that recorded it (DATA_FORMAT.md 3.1 `source`).
    pub source: String,
    /// City or road network.
    pub place: Option<String>,
    /// Identity of the map, when there is one.
    pub map_ref: Option<String>,
    /// License of the data, as an SPDX id where there is one.
    pub licence: Option<String>,
    /// Recording session: drives of one session are never split between training and test. `None` is unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub session: Option<String>,
    /// The single vehicle that recorded it, where `source` names a fleet. `None` is unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vehicle: Option<String>,
    /// Where on Earth the origin of the world frame lies, x to the east and y to the north. `None` is unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<GeoPosition>,
    /// Frame of reference of the poses.
    pub frame_of_reference: FrameOfReference,
    /// Hash of the input's content; equal input gives an equal hash.
    pub content_hash: String,
    /// Cameras and other sensors named by the log.
    pub video: Vec<String>,
    /// Non-camera sensors named by the log.
    pub sensors: Vec<String>,
    /// Whether vehicle bus signals were recorded.
    pub can: bool,
    /// What the log lacks.
    pub missing: Vec<Need>,
    /// First and last frame of each stretch in which nothing observed the objects: there they are unknown, not absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub objects_unknown: Vec<[Nanos; 2]>,
}

impl DriveMeta {
    /// The log states date and time of day: times are not counted from an invented start.
    pub fn is_dated(&self) -> bool {
        !self.missing.contains(&Need::Date)
    }

    /// True when nothing observed the objects in the frame at `time`.
    pub fn are_objects_unknown(&self, time: Nanos) -> bool {
        self.objects_unknown.iter().any(|[first, last]| (*first..=*last).contains(&time))
    }

    /// Notes that the log lacks something.
    pub fn lacks(&mut self, need: Need) {
        if !self.missing.contains(&need) {
            self.missing.push(need);
        }
    }
}

/// A position on Earth, WGS 84.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GeoPosition {
    /// Degrees, north positive, -90 to 90.
    pub latitude_deg: f64,
    /// Degrees, east positive, -180 to 180.
    pub longitude_deg: f64,
}

/// What positions in a drive refer to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrameOfReference {
    /// Fixed to the ground.
    #[default]
    World,
    /// The ego vehicle at each frame: the log has no ego pose. Positions relative to the ego are known
    /// (ego reference point of the source), velocities over ground are not.
    Ego,
}

/// The recording vehicle, one value per frame (`Drive::times`) in each vector.
#[derive(Clone, Debug, Default)]
pub struct Ego {
    /// Box length, m.
    pub length_m: f64,
    /// Box width, m.
    pub width_m: f64,
    /// Box height, m.
    pub height_m: f64,
    /// From the source's reference point (rear axle, front bumper, ...) forward to the box center, m; already applied
    /// to the poses.
    pub reference_to_centre_m: f64,
    /// Motion of the box center.
    pub motion: Motion,
    /// Vehicle bus signals; empty vectors where the log has none.
    pub bus: EgoBus,
    /// Time of the latest measurement on which each row is based, where that is later than the frame (a pose between
    /// two samples rests on both); empty when no row rests on a later one.
    pub known_at: Vec<Nanos>,
}

/// Motion of a box center in the world frame; all vectors have one length (`forward` may be empty), NaN is unknown.
/// Velocities, acceleration and yaw rate are known only where the log states them.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// m.
    pub x: Vec<f64>,
    /// m.
    pub y: Vec<f64>,
    /// m.
    pub z: Vec<f64>,
    /// rad, (-pi, pi].
    pub heading: Vec<f64>,
    /// m/s along world x.
    pub vx: Vec<f64>,
    /// m/s along world y.
    pub vy: Vec<f64>,
    /// m/s2 along the heading; negative is braking while driving forward.
    pub accel: Vec<f64>,
    /// rad/s, counter-clockwise.
    pub yaw_rate: Vec<f64>,
    /// m/s along the heading, negative backwards, where the log states a speed and no velocity vector; empty when no
    /// row has one.
    pub forward: Vec<f64>,
}

impl Motion {
    /// `n` rows, all unknown.
    pub fn unknown(n: usize) -> Self {
        let v = || vec![f64::NAN; n];
        let forward = Vec::new();
        Self { x: v(), y: v(), z: v(), heading: v(), vx: v(), vy: v(), accel: v(), yaw_rate: v(), forward }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// True when there are no rows.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Speed over ground in m/s, never negative; NaN when unknown.
    pub fn speed(&self, row: usize) -> f64 {
        self.vx[row].hypot(self.vy[row])
    }

    /// Velocity along the heading in m/s: negative when driving backwards.
    pub fn forward_speed(&self, row: usize) -> f64 {
        let (s, c) = self.heading[row].sin_cos();
        self.vx[row] * c + self.vy[row] * s
    }
}

/// Vehicle bus signals, one value per frame; an empty vector means that the log has none, NaN or `None` that this
/// frame has none.
#[derive(Clone, Debug, Default)]
pub struct EgoBus {
    /// Speed as the car itself measures it, m/s: independent of the pose, often a few percent high or low.
    pub speed_mps: Vec<f64>,
    /// Steering wheel angle, rad, left positive.
    pub steering: Vec<f64>,
    /// Brake pedal or brake light.
    pub brake: Vec<Option<bool>>,
    /// Throttle 0..1.
    pub throttle: Vec<f64>,
    /// `P`, `R`, `N`, `D`.
    pub gear: Vec<Option<char>>,
    /// Indicator.
    pub turn_signal: Vec<Option<TurnSignal>>,
    /// Automatic emergency braking active.
    pub aeb: Vec<Option<bool>>,
    /// Windscreen wipers moving, at any speed.
    pub wipers: Vec<Option<bool>>,
    /// Vertical acceleration of the body without gravity, m/s2, up positive: the sample of greatest magnitude in a
    /// frame, since a bump is shorter than a frame.
    pub vertical_accel: Vec<f64>,
    /// Cruise control active.
    pub cruise: Vec<Option<bool>>,
    /// Next routing command from the source's words, reduced to `left`, `right`, `straight`, `uturn`, `exit`; `none`
    /// where there is no command now.
    pub route_command: Vec<Option<String>>,
}

/// State of the indicators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TurnSignal {
    /// Both off.
    Off,
    /// Left on.
    Left,
    /// Right on.
    Right,
    /// Both on.
    Hazard,
}

/// One tracked object: rows only for the frames in which it was observed.
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// Id within the drive.
    pub id: TrackId,
    /// Class on our scale by all rows that are here: the one that most rows state, where some state one.
    pub class: ObjectClass,
    /// Class in the source's words.
    pub source_class: String,
    /// Class by time, where it changes: what is stated from each of these rows on, the first entry from row 0. Empty
    /// when every row has `class`.
    pub class_changes: Vec<ClassChange>,
    /// Frame of each row, strictly ascending; may have gaps.
    pub frames: Vec<u32>,
    /// Motion of the box center, one row per frame in `frames`.
    pub motion: Motion,
    /// Box length in m, one value per row; NaN where the log has no sizes.
    pub length_m: Vec<f64>,
    /// Box width in m, one value per row.
    pub width_m: Vec<f64>,
    /// Box height in m, one value per row.
    pub height_m: Vec<f64>,
    /// Lidar points in the box or another count of visibility, NaN where unknown.
    pub interior_points: Vec<f64>,
    /// Indicators, where the source states it (simulators do); empty when it does not.
    pub turn_signal: Vec<Option<TurnSignal>>,
    /// Share of the object that the ego's sensors could see, 0 to 1, one value per row, where the source's own sensor
    /// model states it; empty when it does not.
    pub visible_share: Vec<f64>,
    /// What hid most of the rest by that model; empty if it has none. May name a track that was itself never
    /// seen and so is not in the drive.
    pub occluder: Vec<Option<TrackId>>,
    /// As [`Ego::known_at`], one value per row.
    pub known_at: Vec<Nanos>,
}

/// A class that the source states from a row on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ClassChange {
    /// First row for which it is stated.
    pub row: u32,
    /// Class on our scale.
    pub class: ObjectClass,
    /// Class in the source's words.
    pub source_class: String,
}

impl Track {
    /// First frame and one past the last.
    pub fn span(&self) -> FrameRange {
        match (self.frames.first(), self.frames.last()) {
            (Some(&a), Some(&b)) => FrameRange::new(a as usize, b as usize + 1),
            _ => FrameRange::default(),
        }
    }

    /// Sets the class that the source states for each row. The track's own class is the one that most rows state, the
    /// earlier one of two that are equally frequent; unknown only when no row states one.
    pub fn state_classes<'a>(&mut self, stated: impl IntoIterator<Item = (ObjectClass, &'a str)>) {
        let mut changes: Vec<ClassChange> = Vec::new();
        // Rows by class, in the order in which the classes appear.
        let mut counts: Vec<((ObjectClass, &'a str), usize)> = Vec::new();
        for (row, stated) in stated.into_iter().enumerate() {
            if changes.last().is_none_or(|c| (c.class, c.source_class.as_str()) != stated) {
                let (class, source_class) = (stated.0, stated.1.to_owned());
                changes.push(ClassChange { row: row as u32, class, source_class });
            }
            match counts.iter_mut().find(|(of, _)| *of == stated) {
                Some((_, rows)) => *rows += 1,
                None => counts.push((stated, 1)),
            }
        }
        // Backwards, because `max_by_key` takes the last of several that are equal.
        let most =
            counts.into_iter().rev().max_by_key(|((class, _), rows)| (*class != ObjectClass::Unknown, *rows));
        if let Some(((class, source_class), _)) = most {
            (self.class, self.source_class) = (class, source_class.to_owned());
        }
        self.class_changes = if changes.len() > 1 { changes } else { Vec::new() };
    }

    /// Class and class in the source's words as stated for `row`.
    pub fn class_at(&self, row: usize) -> (ObjectClass, &str) {
        let stated = self.class_changes.iter().rev().find(|c| c.row as usize <= row);
        stated.map_or((self.class, self.source_class.as_str()), |c| (c.class, c.source_class.as_str()))
    }

    /// Row of `frame`, if the object was observed then.
    pub fn row_at(&self, frame: usize) -> Option<usize> {
        let frame = u32::try_from(frame).ok()?;
        // Mostly no frame is missing up to this one.
        let dense = frame.checked_sub(*self.frames.first()?)? as usize;
        if self.frames.get(dense) == Some(&frame) {
            return Some(dense);
        }
        self.frames.binary_search(&frame).ok()
    }
}

/// State of one signal head for one lane or one movement across a junction.
#[derive(Clone, Debug, PartialEq)]
pub struct LightState {
    /// Lane that the light controls (its id in the map).
    pub lane_id: String,
    /// Lane behind the light, if the source distinguishes movements.
    pub to_lane_id: Option<String>,
    /// When the state began or was observed.
    pub time: Nanos,
    /// The state.
    pub color: LightColor,
    /// Seconds that its countdown shows at `time`, until the next color; `None` without one.
    pub countdown_s: Option<f64>,
}

/// Color of a traffic light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LightColor {
    /// Stop.
    Red,
    /// Clear the junction.
    Yellow,
    /// Green, and no conflicting traffic has right of way.
    Green,
    /// Green that must give way to others.
    GreenYield,
    /// Round green: every movement may go, a left turn gives way to oncoming traffic (GB 14886 "full" signal).
    GreenRound,
    /// Green arrow: its movement goes, conflicting traffic is held.
    GreenArrow,
    /// Green that flashes: about to be yellow.
    FlashingGreen,
    /// Red and yellow: about to be green.
    RedYellow,
    /// Flashing yellow.
    FlashingYellow,
    /// Dark.
    Off,
    /// Seen but not readable.
    Unknown,
}

/// A stated condition of the surroundings that holds from `time` until the next state of the same `kind`.
#[derive(Clone, Debug, PartialEq)]
pub struct ContextState {
    /// When it began.
    pub time: Nanos,
    /// `weather`, `surface`, `lighting`, `construction`, ...
    pub kind: String,
    /// Value in the words of `schema/signals.yaml`.
    pub value: String,
    /// The source of the statement.
    pub source: String,
    /// How sure the source is, 0 to 1, where it states this (a perception model).
    pub confidence: Option<f64>,
}

/// One camera frame.
#[derive(Clone, Debug, PartialEq)]
pub struct MediaFrame {
    /// Camera name.
    pub camera: String,
    /// Exposure time.
    pub time: Nanos,
    /// Path of the image, relative to the lake or as the log names it.
    pub uri: String,
    /// Frame number inside a video.
    pub index: u32,
}

impl Drive {
    /// Number of frames.
    pub fn frame_count(&self) -> usize {
        self.times.len()
    }

    /// Frame ranges of the clips: [`CLIP_FRAMES`] each, the last one and those before a gap shorter.
    pub fn clips(&self) -> Vec<FrameRange> {
        crate::clip::division(&self.times)
    }

    /// The track with this id.
    pub fn track(&self, id: &TrackId) -> Option<&Track> {
        self.tracks.binary_search_by(|t| t.id.cmp(id)).ok().map(|i| &self.tracks[i])
    }
}
