//! Closed lists of words that maps and context states are made of. Adapters map their sources' words to these; signals
//! read no others. Their use is described in `docs/reference/lake.md`.

/// Tags of a lane ([`crate::road_map::Lane::tags`]).
pub const LANE_TAGS: &[&str] =
    &["ramp", "acceleration", "deceleration", "tidal", "variable", "waiting_area", "unpaved"];

/// Bus lanes among what a map is declared to have in full ([`crate::RoadMap::complete_for`]).
pub const BUS_LANES: &str = "bus_lane";

/// Kinds of facilities ([`crate::road_map::Facility::kind`]).
pub const FACILITY_KINDS: &[&str] = &[
    "speed_bump",
    "toll_etc",
    "toll_manual",
    "toll_plaza",
    "gate",
    "tunnel",
    "roundabout",
    "construction",
    "building",
    "barrier_gap",
    "waiting_area",
    "accident",
    "bridge",
    "parking",
    "driveway",
    "traffic_light",
];

/// Kinds of signs ([`crate::road_map::Sign::kind`]).
pub const SIGN_KINDS: &[&str] = &[
    "stop",
    "yield",
    "speed_limit",
    "lane_arrow",
    "prohibition",
    "no_entry",
    "no_straight",
    "no_left_turn",
    "no_right_turn",
    "no_u_turn",
    "no_overtaking",
    "no_parking",
    "no_trucks",
    "height_limit",
    "width_limit",
    "weight_limit",
    "warning",
    "warning_pedestrians",
    "warning_children",
    "warning_bend",
    "warning_slope",
    "warning_slippery",
    "warning_narrow",
    "warning_works",
    "warning_junction",
    "warning_bump",
    "warning_animals",
    "warning_lights",
    "priority",
    "priority_road",
];

/// Kinds of prohibitions that require a moving car to slow or to take another route: all but those about parking,
/// overtaking and vehicles of other kinds. `prohibition` itself is one without further details.
pub const PROHIBITIONS: &[&str] = &[
    "prohibition",
    "no_entry",
    "no_straight",
    "no_left_turn",
    "no_right_turn",
    "no_u_turn",
    "height_limit",
    "width_limit",
];

/// Kinds of warnings. `warning` itself is one without further details.
pub const WARNINGS: &[&str] = &[
    "warning",
    "warning_pedestrians",
    "warning_children",
    "warning_bend",
    "warning_slope",
    "warning_slippery",
    "warning_narrow",
    "warning_works",
    "warning_junction",
    "warning_bump",
    "warning_animals",
    "warning_lights",
];

/// Value of an unknown context state; it ends the previous state.
pub const UNKNOWN: &str = "unknown";

/// Type of the value of a context state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContextValues {
    /// One of these words.
    Words(&'static [&'static str]),
    /// A number as text, in the unit named here.
    Number(&'static str),
}

/// Kinds of context states ([`crate::scene::ContextState`]) and their values.
pub const CONTEXT_KINDS: &[(&str, ContextValues)] = &[
    ("weather", ContextValues::Words(&["clear", "rain", "snow", "fog"])),
    ("visibility", ContextValues::Number("m")),
    ("surface", ContextValues::Words(&["dry", "wet", "puddle", "snow", "ice", "rough"])),
    ("lighting", ContextValues::Words(&["day", "dusk", "night", "tunnel", "glare"])),
    ("road_type", ContextValues::Words(&["urban", "motorway", "rural", "mountain"])),
    ("pavement", ContextValues::Words(&["paved", "unpaved"])),
    ("lane_marks", ContextValues::Words(&["normal", "missing", "faded", "wrong"])),
    ("construction", ContextValues::Words(&["none", "ahead", "here"])),
    ("accident", ContextValues::Words(&["none", "ahead", "here"])),
    ("gate", ContextValues::Words(&["closed", "opening", "open"])),
    ("nav_speed_limit", ContextValues::Number("m/s")),
    ("route_distance", ContextValues::Number("m")),
    ("warning_light", ContextValues::Words(&["none", "flashing_yellow"])),
];

/// What the value of a context state of `kind` must be; `None` for a kind that is not in the list.
pub fn context_values(kind: &str) -> Option<ContextValues> {
    CONTEXT_KINDS.iter().find(|(k, _)| *k == kind).map(|(_, values)| *values)
}
