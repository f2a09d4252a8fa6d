//! The recorded drive of a label, for the checks that compare the two. The caller provides it: this crate reads no lake
//! and derives no signals.

use std::fmt;
use std::sync::Arc;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Drive, SignalTable};

/// A drive with the data derived from it.
#[derive(Clone, Debug, Default)]
pub struct Recorded {
    /// The whole drive.
    pub drive: Arc<Drive>,
    /// Its signals.
    pub signals: Arc<SignalTable>,
    /// Episodes that the mining rules found in it; empty where they were not run.
    pub episodes: Vec<EpisodeRecord>,
}

/// Finds drives by the clips that labels name.
pub trait Recordings: Send + Sync {
    /// The drive of a clip; `None` where it is not available.
    fn of_clip(&self, clip_id: &str) -> Option<Arc<Recorded>>;
}

impl fmt::Debug for dyn Recordings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("recordings")
    }
}
