//! The meaning of each topic: from the user's mapping file (`--mapping FILE`), else from message types with a fixed
//! meaning. The mapping file is documented in `docs/reference/formats.md`.

use crate::mapping_file::{self, class, number, one_of};
use std::collections::BTreeMap;
use whyroad_model::yaml::{Fields, FileReport, FormCodes, Node};
use whyroad_model::{Diagnostic, ObjectClass};

/// Everything that is wrong with a mapping file has one code.
static FORM: FormCodes = FormCodes {
    syntax: "mcap.mapping",
    missing: "mcap.mapping",
    unknown: "mcap.mapping",
    kind: "mcap.mapping",
    duplicate: "mcap.mapping",
    empty: "mcap.mapping",
};

/// The mapping file.
#[derive(Clone, Debug, Default)]
pub(super) struct Mapping {
    pub ego: EgoBox,
    pub topics: BTreeMap<String, Rule>,
    /// The log's class names and ours.
    pub classes: BTreeMap<String, ObjectClass>,
}

/// The recording vehicle, which no message describes.
#[derive(Clone, Debug, Default)]
pub(super) struct EgoBox {
    pub length_m: Option<f64>,
    pub width_m: Option<f64>,
    pub height_m: Option<f64>,
    /// From the point that the pose is of, forward to the middle of the car.
    pub reference_to_centre_m: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Role {
    #[default]
    Ignore,
    /// Poses of the recording vehicle.
    Ego,
    /// Lists of tracked objects.
    Objects,
    /// Signals of the vehicle bus.
    Bus,
}

impl Role {
    const IDS: &[&str] = &["ignore", "ego", "objects", "bus"];

    fn from_id(id: &str) -> Option<Self> {
        Some(match id {
            "ignore" => Role::Ignore,
            "ego" => Role::Ego,
            "objects" => Role::Objects,
            "bus" => Role::Bus,
            _ => return None,
        })
    }
}

/// What positions are relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Frame {
    World,
    Ego,
}

impl Frame {
    const IDS: &[&str] = &["world", "ego"];

    fn from_id(id: &str) -> Option<Self> {
        match id {
            "world" => Some(Frame::World),
            "ego" => Some(Frame::Ego),
            _ => None,
        }
    }
}

/// How a topic is read: paths into the message, parts separated by dots, numbers for places in a list.
#[derive(Clone, Debug, Default)]
pub(super) struct Rule {
    pub role: Role,
    /// Of a message type whose meaning is fixed, not of the mapping file.
    pub is_standard: bool,
    /// Used where the messages do not state it by a frame id.
    pub frame: Option<Frame>,
    pub frame_id: Option<String>,
    pub time: Option<String>,
    /// The list of objects; the paths below start at its elements.
    pub list: Option<String>,
    pub id: Option<String>,
    pub class: Option<String>,
    pub position: Option<String>,
    /// A quaternion x, y, z, w.
    pub orientation: Option<String>,
    /// rad, instead of a quaternion.
    pub heading: Option<String>,
    pub size: Option<String>,
    /// Over ground. Objects: in the axes of the frame of their position. Ego: in the axes of the car.
    pub velocity: Option<String>,
    pub speed_mps: Option<String>,
    /// rad, left positive.
    pub steering: Option<String>,
    pub brake: Option<String>,
    /// Moving: true, or a stage over 0.
    pub wipers: Option<String>,
    /// Without gravity, up positive.
    pub vertical_accel_mps2: Option<String>,
    /// 0..1
    pub throttle: Option<String>,
    /// `P`, `R`, `N`, `D`
    pub gear: Option<String>,
    /// `off`, `left`, `right`, `hazard`
    pub turn_signal: Option<String>,
}

impl Mapping {
    /// Reads the text of a mapping file; with an error there is no mapping.
    pub fn read(file: &str, text: &str) -> (Option<Self>, Vec<Diagnostic>) {
        mapping_file::read((file, text), &FORM, mapping)
    }
}

