//! The map that the options name, kept with them once it has been read, so that it is read once for all drives.

use crate::report::RowCount;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use whyroad_model::{Diagnostic, RoadMap};

/// A map that was read.
#[derive(Debug)]
pub(crate) struct MapBeside {
    pub map: RoadMap,
    pub name: String,
    /// The file, as the user named it.
    pub label: String,
    pub hash: String,
    pub tables: Vec<RowCount>,
}

/// Result of reading the file.
#[derive(Debug, Default)]
pub(crate) struct Loaded {
    pub map: Option<MapBeside>,
    pub diagnostics: Vec<Diagnostic>,
    reported: AtomicBool,
}

/// The map; empty until it is first requested.
#[derive(Clone, Debug, Default)]
pub(crate) struct MapCache(Arc<OnceLock<Loaded>>);

impl MapCache {
    /// The map, read by `load` on the first request, and the diagnostics, on the first request only.
    pub fn get(&self, load: impl FnOnce() -> Loaded) -> (Option<&MapBeside>, Vec<Diagnostic>) {
        let loaded = self.0.get_or_init(load);
        let news = !loaded.reported.swap(true, Ordering::Relaxed);
        (loaded.map.as_ref(), if news { loaded.diagnostics.clone() } else { Vec::new() })
    }
}
