//! The scene tables, one file each: columns to disk and back. `docs/reference/lake.md` documents every column.

pub(crate) mod clips;
pub(crate) mod ego;
pub(crate) mod frames;
pub(crate) mod road_map;
pub(crate) mod states;
pub(crate) mod tracks;
