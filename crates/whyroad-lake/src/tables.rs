//! The scene tables, one file each: columns to disk and back. `docs/reference/lake.md` documents every column.

pub(crate) mod clips;
pub(crate) mod ego;
pub(crate) mod frames;
pub(crate) mod road_map;
pub(crate) mod states;
pub(crate) mod tracks;

/// The scene tables and the order of their rows.
pub(crate) const SCENE: [(&str, &str); 8] = [
    ("clips", clips::ROW_ORDER),
    ("frames", frames::ROW_ORDER),
    ("tracks", tracks::ROW_ORDER),
    ("ego", ego::ROW_ORDER),
    ("map", road_map::ROW_ORDER),
    ("lights", states::LIGHTS_ORDER),
    ("context", states::CONTEXT_ORDER),
    ("media", states::MEDIA_ORDER),
];
