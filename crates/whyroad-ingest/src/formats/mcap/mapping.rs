//! Which topic is what: from the user's mapping file (`--mapping FILE`), else from the message types that have one
//! meaning everywhere. The mapping file is documented in `docs/reference/formats.md`.

use serde::Deserialize;
use std::collections::BTreeMap;
use whyroad_model::ObjectClass;

/// The mapping file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Mapping {
    #[serde(default)]
    pub ego: EgoBox,
    #[serde(default)]
    pub topics: BTreeMap<String, Rule>,
    /// The log's class names and ours.
    #[serde(default)]
    pub classes: BTreeMap<String, ObjectClass>,
}

/// The recording vehicle, which no message describes.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EgoBox {
    pub length_m: Option<f64>,
    pub width_m: Option<f64>,
    pub height_m: Option<f64>,
    /// From the point that the pose is of, forward to the middle of the car.
    #[serde(default)]
    pub reference_to_centre_m: f64,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
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

/// What positions are relative to.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(super) enum Frame {
    World,
    Ego,
}

/// How a topic is read: paths into the message, parts separated by dots, numbers for places in a list.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Rule {
    pub role: Role,
    /// Where the messages do not say it by a frame id.
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
    /// Objects: over ground, in the axes of the world. Ego: in the axes of the car.
    pub velocity: Option<String>,
    pub speed_mps: Option<String>,
    /// rad, left positive.
    pub steering: Option<String>,
    pub brake: Option<String>,
    /// 0..1
    pub throttle: Option<String>,
    /// `P`, `R`, `N`, `D`
    pub gear: Option<String>,
    /// `off`, `left`, `right`, `hazard`
    pub turn_signal: Option<String>,
}

/// The rule of a message type whose meaning is fixed; `None` for all others.
pub(super) fn standard(schema: &str) -> Option<Rule> {
    let path = |p: &str| Some(p.to_owned());
    let stamped = Rule { frame_id: path("header.frame_id"), time: path("header.stamp"), ..Rule::default() };
    let foxglove = Rule { frame_id: path("frame_id"), time: path("timestamp"), ..Rule::default() };
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
