//! `drive.json`: what a drive states about itself that is not a table. Also the lake's own `whyroad-lake.json`.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use whyroad_model::scene::DriveMeta;

/// `whyroad-lake.json`.
#[derive(Serialize, Deserialize)]
pub(crate) struct LakeMarker {
    pub format: String,
    pub version: u32,
}

/// `drive.json`.
#[derive(Serialize, Deserialize)]
pub(crate) struct DriveManifest {
    pub lake_version: u32,
    pub meta: DriveMeta,
    pub frames: usize,
    /// Rows of each table; a table that is not named here is one that the log has not.
    pub tables: BTreeMap<String, usize>,
}