fn mapping(root: &Node, report: &mut FileReport) -> Option<Mapping> {
    let mut out = Mapping::default();
    let mut fields = Fields::open(root, report)?;
    if let Some(node) = fields.get("ego") {
        out.ego = ego_box(node, report)?;
    }
    if let Some(node) = fields.get("topics") {
        for entry in report.entries(node)? {
            if let Some(rule) = rule(&entry.node, report) {
                out.topics.insert(entry.key.clone(), rule);
            }
        }
    }
    if let Some(node) = fields.get("classes") {
        for entry in report.entries(node)? {
            if let Some(class) = class(&entry.node, report) {
                out.classes.insert(entry.key.clone(), class);
            }
        }
    }
    fields.close(report);
    Some(out)
}

fn ego_box(node: &Node, report: &mut FileReport) -> Option<EgoBox> {
    let mut fields = Fields::open(node, report)?;
    let mut meters = |key| fields.get(key).and_then(|n| number(n, report));
    let ego = EgoBox {
        length_m: meters("length_m"),
        width_m: meters("width_m"),
        height_m: meters("height_m"),
        reference_to_centre_m: meters("reference_to_centre_m").unwrap_or(0.0),
    };
    fields.close(report);
    Some(ego)
}

fn rule(node: &Node, report: &mut FileReport) -> Option<Rule> {
    let mut fields = Fields::open(node, report)?;
    let role = fields.get("role").and_then(|n| one_of(n, report, Role::from_id, Role::IDS));
    let frame = fields.get("frame").and_then(|n| one_of(n, report, Frame::from_id, Frame::IDS));
    let mut path = |key| fields.text_opt(key, report);
    let rule = Rule {
        role: role.unwrap_or_default(),
        is_standard: false,
        frame,
        frame_id: path("frame_id"),
        time: path("time"),
        list: path("list"),
        id: path("id"),
        class: path("class"),
        position: path("position"),
        orientation: path("orientation"),
        heading: path("heading"),
        size: path("size"),
        velocity: path("velocity"),
        speed_mps: path("speed_mps"),
        steering: path("steering"),
        brake: path("brake"),
        wipers: path("wipers"),
        vertical_accel_mps2: path("vertical_accel_mps2"),
        throttle: path("throttle"),
        gear: path("gear"),
        turn_signal: path("turn_signal"),
    };
    fields.close(report);
    Some(rule)
}

/// The rule of a message type whose meaning is fixed; `None` for all others.
pub(super) fn standard(schema: &str) -> Option<Rule> {
    let path = |p: &str| Some(p.to_owned());
    let of = |frame_id: &str, time: &str| Rule {
        is_standard: true,
        frame_id: path(frame_id),
        time: path(time),
        ..Rule::default()
    };
    let (stamped, foxglove) = (of("header.frame_id", "header.stamp"), of("frame_id", "timestamp"));
    Some(match schema.replace("/msg/", "/").as_str() {
        "nav_msgs/Odometry" => Rule {
            role: Role::Ego,
            position: path("pose.pose.position"),
            orientation: path("pose.pose.orientation"),
            velocity: path("twist.twist.linear"),
            ..stamped
        },
        "geometry_msgs/PoseStamped" => Rule {
            role: Role::Ego,
            position: path("pose.position"),
            orientation: path("pose.orientation"),
            ..stamped
        },
        "foxglove.PoseInFrame" => Rule {
            role: Role::Ego,
            position: path("pose.position"),
            orientation: path("pose.orientation"),
            ..foxglove
        },
        "foxglove.SceneUpdate" => Rule {
            role: Role::Objects,
            list: path("entities"),
            id: path("id"),
            position: path("cubes.0.pose.position"),
            orientation: path("cubes.0.pose.orientation"),
            size: path("cubes.0.size"),
            class: path("metadata.class"),
            ..foxglove
        },
        "vision_msgs/Detection3DArray" => Rule {
            role: Role::Objects,
            list: path("detections"),
            id: path("id"),
            position: path("bbox.center.position"),
            orientation: path("bbox.center.orientation"),
            size: path("bbox.size"),
            class: path("results.0.hypothesis.class_id"),
            ..stamped
        },
        _ => return None,
    })
}
