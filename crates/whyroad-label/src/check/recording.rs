//! The recorded drive behind a label, for the checks that compare the two. Handed in by whoever has it: this crate
//! reads no lake and derives no signal.

use std::fmt;
use std::sync::Arc;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Drive, SignalTable};

/// A drive with what is derived from it.
#[derive(Clone, Debug, Default)]
pub struct Recorded {
    /// The whole drive.
    pub drive: Arc<Drive>,
    /// Its signals.
    pub signals: Arc<SignalTable>,
    /// What the mining rules found in it; empty where nobody asked them.
    pub episodes: Vec<EpisodeRecord>,
}

/// Drives by the clips that labels name.
pub trait Recordings: Send + Sync {
    /// The drive of a clip; `None` where it is not at hand.
    fn of_clip(&self, clip_id: &str) -> Option<Arc<Recorded>>;
}

impl fmt::Debug for dyn Recordings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("recordings")
    }
}
