//! A reader of a single file of outside bytes, and what readers of maps have in common. [`crate::readers`] lists them.

use crate::assemble::finish::finish;
use whyroad_model::scene::{Ego, Motion};
use whyroad_model::{Drive, Nanos, RoadMap};

/// A reader; what it makes of the bytes is dropped, and whether it took them for a file of its kind.
#[derive(Clone, Copy)]
pub struct FileReader {
    /// Format or encoding, and what of it.
    pub name: &'static str,
    /// Reads a file; true when it can be one.
    pub read: fn(&[u8]) -> bool,
}

/// A drive of two frames at the origin, on this map.
pub(crate) fn drive_on(map: Option<RoadMap>) -> Drive {
    let motion = Motion { x: vec![0.0, 1.0], y: vec![0.0; 2], heading: vec![0.0; 2], ..Motion::unknown(2) };
    Drive {
        times: vec![Nanos(0), Nanos(100_000_000)],
        ego: Some(Ego { length_m: 4.5, width_m: 1.8, motion, ..Ego::default() }),
        map,
        ..Drive::default()
    }
}

/// What is common to all formats, for a map; false without lanes.
pub(crate) fn finish_map(map: RoadMap) -> bool {
    let has_lanes = !map.lanes.is_empty();
    drop(finish(&mut drive_on(Some(map))));
    has_lanes
}
