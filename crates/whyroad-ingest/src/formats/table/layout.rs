//! What the layout consists of: names of its tables, of their columns, and of the keys of the drive file. What they
//! mean
//! is written in `docs/reference/table-format.md`.

/// The tables of a drive.
pub(super) const TABLES: &[&str] = &["ego", "objects", "lanes", "areas", "signs", "lights", "context"];
/// Keys of the drive file, and of `ego` in it.
pub(super) const KEYS: &[&str] =
    &["drive_id", "source", "place", "map_ref", "licence", "start_time", "ego", "map_complete_for"];
pub(super) const EGO_KEYS: &[&str] = &["length_m", "width_m", "height_m", "reference_to_centre_m"];

const EGO: &[&str] = &[
    "timestamp_ns",
    "time",
    "time_s",
    "x_m",
    "y_m",
    "z_m",
    "heading_rad",
    "heading_deg",
    "vx_mps",
    "vy_mps",
    "speed_mps",
    "accel_mps2",
    "yaw_rate_radps",
    "bus_speed_mps",
    "steering_rad",
    "throttle",
    "brake",
    "gear",
    "turn_signal",
    "aeb",
    "wipers",
    "vertical_accel_mps2",
    "cruise",
    "route_command",
];
const OBJECTS: &[&str] = &[
    "timestamp_ns",
    "time",
    "time_s",
    "track_id",
    "class",
    "x_m",
    "y_m",
    "z_m",
    "heading_rad",
    "heading_deg",
    "vx_mps",
    "vy_mps",
    "speed_mps",
    "length_m",
    "width_m",
    "height_m",
    "interior_points",
    "turn_signal",
    "visible_share",
    "occluder",
];
const LANES: &[&str] = &[
    "lane_id",
    "centre_xyz_m",
    "left_xyz_m",
    "right_xyz_m",
    "left_mark",
    "right_mark",
    "left_neighbour",
    "right_neighbour",
    "successors",
    "predecessors",
    "kind",
    "in_junction",
    "junction_id",
    "speed_limit_mps",
    "width_m",
    "turn",
    "tags",
];
const AREAS: &[&str] = &["area_id", "kind", "boundary_xyz_m", "lane_ids"];
const SIGNS: &[&str] =
    &["sign_id", "kind", "x_m", "y_m", "z_m", "lane_ids", "value", "facing_rad", "facing_deg"];
const LIGHTS: &[&str] = &["timestamp_ns", "time", "time_s", "lane_id", "to_lane_id", "colour", "countdown_s"];
const CONTEXT: &[&str] = &["timestamp_ns", "time", "time_s", "kind", "value", "source", "confidence"];

/// The columns of a table.
pub(super) fn columns_of(table: &str) -> &'static [&'static str] {
    match table {
        "ego" => EGO,
        "objects" => OBJECTS,
        "lanes" => LANES,
        "areas" => AREAS,
        "signs" => SIGNS,
        "lights" => LIGHTS,
        _ => CONTEXT,
    }
}
