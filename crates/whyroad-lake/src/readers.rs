//! Every reader of a single file of a lake, by name, on bytes in memory: what the fuzz targets run. They are the
//! functions that read a lake.

use crate::LakeError;
use crate::columns::Table;
use crate::file::read_table_bytes;
use crate::manifest::DriveManifest;
use crate::signals::read_bytes;
use crate::tables::{clips, ego, frames, road_map, states, tracks};

/// A reader; its result is dropped.
#[derive(Clone, Copy)]
pub struct LakeReader {
    /// Name of the file without its ending, after that of its folder.
    pub name: &'static str,
    /// Reads a file; true when it can be one.
    pub read: fn(&[u8]) -> bool,
}

/// All of them.
pub const ALL: &[LakeReader] = &[
    LakeReader {
        name: "drive-manifest",
        read: |bytes| serde_json::from_slice::<DriveManifest>(bytes).is_ok(),
    },
    LakeReader { name: "drive-frames", read: |b| table(b, frames::ROW_ORDER, |t| frames::from_table(&t)) },
    LakeReader { name: "drive-ego", read: |b| table(b, ego::ROW_ORDER, |t| ego::from_table(&t, t.rows())) },
    LakeReader { name: "drive-tracks", read: |b| table(b, tracks::ROW_ORDER, |t| tracks::from_table(&t, 3)) },
    LakeReader { name: "drive-map", read: |b| table(b, road_map::ROW_ORDER, |t| road_map::from_table(&t)) },
    LakeReader {
        name: "drive-lights",
        read: |b| table(b, states::LIGHTS_ORDER, |t| states::lights_from_table(&t)),
    },
    LakeReader {
        name: "drive-context",
        read: |b| table(b, states::CONTEXT_ORDER, |t| states::context_from_table(&t)),
    },
    LakeReader {
        name: "drive-media",
        read: |b| table(b, states::MEDIA_ORDER, |t| states::media_from_table(&t)),
    },
    LakeReader { name: "drive-clips", read: |b| table(b, clips::ROW_ORDER, |t| clips::summaries(&t)) },
    LakeReader { name: "signals", read: |bytes| read_bytes(bytes).is_ok_and(|columns| columns > 0) },
];

fn table<T>(bytes: &[u8], order: &str, read: impl FnOnce(Table) -> Result<T, LakeError>) -> bool {
    read_table_bytes(bytes, order).and_then(read).is_ok()
}
